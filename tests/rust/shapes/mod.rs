//! Meshes, lattices and measures that the tests of the volume correction share.
#![allow(dead_code, reason = "not every test program uses every item")]

use nalgebra::{Point3, Vector3};
use supple::internals::{Correction, CorrectionWorkspace, Embedding, ExternalForce};
use supple::{ComponentReport, Lattice, LatticeOptions, Mesh, Resolution};

/// The identity quaternion, as x, y, z, w.
pub(crate) const UNROTATED: [f32; 4] = [0.0, 0.0, 0.0, 1.0];

/// Returns the cells of a box with its lowest cell at `low`.
pub(crate) fn block(low: [i32; 3], size: [i32; 3]) -> Vec<[i32; 3]> {
    let [nx, ny, nz] = size;
    (0..nx * ny * nz).map(|i| [low[0] + i % nx, low[1] + i / nx % ny, low[2] + i / nx / ny]).collect()
}

/// Returns a lattice of cells of edge 1 with its origin at zero, without bridges between floating parts.
pub(crate) fn lattice(cells: &[[i32; 3]]) -> Lattice {
    Lattice::from_cells(cells, 1.0, Point3::origin(), false).expect("cells make a lattice")
}

/// Returns a sphere: the six faces of a cube, of `n` x `n` quads each, projected to a radius. The six faces
/// share no vertices.
pub(crate) fn sphere(center: [f64; 3], radius: f64, n: i32) -> (Vec<[f64; 3]>, Vec<Vec<u32>>) {
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for side in 0..6 {
        let (axis, sign) = (side / 2, if side % 2 == 0 { -1 } else { 1 });
        let first = vertices.len() as u32;
        for k in 0..(n + 1) * (n + 1) {
            let mut p = [0; 3];
            p[axis] = sign * n;
            p[(axis + 1) % 3] = 2 * (k % (n + 1)) - n;
            p[(axis + 2) % 3] = 2 * (k / (n + 1)) - n;
            let p = p.map(f64::from);
            let length = (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]).sqrt();
            vertices.push(std::array::from_fn(|a| center[a] + radius * p[a] / length));
        }
        for k in 0..n * n {
            let a = first + (k / n * (n + 1) + k % n) as u32;
            let [b, c, d] = [a + 1, a + n as u32 + 2, a + n as u32 + 1];
            faces.push(if sign > 0 { vec![a, b, c, d] } else { vec![a, d, c, b] });
        }
    }
    (vertices, faces)
}

/// Returns a sphere whose center is not the origin.
pub(crate) fn ball(radius: f64) -> Mesh {
    let (vertices, faces) = sphere([0.3, -0.2, 0.1], radius, 12);
    Mesh::new(vertices, &faces).expect("a sphere is a mesh")
}

/// Returns the lattice of a mesh and the embedding of the mesh in it.
pub(crate) fn of_mesh(mesh: &Mesh, resolution: Resolution) -> (Lattice, Embedding) {
    let options = LatticeOptions { resolution, ..LatticeOptions::default() };
    let lattice = Lattice::from_mesh(mesh, &options).expect("the mesh has a lattice");
    let embedding = Embedding::new(&lattice, mesh.vertices());
    (lattice, embedding)
}

/// Returns the rest positions of the lattice vertices, in cells, transformed by `map`.
pub(crate) fn posed(lattice: &Lattice, map: impl Fn([f32; 3]) -> [f32; 3]) -> Vec<[f32; 3]> {
    lattice.indices().iter().map(|index| map(index.map(|i| i as f32))).collect()
}

/// Returns the volume of the mesh as deformed by lattice `positions` (in cells), in cubed units of length.
pub(crate) fn surface_volume(
    mesh: &Mesh,
    lattice: &Lattice,
    embedding: &Embedding,
    positions: &[[f32; 3]],
) -> f64 {
    let mut points = vec![[0.0_f32; 3]; mesh.vertices().len()];
    embedding.interpolate(positions, &mut points);
    let points: Vec<Vector3<f64>> = points.iter().map(|p| Vector3::from(p.map(f64::from))).collect();
    enclosed_volume(mesh, &points) * lattice.cell_size().powi(3)
}

/// Returns the volume that the triangles of a mesh enclose with its vertices at `points`.
pub(crate) fn enclosed_volume(mesh: &Mesh, points: &[Vector3<f64>]) -> f64 {
    let center = points.iter().sum::<Vector3<f64>>() / points.len() as f64;
    let six_times_volume = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|i| points[i as usize] - center);
        a.dot(&b.cross(&c))
    };
    mesh.triangles().iter().map(six_times_volume).sum::<f64>() / 6.0
}

/// Returns the corrected positions of an unrotated body.
pub(crate) fn apply(
    correction: &Correction,
    deformed: &[[f32; 3]],
    forces: &[ExternalForce],
) -> Vec<[f32; 3]> {
    apply_in(&mut CorrectionWorkspace::default(), correction, deformed, forces).1
}

/// Returns the reports and the corrected positions of an unrotated body. The workspace is the caller's.
pub(crate) fn apply_in(
    workspace: &mut CorrectionWorkspace,
    correction: &Correction,
    deformed: &[[f32; 3]],
    forces: &[ExternalForce],
) -> (Vec<ComponentReport>, Vec<[f32; 3]>) {
    let mut corrected = vec![[f32::NAN; 3]; deformed.len()];
    let rotations = vec![UNROTATED; deformed.len()];
    let reports = correction.apply(workspace, deformed, &rotations, forces, &mut corrected);
    (reports.to_vec(), corrected)
}

/// Asserts that `a` equals `b` to a relative accuracy.
pub(crate) fn within(a: f64, b: f64, relative: f64) {
    assert!((a - b).abs() <= relative * b.abs(), "{a} is not {b} to {relative:e}");
}
