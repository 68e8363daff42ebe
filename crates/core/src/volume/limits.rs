//! Limits of the displacements of lattice vertices, and the projection of a displacement to them.

use nalgebra::Vector3;

/// Distance in cells by which a vertex must exceed a limit to be moved again.
const NOTICEABLE: f64 = 1e-3;

/// Limit of a lattice vertex: a half space in which the vertex must stay, so that the surface does not enter
/// an obstacle: a collider, or the surface of another body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Limit {
    /// Lattice vertex.
    pub vertex: u32,
    /// Unit normal away from the obstacle, in world axes.
    pub normal: Vector3<f64>,
    /// Greatest displacement of the vertex against the normal, in cells; at least 0.
    pub clearance: f64,
    /// Whether the limit is left out if the volume of the component can be restored without it only.
    pub is_soft: bool,
}

/// The limits of the vertices of a lattice.
#[derive(Clone, Debug, Default)]
pub(crate) struct Limits(Vec<Limit>);

/// Motion of a vertex with limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Motion {
    /// No limit has an effect.
    Free,
    /// Slides along the plane of one limit, with this normal.
    Sliding(Vector3<f64>),
    /// Slides along the line at which the planes of two limits meet, with this unit vector along it.
    Along(Vector3<f64>),
    /// Is stopped by several limits.
    Stopped,
}

impl Limits {
    pub(crate) fn list(&self) -> &[Limit] {
        &self.0
    }

    /// Returns the list of limits. [`sort`](Self::sort) must be called after a change.
    pub(crate) fn list_mut(&mut self) -> &mut Vec<Limit> {
        &mut self.0
    }

    /// Sorts the limits by vertex, and by all other fields, so that results do not depend on the order of the obstacles.
    pub(crate) fn sort(&mut self) {
        self.0.sort_unstable_by_key(|limit| {
            (limit.vertex, limit.clearance.to_bits(), <[f64; 3]>::from(limit.normal).map(f64::to_bits))
        });
    }

    /// Returns the limits of a vertex.
    pub(crate) fn of(&self, vertex: u32) -> &[Limit] {
        let limits = &self.0[self.0.partition_point(|limit| limit.vertex < vertex)..];
        &limits[..limits.iter().take_while(|limit| limit.vertex == vertex).count()]
    }

    /// Returns whether a vertex that moved from its start exceeds a limit noticeably.
    pub(crate) fn are_exceeded(&self, start: &[[f32; 3]], moved: &[[f32; 3]]) -> bool {
        self.0.iter().any(|limit| {
            let [from, to] = [start, moved].map(|positions| positions[limit.vertex as usize]);
            let displacement = Vector3::from_fn(|k, _| f64::from(to[k] - from[k]));
            -limit.normal.dot(&displacement) > limit.clearance + NOTICEABLE
        })
    }

    /// Iterates over the limits of each vertex that has any, in the order of the vertices.
    pub(super) fn by_vertex(&self) -> impl Iterator<Item = &[Limit]> {
        self.0.chunk_by(|a, b| a.vertex == b.vertex)
    }

    /// Returns the memory in bytes.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&*self.0)
    }
}

/// Squared sine of the angle between two planes up to which they count as parallel, so that they meet at no line: where they
/// meet is farther than 30 times the excess.
const PARALLEL: f64 = 1e-3;

