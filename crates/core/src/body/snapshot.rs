//! The saved state of a body.

use crate::contact::Side;
use crate::dynamics::{Constraints, Forces, Inflation, KeyedMaterial, Material, PartFactors};
use crate::fracture::Cracks;
use crate::matching::HalfWidth;
use crate::state::State;
use crate::volume::VolumeOptions;

/// The saved state of a body: all data that steps and changes of settings modify. Each stage saves, checks and restores
/// its own part. It can be restored in any body that was built from the same mesh or lattice with the same settings.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BodySnapshot {
    /// The cracks; `None` while the body is whole. They determine the lattice, to which all other data belong.
    pub(super) cracks: Option<Cracks>,
    pub(super) state: State,
    pub(super) constraints: Option<Constraints>,
    pub(super) material: Material,
    /// Young's modulus that was fixed when the body joined a simulation.
    pub(super) youngs_modulus: Option<f64>,
    pub(super) half_width: HalfWidth,
    /// One per lattice vertex.
    pub(super) stiffness_factors: Option<Vec<f64>>,
    pub(super) parts: PartFactors,
    pub(super) inflation: Option<Inflation>,
    pub(super) keyed: Option<KeyedMaterial>,
    /// Young's modulus in force as a share of the greatest one of its keyframes.
    pub(super) modulus_share: f64,
    /// The friction in force, if it has keyframes.
    pub(super) friction: Option<f64>,
    pub(super) volume: VolumeOptions,
    pub(super) forces: Option<Forces>,
    /// Displacements by contacts since the frame began, for the volume correction.
    pub(super) displacements: Vec<[f32; 3]>,
    /// Side points of the samples at colliders; see `contact::sides`.
    pub(super) sides: Vec<Side>,
}
