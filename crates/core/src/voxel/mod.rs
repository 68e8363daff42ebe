//! Which cells of a grid a surface passes through or encloses.
//!
//! In the order of the data: the grid around the surface ([`grid`]), the boxes of cells that a triangle passes through
//! ([`triangle_box`]), bits for cells ([`bitmap`]), the cells that a way from outside leads to ([`fill`]), the cells of
//! the surface and its inside ([`voxelize`](mod@voxelize)), as a sorted set of grid positions ([`grid_set`]).

mod bitmap;
mod fill;
mod grid;
mod grid_set;
mod triangle_box;
mod voxelize;

pub(crate) use grid::{Grid, HIGHEST_INDEX};
pub(crate) use grid_set::GridSet;
pub(crate) use voxelize::{Voxels, bytes, voxelize};
