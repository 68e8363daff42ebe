//! A soft body: lattice, state and stages, and the mesh that is shown.
//!
//! | file | contents |
//! |---|---|
//! | `builder` | from a mesh or a lattice and settings to a body |
//! | `step` | the stages of a step, in order |
//! | `plan` | the same stages as a report |
//! | `settings` | what a user changes between steps: material, volume, pins, handles, forces |
//! | `snapshot` | the state to save and restore |
//! | `display` | what is shown: the volume correction and the mesh update |

mod builder;
mod display;
mod plan;
mod settings;
mod snapshot;
mod step;

pub use builder::BodyBuilder;
pub(crate) use display::Scene;
pub use display::{BodyRef, Display, DisplayTimes, Displayed, DisplayedSurface};
pub use snapshot::{BodySnapshot, StateError};
pub(crate) use step::World;

use std::sync::OnceLock;

use nalgebra::{Isometry3, Matrix3, Point3, Quaternion, UnitQuaternion, Vector3};

use crate::contact::{Colliders, Contacts, SampleCells};
use crate::dynamics::{Constraints, EnergyLimiter, Forces, Material, MomentumTracker, RegionDamper};
use crate::lattice::{Embedding, Lattice};
use crate::matching::{Matching, Purpose, Workspace};
use crate::mesh::Mesh;
use crate::parallel::Executor;
use crate::skin::Skin;
use crate::state::State;
use crate::volume::{self, Correction, VolumeMeasures, VolumeOptions};

/// The greatest coordinate in cells, and speed in cells/s, that is accepted: beyond it, f64 does not separate
/// neighbouring lattice vertices.
const FARTHEST: f64 = 1e15;

/// A soft body.
///
/// Its lattice vertices are the particles of the dynamics; arrays have one entry per lattice vertex, in the order of
/// [`Lattice::indices`], in scene units and the axes of the world.
#[derive(Debug)]
pub struct Body {
    name: String,
    material: Material,
    lattice: Lattice,
    surface: Option<Surface>,
    volume: VolumeOptions,
    correction: Option<Correction>,
    /// Built for the first report.
    measures: OnceLock<VolumeMeasures>,
    /// From the model's frame to the world at frame 0.
    placed: Isometry3<f64>,
    state: State,

    // The stages: see `step`.
    matching: Matching,
    workspace: Workspace,
    momentum: MomentumTracker,
    /// Built when a region first has two best rotations.
    energy: Option<EnergyLimiter>,
    region_damping: Option<RegionDamper>,
    forces: Option<Forces>,
    contacts: Option<Contacts>,
    constraints: Option<Constraints>,
    /// Rotations that Newton's method left to the robust path.
    unsettled: usize,
}

impl Body {
    /// A body from a mesh.
    pub fn builder(mesh: Mesh) -> BodyBuilder {
        BodyBuilder::from_mesh(mesh)
    }

    /// A body from a bare lattice, with no mesh to show.
    pub fn from_lattice(lattice: Lattice) -> BodyBuilder {
        BodyBuilder::from_lattice(lattice)
    }

    /// The body's name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The lattice, in the model's frame: after `scale`, before `rotate` and `translate`.
    pub fn lattice(&self) -> &Lattice {
        &self.lattice
    }

    /// The mesh in the model's frame; `None` for a bare lattice.
    pub fn mesh(&self) -> Option<&Mesh> {
        self.surface.as_ref().map(|surface| &surface.mesh)
    }

    /// The material.
    pub fn material(&self) -> &Material {
        &self.material
    }

    /// The half-width of the regions in cells: the material's, at most the extent of the lattice.
    pub fn half_width(&self) -> usize {
        self.matching.regions.half_width()
    }

    /// Positions, shape `(n, 3)`.
    pub fn positions(&self) -> Vec<Point3<f64>> {
        self.by_vertex(|slot| self.state.frame.to_world(self.state.local(slot)))
    }

    /// Sets all positions, one per vertex. Velocities, pins and the rest stay as they are.
    ///
    /// # Errors
    ///
    /// A wrong number of positions, or a number that is not finite or beyond 10^15 cells.
    pub fn set_positions(&mut self, positions: &[Point3<f64>]) -> Result<(), ArrayError> {
        self.check("positions", positions.len(), positions.iter().map(|p| p.coords))?;
        self.state.set_world(self.matching.layout.slots(), positions);
        Ok(())
    }

    /// Velocities in scene units per second, shape `(n, 3)`.
    pub fn velocities(&self) -> Vec<Vector3<f64>> {
        self.by_vertex(|slot| self.state.frame.velocity_to_world(self.state.velocities.get(slot)))
    }

    /// Sets all velocities, one per vertex. Positions, pins and the rest stay as they are.
    ///
    /// # Errors
    ///
    /// A wrong number of velocities, or a number that is not finite or beyond 10^15 cells/s.
    pub fn set_velocities(&mut self, velocities: &[Vector3<f64>]) -> Result<(), ArrayError> {
        self.check("velocities", velocities.len(), velocities.iter().copied())?;
        self.state.set_world_velocities(self.matching.layout.slots(), velocities);
        Ok(())
    }

