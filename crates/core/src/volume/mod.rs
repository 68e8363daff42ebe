//! Volume-preserving correction of a deformed lattice (Takamatsu & Kanai 2009), after von Funck, Theisel &
//! Seidel (2008).
//!
//! The dynamics give deformed vertices `P^`, whose volume differs from the rest volume. The
//! correction moves them along a deformation field `V`:
//!
//! ```text
//! field V at rest (built once) -> rotated by the matching -> minus external forces (Eq. 2) and constraints
//! P^ + Lambda V, a scale per vertex from the volume loss of its regions     (scope `regional` only)
//! vol(P^ + lambda V) = c0 + c1 lambda + c2 lambda^2 + c3 lambda^3 = vol(P)  (Eq. 1)
//! P~ = P^ + lambda V,  lambda the root of least absolute value
//! vertices that would enter a collider stop before it; solve again          (only with colliders)
//! ```
//!
//! `P~` is used for the display only: it deforms the mesh and never feeds back into the dynamics.
//!
//! [`Correction`] corrects a body, with the buffers of a [`CorrectionWorkspace`]. [`VolumeMeasures`]
//! evaluates all measures of a body, with or without correction. [`smallest_root`] solves the cubic. Each
//! connected component of the lattice has its own rest volume and its own `lambda`.
//!
//! | file | content |
//! |---|---|
//! | `options`, `report` | user options, and the results |
//! | `adjacency` | tables of the lattice: links, boundary faces |
//! | `line` | points that move along lines, and their determinants, which are cubics |
//! | `sums` | buffers of an evaluation; sums in a fixed order |
//! | `measure`, `mesh_measure` | the volume as a cubic in `lambda`, for each measure |
//! | `surface`, `shells` | the measure `mesh`: the shells of the mesh that bound the body |
//! | `volumes` | all measures of a body, for reports |
//! | `field` | the field V |
//! | `external_forces` | external forces (Eq. 2) and constrained vertices |
//! | `cubic` | the root of the cubic of Eq. (1) |
//! | `regional` | scope `regional`: a scale per vertex, before the cubic |
//! | `limits`, `clearance` | vertices that stop at a collider or slide along it |
//! | `correction` | the whole correction, in this order |

mod adjacency;
mod clearance;
mod correction;
mod cubic;
mod external_forces;
mod field;
mod limits;
mod line;
mod measure;
mod mesh_measure;
mod options;
mod regional;
mod report;
mod shells;
mod sums;
mod surface;
mod volumes;

pub(crate) use clearance::Obstacles;
pub use correction::{Correction, CorrectionWorkspace};
pub use cubic::{Root, smallest_root};
pub use external_forces::{ExternalForce, HALF_FORCE};
pub use options::{FieldKind, Preservation, VolumeError, VolumeMeasure, VolumeOptions, VolumeScope};
pub use report::{ComponentReport, VolumeReport, Volumes};
pub use surface::Surface;
pub use volumes::VolumeMeasures;
