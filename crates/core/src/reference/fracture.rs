//! The strain of joints, plainly.

use nalgebra::Matrix3;

use super::RegionMotion;
use crate::lattice::{Joint, Lattice};

/// Returns the greatest principal strain of each joint that holds, at which a body breaks: √λ - 1 with the greatest
/// eigenvalue λ of FᵀF. F is the mean over the four corners of the joint of the deformation gradients of the regions
/// around them, relative to their plastic shapes: F S⁻¹. `motions` has the motion of the region around each lattice
/// vertex.
///
/// # Panics
///
/// If the number of motions is not the number of lattice vertices.
pub fn joint_strains(lattice: &Lattice, motions: &[RegionMotion]) -> Vec<(Joint, f64)> {
    assert_eq!(motions.len(), lattice.len(), "`motions` must match the lattice vertices");
    let strain = |joint: Joint| {
        let gradient = |corner: u32| {
            let RegionMotion { gradient, shape, .. } = &motions[corner as usize];
            gradient * shape.try_inverse().unwrap_or_else(Matrix3::identity)
        };
        let sum: Matrix3<f64> = lattice.joint_corners(joint).into_iter().map(gradient).sum();
        (sum / 4.0).singular_values().max() - 1.0
    };
    let joints = lattice.joints().map(|(joint, _)| joint);
    joints.filter(|joint| !lattice.is_broken(*joint)).map(|joint| (joint, strain(joint))).collect()
}
