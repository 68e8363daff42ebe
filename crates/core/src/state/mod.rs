//! The state of a body: the data that a step changes and a checkpoint stores. All other data can be rebuilt.
//!
//! | file | contents |
//! |---|---|
//! | `placement` | initial position, orientation and velocity of a body |
//! | `frame` | the f64 frame of the f32 positions and velocities; the time interval of a step |
//! | `origin` | moves the origin of the frame with the body |
//! | `pressing` | contacts that pressed in a step, as one |
//! | `supports` | the contacts that pressed on the body in the last step |
//! | `pair_supports` | the contacts between bodies that pressed on them in the last step |
//! | `touches` | the contacts with other bodies in the last step, and the forces of those with colliders |
//! | `place` | the place of a body at a time, from which its displacements are measured |
//! | `rest` | how long a body has been at rest, and whether it sleeps |
//! | `rigid` | pose and momenta of a rigid body, and its mobility |
//! | `errors` | arrays that do not fit a body |
//! | `escapes` | the translations by which components leave colliders in which they began |
//! | `mod` | [`State`]: positions, velocities, rotations and momenta |

mod errors;
mod escapes;
mod frame;
mod origin;
mod pair_supports;
mod place;
mod placement;
mod pressing;
mod rest;
mod rigid;
mod supports;
mod touches;

pub use errors::ArrayError;
pub(crate) use escapes::Escapes;
pub(crate) use frame::Frame;
pub use frame::{BodyFrame, BodyState, Interval};
pub(crate) use pair_supports::{PairSupport, PairSupports};
pub use placement::Placement;
pub(crate) use pressing::{Deflection, Pressing, PressingContact};
pub(crate) use rest::{Rest, Stay};
pub(crate) use rigid::{RigidMobility, RigidPose, Twist};
pub(crate) use supports::{Support, SupportingContact, Supports};
pub(crate) use touches::{ContactForce, ContactKey, SampleTouch, SearchedMotion, TouchedPoint, Touches};

use nalgebra::{Point3, Vector3};

use crate::lattice::{Lattice, Layout};
use crate::simd::lanes::{Block, Lanes, Row};

/// The state of a body: positions, velocities and rotations of its lattice vertices.
///
/// The arrays are indexed by slot, the index of a vertex in the storage order ([`Lanes`]). Positions are in
/// cells from the body's origin, along the world axes. The origin stays near the body, so that the f32
/// coordinates are small.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct State {
    pub(crate) frame: Frame,
    pub(crate) positions: Lanes<3>,
    /// Rounding errors of the f32 positions: the exact position is `positions` + `compensation`.
    pub(crate) compensation: Lanes<3>,
    /// Velocities relative to the frame's origin, in cells/s.
    pub(crate) velocities: Lanes<3>,
    /// Rotation of the region around each vertex, relative to the rest pose: unit quaternions (x, y, z, w).
    pub(crate) rotations: Lanes<4>,
    /// Plastic strain S - 1 of the region around each vertex, with its plastic shape S: xx, yy, zz, xy, xz, yz in the
    /// rest pose. `None` without plasticity.
    pub(crate) strains: Option<Lanes<6>>,
    /// Whether the rotations are up to date. `false` after a caller has set positions or changed the regions,
    /// until the next step fits the rotations.
    pub(crate) fitted: bool,
    /// Momenta of each connected component of the lattice. They are conserved in a component without
    /// constraints and contacts. `None` for a component whose momenta are not conserved or not yet measured.
    pub(crate) momenta: Vec<Option<Momentum>>,
    /// Energy limit of a free body: a body without constraints and contacts. `None` before the first step in
    /// which Newton's method fails to converge for the rotation of a region. The energy can grow only in such
    /// steps (`dynamics::energy`).
    pub(crate) energy_limit: Option<EnergyLimit>,
    /// The remaining steps of a recovery from a tangled state (`dynamics::recovery`); 0 if there is none.
    pub(crate) recovery_steps: u32,
    pub(crate) supports: Supports,
    pub(crate) touches: Touches,
    pub(crate) escapes: Escapes,
    pub(crate) rest: Rest,
    /// `None` if the body is not rigid.
    pub(crate) rigid: Option<RigidPose>,
}

/// Eight identity quaternions.
pub(crate) const IDENTITIES: Block<4> = [Row::ZERO, Row::ZERO, Row::ZERO, Row::all(1.0)];

