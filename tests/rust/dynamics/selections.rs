//! Selections of parts of the mesh, and the pose of a body.

use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};
use supple::{Body, Mesh, Selection, Simulation, Zone};
use supple_tests::{block, cuboid, lattice};

fn bar() -> Mesh {
    let mesh = cuboid([4, 2, 2]);
    let end: Vec<u32> = (0..).zip(mesh.vertices()).filter(|(_, p)| p.x == 4.0).map(|(v, _)| v).collect();
    mesh.with_groups([("end".to_owned(), end), ("none".to_owned(), vec![])])
}

#[test]
fn groups_and_mesh_vertices_select_the_corners_of_their_cells() {
    let body = Body::builder(bar()).cell_size(1.0).build().unwrap();
    let by_shape =
        body.select(&Selection::Plane { point: [4.0, 0.0, 0.0], normal: [1.0, 0.0, 0.0] }).unwrap();
    assert_eq!(body.select(&Selection::Group("end".to_owned())).unwrap(), by_shape);
    let mesh = body.mesh().unwrap();
    let mut list = mesh.groups().iter().find(|(name, _)| name == "end").unwrap().1.clone();
    list.reverse();
    assert_eq!(body.select(&Selection::MeshVertices(list)).unwrap(), by_shape);
    let all = Selection::MeshVertices((0..mesh.vertices().len() as u32).collect());
    assert_eq!(body.select(&all).unwrap().len(), body.lattice().len());
}

#[test]
fn wrong_parts_of_a_mesh_are_errors_with_the_way_out() {
    let body = Body::builder(bar()).cell_size(1.0).build().unwrap();
    let error = |selection: Selection| body.select(&selection).unwrap_err().to_string();
    let vertices = body.mesh().unwrap().vertices().len();
    assert_eq!(
        error(Selection::MeshVertices(vec![0, 10_000])),
        format!("vertex 10000 is out of range: the mesh has {vertices} vertices, 0 to {}", vertices - 1)
    );
    assert!(
        error(Selection::Group("ends".to_owned())).contains(r#"no group "ends"; it has ["end", "none"]"#)
    );
    assert!(error(Selection::Group("none".to_owned())).contains("no group"));
    assert!(error(Selection::MeshVertices(vec![])).contains("empty"));
    let bare = Body::from_lattice(lattice(&block([2, 1, 1]))).build().unwrap();
    assert!(bare.select(&Selection::Group("end".to_owned())).unwrap_err().to_string().contains("no mesh"));
}

#[test]
fn a_zone_by_a_group_has_its_factor_on_the_cells_of_the_group() {
    let mut body = Body::builder(bar()).cell_size(1.0).youngs_modulus(1e5).build().unwrap();
    let selection = Selection::Group("end".to_owned());
    body.zone(&Zone::new(selection.clone(), 4.0)).unwrap();
    let selected = body.select(&selection).unwrap();
    for (vertex, factor) in (0..).zip(body.stiffness_factors().unwrap()) {
        assert_eq!(*factor, if selected.contains(&vertex) { 4.0 } else { 1.0 });
    }
}

#[test]
fn the_pose_of_a_body_is_its_placement_and_then_its_rigid_motion() {
    let body = Body::builder(bar())
        .cell_size(0.5)
        .youngs_modulus(1e7)
        .translate([3.0, -2.0, 100.0])
        .rotate([0.0, 90.0, 30.0])
        .spin([0.0, 1.2, 0.0]);
    let mut simulation =
        Simulation::builder().body(body.build().unwrap()).gravity([0.0; 3]).dt(1.0 / 240.0).build().unwrap();
    let error = |a: Isometry3<f64>, b: Isometry3<f64>| {
        (a.rotation.angle_to(&b.rotation), (a.translation.vector - b.translation.vector).norm())
    };
    let placed = simulation.bodies()[0].pose();
    let expected =
        supple::Placement { rotate: [0.0, 90.0, 30.0], translate: [3.0, -2.0, 100.0], ..Default::default() };
    let (angle, distance) = error(placed, expected.isometry());
    assert!(angle < 1e-6 && distance < 1e-5, "{angle} {distance}");
    let center = simulation.bodies()[0].center_of_mass();
    simulation.steps(240);
    let turn = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), 1.2);
    let about = |point: Point3<f64>| Isometry3::from_parts((point - turn * point).into(), turn);
    let (angle, distance) = error(simulation.bodies()[0].pose(), about(center) * placed);
    // The spin stretches the bar by centrifugal forces, so that it turns slightly slower.
    assert!(angle < 0.01 && distance < 0.05, "{angle} {distance}");
}
