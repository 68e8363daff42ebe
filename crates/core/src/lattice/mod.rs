//! The lattice: axis-aligned cubic cells that cover a shape, and the vertices at their corners.
//!
//! A *part* is a connected component of the occupied cells. Bridges of further cells can join the parts.
//!
//! The files, in the order of the data flow:
//!
//! * [`options`], [`error`], [`memory`]: options of the construction, its errors and the memory limit.
//! * [`resolution`]: finds the cell size for a requested number of vertices.
//! * [`candidate`]: finds the cells at one cell size.
//! * [`components`], [`nearest`]: find the parts of the cells and the bridges that join them.
//! * [`cells`]: [`Lattice`] itself; [`broken`]: the data that broken joints change.
//! * [`assemble`]: finds the vertices and links of a set of cells.
//! * [`construct`]: the constructors of [`Lattice`].
//! * [`blocks`], [`axis_links`], [`loose`], [`layout`]: storage of the vertices in blocks of eight.
//! * [`tables`]: the neighbors of all vertices, the corners of all cells, and their faces.
//! * [`joints`]: joints between cells.
//! * [`split`], [`vertex_classes`], [`split_links`], [`charts`]: lattices with broken joints, their vertices, links and
//!   blocks.
//! * [`shares`], [`masses`]: the filled shares of the cells, and the masses of the vertices.
//! * [`embedding`], [`trilinear`]: points that move with the cells.
//! * [`carry`]: values of the surface, carried to the vertices.
//! * [`smooth`], [`slopes`]: interpolation that is smooth across the faces of the cells.

mod assemble;
mod axis_links;
mod blocks;
mod broken;
mod candidate;
mod carry;
mod cells;
mod charts;
mod components;
mod construct;
mod embedding;
mod error;
mod joints;
mod layout;
mod loose;
mod masses;
mod memory;
mod nearest;
mod options;
mod resolution;
mod shares;
mod slopes;
mod smooth;
mod split;
mod split_links;
mod tables;
mod trilinear;
mod vertex_classes;

pub(crate) use axis_links::AxisLinks;
pub use broken::Joint;
pub(crate) use carry::carried;
pub use cells::Lattice;
pub use components::Components;
pub use embedding::Embedding;
pub(crate) use embedding::{Locator, PointMap};
pub use error::LatticeError;
pub(crate) use layout::Layout;
pub(crate) use loose::{LooseCell, LooseCells};
pub(crate) use masses::{Masses, cell_shares, dense_shares, masses_of_shares};
pub use options::{FloatingPart, LatticeOptions, LatticeReport, Resolution};
pub(crate) use slopes::{SlopeWeights, Slopes, Smoothing, Stencil};
pub(crate) use smooth::{SmoothCoordinate, SmoothTerms, smooth_value, trilinear_value};
#[cfg(test)]
pub(crate) use tables::FACE_CORNERS;
pub(crate) use tables::corners_from;
pub(crate) use trilinear::{corner_sums, monomials, polynomial, weights as trilinear_weights};
