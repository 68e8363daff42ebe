//! Plastic bodies: they keep dents, conserve momenta, and equal the reference.

use nalgebra::{Matrix3, Point3, Vector3};
use supple::reference::{Naive, Regions};
use supple::{
    Body, BodyBuilder, Collider, Damping, Elasticity, HalfWidth, Handle, Key, Material, Pin, Plasticity,
    Preservation, RegionSize, Selection, Simulation, Stiffness, TimeWindow, VolumeMeasure, Zone,
};

use supple_tests::{
    Random, block, coordinates, difficult_lattices, lattice, momentum, points, rest, tolerance,
    without_gravity, worst,
};

/// A low yield strain, so that nearly all of a strong deformation becomes plastic.
const SOFT: Plasticity = Plasticity { yield_strain: 0.01, creep: 5.0, max: 1.0 };

/// Rate in 1/s at which the tested bodies come to rest.
const RATE: f64 = 8.0;

/// Returns a block of cells of edge 1 with narrow regions.
fn plastic_block(size: [i32; 3], plastic: Option<Plasticity>) -> BodyBuilder {
    let material = Material { plastic, damping: Some(Damping::Rate(RATE)), ..Material::fast_lsm() };
    Body::from_lattice(lattice(&block(size))).material(material).half_width(1)
}

/// Returns the part of the space within 0.1 of `at` on an axis.
fn layer(axis: usize, at: f64) -> Selection {
    let (mut min, mut max) = ([-1e3; 3], [1e3; 3]);
    (min[axis], max[axis]) = (at - 0.1, at + 0.1);
    Selection::Box { min, max }
}

/// Moves one end of a block away from the other by the fraction `stretch` of its length within a second, holds it for two
/// seconds, and lets it rest for six. Returns the simulation.
fn stretched_and_released(body: BodyBuilder, axis: usize, length: f64, stretch: f64) -> Simulation {
    let mut simulation = stretched(body, axis, length, stretch);
    simulation.steps(9 * 240);
    simulation
}

/// Returns the simulation of [`stretched_and_released`] at its start.
fn stretched(body: BodyBuilder, axis: usize, length: f64, stretch: f64) -> Simulation {
    let mut translate = [0.0; 3];
    translate[axis] = stretch * length;
    let keys = vec![
        Key { time: 0.0, translate: [0.0; 3], rotate: [0.0; 3] },
        Key { time: 1.0, translate, rotate: [0.0; 3] },
    ];
    let window = TimeWindow { start: 0.0, end: 3.0 };
    let body = body.pin(Pin { goal: None, selection: layer(axis, 0.0), window }).handle(Handle {
        goal: None,
        selection: layer(axis, length),
        motion: keys.into(),
        window,
    });
    let simulation = Simulation::builder().body(body.build().unwrap()).gravity([0.0; 3]).dt(1.0 / 240.0);
    simulation.build().unwrap()
}

/// Returns the mean distance between the two ends of a block along an axis.
fn length_of(body: &Body, axis: usize) -> f64 {
    let end = |index: i32| {
        let vertices = body.lattice().indices().iter().zip(body.positions());
        let at: Vec<f64> = vertices.filter(|(other, _)| other[axis] == index).map(|(_, x)| x[axis]).collect();
        at.iter().sum::<f64>() / at.len() as f64
    };
    let last = body.lattice().indices().iter().map(|index| index[axis]).max().unwrap();
    end(last) - end(0)
}

fn greatest(numbers: &[f64]) -> f64 {
    numbers.iter().copied().fold(0.0, f64::max)
}

/// What remains of the elongation is what the yield strain leaves elastic: √6 e/(3 + e) = 0.01 at e = 0.012, of 0.25.
#[test]
fn a_pulled_bar_keeps_most_of_its_elongation() {
    let simulation = stretched_and_released(plastic_block([24, 8, 8], Some(SOFT)), 0, 24.0, 0.25);
    let kept = (length_of(&simulation.body(0), 0) / 24.0 - 1.0) / 0.25;
    assert!((0.85..1.0).contains(&kept), "{kept}");
}

/// An elastic strain of 0.01 is an elongation of 0.012 of the pressed length, 0.6: 0.0074 of the compression of 0.4, of 1,
/// springs back, 1.8 % of it. The held ends bulge less than the middle, so that the strain varies.
#[test]
fn a_pressed_block_keeps_most_of_its_compression() {
    let simulation = stretched_and_released(plastic_block([10, 10, 10], Some(SOFT)), 1, 10.0, -0.4);
    let kept = (length_of(&simulation.body(0), 1) / 10.0 - 1.0) / -0.4;
    assert!((1.0 - 2.0 * 0.018..1.0).contains(&kept), "{kept}");
}

