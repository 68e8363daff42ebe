//! The surface mesh: errors, topology counts, volumes and normals.

use nalgebra::{Point3, Rotation3, Vector3};
use supple::{Interior, Mesh, MeshError, Scale, VertexNormals, vertex_normals};
use supple_tests::{mesh_of, unit_cube};

fn message(vertices: Vec<[f64; 3]>, faces: &[&[u32]]) -> String {
    Mesh::new(vertices, faces).unwrap_err().to_string()
}

#[test]
fn a_cube_is_closed_and_has_its_volume() {
    let cube = mesh_of(unit_cube());
    assert_eq!((cube.vertices().len(), cube.face_count(), cube.triangles().len()), (8, 6, 12));
    assert!(cube.is_closed());
    assert_eq!(cube.signed_volume(), 1.0);
    assert_eq!(cube.bounds(), (Point3::origin(), Point3::new(1.0, 1.0, 1.0)));
    let topology = cube.topology();
    assert_eq!((topology.edges, topology.boundary_edges, topology.non_manifold_edges), (12, 0, 0));
    assert_eq!(topology.components.len(), 1);
    assert!(topology.components[0].closed && topology.components[0].signed_volume == 1.0);
    assert_eq!(cube.triangles()[..2], [[0, 2, 3], [0, 3, 1]]);
}

#[test]
fn the_volume_is_exact_far_from_the_origin() {
    let (mut vertices, faces) = unit_cube();
    vertices.iter_mut().flatten().for_each(|coordinate| *coordinate += 1e9);
    assert_eq!(mesh_of((vertices, faces)).volume(), 1.0);
}

#[test]
fn reversed_faces_negate_the_signed_volume() {
    let (vertices, mut faces) = unit_cube();
    faces.iter_mut().for_each(|face| face.reverse());
    let flipped = mesh_of((vertices, faces));
    assert_eq!((flipped.signed_volume(), flipped.volume()), (-1.0, 1.0));
    assert!(flipped.is_closed() && flipped.topology().is_flipped());
}

#[test]
fn one_reversed_face_makes_a_surface_open() {
    let (vertices, mut faces) = unit_cube();
    faces[3].reverse();
    let mesh = mesh_of((vertices, faces));
    assert!(!mesh.is_closed());
    assert_eq!((mesh.topology().misoriented_edges, mesh.topology().open_edges), (4, 4));
    assert_eq!(mesh.topology().boundary_edges, 0);
}

#[test]
fn seams_are_welded_and_zeros_of_both_signs_are_equal() {
    let (vertices, faces) = unit_cube();
    // Each face has its own vertices; zeros are negative in every other face.
    let mut split = Vec::new();
    let mut own = Vec::new();
    for (index, face) in faces.iter().enumerate() {
        let sign = if index % 2 == 0 { -0.0 } else { 0.0 };
        own.push((0..4).map(|corner| (split.len() + corner) as u32).collect::<Vec<_>>());
        split.extend(face.iter().map(|&v| vertices[v as usize].map(|x| if x == 0.0 { sign } else { x })));
    }
    let mesh = mesh_of((split, own));
    assert!(mesh.is_closed());
    assert_eq!(mesh.topology().seam_vertices, 16);
    assert_eq!(mesh.volume(), 1.0);
    let positions: Vec<[f32; 3]> = mesh.vertices().iter().map(|v| (*v).cast::<f32>().into()).collect();
    let mut normals = vec![[0.0; 3]; 24];
    VertexNormals::new(&mesh).compute(&positions, &mut normals);
    for (a, &b) in mesh.weld().iter().enumerate() {
        assert_eq!(normals[a], normals[b as usize]);
    }
}

#[test]
fn an_open_box_has_four_boundary_edges() {
    let (vertices, mut faces) = unit_cube();
    faces.remove(1);
    let mesh = mesh_of((vertices, faces));
    assert!(!mesh.is_closed());
    assert_eq!((mesh.topology().boundary_edges, mesh.topology().open_edges), (4, 4));
    assert!(!mesh.topology().components[0].closed);
}

