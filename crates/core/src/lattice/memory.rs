//! Memory that a lattice and its simulation take, and how much there is.

use super::error::LatticeError;

/// Bytes of simulation state and scratch for each lattice vertex.
const SIMULATION_BYTES: u64 = 200;

/// Bytes of the lattice itself for each lattice vertex, at most: indices, links and component of the vertex, its share of the cells
/// (no more than one a vertex) and of the look-up tables.
const LATTICE_BYTES: u64 = 50;

/// Limit where the machine does not tell its memory.
const FALLBACK_LIMIT: u64 = 4 << 30;

/// Bytes that `vertices` lattice vertices take, simulation included.
pub(crate) fn of_vertices(vertices: u64) -> u64 {
    vertices.saturating_mul(LATTICE_BYTES + SIMULATION_BYTES)
}

/// Vertices are numbered with 32 bits, one of which is left free, so that no limit may allow for more.
const MOST_VERTICES: u64 = 1 << 31;

/// The limit in bytes: what was asked for, or half of the machine's memory, or 4 GiB where that is not known.
pub(crate) fn limit(asked: Option<u64>) -> u64 {
    let limit = asked.unwrap_or_else(|| machine().map_or(FALLBACK_LIMIT, |bytes| bytes / 2));
    limit.min(of_vertices(MOST_VERTICES))
}

/// Refuses what needs more than the limit.
pub(crate) fn check(needed: u64, limit: u64, cell_size: f64) -> Result<(), LatticeError> {
    if needed > limit {
        return Err(LatticeError::TooMuchMemory { cell_size, needed, limit, fitting: None });
    }
    Ok(())
}

/// Bytes of memory that this process may use: the machine's, or what its control group is given where that is less.
fn machine() -> Option<u64> {
    let total = std::fs::read_to_string("/proc/meminfo").ok().and_then(|text| total_of_meminfo(&text))?;
    let group =
        std::fs::read_to_string("/sys/fs/cgroup/memory.max").ok().and_then(|text| text.trim().parse().ok());
    Some(group.map_or(total, |group: u64| group.min(total)))
}

/// The line `MemTotal:  24683504 kB` of Linux's `/proc/meminfo`, in bytes.
fn total_of_meminfo(text: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix("MemTotal:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    kibibytes.checked_mul(1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn meminfo_is_read() {
        assert_eq!(total_of_meminfo("MemTotal:       24683504 kB\nMemFree: 1 kB\n"), Some(24_683_504 * 1024));
        for strange in ["", "MemTotal: x kB", "MemTotal: 12", "MemTotal: 99999999999999999999 kB"] {
            assert_eq!(total_of_meminfo(strange), None);
        }
    }

    #[test]
    fn no_limit_allows_more_vertices_than_can_be_numbered() {
        assert_eq!(limit(Some(1000)), 1000);
        assert_eq!(limit(Some(u64::MAX)), of_vertices(MOST_VERTICES));
        assert!(limit(None) > 0);
    }
}
