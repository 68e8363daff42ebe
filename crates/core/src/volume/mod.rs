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
//! those that would enter an obstacle stop before it, and the rest solves again    (where there are colliders)
//! ```
//!
//! `P~` is for the eye alone: it deforms the mesh and never feeds back into the dynamics.
//!
//! [`Correction`] does this for a body; [`VolumeMeasures`] measures a body by every measure there is, corrected or
//! not; [`smallest_root`] solves the cubic. Components of the lattice that nothing joins have each their own rest
//! volume and their own `lambda`.

mod adjacency;
mod constraints;
mod correction;
mod cubic;
mod field;
mod limits;
mod line;
mod measure;
mod mesh_measure;
mod options;
mod regional;
mod report;
mod shells;
mod surface;
mod volumes;

pub use constraints::{HALF_PUSH, Push};
pub use correction::{Correction, CorrectionWorkspace};
pub use cubic::{Root, smallest_root};
pub use field::FieldKind;
pub(crate) use limits::Limit;
pub use options::{Preservation, VolumeError, VolumeMeasure, VolumeOptions, VolumeScope};
pub use report::{ComponentReport, VolumeReport, Volumes};
pub use surface::Surface;
pub use volumes::VolumeMeasures;
