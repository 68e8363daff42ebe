//! Lattice shape matching and region damping by explicit sums.

use nalgebra::{Matrix3, Vector3};

use super::{Naive, Regions};
use crate::lattice::Lattice;

/// Computes the goal positions (Rivers & James 2007, Eqs. (5) and (6)).
///
/// The goal of a vertex is the mean, over all regions that contain it, of its rest position moved by the
/// rigid motion of the region. With the weights m_i / n_i, `sum m_i g_i = sum m_i x_i`.
///
/// * `positions`: one per lattice vertex, in the units of the lattice's cell size.
/// * `half_width`: w of the regions, in cells.
///
/// # Panics
///
/// If the number of positions is not the number of lattice vertices.
pub fn goals(
    lattice: &Lattice,
    positions: &[Vector3<f64>],
    half_width: usize,
    regions: Regions,
) -> Vec<Vector3<f64>> {
    let naive = Naive::new(lattice, half_width, regions);
    naive.goals(&naive.motions(positions))
}

/// Computes the rotation of the region of each vertex.
///
/// # Panics
///
/// If the number of positions is not the number of lattice vertices.
pub fn rotations(
    lattice: &Lattice,
    positions: &[Vector3<f64>],
    half_width: usize,
    regions: Regions,
) -> Vec<Matrix3<f64>> {
    let motions = Naive::new(lattice, half_width, regions).motions(positions);
    motions.iter().map(|motion| motion.rotation).collect()
}

/// Damps velocities towards the mean rigid velocity of the regions: `v_i + damping * (u_i - v_i)`.
///
/// u_i is the mean, over the regions r that contain i, of `v_r + omega_r x R_r (x0_i - c0_r)`.
///
/// This is the region damping of Rivers & James 2007, section 5, except that the lever arms are those of the
/// rest shape rotated by R, not those of the current shape. The inertia of a region is then constant except
/// for its rotation, and is never singular for `half_width >= 1`.
///
/// * `positions`, `velocities`: one per lattice vertex, in the units of the lattice's cell size.
/// * `damping`: 0 keeps the velocities, 1 replaces them by u_i.
///
/// # Panics
///
/// If the number of positions or velocities is not the number of lattice vertices.
pub fn damped_velocities(
    lattice: &Lattice,
    positions: &[Vector3<f64>],
    velocities: &[Vector3<f64>],
    half_width: usize,
    regions: Regions,
    damping: f64,
) -> Vec<Vector3<f64>> {
    let naive = Naive::new(lattice, half_width, regions);
    naive.damped_velocities(&naive.motions(positions), velocities, damping)
}
