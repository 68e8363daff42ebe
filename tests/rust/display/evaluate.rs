//! Displays: reuse between bodies and frames, and bodies that change simulations.

use nalgebra::{Point3, Vector3};
use supple::{
    Body, BodyRef, Collider, Display, Material, Preset, RegionSize, Simulation, SkinKind, VolumeOptions,
};
use supple_tests::{ball, block, lattice};

fn cube(edge: i32) -> Body {
    Body::from_lattice(lattice(&block([edge; 3])))
        .material(Material::fast_lsm())
        .region_damping(0.2)
        .build()
        .unwrap()
}

fn falling(body: Body) -> Simulation {
    Simulation::builder().body(body).threads(1).build().unwrap()
}

fn above_ground(body: Body, height: f64) -> Simulation {
    let ground = Collider::plane([0.0, height, 0.0], [0.0, 1.0, 0.0]);
    Simulation::builder().body(body).collider(ground).threads(1).build().unwrap()
}

fn lowest(body: BodyRef<'_>) -> f64 {
    body.corrected_positions().iter().map(|p| p.y).fold(f64::INFINITY, f64::min)
}

#[test]
fn bodies_swapped_between_simulations_collide_with_the_colliders_of_the_new_one() {
    let (mut free, mut grounded) = (falling(cube(3)), above_ground(cube(3), -0.5));
    std::mem::swap(&mut free.bodies_mut()[0], &mut grounded.bodies_mut()[0]);
    free.steps(120);
    grounded.steps(120);
    // Symplectic Euler from rest: g dt² n (n + 1)/2 with dt 1/60 and n = 120.
    let fallen = 9.81 / 3600.0 * 120.0 * 121.0 / 2.0;
    assert!((lowest(free.body(0)) + fallen).abs() < 1e-4, "{}", lowest(free.body(0)));
    // Regression bound: 0.02 cells below the ground at -0.5.
    assert!(lowest(grounded.body(0)) > -0.52, "the ground stops the swapped body");
    let contacts = |simulation: &Simulation| {
        simulation.plan().bodies[0].stages.iter().any(|stage| stage.name == "contacts")
    };
    assert!(contacts(&grounded) && !contacts(&free));
}

#[test]
fn a_swapped_body_is_evaluated_with_its_new_colliders_before_the_first_step() {
    let (mut free, mut grounded) = (falling(cube(3)), above_ground(cube(3), -1e-3));
    let squashed: Vec<Point3<f64>> =
        cube(3).positions().iter().map(|p| Point3::new(p.x, 0.5 * p.y, p.z)).collect();
    free.body_mut(0).set_positions(&squashed).unwrap();
    assert!(lowest(free.body(0)) < -0.05, "alone, the correction moves the lower side down");
    std::mem::swap(&mut free.bodies_mut()[0], &mut grounded.bodies_mut()[0]);
    assert!(lowest(grounded.body(0)) > -2e-3, "the ground limits the correction");
}

#[test]
fn a_body_moved_into_another_simulation_continues_bit_for_bit() {
    let run = |swap: bool| {
        let (mut first, mut second) = (above_ground(cube(3), -0.5), above_ground(cube(3), -0.5));
        first.steps(40);
        if swap {
            second.steps(40);
            std::mem::swap(&mut first.bodies_mut()[0], &mut second.bodies_mut()[0]);
        }
        first.steps(40);
        (first.body(0).positions(), first.body(0).corrected_positions())
    };
    assert!(run(true) == run(false));
}

#[test]
fn a_reused_display_gives_the_same_result_as_a_new_one() {
    let mut simulations = [above_ground(cube(3), -0.5), above_ground(cube(4), -1.0), falling(cube(3))];
    simulations[1].body_mut(0).set_volume(VolumeOptions::off()).unwrap();
    let mut reused = Display::new();
    for _ in 0..6 {
        for simulation in &mut simulations {
            simulation.steps(10);
            let positions: Vec<Point3<f64>> = reused.evaluate(simulation.body(0)).positions().collect();
            assert!(positions == simulation.body(0).corrected_positions());
            assert_eq!(
                reused.evaluate(simulation.body(0)).volume_report(),
                simulation.body(0).volume_report()
            );
        }
    }
}

