//! Defines the storage formats and the SIMD helpers that the kernels share.
//!
//! | file | contents |
//! |---|---|
//! | `lanes` | numbers of lattice vertices, stored in blocks of eight vertices |
//! | `bounds` | bounds of the numbers of all lattice vertices |
//! | `vector` | products of 3-vectors, one vector in each lane of three registers; a vector in `f64` |
//! | `xyzx` | points stored as the four numbers (x, y, z, x) |
//! | `moving` | points that move along straight lines |
//! | `tile` | scratch points of a thread, read by 16-bit offsets |
//! | `coordinate` | the number types of output coordinates |
//! | `level` | the SIMD level, and the environment variable that selects it |

pub(crate) mod bounds;
mod coordinate;
pub(crate) mod lanes;
mod level;
pub(crate) mod moving;
pub(crate) mod tile;
pub(crate) mod vector;
pub(crate) mod xyzx;

pub use coordinate::Coordinate;
pub use level::{SimdError, check_simd_request, simd_level};
pub(crate) use level::{has_masked_arithmetic, level};
