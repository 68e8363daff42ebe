//! Finds the regions: the sets of lattice vertices for shape matching, one around each vertex.

use crate::lattice::Lattice;
use crate::matching::HalfWidth;
use crate::mesh::distinct;

/// The shape of a region around its vertex.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Regions {
    /// All vertices that are found by at most w links along z, then at most w links along y from each vertex
    /// found, then at most w links along x from each vertex found. The sums over all regions are then window
    /// sums along one axis at a time. w is the half-width.
    #[default]
    Staircase,
    /// All vertices within w steps, where a step leads to any vertex of a common cell (Rivers & James 2007).
    BreadthFirst,
}

/// Returns the vertices of the region around `vertex`, sorted, of windows of at least three vertices.
///
/// In a full box both shapes are the cube with `2 w + 1` vertices along each edge. They differ near concave
/// corners and gaps.
///
/// # Panics
///
/// If there is no such vertex, or if the half-width is 1/2: those regions belong to cells.
pub fn region(
    lattice: &Lattice,
    vertex: u32,
    half_width: impl Into<HalfWidth>,
    regions: Regions,
) -> Vec<u32> {
    let half_width = half_width.into();
    assert!(!half_width.is_cell(), "regions of half-width 1/2 are cells: see `Lattice::cell_corners`");
    let half_width = half_width.links();
    let mut members = match regions {
        Regions::Staircase => staircase(lattice, vertex, half_width),
        Regions::BreadthFirst => breadth_first(lattice, vertex, half_width),
    };
    members.sort_unstable();
    members
}

/// Returns the vertices of a region of shape [`Regions::Staircase`].
fn staircase(lattice: &Lattice, vertex: u32, half_width: usize) -> Vec<u32> {
    let mut members = vec![vertex];
    for axis in [2, 1, 0] {
        members = members.iter().flat_map(|&start| window(lattice, start, axis, half_width)).collect();
    }
    members
}

/// Returns the vertices within `half_width` links of `start` along an axis, in both directions.
fn window(lattice: &Lattice, start: u32, axis: usize, half_width: usize) -> Vec<u32> {
    let mut reached = vec![start];
    for direction in [2 * axis, 2 * axis + 1] {
        let mut vertex = start;
        for _ in 0..half_width {
            let Some(next) = lattice.neighbors(vertex)[direction] else { break };
            reached.push(next);
            vertex = next;
        }
    }
    reached
}

/// Returns the vertices of a region of shape [`Regions::BreadthFirst`].
fn breadth_first(lattice: &Lattice, vertex: u32, half_width: usize) -> Vec<u32> {
    let mut members = vec![vertex];
    let mut frontier = vec![vertex];
    for _ in 0..half_width {
        let mut next = distinct(frontier.iter().flat_map(|&v| cell_neighbors(lattice, v)));
        next.retain(|v| !members.contains(v));
        members.extend(&next);
        frontier = next;
    }
    members
}

/// Returns the vertices of all cells that have `vertex` as a corner.
///
/// In a full box these are the 26 neighbors and `vertex` itself. Some of them are repeated.
fn cell_neighbors(lattice: &Lattice, vertex: u32) -> Vec<u32> {
    let index = lattice.indices()[vertex as usize];
    let around = (0..8).map(|k| [index[0] - (k & 1), index[1] - (k >> 1 & 1), index[2] - (k >> 2 & 1)]);
    around.filter_map(|cell| lattice.cell_at(cell)).flat_map(|cell| lattice.cell_corners(cell)).collect()
}

/// Weights of the lattice vertices in the regions that contain them.
#[derive(Clone, Debug, PartialEq)]
pub struct Weights {
    /// Mass m_i of each vertex, in masses of a full cell; of a bare lattice it is the number of its occupied cells / 8.
    /// Shape `(n,)`.
    pub masses: Vec<f64>,
    /// Number n_i of regions that contain each vertex, at least 1. Shape `(n,)`.
    pub counts: Vec<usize>,
}

impl Weights {
    /// Returns m_i / n_i, the weight of a vertex in one region.
    pub fn of(&self, vertex: u32) -> f64 {
        self.masses[vertex as usize] / self.counts[vertex as usize] as f64
    }
}

/// Computes the mass of each vertex of a bare lattice and the number of regions that contain it.
pub fn weights(lattice: &Lattice, half_width: impl Into<HalfWidth>, regions: Regions) -> Weights {
    let half_width = half_width.into();
    let masses = lattice.occupied_cells().iter().map(|&cells| f64::from(cells) / 8.0).collect();
    if half_width.is_cell() {
        let counts = lattice.occupied_cells().iter().map(|&cells| cells.into()).collect();
        return Weights { masses, counts };
    }
    let mut counts = vec![0; lattice.len()];
    for vertex in 0..lattice.len() as u32 {
        for member in region(lattice, vertex, half_width, regions) {
            counts[member as usize] += 1;
        }
    }
    Weights { masses, counts }
}
