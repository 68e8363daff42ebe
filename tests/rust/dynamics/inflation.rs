//! Inflation: rest volumes that change, of a body and of its zones.

use nalgebra::Vector3;
use supple::{
    Body, BodyBuilder, Collider, Curve, CurveKey, ElasticLaw, Lattice, Material, Pin, Plasticity, Selection,
    Simulation, Substeps, TimeWindow, VolumeMeasure, VolumeOptions, VolumeScope, Zone,
};
use supple_tests::{
    Random, ball, block, coordinates, difficult_lattices, lattice, momentum, points, rest, tolerance,
    without_gravity, worst,
};

use crate::poisson::{assert_forces_are_gradient, assert_same_bits, body, deformed, mean_position, naive};

/// Returns a curve from 1 at time 0 to `value` at `time`.
fn ramp(time: f64, value: f64) -> Curve {
    Curve::new(vec![CurveKey { time: 0.0, value: 1.0 }, CurveKey { time, value }]).unwrap()
}

/// Returns the part of a lattice with x up to `at`.
fn below(at: f64) -> Selection {
    Selection::Box { min: [-1e3; 3], max: [at, 1e3, 1e3] }
}

#[test]
fn goals_and_energies_equal_the_reference() {
    let mut random = Random(71);
    for (name, lattice) in difficult_lattices() {
        for (half_width, ratio) in [(1.0, 0.45), (2.0, 0.0), (0.5, 0.0), (0.5, 0.45)] {
            for stretch in [[1.3, 0.9, 1.1], [-0.7, 1.2, 1.0]] {
                let zone = Zone::new(below(1.5), 1.0).inflated(1.6);
                let builder = body(&lattice, half_width, ratio).inflate(0.7).zone(zone);
                let mut simulation = without_gravity(builder.build().unwrap());
                simulation.step();
                let x = deformed(&rest(&lattice), stretch, 0.1, &mut random);
                simulation.body_mut(0).set_positions(&points(&x)).unwrap();
                let body = simulation.body(0);
                let ratios = body.rest_volume_ratios();
                assert!(ratios.iter().all(|ratio| (0.7..=1.12 + 1e-9).contains(ratio)));
                let x = coordinates(&body.positions());
                let naive = naive(&lattice, half_width, ratio).with_rest_volumes(ratios);
                let motions = naive.motions(&x);
                let extent = x.iter().map(|x| x.amax()).fold(1.0, f64::max);
                // As for Poisson's ratio, with a deformation gradient that is up to 1/σ = 1.13 times as large.
                let limit = 20.0 * 1.3 * tolerance(extent);
                let error = worst(&coordinates(&body.goals()), &naive.goals(&motions));
                assert!(error <= limit, "{name}, w = {half_width}, {ratio}, {stretch:?}: goals {error:e}");
                let alpha = ElasticLaw::greatest_alpha_of(ratio);
                let unit = alpha / simulation.dt().powi(2) * body.material().density;
                let expected = unit * naive.matching_energy(&motions, &x);
                let found = body.elastic_energy().unwrap();
                let scale = expected.max(unit * lattice.len() as f64);
                assert!((found - expected).abs() <= 1e-4 * scale, "{name}: {found} for {expected}");
            }
        }
    }
}

#[test]
fn forces_are_the_gradient_of_the_energy() {
    let mut random = Random(72);
    let lattice = lattice(&block([4, 3, 2]));
    for (half_width, ratio) in [(1.0, 0.45), (2.0, 0.0), (0.5, 0.45)] {
        for stretch in [[1.2, 0.9, 1.0], [1.0, 1.0, -1.0], [0.1, 0.1, 0.1]] {
            let ratios = (0..lattice.len()).map(|_| 0.5 + 1.5 * random.unit()).collect();
            let naive = naive(&lattice, half_width, ratio).with_rest_volumes(ratios);
            let x = deformed(&rest(&lattice), stretch, 0.1, &mut random);
            assert_forces_are_gradient(&naive, &x, &format!("{half_width}, {ratio}, {stretch:?}"));
        }
    }
}

/// Damps a body at 0.3 of the lowest mode.
fn damped(builder: BodyBuilder) -> BodyBuilder {
    builder.damping_ratio(0.3)
}

