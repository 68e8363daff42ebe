//! Finds the translation by which a body that begins inside colliders leaves them.
//!
//! A sample alone is pushed out through the nearest surface. The samples of a body in the middle of a box would so
//! leave through all of its faces, and the body would tear. An escape is one translation of a whole connected
//! component. It is the least one in a set of directions: the normals of the colliders, their axes, and up.
//!
//! The points of a component are its samples, and balls around the vertices inside it, so that a collider within the
//! body is found too. In a direction, each pair of a point and a collider gives the interval of translations for which
//! they overlap. The translation ends where the intervals that begin at zero end. A gap of less than one cell between
//! two intervals does not end it: samples are up to one cell apart, so that a thin plate fits between them.

use nalgebra::{Point3, Vector3};

use super::shape::PosedShape;
use super::stage::{ALLOWED_DEPTH, PUSH_LIMIT};

/// Radius in cells of the ball around a vertex inside the body. Such a vertex is at least one cell from the surface.
const INNER_RADIUS: f64 = 0.5;

/// Depth in cells at which a sample counts as free in the choice of the direction. So a body that lies on a collider
/// can move along it.
const FREE_DEPTH: f64 = 0.02;

/// Greatest gap in cells between two intervals that counts as overlap.
const GAP: f64 = 1.0;

/// Greatest translation, in cells.
const MAX_LENGTH: f64 = 1e6;

/// A direction that comes first is chosen if its translation is at most this much longer, in cells. So rounding does
/// not decide between equal lengths.
const TIE: f64 = 1e-3;

/// The points of a component by which it overlaps with colliders, in cells.
#[derive(Clone, Debug, Default)]
pub(crate) struct BodyPoints {
    pub samples: Vec<Point3<f64>>,
    /// Vertices inside the body, at least one cell from its surface.
    pub inner: Vec<Point3<f64>>,
}

impl BodyPoints {
    /// Returns the least translation that frees the points of all `shapes`, or `None` if the body is not in a collider,
    /// or if no translation frees it. `up` points against gravity; it is zero without gravity.
    ///
    /// The body is in a collider if a sample is deeper than the greatest push-out of a step, or if a vertex inside the
    /// body is near or in the collider. A body whose center is outside of all colliders is not moved farther than its
    /// radius: a body that is pressed between two plates does not leave sideways.
    pub(crate) fn escape_translation(
        &self,
        shapes: &[PosedShape<'_>],
        up: Vector3<f64>,
    ) -> Option<Vector3<f64>> {
        let hit: Vec<&PosedShape<'_>> = shapes.iter().filter(|shape| self.is_in(shape)).collect();
        if hit.is_empty() {
            return None;
        }
        let points = || self.samples.iter().chain(&self.inner);
        let count = points().count() as f64;
        let center = Point3::from(points().map(|point| point.coords / count).sum::<Vector3<f64>>());
        let is_inside = |shape: &&PosedShape<'_>| shape.signed_distance(&center).distance < 0.0;
        let radius = points().map(|point| (point - center).norm()).fold(0.0, f64::max);
        let mut least = if hit.iter().any(is_inside) { MAX_LENGTH } else { radius };
        let mut found = None;
        for direction in std::iter::once(up).chain(hit.iter().flat_map(|shape| directions(shape, &center))) {
            let length = match direction == Vector3::zeros() {
                true => f64::INFINITY,
                false => self.length_along(shapes.iter(), &direction, FREE_DEPTH),
            };
            // The first comparison includes the limit.
            if found.is_none() && length <= least || length < least - TIE {
                (least, found) = (length, Some(direction));
            }
        }
        found.map(|direction| {
            // A push-out at the end of the translation would deform the body.
            let whole = self.length_along(hit.iter().copied(), &direction, ALLOWED_DEPTH);
            direction * if whole <= least + 1.0 { whole } else { least }
        })
    }

    /// Returns the points, and the radii of the balls around them. Samples have a negative radius: they may overlap by
    /// `free_depth`.
    fn all(&self, free_depth: f64) -> impl Iterator<Item = (&Point3<f64>, f64)> {
        let samples = self.samples.iter().map(move |point| (point, -free_depth));
        samples.chain(self.inner.iter().map(|point| (point, INNER_RADIUS)))
    }

    /// Returns whether a sample is deeper than the greatest push-out of a step, or a vertex inside the body is near or in
    /// the shape.
    pub(crate) fn is_in(&self, shape: &PosedShape<'_>) -> bool {
        let depth = |point: &Point3<f64>| -shape.signed_distance(point).distance;
        self.samples.iter().any(|point| depth(point) > PUSH_LIMIT)
            || self.inner.iter().any(|point| depth(point) > -INNER_RADIUS)
    }

    /// Returns the length of the translation out of `shapes` in a direction; infinity if there is none.
    fn length_along<'a>(
        &self,
        shapes: impl Iterator<Item = &'a PosedShape<'a>>,
        direction: &Vector3<f64>,
        free_depth: f64,
    ) -> f64 {
        let mut intervals = Vec::new();
        for shape in shapes {
            for (point, radius) in self.all(free_depth) {
                shape.add_overlaps(point, direction, radius, &mut intervals);
            }
        }
        intervals.retain(|&[_, end]| end > 0.0);
        intervals.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]));
        let mut end = 0.0_f64;
        for interval in intervals {
            if interval[0] > end + GAP {
                break;
            }
            end = end.max(interval[1]);
        }
        end
    }
}

