//! The body, and what its parts are.

use std::sync::OnceLock;

use nalgebra::Isometry3;

use super::fracture_stage::Breaking;
use super::leaving::Leaving;
use super::surface::Surface;
use super::touching::TouchingOptions;
use crate::contact::Contacts;
use crate::contact::bodies::BodyContact;
use crate::dynamics::{
    Constraints, ElasticDamper, EnergyLimiter, Forces, Inflation, Material, MomentumTracker, RegionDamper,
    StiffnessFactors,
};
use crate::lattice::{Lattice, Masses};
use crate::matching::{HalfWidth, Matching, Workspace};
use crate::mesh::Scale;
use crate::skin::SkinKind;
use crate::state::{BodyFrame, State};
use crate::volume::{Correction, VolumeMeasures, VolumeOptions};

/// Greatest valid magnitude of coordinates, in cells, and of speeds, in cells/s. Adjacent f64 numbers are
/// 0.125 apart at 1e15, so there is a margin to 1e16, where f64 does not resolve neighboring lattice
/// vertices.
pub(super) const MAX_CELLS: f64 = 1e15;

/// A soft body.
///
/// The lattice vertices are the particles of the dynamics. Arrays of the state have one entry per lattice
/// vertex, in the order of [`Lattice::indices`], in scene units and world space.
#[derive(Debug)]
pub struct Body {
    pub(super) name: String,
    pub(super) material: Material,
    pub(super) lattice: Lattice,
    /// Mass of each vertex in units of a full cell's mass.
    pub(super) masses: Masses,
    /// `None` for a bare lattice. Computed when it is needed: see `pieces`.
    pub(super) surface: Option<OnceLock<Surface>>,
    pub(super) skin: SkinKind,
    pub(super) volume: VolumeOptions,
    /// Computed when it is needed: see `pieces`.
    pub(super) correction: OnceLock<Option<Correction>>,
    /// Built by the first volume report.
    pub(super) measures: OnceLock<VolumeMeasures>,
    /// Scale of the given mesh or lattice.
    pub(super) scale: Scale,
    /// Transform from the model's frame to world space at frame 0.
    pub(super) model_to_world: Isometry3<f64>,
    pub(super) state: State,

    // The stages: see `step`.
    pub(super) matching: Matching,
    /// Not used if the body is a single task: see [`StepContext::workspaces`](super::StepContext::workspaces).
    pub(super) workspace: Workspace,
    pub(super) momentum: MomentumTracker,
    /// Built when the body is free (see `step`) and Newton's method for a rotation first does not converge.
    pub(super) energy: Option<EnergyLimiter>,
    pub(super) region_damping: Option<RegionDamper>,
    pub(super) elastic_damping: Option<ElasticDamper>,
    pub(super) forces: Option<Forces>,
    pub(super) contacts: Option<Contacts>,
    /// Present in a simulation in which the body can touch bodies.
    pub(super) body_contact: Option<BodyContact>,
    pub(super) touching: TouchingOptions,
    /// Vertices of components that leave colliders in the current step: see `escape`.
    pub(super) leaving: Vec<Leaving>,
    pub(super) constraints: Option<Constraints>,
    /// Present in a body that can break or was cut.
    pub(super) breaking: Option<Box<Breaking>>,
    /// Whether parts of the body touch each other that are connected.
    pub(super) has_self_contact: bool,
    /// `None` if the stiffness does not vary.
    pub(super) stiffness_factors: Option<StiffnessFactors>,
    /// `None` if all rest volumes are those of the mesh and stay so.
    pub(super) inflation: Option<Inflation>,
    /// Largest extent of the lattice along an axis, in cells.
    pub(super) extent: usize,
    /// Size L in scene units, the length scale of presets and of the limit of sleep: see `elasticity`.
    pub(super) size: f64,
    /// Young's modulus of the material, fixed when the body joined a simulation. `None` with the elasticity of
    /// regions, and outside a simulation.
    pub(super) youngs_modulus: Option<f64>,
    /// The eigenvalue of the lowest elastic mode: see `dynamics::lowest_mode`. Computed when it is needed.
    pub(super) lowest_eigenvalue: OnceLock<f64>,
    /// A vertex that was faster than the limit of sleep.
    pub(super) fast_vertex: usize,
    /// See [`Body::unconverged_rotations`].
    pub(super) unconverged: usize,
}

impl Body {
    /// Returns the name of the body.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns the lattice in the model's frame: after `scale`, before `rotate` and `translate`.
    pub fn lattice(&self) -> &Lattice {
        &self.lattice
    }

    /// Returns the scale of the given mesh or lattice.
    pub fn scale(&self) -> Scale {
        self.scale
    }

    /// Returns how the mesh follows the lattice.
    pub fn skin(&self) -> SkinKind {
        self.skin
    }

    /// Returns the material.
    pub fn material(&self) -> &Material {
        &self.material
    }

    /// Returns the half-width of the regions, at most the extent of the lattice.
    pub fn half_width(&self) -> HalfWidth {
        self.matching.regions.half_width()
    }

    /// Returns the state.
    pub(crate) fn state(&self) -> &State {
        &self.state
    }

    /// Returns the regions and the layout of the lattice.
    pub(crate) fn matching(&self) -> &Matching {
        &self.matching
    }

    /// Returns the contact stage; `None` if there is no collider, or before the first step.
    pub(crate) fn contacts(&self) -> Option<&Contacts> {
        self.contacts.as_ref()
    }

    /// Returns the external forces; `None` if there have been none.
    pub(crate) fn forces(&self) -> Option<&Forces> {
        self.forces.as_ref()
    }

    /// Returns the transformation from local coordinates to world space.
    pub(crate) fn frame(&self) -> BodyFrame {
        self.state.frame.body_frame()
    }

    /// Returns the options of the volume correction.
    pub fn volume_options(&self) -> VolumeOptions {
        self.volume
    }

    /// Returns the number of region rotations for which Newton's method did not converge, summed over the
    /// shape matching of all steps so far. A fallback computes such a rotation from an eigenvalue problem in
    /// f64. If the energy limiter repeats the fit of a step, only the first fit counts.
    pub fn unconverged_rotations(&self) -> usize {
        self.unconverged
    }

    /// Returns the mass of a full cell.
    pub(crate) fn cell_mass(&self) -> f64 {
        self.material.density * self.lattice.cell_size().powi(3)
    }

    /// Returns the mass of a vertex.
    pub(super) fn mass_of(&self, vertex: u32) -> f64 {
        self.cell_mass() * f64::from(self.masses[vertex as usize])
    }

    /// Returns one value per vertex, computed from the slot of the vertex: its index in the storage of the
    /// state (see [`Lanes`](crate::simd::lanes::Lanes)).
    pub(super) fn by_vertex<T>(&self, value: impl FnMut(u32) -> T) -> Vec<T> {
        self.matching.layout.slots().iter().copied().map(value).collect()
    }

    /// Returns the greatest valid magnitude of coordinates in scene units, and of speeds in scene units per
    /// second.
    pub(super) fn coordinate_limit(&self) -> f64 {
        MAX_CELLS * self.lattice.cell_size()
    }
}
