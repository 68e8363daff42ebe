//! The state of a body: what a step changes and a checkpoint holds. All else can be rebuilt.
//!
//! | file | contents |
//! |---|---|
//! | `angles` | Euler angles in degrees, with the same bits on every machine |
//! | `placement` | where a body starts, and how it moves there |
//! | `frame` | the f64 frame of the f32 state, and the time interval of a step |
//! | here | positions, velocities, rotations, momenta |

mod angles;
mod frame;
mod placement;

pub use angles::{euler_degrees, sin_cos_degrees};
pub(crate) use frame::Frame;
pub use frame::{BodyFrame, BodyState, Interval};
pub use placement::Placement;

use nalgebra::{Point3, Vector3};

use crate::lattice::{Lattice, Layout};
use crate::simd::lanes::{Block, Lanes, Row};

/// Positions, velocities and rotations of a body's lattice vertices, in storage order.
///
/// Lengths are in cells, along the axes of the world, from the body's origin: f32 near zero, wherever the body is.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct State {
    pub(crate) frame: Frame,
    pub(crate) positions: Lanes<3>,
    /// What f32 rounded away from the positions.
    pub(crate) compensation: Lanes<3>,
    /// In cells/s.
    pub(crate) velocities: Lanes<3>,
    /// Of the region around each vertex, from the rest pose: unit quaternions x, y, z, w.
    pub(crate) rotations: Lanes<4>,
    /// Whether a step has fitted the rotations since the positions were set or the regions changed.
    pub(crate) fitted: bool,
    /// The momenta of each component without constraints and contacts; `None` until they are measured.
    pub(crate) momenta: Vec<Option<Momentum>>,
    /// The most energy that the body may have while nothing acts on it; `None` until a region comes near two best
    /// rotations.
    pub(crate) energy_limit: Option<EnergyLimit>,
}

/// Eight identity quaternions.
pub(crate) const IDENTITIES: Block<4> = [Row::ZERO, Row::ZERO, Row::ZERO, Row::all(1.0)];

impl State {
    /// A lattice at rest where it is placed.
    pub(crate) fn at_rest(lattice: &Lattice, layout: &Layout, placement: &Placement) -> Self {
        let (rotation, translation) = (placement.rotation(), Vector3::from(placement.translate));
        let (low, high) = index_bounds(lattice.indices());
        let middle = Vector3::from_fn(|c, _| (f64::from(low[c]) + f64::from(high[c])) / 2.0).map(f64::floor);
        let extent = (0..3).map(|c| f64::from(high[c]) - f64::from(low[c])).fold(1.0, f64::max);
        let cell_size = lattice.cell_size();
        let base = rotation * (lattice.origin() + middle * cell_size) + translation;
        let quantum = 2.0_f64.powf(extent.log2().ceil());
        let (shift, velocity) = ([0.0; 3], [0.0; 3]);
        let frame = Frame { base: base.coords.into(), shift, velocity, cell_size, quantum };

        let mut state = Self {
            frame,
            positions: Lanes::zeros(layout.blocks()),
            compensation: Lanes::zeros(layout.blocks()),
            velocities: Lanes::zeros(layout.blocks()),
            rotations: Lanes::filled(layout.blocks(), IDENTITIES),
            fitted: true,
            momenta: vec![None; lattice.components().count],
            energy_limit: None,
        };
        let turned = [rotation.i as f32, rotation.j as f32, rotation.k as f32, rotation.w as f32];
        for (&slot, index) in layout.slots().iter().zip(lattice.indices()) {
            let offset = Vector3::from_fn(|c, _| f64::from(index[c])) - middle;
            state.put(slot, rotation * offset);
            state.rotations.set(slot, turned);
        }
        state
    }

    /// Whether all arrays have `blocks` blocks, and there are `components` components.
    pub(crate) fn is_whole(&self, blocks: usize, components: usize) -> bool {
        let Self { positions, compensation, velocities, rotations, .. } = self;
        let of_three =
            [positions, compensation, velocities].iter().all(|lanes| lanes.blocks().len() == blocks);
        of_three && rotations.blocks().len() == blocks && self.momenta.len() == components
    }

    /// Memory that the state takes.
    pub(crate) fn bytes(&self) -> usize {
        let Self { positions, compensation, velocities, rotations, .. } = self;
        positions.bytes() + compensation.bytes() + velocities.bytes() + rotations.bytes()
    }

    /// Gives a lattice at rest the velocity and the spin of its placement.
    pub(crate) fn set_in_motion(&mut self, lattice: &Lattice, layout: &Layout, placement: &Placement) {
        let spin = Vector3::from(placement.spin);
        let velocity = Vector3::from(placement.velocity) / self.frame.cell_size;
        let masses = lattice.occupied_cells().iter().map(|&cells| f64::from(cells));
        let mass: f64 = masses.clone().sum();
        let center: Vector3<f64> =
            layout.slots().iter().zip(masses).map(|(&slot, m)| self.local(slot) * (m / mass)).sum();
        for &slot in layout.slots() {
            let turning = spin.cross(&(self.local(slot) - center));
            self.velocities.set(slot, turning.map(|v| v as f32).into());
        }
        // What all have in common is kept in f64.
        self.frame.velocity = velocity.into();
    }