/// A free body has s times its volume at rest, whatever Poisson's ratio and the regions, and gets no momentum.
#[test]
fn a_free_body_grows_to_its_ratio_without_momentum() {
    let lattice = lattice(&block([6, 3, 3]));
    for (half_width, ratio) in [(0.5, 0.0), (0.5, 0.45), (1.0, 0.3), (2.0, 0.45)] {
        for s in [0.1, 0.5, 3.0, 10.0] {
            let builder = damped(body(&lattice, half_width, ratio)).inflate(ramp(1.0, s));
            let mut simulation = without_gravity(builder.build().unwrap());
            for _ in 0..30 {
                simulation.steps(20);
                let body = simulation.body(0);
                // Positions are f32: 1e-6 of the speed of growth, one length of the body in the second of the ramp.
                let scale = 6.0 * body.mass();
                assert!(momentum(&body).norm() < 1e-6 * scale, "{}", momentum(&body).norm());
                assert!(body.angular_momentum().norm() < 1e-6 * 6.0 * scale);
            }
            let report = simulation.body(0).volume_report();
            let [rest, before, after] = report.volumes[1].1.into_array();
            assert!((rest / (54.0 * s) - 1.0).abs() < 1e-12, "{rest}");
            assert!((before / rest - 1.0).abs() < 1e-4, "w {half_width}, {ratio}, s {s}: {}", before / rest);
            assert!((after / rest - 1.0).abs() < 1e-6, "{}", after / rest);
        }
    }
}

trait IntoArray {
    fn into_array(self) -> [f64; 3];
}

impl IntoArray for supple::Volumes {
    fn into_array(self) -> [f64; 3] {
        [self.rest, self.before, self.after]
    }
}

/// A zone grows by itself: layers far from its border have the ratio of the zone, or 1.
#[test]
fn a_zone_grows_alone() {
    let lattice = lattice(&block([24, 4, 4]));
    for half_width in [0.5, 1.0] {
        let builder = damped(body(&lattice, half_width, 0.3)).zone(Zone::new(below(12.5), 1.0).inflated(1.5));
        let mut simulation = without_gravity(builder.build().unwrap());
        simulation.steps(2000);
        let body = simulation.body(0);
        let at = |layer: i32| mean_position(&body, 0, |index| index[0] == layer);
        let length = |from: i32, to: i32| (at(to) - at(from)) / f64::from(to - from);
        assert!((length(2, 7) / 1.5_f64.cbrt() - 1.0).abs() < 1e-3, "{}", length(2, 7));
        assert!((length(17, 22) - 1.0).abs() < 1e-3, "{}", length(17, 22));
    }
}

/// A body that is held all over presses with the pressure p of its bulk modulus K: p = K (s - 1) for small s - 1.
#[test]
fn a_held_body_presses_by_its_bulk_modulus() {
    let n = 4;
    let lattice = lattice(&block([n; 3]));
    for ratio in [0.0, 0.3, 0.45] {
        let e = 1e5;
        let excess = 1e-3;
        let end = f64::from(n);
        let window = TimeWindow::default();
        let all =
            Pin { goal: None, selection: Selection::Box { min: [-1.0; 3], max: [end + 1.0; 3] }, window };
        let face = Pin {
            goal: None,
            selection: Selection::Box { min: [end - 0.1, -1.0, -1.0], max: [end + 1.0; 3] },
            window,
        };
        let builder =
            Body::from_lattice(lattice.clone()).youngs_modulus(e).poisson_ratio(ratio).inflate(1.0 + excess);
        let body = builder.density(1e3).pin(all).pin(face).build().unwrap();
        let mut simulation = Simulation::builder()
            .body(body)
            .gravity([0.0; 3])
            .fps(30.0)
            .substeps(Substeps::Auto)
            .build()
            .unwrap();
        simulation.advance(2);
        let force = simulation.body(0).hold_force(1).unwrap().unwrap().force.x;
        let law = e / (3.0 * (1.0 - 2.0 * ratio)) * excess * end * end;
        assert!((-force / law - 1.0).abs() < 0.02, "nu {ratio}: {force} for {law}");
    }
}

