//! The data of a body that contact between bodies reads.

use std::sync::OnceLock;

use nalgebra::{Point3, Vector3};

use super::bounds::Bounds;
use super::deformed_cell::DeformedCell;
use super::motion::{PartMotions, PartVertices};
use super::near_cells::NearCells;
use super::posed::PosedLattice;
use super::surface::ContactSurface;
use crate::contact::Contacts;
use crate::lattice::Lattice;
use crate::simd::lanes::Lanes;
use crate::simd::vector::wide;
use crate::state::{RigidMobility, SearchedMotion, State};

/// The numbers of a step that contact between bodies depends on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ContactStep {
    /// Length of the step in seconds.
    pub dt: f64,
    /// Magnitude of gravity, in scene units per second squared.
    pub gravity: f64,
}

/// How a body touches other bodies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SurfaceProperties {
    /// Coulomb friction coefficient, >= 0.
    pub friction: f64,
    /// Coefficient of restitution, in [0, 1].
    pub restitution: f64,
    /// Distance outside of the surface at which the body touches, in scene units, >= 0.
    pub thickness: f64,
}

/// The data of contact between bodies that one body owns.
#[derive(Debug)]
pub(crate) struct BodyContact {
    /// Created when another body is near for the first time, or for contact of the body with itself. `None` if it has
    /// no area.
    surface: OnceLock<Option<ContactSurface>>,
    /// Velocities before the step, relative to `origin_velocity`, in cells/s.
    velocities_before: Lanes<3>,
    /// Velocity of the origin before the step, in cells/s.
    origin_velocity: Vector3<f64>,
    pub(super) motions: PartMotions,
    /// The distance that the body moved since its contacts were searched.
    pub(crate) searched: SearchedMotion,
    pub(crate) near_cells: NearCells,
    /// Buffer: the change of the momenta of each component by the contacts of a step.
    pub(crate) momentum_changes: Vec<MomentumChange>,
}

/// Change of the momenta of a component by contacts, in units of the body.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct MomentumChange {
    /// Sum of the impulses.
    pub linear: Vector3<f64>,
    /// Sum of the moments of the impulses about the center of mass.
    pub angular: Vector3<f64>,
    /// Sum of mass times displacement.
    pub moved: Vector3<f64>,
}

impl BodyContact {
    pub(crate) fn new() -> Self {
        Self {
            surface: OnceLock::new(),
            velocities_before: Lanes::default(),
            origin_velocity: Vector3::zeros(),
            motions: PartMotions::EMPTY,
            searched: SearchedMotion::UNKNOWN,
            near_cells: NearCells::default(),
            momentum_changes: Vec::new(),
        }
    }

    /// Returns the surface, which `create` creates if it does not exist; `None` if it has no area.
    pub(crate) fn surface_or(
        &self,
        create: impl FnOnce() -> Option<ContactSurface>,
    ) -> Option<&ContactSurface> {
        self.surface.get_or_init(create).as_ref()
    }

    /// Returns the surface, if it was created and has an area.
    pub(crate) fn created_surface(&self) -> Option<&ContactSurface> {
        self.surface.get().and_then(Option::as_ref)
    }

    /// Returns the surface. Only bodies in pairs are searched, and these have one.
    pub(in crate::contact) fn surface(&self) -> &ContactSurface {
        self.created_surface().expect("a body in a pair has a surface")
    }

    /// Returns the box of the body in the last step.
    pub(crate) fn bounds(&self) -> Bounds {
        self.motions.all.positions
    }

    /// Stores the velocities before the step.
    pub(crate) fn begin(&mut self, state: &State, vertices: &PartVertices<'_>) {
        self.velocities_before.copy_from(&state.velocities);
        self.origin_velocity = state.frame.velocity();
        self.motions.begin(state, vertices);
    }

    /// Measures the boxes of the positions and velocities at the end of the step.
    pub(crate) fn measure_bounds(&mut self, state: &State, vertices: &PartVertices<'_>) {
        self.motions.end(state, vertices);
    }

    /// Returns the memory in bytes.
    pub(crate) fn bytes(&self) -> usize {
        let surface = self.created_surface().map_or(0, ContactSurface::bytes);
        let changes = self.momentum_changes.capacity() * size_of::<MomentumChange>();
        surface + self.velocities_before.bytes() + self.motions.bytes() + self.near_cells.bytes() + changes
    }
}

