//! Errors of the construction of a lattice.

use crate::mesh::Scale;

/// An error of the construction of a lattice.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LatticeError {
    /// The cell size is zero, negative, infinite or NaN.
    #[error("the cell size is {0}; it must be a positive, finite length")]
    CellSize(f64),
    /// A bare lattice is scaled differently along its axes.
    #[error("the scale is {0}; cells are cubes, so that a lattice is scaled by one factor above 0")]
    Scale(Scale),
    /// The origin has a coordinate that is infinite or NaN.
    #[error("the lattice origin is ({0}, {1}, {2}); its coordinates must be finite")]
    Origin(f64, f64, f64),
    /// Fewer than 8 lattice vertices are requested: one cell has 8.
    #[error("the requested number of lattice vertices is {0}; it must be at least 8 (one cell)")]
    TooFewVertices(usize),
    /// No cell is occupied, so there is nothing to simulate.
    #[error("no cell is occupied; a lattice needs at least one")]
    NoCells,
    /// A body cannot be built from the lattice of a broken body.
    #[error(
        "the lattice is that of a broken body; build the body from its mesh, or restore a state of the broken body"
    )]
    Broken,
    /// A cell's grid index is out of range.
    #[error("cell {cell} has the grid index {index}; it must be between -1073741824 and 1073741824")]
    IndexRange {
        /// Index of the cell in the input, from 0.
        cell: usize,
        /// The grid index that is out of range.
        index: i32,
    },
    /// The lattice and a simulation of it would need more memory than allowed.
    #[error("{}", too_much_memory(*cell_size, *needed, *limit, *fitting))]
    TooMuchMemory {
        /// Requested cell size, or the cell size estimated from the requested number of lattice vertices.
        cell_size: f64,
        /// Lower bound of the memory needed, in bytes. `u64::MAX` stands for a grid with more than 2^30 cells
        /// along an axis.
        needed: u64,
        /// Memory limit, in bytes.
        limit: u64,
        /// A cell size that would fit. `None` if even a single cell does not fit, or if the lattice is built
        /// from given cells.
        fitting: Option<f64>,
    },
}

/// Formats [`LatticeError::TooMuchMemory`].
fn too_much_memory(cell_size: f64, needed: u64, limit: u64, fitting: Option<f64>) -> String {
    let (needed, limit) = (readable(needed), readable(limit));
    // The search for cells ends at the limit, so that the lower bound is often equal to it.
    let needs = if needed == limit {
        format!("needs more memory than the limit of {limit}")
    } else {
        format!("needs at least {needed} of memory, more than the limit of {limit}")
    };
    let message = format!("a lattice with cells of size {cell_size:.4e} {needs}");
    match fitting {
        Some(size) => format!("{message}; a cell size of {size:.4e} would fit"),
        None => format!("{message}; use fewer cells or raise the limit"),
    }
}

/// Formats a number of bytes with a binary unit, and with one decimal if the number of units is below 100.
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
    fn a_lower_bound_near_the_limit_is_not_printed() {
        let near = too_much_memory(0.5, (1 << 30) + 1, 1 << 30, None);
        assert!(near.starts_with(
            "a lattice with cells of size 5.0000e-1 needs more memory than the limit of 1.0 GiB;"
        ));
        let far = too_much_memory(0.5, 3 << 30, 1 << 30, Some(2.0));
        assert!(far.contains(
            "needs at least 3.0 GiB of memory, more than the limit of 1.0 GiB; a cell size of 2.0000e0"
        ));
    }

    #[test]
    fn readable_formats_bytes_with_binary_units() {
        assert_eq!(readable(0), "0 bytes");
        assert_eq!(readable(1023), "1023 bytes");
        assert_eq!(readable(1536), "1.5 KiB");
        assert_eq!(readable(300 << 30), "300 GiB");
        assert_eq!(readable(u64::MAX), "16.0 EiB");
    }
}