    /// The part of the state that constraints and contacts change.
    pub(crate) fn shared(&mut self) -> BodyState<'_> {
        BodyState {
            frame: self.frame.body_frame(),
            positions: &mut self.positions,
            compensation: Some(&mut self.compensation),
            velocities: &mut self.velocities,
        }
    }

    /// The position of a slot in cells from the body's origin.
    pub(crate) fn local(&self, slot: u32) -> Vector3<f64> {
        let (high, low) = (self.positions.get(slot), self.compensation.get(slot));
        Vector3::from_fn(|c, _| f64::from(high[c]) + f64::from(low[c]))
    }

    /// Sets the position of a slot, in cells from the body's origin.
    pub(crate) fn put(&mut self, slot: u32, local: Vector3<f64>) {
        let high: [f32; 3] = local.map(|x| x as f32).into();
        self.positions.set(slot, high);
        self.compensation.set(slot, std::array::from_fn(|c| (local[c] - f64::from(high[c])) as f32));
    }

    /// Positions of the world for all slots of `slots`, the origin moved near their mean.
    pub(crate) fn set_world(&mut self, slots: &[u32], world: &[Point3<f64>]) {
        let mean = world.iter().map(|p| self.frame.to_local(*p) / world.len() as f64).sum();
        self.frame.shift = (Vector3::from(self.frame.shift) + self.frame.nearest(mean)).into();
        for (&slot, &point) in slots.iter().zip(world) {
            self.put(slot, self.frame.to_local(point));
        }
        self.fitted = false;
        self.momenta.fill(None);
    }

    /// Velocities of the world in scene units per second for all slots of `slots`; their mean becomes the origin's.
    pub(crate) fn set_world_velocities(&mut self, slots: &[u32], world: &[Vector3<f64>]) {
        let cells = |v: &Vector3<f64>| v / self.frame.cell_size;
        let mean = world.iter().map(|v| cells(v) / world.len() as f64).sum::<Vector3<f64>>();
        for (&slot, velocity) in slots.iter().zip(world) {
            self.velocities.set(slot, (cells(velocity) - mean).map(|v| v as f32).into());
        }
        self.frame.velocity = mean.into();
        self.momenta.fill(None);
    }

    /// Gives the origin `velocity`, in cells/s, and the vertices what they had beside it.
    pub(crate) fn set_origin_velocity(&mut self, slots: &[u32], velocity: Vector3<f64>) {
        let change = self.frame.velocity() - velocity;
        if change == Vector3::zeros() {
            return;
        }
        for &slot in slots {
            let local = Vector3::from(self.velocities.get(slot).map(f64::from)) + change;
            self.velocities.set(slot, local.map(|v| v as f32).into());
        }
        self.frame.velocity = velocity.into();
        self.momenta.fill(None);
    }

    /// Invalidates the momenta of the component of a lattice vertex.
    pub(crate) fn invalidate_momentum(&mut self, lattice: &Lattice, vertex: u32) {
        self.momenta[lattice.components().of_vertex[vertex as usize] as usize] = None;
    }

    /// Whether the body has moved so far from its origin that [`State::rebase`] is due, judged by one vertex.
    pub(crate) fn strayed(&self, slot: u32) -> bool {
        self.positions.get(slot).iter().any(|x| f64::from(x.abs()) > 2.0 * self.frame.quantum)
    }

    /// Moves the origin to the multiple of the quantum nearest to `center`, in cells; the body stays.
    pub(crate) fn rebase(&mut self, slots: &[u32], center: Vector3<f64>) {
        let by = self.frame.nearest(center);
        if by == Vector3::zeros() {
            return;
        }
        self.frame.shift = (Vector3::from(self.frame.shift) + by).into();
        for &slot in slots {
            self.put(slot, self.local(slot) - by);
        }
    }
}

/// The momenta of one component: masses in full cells, lengths in cells.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Momentum {
    /// Σ m v, in cell masses times cells/s.
    pub(crate) linear: [f64; 3],
    /// Σ m (x - c) x v about the component's center of mass.
    pub(crate) angular: [f64; 3],
}

/// The most energy that a body may have.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct EnergyLimit {
    /// In full cells times (cells/s)².
    pub(crate) energy: f64,
    /// The alpha/dt in 1/s and the dt in seconds of the measurement: others make it another energy.
    pub(crate) stiffness_rate: f64,
    pub(crate) dt: f64,
}

/// The least and the greatest grid index along each axis.
pub(crate) fn index_bounds(indices: &[[i32; 3]]) -> ([i32; 3], [i32; 3]) {
    indices.iter().fold(([i32::MAX; 3], [i32::MIN; 3]), |(low, high), index| {
        (std::array::from_fn(|c| low[c].min(index[c])), std::array::from_fn(|c| high[c].max(index[c])))
    })
}
