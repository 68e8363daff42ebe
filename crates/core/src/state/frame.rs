//! The frame of a body's state, and the time interval of a step.

use nalgebra::{Point3, Vector3};

use crate::simd::lanes::Lanes;

/// The frame in which the state of a body is stored: world position = `base` + `cell_size` (`shift` + x).
///
/// The origin of a free body moves with the body. The common displacement and velocity of all vertices are in
/// f64, so that the accuracy of the f32 state does not depend on distance or speed.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Frame {
    /// Initial world position of the origin, in scene units.
    pub(super) base: [f64; 3],
    /// Displacement of the origin from `base`, in cells.
    pub(super) shift: [f64; 3],
    /// Velocity of the origin, in cells/s. The velocities of the state are relative to it.
    pub(super) velocity: [f64; 3],
    /// Edge length of a cell in scene units.
    pub(super) cell_size: f64,
    /// Unit of the shifts of [`State::rebase`](super::State::rebase): a power of two, at least the body's
    /// extent in the rest pose, in cells.
    pub(super) quantum: f64,
}

impl Frame {
    /// Converts a world position to cells from the body's origin.
    pub(crate) fn to_local(self, world: Point3<f64>) -> Vector3<f64> {
        (world - Point3::from(self.base)) / self.cell_size - Vector3::from(self.shift)
    }

    /// Converts a position in cells from the body's origin to world space.
    pub(crate) fn to_world(self, local: Vector3<f64>) -> Point3<f64> {
        Point3::from(self.base) + (Vector3::from(self.shift) + local) * self.cell_size
    }

    /// Returns the world position of the body's origin and the cell size.
    pub(crate) fn body_frame(self) -> BodyFrame {
        BodyFrame { origin: self.to_world(Vector3::zeros()), cell_size: self.cell_size }
    }

    /// The edge length of a cell in scene units.
    pub(crate) fn cell_size(self) -> f64 {
        self.cell_size
    }

    /// The velocity of the origin, in cells/s.
    pub(crate) fn velocity(self) -> Vector3<f64> {
        self.velocity.into()
    }

    /// Converts a velocity in cells/s relative to the origin to a world velocity in scene units per second.
    pub(crate) fn velocity_to_world(self, local: [f32; 3]) -> Vector3<f64> {
        (self.velocity() + Vector3::from(local.map(f64::from))) * self.cell_size
    }

    /// Advances the origin by one step: adds `gain` in cells/s to its velocity, then moves it.
    pub(crate) fn advance_origin(&mut self, gain: Vector3<f64>, dt: f64) {
        let velocity = self.velocity() + gain;
        self.velocity = velocity.into();
        self.shift = (Vector3::from(self.shift) + velocity * dt).into();
    }

    /// Rounds a point, in cells from the origin, to multiples of the quantum. Coordinates that are not finite
    /// become 0.
    pub(super) fn nearest(self, local: Vector3<f64>) -> Vector3<f64> {
        local.map(|x| if x.is_finite() { (x / self.quantum).round() * self.quantum } else { 0.0 })
    }
}

/// The transformation from the local coordinates of a body to world space:
/// `world = origin + cell_size * local`.
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
    /// Converts a local position to world space.
    #[inline]
    pub fn to_world(self, local: Vector3<f64>) -> Point3<f64> {
        self.origin + local * self.cell_size
    }

    /// Converts a world position to local coordinates.
    #[inline]
    pub fn to_local(self, world: &Point3<f64>) -> Vector3<f64> {
        (world - self.origin) / self.cell_size
    }
}

/// The positions and velocities of one body, as constraints, contacts and forces change them.
#[derive(Debug)]
pub struct BodyState<'a> {
    /// Local positions by slot, in cells.
    pub positions: &'a mut Lanes<3>,
    /// Rounding errors of the f32 positions, or `None` if they are not stored. A position is `positions` +
    /// `compensation`.
    pub compensation: Option<&'a mut Lanes<3>>,
    /// Velocities by slot, in cells per second.
    pub velocities: &'a mut Lanes<3>,
    /// Transformation from local coordinates to world space.
    pub frame: BodyFrame,
}

impl BodyState<'_> {
    /// Returns the position of a slot in cells.
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

    /// Returns the velocity of a slot in cells per second.
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

/// Converts to f64.
#[inline]
fn wide(value: [f32; 3]) -> Vector3<f64> {
    Vector3::from(value.map(f64::from))
}

/// The time interval of a step, in seconds.
///
/// Start and end are multiples of the step length, not running sums, so that the end of a step is
/// bit-identical to the start of the next.
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
    /// Returns the interval of the step after `count` steps of `dt` seconds.
    pub fn of_step(count: u64, dt: f64) -> Self {
        Self { start: count as f64 * dt, end: (count + 1) as f64 * dt, dt }
    }
}