#[test]
fn a_reused_display_works_for_another_half_width_and_body_size() {
    let mut reused = Display::new();
    for edge in [4, 12, 7] {
        let mut simulation = above_ground(cube(edge), -0.5);
        for half_width in [1, 4, 9, 2] {
            simulation.body_mut(0).set_region_size(RegionSize::Cells(half_width.into())).unwrap();
            simulation.steps(10);
            let positions: Vec<Point3<f64>> = reused.evaluate(simulation.body(0)).positions().collect();
            assert!(
                positions == simulation.body(0).corrected_positions(),
                "edge {edge}, half-width {half_width}"
            );
        }
    }
}

#[test]
fn evaluating_a_body_changes_no_bit_of_its_motion() {
    let run = |evaluate: bool| {
        let mut simulation = above_ground(cube(3), -0.5);
        for _ in 0..20 {
            simulation.steps(5);
            if evaluate {
                simulation.body(0).surface();
                simulation.body(0).volume_report();
            }
        }
        simulation.body(0).positions()
    };
    assert!(run(true) == run(false));
}

/// A ball that flies, spins and strikes the ground, in steps of `dt`.
fn striking(skin: SkinKind, volume: VolumeOptions, dt: f64) -> Simulation {
    let body = Body::builder(ball(1.0)).lattice_vertices(400).preset(Preset::Jelly).skin(skin).volume(volume);
    let body = body.translate([40.0, 1.2, 0.0]).velocity([3.0, -2.0, 1.0]).spin([0.5, 1.0, -2.0]);
    let ground = Collider::plane([0.0; 3], [0.0, 1.0, 0.0]);
    Simulation::builder().body(body.build().unwrap()).collider(ground).dt(dt).threads(1).build().unwrap()
}

/// Returns the greatest difference between the velocities of the surface after some steps and the change of its positions
/// in the last step by the length of the step, and the greatest speed.
fn velocity_error(mut simulation: Simulation, steps: u64) -> (f64, f64) {
    simulation.steps(steps - 1);
    let before = simulation.body(0).surface().positions;
    simulation.step();
    let after = simulation.body(0).surface().positions;
    let velocities = simulation.body(0).surface_velocities();
    assert_eq!(velocities.len(), after.len());
    let changes = after.iter().zip(&before).map(|(after, before)| (after - before) / simulation.dt());
    let errors = changes.zip(&velocities).map(|(change, velocity)| (change - velocity).norm());
    (errors.fold(0.0, f64::max), velocities.iter().map(Vector3::norm).fold(0.0, f64::max))
}

#[test]
fn surface_velocities_are_those_at_the_end_of_a_step() {
    // In flight: without a correction the trilinear surface moves as its lattice. A spin changes velocities by the
    // acceleration spin² x radius during a step; the ball also sways a little. Factor 3: a choice.
    for dt in [1.0 / 480.0, 1.0 / 1920.0] {
        let steps = (0.04 / dt) as u64;
        let (error, speed) = velocity_error(striking(SkinKind::Linear, VolumeOptions::off(), dt), steps);
        assert!(speed > 2.0, "{speed}");
        assert!(error < 3.0 * 5.25 * dt + 4e-6 / dt, "steps of {dt}: {error}");
    }
    let bare = Body::from_lattice(lattice(&block([2; 3]))).build().unwrap();
    assert!(bare.surface_velocities().is_empty());
}

#[test]
fn surface_velocities_leave_out_little_of_the_motion_of_corrected_and_smooth_surfaces() {
    for skin in [SkinKind::Linear, SkinKind::Smooth] {
        for steps in [20, 240] {
            let (error, speed) = velocity_error(striking(skin, VolumeOptions::default(), 1.0 / 480.0), steps);
            // A choice: a tenth of the speed, of the frame that is blurred.
            assert!(error < 0.1 * speed, "{skin:?}, {steps} steps: {error} of {speed}");
        }
    }
}