/// A body, as contact between bodies reads it.
#[derive(Clone, Copy)]
pub(crate) struct BodyView<'a> {
    pub lattice: &'a Lattice,
    /// Slot of each lattice vertex.
    pub slots: &'a [u32],
    /// Mass of each lattice vertex in units of a full cell's mass.
    pub masses: &'a [f32],
    /// Mass of a full cell.
    pub cell_mass: f64,
    /// Whether each lattice vertex is constrained by a pin or handle; empty if none is.
    pub constrained: &'a [bool],
    /// Whether a part of the body touches itself.
    pub touches_itself: bool,
    pub state: &'a State,
    pub contact: &'a BodyContact,
    pub properties: SurfaceProperties,
    /// Factor of the coefficient of friction of each vertex of the lattice before the body broke; `None` if all are 1.
    pub friction_factors: Option<&'a [f64]>,
    /// The contacts with colliders, whose constraints are part of the problem of an island.
    pub contacts: Option<&'a Contacts>,
    /// The mobility of a rigid body; `None` if the body is not rigid.
    pub rigid: Option<&'a RigidMobility>,
}

impl BodyView<'_> {
    /// Returns the lattice vertices at the corners of a cell.
    #[inline]
    pub(super) fn corners(&self, cell: u32) -> [u32; 8] {
        self.contact.surface().corners[cell as usize]
    }

    /// Returns the geometry of a cell at the end of the step.
    pub(super) fn deformed_cell(&self, cell: u32) -> DeformedCell {
        DeformedCell::new(&self.corners(cell).map(|vertex| self.position(vertex)))
    }

    /// Returns the lesser cell size of two bodies.
    pub(super) fn lesser_cell_size(&self, other: &BodyView) -> f64 {
        self.lattice.cell_size().min(other.lattice.cell_size())
    }

    /// Poses the lattice `past` seconds before the end of the step, and prepares the search of points in `region`, and
    /// within `thickness` of the cells: of all cells, or of those `among` a list in increasing order.
    pub(super) fn pose(
        &self,
        posed: &mut PosedLattice,
        past: f64,
        region: &Bounds,
        thickness: f64,
        among: Option<&[u32]>,
    ) {
        let position = |vertex: u32| match past > 0.0 {
            true => self.position(vertex) - self.velocity(vertex) * past,
            false => self.position(vertex),
        };
        let positions = (0..self.lattice.len() as u32).map(position);
        let (lengths, surface) = ((self.lattice.cell_size(), thickness), self.contact.surface());
        match among {
            None => posed.pose(positions, surface, lengths, region, 0..surface.corners.len() as u32),
            Some(cells) => posed.pose(positions, surface, lengths, region, cells.iter().copied()),
        }
    }

    /// Lists the cells that may touch other cells of the body. `occupied` has the bit mask of the lanes with a vertex, for each
    /// block.
    pub(crate) fn list_near_cells(&self, cells: &mut NearCells, occupied: &[u8]) {
        let contact = (self.properties.thickness, self.touches_itself);
        let pose = |posed: &mut PosedLattice, reach: f64| self.pose(posed, 0.0, &Bounds::ALL, reach, None);
        let body = (self.contact.surface(), self.lattice);
        cells.update(body, contact, (&self.state.positions, occupied), pose);
    }

    /// Returns the world position of a lattice vertex.
    #[inline]
    pub(super) fn position(&self, vertex: u32) -> Point3<f64> {
        self.state.frame.to_world(self.state.local(self.slots[vertex as usize]))
    }

    /// Returns the velocity of a lattice vertex, in scene units per second.
    #[inline]
    pub(super) fn velocity(&self, vertex: u32) -> Vector3<f64> {
        self.state.frame.velocity_to_world(self.state.velocities.get(self.slots[vertex as usize]))
    }

    /// Returns the velocity of a lattice vertex before the step, in scene units per second.
    #[inline]
    pub(super) fn velocity_before(&self, vertex: u32) -> Vector3<f64> {
        let BodyContact { velocities_before, origin_velocity, .. } = self.contact;
        let local = wide(velocities_before.get(self.slots[vertex as usize]));
        (origin_velocity + local) * self.lattice.cell_size()
    }
}
