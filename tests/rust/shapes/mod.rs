//! Shapes and measurements that several tests of the volume share.

// Each test program uses its own part of these.
#![allow(dead_code)]

use nalgebra::{Point3, Vector3};
use supple::internals::{Correction, CorrectionWorkspace, Embedding, ExternalForce};
use supple::{ComponentReport, Lattice, LatticeOptions, Mesh, Resolution};

/// No rotation.
pub(crate) const UPRIGHT: [f32; 4] = [0.0, 0.0, 0.0, 1.0];

/// All cells of a box, from its lowest index on.
pub(crate) fn block(low: [i32; 3], size: [i32; 3]) -> Vec<[i32; 3]> {
    let [nx, ny, nz] = size;
    (0..nx * ny * nz).map(|i| [low[0] + i % nx, low[1] + i / nx % ny, low[2] + i / nx / ny]).collect()
}

/// Cells of edge one; parts that float apart stay apart.
pub(crate) fn lattice(cells: &[[i32; 3]]) -> Lattice {
    Lattice::from_cells(cells, 1.0, Point3::origin(), false).expect("cells make a lattice")
}

/// A sphere: the faces of a cube of `n` x `n` quads each, pushed out to a radius; its seams are separate vertices.
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

/// A sphere off the origin.
pub(crate) fn ball(radius: f64) -> Mesh {
    let (vertices, faces) = sphere([0.3, -0.2, 0.1], radius, 12);
    Mesh::new(vertices, &faces).expect("a sphere is a mesh")
}

/// The lattice of a mesh, and where the mesh lies in it.
pub(crate) fn of_mesh(mesh: &Mesh, resolution: Resolution) -> (Lattice, Embedding) {
    let options = LatticeOptions { resolution, ..LatticeOptions::default() };
    let lattice = Lattice::from_mesh(mesh, &options).expect("the mesh has a lattice");
    let embedding = Embedding::new(&lattice, mesh.vertices());
    (lattice, embedding)
}

/// The lattice at rest under a map of positions, in cells.
pub(crate) fn posed(lattice: &Lattice, map: impl Fn([f32; 3]) -> [f32; 3]) -> Vec<[f32; 3]> {
    lattice.indices().iter().map(|index| map(index.map(|i| i as f32))).collect()
}

/// The volume of the surface as it is shown, in cubed units of length: embedded in single precision.
pub(crate) fn shown(mesh: &Mesh, lattice: &Lattice, embedding: &Embedding, positions: &[[f32; 3]]) -> f64 {
    let mut points = vec![[0.0_f32; 3]; mesh.vertices().len()];
    embedding.interpolate(positions, &mut points);
    let points: Vec<Vector3<f64>> = points.iter().map(|p| Vector3::from(p.map(f64::from))).collect();
    let center = points.iter().sum::<Vector3<f64>>() / points.len() as f64;
    let six_fold = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|i| points[i as usize] - center);
        a.dot(&b.cross(&c))
    };
    mesh.triangles().iter().map(six_fold).sum::<f64>() / 6.0 * lattice.cell_size().powi(3)
}

/// What the correction makes of a body that has not turned.
pub(crate) fn apply(
    correction: &Correction,
    deformed: &[[f32; 3]],
    pushes: &[ExternalForce],
) -> Vec<[f32; 3]> {
    apply_in(&mut CorrectionWorkspace::default(), correction, deformed, pushes).1
}

/// The same in a workspace of the caller's, with the reports.
pub(crate) fn apply_in(
    workspace: &mut CorrectionWorkspace,
    correction: &Correction,
    deformed: &[[f32; 3]],
    pushes: &[ExternalForce],
) -> (Vec<ComponentReport>, Vec<[f32; 3]>) {
    let mut corrected = vec![[f32::NAN; 3]; deformed.len()];
    let rotations = vec![UPRIGHT; deformed.len()];
    let reports = correction.apply(workspace, deformed, &rotations, pushes, &mut corrected);
    (reports.to_vec(), corrected)
}

/// Asserts that `a` is `b` to a relative accuracy.
pub(crate) fn within(a: f64, b: f64, relative: f64) {
    assert!((a - b).abs() <= relative * b.abs(), "{a} is not {b} to {relative:e}");
}