/// A pull of 3 % strains the bar by 0.025, and with region damping, which holds the bar back, by more beside the end that
/// is pulled. It returns to its length up to what the damping of six seconds leaves.
#[test]
fn below_the_yield_strain_a_body_is_elastic_to_the_bit() {
    for (region_damping, yield_strain) in [(0.0, 0.1), (0.2, 0.3)] {
        let plastic = Plasticity { yield_strain, ..Plasticity::default() };
        let [with, without] = [Some(plastic), None].map(|plastic| {
            let body = plastic_block([16, 4, 4], plastic).region_damping(region_damping);
            stretched_and_released(body, 0, 16.0, 0.03)
        });
        assert_eq!(greatest(&with.body(0).plastic_strain()), 0.0);
        assert!(with.body(0).positions() == without.body(0).positions(), "{region_damping}");
        assert!(with.body(0).velocities() == without.body(0).velocities(), "{region_damping}");
    }
}

/// Returns a body that is stretched, sheared and noisy, with plastic shapes from some steps of flow, and its plasticity.
fn flowing(lattice: &supple::Lattice, half_width: usize, random: &mut Random) -> (Body, Plasticity) {
    let plastic = Plasticity { yield_strain: 0.02, creep: 50.0, max: 0.6 };
    let material = Material { plastic: Some(plastic), ..Material::fast_lsm() };
    let body = Body::from_lattice(lattice.clone()).material(material).half_width(half_width);
    let mut body = body.build().unwrap();
    body.set_positions(&points(&deformed(&rest(lattice), random))).unwrap();
    (body, plastic)
}

fn deformed(x: &[Vector3<f64>], random: &mut Random) -> Vec<Vector3<f64>> {
    let turn = random.rotation();
    let stretch = Matrix3::from_diagonal(&Vector3::new(1.4, 0.8, 1.1));
    let middle = x.iter().sum::<Vector3<f64>>() / x.len() as f64;
    x.iter().map(|x| turn * (stretch * (x - middle)) + random.vector() * 0.1).collect()
}

fn extent(x: &[Vector3<f64>]) -> f64 {
    x.iter().map(|x| x.amax()).fold(1.0, f64::max)
}

/// Returns the largest difference of an entry.
fn worst_entry(a: &[Matrix3<f64>], b: &[Matrix3<f64>]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).amax()).fold(0.0, f64::max)
}

#[test]
fn goals_and_flow_equal_the_reference() {
    let mut random = Random(31);
    for (name, lattice) in difficult_lattices() {
        for half_width in [1, 2, 4] {
            let (body, plastic) = flowing(&lattice, half_width, &mut random);
            let mut simulation = without_gravity(body);
            let mut most: f64 = 0.0;
            for step in 0..8 {
                let body = simulation.body(0);
                let (x, old) = (coordinates(&body.positions()), body.plastic_shapes());
                let naive = Naive::new(&lattice, half_width, Regions::Staircase).with_shapes(old);
                let motions = naive.motions(&x);
                let error = worst(&coordinates(&body.goals()), &naive.goals(&motions));
                // The stretched shapes reach up to 1.7 times as far as the rest shapes.
                let limit = 2.0 * tolerance(extent(&x));
                assert!(error <= limit, "{name}, w = {half_width}, step {step}: goals {error:e}");

                let expected = naive.flowed(&motions, &plastic, simulation.dt());
                simulation.step();
                let shapes = simulation.body(0).plastic_shapes();
                // A gradient has the rounding errors of the positions divided by the radius of a region, and a region at
                // the yield strain flows by as much or not at all.
                let error = worst_entry(&shapes, &expected);
                assert!(error <= 2e-5, "{name}, w = {half_width}, step {step}: shapes {error:e}");
                most = most.max(greatest(&simulation.body(0).plastic_strain()));
            }
            assert!(most > 0.05, "{name}, w = {half_width}: it flows: {most}");
        }
    }
}

