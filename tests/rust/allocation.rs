//! Steps and evaluations in a steady state allocate nothing. The plan counts the memory of a simulation.

use nalgebra::Point3;
use supple::{
    Body, BodyBuilder, BreakLimit, Collider, Curve, CurveKey, Display, FractureOptions, HalfWidth, Handle,
    HandleMotion, Key, Lattice, Material, Mesh, MeshAnimation, Pin, Plasticity, Preservation, Selection,
    Simulation, SkinKind, Substeps, TimeWindow, Touched, VolumeMeasure, VolumeOptions, VolumeScope, Zone,
};
use supple_tests::counting_allocator::{CountingAllocator, allocations, thread_allocations, thread_bytes};
use supple_tests::{mesh_of, unit_cube};

#[global_allocator]
static ALLOCATOR: CountingAllocator = CountingAllocator;

/// Returns a cube of `n` x `n` x `n` cells of edge 0.1.
fn block(n: i32) -> BodyBuilder {
    Body::from_lattice(
        Lattice::from_cells(&supple_tests::block([n; 3]), 0.1, Point3::origin(), false).unwrap(),
    )
    .material(Material::fast_lsm())
}

/// Returns a square sheet below the origin.
fn sheet() -> Mesh {
    let vertices = vec![[-9.0, -0.01, -9.0], [9.0, -0.01, -9.0], [9.0, -0.01, 9.0], [-9.0, -0.01, 9.0]];
    Mesh::new(vertices, &[[0, 1, 2, 3]]).unwrap()
}

/// Returns a simulation of a plastic body that can break with both kinds of damping, a pin, a moving handle and contact with the ground.
fn full_simulation(n: i32, threads: usize) -> Simulation {
    let top = Selection::Plane { point: [0.0, 0.1 * f64::from(n), 0.0], normal: [0.0, 1.0, 0.0] };
    let corner = Selection::Sphere { center: [0.0; 3], radius: 0.05 };
    let key = |time, rotate| Key { time, translate: [0.0; 3], rotate: [0.0, rotate, 0.0] };
    let body = block(n)
        .damping_ratio(0.2)
        .region_damping(0.1)
        .plastic(Plasticity { yield_strain: 1e-3, ..Plasticity::default() })
        .fracture(FractureOptions { rotation: Some(180.0), ..FractureOptions::new(BreakLimit::Strain(9.0)) })
        .pin(Pin { goal: None, selection: corner, window: TimeWindow::default() })
        .handle(Handle {
            goal: None,
            selection: top,
            motion: vec![key(0.0, 0.0), key(9.0, 90.0)].into(),
            window: TimeWindow::default(),
        })
        .build()
        .unwrap();
    let ground = Collider::plane([0.0, 0.05, 0.0], [0.0, 1.0, 0.0]);
    Simulation::builder().body(body).collider(ground).threads(threads).build().unwrap()
}

/// Returns a simulation of a body of the default material with two components, of which one is pinned at a vertex, on
/// the ground.
fn resting_simulation(sleep: bool) -> Simulation {
    let cells: Vec<_> =
        [0, 5].into_iter().flat_map(|x| (0..27).map(move |k| [x + k / 9, k / 3 % 3, k % 3])).collect();
    let lattice = Lattice::from_cells(&cells, 0.1, Point3::origin(), false).unwrap();
    let body = Body::from_lattice(lattice)
        .pin(Pin {
            goal: None,
            selection: Selection::Sphere { center: [0.0; 3], radius: 0.05 },
            window: TimeWindow::default(),
        })
        .build()
        .unwrap();
    assert_eq!(body.lattice().components().count, 2);
    let ground = Collider::plane([0.0; 3], [0.0, 1.0, 0.0]);
    Simulation::builder().body(body).collider(ground).threads(1).sleep(sleep).build().unwrap()
}

