//! What a ray meets, and what is nearest to a point.

use nalgebra::{Point3, Vector3};
use supple::{Body, Collider, Simulation, Touched};
use supple_tests::{block, lattice, mesh_of, plain_box};

/// A cube of edge 1 from the origin, a bare block of 2 x 2 x 2 cells at x = 10, and the ground at y = -1.
fn scene() -> Simulation {
    let cube = Body::builder(mesh_of(plain_box([0.0; 3], [1.0; 3]))).name("cube").build().unwrap();
    let bare = Body::from_lattice(lattice(&block([2; 3]))).name("bare").translate([10.0, 0.0, 0.0]);
    let ground = Collider::plane([0.0, -1.0, 0.0], [0.0, 1.0, 0.0]);
    let builder = Simulation::builder().body(cube).body(bare.build().unwrap()).collider(ground);
    builder.gravity([0.0; 3]).dt(0.01).build().unwrap()
}

#[test]
fn rays_meet_bodies_and_colliders_where_they_are() {
    let simulation = scene();
    let down = [0.0, -2.0, 0.0];
    let rays = [
        ([0.5, 3.0, 0.25], down),
        ([11.0, 5.0, 0.7], down),
        ([4.0, 5.0, 0.0], down),
        ([4.0, 5.0, 0.0], [0.0, 1.0, 0.0]),
        // From inside of the cube, which has no inside for a ray.
        ([0.5, 0.5, 0.5], [1.0, 0.0, 0.0]),
        ([0.0, -3.0, 0.0], [0.0, 0.0, 1.0]),
    ];
    let found = simulation.raycast(&rays, f64::INFINITY).unwrap();
    let cube = found[0].unwrap();
    assert_eq!((cube.of, cube.distance, cube.normal), (Touched::Body(0), 2.0, Vector3::y()));
    let face = simulation.body(0).mesh().unwrap().faces().nth(cube.face.unwrap() as usize).unwrap().to_vec();
    let corners = face.iter().map(|&corner| simulation.body(0).mesh().unwrap().vertices()[corner as usize]);
    assert!(corners.into_iter().all(|corner| corner.y == 1.0));
    let bare = found[1].unwrap();
    assert_eq!((bare.of, bare.face, bare.normal), (Touched::Body(1), None, Vector3::y()));
    assert!((bare.distance - 3.0).abs() < 1e-6);
    let ground = found[2].unwrap();
    assert_eq!((ground.of, ground.distance), (Touched::Collider(0), 6.0));
    assert!((ground.point - Point3::new(4.0, -1.0, 0.0)).norm() < 1e-12);
    assert!(found[3].is_none());
    let inside = found[4].unwrap();
    assert_eq!((inside.of, inside.distance), (Touched::Body(0), 0.5));
    assert_eq!((found[5].unwrap().of, found[5].unwrap().distance), (Touched::Collider(0), 0.0));
    assert!(simulation.raycast(&rays[..1], 1.5).unwrap()[0].is_none());
}

#[test]
fn the_nearest_points_are_on_the_surfaces_as_they_are_displayed() {
    let mut simulation = scene();
    let found = simulation.nearest(&[[0.5, 1.25, 0.5], [5.0, 2.0, 0.0], [0.5, 0.9, 0.5]]).unwrap();
    let above = found[0].unwrap();
    assert_eq!(above.of, Touched::Body(0));
    assert!((above.distance - 0.25).abs() < 1e-6 && (above.point - Point3::new(0.5, 1.0, 0.5)).norm() < 1e-6);
    assert_eq!((found[1].unwrap().of, found[1].unwrap().distance), (Touched::Collider(0), 3.0));
    // Inside of the cube the distance is not negative.
    assert!((found[2].unwrap().distance - 0.1).abs() < 1e-6);
    // The surface moves with the body.
    let moved: Vec<_> =
        simulation.body(0).positions().iter().map(|point| point + Vector3::new(0.0, 7.0, 0.0)).collect();
    simulation.body_mut(0).set_positions(&moved).unwrap();
    let found = simulation.nearest(&[[0.5, 9.0, 0.5]]).unwrap()[0].unwrap();
    assert!((found.distance - 1.0).abs() < 1e-6 && found.of == Touched::Body(0));
    let ray = simulation.raycast(&[([0.5, 20.0, 0.5], [0.0, -1.0, 0.0])], 100.0).unwrap()[0].unwrap();
    assert!((ray.distance - 12.0).abs() < 1e-5);
}