#[test]
fn duplicate_two_sided_degenerate_unused_and_non_manifold_elements_are_counted() {
    let vertices = vec![
        [0.0; 3],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.5, 0.5, 1.0],
        [9.0; 3],
        [1.0, 0.0, 0.0],
    ];
    let faces: &[&[u32]] = &[
        &[0, 1, 2, 3],
        &[3, 2, 1, 0], // the same face, reversed
        &[2, 3, 0, 1], // a duplicate
        &[0, 1, 4],    // another face on the edge 0-1
        &[0, 1, 1],    // two distinct corners
        &[1, 6, 2],    // two distinct positions
        &[2],          // one corner
        &[],           // no corner
        &[0, 6, 2, 3], // a duplicate through a welded vertex
    ];
    let mesh = Mesh::new(vertices, faces).unwrap();
    let topology = mesh.topology();
    assert_eq!((topology.duplicate_faces, topology.two_sided_faces), (2, 1));
    assert_eq!(topology.degenerate_faces, 4);
    assert_eq!(topology.unused_vertices, 1);
    assert_eq!(topology.seam_vertices, 1);
    // The quad counts once. One edge also has a triangle and both sides of a degenerate face, one only the latter.
    assert_eq!(topology.non_manifold_edges, 2);
    assert_eq!(mesh.face_count(), 9);
    assert_eq!(mesh.triangles().len(), 2 + 2 + 2 + 1 + 1 + 1 + 2);
    assert_eq!(mesh.bounds().1, Point3::new(1.0, 1.0, 1.0), "unused vertices are outside the bounds");
}

#[test]
fn a_two_sided_sheet_counts_once_and_encloses_nothing() {
    let vertices = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let mesh = Mesh::new(vertices, &[[0, 1, 2], [2, 1, 0]]).unwrap();
    assert!(!mesh.is_closed());
    assert_eq!((mesh.topology().boundary_edges, mesh.interior()), (3, Interior::Sheet));
    assert_eq!(mesh.volume(), 0.0);
}

#[test]
fn components_are_sorted_by_face_count_and_have_their_volumes() {
    let (mut vertices, mut faces) = unit_cube();
    let (more, tetrahedron) = (vertices.len() as u32, [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]);
    vertices.extend([[5.0, 0.0, 0.0], [6.0, 0.0, 0.0], [5.0, 1.0, 0.0], [5.0, 0.0, 1.0]]);
    faces.splice(0..0, tetrahedron.iter().map(|face| face.map(|corner| corner + more).to_vec()));
    let mesh = mesh_of((vertices, faces));
    let parts = &mesh.topology().components;
    assert_eq!(parts.iter().map(|part| (part.first_face, part.faces)).collect::<Vec<_>>(), [(4, 6), (0, 4)]);
    assert!(
        (parts[0].signed_volume - 1.0).abs() < 1e-13 && (parts[1].signed_volume - 1.0 / 6.0).abs() < 1e-13
    );
    assert!((mesh.signed_volume() - 7.0 / 6.0).abs() < 1e-13);
}