#[test]
fn steady_steps_and_evaluations_allocate_nothing_and_the_plan_counts_all_memory() {
    let mut sim = full_simulation(6, 1);
    sim.steps(300);
    assert_eq!(thread_allocations(|| sim.steps(200)), 0, "with all stages");

    let mut free = Simulation::builder().body(block(6).build().unwrap()).threads(1).build().unwrap();
    free.steps(3);
    assert_eq!(thread_allocations(|| free.steps(200)), 0, "a free body");

    let sizes = [2, 6, 4].into_iter().zip(0..);
    let bodies = sizes.map(|(n, k)| block(n).translate([2.0 * f64::from(k), 0.0, 0.0]).build().unwrap());
    let mut several =
        bodies.fold(Simulation::builder().threads(1), |world, body| world.body(body)).build().unwrap();
    assert_eq!(several.plan().window_sum_bytes, 0);
    several.steps(3);
    assert_eq!(thread_allocations(|| several.steps(200)), 0, "bodies of different sizes");
    // The bodies of a thread have the memory in common that the largest one needs.
    assert_eq!(several.plan().window_sum_bytes, free.plan().window_sum_bytes);
    several.set_threads(2).unwrap();
    several.steps(20);
    assert_eq!(several.plan().window_sum_bytes, 2 * free.plan().window_sum_bytes);

    // The animation has a sample every three steps.
    let turning = |sample: i32| {
        let (sin, cos) = (0.02 * f64::from(sample)).sin_cos();
        let turn =
            move |p: &Point3<f64>| [p.x, cos * p.y - sin * p.z, sin * p.y + cos * p.z].map(|x| x as f32);
        mesh_of(unit_cube()).vertices().iter().map(turn).collect::<Vec<_>>()
    };
    let animation = MeshAnimation::new((0..200).flat_map(turning).collect(), 8, 0.0, 0.05).unwrap();
    let selection = Selection::Plane { point: [0.5, 0.0, 0.0], normal: [1.0, 0.0, 0.0] };
    let motion = HandleMotion::Follow(animation);
    let following = Body::builder(mesh_of(unit_cube())).lattice_vertices(500).material(Material::fast_lsm());
    let following = following.handle(Handle { goal: None, selection, motion, window: TimeWindow::default() });
    let mut following = Simulation::builder().body(following.build().unwrap()).threads(1).build().unwrap();
    following.steps(60);
    assert_eq!(thread_allocations(|| following.steps(200)), 0, "a handle that follows an animation");

    let mut driven = full_simulation(6, 1);
    driven.collider_mut(0).move_to([0.0; 3], [0.0; 3]).unwrap();
    driven.steps(300);
    let drive = |step| {
        let along = [1e-3 * f64::from(step), 0.0, 0.0];
        driven.collider_mut(0).move_to(along, [0.0, f64::from(step), 0.0]).unwrap();
        driven.step();
    };
    assert_eq!(thread_allocations(|| (0..200).for_each(drive)), 0, "a driven collider");

    let stacked =
        |k: usize| block(6).damping_ratio(0.5).translate([0.1, 0.01 + 0.6 * k as f64, 0.0]).build().unwrap();
    let ground = || Collider::plane([0.0; 3], [0.0, 1.0, 0.0]);
    let stack = Simulation::builder().body(stacked(0)).body(stacked(1)).collider(ground()).sleep(false);
    let mut stack = stack.dt(1.0 / 240.0).threads(1).build().unwrap();
    stack.steps(600);
    assert!(stack.contacts().iter().any(|contact| matches!(contact.other, Touched::Body(_))));
    assert_eq!(thread_allocations(|| stack.steps(200)), 0, "two bodies that touch each other");

    let rigid = Body::builder(mesh_of(unit_cube()))
        .rigid(true)
        .scale(0.5)
        .translate([0.15, 0.62, 0.15])
        .build()
        .unwrap();
    let stack = Simulation::builder().body(stacked(0)).body(rigid).collider(ground()).sleep(false);
    let mut stack = stack.dt(1.0 / 240.0).threads(1).build().unwrap();
    stack.steps(600);
    assert!(stack.contacts().iter().any(|contact| matches!(contact.other, Touched::Body(_))));
    assert_eq!(thread_allocations(|| stack.steps(200)), 0, "a rigid body on a soft one");

    let pin = Pin { goal: None, selection: Selection::Vertices(vec![0]), window: TimeWindow::default() };
    let rigid = Body::builder(mesh_of(unit_cube())).rigid(true).pin(pin).build().unwrap();
    let mut swinging = Simulation::builder().body(rigid).collider(ground()).threads(1).build().unwrap();
    swinging.steps(3);
    assert_eq!(thread_allocations(|| swinging.steps(200)), 0, "a rigid body that swings");

    let mut at_rest = resting_simulation(false);
    at_rest.steps(300);
    assert_eq!(thread_allocations(|| at_rest.steps(200)), 0, "two components that rest on the ground");
    assert!(!at_rest.body(0).is_asleep());
    let mut on_mesh = Simulation::builder()
        .body(block(6).build().unwrap())
        .collider(Collider::mesh(sheet()).unwrap())
        .collider(Collider::capsule([-9.0, -0.04, 0.3], [9.0, -0.04, 0.3], 0.05))
        .threads(1)
        .sleep(false)
        .build()
        .unwrap();
    on_mesh.steps(300);
    assert_eq!(thread_allocations(|| on_mesh.steps(200)), 0, "on a mesh and a thin rod");

    let mut asleep = resting_simulation(true);
    asleep.steps(300);
    assert!(asleep.body(0).is_asleep());
    assert_eq!(thread_allocations(|| asleep.steps(200)), 0, "a sleeping body");

    // With several threads, the queue of the pool allocates a block now and then. 16 is a regression bound.
    let mut large = full_simulation(18, 2);
    large.steps(100);
    let count = allocations(|| large.steps(200));
    assert!(count <= 16, "{count} allocations in 200 steps on two threads");

    // Evaluation with each volume measure: the first one allocates all buffers.
    let cases = [
        (VolumeMeasure::Lattice, SkinKind::Linear),
        (VolumeMeasure::Cells, SkinKind::Linear),
        (VolumeMeasure::Mesh, SkinKind::Linear),
        (VolumeMeasure::Mesh, SkinKind::Smooth),
    ];
    for (measure, skin) in cases {
        let body = Body::builder(mesh_of(unit_cube()))
            .material(Material::fast_lsm())
            .lattice_vertices(500)
            .skin(skin)
            .volume(Preservation::By(measure));
        let mut sim = Simulation::builder()
            .body(body.spin([1.0, 2.0, 0.0]).build().unwrap())
            .threads(1)
            .build()
            .unwrap();
        let vertices = sim.body(0).mesh().unwrap().vertices().len();
        let (mut positions, mut normals) = (vec![[0.0_f32; 3]; vertices], vec![[0.0_f32; 3]; vertices]);
        let mut display = Display::new();
        let mut step_and_evaluate = |sim: &mut Simulation| {
            sim.step();
            display.evaluate(sim.body(0)).surface_into(&mut positions, Some(&mut normals));
            display.evaluate(sim.body(0)).surface_into(&mut positions, None);
        };
        step_and_evaluate(&mut sim);
        let count = thread_allocations(|| (0..20).for_each(|_| step_and_evaluate(&mut sim)));
        assert_eq!(count, 0, "evaluations with measure {measure}, {skin:?}");
    }

    // An inflated body: its first step creates the stage.
    for half_width in [HalfWidth::CELL, HalfWidth::from(2.0)] {
        let zone = Selection::Plane { point: [0.5; 3], normal: [0.0, 1.0, 0.0] };
        let body = Body::builder(mesh_of(unit_cube())).lattice_vertices(500).half_width(half_width);
        let keys = [(0.0, 1.0), (1.0, 1.3)].map(|(time, value)| CurveKey { time, value });
        let body = body.poisson_ratio(0.3).inflate(Curve::new(keys.into()).unwrap());
        let body = body.zone(Zone::new(zone, 1.0).inflated(1.2)).build().unwrap();
        let mut sim = Simulation::builder().body(body).threads(1).build().unwrap();
        let mut display = Display::new();
        let mut step_and_evaluate = || {
            sim.step();
            assert!(display.evaluate(sim.body(0)).positions().len() > 0);
        };
        step_and_evaluate();
        let count = thread_allocations(|| (0..20).for_each(|_| step_and_evaluate()));
        assert_eq!(count, 0, "an inflated body, {half_width:?}");
    }

    // The regional correction beside colliders, once the body has come to rest.
    let volume = VolumeOptions { scope: VolumeScope::Regional, ..VolumeMeasure::Mesh.into() };
    for skin in [SkinKind::Linear, SkinKind::Smooth] {
        let body = Body::builder(mesh_of(unit_cube()))
            .material(Material::fast_lsm())
            .lattice_vertices(500)
            .region_damping(0.2)
            .volume(volume)
            .skin(skin)
            .build()
            .unwrap();
        let ball = Collider::sphere([0.5, -0.9, 0.5], 1.0);
        let ground = Collider::plane([0.0, 0.02, 0.0], [0.0, 1.0, 0.0]);
        let resting =
            Simulation::builder().body(body).collider(ball).collider(ground).substeps(Substeps::Fixed(2));
        let mut resting = resting.threads(1).build().unwrap();
        let mut display = Display::new();
        let mut step_and_evaluate = |count: usize| {
            for _ in 0..count {
                resting.steps(2);
                assert!(display.evaluate(resting.body(0)).positions().len() > 0);
            }
        };
        step_and_evaluate(200);
        assert_eq!(thread_allocations(|| step_and_evaluate(20)), 0, "evaluations beside colliders, {skin:?}");
    }

    let stages = |sim: &Simulation| {
        let plan = sim.plan();
        plan.bodies[0].stages.iter().map(|stage| stage.name).collect::<Vec<_>>()
    };
    let all = [
        "begin pins, handles",
        "momentum tracker",
        "region damping",
        "elastic damping",
        "begin contacts",
        "shape matching",
        "fracture",
        "integration",
        "contacts",
        "pins and handles",
        "supported motion",
        "damping by supports",
        "volume correction",
    ];
    assert_eq!(stages(&sim), all);
    assert_eq!(
        sim.plan().bodies[0].left_out,
        ["inflation", "external forces", "contact of bodies", "mesh update"]
    );
    let bare =
        Simulation::builder().body(block(6).volume(VolumeOptions::off()).build().unwrap()).build().unwrap();
    assert_eq!(stages(&bare), ["momentum tracker", "shape matching", "integration"]);

    // The plan counts the memory that building and stepping a simulation allocates. It leaves out the slack
    // of growing vectors and a few numbers per component and constraint: less than 2 bytes per lattice vertex
    // here, so no array with a number (4 bytes or more) for each vertex is missing.
    let without_optional_stages = |n| {
        let body = block(n).volume(VolumeOptions::off()).build().unwrap();
        Simulation::builder().body(body).threads(1).build().unwrap()
    };
    let builds: [&dyn Fn(i32) -> Simulation; 2] = [&|n| full_simulation(n, 1), &without_optional_stages];
    for build in builds {
        let before = thread_bytes();
        let mut sim = build(36);
        sim.step();
        let allocated = thread_bytes() - before;
        let planned = sim.plan().bodies[0].bytes() as isize;
        let missing = allocated - planned;
        assert!(
            (0..2 * 37_isize.pow(3)).contains(&missing),
            "the plan counts {planned} bytes of {allocated} that are allocated"
        );
    }
}