/// Plastic shapes have the determinant 1, and are at most `max` from the identity.
#[test]
fn plastic_shapes_keep_their_volume_and_their_limit() {
    let mut random = Random(32);
    for (name, lattice) in difficult_lattices() {
        let (mut body, _) = flowing(&lattice, 1, &mut random);
        let plastic = Plasticity { yield_strain: 1e-3, creep: 1e3, max: 0.15 };
        body.set_plastic(Some(plastic)).unwrap();
        let mut simulation = without_gravity(body);
        let mut most: f64 = 0.0;
        for _ in 0..20 {
            simulation.step();
            let body = simulation.body(0);
            for shape in body.plastic_shapes() {
                assert!((shape.determinant() - 1.0).abs() < 1e-5, "{name}: {shape}");
                assert!((shape - Matrix3::identity()).norm() <= 0.15 + 1e-6, "{name}: {shape}");
            }
            most = most.max(greatest(&body.plastic_strain()));
        }
        // The scaling to the determinant 1 takes a shape back below the limit by a few per cent.
        assert!(most > 0.13, "{name}: the limit is reached: {most}");
    }
}

/// A free body that flows keeps its momenta, as an elastic one does: to the rounding of f32 velocities, 6e-8 of the speeds.
#[test]
fn plastic_flow_conserves_momenta() {
    let mut random = Random(33);
    for region_damping in [0.0, 0.2] {
        let (mut body, _) = flowing(&lattice(&block([8, 5, 4])), 1, &mut random);
        body.set_region_damping(supple::RegionDamping::PerStep(region_damping)).unwrap();
        let velocities: Vec<_> =
            rest(body.lattice()).iter().map(|x| Vector3::new(1.0 + x.y, -x.x, x.z)).collect();
        body.set_velocities(&velocities).unwrap();
        let mut simulation = without_gravity(body);
        let before = (momentum(&simulation.body(0)), simulation.body(0).angular_momentum());
        simulation.steps(300);
        let body = simulation.body(0);
        assert!(greatest(&body.plastic_strain()) > 0.01, "it flows: {}", greatest(&body.plastic_strain()));
        let scale = before.0.norm();
        assert!((momentum(&body) - before.0).norm() < 1e-6 * scale);
        assert!((body.angular_momentum() - before.1).norm() < 1e-6 * before.1.norm());
    }
}

/// The goals of a plastically deformed body that is moved rigidly move with it, and a spinning one is not damped.
#[test]
fn rigid_motions_of_a_dented_body_are_exact() {
    let mut random = Random(34);
    let simulation = stretched_and_released(plastic_block([12, 6, 6], Some(SOFT)), 0, 12.0, 0.25);
    let mut body = plastic_block([12, 6, 6], Some(SOFT)).build().unwrap();
    body.restore(&simulation.body(0).snapshot()).unwrap();
    body.release(0).unwrap();
    body.release(1).unwrap();
    let goals = coordinates(&body.goals());
    let turn = random.rotation();
    let shift = Vector3::new(3.0, -2.0, 5.0);
    let moved: Vec<_> = coordinates(&body.positions()).iter().map(|x| turn * x + shift).collect();
    body.set_positions(&points(&moved)).unwrap();
    let expected: Vec<_> = goals.iter().map(|g| turn * g + shift).collect();
    assert!(worst(&coordinates(&body.goals()), &expected) < 2.0 * tolerance(extent(&moved)));

    let spin = Vector3::new(0.0, 0.0, 0.5);
    let center = body.center_of_mass().coords;
    let spinning: Vec<_> = moved.iter().map(|x| spin.cross(&(x - center))).collect();
    body.set_velocities(&spinning).unwrap();
    body.set_region_damping(supple::RegionDamping::PerStep(1.0)).unwrap();
    let before = body.kinetic_energy();
    let mut simulation = without_gravity(body);
    simulation.steps(200);
    // The spin of 0.5 rad/s stretches the bar by less than 1e-4 of its length.
    assert!((simulation.body(0).kinetic_energy() / before - 1.0).abs() < 1e-3);
}

fn pressed(threads: usize) -> Simulation {
    let body = plastic_block([40, 16, 16], Some(Plasticity::default())).translate([0.0, 2.0, 0.0]);
    let mut press = Collider::sphere([20.0, 24.0, 8.0], 5.0);
    press.keys = vec![
        Key { time: 0.0, translate: [0.0; 3], rotate: [0.0; 3] },
        Key { time: 0.5, translate: [0.0, -9.0, 0.0], rotate: [0.0; 3] },
        Key { time: 1.0, translate: [0.0; 3], rotate: [0.0; 3] },
    ];
    let ground = Collider::plane([0.0; 3], [0.0, 1.0, 0.0]);
    Simulation::builder()
        .body(body.build().unwrap())
        .collider(ground)
        .collider(press)
        .dt(0.01)
        .threads(threads)
        .build()
        .unwrap()
}

