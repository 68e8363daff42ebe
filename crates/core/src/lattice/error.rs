//! What can be wrong with the request for a lattice.

/// What can be wrong with the request for a lattice.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LatticeError {
    /// The cell size is zero, negative, infinite or not a number.
    #[error("the cell size is {0}; it must be a positive, finite length")]
    CellSize(f64),
    /// The origin has a coordinate that is infinite or not a number.
    #[error("the lattice origin is ({0}, {1}, {2}); its coordinates must be finite")]
    Origin(f64, f64, f64),
    /// Fewer lattice vertices were asked for than one cell has.
    #[error("{0} lattice vertices were asked for; the smallest lattice, one cell, has 8")]
    TooFewVertices(usize),
    /// No cell is occupied, so that there is nothing to simulate.
    #[error("no cell is occupied; a lattice needs at least one")]
    NoCells,
    /// A cell's grid index is out of range.
    #[error("cell {cell} has the grid index {index}; indices go from -1073741824 to 1073741824")]
    IndexRange {
        /// Number of the cell in the input.
        cell: usize,
        /// Its index that is out of range.
        index: i32,
    },
    /// The lattice, and what a simulation of it needs, would take more memory than allowed.
    #[error("{}", too_much_memory(*cell_size, *needed, *limit, *fitting))]
    TooMuchMemory {
        /// Cell size asked for, or estimated from the wished number of lattice vertices.
        cell_size: f64,
        /// Bytes that are needed, at least.
        needed: u64,
        /// Bytes that are allowed.
        limit: u64,
        /// A cell size that would fit; none where even the coarsest lattice does not, or where the cells were given.
        fitting: Option<f64>,
    },
}

fn too_much_memory(cell_size: f64, needed: u64, limit: u64, fitting: Option<f64>) -> String {
    let (needed, limit) = (readable(needed), readable(limit));
    let asked = format!(
        "a lattice with cells of size {cell_size:.4e} needs {needed} of memory, more than the limit of {limit}"
    );
    match fitting {
        Some(size) => format!("{asked}; a cell size of {size:.4e} would fit"),
        None => format!("{asked}; use fewer cells or raise the limit"),
    }
}

/// A number of bytes to read: three digits and a binary unit.
fn readable(bytes: u64) -> String {
    const UNITS: [&str; 7] = ["bytes", "KiB", "MiB", "GiB", "TiB", "PiB", "EiB"];
    let power = (bytes.max(1).ilog2() / 10) as usize;
    let value = bytes as f64 / (1u64 << (10 * power)) as f64;
    let digits = if power == 0 || value >= 100.0 { 0 } else { 1 };
    format!("{value:.digits$} {}", UNITS[power])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_is_told_in_readable_units() {
        assert_eq!(readable(0), "0 bytes");
        assert_eq!(readable(1023), "1023 bytes");
        assert_eq!(readable(1536), "1.5 KiB");
        assert_eq!(readable(300 << 30), "300 GiB");
        assert_eq!(readable(u64::MAX), "16.0 EiB");
    }
}
