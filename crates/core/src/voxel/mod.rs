//! Voxelization: finds the cells of a grid that a surface passes through or encloses.
//!
//! The files, in the order of the data flow:
//!
//! * [`grid`]: the grid around the surface.
//! * [`triangle_box`]: the intersection test of a triangle and a box of cells.
//! * [`bitmap`]: one bit for each cell.
//! * [`boxes`]: finds the cells that a triangle enters.
//! * [`fill`]: flood fill of the cells outside the surface.
//! * [`voxelize`](mod@voxelize): finds the cells that the surface passes through or encloses.
//! * [`grid_set`]: the result, a sorted set of grid positions.

mod bitmap;
mod boxes;
mod fill;
mod grid;
mod grid_set;
mod triangle_box;
mod voxelize;

pub(crate) use grid::{Grid, HIGHEST_INDEX};
pub(crate) use grid_set::GridSet;
pub(crate) use voxelize::{Voxels, bytes, voxelize};
