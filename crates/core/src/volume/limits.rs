//! Vertices that the correction would push into an obstacle stop before it, or slide along it.

use nalgebra::Vector3;

use super::line::Moving;

/// How far a lattice vertex may be moved before the surface that it carries meets an obstacle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Limit {
    /// The lattice vertex.
    pub(super) vertex: u32,
    /// Away from the obstacle: a unit vector in world axes.
    pub(super) normal: Vector3<f64>,
    /// The way left against the normal, in cells; at least 0.
    pub(super) room: f64,
}

/// The limited vertices of one evaluation.
#[derive(Clone, Debug, Default)]
pub(super) struct Limits {
    /// In the order of their vertices.
    sorted: Vec<Limit>,
    limited: Vec<Limited>,
}

/// A vertex with limits: `scale` is what the regional scope has moved it by, in units of its direction.
#[derive(Clone, Copy, Debug)]
struct Limited {
    vertex: u32,
    limits: (u32, u32),
    place: Vector3<f64>,
    direction: Vector3<f64>,
    scale: f64,
    way: Way,
}

/// Where a vertex goes, as far as that depends on `lambda`.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Way {
    /// Along the field.
    Free,
    /// Along one obstacle, at the end of its room.
    Along { limit: u32 },
    /// Between several: no farther until something changes.
    Stopped { way: Vector3<f64> },
}

impl Limits {
    /// Memory that it takes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.sorted) + size_of_val(&*self.limited)
    }

    /// Removes all limits.
    pub(super) fn clear(&mut self) {
        self.sorted.clear();
        self.limited.clear();
    }

    /// Replaces the limits, given in any order, of points that have been moved by `scales` times their directions.
    pub(super) fn begin(&mut self, limits: &[Limit], points: &mut [Moving], scales: Option<&[f32]>) {
        for limited in &self.limited {
            limited.free(&mut points[limited.vertex as usize]);
        }
        self.clear();
        self.sorted.extend_from_slice(limits);
        // By all fields, so that the order of the obstacles does not matter.
        self.sorted.sort_unstable_by_key(|limit| {
            (limit.vertex, limit.room.to_bits(), <[f64; 3]>::from(limit.normal).map(f64::to_bits))
        });
        let mut first = 0;
        for group in self.sorted.chunk_by(|a, b| a.vertex == b.vertex) {
            let vertex = group[0].vertex;
            let point = &points[vertex as usize];
            let wide = |v: [f32; 3]| Vector3::from(v.map(f64::from));
            let direction = wide(point.direction());
            let scale = scales.map_or(0.0, |scales| f64::from(scales[vertex as usize]));
            let place = wide(point.place()) - direction * scale;
            let limits = (first, first + group.len() as u32);
            self.limited.push(Limited { vertex, limits, place, direction, scale, way: Way::Free });
            first = limits.1;
        }
    }

    /// Sets the ways of the points near the `lambda` of their vertex. Returns whether any has changed.
    pub(super) fn divert(&mut self, lambda: impl Fn(u32) -> f64, points: &mut [Moving]) -> bool {
        let mut changed = false;
        for limited in &mut self.limited {
            let lambda = lambda(limited.vertex);
            let (way, reached) = limited.go(&self.sorted, lambda);
            changed |= way != limited.way;
            limited.way = way;
            let direction = match way {
                Way::Free => limited.direction,
                Way::Along { limit } => {
                    let normal = self.sorted[limit as usize].normal;
                    limited.direction - normal * normal.dot(&limited.direction)
                }
                Way::Stopped { .. } => Vector3::zeros(),
            };
            let point = &mut points[limited.vertex as usize];
            point.set_place((limited.place + reached - direction * lambda).map(|x| x as f32).into());
            point.set_direction(direction.map(|x| x as f32).into());
        }
        changed
    }

    /// Adds to the positions of the limited vertices how far they go, each by `lambda` of its vertex.
    pub(super) fn write(&self, lambda: impl Fn(u32) -> f64, deformed: &[[f32; 3]], out: &mut [[f32; 3]]) {
        for limited in &self.limited {
            let (_, reached) = limited.go(&self.sorted, lambda(limited.vertex));
            let vertex = limited.vertex as usize;
            out[vertex] = std::array::from_fn(|k| deformed[vertex][k] + reached[k] as f32);
        }
    }
}

impl Limit {
    /// How far beyond the limit a way leads; negative within it.
    fn excess(&self, way: &Vector3<f64>) -> f64 {
        -self.normal.dot(way) - self.room
    }
}

impl Limited {
    /// Resets a point to its place and direction in the field.
    fn free(&self, point: &mut Moving) {
        point.set_place((self.place + self.direction * self.scale).map(|x| x as f32).into());
        point.set_direction(self.direction.map(|x| x as f32).into());
    }

