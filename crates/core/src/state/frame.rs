//! Defines the frame in which the state of a body is stored, and the time interval of a step.

use nalgebra::{Point3, Vector3};

use crate::simd::lanes::Lanes;
use crate::simd::vector::wide;

/// The frame in which the state of a body is stored. The world position of a stored position x is
/// `base` + `cell_size` (`shift` + x).
///
/// The origin of a free body, one without constraints and contacts, moves with the body. The displacement and
/// the velocity of the origin are in f64, so that the accuracy of the f32 positions and velocities does not
/// depend on the distance and the speed of the body.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Frame {
    /// Initial world position of the origin, in scene units.
    pub(super) base: [f64; 3],
    /// Displacement of the origin from `base`, in cells.
    pub(super) shift: [f64; 3],
    /// Velocity of the origin, in cells/s. The stored velocities of the vertices are relative to it.
    pub(super) velocity: [f64; 3],
    /// Edge length of a cell in scene units.
    pub(super) cell_size: f64,
    /// Quantum in cells: [`State::rebase`](super::State::rebase) moves the origin by multiples of it. It is a
    /// power of two and at least the extent of the body in the rest pose.
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

    /// Returns the edge length of a cell in scene units.
    pub(crate) fn cell_size(self) -> f64 {
        self.cell_size
    }

    /// Returns the velocity of the origin, in cells/s.
    pub(crate) fn velocity(self) -> Vector3<f64> {
        self.velocity.into()
    }

    /// Converts a velocity in cells/s relative to the origin to a world velocity in scene units per second.
    pub(crate) fn velocity_to_world(self, local: [f32; 3]) -> Vector3<f64> {
        (self.velocity() + Vector3::from(local.map(f64::from))) * self.cell_size
    }

    /// Advances the origin by one step of `dt` seconds: adds `velocity_change`, in cells/s, to its velocity,
    /// then moves it with the new velocity.
    pub(crate) fn advance_origin(&mut self, velocity_change: Vector3<f64>, dt: f64) {
        let velocity = self.velocity() + velocity_change;
        self.velocity = velocity.into();
        self.shift = (Vector3::from(self.shift) + velocity * dt).into();
    }

    /// Rounds each coordinate of a point, in cells from the origin, to a multiple of the quantum. A
    /// coordinate that is not finite becomes 0.
    pub(super) fn nearest(self, local: Vector3<f64>) -> Vector3<f64> {
        local.map(|x| if x.is_finite() { (x / self.quantum).round() * self.quantum } else { 0.0 })
    }
}

/// The transformation from the local coordinates of a body to world space:
/// `world = origin + cell_size * local`.
///
/// The local axes are parallel to the world axes. Local coordinates are in cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyFrame {
    /// World position of the local origin, in scene units.
    pub origin: Point3<f64>,
    /// Edge length of a lattice cell in scene units, > 0.
    pub cell_size: f64,
}

impl BodyFrame {
    /// World space itself: local coordinates are world coordinates, in scene units.
    pub(crate) const WORLD: Self = Self { origin: Point3::new(0.0, 0.0, 0.0), cell_size: 1.0 };

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

/// Returns the position of a slot: its f32 coordinates and their rounding errors.
#[inline]
pub(super) fn position_of(positions: &Lanes<3>, compensation: &Lanes<3>, slot: u32) -> Vector3<f64> {
    wide(positions.get(slot)) + wide(compensation.get(slot))
}

/// Sets the position of a slot: its f32 coordinates and, if they are stored, their rounding errors.
#[inline]
pub(super) fn set_position_of(
    positions: &mut Lanes<3>,
    compensation: Option<&mut Lanes<3>>,
    slot: u32,
    position: Vector3<f64>,
) {
    let high: [f32; 3] = position.map(|x| x as f32).into();
    positions.set(slot, high);
    if let Some(compensation) = compensation {
        compensation.set(slot, (position - wide(high)).map(|x| x as f32).into());
    }
}

/// The positions and velocities of one body, for the stages that change them: constraints, contacts, forces.
///
/// A slot is the index of a lattice vertex in the storage order ([`Lanes`]).
#[derive(Debug)]
pub struct BodyState<'a> {
    /// Positions by slot, in cells from the local origin.
    pub positions: &'a mut Lanes<3>,
    /// Rounding errors of the f32 positions, or `None` if they are not stored. The exact position is
    /// `positions` + `compensation`.
    pub compensation: Option<&'a mut Lanes<3>>,
    /// Velocities by slot, in cells per second, relative to the velocity of the local origin.
    pub velocities: &'a mut Lanes<3>,
    /// Transformation from local coordinates to world space.
    pub frame: BodyFrame,
}

impl BodyState<'_> {
    /// Returns the position of a slot, in cells from the local origin.
    #[inline]
    pub fn position(&self, slot: u32) -> Vector3<f64> {
        match &self.compensation {
            Some(compensation) => position_of(self.positions, compensation, slot),
            None => wide(self.positions.get(slot)),
        }
    }

    /// Sets the position of a slot, in cells from the local origin.
    #[inline]
    pub fn set_position(&mut self, slot: u32, position: Vector3<f64>) {
        set_position_of(self.positions, self.compensation.as_deref_mut(), slot, position);
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

/// The time interval of a step, in seconds.
///
/// Start and end are computed as a number of steps times the step length, not as running sums. So the end of
/// a step is bit-identical to the start of the next step.
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
    /// Returns the interval of the step that follows the first `count` steps, each `dt` seconds long.
    #[cfg(any(test, feature = "internals"))]
    pub fn of_step(count: u64, dt: f64) -> Self {
        Self { start: count as f64 * dt, end: (count + 1) as f64 * dt, dt }
    }
}