#[test]
fn plastic_flow_is_thread_count_independent() {
    let [one, two, five] = [1, 2, 5].map(|threads| {
        let mut simulation = pressed(threads);
        simulation.steps(120);
        simulation
    });
    assert!(greatest(&one.body(0).plastic_strain()) > 0.1, "it flows");
    for other in [two, five] {
        assert_eq!(one.body(0).positions(), other.body(0).positions());
        assert_eq!(one.body(0).plastic_shapes(), other.body(0).plastic_shapes());
    }
}

/// A state that is saved while the body flows continues bit by bit, also in a body with other settings.
#[test]
fn a_saved_plastic_body_continues_bit_by_bit() {
    let mut simulation = pressed(1);
    simulation.steps(40);
    let bytes = postcard::to_stdvec(&simulation.state()).unwrap();
    let shapes = simulation.body(0).plastic_shapes();
    simulation.steps(60);
    let mut restored = pressed(1);
    restored.body_mut(0).set_plastic(None).unwrap();
    restored.restore(&postcard::from_bytes(&bytes).unwrap()).unwrap();
    assert_eq!(restored.body(0).plastic_shapes(), shapes);
    restored.steps(60);
    assert_eq!(restored.body(0).positions(), simulation.body(0).positions());
    assert_eq!(restored.body(0).plastic_shapes(), simulation.body(0).plastic_shapes());
    assert!(greatest(&simulation.body(0).plastic_strain()) > 0.1, "it flows");
}

#[test]
fn a_reset_body_returns_to_its_rest_shape() {
    let size = [12, 6, 6];
    let mut simulation = stretched_and_released(plastic_block(size, Some(SOFT)), 0, 12.0, 0.25);
    assert!(length_of(&simulation.body(0), 0) > 14.0);
    // Without a limit the reset body would yield again on its way back.
    simulation.body_mut(0).set_plastic(Some(Plasticity { yield_strain: 1.0, ..SOFT })).unwrap();
    simulation.body_mut(0).reset_plastic();
    assert_eq!(greatest(&simulation.body(0).plastic_strain()), 0.0);
    simulation.steps(5 * 240);
    // The oscillation decays at 8/s: to e^-40 after five seconds.
    assert!((length_of(&simulation.body(0), 0) - 12.0).abs() < 1e-4);
}

#[test]
fn a_body_without_plasticity_has_no_plastic_strain() {
    let mut body = plastic_block([3, 3, 3], None).build().unwrap();
    let (before, bytes) = (body.snapshot(), body.memory());
    body.reset_plastic();
    assert!(body.snapshot() == before, "nothing changes");
    assert_eq!(body.plastic_strain(), vec![0.0; 64]);
    body.set_plastic(Some(SOFT)).unwrap();
    assert!(body.memory() > bytes);
    body.set_plastic(None).unwrap();
    assert_eq!((greatest(&body.plastic_strain()), body.memory()), (0.0, bytes));
}

/// A pressed body comes to rest in its new shape and sleeps. Its plastic shapes then stay as they are.
#[test]
fn a_dented_body_falls_asleep() {
    let mut simulation = pressed(1);
    simulation.steps(1000);
    let body = simulation.body(0);
    assert!(body.is_asleep());
    let shapes = body.plastic_shapes();
    assert!(greatest(&body.plastic_strain()) > 0.1);
    simulation.steps(200);
    assert_eq!(simulation.body(0).plastic_shapes(), shapes);
}

/// The measures are those of the rest shape, because plastic shapes have the determinant 1. The correction brings a dented
/// body to it to a relative 1e-6.
#[test]
fn a_dented_body_keeps_its_volume() {
    for measure in [VolumeMeasure::Cells, VolumeMeasure::Lattice] {
        let preservation = Preservation::By(measure);
        let body = plastic_block([12, 8, 8], Some(SOFT)).volume(preservation);
        let simulation = stretched_and_released(body, 1, 8.0, -0.4);
        let report = simulation.body(0).volume_report();
        assert!(
            (report.before / report.rest - 1.0).abs() < 0.02,
            "{measure}: {}",
            report.before / report.rest
        );
        assert!((report.after / report.rest - 1.0).abs() < 1e-6, "{measure}: {}", report.after / report.rest);
    }
}

