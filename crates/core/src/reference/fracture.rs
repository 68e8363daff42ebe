//! The strain of joints, plainly.

use nalgebra::{Matrix3, Vector3};

use crate::lattice::{Joint, Lattice};

/// Returns the greatest principal strain of each joint that holds, at positions of the lattice vertices in the unit of
/// the cell size: √λ - 1 with the greatest eigenvalue λ of FᵀF. F is the mean of the gradients of the two cells of the
/// joint, and the gradient of a cell the mean of the derivatives at its corners. A body breaks at the strains of its
/// goal positions.
///
/// # Panics
///
/// If the number of positions is not the number of lattice vertices.
pub fn joint_strains(lattice: &Lattice, positions: &[Vector3<f64>]) -> Vec<(Joint, f64)> {
    assert_eq!(positions.len(), lattice.len(), "`positions` must match the lattice vertices");
    let gradient = |cell: u32| -> Matrix3<f64> {
        let corners = lattice.cell_corners(cell).map(|corner| positions[corner as usize]);
        Matrix3::from_fn(|row, axis| {
            let signed = |(k, corner): (usize, &Vector3<f64>)| {
                if k >> axis & 1 == 0 { -corner[row] } else { corner[row] }
            };
            corners.iter().enumerate().map(signed).sum::<f64>() / (4.0 * lattice.cell_size())
        })
    };
    let strain = |cells: [u32; 2]| {
        let [a, b] = cells.map(gradient);
        ((a + b) / 2.0).singular_values().max() - 1.0
    };
    let joints = lattice.joints().filter(|(joint, _)| !lattice.broken_joints().contains(joint));
    joints.map(|(joint, other)| (joint, strain([joint.cell, other]))).collect()
}
