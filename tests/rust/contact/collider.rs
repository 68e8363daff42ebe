//! Shapes of colliders: signed distances, normals, validation.

use nalgebra::{Point3, Vector3};
use proptest::prelude::*;
use supple::euler_degrees;
use supple::internals::Colliders;
use supple::{Collider, Key, Shape};

fn distance(shape: &Shape, point: [f64; 3]) -> f64 {
    shape.signed_distance(point).distance
}

#[test]
fn distances_and_normals_at_known_points() {
    let plane = Collider::plane([0.0, 1.0, 0.0], [0.0, 3.0, 0.0]).shape;
    let sphere = Collider::sphere([1.0, 0.0, 0.0], 2.0).shape;
    let cuboid = Collider::cuboid([0.0; 3], [1.0, 2.0, 3.0], [0.0; 3]).shape;
    let turned = Collider::cuboid([0.0; 3], [1.0, 2.0, 3.0], [0.0, 0.0, 90.0]).shape;
    let capsule = Collider::capsule([0.0; 3], [4.0, 0.0, 0.0], 0.5).shape;
    let known: [(&Shape, [f64; 3], f64, [f64; 3]); 14] = [
        (&plane, [7.0, -1.0, 2.0], -2.0, [0.0, 1.0, 0.0]),
        (&sphere, [1.0, 5.0, 0.0], 3.0, [0.0, 1.0, 0.0]),
        (&sphere, [1.0, 0.0, -0.5], -1.5, [0.0, 0.0, -1.0]),
        (&cuboid, [4.0, 6.0, 0.0], 5.0, [0.6, 0.8, 0.0]),
        (&cuboid, [0.0, 0.0, -4.0], 1.0, [0.0, 0.0, -1.0]),
        (&cuboid, [0.2, -1.9, 0.0], -0.1, [0.0, -1.0, 0.0]),
        (&cuboid, [-1.0, 0.0, 0.0], 0.0, [-1.0, 0.0, 0.0]),
        (&turned, [-3.0, 0.0, 0.0], 1.0, [-1.0, 0.0, 0.0]),
        (&turned, [0.0, 0.75, 0.0], -0.25, [0.0, 1.0, 0.0]),
        (&capsule, [2.0, 0.0, 1.0], 0.5, [0.0, 0.0, 1.0]),
        (&capsule, [7.0, 4.0, 0.0], 4.5, [0.6, 0.8, 0.0]),
        (&capsule, [-0.25, 0.0, 0.0], -0.25, [-1.0, 0.0, 0.0]),
        // Degenerate: the nearest point is not unique, and the implementation chooses this one.
        (&sphere, [1.0, 0.0, 0.0], -2.0, [1.0, 0.0, 0.0]),
        (&cuboid, [0.0, 0.0, 0.0], -1.0, [1.0, 0.0, 0.0]),
    ];
    for (shape, point, distance, normal) in known {
        let found = shape.signed_distance(point);
        assert!((found.distance - distance).abs() < 1e-15, "{shape:?} at {point:?}: {found:?}");
        assert!((found.normal - Vector3::from(normal)).norm() < 1e-15, "{shape:?} at {point:?}: {found:?}");
    }
}

#[test]
fn a_capsule_of_zero_length_is_a_sphere_and_its_axis_has_a_normal() {
    let point = Collider::capsule([1.0; 3], [1.0; 3], 2.0).shape;
    let sphere = Collider::sphere([1.0; 3], 2.0).shape;
    for p in [[1.0; 3], [3.0, -1.0, 0.5], [1.0, 1.0, 1.5]] {
        assert_eq!(point.signed_distance(p), sphere.signed_distance(p));
    }
    let capsule = Collider::capsule([0.0; 3], [0.0, 0.0, 4.0], 0.5).shape;
    let on_axis = capsule.signed_distance([0.0, 0.0, 1.0]);
    assert_eq!(on_axis.distance, -0.5);
    assert_eq!((on_axis.normal.norm(), on_axis.normal.z), (1.0, 0.0));
}