/// Regions that are collapsed to a point, flattened or inverted give finite shapes.
#[test]
fn degenerate_regions_stay_finite() {
    let lattice = lattice(&block([5, 4, 3]));
    let x = rest(&lattice);
    let cases: [(&str, Matrix3<f64>); 5] = [
        ("a point", Matrix3::zeros()),
        ("a line", Matrix3::from_diagonal(&Vector3::new(1.0, 0.0, 0.0))),
        ("a plane", Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, 0.0))),
        ("inverted", Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, -1.0))),
        ("far apart", Matrix3::identity() * 1e14),
    ];
    for (name, map) in cases {
        for half_width in [1, 3] {
            let plastic = Plasticity { yield_strain: 1e-6, creep: 1e6, max: 2.0 };
            let material = Material { plastic: Some(plastic), ..Material::fast_lsm() };
            let body = Body::from_lattice(lattice.clone()).material(material).half_width(half_width);
            let mut body = body.region_damping(0.5).build().unwrap();
            body.set_positions(&points(&x.iter().map(|x| map * x).collect::<Vec<_>>())).unwrap();
            let mut simulation = without_gravity(body);
            simulation.steps(200);
            let body = simulation.body(0);
            assert!(body.positions().iter().all(|x| x.iter().all(|x| x.is_finite())), "{name}");
            for shape in body.plastic_shapes() {
                assert!((shape.determinant() - 1.0).abs() < 1e-3, "{name}: {shape}");
                assert!(shape.symmetric_eigenvalues().min() > 0.0, "{name}: {shape}");
            }
        }
    }
}

#[test]
fn plasticity_out_of_range_is_an_error() {
    let wrong = [
        (Plasticity { yield_strain: 0.0, ..SOFT }, "plastic.yield = 0 is out of range: it must be in (0, 1]"),
        (
            Plasticity { creep: -1.0, ..SOFT },
            "plastic.creep = -1 is out of range: it must be a rate in 1/s, > 0",
        ),
        (Plasticity { max: 2.5, ..SOFT }, "plastic.max = 2.5 is out of range: it must be in (0, 2]"),
    ];
    for (plastic, message) in wrong {
        let error = plastic_block([2, 2, 2], Some(plastic)).build().unwrap_err();
        assert_eq!(error.to_string(), message);
    }
}

/// The copies of the vertices at a cut have the plastic shapes of their vertices.
#[test]
fn plastic_shapes_follow_the_copies_of_a_cut() {
    let mut simulation = stretched_and_released(plastic_block([12, 6, 6], Some(SOFT)), 0, 12.0, 0.25);
    let before = simulation.body(0).plastic_shapes();
    let body = simulation.body_mut(0);
    let whole = body.lattice().len();
    let middle = body.center_of_mass();
    body.cut(middle.into(), [1.0, 0.3, 0.1]).unwrap();
    assert_eq!(body.pieces(), 2);
    let (lattice, after) = (body.lattice(), body.plastic_shapes());
    assert!(lattice.len() > whole + 20);
    assert_eq!(after[..whole], before);
    for vertex in whole..lattice.len() {
        let index = lattice.indices()[vertex];
        let source = lattice.indices()[..whole].iter().position(|other| *other == index).unwrap();
        assert_eq!(after[vertex], before[source], "copy {vertex} of vertex {source}");
    }
    // The pieces keep the dent, and continue from a saved state bit by bit.
    simulation.steps(100);
    let state = postcard::to_stdvec(&simulation.state()).unwrap();
    let shapes = simulation.body(0).plastic_shapes();
    assert!(greatest(&simulation.body(0).plastic_strain()) > 0.2);
    simulation.steps(100);
    let end = (simulation.body(0).positions(), simulation.body(0).plastic_shapes());
    let mut restored = stretched(plastic_block([12, 6, 6], Some(SOFT)), 0, 12.0, 0.25);
    restored.restore(&postcard::from_bytes(&state).unwrap()).unwrap();
    assert_eq!(restored.body(0).pieces(), 2);
    assert!(restored.body(0).plastic_shapes() == shapes);
    restored.steps(100);
    assert!((restored.body(0).positions(), restored.body(0).plastic_shapes()) == end);
}

