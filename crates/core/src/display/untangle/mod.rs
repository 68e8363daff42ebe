//! Untangles a deformed lattice: moves the corners of cells that are inside out, until no cell is.
//!
//! The *determinant* of a corner of a cell is formed by the three edges of the cell at this corner, in cells: 1 at
//! rest, and not positive if the cell is inside out there. The determinant of the center is formed by the mean edges.
//! A cell is *inverted* if one of these nine determinants is not positive. The first search finds determinants of
//! corners; a cell with a center alone that is inside out is very rare, and is found where another cell is inverted.
//!
//! | file | content |
//! |---|---|
//! | `inverted` | finds out quickly whether cells may be inverted |
//! | `determinants` | the determinants of a cell, and their derivatives |
//! | `cells` | tables of the cells of a lattice |
//! | `limits` | moves vertices within limits of their displacements |
//! | `untangler` | moves single vertices, in sweeps; shortens displacements that would invert cells |
//! | `relaxation` | moves parts of the lattice towards smoothed shapes, where sweeps do not help |

mod cells;
mod determinants;
mod inverted;
mod limits;
mod relaxation;
mod untangler;

pub(super) use inverted::may_be_inverted;
pub use untangler::UntanglingReport;

pub(super) use untangler::Untangler;
