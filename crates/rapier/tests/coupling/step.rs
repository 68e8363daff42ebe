//! The step of both programs, and locked axes.

use rapier3d::prelude::*;
use supple::{Simulation, Substeps};
use supple_rapier::SoftWorld;

use crate::support::*;

/// The automatic number of steps per frame of this stiff cube is greater than 1.
#[test]
fn the_step_length_is_that_of_rapier_with_automatic_substeps() {
    let mut world = world(9.81);
    let cube = soft_cube().youngs_modulus(1e9).build().unwrap();
    let simulation = Simulation::builder().body(cube).fps(24.0).substeps(Substeps::Auto).threads(1);
    let mut soft = SoftWorld::new(simulation.build().unwrap());
    let dt = f64::from(world.integration_parameters.dt);
    for step in 1..=2 {
        soft.step(&mut world).unwrap();
        assert_eq!(soft.simulation().dt(), dt);
        assert!((soft.simulation().time() - f64::from(step) * dt).abs() < 1e-15);
    }
}

/// The soft cube falls on the body, and overlaps with it.
#[test]
fn a_body_with_locked_translations_stays_in_place() {
    let mut world = world(9.81);
    let start = RigidBodyBuilder::dynamic().lock_translations().lock_rotations();
    let body = insert_cube(&mut world, start, (0.5, 1000.0));
    let mut soft = soft_world(soft_cube().cell_size(0.25).translate([0.0, 0.76, 0.0]));
    let mut greatest = 0.0_f64;
    for _ in 0..30 {
        soft.step(&mut world).unwrap();
        greatest = greatest.max(-soft.impulse_on(body).unwrap().0.y);
    }
    assert!(greatest > 0.0);
    assert_eq!(world.bodies[body].translation(), Vector::ZERO);
}

/// A rigid cube with a spin is near the soft one. From the step on in which its rotations are locked, its rigid body
/// has no angular momentum.
#[test]
fn rotations_that_are_locked_between_steps_are_followed() {
    let mut world = world(0.0);
    let start = RigidBodyBuilder::dynamic().translation(Vector::Y * 1.0).angvel(Vector::Y);
    let body = insert_cube(&mut world, start, (0.5, 1000.0));
    let mut soft = soft_world(soft_cube().cell_size(0.5));
    soft.step(&mut world).unwrap();
    assert!(soft.simulation().bodies()[1].angular_momentum().norm() > 0.0);
    world.bodies[body].set_locked_axes(LockedAxes::ROTATION_LOCKED, true);
    soft.step(&mut world).unwrap();
    assert_eq!(soft.simulation().bodies()[1].angular_momentum().norm(), 0.0);
}

/// The cube rests on the soft one, so that a part of the impulse acts as a force in Rapier's step.
#[test]
fn forces_of_a_step_that_is_left_out_are_taken_back() {
    let mut world = world(9.81);
    world.insert(RigidBodyBuilder::fixed(), ColliderBuilder::new(SharedShape::halfspace(Vector::Y)));
    let start = RigidBodyBuilder::dynamic().translation(Vector::Y * 1.25);
    let body = insert_cube(&mut world, start, (0.5, 1000.0));
    let mut soft = soft_world(soft_cube().cell_size(0.25).translate([0.0, 0.5, 0.0]));
    let force = Vector::new(0.25, 0.0, 0.0);
    world.bodies[body].add_force(force, true);
    (0..30).for_each(|_| soft.step(&mut world).unwrap());
    let settings = (world.gravity, world.integration_parameters.dt);
    let mut has_others = false;
    for _ in 0..3 {
        soft.begin_step(settings, &mut world.bodies, &world.colliders, &world.multibody_joints).unwrap();
        has_others |= world.bodies[body].user_force() != force;
    }
    assert!(has_others);
    soft.step(&mut world).unwrap();
    assert_eq!(world.bodies[body].user_force(), force);
    assert_eq!(world.bodies[body].user_torque(), Vector::ZERO);
}
