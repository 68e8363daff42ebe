//! Volume corrections of posed lattices.

use nalgebra::Vector3;
use supple::internals::{Correction, CorrectionWorkspace, Embedding, ExternalForce};
use supple::{ComponentReport, Lattice, LatticeOptions, Mesh, Resolution};

/// The identity quaternion, as x, y, z, w.
pub const UNROTATED: [f32; 4] = [0.0, 0.0, 0.0, 1.0];

/// Returns the lattice of a mesh and the embedding of the mesh in it.
pub fn of_mesh(mesh: &Mesh, resolution: Resolution) -> (Lattice, Embedding) {
    let options = LatticeOptions { resolution, ..LatticeOptions::default() };
    let lattice = Lattice::from_mesh(mesh, &options).expect("the mesh has a lattice");
    let embedding = Embedding::new(&lattice, mesh.vertices());
    (lattice, embedding)
}

/// Returns the rest positions of the lattice vertices, in cells, transformed by `map`.
pub fn posed(lattice: &Lattice, map: impl Fn([f32; 3]) -> [f32; 3]) -> Vec<[f32; 3]> {
    lattice.indices().iter().map(|index| map(index.map(|i| i as f32))).collect()
}

/// Returns the volume of the mesh as deformed by lattice `positions` (in cells), in cubed units of length.
pub fn surface_volume(mesh: &Mesh, lattice: &Lattice, embedding: &Embedding, positions: &[[f32; 3]]) -> f64 {
    let mut points = vec![[0.0_f32; 3]; mesh.vertices().len()];
    embedding.interpolate(positions, &mut points);
    let points: Vec<Vector3<f64>> = points.iter().map(|p| Vector3::from(p.map(f64::from))).collect();
    enclosed_volume(mesh, &points) * lattice.cell_size().powi(3)
}

/// Returns the volume that the triangles of a mesh enclose with its vertices at `points`.
pub fn enclosed_volume(mesh: &Mesh, points: &[Vector3<f64>]) -> f64 {
    let center = points.iter().sum::<Vector3<f64>>() / points.len() as f64;
    let six_times_volume = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|i| points[i as usize] - center);
        a.dot(&b.cross(&c))
    };
    mesh.triangles().iter().map(six_times_volume).sum::<f64>() / 6.0
}

/// Returns the corrected positions of an unrotated body.
pub fn apply(correction: &Correction, deformed: &[[f32; 3]], forces: &[ExternalForce]) -> Vec<[f32; 3]> {
    apply_in(&mut CorrectionWorkspace::default(), correction, deformed, forces).1
}

/// Returns the reports and the corrected positions of an unrotated body. The workspace is the caller's.
pub fn apply_in(
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
