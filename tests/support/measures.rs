//! Measures of bodies and positions.

use nalgebra::{Point3, Rotation3, Vector3};
use supple::{Body, Lattice};

/// Returns the volume of each piece of the mesh of a body, with its vertices at other positions.
pub fn volumes_of_pieces(body: &Body, positions: &[Point3<f64>]) -> Vec<f64> {
    let pieces = body.piece_of_mesh_vertices().unwrap();
    let mut volumes = vec![0.0; body.pieces()];
    for triangle in body.mesh().unwrap().triangles() {
        let [a, b, c] = triangle.map(|vertex| positions[vertex as usize].coords);
        volumes[pieces[triangle[0] as usize] as usize] += a.dot(&b.cross(&c)) / 6.0;
    }
    volumes
}

/// Returns the root mean square of lengths.
pub fn rms(lengths: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = lengths.fold((0.0, 0.0), |(sum, count), x| (sum + x * x, count + 1.0));
    f64::sqrt(sum / count)
}

/// Returns the linear momentum of a body.
pub fn momentum(body: &Body) -> Vector3<f64> {
    body.masses().iter().zip(body.velocities()).map(|(m, v)| v * *m).sum()
}

/// Returns the rest positions of a lattice.
pub fn rest(lattice: &Lattice) -> Vec<Vector3<f64>> {
    (0..lattice.len() as u32).map(|v| lattice.rest_position(v).coords).collect()
}

/// Converts points to vectors.
pub fn coordinates(points: &[Point3<f64>]) -> Vec<Vector3<f64>> {
    points.iter().map(|p| p.coords).collect()
}

/// Converts vectors to points.
pub fn points(vectors: &[Vector3<f64>]) -> Vec<Point3<f64>> {
    vectors.iter().map(|&v| v.into()).collect()
}

/// Returns the largest difference of a coordinate.
pub fn worst(a: &[Vector3<f64>], b: &[Vector3<f64>]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).amax()).fold(0.0, f64::max)
}

/// Returns the greatest distance of a point from the one with its index.
pub fn greatest_distance(a: &[Point3<f64>], b: &[Point3<f64>]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
}

/// Returns the largest permitted difference of positions from the reference, in cells of edge 1: 1e-5, or 4
/// ulp of the largest coordinate `extent` if that is more.
pub fn tolerance(extent: f64) -> f64 {
    let ulp = 2.0_f64.powi(extent.log2().floor() as i32 - 23);
    (4.0 * ulp).max(1e-5)
}

/// Returns the rigid motion (R, c, d) with x ≈ R (x0 - c) + d that has the least mass-weighted squared error.
pub fn rigid_fit(
    masses: &[f64],
    from: &[Vector3<f64>],
    to: &[Vector3<f64>],
) -> (Rotation3<f64>, Vector3<f64>, Vector3<f64>) {
    let mass: f64 = masses.iter().sum();
    let mean = |x: &[Vector3<f64>]| x.iter().zip(masses).map(|(x, m)| x * *m).sum::<Vector3<f64>>() / mass;
    let (c, d) = (mean(from), mean(to));
    let a = from.iter().zip(to).zip(masses).map(|((x0, x), m)| (x - d) * (x0 - c).transpose() * *m).sum();
    (Rotation3::from_matrix_unchecked(supple::reference::rotation(&a)), c, d)
}

/// Asserts that `a` equals `b` to a relative accuracy.
pub fn within(a: f64, b: f64, relative: f64) {
    assert!((a - b).abs() <= relative * b.abs(), "{a} is not {b} to {relative:e}");
}