impl State {
    /// Creates the state of an undeformed lattice in its placement, with velocity zero.
    pub(crate) fn at_rest(lattice: &Lattice, layout: &Layout, placement: &Placement) -> Self {
        let (rotation, translation) = (placement.rotation(), Vector3::from(placement.translate));
        let (low, high) = index_bounds(lattice.indices());
        let middle = Vector3::from_fn(|c, _| (f64::from(low[c]) + f64::from(high[c])) / 2.0).map(f64::floor);
        let extent = (0..3).map(|c| f64::from(high[c]) - f64::from(low[c])).fold(1.0, f64::max);
        let cell_size = lattice.cell_size();
        let base = rotation * (lattice.origin() + middle * cell_size) + translation;
        let quantum = libm::pow(2.0_f64, libm::log2(extent).ceil());
        let (shift, velocity) = ([0.0; 3], [0.0; 3]);
        let frame = Frame { base: base.coords.into(), shift, velocity, cell_size, quantum };

        let mut state = Self {
            frame,
            positions: Lanes::zeros(layout.blocks()),
            compensation: Lanes::zeros(layout.blocks()),
            velocities: Lanes::zeros(layout.blocks()),
            rotations: Lanes::filled(layout.blocks(), IDENTITIES),
            strains: None,
            fitted: true,
            momenta: vec![None; lattice.components().count],
            energy_limit: None,
            recovery_steps: 0,
            supports: Supports::default(),
            touches: Touches::default(),
            escapes: Escapes::default(),
            rest: Rest::default(),
            rigid: None,
        };
        let quaternion = [rotation.i as f32, rotation.j as f32, rotation.k as f32, rotation.w as f32];
        for (&slot, index) in layout.slots().iter().zip(lattice.indices()) {
            let offset = Vector3::from_fn(|c, _| f64::from(index[c])) - middle;
            state.set_local(slot, rotation * offset);
            state.rotations.set(slot, quaternion);
        }
        state
    }

    /// Checks deserialized data. Returns whether each array has `blocks` blocks of eight vertices and the
    /// momenta have `components` entries.
    pub(crate) fn is_valid(&self, blocks: usize, components: usize) -> bool {
        let Self { positions, compensation, velocities, rotations, strains, .. } = self;
        let supports_match =
            self.supports.list().iter().all(|support| (support.component as usize) < components);
        let vectors_match =
            [positions, compensation, velocities].iter().all(|lanes| lanes.blocks().len() == blocks);
        vectors_match
            && supports_match
            && self.touches.is_valid(blocks, components)
            && self.escapes.is_valid(components)
            && self.rest.is_valid(blocks)
            && self.rigid.is_none_or(|rigid| rigid.is_valid())
            && rotations.blocks().len() == blocks
            && strains.as_ref().is_none_or(|strains| are_strains_valid(strains, blocks))
            && self.momenta.len() == components
    }

    /// Returns the memory in bytes.
    pub(crate) fn bytes(&self) -> usize {
        let Self { positions, compensation, velocities, rotations, strains, .. } = self;
        let lanes = positions.bytes() + compensation.bytes() + velocities.bytes() + rotations.bytes();
        lanes + strains.as_ref().map_or(0, Lanes::bytes) + self.touches.bytes() + self.rest.bytes()
    }

    /// Sets the velocities of an undeformed lattice from the velocity and the spin of its placement. `masses` has the
    /// mass of each vertex.
    pub(crate) fn set_initial_velocities(&mut self, masses: &[f32], layout: &Layout, placement: &Placement) {
        let spin = Vector3::from(placement.spin);
        let velocity = Vector3::from(placement.velocity) / self.frame.cell_size;
        let masses = masses.iter().map(|&mass| f64::from(mass));
        let mass: f64 = masses.clone().sum();
        let center: Vector3<f64> =
            layout.slots().iter().zip(masses).map(|(&slot, m)| self.local(slot) * (m / mass)).sum();
        for &slot in layout.slots() {
            let rotational = spin.cross(&(self.local(slot) - center));
            self.velocities.set(slot, rotational.map(|v| v as f32).into());
        }
        // The frame stores the common velocity of all vertices in f64.
        self.frame.velocity = velocity.into();
    }

    /// Returns the motion of the body since its contacts with other bodies were searched: see
    /// [`Touches::searched_motion`].
    pub(crate) fn searched_motion(
        &mut self,
        occupied: &[u8],
        limit: f64,
        is_relative: bool,
    ) -> SearchedMotion {
        self.touches.searched_motion((&self.positions, self.frame.shift), occupied, limit, is_relative)
    }

    /// Adds a step of `dt` seconds to the time of rest. `is_slow`: whether all vertices were slow, or stayed where other
    /// bodies were searched.
    pub(crate) fn track_rest(&mut self, dt: f64, is_slow: bool, stay: Stay) {
        self.rest.add(dt, is_slow);
        match stay {
            Stay::Impossible => self.rest.leave(),
            Stay::Possible { stays } => self.rest.stay((&self.positions, self.frame.shift), dt, stays),
        }
    }

    /// Returns an upper bound of the distance in cells of a vertex from the place in which the body has stayed; `None` if
    /// there is no such place. `occupied` has the bit mask of the lanes with a vertex of each block.
    pub(crate) fn distance_from_place(&self, occupied: &[u8]) -> Option<f64> {
        self.rest.place().greatest_distance((&self.positions, self.frame.shift), occupied)
    }

    /// Returns the displacement in cells of the vertex of a slot from the place in which the body has stayed.
    pub(crate) fn displacement_from_place(&self, slot: u32) -> Vector3<f64> {
        self.rest.place().displacement((&self.positions, self.frame.shift), slot)
    }