/// Inflated on a floor, a ball has the volume that is asked for, drifts nowhere, and the display keeps it to 1e-6.
#[test]
fn a_ball_on_a_floor_grows_to_its_ratio() {
    for (ratio, accuracy) in [(0.45, supple::Accuracy::Exact), (0.0, supple::Accuracy::Fast)] {
        for s in [0.7, 1.5] {
            // The lowest vertex of the mesh is at y = -1.2.
            let builder =
                Body::builder(ball(1.0)).lattice_vertices(600).youngs_modulus(5e7).poisson_ratio(ratio);
            let builder = builder.accuracy(accuracy).translate([0.0, 1.2, 0.0]).inflate(ramp(2.0, s));
            let floor = Collider::plane([0.0; 3], [0.0, 1.0, 0.0]);
            let builder = Simulation::builder()
                .body(builder.build().unwrap())
                .collider(floor)
                .fps(30.0)
                .substeps(Substeps::Auto);
            let mut simulation = builder.build().unwrap();
            let start = simulation.body(0).center_of_mass();
            simulation.advance(120);
            let body = simulation.body(0);
            let report = body.volume_report();
            // The weight presses by less than 1 %: by Hertz, it sinks by 0.01 of its radius.
            assert!((report.before / report.rest - 1.0).abs() < 0.01, "{}", report.before / report.rest);
            assert!((report.after / report.rest - 1.0).abs() < 1e-6, "{}", report.after / report.rest);
            let measures = body.volume_report().volumes;
            assert!(measures.iter().all(|(_, volumes)| volumes.rest > 0.0));
            let drift = body.center_of_mass() - start;
            assert!(drift.x.hypot(drift.z) < 1e-3, "{drift}");
            // It grows from where it touches.
            let height = s.cbrt();
            assert!(
                (body.center_of_mass().y - height).abs() < 0.02 * height,
                "{} for {height}",
                body.center_of_mass()
            );
        }
    }
}

/// The scope `regional` puts the volume where it belongs: an inflated zone is displayed with its own ratio.
#[test]
fn a_regional_correction_follows_the_zones() {
    let lattice = lattice(&block([24, 4, 4]));
    let regional = VolumeOptions { scope: VolumeScope::Regional, ..VolumeMeasure::Cells.into() };
    let builder =
        damped(body(&lattice, 0.5, 0.0)).zone(Zone::new(below(12.5), 1.0).inflated(2.0)).volume(regional);
    let mut simulation = without_gravity(builder.build().unwrap());
    simulation.steps(2000);
    // Flatten the body: the correction has to return the lost volume in both halves.
    let x: Vec<_> =
        simulation.body(0).positions().iter().map(|x| Vector3::new(x.x, 0.8 * x.y, x.z)).collect();
    simulation.body_mut(0).set_positions(&points(&x)).unwrap();
    let corrected = coordinates(&simulation.body(0).corrected_positions());
    let volume = |positions: &[Vector3<f64>], from: i32, to: i32| {
        let extent = |axis: usize, low: i32, high: i32| {
            let body = simulation.body(0);
            let mean = |at: i32| {
                let chosen = body.lattice().indices().iter().zip(positions);
                let values: Vec<f64> = chosen
                    .filter(|(index, _)| (from..=to).contains(&index[0]) && index[axis] == at)
                    .map(|(_, x)| x[axis])
                    .collect();
                values.iter().sum::<f64>() / values.len() as f64
            };
            mean(high) - mean(low)
        };
        extent(0, from, to) * extent(1, 0, 4) * extent(2, 0, 4)
    };
    for (from, to, s) in [(3, 8, 2.0), (16, 21, 1.0)] {
        let rest = 16.0 * f64::from(to - from) * s;
        assert!((volume(&x, from, to) / rest - 0.8).abs() < 0.02);
        let ratio = volume(&corrected, from, to) / rest;
        assert!((ratio - 1.0).abs() < 0.05, "{from} to {to}: {ratio}");
    }
    let report = simulation.body(0).volume_report();
    assert!((report.after / report.rest - 1.0).abs() < 1e-6);
}

/// Returns the names of the stages of the body.
fn stages(simulation: &Simulation) -> Vec<&'static str> {
    simulation.plan().bodies[0].stages.iter().map(|stage| stage.name).collect()
}

