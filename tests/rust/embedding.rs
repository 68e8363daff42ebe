//! Points carried along by the cells of a lattice.

use nalgebra::{Point3, Rotation3, Vector3};
use supple::internals::Embedding;
use supple::{Lattice, LatticeOptions, Mesh, Resolution};

const BUST: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../examples/scenes/bust_parts.obj");

fn bust(vertices: usize) -> (Mesh, Lattice) {
    let mesh = supple_io::obj::read(BUST).expect("the bust");
    let options = LatticeOptions { resolution: Resolution::Vertices(vertices), ..Default::default() };
    let lattice = Lattice::from_mesh(&mesh, &options).expect("its lattice");
    (mesh, lattice)
}

/// Lattice vertices in cells, moved by a function of their rest position in cells.
fn moved(lattice: &Lattice, motion: impl Fn(Vector3<f64>) -> Vector3<f64>) -> Vec<[f32; 3]> {
    let indices = lattice.indices().iter();
    indices.map(|index| motion(Vector3::from(index.map(f64::from))).map(|x| x as f32).into()).collect()
}

fn place(lattice: &Lattice, point: &Point3<f64>) -> Vector3<f64> {
    (point - lattice.origin()) / lattice.cell_size()
}

#[test]
fn at_rest_the_mesh_is_itself_to_rounding() {
    for vertices in [300, 5000, 50000] {
        let (mesh, lattice) = bust(vertices);
        let embedding = Embedding::new(&lattice, mesh.vertices());
        assert_eq!(embedding.len(), mesh.vertices().len());
        let mut points = vec![[0.0; 3]; embedding.len()];
        embedding.interpolate(&moved(&lattice, |p| p), &mut points);
        for (point, vertex) in points.iter().zip(mesh.vertices()) {
            let expected = place(&lattice, vertex);
            for a in 0..3 {
                let error = (f64::from(point[a]) - expected[a]).abs();
                assert!(error <= f64::from(f32::EPSILON) * expected[a].abs().max(1.0), "{error}");
            }
        }
    }
}

#[test]
fn affine_motions_are_followed() {
    let (mesh, lattice) = bust(2000);
    let embedding = Embedding::new(&lattice, mesh.vertices());
    let turn = Rotation3::new(Vector3::new(0.3, -2.0, 0.8)).matrix() * 1.7;
    let motion = |p: Vector3<f64>| turn * p + Vector3::new(4.0, 5.0, -6.0);
    let positions = moved(&lattice, motion);
    let mut points = vec![[0.0; 3]; embedding.len()];
    embedding.interpolate(&positions, &mut points);
    for (i, vertex) in mesh.vertices().iter().enumerate() {
        let expected = motion(place(&lattice, vertex));
        let weighted: Vector3<f64> = (0..8)
            .map(|k| {
                let corner = positions[embedding.corners(i)[k] as usize].map(f64::from);
                Vector3::from(corner) * f64::from(embedding.weights(i)[k])
            })
            .sum();
        assert!((weighted - expected).amax() < 2e-5);
        assert!((Vector3::from(points[i].map(f64::from)) - expected).amax() < 1e-5);
    }
}

#[test]
fn points_are_grouped_by_cell() {
    let (mesh, lattice) = bust(1000);
    let embedding = Embedding::new(&lattice, mesh.vertices());
    let mut seen = vec![0; embedding.len()];
    let mut last = None;
    for group in embedding.by_cell() {
        assert!(last < Some(group.cell) && !group.points.is_empty() && group.points.is_sorted());
        assert_eq!(*group.corners, lattice.cell_corners(group.cell));
        last = Some(group.cell);
        for &point in group.points {
            seen[point as usize] += 1;
            assert_eq!(
                (embedding.cell(point as usize), embedding.corners(point as usize)),
                (group.cell, *group.corners)
            );
        }
    }
    assert!(seen.iter().all(|&count| count == 1));
}

#[test]
fn every_vertex_of_a_face_is_in_its_cell() {
    for vertices in [100, 1000, 20000] {
        let (mesh, lattice) = bust(vertices);
        let embedding = Embedding::new(&lattice, mesh.vertices());
        for &vertex in mesh.triangles().iter().flatten() {
            let local = embedding.local(vertex as usize);
            assert!(local.iter().all(|x| (-1e-6..=1.0 + 1e-6).contains(x)), "{local:?}");
            let corner = lattice.cells()[embedding.cell(vertex as usize) as usize];
            let place = place(&lattice, &mesh.vertices()[vertex as usize]);
            for a in 0..3 {
                assert!((place[a] - f64::from(corner[a]) - f64::from(local[a])).abs() < 1e-7);
            }
        }
    }
}

#[test]
fn stray_points_follow_the_nearest_cell() {
    let cells = [[0, 0, 0], [1, 0, 0], [2, 0, 0], [2, 1, 0]];
    let lattice = Lattice::from_cells(&cells, 2.0, Point3::new(1.0, 0.0, 0.0), true).expect("an L");
    let points = [[-99.0, 1.0, 1.0], [4.0, 900.0, -50.0], [2.5, 3.9, 1.0], [1e9, 1.0, 1.0]].map(Point3::from);
    let embedding = Embedding::new(&lattice, &points);
    let nearest = [[0, 0, 0], [2, 1, 0], [0, 0, 0], [2, 0, 0]];
    for (i, cell) in nearest.into_iter().enumerate() {
        assert_eq!(lattice.cells()[embedding.cell(i) as usize], cell, "point {i}");
        assert!((embedding.weights(i).iter().sum::<f32>() - 1.0).abs() < 1e-3 || i == 3);
    }
    let mut out = [[0.0; 3]; 4];
    embedding.interpolate(&moved(&lattice, |p| p + Vector3::new(0.0, 7.0, 0.0)), &mut out);
    assert_eq!(out[0], [-50.0, 7.5, 0.5]);
    assert_eq!(out[1], [1.5, 457.0, -25.0]);
}

#[test]
fn points_that_are_not_finite_do_no_harm() {
    let lattice = Lattice::from_cells(&[[0; 3]], 1.0, Point3::origin(), true).expect("a cell");
    let points =
        [[f64::NAN, 0.5, 0.5], [f64::INFINITY, 0.0, 0.0], [0.5, f64::NEG_INFINITY, 0.5]].map(Point3::from);
    let embedding = Embedding::new(&lattice, &points);
    let mut out = [[0.0; 3]; 3];
    embedding.interpolate(&moved(&lattice, |p| p), &mut out);
    assert!(out.iter().all(|p| p.iter().any(|x| !x.is_finite())));
    let none = Embedding::new(&lattice, &[]);
    assert!(none.is_empty() && none.by_cell().len() == 0);
}
