//! The body and its parts.

use super::parts::{Breaking, ContactData, DisplayData, Pipeline, Settings, Shape};
use crate::contact::Contacts;
use crate::dynamics::{Constraints, Forces, Inflation, KeyedMaterial, Material, RigidBody, StiffnessFactors};
use crate::error::Error;
use crate::lattice::Lattice;
use crate::matching::{HalfWidth, Matching};
use crate::mesh::Scale;
use crate::skin::SkinKind;
use crate::state::{BodyFrame, State};
use crate::volume::VolumeOptions;

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
    pub(super) shape: Shape,
    pub(super) settings: Settings,
    pub(super) state: State,
    pub(super) pipeline: Pipeline,
    pub(super) contact: ContactData,
    pub(super) constraints: Option<Constraints>,
    pub(super) forces: Option<Forces>,
    /// `None` if all rest volumes equal the volumes of the mesh at all times.
    pub(super) inflation: Option<Inflation>,
    /// `None` if no number of the material has keyframes.
    pub(super) keyed: Option<Box<KeyedMaterial>>,
    /// `None` if the stiffness does not vary.
    pub(super) stiffness_factors: Option<StiffnessFactors>,
    /// Present in a body that can break or was cut.
    pub(super) breaking: Option<Box<Breaking>>,
    /// Present in a rigid body.
    pub(super) rigid: Option<Box<RigidBody>>,
    pub(super) display: DisplayData,
}

impl Body {
    /// Returns the name of the body.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns the index of the body with a name. `what` refers to the body, as in "a field".
    pub(crate) fn index_of(bodies: &[Self], what: &'static str, name: &str) -> Result<usize, Error> {
        let missing = || {
            let bodies = bodies.iter().map(|body| body.name().to_owned()).collect();
            Error::NoSuchBody { what, name: name.to_owned(), bodies }
        };
        bodies.iter().position(|body| body.name() == name).ok_or_else(missing)
    }

    /// Returns the lattice in the model's frame: after `scale`, before `rotate` and `translate`.
    pub fn lattice(&self) -> &Lattice {
        &self.shape.lattice
    }

    /// Returns the scale of the given mesh or lattice.
    pub fn scale(&self) -> Scale {
        self.shape.scale
    }

    /// Returns how the mesh follows the lattice.
    pub fn skin(&self) -> SkinKind {
        self.settings.skin
    }

    /// Returns the material.
    pub fn material(&self) -> &Material {
        &self.settings.material
    }

    /// Returns the half-width of the regions, at most the extent of the lattice.
    pub fn half_width(&self) -> HalfWidth {
        self.pipeline.matching.regions.half_width()
    }

    /// Returns the state.
    pub(crate) fn state(&self) -> &State {
        &self.state
    }

    /// Returns the regions and the layout of the lattice.
    pub(crate) fn matching(&self) -> &Matching {
        &self.pipeline.matching
    }

    /// Returns the contact stage; `None` if there is no collider, or before the first step.
    pub(crate) fn contacts(&self) -> Option<&Contacts> {
        self.contact.contacts.as_ref()
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
        self.settings.volume
    }

    /// Returns the number of region rotations for which Newton's method did not converge, summed over the
    /// shape matching of all steps so far. A fallback computes such a rotation from an eigenvalue problem in
    /// f64. If the energy limiter repeats the fit of a step, only the first fit counts.
    pub fn unconverged_rotations(&self) -> usize {
        self.pipeline.unconverged
    }

    /// Returns the mass of a full cell.
    pub(super) fn cell_mass(&self) -> f64 {
        self.settings.material.density * self.shape.lattice.cell_size().powi(3)
    }

    /// Returns the mass of a vertex.
    pub(crate) fn mass_of(&self, vertex: u32) -> f64 {
        self.cell_mass() * f64::from(self.shape.masses[vertex as usize])
    }

    /// Returns one value per vertex, computed from the slot of the vertex: its index in the storage of the
    /// state (see [`Lanes`](crate::simd::lanes::Lanes)).
    pub(super) fn by_vertex<T>(&self, value: impl FnMut(u32) -> T) -> Vec<T> {
        self.pipeline.matching.layout.slots().iter().copied().map(value).collect()
    }

    /// Returns the greatest valid magnitude of coordinates in scene units, and of speeds in scene units per
    /// second.
    pub(super) fn coordinate_limit(&self) -> f64 {
        MAX_CELLS * self.shape.lattice.cell_size()
    }
}