/// A ratio of 1 has the bits of none, and after a ratio returns to 1 nothing of it is left.
#[test]
fn a_ratio_of_one_costs_nothing() {
    let lattice = lattice(&block([7, 5, 4]));
    let run = |builder: BodyBuilder| {
        let mut body = builder.build().unwrap();
        let mut random = Random(73);
        body.set_positions(&points(&deformed(&rest(&lattice), [1.2, 0.8, 1.0], 0.1, &mut random))).unwrap();
        let mut simulation = without_gravity(body);
        simulation.steps(50);
        simulation
    };
    let plain = || Body::from_lattice(lattice.clone()).material(Material::default());
    let (without, with) = (run(plain()), run(plain().inflate(1.0)));
    assert!(without.state() == with.state());
    assert_eq!(stages(&with), stages(&without));
    let mut simulation = run(plain().inflate(1.2));
    assert_eq!(simulation.body(0).inflate().constant(), Some(1.2));
    simulation.body_mut(0).set_inflate(1.0).unwrap();
    simulation.step();
    assert_eq!(stages(&simulation), stages(&without));
    assert_eq!(simulation.body(0).memory(), without.body(0).memory());
    assert!(simulation.body(0).rest_volume_ratios().iter().all(|&ratio| ratio == 1.0));
}

#[test]
fn bits_do_not_depend_on_threads_and_states_continue() {
    let lattice = lattice(&block([20, 19, 18]));
    for (half_width, plastic) in [(1.0, false), (0.5, true)] {
        let run = |threads: usize| {
            let zone = Zone::new(below(9.0), 1.0).inflated(ramp(1.0, 2.0));
            let mut builder = body(&lattice, half_width, 0.3).inflate(ramp(0.5, 0.8)).zone(zone);
            if plastic {
                builder = builder.plastic(Plasticity { yield_strain: 0.02, ..Plasticity::default() });
            }
            let simulation = Simulation::builder().body(builder.build().unwrap()).gravity([0.0; 3]);
            let mut simulation = simulation.threads(threads).build().unwrap();
            simulation.steps(10);
            simulation
        };
        assert_same_bits(run, &format!("{half_width}"));
    }
}

/// Before its first keyframe is left, a restored body has the stages and the memory of one that was not saved.
#[test]
fn a_restored_body_has_no_stage_before_its_ratio_changes() {
    let build = || {
        let keys = [(5.0, 1.0), (6.0, 2.0)].map(|(time, value)| CurveKey { time, value });
        let builder = body(&lattice(&block([4, 4, 4])), 2.0, 0.0).inflate(Curve::new(keys.into()).unwrap());
        without_gravity(builder.build().unwrap())
    };
    let (mut first, mut second) = (build(), build());
    first.steps(3);
    second.restore(&first.state()).unwrap();
    assert_eq!(stages(&first), stages(&second));
    assert_eq!(first.body(0).memory(), second.body(0).memory());
}

/// A body that sleeps wakes when it is inflated, and falls asleep again.
#[test]
fn inflation_wakes_a_body() {
    let builder =
        Body::builder(ball(1.0)).lattice_vertices(300).translate([0.0, 1.0, 0.0]).damping_ratio(0.5);
    let curve = |keys: &[(f64, f64)]| {
        Curve::new(keys.iter().map(|&(time, value)| CurveKey { time, value }).collect()).unwrap()
    };
    let body = builder.inflate(curve(&[(6.0, 1.0), (6.5, 1.3)])).build().unwrap();
    let floor = Collider::plane([0.0; 3], [0.0, 1.0, 0.0]);
    let mut simulation =
        Simulation::builder().body(body).collider(floor).fps(30.0).substeps(Substeps::Auto).build().unwrap();
    simulation.advance(178);
    assert!(simulation.body(0).is_asleep());
    simulation.advance(10);
    assert!(!simulation.body(0).is_asleep());
    simulation.advance(200);
    assert!(simulation.body(0).is_asleep());
}

#[test]
fn ratios_out_of_range_are_errors() {
    let lattice: Lattice = lattice(&block([2, 2, 2]));
    let error = Body::from_lattice(lattice.clone()).inflate(0.01).build().unwrap_err().to_string();
    assert_eq!(error, "inflate = 0.01 is out of range: it must be in [0.1, 10]");
    let zone = Zone::new(below(0.5), 1.0).inflated(20.0);
    let error = Body::from_lattice(lattice).zone(zone).build().unwrap_err().to_string();
    assert_eq!(error, "inflate = 20 is out of range: it must be in [0.1, 10]");
}