    /// Returns the positions and velocities, for the stages that change them: constraints, contacts, forces.
    pub(crate) fn body_state(&mut self) -> BodyState<'_> {
        BodyState {
            frame: self.frame.body_frame(),
            positions: &mut self.positions,
            compensation: Some(&mut self.compensation),
            velocities: &mut self.velocities,
        }
    }

    /// Returns the position of a slot, in cells from the body's origin.
    pub(crate) fn local(&self, slot: u32) -> Vector3<f64> {
        frame::position_of(&self.positions, &self.compensation, slot)
    }

    /// Sets the position of a slot, in cells from the body's origin.
    pub(crate) fn set_local(&mut self, slot: u32, local: Vector3<f64>) {
        frame::set_position_of(&mut self.positions, Some(&mut self.compensation), slot, local);
    }

    /// Sets the positions of all vertices from the world positions `world`. Moves the origin near the mean
    /// position. `slots` has the slot of each vertex.
    pub(crate) fn set_world(&mut self, slots: &[u32], world: &[Point3<f64>]) {
        let mean = world.iter().map(|p| self.frame.to_local(*p) / world.len() as f64).sum();
        self.frame.shift = (Vector3::from(self.frame.shift) + self.frame.nearest(mean)).into();
        for (&slot, &point) in slots.iter().zip(world) {
            self.set_local(slot, self.frame.to_local(point));
        }
        self.fitted = false;
        self.recovery_steps = 0;
        self.supports.clear();
        self.touches.forget();
        self.escapes.search();
        self.momenta.fill(None);
    }

    /// Sets the velocities of all vertices from `world`, world velocities in scene units per second. The mean
    /// velocity becomes the velocity of the origin. `slots` has the slot of each vertex.
    pub(crate) fn set_world_velocities(&mut self, slots: &[u32], world: &[Vector3<f64>]) {
        let in_cells = |v: &Vector3<f64>| v / self.frame.cell_size;
        let mean = world.iter().map(|v| in_cells(v) / world.len() as f64).sum::<Vector3<f64>>();
        for (&slot, velocity) in slots.iter().zip(world) {
            self.velocities.set(slot, (in_cells(velocity) - mean).map(|v| v as f32).into());
        }
        self.frame.velocity = mean.into();
        self.momenta.fill(None);
    }

    /// Changes the velocity of a lattice vertex by dv, `change` in cells/s, in a step of `dt` seconds: v += dv and
    /// x += h dv, as contacts do with their impulses. Invalidates the momenta of its connected component. `slots` has the
    /// slot of each vertex.
    pub(crate) fn accelerate(
        &mut self,
        (lattice, slots): (&Lattice, &[u32]),
        vertex: u32,
        change: Vector3<f64>,
        dt: f64,
    ) {
        let (slot, mut state) = (slots[vertex as usize], self.body_state());
        state.set_position(slot, state.position(slot) + change * dt);
        state.set_velocity(slot, state.velocity(slot) + change);
        self.invalidate_momentum(lattice, vertex);
    }

    /// Invalidates the momenta of the connected component that contains a lattice vertex.
    pub(crate) fn invalidate_momentum(&mut self, lattice: &Lattice, vertex: u32) {
        self.momenta[lattice.components().of_vertex[vertex as usize] as usize] = None;
    }
}

/// Checks deserialized plastic strains. Returns whether they are finite and have `blocks` blocks.
fn are_strains_valid(strains: &Lanes<6>, blocks: usize) -> bool {
    strains.blocks().len() == blocks
        && strains.blocks().as_flattened().iter().all(|row| row.iter().all(|strain| strain.is_finite()))
}

/// The momenta of one connected component. Masses are in units of a full cell's mass, lengths in cells, and
/// velocities in cells/s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Momentum {
    /// Linear momentum Σ m v, with the mass m and the velocity v of each vertex, relative to the origin's
    /// velocity.
    pub(crate) linear: [f64; 3],
    /// Angular momentum Σ m (x - c) × v about the component's center of mass c, with the position x of each
    /// vertex.
    pub(crate) angular: [f64; 3],
}

impl Momentum {
    /// Adds other momenta.
    pub(crate) fn add(&mut self, other: Self) {
        for c in 0..3 {
            self.linear[c] += other.linear[c];
            self.angular[c] += other.angular[c];
        }
    }
}

/// The energy limit of a free body: the energy in the first step in which Newton's method did not converge
/// for the rotation of a region.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct EnergyLimit {
    /// Largest permitted energy, in units of a full cell's mass times (cells/s)².
    pub(crate) energy: f64,
    /// alpha/dt in 1/s when the energy was measured. The limit is valid only for this value and this `dt`.
    pub(crate) stiffness_rate: f64,
    /// Time step in seconds when the energy was measured.
    pub(crate) dt: f64,
}

/// Returns the smallest and the largest grid index along each axis.
pub(crate) fn index_bounds(indices: &[[i32; 3]]) -> ([i32; 3], [i32; 3]) {
    indices.iter().fold(([i32::MAX; 3], [i32::MIN; 3]), |(low, high), index| {
        (std::array::from_fn(|c| low[c].min(index[c])), std::array::from_fn(|c| high[c].max(index[c])))
    })
}
