//! Rest and stability of contacts.

use rapier3d::prelude::*;
use supple::Touched;

use crate::support::*;

const G: f32 = 9.81;

fn ground(world: &mut PhysicsWorld) {
    world.insert(
        RigidBodyBuilder::fixed().translation(Vector::new(0.0, -0.5, 0.0)),
        ColliderBuilder::cuboid(5.0, 0.5, 5.0),
    );
}

/// Returns the mean over `steps` of the force upwards on a Rapier body.
fn mean_force(
    soft: &mut supple_rapier::SoftWorld,
    world: &mut PhysicsWorld,
    body: RigidBodyHandle,
    steps: u32,
) -> f64 {
    let mut sum = 0.0;
    for _ in 0..steps {
        soft.step(world).unwrap();
        sum += soft.impulse_on(body).unwrap().0.y;
    }
    sum / (f64::from(steps) * f64::from(world.integration_parameters.dt))
}

#[test]
fn a_soft_cube_rests_on_a_rapier_ground_with_its_weight() {
    let mut world = world(G);
    ground(&mut world);
    let mut soft = soft_world(soft_cube().translate([0.0, 0.51, 0.0]).damping_ratio(0.5));
    for _ in 0..240 {
        soft.step(&mut world).unwrap();
    }
    let contacts = soft.simulation().contacts();
    assert!(contacts.iter().all(|contact| contact.other == Touched::Collider(0)));
    let force: f64 = contacts.iter().map(|contact| contact.force.y).sum();
    let weight = soft.bodies()[0].mass() * f64::from(G);
    assert!((force / weight - 1.0).abs() < 1e-3, "{force} {weight}");
}

#[test]
fn a_rigid_cube_rests_on_a_soft_one_with_its_weight() {
    let mut world = world(G);
    ground(&mut world);
    let start = RigidBodyBuilder::dynamic().translation(Vector::new(0.0, 1.26, 0.0));
    let rigid = insert_cube(&mut world, start, (0.5, 1000.0));
    let mut soft = soft_world(soft_cube().translate([0.0, 0.5, 0.0]).damping_ratio(0.5));
    for _ in 0..360 {
        soft.step(&mut world).unwrap();
    }
    let height = world.bodies[rigid].translation().y;
    let force = mean_force(&mut soft, &mut world, rigid, 120);
    let weight = f64::from(world.bodies[rigid].mass() * G);
    let body = &world.bodies[rigid];
    assert!((force / weight - 1.0).abs() < 1e-3, "{force} {weight}");
    assert!((body.translation().y - height).abs() < 1e-4);
    assert!(body.linvel().length() < 1e-3);
}

/// The mass of the cube is a thousandth of that of the soft body, 1/30 of the mass of the cells below it.
#[test]
fn a_light_rigid_cube_on_a_heavy_soft_one_is_stable() {
    let mut world = world(G);
    ground(&mut world);
    let start = RigidBodyBuilder::dynamic().translation(Vector::new(0.0, 1.12, 0.0));
    let rigid = insert_cube(&mut world, start, (0.2, 125.0));
    let mut soft = soft_world(soft_cube().translate([0.0, 0.5, 0.0]).damping_ratio(0.5));
    for _ in 0..360 {
        soft.step(&mut world).unwrap();
    }
    let mut fastest = 0.0_f32;
    for _ in 0..120 {
        soft.step(&mut world).unwrap();
        fastest = fastest.max(world.bodies[rigid].linvel().length());
    }
    let force = mean_force(&mut soft, &mut world, rigid, 120);
    let weight = f64::from(world.bodies[rigid].mass() * G);
    // A step of free fall adds 0.08.
    assert!(fastest < 1e-2, "{fastest}");
    assert!((force / weight - 1.0).abs() < 1e-3, "{force} {weight}");
}

/// The soft cube, 20 times as heavy as the plate, bounces on it. Rapier's contacts are soft: the plate gives way by a
/// few millimeters, and the bound of a tenth of its thickness is a choice.
#[test]
fn a_light_plate_between_the_ground_and_a_heavy_soft_cube_stays_in_place() {
    let mut world = world(G);
    ground(&mut world);
    let start = Vector::new(0.0, 0.05, 0.0);
    let (plate, _) = world.insert(
        RigidBodyBuilder::dynamic().translation(start),
        ColliderBuilder::cuboid(0.7, 0.05, 0.7).density(250.0),
    );
    let mut soft = soft_world(soft_cube().translate([0.0, 0.6, 0.0]).damping_ratio(0.5));
    let mut greatest = 0.0_f64;
    for _ in 0..480 {
        soft.step(&mut world).unwrap();
        greatest = greatest.max(-soft.impulse_on(plate).unwrap().0.y * 120.0);
        let moved = world.bodies[plate].translation() - start;
        assert!(moved.length() < 0.01, "{moved}");
    }
    // A bounce without damping doubles the weight.
    let weight = soft.bodies()[0].mass() * f64::from(G);
    assert!(greatest > weight && greatest < 2.5 * weight, "{greatest} {weight}");
}
