//! Computes lattice shape matching and region damping by explicit sums.

use nalgebra::{Matrix3, Vector3};

use super::{Naive, Regions};
use crate::lattice::Lattice;
use crate::matching::HalfWidth;

/// Computes the goal positions (Rivers & James 2007, Eqs. (5) and (6)).
///
/// Each region that contains a vertex moves the rest position of the vertex by the rigid motion of the
/// region. The goal position g_i of vertex i is the mean of the resulting positions. In a region, vertex i
/// has the weight m_i / n_i: its mass divided by the number of regions that contain it. With these weights,
/// `sum m_i g_i = sum m_i x_i`, where x_i are the positions.
///
/// * `positions`: one per lattice vertex, in the unit of the lattice's cell size.
/// * `half_width`: half-width of the regions, in cells: 0.5, so that each region is a cell, or a whole number.
///
/// # Panics
///
/// If the number of positions is not the number of lattice vertices.
pub fn goals(
    lattice: &Lattice,
    positions: &[Vector3<f64>],
    half_width: impl Into<HalfWidth>,
    regions: Regions,
) -> Vec<Vector3<f64>> {
    let naive = Naive::new(lattice, half_width, regions);
    naive.goals(&naive.motions(positions))
}

/// Computes the rotation of each region: of each vertex, or of each cell if the half-width is 1/2.
///
/// # Panics
///
/// If the number of positions is not the number of lattice vertices.
pub fn rotations(
    lattice: &Lattice,
    positions: &[Vector3<f64>],
    half_width: impl Into<HalfWidth>,
    regions: Regions,
) -> Vec<Matrix3<f64>> {
    let motions = Naive::new(lattice, half_width, regions).motions(positions);
    motions.iter().map(|motion| motion.rotation).collect()
}

/// Returns the damped velocities `v_i + damping * (u_i - v_i)`, where u_i is the mean rigid velocity of the
/// regions that contain vertex i.
///
/// u_i is the mean of `v_r + omega_r × R_r (x0_i - c0_r)` over the regions r that contain i. Here v_r and
/// omega_r are the velocity and the angular velocity of the region, R_r its rotation, x0_i the rest position
/// of the vertex, and c0_r the weighted mean of the rest positions of the region.
///
/// This is the region damping of Rivers & James 2007, section 5, except for the lever arms: they are the
/// lever arms in the rest shape rotated by R_r, not the lever arms in the current shape. The inertia of a
/// region is then constant except for its rotation, and is never singular.
///
/// * `positions`, `velocities`: one per lattice vertex, in the unit of the lattice's cell size.
/// * `damping`: 0 keeps the velocities, 1 replaces them by u_i.
///
/// # Panics
///
/// If the number of positions or velocities is not the number of lattice vertices.
pub fn damped_velocities(
    lattice: &Lattice,
    positions: &[Vector3<f64>],
    velocities: &[Vector3<f64>],
    half_width: impl Into<HalfWidth>,
    regions: Regions,
    damping: f64,
) -> Vec<Vector3<f64>> {
    let naive = Naive::new(lattice, half_width, regions);
    naive.damped_velocities(&naive.motions(positions), velocities, damping)
}
