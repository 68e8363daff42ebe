//! A soft body: lattice, state, stages and displayed mesh.
//!
//! | file | contents |
//! |---|---|
//! | `builder` | builds a body from a mesh or a lattice, and settings |
//! | `step` | runs the stages of a step, in order |
//! | `recovery` | lets a tangled body return to its rest shape |
//! | `plan` | describes the stages and their memory |
//! | `elasticity` | the material in force |
//! | `material` | changes of the material between steps |
//! | `zones` | stiffness factors |
//! | `inflation` | ratios of rest volumes |
//! | `plasticity` | plastic shapes |
//! | `breaking` | fracture and cuts |
//! | `transfer` | the state after joints broke |
//! | `pieces` | the displayed mesh and the volume correction of a broken body |
//! | `settings` | changes settings between steps: volume correction, pins, handles, forces |
//! | `hold_force` | the forces that pins and handles exert |
//! | `quantities` | sums mass, momenta and energies |
//! | `snapshot` | saves and restores the state |
//! | `body_contact` | contact with other bodies |
//! | `escape` | moves components that begin inside colliders out of them |
//! | `sleep` | decides whether a body at rest is stepped |
//! | `display` | evaluates the displayed surface: volume correction and mesh update |
//! | `untangling` | untangles the displayed lattice where cells are inside out |

mod body_contact;
mod body_limits;
mod breaking;
mod builder;
mod display;
mod elasticity;
mod escape;
mod hold_force;
mod inflation;
mod material;
mod near_bodies;
mod pieces;
mod plan;
mod plasticity;
mod quantities;
mod recovery;
mod reference;
mod select;
mod settings;
mod sleep;
mod snapshot;
mod step;
mod transfer;
mod untangling;
mod zones;

pub use body_contact::TouchingOptions;
pub use builder::BodyBuilder;
pub use display::{Display, DisplayTimes, Displayed, DisplayedSurface};
pub use elasticity::Softened;
pub use hold_force::HoldForce;
pub(crate) use near_bodies::NearBodies;
pub use pieces::PieceMesh;
pub use reference::BodyRef;
pub(crate) use reference::DisplayContext;
pub(crate) use sleep::RestVote;
pub use snapshot::BodySnapshot;
pub(crate) use step::{BodyContactPart, StepContext};

use breaking::Breaking;
use escape::Leaving;

use std::sync::OnceLock;

use nalgebra::{Isometry3, Matrix3, Point3, Quaternion, UnitQuaternion, Vector3};

use crate::contact::bodies::BodyContact;
use crate::contact::{Colliders, Contacts, Pressure, SampleCells};
use crate::dynamics::{
    Constraints, ElasticDamper, EnergyLimiter, Forces, Inflation, Material, MomentumTracker, RegionDamper,
    StiffnessFactors,
};
use crate::lattice::{Embedding, Lattice, Masses, Smoothing};
use crate::matching::{HalfWidth, Matching, Purpose, Workspace};
use crate::mesh::{Mesh, Scale};
use crate::parallel::Executor;
use crate::skin::{Skin, SkinKind};
use crate::state::{ArrayError, BodyFrame, State};
use crate::volume::{self, Correction, VolumeMeasures, VolumeOptions};

/// Greatest valid magnitude of coordinates, in cells, and of speeds, in cells/s. Adjacent f64 numbers are
/// 0.125 apart at 1e15, so there is a margin to 1e16, where f64 does not resolve neighboring lattice
/// vertices.
const MAX_CELLS: f64 = 1e15;

/// A soft body.
///
/// The lattice vertices are the particles of the dynamics. Arrays of the state have one entry per lattice
/// vertex, in the order of [`Lattice::indices`], in scene units and world space.
#[derive(Debug)]
pub struct Body {
    name: String,
    material: Material,
    lattice: Lattice,
    /// Mass of each vertex in units of a full cell's mass.
    masses: Masses,
    /// `None` for a bare lattice. Computed when it is needed: see `pieces`.
    surface: Option<OnceLock<Surface>>,
    skin: SkinKind,
    volume: VolumeOptions,
    /// Computed when it is needed: see `pieces`.
    correction: OnceLock<Option<Correction>>,
    /// Built by the first volume report.
    measures: OnceLock<VolumeMeasures>,
    /// Scale of the given mesh or lattice.
    scale: Scale,
    /// Transform from the model's frame to world space at frame 0.
    model_to_world: Isometry3<f64>,
    state: State,

