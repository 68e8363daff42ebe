//! A soft body: a lattice, what holds and touches it, and the mesh that is shown.

mod builder;
mod force;
mod hold;
mod look;
mod material;
mod place;
mod plan;
mod retune;
mod snapshot;
mod state;
mod step;
mod surroundings;
mod view;

pub use builder::BodyBuilder;
pub use look::ShownSurface;
pub(crate) use material::in_range;
pub use material::{Damping, Material, RangeError, Reach, Stiffness};
pub use place::Placement;
pub use snapshot::BodySnapshot;
pub(crate) use state::State;
pub(crate) use step::World;
pub(crate) use surroundings::Surroundings;
pub use view::ViewTimes;

use std::sync::Mutex;

use nalgebra::{Isometry3, Matrix3, Point3, Quaternion, UnitQuaternion, Vector3};

use crate::contact::Contacts;
use crate::dynamics::Kinematics;
use crate::dynamics::damping::RegionDamping;
use crate::dynamics::energy::EnergyGuard;
use crate::dynamics::momentum::Bookkeeper;
use crate::lattice::{Embedding, Lattice};
use crate::matching::Matching;
use crate::matching::cascade::Cascade;
use crate::mesh::Mesh;
use crate::volume;
use force::Forces;
use look::unlocked;
use view::View;

/// The greatest coordinate in cells, and speed in cells/s, that is taken: beyond it, f64 does not tell neighbouring
/// lattice vertices apart.
const FARTHEST: f64 = 1e15;

/// A soft body.
///
/// Its lattice vertices are the bodies of the dynamics; arrays are "one per vertex", in the order of
/// [`Lattice::indices`], in the units of the scene and the axes of the world.
#[derive(Debug)]
pub struct Body {
    name: String,
    material: Material,
    lattice: Lattice,
    surface: Option<Surface>,
    matching: Matching,
    /// Scratch of the sums, shared by all stages that sum and by those who look.
    cascade: Mutex<Cascade>,
    damping: Option<RegionDamping>,
    bookkeeper: Bookkeeper,
    /// Built when a region first has two best rotations.
    energy: Option<EnergyGuard>,
    /// Rotations that Newton's method left to the robust path.
    unsettled: usize,
    kinematics: Option<Kinematics>,
    contacts: Option<Contacts>,
    forces: Option<Forces>,
    state: State,
    /// From the model's frame to the world at frame 0.
    placed: Isometry3<f64>,
    surroundings: Surroundings,
    view: Mutex<View>,
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

    /// What the body is made of.
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

    /// The mass of a lattice vertex.
    fn mass(&self, vertex: u32) -> f64 {
        let cell = self.material.density * self.lattice.cell_size().powi(3);
        cell * f64::from(self.lattice.occupied_cells()[vertex as usize]) / 8.0
    }

    /// Rotations in all steps so far that Newton's method left to the robust path.
    pub fn unsettled_rotations(&self) -> usize {
        self.unsettled
    }

    /// One value per vertex, from its slot.
    fn by_vertex<T>(&self, value: impl FnMut(u32) -> T) -> Vec<T> {
        self.matching.layout.slots().iter().copied().map(value).collect()
    }

    /// The greatest coordinate that is taken, in scene units.
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

/// The mesh that is shown, and where it lies in the lattice.
#[derive(Debug)]
pub(crate) struct Surface {
    pub(crate) mesh: Mesh,
    pub(crate) embedding: Embedding,
}

impl Surface {
    /// As the volume measures take it.
    pub(crate) fn borrowed(&self) -> volume::Surface<'_> {
        volume::Surface { mesh: &self.mesh, embedding: &self.embedding }
    }
}

/// An array that does not fit the body.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
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
        /// What it is.
        value: [f64; 3],
    },
    /// A number so large that neighbouring vertices could not be told apart.
    #[error("{name}[{index}] = {value:?} is too large: the limit is {limit:.3e}, 10^15 cells")]
    TooFar {
        /// The array.
        name: &'static str,
        /// The entry.
        index: usize,
        /// What it is.
        value: [f64; 3],
        /// The greatest magnitude that is taken.
        limit: f64,
    },
}