    /// The rotation of the region around each vertex from the rest pose, in the last step, shape `(n, 3, 3)`.
    pub fn rotations(&self) -> Vec<Matrix3<f64>> {
        self.by_vertex(|slot| {
            let [x, y, z, w] = self.state.rotations.get(slot).map(f64::from);
            UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z)).to_rotation_matrix().into_inner()
        })
    }

    /// Masses, one per vertex: density x cell_size³ x occupied cells / 8.
    pub fn masses(&self) -> Vec<f64> {
        (0..self.lattice.len() as u32).map(|vertex| self.mass(vertex)).collect()
    }

    fn mass(&self, vertex: u32) -> f64 {
        mass(&self.material, &self.lattice, vertex)
    }

    /// Creates or removes the contact stage: a body among colliders has one.
    pub(crate) fn meet(&mut self, colliders: &Colliders) {
        if colliders.is_empty() {
            self.contacts = None;
        } else if self.contacts.is_none() {
            self.contacts = Some(Contacts::new(self.samples()));
        }
    }

    /// The points on which contacts act: of the visible surface, or of the boundary of a bare lattice.
    fn samples(&self) -> SampleCells {
        let slots = self.matching.layout.slots();
        match &self.surface {
            Some(surface) => SampleCells::of_mesh(&surface.mesh, &self.lattice, slots),
            None => SampleCells::of_lattice(&self.lattice, slots),
        }
    }

    /// The goal positions of the current positions, shape `(n, 3)`. No time passes.
    pub fn goals(&self) -> Vec<Point3<f64>> {
        let (mut workspace, executor) = (Workspace::default(), Executor::sequential());
        let mut rotations = self.state.rotations.clone();
        let fitted = (&self.state.positions, &mut rotations);
        self.matching.fit(&mut workspace, &executor, fitted, None, Purpose::Adjoint);
        let goals = self.matching.goals(&workspace, &executor);
        self.by_vertex(|slot| self.state.frame.to_world(goals.get(slot).map(f64::from).into()))
    }

    /// The volume correction as it was asked for.
    pub fn volume_options(&self) -> VolumeOptions {
        self.volume
    }

    /// Rotations in all steps so far that Newton's method left to the robust path.
    pub fn unsettled_rotations(&self) -> usize {
        self.unsettled
    }

    /// One value per vertex, from its slot.
    fn by_vertex<T>(&self, value: impl FnMut(u32) -> T) -> Vec<T> {
        self.matching.layout.slots().iter().copied().map(value).collect()
    }

    /// The greatest coordinate that is accepted, in scene units.
    fn farthest(&self) -> f64 {
        FARTHEST * self.lattice.cell_size()
    }

    fn check(
        &self,
        name: &'static str,
        count: usize,
        values: impl Iterator<Item = Vector3<f64>>,
    ) -> Result<(), ArrayError> {
        if count != self.lattice.len() {
            return Err(ArrayError::Length { name, count, expected: self.lattice.len() });
        }
        for (index, value) in values.enumerate() {
            if !value.iter().all(|x| x.is_finite()) {
                return Err(ArrayError::NotFinite { name, index, value: value.into() });
            }
            let limit = self.farthest();
            if value.amax() > limit {
                return Err(ArrayError::TooFar { name, index, value: value.into(), limit });
            }
        }
        Ok(())
    }
}

/// The mass of a lattice vertex: density x cell_size³ x occupied cells / 8.
fn mass(material: &Material, lattice: &Lattice, vertex: u32) -> f64 {
    let cell = material.density * lattice.cell_size().powi(3);
    cell * f64::from(lattice.occupied_cells()[vertex as usize]) / 8.0
}

/// The mesh that is shown, and its position in the lattice.
#[derive(Debug)]
struct Surface {
    mesh: Mesh,
    embedding: Embedding,
    skin: Skin,
}

impl Surface {
    fn borrowed(&self) -> volume::Surface<'_> {
        volume::Surface { mesh: &self.mesh, embedding: &self.embedding }
    }
}

/// An array that does not fit the body.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ArrayError {
    /// A wrong number of entries.
    #[error("{name} has {count} entries; the body has {expected} lattice vertices")]
    Length {
        /// The array.
        name: &'static str,
        /// Its entries.
        count: usize,
        /// The body's lattice vertices.
        expected: usize,
    },
    /// A number that is not finite.
    #[error("{name}[{index}] = {value:?} is not finite")]
    NotFinite {
        /// The array.
        name: &'static str,
        /// The entry.
        index: usize,
        /// Its value.
        value: [f64; 3],
    },
    /// A number so large that f64 does not separate neighbouring vertices.
    #[error("{name}[{index}] = {value:?} is too large: the limit is {limit:.3e}, 10^15 cells")]
    TooFar {
        /// The array.
        name: &'static str,
        /// The entry.
        index: usize,
        /// Its value.
        value: [f64; 3],
        /// The greatest magnitude that is accepted.
        limit: f64,
    },
}