/// A bar with a soft half is held at both ends and pulled: the soft half takes the strain, and keeps it.
#[test]
fn the_soft_zone_of_a_plastic_bar_yields() {
    let zone = Zone::new(Selection::Box { min: [-1.0; 3], max: [8.1, 9.0, 9.0] }, 0.2);
    let body = plastic_block([16, 4, 4], Some(Plasticity { yield_strain: 0.05, ..SOFT })).zone(zone);
    let simulation = stretched_and_released(body, 0, 16.0, 0.1);
    let (body, lattice) = (simulation.body(0), simulation.body(0).lattice().clone());
    let strain = body.plastic_strain();
    let mean = |range: std::ops::Range<i32>| {
        let of_range = lattice.indices().iter().zip(&strain).filter(|(index, _)| range.contains(&index[0]));
        let found: Vec<f64> = of_range.map(|(_, strain)| *strain).collect();
        found.iter().sum::<f64>() / found.len() as f64
    };
    // The soft half is stretched by up to 20 %, a strain of 0.15, and the other one by 4 %, less than the yield strain.
    assert!(mean(2..7) > 0.05, "{}", mean(2..7));
    assert!(mean(11..15) < 1e-3, "{}", mean(11..15));
    assert!(body.positions().iter().all(|x| x.iter().all(|x| x.is_finite())));
    for shape in body.plastic_shapes() {
        assert!((shape.determinant() - 1.0).abs() < 1e-5, "{shape}");
    }
}

/// The plastic shapes belong to the regions around the vertices. Wider or narrower regions around them keep them, and so
/// does the body, whose shape is even.
#[test]
fn other_half_widths_keep_the_plastic_shapes() {
    let mut simulation = stretched_and_released(plastic_block([16, 8, 8], Some(SOFT)), 0, 16.0, 0.25);
    let length = length_of(&simulation.body(0), 0);
    for half_width in [3, 1] {
        let mut state = serde_json::to_value(simulation.body(0).snapshot()).unwrap();
        state["half_width"] = half_width.into();
        let kept = simulation.body(0).plastic_shapes();
        simulation.body_mut(0).restore(&serde_json::from_value(state).unwrap()).unwrap();
        assert_eq!(simulation.body(0).half_width(), half_width);
        assert!(simulation.body(0).plastic_shapes() == kept);
        simulation.steps(4 * 240);
        let found = length_of(&simulation.body(0), 0);
        assert!((found / length - 1.0).abs() < 0.02, "{half_width}: {found} {length}");
    }
}

/// A dent stays when the regions become cells, and when they become wider again.
#[test]
fn plastic_shapes_are_carried_to_other_regions() {
    let lattice = lattice(&block([8, 4, 4]));
    let plastic = Plasticity { yield_strain: 0.05, ..Plasticity::default() };
    let body = Body::from_lattice(lattice.clone()).half_width(1).plastic(plastic).damping_ratio(0.5);
    let mut simulation = without_gravity(body.build().unwrap());
    let stretched: Vec<_> =
        simulation.body(0).positions().iter().map(|p| Point3::new(1.3 * p.x, p.y, p.z)).collect();
    for _ in 0..60 {
        simulation.body_mut(0).set_positions(&stretched).unwrap();
        simulation.step();
    }
    simulation.steps(600);
    let length = |simulation: &Simulation| {
        let x = simulation.body(0).positions().into_iter().map(|p| p.x);
        x.clone().fold(f64::MIN, f64::max) - x.fold(f64::MAX, f64::min)
    };
    let before = length(&simulation);
    assert!(before > 1.1 * 8.0, "{before}");
    let mean = |simulation: &Simulation| {
        let shapes = simulation.body(0).plastic_shapes();
        assert!(shapes.iter().all(|shape| (shape.determinant() - 1.0).abs() < 1e-5));
        shapes.iter().map(|shape| shape[(0, 0)]).sum::<f64>() / shapes.len() as f64
    };
    let shape = mean(&simulation);
    for half_width in [HalfWidth::CELL, 2.into(), HalfWidth::CELL, 1.into()] {
        let elasticity =
            Elasticity::Regions { size: RegionSize::Cells(half_width), stiffness: Stiffness::PerStep(1.0) };
        simulation.body_mut(0).set_elasticity(elasticity).unwrap();
        simulation.steps(300);
        let (length, found) = (length(&simulation), mean(&simulation));
        assert!((length / before - 1.0).abs() < 0.01, "{half_width}: {length} for {before}");
        assert!((found / shape - 1.0).abs() < 0.01, "{half_width}: {found} for {shape}");
    }
}