    // The stages: see `step`.
    matching: Matching,
    /// Not used if the body is a single task: see [`StepContext::workspaces`].
    workspace: Workspace,
    momentum: MomentumTracker,
    /// Built when the body is free (see `step`) and Newton's method for a rotation first does not converge.
    energy: Option<EnergyLimiter>,
    region_damping: Option<RegionDamper>,
    elastic_damping: Option<ElasticDamper>,
    forces: Option<Forces>,
    contacts: Option<Contacts>,
    /// Present in a simulation in which the body can touch bodies.
    body_contact: Option<BodyContact>,
    touching: TouchingOptions,
    /// Vertices of components that leave colliders in the current step: see `escape`.
    leaving: Vec<Leaving>,
    constraints: Option<Constraints>,
    /// Present in a body that can break or was cut.
    breaking: Option<Box<Breaking>>,
    /// Whether parts of the body touch each other that are connected.
    has_self_contact: bool,
    /// `None` if the stiffness does not vary.
    stiffness_factors: Option<StiffnessFactors>,
    /// `None` if all rest volumes are those of the mesh and stay so.
    inflation: Option<Inflation>,
    /// Largest extent of the lattice along an axis, in cells.
    extent: usize,
    /// Size L in scene units, the length scale of presets and of the limit of sleep: see `elasticity`.
    size: f64,
    /// Young's modulus of the material, fixed when the body joined a simulation. `None` with the elasticity of
    /// regions, and outside a simulation.
    youngs_modulus: Option<f64>,
    /// The eigenvalue of the lowest elastic mode: see `dynamics::lowest_mode`. Computed when it is needed.
    lowest_eigenvalue: OnceLock<f64>,
    /// A vertex that was faster than the limit of sleep.
    fast_vertex: usize,
    /// See [`Body::unconverged_rotations`].
    unconverged: usize,
}

impl Body {
    /// Returns a builder of a body from a mesh.
    pub fn builder(mesh: Mesh) -> BodyBuilder {
        BodyBuilder::from_mesh(mesh)
    }

    /// Returns a builder of a body from a bare lattice, without a mesh to display.
    pub fn from_lattice(lattice: Lattice) -> BodyBuilder {
        BodyBuilder::from_lattice(lattice)
    }

    /// Returns the name of the body.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns the lattice in the model's frame: after `scale`, before `rotate` and `translate`.
    pub fn lattice(&self) -> &Lattice {
        &self.lattice
    }

    /// Returns the mesh in the model's frame, or `None` for a bare lattice.
    pub fn mesh(&self) -> Option<&Mesh> {
        self.surface().map(|surface| &surface.mesh)
    }

    /// Returns the scale of the given mesh or lattice.
    pub fn scale(&self) -> Scale {
        self.scale
    }

    /// Returns how the mesh follows the lattice.
    pub fn skin(&self) -> SkinKind {
        self.skin
    }

    /// Returns the stencils of a smooth skin; `None` if the skin is linear.
    fn smoothing(&self) -> Option<&Smoothing> {
        self.surface().and_then(|surface| surface.embedding.smoothing())
    }

    /// Returns the material.
    pub fn material(&self) -> &Material {
        &self.material
    }

    /// Returns the half-width of the regions, at most the extent of the lattice.
    pub fn half_width(&self) -> HalfWidth {
        self.matching.regions.half_width()
    }

    /// Returns the positions, shape `(n, 3)`.
    pub fn positions(&self) -> Vec<Point3<f64>> {
        self.by_vertex(|slot| self.state.frame.to_world(self.state.local(slot)))
    }

    /// Sets all positions, one per vertex. Velocities, pins and all other state are unchanged.
    ///
    /// # Errors
    ///
    /// A wrong number of positions, or a coordinate that is not finite or exceeds 10^15 cells.
    pub fn set_positions(&mut self, positions: &[Point3<f64>]) -> Result<(), ArrayError> {
        self.check("positions", positions.len(), positions.iter().map(|p| p.coords))?;
        self.state.set_world(self.matching.layout.slots(), positions);
        self.measure_contact_bounds();
        self.wake();
        Ok(())
    }