#[test]
fn errors_name_the_element_the_value_and_the_range() {
    let (vertices, _) = unit_cube();
    let triangle: &[u32] = &[0, 1, 2];
    let bad: &[u32] = &[3, 9, 1];
    assert_eq!(
        message(vertices.clone(), &[triangle, triangle, bad]),
        "face 2 refers to vertex 9 of 8 (counted from 0)"
    );
    for (value, axis) in [(f64::NAN, 0), (f64::NEG_INFINITY, 1), (1e39, 2)] {
        let mut vertices = vertices.clone();
        vertices[5][axis] = value;
        let text = message(vertices, &[triangle]);
        let expected = format!("vertex 5 (counted from 0) has {} = {value:?}", ["x", "y", "z"][axis]);
        assert!(text.starts_with(&expected), "{text}");
    }
    let none: &[&[u32]] = &[];
    for faces in [none, &[&[0, 1], &[2]], &[&[0, 1, 1, 0]]] {
        let text = message(vertices.clone(), faces);
        assert!(text.starts_with(&format!("no faces: {} given", faces.len())), "{text}");
    }
    let text = message(vec![[1.0, 2.0, 3.0], [4.0; 3], [1.0, 2.0, 3.0], [1.0, 2.0, 3.0]], &[&[0, 2, 3]]);
    assert_eq!(text, "no extent: all 3 vertices of the faces lie at (1, 2, 3)");
    assert!(matches!(mesh_of(unit_cube()).scaled(0.0), Err(MeshError::Scale(Scale::Uniform(0.0)))));
    assert!(matches!(
        mesh_of(unit_cube()).scaled(1e300),
        Err(MeshError::NotFinite { vertex: 1, axis: 'x', value: 1e300 })
    ));
}

#[test]
fn scaling_multiplies_bounds_and_volume() {
    let large = mesh_of(unit_cube()).scaled(3.0).unwrap();
    assert_eq!((large.volume(), large.bounds().1.x), (27.0, 3.0));
}

/// Computes area-weighted vertex normals in f64, triangle by triangle.
fn naive_normals(mesh: &Mesh, positions: &[[f32; 3]]) -> Vec<Vector3<f64>> {
    let mut sums = vec![Vector3::zeros(); positions.len()];
    for triangle in mesh.triangles() {
        let [a, b, c] = triangle.map(|v| Vector3::from(positions[v as usize]).cast::<f64>());
        for &corner in triangle {
            sums[mesh.weld()[corner as usize] as usize] += (b - a).cross(&(c - a));
        }
    }
    mesh.weld().iter().map(|&w| sums[w as usize].try_normalize(0.0).unwrap_or_default()).collect()
}

#[test]
fn vertex_normals_equal_the_naive_ones_at_any_scale() {
    let (vertices, faces) = unit_cube();
    let turn = Rotation3::from_euler_angles(0.3, -1.1, 2.0);
    let turned = vertices.iter().map(|v| (turn * Vector3::from(*v)).into()).collect::<Vec<[f64; 3]>>();
    for scale in [1.0, 1e-30, 1e-18, 1e-3, 1e12, 1e30] {
        let mesh = Mesh::new(turned.iter().map(|v| v.map(|x| x * scale)).collect(), &faces).unwrap();
        let positions: Vec<[f32; 3]> = mesh.vertices().iter().map(|v| (*v).cast::<f32>().into()).collect();
        let naive = naive_normals(&mesh, &positions);
        let mut prepared = vec![[9.0; 3]; positions.len()];
        let mut normals = VertexNormals::new(&mesh);
        normals.compute(&positions, &mut prepared);
        normals.compute(&positions, &mut prepared);
        let mut one_shot = vec![[9.0; 3]; positions.len()];
        vertex_normals(mesh.triangles(), &positions, mesh.weld(), &mut one_shot);
        for (k, naive) in naive.iter().enumerate() {
            assert!((Vector3::from(prepared[k]).cast() - naive).norm() < 1e-6, "scale {scale}");
            assert!((Vector3::from(one_shot[k]).cast() - naive).norm() < 1e-6, "scale {scale}");
        }
    }
}

#[test]
fn vertices_without_face_area_have_zero_normals() {
    let mesh = Mesh::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [7.0; 3]], &[[0, 1, 2]]).unwrap();
    let mut normals = [[9.0; 3]; 4];
    let positions = [[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [7.0; 3]];
    VertexNormals::new(&mesh).compute(&positions, &mut normals);
    assert_eq!(normals, [[0.0; 3]; 4]);
}