/// Returns unit vectors along which a body with its center at `center` may leave a shape.
fn directions(shape: &PosedShape<'_>, center: &Point3<f64>) -> impl Iterator<Item = Vector3<f64>> {
    let normal = shape.signed_distance(center).normal;
    let axes = match shape {
        PosedShape::Plane { .. } => [Vector3::zeros(); 3],
        PosedShape::Box { rotation, .. } => [0, 1, 2].map(|axis| rotation.column(axis).into_owned()),
        PosedShape::Sphere { .. } => perpendicular(normal, Vector3::ith(normal.iamin(), 1.0)),
        PosedShape::Capsule { axis, .. } => perpendicular(normal, *axis),
        PosedShape::Mesh(mesh) => mesh.axes(),
    };
    std::iter::once(normal).chain(axes.into_iter().flat_map(|axis| [axis, -axis]))
}

/// Returns three perpendicular unit vectors: a unit vector `first`, and others by `second`, or zeros in their place if
/// `second` has the direction of `first`.
fn perpendicular(first: Vector3<f64>, second: Vector3<f64>) -> [Vector3<f64>; 3] {
    let third = first.cross(&second).try_normalize(1e-9).unwrap_or_default();
    [first, third.cross(&first), third]
}

impl PosedShape<'_> {
    /// Adds the intervals of t for which the ball with the radius `ball` around `point` + t `direction` overlaps with
    /// the shape; intervals of a mesh belong to the center of the ball, and are longer by the radius at both ends.
    fn add_overlaps(
        &self,
        point: &Point3<f64>,
        direction: &Vector3<f64>,
        ball: f64,
        intervals: &mut Vec<[f64; 2]>,
    ) {
        match self {
            Self::Mesh(mesh) => mesh.add_overlaps(point, direction, ball, intervals),
            shape => intervals.extend(shape.overlap_along(point, direction, ball)),
        }
    }

    /// Returns the interval of t for which the ball with the radius `ball` around `point` + t `direction` overlaps with
    /// the shape other than a mesh, or `None`. A box is enlarged by the radius at each face; its
    /// thickness does not count. `direction` is a unit vector.
    pub(super) fn overlap_along(
        &self,
        point: &Point3<f64>,
        direction: &Vector3<f64>,
        ball: f64,
    ) -> Option<[f64; 2]> {
        match self {
            Self::Plane { point: origin, normal } => {
                slab(normal.dot(&(point - origin)), normal.dot(direction), [f64::NEG_INFINITY, ball])
            }
            Self::Sphere { center, radius } => ball_overlap(point - center, direction, radius + ball),
            Self::Box { center, half, rotation, .. } => {
                let (offset, along) = (rotation.tr_mul(&(point - center)), rotation.tr_mul(direction));
                (0..3).try_fold([f64::NEG_INFINITY, f64::INFINITY], |interval, axis| {
                    let limit = (half[axis] + ball).max(0.0);
                    intersection(interval, slab(offset[axis], along[axis], [-limit, limit])?)
                })
            }
            Self::Capsule { a, axis, radius } => {
                let (radius, offset) = (radius + ball, point - a);
                let ends = [offset, offset - axis].map(|offset| ball_overlap(offset, direction, radius));
                let across = |vector: &Vector3<f64>| vector - axis * (vector.dot(axis) / axis.norm_squared());
                let side = (axis.norm_squared() > 0.0).then(|| {
                    let between = slab(offset.dot(axis), direction.dot(axis), [0.0, axis.norm_squared()])?;
                    intersection(between, ball_overlap(across(&offset), &across(direction), radius)?)
                });
                let [first, second] = ends;
                [first, second, side.flatten()]
                    .into_iter()
                    .flatten()
                    .reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])
            }
            Self::Mesh(_) => None,
        }
    }
}

