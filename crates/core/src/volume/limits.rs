//! Applies limits to the correction: a vertex at its limit slides along the obstacle, or stops.
//!
//! An obstacle is a collider at one time, or the surface of another body. [`Limits`] is the active set of the iteration
//! that solves for `lambda`: it determines which limited vertices move freely, slide or are stopped at the current
//! `lambda`.

use nalgebra::Vector3;

use super::line::Moving;

/// Limit of a lattice vertex: a half space in which the vertex must stay, so that the surface does not enter
/// an obstacle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Limit {
    /// Lattice vertex.
    pub(crate) vertex: u32,
    /// Unit normal away from the obstacle, in world axes.
    pub(crate) normal: Vector3<f64>,
    /// Greatest displacement of the vertex against the normal, in cells; at least 0.
    pub(crate) clearance: f64,
    /// Whether the limit is left out if the volume of the component can be restored without it only.
    pub(crate) is_soft: bool,
}

/// Vertices with limits in one evaluation.
#[derive(Clone, Debug, Default)]
pub(super) struct Limits {
    /// Limits, sorted by vertex.
    sorted: Vec<Limit>,
    /// Vertices with limits, in increasing order.
    limited: Vec<LimitedVertex>,
}

/// Vertex with limits.
#[derive(Clone, Copy, Debug)]
struct LimitedVertex {
    vertex: u32,
    /// Start and end of the limits of the vertex in `Limits::sorted`.
    limit_range: (u32, u32),
    /// Position without correction, relative to the center of the component.
    position: Vector3<f64>,
    /// Vector of the field.
    direction: Vector3<f64>,
    /// Displacement to which `lambda` times `direction` is added, in cells.
    offset: Vector3<f64>,
    motion: Motion,
}

/// Motion of a vertex as a function of `lambda`: the state of the vertex in the active set.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Motion {
    /// Moves along the field.
    Free,
    /// Slides along an obstacle, at the limit with this index in `Limits::sorted`.
    Sliding { limit: u32 },
    /// Is stopped by several limits, at a constant displacement.
    Stopped { displacement: Vector3<f64> },
}

impl Limits {
    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.sorted) + size_of_val(&*self.limited)
    }

    /// Removes all limits.
    pub(super) fn clear(&mut self) {
        self.sorted.clear();
        self.limited.clear();
    }

    /// Returns whether any vertex slides or is stopped.
    pub(super) fn is_any_limited(&self) -> bool {
        self.limited.iter().any(|limited| limited.motion != Motion::Free)
    }

    /// Replaces the limits by `limits`, which may be in any order.
    ///
    /// * `points`: points of the lattice. The points of the previously limited vertices are reset.
    /// * `offsets`: displacement of each vertex by which its point has already moved, in cells. Empty if all are
    ///   zero.
    pub(super) fn replace(&mut self, limits: &[Limit], points: &mut [Moving], offsets: &[[f32; 3]]) {
        for limited in &self.limited {
            limited.reset(&mut points[limited.vertex as usize]);
        }
        self.clear();
        self.sorted.extend_from_slice(limits);
        // Sorts by all fields, so that the result does not depend on the order of the obstacles.
        self.sorted.sort_unstable_by_key(|limit| {
            (limit.vertex, limit.clearance.to_bits(), <[f64; 3]>::from(limit.normal).map(f64::to_bits))
        });
        let mut first = 0;
        for group in self.sorted.chunk_by(|a, b| a.vertex == b.vertex) {
            let vertex = group[0].vertex;
            let point = &points[vertex as usize];
            let to_f64 = |v: [f32; 3]| Vector3::from(v.map(f64::from));
            let direction = to_f64(point.direction());
            let offset = to_f64(offsets.get(vertex as usize).copied().unwrap_or_default());
            let position = to_f64(point.position()) - offset;
            let limit_range = (first, first + group.len() as u32);
            self.limited.push(LimitedVertex {
                vertex,
                limit_range,
                position,
                direction,
                offset,
                motion: Motion::Free,
            });
            first = limit_range.1;
        }
    }

    /// Updates the motions of the limited vertices, and their points, for the current `lambda`. Returns
    /// whether any motion has changed.
    ///
    /// * `lambda`: returns the `lambda` of a vertex.
    pub(super) fn update_motions(&mut self, lambda: impl Fn(u32) -> f64, points: &mut [Moving]) -> bool {
        let mut changed = false;
        for limited in &mut self.limited {
            let lambda = lambda(limited.vertex);
            let (motion, displacement) = limited.motion_at(&self.sorted, lambda);
            changed |= motion != limited.motion;
            limited.motion = motion;
            let direction = match motion {
                Motion::Free => limited.direction,
                Motion::Sliding { limit } => {
                    let normal = self.sorted[limit as usize].normal;
                    limited.direction - normal * normal.dot(&limited.direction)
                }
                Motion::Stopped { .. } => Vector3::zeros(),
            };
            let point = &mut points[limited.vertex as usize];
            // The point reaches the displacement at the current `lambda`.
            let position = limited.position + displacement - direction * lambda;
            point.set_position(position.map(|x| x as f32).into());
            point.set_direction(direction.map(|x| x as f32).into());
        }
        changed
    }

    /// Writes the corrected position of each limited vertex to `out`: its position in `deformed` plus its
    /// displacement at its `lambda`.
    pub(super) fn write(&self, lambda: impl Fn(u32) -> f64, deformed: &[[f32; 3]], out: &mut [[f32; 3]]) {
        for limited in &self.limited {
            let (_, displacement) = limited.motion_at(&self.sorted, lambda(limited.vertex));
            let vertex = limited.vertex as usize;
            out[vertex] = std::array::from_fn(|k| deformed[vertex][k] + displacement[k] as f32);
        }
    }
}

