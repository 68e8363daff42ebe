//! Volume-preserving correction of a deformed lattice (Takamatsu & Kanai 2009), after von Funck, Theisel & Seidel
//! (2008).
//!
//! The dynamics leave vertices `P^`, whose volume is not that at rest. The correction moves them along a field `V`:
//!
//! ```text
//! field V (rest, once) -> turned by the rotations -> less external forces (Eq. 2) and held vertices
//! P^ + Lambda V, a scale for each vertex from what its region lost         (scope `regional` only)
//! vol(P^ + lambda V) = c0 + c1 lambda + c2 lambda^2 + c3 lambda^3 = vol(P)        (Eq. 1)
//! P~ = P^ + lambda V,  lambda the root of least absolute value
//! vertices that would enter a collider stop before it, and the others solve again  (where there are colliders)
//! ```
//!
//! `P~` is shown only: it deforms the mesh and never feeds back into the dynamics.
//!
//! [`Correction`] does this for a body, with the buffers of a [`CorrectionWorkspace`]; [`VolumeMeasures`] measures a body
//! by every measure there is, corrected or not; [`smallest_root`] solves the cubic. Each connected component of the
//! lattice has its own rest volume and its own `lambda`.
//!
//! | file | content |
//! |---|---|
//! | `options`, `report` | the choices of a user, and the results |
//! | `adjacency` | the lattice as tables: links, boundary faces |
//! | `line` | points that move along lines, and determinants of them: cubics |
//! | `sums` | buffers of an evaluation; sums of fixed shape |
//! | `measure`, `mesh_measure` | the volume as a cubic, by each measure |
//! | `surface`, `shells` | the parts of a mesh that bound the body, as a measure |
//! | `volumes` | all measures of a body, for reports |
//! | `field` | the field V |
//! | `external_forces` | external forces and held vertices |
//! | `cubic` | the root of a cubic |
//! | `regional` | a scale for each vertex, before the cubic |
//! | `limits`, `clearance` | vertices that stop at a collider, or slide along it |
//! | `correction` | all of it, in order |

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