/// Projects a step of a vertex to its limits. Returns the step within the limits, and how the limits change it.
///
/// The step is projected to the plane of the first limit that it exceeds, then, if it exceeds another one, to the line at
/// which both planes meet, and then to the point at which this line meets a third plane. Limits that it exceeds afterwards
/// shorten it.
///
/// * `limits`: the limits of the vertex.
/// * `from`: the displacement before the step, within the limits.
pub(crate) fn project(
    limits: &[Limit],
    from: Vector3<f64>,
    mut step: Vector3<f64>,
) -> (Vector3<f64>, Motion) {
    // The room of `from` would be negative by rounding errors only.
    let room = |limit: &Limit| (limit.clearance + limit.normal.dot(&from)).max(0.0);
    let excess = |limit: &Limit, step: &Vector3<f64>| -limit.normal.dot(step) - room(limit);
    // After a projection to a limit without room, the component along the normal is only rounding error.
    let rounding = 1e-9 * step.norm();
    let mut motion = Motion::Free;
    for limit in limits {
        let excess = excess(limit, &step);
        if excess <= rounding {
            continue;
        }
        match motion {
            Motion::Free => {
                step += limit.normal * excess;
                motion = Motion::Sliding(limit.normal);
            }
            Motion::Sliding(first) => {
                // Within the plane of the first limit, so that this one stays satisfied.
                let within = limit.normal - first * first.dot(&limit.normal);
                let squared = within.norm_squared();
                if squared > PARALLEL {
                    step += within * (excess / squared);
                    motion = Motion::Along(first.cross(&limit.normal).normalize());
                }
            }
            Motion::Along(axis) => {
                let along = axis.dot(&limit.normal);
                if along * along > PARALLEL {
                    step += axis * (excess / along);
                    motion = Motion::Stopped;
                }
            }
            Motion::Stopped => {}
        }
    }
    for limit in limits {
        if excess(limit, &step) > rounding {
            step *= room(limit) / -limit.normal.dot(&step);
            motion = Motion::Stopped;
        }
    }
    (step, motion)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn limit(normal: [f64; 3], clearance: f64) -> Limit {
        Limit { vertex: 0, normal: Vector3::from(normal).normalize(), clearance, is_soft: false }
    }

    fn assert_projected(limits: &[Limit], steps: [[f64; 3]; 3], expected_motion: Motion) {
        let [from, step, expected] = steps.map(Vector3::from);
        let (projected, motion) = project(limits, from, step);
        assert!((projected - expected).norm() < 1e-12, "{projected} {expected}");
        assert_eq!(motion, expected_motion);
    }

    const FLOOR: [f64; 3] = [0.0, 1.0, 0.0];
    const WALL: [f64; 3] = [-1.0, 0.0, 0.0];

    #[test]
    fn vertex_slides_along_the_obstacle_at_its_limit() {
        let sliding = Motion::Sliding(FLOOR.into());
        let floor = |clearance: f64| [limit(FLOOR, clearance)];
        assert_projected(&floor(0.5), [[0.0; 3], [0.3, -0.4, 0.0], [0.3, -0.4, 0.0]], Motion::Free);
        assert_projected(&floor(0.5), [[0.0; 3], [-1.2, 1.6, 0.0], [-1.2, 1.6, 0.0]], Motion::Free);
        assert_projected(&floor(0.5), [[0.0; 3], [1.2, -1.6, 0.0], [1.2, -0.5, 0.0]], sliding);
        assert_projected(&floor(0.0), [[0.0; 3], [1.2, -1.6, 0.0], [1.2, 0.0, 0.0]], sliding);
        // The displacement before the step takes a part of the clearance.
        assert_projected(&floor(0.5), [[1.0, -0.4, 0.0], [1.2, -1.6, 0.0], [1.2, -0.1, 0.0]], sliding);
        assert_projected(&floor(0.5), [[0.0, 0.4, 0.0], [1.2, -1.6, 0.0], [1.2, -0.9, 0.0]], sliding);
    }

    #[test]
    fn several_limits_are_all_satisfied() {
        let step = [1.2, -1.6, 0.0];
        let floor_and_wall = [limit(FLOOR, 0.5), limit(WALL, 0.1)];
        let along = Motion::Along(Vector3::z());
        assert_projected(&floor_and_wall, [[0.0; 3], step, [0.1, -0.5, 0.0]], along);
        // Along the line at which the floor and the wall meet, nothing stops the vertex.
        let step_along = [1.2, -1.6, 3.0];
        assert_projected(&floor_and_wall, [[0.0; 3], step_along, [0.1, -0.5, 3.0]], along);
        let two_floors = [limit(FLOOR, 0.2), limit(FLOOR, 0.5)];
        assert_projected(&two_floors, [[0.0; 3], step, [1.2, -0.2, 0.0]], Motion::Sliding(FLOOR.into()));
        // A narrow wedge: after the projection to one side, the vertex must not be beyond the other side.
        let wedge = [limit([0.6, 0.8, 0.0], 0.1), limit([-0.8, 0.6, 0.0], 0.1), limit([-0.6, 0.8, 0.0], 0.1)];
        for length in [0.1, 1.0, 10.0] {
            let (projected, _) = project(&wedge, Vector3::zeros(), Vector3::new(0.0, -length, 0.0));
            for limit in &wedge {
                assert!(-limit.normal.dot(&projected) <= 0.1 + 1e-12, "{projected} {limit:?}");
            }
        }
    }

    /// Rounding errors along the normal must not stop the vertex.
    #[test]
    fn vertex_without_clearance_slides_for_any_normal() {
        for degrees in 0..=180 {
            let (sin, cos) = libm::sincos(f64::from(degrees).to_radians());
            let floor = limit([sin, cos, 0.0], 0.0);
            let (along, _) = project(&[floor], Vector3::zeros(), Vector3::new(0.0, 0.0, 2.0));
            assert_eq!(along, Vector3::new(0.0, 0.0, 2.0));
            let step = [0.6 * cos - 1.8 * sin, -0.6 * sin - 1.8 * cos, 0.0];
            let expected = [0.6 * cos, -0.6 * sin, 0.0];
            assert_projected(&[floor], [[0.0; 3], step, expected], Motion::Sliding(floor.normal));
        }
    }

    #[test]
    fn limits_of_a_vertex_are_sorted_by_clearance() {
        let mut limits = Limits::default();
        for (vertex, clearance) in [(7, 0.3), (2, 0.2), (7, 0.1), (3, 0.0)] {
            limits.list_mut().push(Limit { vertex, ..limit(FLOOR, clearance) });
        }
        limits.sort();
        let clearances = |vertex| limits.of(vertex).iter().map(|limit| limit.clearance).collect::<Vec<_>>();
        assert_eq!([0, 2, 3, 7, 8].map(clearances), [vec![], vec![0.2], vec![0.0], vec![0.1, 0.3], vec![]]);
        assert_eq!(limits.by_vertex().map(<[Limit]>::len).collect::<Vec<_>>(), [1, 1, 2]);
    }
}
