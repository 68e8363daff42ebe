//! Moves vertices within limits of their displacements.

use nalgebra::Vector3;

use crate::simd::vector::wide;
use crate::volume::{Limits, Motion, project};

/// The limits of displacements.
#[derive(Clone, Copy)]
pub(super) struct Within<'a> {
    pub(super) limits: &'a Limits,
    /// Positions from which the displacements are counted.
    pub(super) start: &'a [[f32; 3]],
    /// Whether each vertex is held by pins or handles.
    pub(super) fixed: &'a [bool],
}

impl Within<'_> {
    /// Moves a vertex by a step, within its limits. A vertex that is fixed, and a step that is not finite, have no effect.
    ///
    /// * `along`: returns the step along a plane, from the unit normal of the plane and the part of the step along it.
    pub(super) fn advance(
        &self,
        vertex: u32,
        step: Vector3<f64>,
        along: impl Fn(Vector3<f64>, f64) -> Vector3<f64>,
        positions: &mut [[f32; 3]],
    ) {
        let index = vertex as usize;
        if self.fixed[index] {
            return;
        }
        let position = wide(positions[index]);
        let before = position - wide(self.start[index]);
        let limits = self.limits.of(vertex);
        let (mut step, motion) = project(limits, before, step);
        if let Motion::Sliding(normal) = motion {
            step = project(limits, before, along(normal, normal.dot(&step))).0;
        }
        let moved: [f32; 3] = (position + step).map(|x| x as f32).into();
        if moved.iter().all(|x| x.is_finite()) {
            positions[index] = moved;
        }
    }
}