/// Returns the interval of t for which `start` + t `rate` lies in a range.
fn slab(start: f64, rate: f64, [low, high]: [f64; 2]) -> Option<[f64; 2]> {
    if rate.abs() < 1e-12 {
        return (low..=high).contains(&start).then_some([f64::NEG_INFINITY, f64::INFINITY]);
    }
    let (first, second) = ((low - start) / rate, (high - start) / rate);
    Some([first.min(second), first.max(second)])
}

/// Returns the interval of t for which `offset` + t `direction` is at most `radius` long.
fn ball_overlap(offset: Vector3<f64>, direction: &Vector3<f64>, radius: f64) -> Option<[f64; 2]> {
    let squared = direction.norm_squared();
    if squared < 1e-24 {
        return (offset.norm() <= radius).then_some([f64::NEG_INFINITY, f64::INFINITY]);
    }
    let nearest = -offset.dot(direction) / squared;
    let distance_squared = (offset + direction * nearest).norm_squared();
    // NaN if the line passes the ball.
    let half = ((radius.max(0.0).powi(2) - distance_squared) / squared).sqrt();
    half.is_finite().then_some([nearest - half, nearest + half])
}

fn intersection(a: [f64; 2], b: [f64; 2]) -> Option<[f64; 2]> {
    let both = [a[0].max(b[0]), a[1].min(b[1])];
    (both[0] <= both[1]).then_some(both)
}

#[cfg(test)]
mod tests {
    use nalgebra::Matrix3;

    use super::*;
    use crate::motion::euler_degrees;

    /// Returns the points of a cube with edges of 4 cells.
    fn cube(low: [f64; 3]) -> BodyPoints {
        let mut points = BodyPoints::default();
        for k in 0..125 {
            let index = [k % 5, k / 5 % 5, k / 25];
            let point = Point3::from(std::array::from_fn(|a| low[a] + f64::from(index[a])));
            let is_inner = index.iter().all(|i| (1..4).contains(i));
            if is_inner { points.inner.push(point) } else { points.samples.push(point) }
        }
        points
    }