impl Limit {
    /// Returns the distance by which a displacement exceeds the limit; negative within the limit.
    fn excess(&self, displacement: &Vector3<f64>) -> f64 {
        -self.normal.dot(displacement) - self.clearance
    }
}

impl LimitedVertex {
    /// Resets the point of the vertex to its position and direction without limits.
    fn reset(&self, point: &mut Moving) {
        point.set_position((self.position + self.offset).map(|x| x as f32).into());
        point.set_direction(self.direction.map(|x| x as f32).into());
    }

    /// Computes the motion and the displacement at `lambda`.
    ///
    /// The displacement along the field is projected to the plane of each limit that it exceeds, one limit
    /// after another. A projection can move the displacement beyond another limit, for example between
    /// obstacles at an acute angle. The displacement is then scaled down until it satisfies this other limit.
    fn motion_at(&self, sorted: &[Limit], lambda: f64) -> (Motion, Vector3<f64>) {
        let limits = (self.limit_range.0..self.limit_range.1).map(|index| (index, &sorted[index as usize]));
        let mut displacement = self.offset + self.direction * lambda;
        // After a projection to a limit with clearance 0, the component along the normal is only rounding
        // error.
        let rounding = 1e-9 * displacement.norm();
        let mut motion = Motion::Free;
        for (index, limit) in limits.clone() {
            let excess = limit.excess(&displacement);
            if excess > 0.0 {
                displacement += limit.normal * excess;
                motion = match motion {
                    Motion::Free => Motion::Sliding { limit: index },
                    _ => Motion::Stopped { displacement },
                };
            }
        }
        for (_, limit) in limits {
            if limit.excess(&displacement) > rounding {
                displacement *= limit.clearance / -limit.normal.dot(&displacement);
                motion = Motion::Stopped { displacement };
            }
        }
        if let Motion::Stopped { displacement: stopped } = &mut motion {
            *stopped = displacement;
        }
        (motion, displacement)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn limit(normal: [f64; 3], clearance: f64) -> Limit {
        Limit { vertex: 0, normal: Vector3::from(normal).normalize(), clearance, is_soft: false }
    }

    /// Returns the displacement of a vertex at `lambda`, with an offset of `scale` times its direction.
    fn displacement_of(direction: [f32; 3], scale: Option<f32>, limits: &[Limit], lambda: f64) -> [f32; 3] {
        let offsets: Vec<_> = scale.iter().map(|scale| direction.map(|v| scale * v)).collect();
        let position = std::array::from_fn(|k| 10.0 + offsets.first().map_or(0.0, |offset| offset[k]));
        let mut points = [Moving::new(position, direction)];
        let mut active_set = Limits::default();
        active_set.replace(limits, &mut points, &offsets);
        active_set.update_motions(|_| lambda, &mut points);
        let mut out = [[f32::NAN; 3]];
        active_set.write(|_| lambda, &[[10.0; 3]], &mut out);
        // The point at `lambda` agrees with the written position.
        points[0].advance(lambda as f32);
        let differences = out[0].iter().zip(points[0].position()).map(|(a, b)| (a - b).abs());
        let difference = differences.fold(0.0, f32::max);
        assert!(difference <= 4e-6, "{out:?} {points:?}");
        out[0].map(|x| x - 10.0)
    }

    fn assert_near(a: [f32; 3], b: [f32; 3]) {
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 4e-6), "{a:?} {b:?}");
    }

    const DOWN: [f32; 3] = [0.6, -0.8, 0.0];
    const FLOOR: [f64; 3] = [0.0, 1.0, 0.0];

    #[test]
    fn vertex_slides_along_the_obstacle_at_its_limit() {
        assert_near(displacement_of(DOWN, None, &[limit(FLOOR, 0.5)], 0.5), [0.3, -0.4, 0.0]);
        assert_near(displacement_of(DOWN, None, &[limit(FLOOR, 0.5)], 2.0), [1.2, -0.5, 0.0]);
        assert_near(displacement_of(DOWN, None, &[limit(FLOOR, 0.0)], 2.0), [1.2, 0.0, 0.0]);
        assert_near(displacement_of(DOWN, None, &[limit(FLOOR, 0.5)], -2.0), [-1.2, 1.6, 0.0]);
        // The offset is part of the displacement.
        assert_near(displacement_of(DOWN, Some(1.5), &[limit(FLOOR, 0.5)], 0.5), [1.2, -0.5, 0.0]);
    }

    #[test]
    fn several_limits_are_all_satisfied() {
        let floor_and_wall = [limit(FLOOR, 0.5), limit([-1.0, 0.0, 0.0], 0.1)];
        assert_near(displacement_of(DOWN, None, &floor_and_wall, 2.0), [0.1, -0.5, 0.0]);
        let two_floors = [limit(FLOOR, 0.5), limit(FLOOR, 0.2)];
        assert_near(displacement_of(DOWN, None, &two_floors, 2.0), [1.2, -0.2, 0.0]);
        // A narrow wedge: after the projection to one side, the vertex must not be beyond the other side.
        let wedge = [limit([0.6, 0.8, 0.0], 0.1), limit([-0.8, 0.6, 0.0], 0.1), limit([-0.6, 0.8, 0.0], 0.1)];
        for lambda in [0.1, 1.0, 10.0] {
            let offset = displacement_of([0.0, -1.0, 0.0], None, &wedge, lambda);
            for limit in &wedge {
                let outward = -limit.normal.dot(&Vector3::from(offset.map(f64::from)));
                assert!(outward <= 0.1 + 4e-6, "{offset:?} {limit:?}");
            }
        }
    }

    /// Rounding errors along the normal must not stop the vertex.
    #[test]
    fn vertex_without_clearance_slides_for_any_normal() {
        for degrees in 0..=180 {
            let (sin, cos) = f64::from(degrees).to_radians().sin_cos();
            let out = displacement_of([0.0, 0.0, 1.0], None, &[limit([sin, cos, 0.0], 0.0)], 2.0);
            assert_near(out, [0.0, 0.0, 2.0]);
            let v = [(0.3 * cos - 0.9 * sin) as f32, (-0.3 * sin - 0.9 * cos) as f32, 0.0];
            let out = displacement_of(v, None, &[limit([sin, cos, 0.0], 0.0)], 2.0);
            assert_near(out, [(0.6 * cos) as f32, (-0.6 * sin) as f32, 0.0]);
        }
    }

    #[test]
    fn update_motions_returns_whether_a_motion_changed() {
        let mut points = [Moving::new([0.0; 3], DOWN)];
        let mut limits = Limits::default();
        limits.replace(&[limit(FLOOR, 0.4)], &mut points, &[]);
        let changed = [0.2, 0.4, 0.6, 0.9, 0.1].map(|lambda| limits.update_motions(|_| lambda, &mut points));
        assert_eq!(changed, [false, false, true, false, true]);
    }
}
