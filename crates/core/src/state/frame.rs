//! The frame in which the state of a body is stored, and the time interval of a step.

use nalgebra::{Point3, Vector3};

use crate::simd::lanes::Lanes;

/// The frame of a body's state: world = `base` + `cell_size` (`shift` + x).
///
/// The origin of a free body flies with it: what all vertices have in common is kept in f64, so that neither
/// distance nor speed costs accuracy.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Frame {
    pub(super) base: [f64; 3],
    /// In cells.
    pub(super) shift: [f64; 3],
    /// Velocity of the origin, in cells/s; velocities are relative to it.
    pub(super) velocity: [f64; 3],
    pub(super) cell_size: f64,
    /// A power of two, at least the body's extent at rest, in cells.
    pub(super) quantum: f64,
}

impl Frame {
    /// A position of the world in cells from the body's origin.
    pub(crate) fn to_local(self, world: Point3<f64>) -> Vector3<f64> {
        (world - Point3::from(self.base)) / self.cell_size - Vector3::from(self.shift)
    }

    /// A position in cells from the body's origin in the world.
    pub(crate) fn to_world(self, local: Vector3<f64>) -> Point3<f64> {
        Point3::from(self.base) + (Vector3::from(self.shift) + local) * self.cell_size
    }

    /// The body's origin in the world, and its unit.
    pub(crate) fn body_frame(self) -> BodyFrame {
        BodyFrame { origin: self.to_world(Vector3::zeros()), cell_size: self.cell_size }
    }

    /// Edge of a cell in scene units.
    pub(crate) fn cell_size(self) -> f64 {
        self.cell_size
    }

    /// The velocity of the origin, in cells/s.
    pub(crate) fn velocity(self) -> Vector3<f64> {
        self.velocity.into()
    }

    /// The velocity of the world in scene units per second of one in cells/s relative to the origin.
    pub(crate) fn velocity_to_world(self, local: [f32; 3]) -> Vector3<f64> {
        (self.velocity() + Vector3::from(local.map(f64::from))) * self.cell_size
    }

    /// Lets the origin fly on: it gains `gain` in cells/s, then moves.
    pub(crate) fn fly(&mut self, gain: Vector3<f64>, dt: f64) {
        let velocity = self.velocity() + gain;
        self.velocity = velocity.into();
        self.shift = (Vector3::from(self.shift) + velocity * dt).into();
    }

    /// The whole multiple of the quantum nearest to a point given in cells from the origin.
    pub(super) fn nearest(self, local: Vector3<f64>) -> Vector3<f64> {
        local.map(|x| if x.is_finite() { (x / self.quantum).round() * self.quantum } else { 0.0 })
    }
}

/// Where the running state of a body lies in the world: `world = origin + cell_size * local`.
///
/// The axes are those of the world; local coordinates are in cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyFrame {
    /// World position of the local origin, in scene units.
    pub origin: Point3<f64>,
    /// Edge length of a lattice cell in scene units, > 0.
    pub cell_size: f64,
}

impl BodyFrame {
    /// The world position of a local one.
    #[inline]
    pub fn to_world(self, local: Vector3<f64>) -> Point3<f64> {
        self.origin + local * self.cell_size
    }

    /// The local position of a world one.
    #[inline]
    pub fn to_local(self, world: &Point3<f64>) -> Vector3<f64> {
        (world - self.origin) / self.cell_size
    }
}

/// The running state of one body as the stages of a step see it.
#[derive(Debug)]
pub struct BodyState<'a> {
    /// Local positions by slot, in cells.
    pub positions: &'a mut Lanes<3>,
    /// What f32 rounded away from the positions, where that is kept.
    pub compensation: Option<&'a mut Lanes<3>>,
    /// Velocities by slot, in cells per second.
    pub velocities: &'a mut Lanes<3>,
    /// Where the local coordinates lie in the world.
    pub frame: BodyFrame,
}

impl BodyState<'_> {
    /// The position of a slot in cells.
    #[inline]
    pub fn position(&self, slot: u32) -> Vector3<f64> {
        let high = wide(self.positions.get(slot));
        self.compensation.as_ref().map_or(high, |compensation| high + wide(compensation.get(slot)))
    }

    /// Sets the position of a slot in cells.
    #[inline]
    pub fn set_position(&mut self, slot: u32, position: Vector3<f64>) {
        let high: [f32; 3] = position.map(|x| x as f32).into();
        self.positions.set(slot, high);
        if let Some(compensation) = &mut self.compensation {
            compensation.set(slot, (position - wide(high)).map(|x| x as f32).into());
        }
    }

    /// The velocity of a slot in cells per second.
    #[inline]
    pub fn velocity(&self, slot: u32) -> Vector3<f64> {
        wide(self.velocities.get(slot))
    }

    /// Sets the velocity of a slot in cells per second.
    #[inline]
    pub fn set_velocity(&mut self, slot: u32, velocity: Vector3<f64>) {
        self.velocities.set(slot, velocity.map(|x| x as f32).into());
    }
}

/// The same numbers in f64.
#[inline]
fn wide(value: [f32; 3]) -> Vector3<f64> {
    Vector3::from(value.map(f64::from))
}

/// The time that one step covers, in seconds.
///
/// Start and end are multiples of the step length and not running sums, so that the end of one step is, to
/// the bit, the start of the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Time at the start of the step.
    pub start: f64,
    /// Time at the end of the step.
    pub end: f64,
    /// Length of the step, > 0.
    pub dt: f64,
}

impl Interval {
    /// The step that follows `count` steps of length `dt` seconds.
    pub fn of_step(count: u64, dt: f64) -> Self {
        Self { start: count as f64 * dt, end: (count + 1) as f64 * dt, dt }
    }
}
