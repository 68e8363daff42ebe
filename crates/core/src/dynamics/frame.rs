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
    pub fn to_world(&self, local: [f32; 3]) -> Point3<f64> {
        self.origin + Vector3::from(local.map(f64::from)) * self.cell_size
    }

    /// The local position of a world one, rounded to f32 at the very end.
    #[inline]
    pub fn to_local(&self, world: &Point3<f64>) -> [f32; 3] {
        let local = (world - self.origin) / self.cell_size;
        [local.x as f32, local.y as f32, local.z as f32]
    }
}

/// The running state of one body as the stages of a step see it.
#[derive(Debug)]
pub struct BodyState<'a> {
    /// Local positions by slot, in cells.
    pub positions: &'a mut Lanes<3>,
    /// Velocities by slot, in cells per second.
    pub velocities: &'a mut Lanes<3>,
    /// Where the local coordinates lie in the world.
    pub frame: BodyFrame,
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
