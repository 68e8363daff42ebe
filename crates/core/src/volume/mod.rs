//! Corrects a deformed lattice so that its volume equals the rest volume (Takamatsu & Kanai 2009, after von
//! Funck, Theisel & Seidel 2008).
//!
//! The dynamics give the deformed lattice vertices `P^`. Their volume `vol(P^)` differs from `vol(P)`, the
//! volume of the rest positions `P`. The correction moves each vertex along its vector of a deformation field
//! `V`, by a scale `lambda`. Along such straight lines the volume is a cubic in `lambda` with the
//! coefficients `c0` to `c3`. The corrected vertices are `P~`. "(Eq. n)" refers to Takamatsu & Kanai 2009.
//!
//! ```text
//! 1. V: build at rest, once; rotate with the shape matching; fade out beside constrained vertices;
//!    remove the directions of external forces (Eq. 2)
//! 2. scope `regional` only: move each vertex along V by its own scale, from the volume loss around it
//! 3. vol(P^ + lambda V) = c0 + c1 lambda + c2 lambda^2 + c3 lambda^3 = vol(P)  (Eq. 1):
//!    solve for lambda, the root of least absolute value
//!    if there is none within the cap: turn V to the present shape, move, and solve again, in several passes
//! 4. only with limits: vertices slide or stop at them; solve again for the other vertices
//! 5. P~ = P^ + lambda V, plus the displacements of step 2 and of the passes
//! ```
//!
//! `P~` is used for the display only: it deforms the displayed mesh and never feeds back into the dynamics.
//!
//! [`Correction`] corrects a body, with the buffers of a [`CorrectionWorkspace`]. A measure is a definition
//! of the volume of a body; [`VolumeMeasures`] evaluates all measures, with or without correction.
//! [`smallest_root`] solves the cubic. In this module *component* means connected component of the lattice.
//! Each component has its own rest volume and its own `lambda`. A *link* is an edge of the lattice between
//! two neighboring vertices.
//!
//! | file | content |
//! |---|---|
//! | `options`, `report` | user options, and the results |
//! | `adjacency` | tables of the lattice: links, boundary faces, occupied cells around each vertex |
//! | `blocks` | numbers of lattice vertices in blocks of eight, for sums over links |
//! | `line` | points that move along straight lines, and their determinants, which are cubics in `lambda` |
//! | `sums` | buffers of an evaluation; sums in a fixed order |
//! | `measure`, `mesh_measure`, `patch`, `smooth_points` | the volume as a cubic in `lambda`, for each measure |
//! | `surface`, `shells` | construction of the measure `mesh`; which shells of the mesh bound the body |
//! | `volumes` | all measures of a body, for reports |
//! | `field` | the field `V` |
//! | `external_forces` | changes of the field by external forces (Eq. 2) |
//! | `cubic` | the root of the cubic (Eq. 1) |
//! | `regional` | scope `regional`: a scale for each vertex, before the cubic is solved |
//! | `limits` | limits of the displacements, and the projection of a displacement to them |
//! | `correction` | the whole correction, in the order of the steps above; passes where one cubic is not enough |

mod adjacency;
mod blocks;
mod correction;
mod cubic;
mod external_forces;
mod field;
mod limits;
mod line;
mod measure;
mod mesh_measure;
mod options;
mod patch;
mod regional;
mod report;
mod shells;
mod smooth_points;
mod sums;
mod surface;
mod volumes;

pub(crate) use correction::RestRatios;
pub use correction::{Correction, CorrectionWorkspace};
#[cfg(feature = "internals")]
pub use cubic::{Root, smallest_root};
pub use external_forces::ExternalForce;
pub(crate) use limits::{Limit, Limits, Motion, project};
pub use options::{FieldKind, Preservation, VolumeError, VolumeMeasure, VolumeOptions, VolumeScope};
pub use report::{ComponentReport, VolumeReport, Volumes};
pub(crate) use surface::MIN_VOLUME_FRACTION;
pub use surface::Surface;
pub use volumes::VolumeMeasures;