/// The sides of a mesh count alike, without the thickness that contacts give it; a closed one is solid.
#[test]
fn mesh_colliders_are_met_at_their_faces() {
    let square = supple::Mesh::new(
        vec![[-2.0, 0.0, -2.0], [-2.0, 0.0, 2.0], [2.0, 0.0, 2.0], [2.0, 0.0, -2.0]],
        &[[0, 1, 2, 3]],
    );
    let body = Body::from_lattice(lattice(&block([1; 3]))).translate([50.0, 0.0, 0.0]).build().unwrap();
    let solid = Collider::mesh(mesh_of(plain_box([10.0, 0.0, 0.0], [12.0, 2.0, 2.0]))).unwrap();
    let builder = Simulation::builder().body(body).collider(Collider::mesh(square.unwrap()).unwrap());
    let simulation = builder.collider(solid).gravity([0.0; 3]).dt(0.01).build().unwrap();
    let rays = [
        ([0.3, 1.0, 0.2], [0.0, -1.0, 0.0]),
        ([0.3, -1.0, 0.2], [0.0, 1.0, 0.0]),
        ([11.0, 5.0, 1.0], [0.0, -1.0, 0.0]),
        ([11.0, 1.5, 1.0], [0.0, -1.0, 0.0]),
    ];
    let found = simulation.raycast(&rays, f64::INFINITY).unwrap();
    let found: Vec<_> = found
        .into_iter()
        .map(|found| found.unwrap())
        .map(|hit| (hit.of, hit.distance, hit.normal.y))
        .collect();
    let expected = [
        (Touched::Collider(0), 1.0, 1.0),
        (Touched::Collider(0), 1.0, -1.0),
        (Touched::Collider(1), 3.0, 1.0),
        (Touched::Collider(1), 0.0, 1.0),
    ];
    for (found, expected) in found.iter().zip(expected) {
        assert_eq!(found.0, expected.0);
        assert!((found.1 - expected.1).abs() < 1e-9 && (found.2 - expected.2).abs() < 1e-9, "{found:?}");
    }
    let nearest = simulation.nearest(&[[0.0, 1.0, 0.0], [11.0, 1.9, 1.0]]).unwrap();
    assert!((nearest[0].unwrap().distance - 1.0).abs() < 1e-9);
    assert!((nearest[1].unwrap().distance - 0.1).abs() < 1e-9);
    assert!(simulation.nearest(&[[1e300, 0.0, 0.0]]).is_err());
}

#[test]
fn rays_without_direction_and_numbers_that_are_not_finite_are_errors() {
    let simulation = scene();
    let far = f64::INFINITY;
    let error = simulation.raycast(&[([0.0; 3], [0.0; 3])], far).unwrap_err().to_string();
    assert!(error.contains("direction"), "{error}");
    assert!(simulation.raycast(&[([f64::NAN, 0.0, 0.0], [1.0; 3])], far).is_err());
    assert!(simulation.raycast(&[([0.0; 3], [1.0; 3])], -1.0).is_err());
    assert!(simulation.raycast(&[([0.0; 3], [1.0; 3])], f64::NAN).is_err());
    assert!(simulation.nearest(&[[0.0, f64::INFINITY, 0.0]]).is_err());
    // Directions of extreme lengths are directions.
    for length in [1e-300, 1e300] {
        let found = simulation.raycast(&[([0.5, 3.0, 0.5], [0.0, -length, 0.0])], far).unwrap()[0].unwrap();
        assert_eq!(found.distance, 2.0);
    }
}
