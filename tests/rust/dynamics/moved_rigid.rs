//! Rigid bodies that another program moves, and bodies that are added and removed between steps.

use nalgebra::{Isometry3, Matrix3, Point3, Vector3};
use supple::{
    Body, BodyBuilder, Collider, Error, Link, MassProperties, RigidError, Selection, Simulation, Touched,
    TouchingOptions,
};
use supple_tests::{mesh_of, plain_box, within};

/// Returns a box of the edge 1 with its center at the origin, of 27 lattice vertices.
fn cube() -> BodyBuilder {
    Body::builder(mesh_of(plain_box([-0.5; 3], [0.5; 3]))).cell_size(0.5)
}

fn properties() -> MassProperties {
    let inertia = Matrix3::new(3.0, 0.2, 0.0, 0.2, 2.0, -0.1, 0.0, -0.1, 4.0);
    MassProperties { mass: 7.0, center: [0.1, -0.2, 0.05], inertia }
}

fn simulation(bodies: Vec<Body>) -> Simulation {
    let builder = bodies.into_iter().fold(Simulation::builder(), |builder, body| builder.body(body));
    let ground = Collider::plane([0.0; 3], [0.0, 1.0, 0.0]);
    builder.collider(ground).dt(1.0 / 120.0).threads(1).build().unwrap()
}

#[test]
fn given_mass_and_motion_are_those_of_the_body() {
    let mut body = cube().rigid(true).mass_properties(properties()).build().unwrap();
    within(body.mass(), 7.0, 1e-14);
    assert!((body.center_of_mass() - Point3::new(0.1, -0.2, 0.05)).norm() < 1e-14);
    let pose = Isometry3::new(Vector3::new(3.0, 4.0, 5.0), Vector3::new(0.3, -1.0, 0.7));
    let (velocity, spin) = (Vector3::new(1.0, -2.0, 0.5), Vector3::new(0.4, 0.1, -3.0));
    body.set_rigid_motion(&pose, velocity, spin).unwrap();
    assert!((body.pose().to_homogeneous() - pose.to_homogeneous()).norm() < 1e-14);
    assert!((body.center_of_mass() - pose * Point3::new(0.1, -0.2, 0.05)).norm() < 1e-14);
    assert!((body.linear_momentum() - velocity * 7.0).norm() < 1e-13);
    let rotation = pose.rotation.to_rotation_matrix();
    let expected = rotation.matrix() * properties().inertia * rotation.matrix().transpose() * spin;
    assert!((body.angular_momentum() - expected).norm() < 1e-13 * expected.norm());
    assert!((body.spin().unwrap() - spin).norm() < 1e-13 * spin.norm());
    // The lattice vertices are f32 with a compensation.
    let corner = body.positions()[0] - pose * Point3::from([-0.5; 3]);
    assert!(corner.norm() < 1e-6, "{corner:?}");
}

#[test]
fn masses_and_motions_of_soft_bodies_and_wrong_numbers_are_errors() {
    let error = cube().mass_properties(properties()).build().unwrap_err();
    assert!(matches!(error, Error::Rigid(RigidError::NotRigid { .. })), "{error}");
    let mut soft = cube().build().unwrap();
    let (still, zero) = (Isometry3::identity(), Vector3::zeros());
    let error = soft.set_rigid_motion(&still, zero, zero).unwrap_err();
    assert_eq!(
        error.to_string(),
        "the body is soft, so that a rigid motion is not possible; build it with rigid"
    );
    assert!(soft.spin().is_none());
    let wrong = [
        MassProperties { mass: 0.0, ..properties() },
        MassProperties { center: [f64::NAN, 0.0, 0.0], ..properties() },
        MassProperties { inertia: Matrix3::new(1.0, 0.5, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0), ..properties() },
        MassProperties { inertia: Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, -0.1)), ..properties() },
    ];
    for properties in wrong {
        let error = cube().rigid(true).mass_properties(properties).build().unwrap_err();
        assert!(matches!(error, Error::Range(_)), "{properties:?}: {error}");
    }
    let mut rigid = cube().rigid(true).build().unwrap();
    let before = rigid.pose();
    let far = Isometry3::translation(1e16, 0.0, 0.0);
    assert!(rigid.set_rigid_motion(&far, zero, zero).is_err());
    assert!(rigid.set_rigid_motion(&still, Vector3::new(f64::INFINITY, 0.0, 0.0), zero).is_err());
    assert_eq!(rigid.pose(), before);
}

