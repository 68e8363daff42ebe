//! Limits of the displacements of vertices, from their positions before the untangling.

use nalgebra::Vector3;

use super::cells::vector;
use crate::volume::Limit;

/// The half spaces in which vertices must stay, and the vertices that do not move.
#[derive(Debug, Default)]
pub(super) struct Limits {
    /// Positions from which the displacements are counted.
    start: Vec<[f32; 3]>,
    /// Limits, sorted by vertex.
    limits: Vec<Limit>,
    /// Whether each vertex is held by pins or handles.
    fixed: Vec<bool>,
}

impl Limits {
    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.start) + size_of_val(&*self.limits) + size_of_val(&*self.fixed)
    }

    /// Sets the vertices that do not move. `vertices`: number of vertices.
    pub(super) fn set_fixed(&mut self, vertices: usize, fixed: impl Iterator<Item = u32>) {
        self.fixed.clear();
        self.fixed.resize(vertices, false);
        fixed.for_each(|vertex| self.fixed[vertex as usize] = true);
    }

    /// Sets the limits, in any order, of displacements from `start`.
    pub(super) fn set_limits(&mut self, limits: &[Limit], start: &[[f32; 3]]) {
        self.start.clear();
        self.start.extend_from_slice(start);
        self.limits.clear();
        self.limits.extend_from_slice(limits);
        self.limits.sort_unstable_by_key(|limit| {
            (limit.vertex, limit.clearance.to_bits(), <[f64; 3]>::from(limit.normal).map(f64::to_bits))
        });
    }

    /// Returns the greatest displacement of a vertex from the start.
    pub(super) fn greatest_displacement(&self, positions: &[[f32; 3]]) -> f64 {
        let moved = self.start.iter().zip(positions).map(|(a, b)| (vector(b) - vector(a)).norm());
        moved.fold(0.0, f64::max)
    }

    /// Moves a vertex by a step, within its limits: along the limit that the step exceeds the most, and no farther than
    /// to the others. A vertex that is fixed, and a step that is not finite, have no effect.
    ///
    /// * `along`: returns the step along a plane, from the unit normal of the plane and the part of the step along it.
    pub(super) fn advance(
        &self,
        vertex: u32,
        mut step: Vector3<f64>,
        along: impl Fn(Vector3<f64>, f64) -> Vector3<f64>,
        positions: &mut [[f32; 3]],
    ) {
        let index = vertex as usize;
        if self.fixed[index] {
            return;
        }
        let position = vector(&positions[index]);
        let before = position - vector(&self.start[index]);
        let first = self.limits.partition_point(|limit| limit.vertex < vertex);
        let limits = self.limits[first..].iter().take_while(|limit| limit.vertex == vertex);
        // The distance that a limit leaves would be negative by rounding errors only.
        let room = |limit: &Limit| (limit.clearance + limit.normal.dot(&before)).max(0.0);
        let excess = |limit: &Limit| -limit.normal.dot(&step) - room(limit);
        let worst = limits.clone().max_by(|a, b| excess(a).total_cmp(&excess(b)));
        if let Some(worst) = worst.filter(|limit| excess(limit) > 0.0) {
            step = along(worst.normal, -room(worst));
            for limit in limits {
                let approach = -limit.normal.dot(&step);
                if approach > room(limit) {
                    step *= room(limit) / approach;
                }
            }
        }
        let moved: [f32; 3] = (position + step).map(|x| x as f32).into();
        if moved.iter().all(|x| x.is_finite()) {
            positions[index] = moved;
        }
    }
}