    /// Returns the corners of the bounding box of the positions, in world space.
    pub(crate) fn bounds(&self) -> (Point3<f64>, Point3<f64>) {
        let (low, high) = self.local_bounds();
        (self.state.frame.to_world(low), self.state.frame.to_world(high))
    }

    /// Returns the corners of the bounding box of the positions, in cells from the origin of the body.
    fn local_bounds(&self) -> (Vector3<f64>, Vector3<f64>) {
        let far = Vector3::repeat(f64::INFINITY);
        let positions = self.matching.layout.slots().iter().map(|&slot| self.state.local(slot));
        positions.fold((far, -far), |(low, high), position| (low.inf(&position), high.sup(&position)))
    }

    /// Returns the velocities in scene units per second, shape `(n, 3)`.
    pub fn velocities(&self) -> Vec<Vector3<f64>> {
        self.by_vertex(|slot| self.state.frame.velocity_to_world(self.state.velocities.get(slot)))
    }

    /// Sets all velocities, one per vertex. Positions, pins and all other state are unchanged.
    ///
    /// # Errors
    ///
    /// A wrong number of velocities, or a component that is not finite or exceeds 10^15 cells/s.
    pub fn set_velocities(&mut self, velocities: &[Vector3<f64>]) -> Result<(), ArrayError> {
        self.check("velocities", velocities.len(), velocities.iter().copied())?;
        self.state.set_world_velocities(self.matching.layout.slots(), velocities);
        self.wake();
        Ok(())
    }

