//! Storage and registers of the kernels: blocks of eight lattice vertices, points of four numbers, the SIMD level.

mod coordinate;
pub(crate) mod lanes;
mod level;
pub(crate) mod tile;
pub(crate) mod vector;
pub(crate) mod xyzx;

pub use coordinate::Coordinate;
pub(crate) use level::level;
pub use level::{SimdError, check_simd_request, simd_level};
