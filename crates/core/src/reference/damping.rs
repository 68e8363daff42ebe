//! Region damping by explicit sums.

use nalgebra::{Matrix3, Vector3};

use super::matching::{match_region, rest};
use super::{Regions, region, weights};
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
    assert_eq!(positions.len(), lattice.len(), "one position per lattice vertex");
    assert_eq!(velocities.len(), lattice.len(), "one velocity per lattice vertex");
    let weights = weights(lattice, half_width, regions);
    let mut means = vec![Vector3::zeros(); lattice.len()];
    for vertex in 0..lattice.len() as u32 {
        let fit = match_region(lattice, positions, &weights, region(lattice, vertex, half_width, regions));
        let arm = |i: u32| fit.rotation * (rest(lattice, i) - fit.rest_centroid);
        let mut momentum = Vector3::zeros();
        let mut angular = Vector3::zeros();
        let mut inertia = Matrix3::zeros();
        for &i in &fit.members {
            let (m, d, v) = (weights.of(i), arm(i), velocities[i as usize]);
            momentum += v * m;
            angular += d.cross(&v) * m;
            inertia += (Matrix3::identity() * d.norm_squared() - d * d.transpose()) * m;
        }
        let velocity = momentum / fit.mass;
        // Only a region of one vertex has no inertia, and no spin either.
        let spin = inertia.try_inverse().map_or(Vector3::zeros(), |inverse| inverse * angular);
        for &i in &fit.members {
            means[i as usize] += (velocity + spin.cross(&arm(i))) / weights.counts[i as usize] as f64;
        }
    }
    velocities.iter().zip(&means).map(|(v, mean)| v + (mean - v) * damping).collect()
}
