//! Embedding of points in the cells of a lattice.

use nalgebra::{Point3, Rotation3, Vector3};
use supple::internals::Embedding;
use supple::{Lattice, LatticeOptions, Mesh, Resolution};
use supple_tests::example;

fn bust(vertices: usize) -> (Mesh, Lattice) {
    let mesh = supple_io::obj::read(example("bust_parts.obj")).expect("the bust");
    let options = LatticeOptions { resolution: Resolution::Vertices(vertices), ..Default::default() };
    let lattice = Lattice::from_mesh(&mesh, &options).expect("its lattice");
    (mesh, lattice)
}

/// Returns the rest positions of the lattice vertices, in cells, transformed by `motion`.
fn moved(lattice: &Lattice, motion: impl Fn(Vector3<f64>) -> Vector3<f64>) -> Vec<[f32; 3]> {
    let indices = lattice.indices().iter();
    indices.map(|index| motion(Vector3::from(index.map(f64::from))).map(|x| x as f32).into()).collect()
}

/// Returns a point of the model frame in cells.
fn to_cells(lattice: &Lattice, point: &Point3<f64>) -> Vector3<f64> {
    (point - lattice.origin()) / lattice.cell_size()
}

#[test]
fn the_rest_pose_is_reproduced_to_f32_rounding() {
    for vertices in [300, 5000, 50000] {
        let (mesh, lattice) = bust(vertices);
        let embedding = Embedding::new(&lattice, mesh.vertices());
        assert_eq!(embedding.len(), mesh.vertices().len());
        let mut points = vec![[0.0; 3]; embedding.len()];
        embedding.interpolate(&moved(&lattice, |p| p), &mut points);
        for (point, vertex) in points.iter().zip(mesh.vertices()) {
            let expected = to_cells(&lattice, vertex);
            for a in 0..3 {
                let error = (f64::from(point[a]) - expected[a]).abs();
                assert!(error <= f64::from(f32::EPSILON) * expected[a].abs().max(1.0), "{error}");
            }
        }
    }
}

#[test]
fn affine_motions_are_interpolated_exactly_to_rounding() {
    let (mesh, lattice) = bust(2000);
    let embedding = Embedding::new(&lattice, mesh.vertices());
    let turn = Rotation3::new(Vector3::new(0.3, -2.0, 0.8)).matrix() * 1.7;
    let motion = |p: Vector3<f64>| turn * p + Vector3::new(4.0, 5.0, -6.0);
    let positions = moved(&lattice, motion);
    let mut points = vec![[0.0; 3]; embedding.len()];
    embedding.interpolate(&positions, &mut points);
    for (i, vertex) in mesh.vertices().iter().enumerate() {
        let expected = motion(to_cells(&lattice, vertex));
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
fn by_cell_yields_each_point_once_with_its_cell_and_corners() {
    let (mesh, lattice) = bust(1000);
    let embedding = Embedding::new(&lattice, mesh.vertices());
    let mut visits = vec![0; embedding.len()];
    let mut last = None;
    for group in embedding.by_cell() {
        assert!(last < Some(group.cell) && !group.points.is_empty() && group.points.is_sorted());
        assert_eq!(*group.corners, lattice.cell_corners(group.cell));
        last = Some(group.cell);
        for &point in group.points {
            visits[point as usize] += 1;
            assert_eq!(
                (embedding.cell(point as usize), embedding.corners(point as usize)),
                (group.cell, *group.corners)
            );
        }
    }
    assert!(visits.iter().all(|&count| count == 1));
}

#[test]
fn vertices_of_faces_lie_within_their_cells() {
    for vertices in [100, 1000, 20000] {
        let (mesh, lattice) = bust(vertices);
        let embedding = Embedding::new(&lattice, mesh.vertices());
        for &vertex in mesh.triangles().iter().flatten() {
            let local = embedding.local(vertex as usize);
            assert!(local.iter().all(|x| (-1e-6..=1.0 + 1e-6).contains(x)), "{local:?}");
            let corner = lattice.cells()[embedding.cell(vertex as usize) as usize];
            let point = to_cells(&lattice, &mesh.vertices()[vertex as usize]);
            for a in 0..3 {
                assert!((point[a] - f64::from(corner[a]) - f64::from(local[a])).abs() < 1e-7);
            }
        }
    }
}

#[test]
fn points_outside_all_cells_follow_the_nearest_cell() {
    let cells = [[0, 0, 0], [1, 0, 0], [2, 0, 0], [2, 1, 0]];
    let lattice = Lattice::from_cells(&cells, 2.0, Point3::new(1.0, 0.0, 0.0), true).expect("an L");
    let points = [[-99.0, 1.0, 1.0], [4.0, 900.0, -50.0], [2.5, 3.9, 1.0], [1e9, 1.0, 1.0]].map(Point3::from);
    let embedding = Embedding::new(&lattice, &points);
    let nearest = [[0, 0, 0], [2, 1, 0], [0, 0, 0], [2, 0, 0]];
    for (i, cell) in nearest.into_iter().enumerate() {
        assert_eq!(lattice.cells()[embedding.cell(i) as usize], cell, "point {i}");
        // In exact arithmetic the weights sum to 1. Each is a sum of four products, rounded by less than 4
        // ulp.
        let weights = embedding.weights(i).map(f64::from);
        let rounding = 4.0 * f64::from(f32::EPSILON) * weights.iter().map(|w| w.abs()).sum::<f64>();
        assert!((weights.iter().sum::<f64>() - 1.0).abs() <= rounding, "point {i}: {weights:?}");
    }
    let mut out = [[0.0; 3]; 4];
    embedding.interpolate(&moved(&lattice, |p| p + Vector3::new(0.0, 7.0, 0.0)), &mut out);
    assert_eq!(out[0], [-50.0, 7.5, 0.5]);
    assert_eq!(out[1], [1.5, 457.0, -25.0]);
    assert_eq!([out[2][0], out[2][2]], [0.75, 0.5]);
    assert!((out[2][1] - 8.95).abs() <= 8.95 * f32::EPSILON, "{:?}", out[2]);
    assert_eq!(out[3], [5e8, 7.5, 0.5]);
}

#[test]
fn non_finite_points_stay_non_finite_and_leave_other_points_alone() {
    let lattice = Lattice::from_cells(&[[0; 3]], 1.0, Point3::origin(), true).expect("a cell");
    let not_finite = [[f64::NAN, 0.5, 0.5], [f64::INFINITY, 0.0, 0.0], [0.5, f64::NEG_INFINITY, 0.5]];
    let finite = [0.25, 0.5, 0.75];
    let points = [not_finite[0], not_finite[1], finite, not_finite[2]].map(Point3::from);
    let embedding = Embedding::new(&lattice, &points);
    let mut out = [[0.0; 3]; 4];
    embedding.interpolate(&moved(&lattice, |p| p), &mut out);
    for i in [0, 1, 3] {
        let finite = |local: f32, given: f64| local.is_finite() == given.is_finite();
        assert!((0..3).all(|a| finite(embedding.local(i)[a], points[i][a])), "{:?}", embedding.local(i));
        assert!(out[i].iter().any(|x| !x.is_finite()), "{:?}", out[i]);
    }
    assert_eq!(out[2], finite.map(|x| x as f32));
    let empty = Embedding::new(&lattice, &[]);
    assert!(empty.is_empty() && empty.by_cell().len() == 0);
}
