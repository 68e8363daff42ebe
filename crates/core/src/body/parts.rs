//! The parts of a body.

use std::sync::OnceLock;

use nalgebra::{Isometry3, Vector3};

use super::proportions::Proportions;
use super::surface::Surface;
use super::touching::TouchingOptions;
use crate::contact::Contacts;
use crate::contact::bodies::BodyContact;
use crate::dynamics::{ElasticDamper, EnergyLimiter, Material, MomentumTracker, PartFactors, RegionDamper};
use crate::fracture::Fracture;
use crate::lattice::{Lattice, Masses};
use crate::matching::{HalfWidth, Matching, Workspace};
use crate::mesh::{Mesh, Scale};
use crate::skin::SkinKind;
use crate::state::Placement;
use crate::volume::{Correction, VolumeMeasures, VolumeOptions};

/// The lattice and the mesh of a body. Only fracture changes them.
#[derive(Debug)]
pub(super) struct Shape {
    pub(super) lattice: Lattice,
    /// Mass of each vertex in units of a full cell's mass.
    pub(super) masses: Masses,
    /// `None` for a bare lattice. Computed when it is needed: see `pieces`.
    pub(super) surface: Option<OnceLock<Surface>>,
    /// Scale of the given mesh or lattice.
    pub(super) scale: Scale,
    /// Transform from the model's frame to world space at frame 0.
    pub(super) model_to_world: Isometry3<f64>,
    /// The placement at frame 0, with the initial velocities.
    pub(super) placement: Placement,
    /// Largest extent of the lattice along an axis, in cells.
    pub(super) extent: usize,
    pub(super) proportions: Proportions,
}

/// The settings of a body: those of the user, and those that its simulation derives from them.
#[derive(Debug)]
pub(super) struct Settings {
    pub(super) material: Material,
    pub(super) skin: SkinKind,
    pub(super) volume: VolumeOptions,
    pub(super) touching: TouchingOptions,
    /// Whether parts of the body touch each other that are connected.
    pub(super) has_self_contact: bool,
    /// The factors with which density and strength vary.
    pub(super) parts: PartFactors,
    /// Young's modulus in force as a share of the greatest one of its keyframes, in (0, 1]; 1 without keyframes.
    pub(super) modulus_share: f64,
    /// Young's modulus of the material, fixed when the body joined a simulation. `None` with the elasticity of
    /// regions, and outside a simulation.
    pub(super) youngs_modulus: Option<f64>,
}

/// The data that stages derive from the shape, the material and the half-width of the regions.
#[derive(Debug)]
pub(super) struct Pipeline {
    pub(super) matching: Matching,
    /// Not used if the body is a single task: see [`StepContext::workspaces`](super::StepContext::workspaces).
    pub(super) workspace: Workspace,
    pub(super) momentum: MomentumTracker,
    /// Built when the body is free (see `stages`) and Newton's method for a rotation first does not converge.
    pub(super) energy: Option<EnergyLimiter>,
    pub(super) region_damping: Option<RegionDamper>,
    pub(super) elastic_damping: Option<ElasticDamper>,
    /// The eigenvalue of the lowest elastic mode: see `dynamics::lowest_mode`. Computed when it is needed.
    pub(super) lowest_eigenvalue: OnceLock<f64>,
    /// A vertex that was faster than the limit of sleep.
    pub(super) fast_vertex: usize,
    /// See `Body::unconverged_rotations`.
    pub(super) unconverged: usize,
    /// The rotations of the last step that did not converge.
    pub(super) unconverged_in_step: usize,
}

/// The data of contacts.
#[derive(Debug, Default)]
pub(super) struct ContactData {
    pub(super) contacts: Option<Contacts>,
    /// Present in a simulation in which the body can touch bodies.
    pub(super) body_contact: Option<BodyContact>,
    /// Whether a collider resists the rolling of bodies that have no resistance of their own.
    pub(super) colliders_resist_rolling: bool,
    /// Vertices of components that leave colliders in the current step: see `escape`.
    pub(super) leaving: Vec<Leaving>,
}

/// The state of a vertex of a component that leaves colliders, before the step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Leaving {
    pub(super) slot: u32,
    /// Index of the connected component.
    pub(super) component: u32,
    /// Position and velocity in cells and cells/s.
    pub(super) position: Vector3<f64>,
    pub(super) velocity: [f32; 3],
}

/// The stage of a body that can break or was cut.
#[derive(Debug)]
pub(super) struct Breaking {
    pub(super) fracture: Fracture,
    /// Filled share of each cell, times the factor of its density.
    pub(super) shares: Vec<f64>,
    /// The mesh of the whole body.
    pub(super) whole: Option<Mesh>,
    /// The masses of the vertices of the whole body.
    pub(super) whole_masses: Masses,
    /// Greatest Young's modulus in force in the present step, and the least factor of the limits.
    pub(super) weakest: (f64, f64),
    /// Whether the shape matching of the step stores the deformation gradients of all regions.
    pub(super) has_gradients: bool,
    /// Whether joints were found that break at the end of the step.
    pub(super) is_due: bool,
    /// Whether there are pieces that the contacts of the simulation have not registered.
    pub(super) has_new_pieces: bool,
}

impl Breaking {
    /// Begins a step: decides whether its shape matching stores the deformation gradients of all regions. Otherwise they
    /// are measured after it where they are needed. The results are the same. Plastic bodies always need them.
    pub(super) fn begin_step(&mut self, weakest: (f64, f64), is_plastic: bool) {
        self.weakest = weakest;
        self.has_gradients = is_plastic || self.fracture.expects_gradients();
    }
}

/// The data that the display derives from the shape.
#[derive(Debug)]
pub(super) struct DisplayData {
    /// Computed when it is needed: see `pieces`.
    pub(super) correction: OnceLock<Option<Correction>>,
    /// Built by the first volume report.
    pub(super) measures: OnceLock<VolumeMeasures>,
}

impl Pipeline {
    /// Creates the shape matching and the momentum tracker of a body with regions of a half-width. The other stages are
    /// [built](super::stages::Stage::rebuild) later.
    pub(super) fn new(lattice: &Lattice, masses: &Masses, half_width: HalfWidth) -> Self {
        let matching = Matching::new(lattice, masses, half_width);
        Self {
            momentum: MomentumTracker::new(lattice, masses, &matching.layout, matching.cascade.tasks()),
            matching,
            workspace: Workspace::default(),
            energy: None,
            region_damping: None,
            elastic_damping: None,
            lowest_eigenvalue: OnceLock::new(),
            fast_vertex: 0,
            unconverged: 0,
            unconverged_in_step: 0,
        }
    }
}
