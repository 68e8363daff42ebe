//! Momentum of soft and rigid bodies together.

use nalgebra::{Point3, Vector3};
use rapier3d::prelude::*;

use crate::support::*;

/// A rigid cube of a third of the mass hits a soft cube off its center, in free fall. Nothing else acts.
#[test]
fn a_free_collision_keeps_both_momenta() {
    let mut world = world(0.0);
    let start = RigidBodyBuilder::dynamic()
        .translation(Vector::new(0.2, 0.95, 0.15))
        .linvel(Vector::new(0.3, -4.0, 0.1))
        .angvel(Vector::new(1.0, 0.5, -2.0));
    let rigid = insert_cube(&mut world, start, (0.5, 2700.0));
    let mut soft = soft_world(soft_cube());
    let origin = Point3::origin();
    let total = |world: &PhysicsWorld, soft: &supple_rapier::SoftWorld| {
        let (a, l) = momenta_of_rigid(&world.bodies[rigid], origin);
        let (b, m) = momenta_of_soft(&soft.bodies()[0], origin);
        (a + b, l + m)
    };
    let before = total(&world, &soft);
    let mut greatest = 0.0_f64;
    let (mut linear, mut angular) = (0.0_f64, 0.0_f64);
    for _ in 0..120 {
        soft.step(&mut world).unwrap();
        greatest = greatest.max(soft.impulse_on(rigid).unwrap().0.norm());
        let now = total(&world, &soft);
        linear = linear.max((now.0 - before.0).norm() / before.0.norm());
        angular = angular.max((now.1 - before.1).norm() / before.1.norm());
    }
    // They collide: the rigid body turns back.
    assert!(greatest > 0.05 * before.0.norm(), "{greatest}");
    assert!(world.bodies[rigid].linvel().y > -1.0);
    assert!(linear < 1e-6, "{linear:e}");
    // Rapier rounds the three coordinates of a step, below 4, by at most 2^-23: an error of the arm of the momentum.
    // The errors of 120 steps have no common sign; three times their standard deviation.
    let arm = 3.0 * 2.0_f64.powi(-23) * (120.0_f64).sqrt();
    let bound = arm * f64::from(world.bodies[rigid].mass()) * 4.2 / before.1.norm();
    assert!(angular < bound && bound < 2e-5, "{angular:e} {bound:e}");
}

/// The impulses that are reported are those that change the momentum of the soft body.
#[test]
fn reported_impulses_are_those_of_the_soft_body() {
    let mut world = world(0.0);
    let start = RigidBodyBuilder::dynamic().translation(Vector::new(0.0, 0.8, 0.0)).linvel(Vector::Y * -2.0);
    let rigid = insert_cube(&mut world, start, (0.5, 1000.0));
    let mut soft = soft_world(soft_cube());
    let mut sum = Vector3::zeros();
    for _ in 0..60 {
        soft.step(&mut world).unwrap();
        sum += soft.impulse_on(rigid).unwrap().0;
    }
    let error = (sum + soft.bodies()[0].linear_momentum()).norm() / sum.norm();
    assert!(sum.norm() > 50.0 && error < 1e-6, "{sum:?} {error:e}");
}