    /// Returns the rotation of the region around each vertex, from the rest pose, as of the last step, shape
    /// `(n, 3, 3)`. If the regions are cells, it is the mean of those around the vertex.
    pub fn rotations(&self) -> Vec<Matrix3<f64>> {
        let matrix = |quaternion: [f32; 4]| {
            let [x, y, z, w] = quaternion.map(f64::from);
            UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z)).to_rotation_matrix().into_inner()
        };
        let mut rotations = Vec::new();
        self.matching.rotations_at_vertices(&self.state.rotations, &mut rotations);
        rotations.into_iter().map(matrix).collect()
    }

    /// Returns the masses, one per vertex: density x cell_size³ / 8 x the sum of the filled shares of the cells that
    /// share the vertex. The filled share of a cell is the part of it inside the mesh, at least 0.05. With an open mesh
    /// and for a bare lattice it is 1.
    pub fn masses(&self) -> Vec<f64> {
        (0..self.lattice.len() as u32).map(|vertex| self.mass_of(vertex)).collect()
    }

    /// Returns the masses of the vertices in the fits of the regions, one per vertex, in units of a full cell's mass.
    /// While a vertex is constrained by a pin or handle, it weighs more in the fits, at least twice: nothing moves it,
    /// so the rigid motions of its regions follow it. Only the fits use these masses; [`Body::masses`] returns the
    /// others.
    pub fn fit_masses(&self) -> Vec<f64> {
        self.by_vertex(|slot| self.matching.regions.weights.get(slot)[0].into())
    }

    /// Returns the filled share of each cell: see [`Body::masses`].
    pub fn cell_shares(&self) -> Vec<f64> {
        (0..self.lattice.cells().len() as u32).map(|cell| self.masses.share(cell).into()).collect()
    }

    /// Returns the mass of a full cell.
    pub(crate) fn cell_mass(&self) -> f64 {
        self.material.density * self.lattice.cell_size().powi(3)
    }

    /// Returns the mass of a vertex.
    fn mass_of(&self, vertex: u32) -> f64 {
        self.cell_mass() * f64::from(self.masses[vertex as usize])
    }

    /// Creates the contact stage if there are colliders, and removes it if there are none. Narrow colliders need more
    /// samples.
    pub(crate) fn update_contact_stage(&mut self, colliders: &Colliders) {
        if colliders.is_empty() {
            self.contacts = None;
            self.state.supports.clear();
            return;
        }
        let spacing = colliders.sample_spacing(self.lattice.cell_size());
        if self.contacts.as_ref().is_none_or(|contacts| contacts.spacing() != spacing) {
            self.contacts = Some(Contacts::within(spacing, self.create_samples(spacing)));
        }
    }

    /// Returns the transformation from local coordinates to world space.
    pub(crate) fn frame(&self) -> BodyFrame {
        self.state.frame.body_frame()
    }

    /// Returns the contacts with colliders of the last step.
    pub(crate) fn pressures(&self) -> &[Pressure] {
        self.contacts.as_ref().map_or(&[], Contacts::pressures)
    }

    /// Creates the samples on which contacts act, at most `spacing` cells apart: points of the mesh, or of the boundary
    /// of a bare lattice.
    fn create_samples(&self, spacing: f64) -> SampleCells {
        let slots = self.matching.layout.slots();
        match self.surface() {
            Some(Surface { mesh, embedding, pieces, .. }) => {
                let samples = SampleCells::of_mesh_within(
                    spacing,
                    (mesh, pieces.as_ref().map(|_| embedding)),
                    &self.lattice,
                    slots,
                    &self.masses,
                );
                match embedding.smoothing() {
                    None => samples,
                    Some(_) => samples.smoothed(&self.lattice, slots, &self.masses),
                }
            }
            None => SampleCells::of_lattice_within(spacing, &self.lattice, slots, &self.masses),
        }
    }

    /// Returns the goal positions g at the current positions, shape `(n, 3)`, without advancing time.
    pub fn goals(&self) -> Vec<Point3<f64>> {
        let (mut workspace, executor) = (Workspace::default(), Executor::sequential());
        let mut rotations = self.state.rotations.clone();
        let fitted = (&self.state.positions, &mut rotations, self.shapes());
        self.matching.fit(&mut workspace, &executor, fitted, None, Purpose::Vertices);
        let goals = self.matching.goals(&workspace, &executor);
        self.by_vertex(|slot| self.state.frame.to_world(goals.get(slot).map(f64::from).into()))
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

    /// Returns one value per vertex, computed from the slot of the vertex: its index in the storage of the
    /// state (see [`Lanes`](crate::simd::lanes::Lanes)).
    fn by_vertex<T>(&self, value: impl FnMut(u32) -> T) -> Vec<T> {
        self.matching.layout.slots().iter().copied().map(value).collect()
    }

    /// Returns the greatest valid magnitude of coordinates in scene units, and of speeds in scene units per
    /// second.
    fn coordinate_limit(&self) -> f64 {
        MAX_CELLS * self.lattice.cell_size()
    }

    /// Checks the length of an array that a user passes.
    fn check_length(&self, name: &'static str, count: usize) -> Result<(), ArrayError> {
        let expected = self.lattice.len();
        if count == expected { Ok(()) } else { Err(ArrayError::Length { name, count, expected }) }
    }

    /// Checks the length and the values of an array that a user passes.
    fn check(
        &self,
        name: &'static str,
        count: usize,
        values: impl Iterator<Item = Vector3<f64>>,
    ) -> Result<(), ArrayError> {
        self.check_length(name, count)?;
        for (index, value) in values.enumerate() {
            if !value.iter().all(|x| x.is_finite()) {
                return Err(ArrayError::NotFinite { name, index, value: value.into() });
            }
            let limit = self.coordinate_limit();
            if value.amax() > limit {
                return Err(ArrayError::TooFar { name, index, value: value.into(), limit });
            }
        }
        Ok(())
    }
}

/// Returns the factors of the masses of the vertices in the fits while the vertices with `true` are constrained.
pub fn hold_factors(body: &Body, constrained: &[bool]) -> Vec<f32> {
    body.matching.regions.hold_factors(&body.matching.layout, constrained)
}

/// The displayed mesh, and its embedding in the lattice.
#[derive(Debug)]
struct Surface {
    mesh: Mesh,
    embedding: Embedding,
    skin: Skin,
    /// `None` while the body is whole.
    pieces: Option<Box<PieceMesh>>,
}

impl Surface {
    /// Returns the surface as the volume correction reads it.
    fn volume_surface(&self) -> volume::Surface<'_> {
        volume::Surface { mesh: &self.mesh, embedding: &self.embedding }
    }
}
