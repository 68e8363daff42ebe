//! Voxelization: finds the cells of a grid that a surface passes through or encloses.
//!
//! The files, in the order of the data flow:
//!
//! * [`grid`]: the grid around the surface.
//! * [`triangle_box`]: the intersection test of a triangle and a box of cells.
//! * [`bricks`]: a set of cells to which cells are added in any order.
//! * [`boxes`]: finds the cells that a triangle enters.
//! * [`grid_set`]: a sorted set of grid positions.
//! * [`fill`]: finds the cells that no path of cells reaches from outside.
//! * [`inside`]: finds the cells inside a surface that is not closed.
//! * [`voxelize`](mod@voxelize): finds the cells that the surface passes through or encloses.

mod boxes;
mod bricks;
mod fill;
mod grid;
mod grid_set;
mod inside;
mod triangle_box;
mod voxelize;

pub(crate) use grid::{Grid, HIGHEST_INDEX, beside, step};
pub(crate) use grid_set::GridSet;
pub(crate) use voxelize::{Maxima, TooMany, Voxels, entered_cells, voxelize};

#[cfg(test)]
mod dense;
