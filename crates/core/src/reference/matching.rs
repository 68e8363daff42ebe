//! Lattice shape matching and region damping by explicit sums.

use nalgebra::{Matrix3, Vector3};

use super::{Naive, Regions};
use crate::lattice::Lattice;

/// The goal positions: for each vertex the mean, over the regions that hold it, of where their rigid motions put it
/// (Rivers and James 2007). With the weights m_i / n_i, `sum m_i g_i = sum m_i x_i`.
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

/// The rotation of the region of each vertex.
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

/// Velocities drawn towards the mean rigid velocity of the regions: `v_i + damping * (u_i - v_i)`, where u_i is the mean, over the
/// regions that hold i, of `v_r + omega_r x R_r (x0_i - c0_r)`.
///
/// As region damping of Rivers and James 2007, but with the rest shape turned by R in place of the current one: the lever arms
/// are those of the rest shape, and the inertia is constant but for the turn and never singular for `half_width >= 1`.
///
/// * `positions`, `velocities`: one per lattice vertex, in the units of the lattice's cell size.
/// * `damping`: 0 leaves the velocities as they are, 1 replaces them by u_i.
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
