//! A steady step allocates nothing, nor does a steady look; an absent stage takes no memory.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::sync::atomic::{AtomicUsize, Ordering};

use nalgebra::Point3;
use supple::{
    Body, BodyBuilder, Collider, Display, Handle, Key, Lattice, Mesh, Pin, Preservation, Selection,
    Simulation, TimeWindow, VolumeMeasure, VolumeOptions, VolumeScope,
};

struct Counting;

/// Of all threads, the test runner's among them.
static ALLOCATIONS: AtomicUsize = AtomicUsize::new(0);

thread_local! {
    /// Of one thread.
    static OWN: Cell<usize> = const { Cell::new(0) };
    /// Bytes that one thread has allocated and not freed.
    static BYTES: Cell<isize> = const { Cell::new(0) };
}

#[allow(unsafe_code, reason = "a global allocator cannot be had without")]
// SAFETY: all calls are handed on to the system's allocator as they come.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
        OWN.set(OWN.get() + 1);
        BYTES.set(BYTES.get() + layout.size() as isize);
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        BYTES.set(BYTES.get() - layout.size() as isize);
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

/// Allocations of this thread while `work` runs.
fn own(work: impl FnOnce()) -> usize {
    let before = OWN.get();
    work();
    OWN.get() - before
}

/// Allocations of all threads while `work` runs. The tests here are one test, so that no other runs beside it.
fn allocations(work: impl FnOnce()) -> usize {
    let before = ALLOCATIONS.load(Ordering::Relaxed);
    work();
    ALLOCATIONS.load(Ordering::Relaxed) - before
}

fn block(n: i32) -> BodyBuilder {
    let cells: Vec<_> =
        (0..n).flat_map(|z| (0..n).flat_map(move |y| (0..n).map(move |x| [x, y, z]))).collect();
    Body::from_lattice(Lattice::from_cells(&cells, 0.1, Point3::origin(), false).unwrap())
}

/// A cube of edge 1.
fn cube() -> Mesh {
    let corners = (0..8).map(|k| [k & 1, k >> 1 & 1, k >> 2 & 1].map(f64::from)).collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    Mesh::new(corners, &quads).unwrap()
}

/// All stages: damping, a pin, a moving handle, contact with the ground.
fn everything(n: i32, threads: usize) -> Simulation {
    let top = Selection::Plane { point: [0.0, 0.1 * f64::from(n), 0.0], normal: [0.0, 1.0, 0.0] };
    let corner = Selection::Sphere { center: [0.0; 3], radius: 0.05 };
    let key = |time, rotate| Key { time, translate: [0.0; 3], rotate: [0.0, rotate, 0.0] };
    let body = block(n)
        .region_damping(0.1)
        .pin(Pin { selection: corner, window: TimeWindow::default() })
        .handle(Handle {
            selection: top,
            keys: vec![key(0.0, 0.0), key(9.0, 90.0)],
            window: TimeWindow::default(),
        })
        .build()
        .unwrap();
    let ground = Collider::plane([0.0, 0.05, 0.0], [0.0, 1.0, 0.0]);
    Simulation::builder().body(body).collider(ground).threads(threads).build().unwrap()
}

#[test]
fn nothing_in_a_steady_state() {
    let mut sim = everything(6, 1);
    sim.steps(300);
    assert_eq!(own(|| sim.steps(200)), 0, "with all stages");

    let mut free = Simulation::builder().body(block(6).build().unwrap()).threads(1).build().unwrap();
    free.steps(3);
    assert_eq!(own(|| free.steps(200)), 0, "a free body");

    // Threads: entering the pool takes a block of its queue now and then, for any number of steps.
    let mut large = everything(18, 2);
    large.steps(100);
    let inside = allocations(|| large.steps(200));
    assert!(inside <= 16, "{inside} allocations in 200 steps on two threads");

    // A look, by each measure: all buffers are there after the first.
    for measure in [VolumeMeasure::Lattice, VolumeMeasure::Cells, VolumeMeasure::Mesh] {
        let body = Body::builder(cube()).lattice_vertices(500).volume(Preservation::By(measure));
        let mut seen = Simulation::builder()
            .body(body.spin([1.0, 2.0, 0.0]).build().unwrap())
            .threads(1)
            .build()
            .unwrap();
        let vertices = seen.body(0).mesh().unwrap().vertices().len();
        let (mut positions, mut normals) = (vec![[0.0_f32; 3]; vertices], vec![[0.0_f32; 3]; vertices]);
        let mut display = Display::new();
        let mut look = |sim: &mut Simulation| {
            sim.step();
            display.evaluate(sim.body(0)).surface_into(&mut positions, Some(&mut normals));
            display.evaluate(sim.body(0)).surface_into(&mut positions, None);
        };
        look(&mut seen);
        assert_eq!(own(|| (0..20).for_each(|_| look(&mut seen))), 0, "looks, measure {measure}");
    }

    // Beside colliders, and region by region, once the body has come to rest.
    let volume = VolumeOptions { scope: VolumeScope::Regional, ..VolumeMeasure::Mesh.into() };
    let body =
        Body::builder(cube()).lattice_vertices(500).region_damping(0.2).volume(volume).build().unwrap();
    let ball = Collider::sphere([0.5, -0.9, 0.5], 1.0);
    let ground = Collider::plane([0.0, 0.02, 0.0], [0.0, 1.0, 0.0]);
    let resting = Simulation::builder().body(body).collider(ball).collider(ground).substeps(2);
    let mut resting = resting.threads(1).build().unwrap();
    let mut display = Display::new();
    let mut look = |count: usize| {
        for _ in 0..count {
            resting.steps(2);
            assert!(display.evaluate(resting.body(0)).positions().len() > 0);
        }
    };
    look(200);
    assert_eq!(own(|| look(20)), 0, "displays beside colliders");

    let stages = |sim: &Simulation| {
        let plan = sim.plan();
        plan.bodies[0].stages.iter().map(|stage| stage.name).collect::<Vec<_>>()
    };
    let all = [
        "begin pins, handles",
        "momentum tracker",
        "region damping",
        "begin contacts",
        "shape matching",
        "integration",
        "contacts",
        "pins and handles",
        "volume correction",
    ];
    assert_eq!(stages(&sim), all);
    assert_eq!(sim.plan().bodies[0].left_out, ["external forces", "mesh update"]);
    let bare =
        Simulation::builder().body(block(6).volume(VolumeOptions::off()).build().unwrap()).build().unwrap();
    assert_eq!(stages(&bare), ["momentum tracker", "shape matching", "integration"]);

    // The plan names what building and stepping a simulation allocates; what it may miss are the slack of growing
    // vectors and a few numbers for each component and constraint.
    for build in [
        || everything(12, 1),
        || {
            Simulation::builder()
                .body(block(12).volume(VolumeOptions::off()).build().unwrap())
                .build()
                .unwrap()
        },
    ] {
        let before = BYTES.get();
        let mut sim = build();
        sim.step();
        let held = (BYTES.get() - before) as f64;
        let told = sim.plan().bodies[0].bytes() as f64;
        assert!((0.95..=1.0).contains(&(told / held)), "the plan says {told} bytes, allocated are {held}");
    }
}
