//! Lattice shape matching by explicit sums.

use nalgebra::{Matrix3, Vector3};

use super::{Regions, region, rotation};
use crate::lattice::Lattice;

/// What each lattice vertex counts in the regions that hold it.
#[derive(Clone, Debug, PartialEq)]
pub struct Weights {
    /// Mass m_i of each vertex, in masses of a full cell: its occupied cells / 8. Shape `(n,)`.
    pub masses: Vec<f64>,
    /// Number n_i of regions that hold each vertex, at least 1. Shape `(n,)`.
    pub counts: Vec<usize>,
}

impl Weights {
    /// m_i / n_i: what a vertex counts in one region.
    pub fn of(&self, vertex: u32) -> f64 {
        self.masses[vertex as usize] / self.counts[vertex as usize] as f64
    }
}

/// The masses, and in how many regions each vertex is.
pub fn weights(lattice: &Lattice, half_width: usize, regions: Regions) -> Weights {
    let masses = lattice.occupied_cells().iter().map(|&cells| f64::from(cells) / 8.0).collect();
    let mut counts = vec![0; lattice.len()];
    for vertex in 0..lattice.len() as u32 {
        for member in region(lattice, vertex, half_width, regions) {
            counts[member as usize] += 1;
        }
    }
    Weights { masses, counts }
}

/// One region and its best rigid motion from rest.
pub(super) struct Match {
    pub(super) members: Vec<u32>,
    pub(super) mass: f64,
    /// Weighted mean of the rest positions.
    pub(super) rest_centroid: Vector3<f64>,
    /// Weighted mean of the positions.
    pub(super) centroid: Vector3<f64>,
    pub(super) rotation: Matrix3<f64>,
}

/// Rest position of a vertex relative to the lattice's origin.
pub(super) fn rest(lattice: &Lattice, vertex: u32) -> Vector3<f64> {
    Vector3::from(lattice.indices()[vertex as usize].map(f64::from)) * lattice.cell_size()
}

/// Matches the rest shape of one region to the positions (Müller et al. 2005).
pub(super) fn match_region(
    lattice: &Lattice,
    positions: &[Vector3<f64>],
    weights: &Weights,
    members: Vec<u32>,
) -> Match {
    let mass: f64 = members.iter().map(|&i| weights.of(i)).sum();
    let mean = |value: &dyn Fn(u32) -> Vector3<f64>| -> Vector3<f64> {
        members.iter().map(|&i| value(i) * weights.of(i)).sum::<Vector3<f64>>() / mass
    };
    let rest_centroid = mean(&|i| rest(lattice, i));
    let centroid = mean(&|i| positions[i as usize]);
    let moments: Matrix3<f64> = members
        .iter()
        .map(|&i| {
            (positions[i as usize] - centroid)
                * (rest(lattice, i) - rest_centroid).transpose()
                * weights.of(i)
        })
        .sum();
    Match { members, mass, rest_centroid, centroid, rotation: rotation(&moments) }
}

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
    assert_eq!(positions.len(), lattice.len(), "one position per lattice vertex");
    let weights = weights(lattice, half_width, regions);
    let mut goals = vec![Vector3::zeros(); lattice.len()];
    for vertex in 0..lattice.len() as u32 {
        let members = region(lattice, vertex, half_width, regions);
        let fit = match_region(lattice, positions, &weights, members);
        for &i in &fit.members {
            let goal = fit.centroid + fit.rotation * (rest(lattice, i) - fit.rest_centroid);
            goals[i as usize] += goal / weights.counts[i as usize] as f64;
        }
    }
    goals
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
    assert_eq!(positions.len(), lattice.len(), "one position per lattice vertex");
    let weights = weights(lattice, half_width, regions);
    let fit =
        |vertex| match_region(lattice, positions, &weights, region(lattice, vertex, half_width, regions));
    (0..lattice.len() as u32).map(|vertex| fit(vertex).rotation).collect()
}