#[test]
fn body_without_an_inertia_does_not_turn() {
    let body =
        cube().rigid(true).mass_properties(MassProperties { inertia: Matrix3::zeros(), ..properties() });
    let plate = cube().translate([0.0, 0.5, 0.0]).build().unwrap();
    // It hits the plate with one edge.
    let body = body.translate([0.7, 1.6, 0.0]).velocity([0.0, -2.0, 0.0]).build().unwrap();
    let mut simulation = simulation(vec![plate, body]);
    simulation.steps(30);
    assert!(simulation.contacts().iter().any(|contact| contact.other == Touched::Body(1)));
    assert_eq!(simulation.bodies()[1].pose().rotation.angle(), 0.0);
}

/// A soft plate, and a rigid one beside it, with a rigid cube above each: they touch the soft one alone.
#[test]
fn body_that_touches_soft_bodies_alone_falls_through_the_others() {
    let touching = TouchingOptions { soft_only: true, ..TouchingOptions::default() };
    let above = |x: f64| cube().rigid(true).touching(touching.clone()).translate([x, 1.55, 0.0]);
    let below = |x: f64| cube().translate([x, 0.5, 0.0]);
    let bodies = [below(0.0), above(0.0), below(3.0).rigid(true), above(3.0)];
    let mut simulation = simulation(bodies.map(|body| body.build().unwrap()).into());
    simulation.steps(120);
    let height = |index: usize| simulation.bodies()[index].center_of_mass().y;
    assert!(height(1) > 1.3, "{}", height(1));
    // A second of free fall: y₀ - n (n + 1)/2 h² g.
    within(height(3), 1.55 - 120.0 * 121.0 / 2.0 / 14400.0 * 9.81, 1e-12);
    assert!((height(2) - 0.5).abs() < 0.01);
}

/// The middle one of three stacked cubes is removed: the upper one falls on the lower one. Their contacts follow.
#[test]
fn bodies_are_added_and_removed() {
    let at = |y: f64| cube().translate([0.0, y, 0.0]).build().unwrap();
    let mut simulation = simulation(vec![at(0.5), at(1.5)]);
    assert_eq!(simulation.add_body(at(2.5)), 2);
    simulation.steps(60);
    let pairs = |simulation: &Simulation| {
        let mut pairs: Vec<_> = simulation.contacts().iter().map(|c| (c.body, c.other)).collect();
        pairs.dedup();
        pairs.sort();
        pairs.dedup();
        pairs
    };
    let ground = (0, Touched::Collider(0));
    assert_eq!(pairs(&simulation), [(0, Touched::Body(1)), ground, (1, Touched::Body(2))]);
    let height = simulation.bodies()[2].center_of_mass().y;
    let removed = simulation.remove_body(1).unwrap();
    assert!((removed.center_of_mass().y - 1.5).abs() < 0.2);
    assert_eq!((simulation.bodies().len(), pairs(&simulation)), (2, vec![ground]));
    // The display of a body looks for the bodies near it.
    assert!(simulation.body(0).surface().positions.iter().all(|p| p.y < 1.1));
    simulation.steps(120);
    assert!(simulation.bodies()[1].center_of_mass().y < height - 0.8);
    assert_eq!(pairs(&simulation), [(0, Touched::Body(1)), ground]);
    // The removed body goes on elsewhere.
    let index = simulation.add_body(removed);
    simulation.steps(10);
    assert!(simulation.bodies()[index].center_of_mass().y.is_finite());
}

#[test]
fn linked_and_only_bodies_are_not_removed() {
    let at = |name: &str, y: f64| cube().name(name).translate([0.0, y, 0.0]).build().unwrap();
    let part = Selection::Box { min: [-1.0, 1.0, -1.0], max: [1.0, 1.1, 1.0] };
    let glue = Link { other: Some("lower".to_owned()), ..Link::new("upper", part) };
    let builder = Simulation::builder().body(at("other", 5.0)).body(at("lower", 0.5)).body(at("upper", 1.5));
    let mut simulation = builder.link(glue).dt(1.0 / 120.0).threads(1).build().unwrap();
    for index in [1, 2] {
        assert!(matches!(simulation.remove_body(index), Err(Error::LinkedBody { .. })));
    }
    // The link follows the indices.
    simulation.remove_body(0).unwrap();
    simulation.steps(60);
    let distance = simulation.bodies()[1].center_of_mass() - simulation.bodies()[0].center_of_mass();
    assert!((distance.norm() - 1.0).abs() < 0.05, "{distance:?}");
    let mut alone = self::simulation(vec![at("alone", 0.5)]);
    assert!(matches!(alone.remove_body(0), Err(Error::NoBody)));
}
