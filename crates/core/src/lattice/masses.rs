//! The masses of the lattice vertices, by the share of each cell that the mesh fills.

use std::ops::Deref;

use super::Lattice;
use super::shares::shares;
use crate::mesh::Mesh;

/// The masses of the vertices and cells of a lattice, in units of a full cell's mass. It is a slice of the masses of
/// the vertices.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Masses {
    /// Mass of each vertex, shape `(n,)`: an eighth of the filled shares of its cells.
    vertices: Vec<f32>,
    /// Filled share of each cell, times the factor of its density, shape `(m,)`; `None` if all are 1. See [`shares`].
    shares: Option<Vec<f32>>,
}

impl Masses {
    /// Computes the masses of a lattice that covers `mesh`.
    pub(crate) fn new(lattice: &Lattice, mesh: Option<&Mesh>) -> Self {
        match shares(lattice, mesh) {
            None => {
                lattice.occupied_cells.iter().map(|&cells| f32::from(cells) / 8.0).collect::<Vec<_>>().into()
            }
            Some(shares) => Self::of_shares(lattice, &shares),
        }
    }

    /// Computes the masses from the filled shares of the cells.
    pub(crate) fn of_shares(lattice: &Lattice, shares: &[f64]) -> Self {
        let is_full = shares.iter().all(|&share| share == 1.0);
        let vertices = masses_of_shares(lattice, shares);
        Self { vertices, shares: (!is_full).then(|| shares.iter().map(|&share| share as f32).collect()) }
    }

    /// Returns the masses with other masses of the vertices, for a lattice with the same cells.
    pub(crate) fn with_vertices(&self, vertices: Vec<f32>) -> Self {
        Self { vertices, shares: self.shares.clone() }
    }

    /// Returns the masses with another density: see [`dense_shares`].
    pub(crate) fn denser(&self, lattice: &Lattice, factors: &[f64]) -> Self {
        let cells = 0..lattice.cells.len() as u32;
        let shares = cells.map(|cell| self.share(cell).into()).collect();
        Self::of_shares(lattice, &dense_shares(lattice, shares, factors))
    }

    /// Returns the filled share of a cell, times the factor of its density.
    pub(crate) fn share(&self, cell: u32) -> f32 {
        self.shares.as_ref().map_or(1.0, |shares| shares[cell as usize])
    }

    /// Returns the memory in bytes.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&*self.vertices) + self.shares.as_ref().map_or(0, |shares| size_of_val(&**shares))
    }
}

/// The masses of full cells.
impl From<Vec<f32>> for Masses {
    fn from(vertices: Vec<f32>) -> Self {
        Self { vertices, shares: None }
    }
}

impl Deref for Masses {
    type Target = [f32];

    fn deref(&self) -> &[f32] {
        &self.vertices
    }
}

/// Returns the shares of cells times the factors of their density: the means of `factors`, one for each vertex, over their
/// corners.
pub(crate) fn dense_shares(lattice: &Lattice, mut shares: Vec<f64>, factors: &[f64]) -> Vec<f64> {
    for (share, corners) in shares.iter_mut().zip(lattice.corner_table().iter()) {
        *share *= corners.iter().map(|&corner| factors[corner as usize]).sum::<f64>() / 8.0;
    }
    shares
}

/// Returns the filled share of each cell, shape `(m,)`, rounded to multiples of [`SHARE_UNIT`]: see [`shares`].
/// The masses of vertices that break apart then have exactly the mass of the vertex before, in f32.
pub(crate) fn cell_shares(lattice: &Lattice, mesh: Option<&Mesh>) -> Vec<f64> {
    match shares(lattice, mesh) {
        None => vec![1.0; lattice.cells.len()],
        Some(shares) => shares.into_iter().map(|share| (share / SHARE_UNIT).round() * SHARE_UNIT).collect(),
    }
}

/// The unit of shares that break apart: an eighth of it is 2^-23, so that sums up to 1 are exact in f32.
const SHARE_UNIT: f64 = 1.0 / (1 << 20) as f64;

/// Computes the mass of each vertex from the filled share of each cell: see [`Masses`].
pub(crate) fn masses_of_shares(lattice: &Lattice, shares: &[f64]) -> Vec<f32> {
    let mut masses = vec![0.0; lattice.len()];
    for (corners, share) in lattice.corner_table().iter().zip(shares) {
        for &corner in corners {
            masses[corner as usize] += share / 8.0;
        }
    }
    masses.into_iter().map(|mass| mass as f32).collect()
}