    /// The way at `lambda`, and how far that leads: what the field has, less what is beyond each limit in turn. Where
    /// that leaves it beyond another, as between obstacles that meet at an acute angle, it stops short on that line.
    fn go(&self, sorted: &[Limit], lambda: f64) -> (Way, Vector3<f64>) {
        let limits = (self.limits.0..self.limits.1).map(|index| (index, &sorted[index as usize]));
        let mut reached = self.direction * (self.scale + lambda);
        // Without room, rounding is all that remains along the normal.
        let rounding = 1e-9 * reached.norm();
        let mut way = Way::Free;
        for (index, limit) in limits.clone() {
            let excess = limit.excess(&reached);
            if excess > 0.0 {
                reached += limit.normal * excess;
                way = match way {
                    Way::Free => Way::Along { limit: index },
                    _ => Way::Stopped { way: reached },
                };
            }
        }
        for (_, limit) in limits {
            if limit.excess(&reached) > rounding {
                reached *= limit.room / -limit.normal.dot(&reached);
                way = Way::Stopped { way: reached };
            }
        }
        if let Way::Stopped { way } = &mut way {
            *way = reached;
        }
        (way, reached)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn limit(normal: [f64; 3], room: f64) -> Limit {
        Limit { vertex: 0, normal: Vector3::from(normal).normalize(), room }
    }

    fn reached(direction: [f32; 3], scales: Option<&[f32]>, limits: &[Limit], lambda: f64) -> [f32; 3] {
        let place = std::array::from_fn(|k| 10.0 + scales.map_or(0.0, |scales| scales[0]) * direction[k]);
        let mut points = [Moving::new(place, direction)];
        let mut all = Limits::default();
        all.begin(limits, &mut points, scales);
        all.divert(|_| lambda, &mut points);
        let mut out = [[f32::NAN; 3]];
        all.write(|_| lambda, &[[10.0; 3]], &mut out);
        // The point is where it is written, and goes on along the way that it was given.
        points[0].advance(lambda as f32);
        let gap = out[0].iter().zip(points[0].place()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(gap <= 4e-6, "{out:?} {points:?}");
        out[0].map(|x| x - 10.0)
    }

    fn near(a: [f32; 3], b: [f32; 3]) {
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 4e-6), "{a:?} {b:?}");
    }

    const DOWN: [f32; 3] = [0.6, -0.8, 0.0];
    const FLOOR: [f64; 3] = [0.0, 1.0, 0.0];

    #[test]
    fn the_way_ends_where_the_room_does_and_goes_on_along_the_obstacle() {
        near(reached(DOWN, None, &[limit(FLOOR, 0.5)], 0.5), [0.3, -0.4, 0.0]);
        near(reached(DOWN, None, &[limit(FLOOR, 0.5)], 2.0), [1.2, -0.5, 0.0]);
        near(reached(DOWN, None, &[limit(FLOOR, 0.0)], 2.0), [1.2, 0.0, 0.0]);
        near(reached(DOWN, None, &[limit(FLOOR, 0.5)], -2.0), [-1.2, 1.6, 0.0]);
        // What a region has moved it by counts.
        near(reached(DOWN, Some(&[1.5]), &[limit(FLOOR, 0.5)], 0.5), [1.2, -0.5, 0.0]);
    }

    #[test]
    fn several_limits_are_all_kept() {
        near(reached(DOWN, None, &[limit(FLOOR, 0.5), limit([-1.0, 0.0, 0.0], 0.1)], 2.0), [0.1, -0.5, 0.0]);
        near(reached(DOWN, None, &[limit(FLOOR, 0.5), limit(FLOOR, 0.2)], 2.0), [1.2, -0.2, 0.0]);
        // A narrow wedge: no way out of one side leads into the other.
        let wedge = [limit([0.6, 0.8, 0.0], 0.1), limit([-0.8, 0.6, 0.0], 0.1), limit([-0.6, 0.8, 0.0], 0.1)];
        for lambda in [0.1, 1.0, 10.0] {
            let way = reached([0.0, -1.0, 0.0], None, &wedge, lambda);
            for limit in &wedge {
                let outward = -limit.normal.dot(&Vector3::from(way.map(f64::from)));
                assert!(outward <= 0.1 + 4e-6, "{way:?} {limit:?}");
            }
        }
    }

    /// Rounding along the normal is no reason to stay behind.
    #[test]
    fn without_room_it_slides_whatever_the_normal() {
        for degrees in 0..=180 {
            let (sin, cos) = f64::from(degrees).to_radians().sin_cos();
            let out = reached([0.0, 0.0, 1.0], None, &[limit([sin, cos, 0.0], 0.0)], 2.0);
            near(out, [0.0, 0.0, 2.0]);
            let v = [(0.3 * cos - 0.9 * sin) as f32, (-0.3 * sin - 0.9 * cos) as f32, 0.0];
            let out = reached(v, None, &[limit([sin, cos, 0.0], 0.0)], 2.0);
            near(out, [(0.6 * cos) as f32, (-0.6 * sin) as f32, 0.0]);
        }
    }

    #[test]
    fn changes_are_told() {
        let mut points = [Moving::new([0.0; 3], DOWN)];
        let mut limits = Limits::default();
        limits.begin(&[limit(FLOOR, 0.4)], &mut points, None);
        let told = [0.2, 0.4, 0.6, 0.9, 0.1].map(|lambda| limits.divert(|_| lambda, &mut points));
        assert_eq!(told, [false, false, true, false, true]);
    }
}
