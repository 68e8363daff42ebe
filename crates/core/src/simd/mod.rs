//! Storage and SIMD registers of the kernels: blocks of eight lattice vertices, points of four numbers, the
//! SIMD level.
//!
//! | file | contents |
//! |---|---|
//! | `lanes` | blocks of eight lattice vertices |
//! | `vector` | products of vectors, one vector for each lane |
//! | `xyzx` | points as four numbers |
//! | `tile` | scratch rows of a thread, gathered by 16-bit offsets |
//! | `coordinate` | the number types of output coordinates |
//! | `level` | the SIMD level, and its environment variable |

mod coordinate;
pub(crate) mod lanes;
mod level;
pub(crate) mod tile;
pub(crate) mod vector;
pub(crate) mod xyzx;

pub use coordinate::Coordinate;
pub(crate) use level::level;
pub use level::{SimdError, check_simd_request, simd_level};
