//! Estimates the memory that a lattice and its simulation need, and determines the memory limit.

use super::error::LatticeError;
use crate::voxel::Maxima;

/// Bytes of the simulation state and scratch per lattice vertex.
const SIMULATION_BYTES: u64 = 200;

/// Upper bound of the bytes of the lattice itself per lattice vertex: index, links and component of the
/// vertex, at most one cell, and entries of the look-up tables.
const LATTICE_BYTES: u64 = 50;

/// Memory limit in bytes if the machine's memory is unknown: 4 GiB.
const FALLBACK_LIMIT: u64 = 4 << 30;

/// Returns the bytes that a lattice with `vertices` vertices and a simulation of it need.
pub(crate) fn needed_bytes(vertices: u64) -> u64 {
    vertices.saturating_mul(LATTICE_BYTES + SIMULATION_BYTES)
}

/// Number of vertices of a lattice of one cell, less one. A lattice of n cells has at least n + 7 vertices: corner 0
/// of each cell, and the other corners of the cell that comes last in the order of (z, y, x).
const FURTHER_VERTICES: u64 = 7;

/// Returns the bytes that a lattice with `cells` cells and a simulation of it need at least.
pub(crate) fn needed_bytes_of_cells(cells: u64) -> u64 {
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

/// Returns the memory limit in bytes: `requested`, or half of the machine's memory, or 4 GiB if the machine's
/// memory is unknown. It is at most the memory for [`MAX_VERTICES`].
pub(crate) fn limit(requested: Option<u64>) -> u64 {
    let limit = requested.unwrap_or_else(|| machine_memory().map_or(FALLBACK_LIMIT, |bytes| bytes / 2));
    limit.min(needed_bytes(MAX_VERTICES))
}

/// Returns an error if `needed` exceeds `limit`, both in bytes. `cell_size`: for the error.
pub(crate) fn check(needed: u64, limit: u64, cell_size: f64) -> Result<(), LatticeError> {
    if needed > limit {
        return Err(LatticeError::TooMuchMemory { cell_size, needed, limit, fitting: None });
    }
    Ok(())
}

/// Returns the bytes of memory that this process may use: the machine's memory, or the memory limit of the
/// process's control group if that is less.
fn machine_memory() -> Option<u64> {
    let total = std::fs::read_to_string("/proc/meminfo").ok().and_then(|text| total_of_meminfo(&text))?;
    let group =
        std::fs::read_to_string("/sys/fs/cgroup/memory.max").ok().and_then(|text| text.trim().parse().ok());
    Some(group.map_or(total, |group: u64| group.min(total)))
}

/// Parses the line `MemTotal:  24683504 kB` of Linux's `/proc/meminfo` and returns the memory in bytes.
fn total_of_meminfo(text: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix("MemTotal:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    kibibytes.checked_mul(1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn meminfo_total_is_parsed() {
        assert_eq!(total_of_meminfo("MemTotal:       24683504 kB\nMemFree: 1 kB\n"), Some(24_683_504 * 1024));
        for malformed in ["", "MemTotal: x kB", "MemTotal: 12", "MemTotal: 99999999999999999999 kB"] {
            assert_eq!(total_of_meminfo(malformed), None);
        }
    }

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
        assert!(limit(None) > 0);
    }
}
