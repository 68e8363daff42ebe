//! Estimates the memory that a lattice and its simulation need, and compares it with a limit.

use super::LatticeOptions;
use super::error::LatticeError;
use crate::voxel::Maxima;

/// Bytes of the simulation state and scratch per lattice vertex.
const SIMULATION_BYTES: u64 = 200;

/// Upper bound of the bytes of the lattice itself per lattice vertex: index, links and component of the
/// vertex, at most one cell, and entries of the look-up tables.
const LATTICE_BYTES: u64 = 50;

/// Returns the bytes that a lattice with `vertices` vertices and a simulation of it need.
pub(super) fn needed_bytes(vertices: u64) -> u64 {
    vertices.saturating_mul(LATTICE_BYTES + SIMULATION_BYTES)
}

/// Number of vertices of a lattice of one cell, less one. A lattice of n cells has at least n + 7 vertices: corner 0
/// of each cell, and the other corners of the cell that comes last in the order of (z, y, x).
const FURTHER_VERTICES: u64 = 7;

/// Returns the bytes that a lattice with `cells` cells and a simulation of it need at least.
pub(super) fn needed_bytes_of_cells(cells: u64) -> u64 {
    needed_bytes(cells.saturating_add(FURTHER_VERTICES))
}

/// Returns the numbers of cells and of faces in grid planes above which a lattice needs more than `limit` bytes.
///
/// Voxelizing needs less memory for a face than the simulation for a lattice vertex. The boundary of a set of cells has
/// more faces than vertices only if it has many tunnels, or coincident faces inside.
pub(super) fn maxima(limit: u64) -> Maxima {
    let vertices = limit / needed_bytes(1);
    Maxima { cells: vertices.saturating_sub(FURTHER_VERTICES), faces: vertices }
}

/// Largest number of vertices that any limit allows. Vertex indices have 32 bits, one of which stays unused.
const MAX_VERTICES: u64 = 1 << 31;

/// Returns the memory limit in bytes: `requested` or the default, and at most the memory for [`MAX_VERTICES`].
pub(super) fn limit(requested: Option<u64>) -> u64 {
    requested.unwrap_or(LatticeOptions::DEFAULT_MEMORY_LIMIT).min(needed_bytes(MAX_VERTICES))
}

/// Returns an error if `needed` exceeds `limit`, both in bytes. `cell_size`: for the error.
pub(super) fn check(needed: u64, limit: u64, cell_size: f64) -> Result<(), LatticeError> {
    if needed > limit {
        return Err(LatticeError::TooMuchMemory { cell_size, needed, limit, fitting: None });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_cells_or_faces_than_the_maxima_need_more_than_the_limit() {
        for limit in [2000, 2001, 12_345_678, limit(Some(u64::MAX))] {
            let Maxima { cells, faces } = maxima(limit);
            assert!(needed_bytes(faces) <= limit && needed_bytes(faces + 1) > limit);
            assert!(needed_bytes_of_cells(cells) <= limit && needed_bytes_of_cells(cells + 1) > limit);
        }
        assert_eq!(maxima(1999).cells, 0);
    }

    #[test]
    fn limit_is_capped_at_the_maximum_number_of_vertices() {
        assert_eq!(limit(Some(1000)), 1000);
        assert_eq!(limit(Some(u64::MAX)), needed_bytes(MAX_VERTICES));
        assert_eq!(limit(None), LatticeOptions::DEFAULT_MEMORY_LIMIT);
    }
}
