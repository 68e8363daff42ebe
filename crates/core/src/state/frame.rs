//! The body-local frame of the running state, and the time interval of a step.

use nalgebra::{Point3, Vector3};

use crate::Lanes;

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
    pub fn to_world(&self, local: Vector3<f64>) -> Point3<f64> {
        self.origin + local * self.cell_size
    }

    /// The local position of a world one.
    #[inline]
    pub fn to_local(&self, world: &Point3<f64>) -> Vector3<f64> {
        (world - self.origin) / self.cell_size
    }
}

/// The running state of one body as the stages of a step see it.
#[derive(Debug)]
pub struct BodyState<'a> {
    /// Local positions by slot, in cells.
    pub positions: &'a mut Lanes<3>,
    /// What f32 rounded away from the positions, where that is kept.
    pub carry: Option<&'a mut Lanes<3>>,
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
        self.carry.as_ref().map_or(high, |carry| high + wide(carry.get(slot)))
    }

    /// Sets the position of a slot in cells.
    #[inline]
    pub fn set_position(&mut self, slot: u32, position: Vector3<f64>) {
        let high: [f32; 3] = position.map(|x| x as f32).into();
        self.positions.set(slot, high);
        if let Some(carry) = &mut self.carry {
            carry.set(slot, (position - wide(high)).map(|x| x as f32).into());
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
