//! Region damping by explicit sums.

use nalgebra::Vector3;

use super::{Naive, Regions};
use crate::lattice::Lattice;

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