    fn cuboid(center: [f64; 3], half: [f64; 3]) -> PosedShape<'static> {
        PosedShape::Box {
            center: center.into(),
            half: half.into(),
            rotation: Matrix3::identity(),
            thickness: 0.0,
        }
    }

    #[test]
    fn intervals_contain_exactly_the_points_inside() {
        let rotation = euler_degrees([20.0, 30.0, 40.0]);
        let (a, axis) = (Point3::new(-1.0, 0.0, 0.5), Vector3::new(2.0, 1.0, -0.5));
        let shapes = [
            PosedShape::Plane { point: a, normal: axis.normalize() },
            PosedShape::Sphere { center: a, radius: 1.3 },
            PosedShape::Box { center: a, half: Vector3::new(0.4, 1.0, 2.0), rotation, thickness: 0.0 },
            PosedShape::Capsule { a, axis, radius: 0.8 },
            PosedShape::Capsule { a, axis: Vector3::zeros(), radius: 0.8 },
        ];
        let mut random = generator(7);
        for shape in shapes {
            let mut inside = 0;
            for _ in 0..200 {
                let mut vector = || Vector3::from_fn(|_, _| 2.0 * random() - 1.0);
                let (point, direction) = (Point3::from(vector() * 3.0), vector().normalize());
                let interval = shape.overlap_along(&point, &direction, 0.0);
                for k in -100..=100 {
                    let t = 0.06 * f64::from(k);
                    let distance = shape.signed_distance(&(point + direction * t)).distance;
                    let is_inside = interval.is_some_and(|[start, end]| (start..=end).contains(&t));
                    assert!(is_inside == (distance <= 0.0) || distance.abs() < 1e-9, "{shape:?} {distance}");
                    inside += usize::from(is_inside);
                }
            }
            assert!(inside > 100, "{shape:?}");
        }
    }

    /// Returns a generator of numbers in [0, 1).
    fn generator(mut seed: u32) -> impl FnMut() -> f64 {
        move || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(seed >> 8) / f64::from(1 << 24)
        }
    }

    #[test]
    fn the_escape_is_the_least_translation_and_up_among_equals() {
        let up = Vector3::y();
        let half = [4.0; 3];
        let escape = |low, shapes: &[PosedShape<'_>]| {
            cube(low).escape_translation(shapes, up).map(|escape| escape.map(|x| x.round()))
        };
        // In the middle of a box, and nearer to one side of it.
        assert_eq!(escape([-2.0; 3], &[cuboid([0.0; 3], half)]), Some(up * 6.0));
        assert_eq!(escape([-2.0, -2.0, 1.0], &[cuboid([0.0; 3], half)]), Some(Vector3::z() * 3.0));
        // A ground on which the cube lies closes the least translation, the one down, and a ceiling the one up.
        let is_sideways = |low, height: f64| {
            let point = Point3::new(0.0, height, 0.0);
            let plane = PosedShape::Plane { point, normal: up * -height.signum() };
            let sideways = escape(low, &[cuboid([0.0; 3], half), plane]).unwrap();
            assert_eq!((sideways.norm(), sideways.y), (6.0, 0.0));
        };
        is_sideways([-2.0, -3.0, -2.0], -3.0);
        is_sideways([-2.0; 3], 5.0);
        // A plate between two layers of points.
        assert_eq!(escape([-2.0; 3], &[cuboid([0.0, 0.5, 0.0], [90.0, 0.1, 90.0])]), Some(-up * 2.0));
        // A ball within the body.
        let ball = PosedShape::Sphere { center: Point3::new(0.1, 0.8, 0.0), radius: 0.5 };
        assert_eq!(escape([-2.0; 3], &[ball]), Some(-up * 2.0));
    }

    #[test]
    fn a_body_that_touches_or_is_pressed_stays() {
        let escape = |shapes: &[PosedShape<'_>]| cube([-2.0; 3]).escape_translation(shapes, Vector3::y());
        let at = |y| cuboid([0.0, y, 0.0], [90.0, 1.0, 90.0]);
        assert_eq!(escape(&[at(-3.0), at(3.0)]), None);
        assert_eq!(escape(&[at(-2.8)]), None);
        assert!(escape(&[at(-2.7)]).is_some());
        assert_eq!(escape(&[at(-2.3), at(2.3)]), None, "pressed between plates");
        assert_eq!(
            BodyPoints::default().escape_translation(&[at(0.0)], Vector3::y()),
            None,
            "without points"
        );
        let planes = [-1.0, 1.0]
            .map(|y| PosedShape::Plane { point: Point3::new(0.0, y, 0.0), normal: Vector3::y() * -y });
        assert_eq!(escape(&[planes[0], planes[1]]), None, "no way out");
    }
}