#[test]
fn invalid_colliders_are_errors_with_the_collider_the_value_and_the_range() {
    let good = Collider::sphere([0.0; 3], 1.0);
    let key = Key { time: 1.0, ..Key::default() };
    let wrong = [
        (Collider::sphere([0.0; 3], 0.0), "collider 1: radius is 0; it must be greater than 0"),
        (Collider::sphere([f64::NAN, 0.0, 0.0], 1.0), "collider 1: center is NaN; it must be finite"),
        (
            Collider::plane([0.0; 3], [0.0; 3]),
            "collider 1: the plane's normal is zero; give the direction of the free side",
        ),
        (
            Collider::cuboid([0.0; 3], [1.0, -1.0, 1.0], [0.0; 3]),
            "collider 1: half_extents is -1; it must be greater than 0",
        ),
        (
            Collider::cuboid([0.0; 3], [1.0; 3], [f64::INFINITY, 0.0, 0.0]),
            "collider 1: rotate is inf; it must be finite",
        ),
        (Collider::capsule([0.0; 3], [1.0; 3], -2.0), "collider 1: radius is -2; it must be greater than 0"),
        (
            Collider { friction: -0.1, ..good.clone() },
            "collider 1: friction is -0.1; its range is 0 and above",
        ),
        (Collider { friction: f64::NAN, ..good.clone() }, "collider 1: friction is NaN; it must be finite"),
        (
            Collider { restitution: 1.5, ..good.clone() },
            "collider 1: restitution is 1.5; its range is 0 to 1",
        ),
        (
            Collider { keys: vec![key, key], ..good.clone() },
            "collider 1: key 1 is at time 1, which is not after key 0 at 1; sort the keys by time",
        ),
    ];
    for (collider, message) in wrong {
        let error = Colliders::new(&[good.clone(), collider]).unwrap_err();
        assert_eq!(error.to_string(), message);
    }
    assert!(Colliders::new(&[]).unwrap().is_empty());
    let edge = Collider { friction: 0.0, restitution: 1.0, ..good };
    assert_eq!(edge.validate(), Ok(()));
}

fn shapes() -> impl Strategy<Value = Shape> {
    let three = |range: std::ops::Range<f64>| prop::array::uniform3(range);
    (three(-1.0..1.0), three(0.1..2.0), three(-180.0..180.0), 0..4).prop_map(
        |(center, size, rotate, kind)| {
            match kind {
                0 => Collider::plane(center, (euler_degrees(rotate) * Vector3::x()).into()),
                1 => Collider::sphere(center, size[0]),
                2 => Collider::cuboid(center, size, rotate),
                _ => Collider::capsule(center, size, size[1]),
            }
            .shape
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..Default::default() })]

    #[test]
    fn the_normal_points_from_the_surface_and_the_distance_is_1_lipschitz(
        shape in shapes(),
        p in prop::array::uniform3(-4.0..4.0_f64),
        q in prop::array::uniform3(-4.0..4.0_f64),
    ) {
        let here = shape.signed_distance(p);
        prop_assert!((here.normal.norm() - 1.0).abs() < 1e-12);
        let surface = Point3::from(p) - here.normal * here.distance;
        prop_assert!(distance(&shape, surface.into()).abs() < 1e-9);
        let apart = (Point3::from(p) - Point3::from(q)).norm();
        prop_assert!((here.distance - distance(&shape, q)).abs() <= apart * (1.0 + 1e-12));
    }
}

/// Contacts take no notice of such a point.
#[test]
fn a_point_that_is_not_a_number_has_no_distance() {
    let shapes = [
        Collider::plane([0.0; 3], [0.0, 1.0, 0.0]),
        Collider::sphere([0.0; 3], 1.0),
        Collider::cuboid([0.0; 3], [1.0; 3], [10.0, 20.0, 30.0]),
        Collider::capsule([0.0; 3], [1.0, 0.0, 0.0], 1.0),
        Collider::capsule([0.0; 3], [0.0; 3], 1.0),
    ];
    for Collider { shape, .. } in shapes {
        assert!(shape.signed_distance([f64::NAN; 3]).distance.is_nan(), "{shape:?}");
    }
}

#[test]
fn moving_colliders_have_their_pose_at_time_0() {
    let plane = Collider::plane([0.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    assert_eq!(plane.signed_distance_at(0.0).unwrap()([5.0, 2.0, 0.0]), 2.0);
    let key = |time, y, angle| Key { time, translate: [0.0, y, 0.0], rotate: [0.0, 0.0, angle] };
    for (keys, expected) in [
        (vec![key(1.0, 0.5, 0.0), key(2.0, 9.0, 0.0)], 1.5),
        (vec![key(-1.0, 0.0, 0.0), key(1.0, 1.0, 0.0)], 1.5),
        (vec![key(-2.0, 7.0, 0.0), key(-1.0, 1.0, 0.0)], 1.0),
        // A rotation by 90 degrees about z turns the normal to -x.
        (vec![key(0.0, 0.0, 90.0)], -5.0),
    ] {
        let moving = Collider { keys, ..plane.clone() };
        assert!(
            (moving.signed_distance_at(0.0).unwrap()([5.0, 2.0, 0.0]) - expected).abs() < 1e-12,
            "{moving:?}"
        );
    }
}
