//! The camera: a direction of view, and the place from which the motion is seen.
//!
//! The picture shows all bodies in the first frame, and of the later places of the bodies those within a distance of the
//! center of the first ones: 8 times half the diagonal of their box, and 1.5 times the distance within which 95 % of all
//! places are. A body that flies away leaves the picture. Colliders are shown as far as they are near the bodies.

use nalgebra::{Matrix3, Vector3};

use super::moment::{Moment, PlaneAt, Solid};

type Vec3 = Vector3<f64>;

/// Largest distance of a place that is shown, relative to half the diagonal of the bodies in the first frame.
const FARTHEST: f64 = 8.0;
/// Share of the places of the bodies, and how many times the distance within which they are is shown.
const SHARE: f64 = 0.95;
const BEYOND: f64 = 1.5;
/// How far beyond the bodies colliders are shown, relative to half the diagonal of the box of the bodies.
const COLLIDERS: f64 = 0.8;
/// Tangent of half the angle of view along the shorter side of the picture.
const VIEW_ANGLE: f64 = 0.24;
/// Share of the picture that the motion takes, along the side that limits it.
const FILLED: f64 = 0.86;
/// Direction to the camera from a body that looks along z and whose up direction is y.
const DEFAULT_VIEW: [f64; 3] = [0.42, 0.34, 1.0];

/// A box along the axes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    low: Vec3,
    high: Vec3,
}

impl Bounds {
    const EMPTY: Self = Self {
        low: Vec3::new(f64::INFINITY, f64::INFINITY, f64::INFINITY),
        high: Vec3::new(f64::NEG_INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY),
    };

    fn of(points: impl IntoIterator<Item = Vec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, |bounds, point| Self {
            low: bounds.low.inf(&point),
            high: bounds.high.sup(&point),
        })
    }

    fn joined(self, other: &Self) -> Self {
        Self { low: self.low.inf(&other.low), high: self.high.sup(&other.high) }
    }

    fn center(&self) -> Vec3 {
        0.5 * (self.low + self.high)
    }

    /// Returns half the diagonal.
    fn radius(&self) -> f64 {
        0.5 * (self.high - self.low).norm()
    }

    fn corners(&self) -> impl Iterator<Item = Vec3> + '_ {
        (0..8).map(|corner| {
            Vec3::from_fn(|axis, _| if corner >> axis & 1 == 0 { self.low[axis] } else { self.high[axis] })
        })
    }

    /// Returns the part within a box; `None` if there is none.
    fn clipped(&self, to: &Self) -> Option<Self> {
        let part = Self { low: self.low.sup(&to.low), high: self.high.inf(&to.high) };
        (0..3).all(|axis| part.low[axis] <= part.high[axis]).then_some(part)
    }

    fn grown(&self, by: f64) -> Self {
        Self { low: self.low.add_scalar(-by), high: self.high.add_scalar(by) }
    }
}

/// The places of the bodies and colliders in the frames of a motion, y up.
#[derive(Debug)]
pub(super) struct Places {
    /// From the axes of the files to those with y up.
    turn: Matrix3<f64>,
    bodies: Vec<Bounds>,
    /// Number of bodies of the first frame.
    first: usize,
    colliders: Vec<Bounds>,
    planes: Vec<PlaneAt>,
}

impl Places {
    pub(super) fn new(up: [f64; 3]) -> Self {
        Self { turn: turn(up), bodies: Vec::new(), first: 0, colliders: Vec::new(), planes: Vec::new() }
    }

    /// Adds a frame.
    pub(super) fn add(&mut self, moment: &Moment) {
        let turn = self.turn;
        let bounds = |solid: &Solid| {
            let bounds = Bounds::of(solid.positions.iter().map(|point| Vec3::from(point.map(f64::from))));
            (!solid.positions.is_empty()).then(|| Bounds::of(bounds.corners().map(|corner| turn * corner)))
        };
        self.bodies.extend(moment.bodies.iter().filter_map(bounds));
        self.colliders.extend(moment.colliders.iter().filter_map(bounds));
        if self.first == 0 {
            self.first = self.bodies.len();
            self.planes.clone_from(&moment.planes);
        }
    }

    /// Returns the box that the pictures show.
    fn shown(&self) -> Bounds {
        let union = |bounds: &[Bounds]| bounds.iter().fold(Bounds::EMPTY, |all, bounds| all.joined(bounds));
        let at_first = union(&self.bodies[..self.first]);
        if self.first == 0 {
            let colliders = union(&self.colliders);
            return if self.colliders.is_empty() {
                Bounds::of([Vec3::zeros()]).grown(1.0)
            } else {
                colliders
            };
        }
        let center = at_first.center();
        let distance = |bounds: &Bounds| (bounds.center() - center).norm() + bounds.radius();
        let mut distances: Vec<f64> = self.bodies.iter().map(distance).collect();
        distances.sort_by(f64::total_cmp);
        let most = distances[((distances.len() - 1) as f64 * SHARE) as usize];
        let limit = (FARTHEST * at_first.radius()).min(BEYOND * most).max(at_first.radius());
        let window = Bounds { low: center, high: center }.grown(limit);
        let bodies = self
            .bodies
            .iter()
            .filter_map(|bounds| bounds.clipped(&window))
            .fold(at_first, |all, part| all.joined(&part));
        let near = bodies.grown(COLLIDERS * bodies.radius());
        let colliders = self.colliders.iter().filter_map(|bounds| bounds.clipped(&near));
        colliders.fold(bodies, |all, part| all.joined(&part))
    }
}

/// Returns the rotation after which y points up, or the opposite direction, along the axis nearest to `up`.
fn turn(up: [f64; 3]) -> Matrix3<f64> {
    let [x, y, z] = up.map(f64::abs);
    if z > x.max(y) {
        Matrix3::new(1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, -1.0, 0.0)
    } else if x > y {
        Matrix3::new(0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0)
    } else {
        Matrix3::identity()
    }
}

/// A camera. It sees the motion in coordinates of its own: y points up, the center of what is shown is the origin, and
/// half the diagonal of its box is 1.
#[derive(Clone, Debug)]
pub(super) struct Camera {
    turn: Matrix3<f64>,
    center: Vec3,
    scale: f64,
    /// Place of the camera, in its coordinates.
    pub(super) eye: Vector3<f32>,
    /// Directions to the right, up and backwards in the picture.
    pub(super) axes: [Vector3<f32>; 3],
    /// Pixels per tangent of the angle from the middle of the picture.
    pub(super) focal: f32,
}

impl Camera {
    /// * `size`: width and height of the pictures in pixels.
    /// * `view`: direction from the bodies to the camera in the axes of the files; `None` for the default.
    pub(super) fn new(places: &Places, size: [u32; 2], view: Option<[f64; 3]>) -> Self {
        let turn = places.turn;
        let shown = places.shown();
        // A point, and planes at infinity, have no size.
        let radius = if shown.radius() > 0.0 { shown.radius() } else { 1.0 };
        let (center, scale) = (shown.center(), radius.recip());
        let view = view.map_or(Vec3::from(DEFAULT_VIEW), |view| turn * Vec3::from(view)).normalize();
        // Of a view along the vertical, z is vertical in the picture.
        let vertical = if view.y.abs() < 0.999 { Vec3::y() } else { -Vec3::z() * view.y.signum() };
        let right = vertical.cross(&view).normalize();
        let up = view.cross(&right);
        let [width, height] = size.map(f64::from);
        let focal = 0.5 * width.min(height) / VIEW_ANGLE;
        let tangents = [width, height].map(|side| FILLED * 0.5 * side / focal);
        let points: Vec<Vec3> = shown.corners().map(|corner| (corner - center) * scale).collect();
        // A camera at (x, z) sees all points between lines of slope t if x + t z >= max(p + t q) and
        // -x + t z >= max(-p + t q), for points p to the right and q toward the camera. The nearest such z is between.
        let fit = |axis: &Vec3, t: f64| {
            let farthest = |sign: f64| {
                let sides = points.iter().map(|point| sign * axis.dot(point) + t * view.dot(point));
                sides.fold(f64::NEG_INFINITY, f64::max)
            };
            let (a, b) = (farthest(1.0), farthest(-1.0));
            (0.5 * (a - b), 0.5 * (a + b) / t)
        };
        let ((x, near_x), (y, near_y)) = (fit(&right, tangents[0]), fit(&up, tangents[1]));
        let eye = x * right + y * up + near_x.max(near_y) * view;
        Self {
            turn,
            center,
            scale,
            eye: eye.cast(),
            axes: [right, up, view].map(|axis| axis.cast()),
            focal: focal as f32,
        }
    }

    /// Returns a camera for pictures that are larger by a factor.
    pub(super) fn magnified(&self, factor: f32) -> Self {
        Self { focal: self.focal * factor, ..self.clone() }
    }

    /// Returns a position in the coordinates of the camera.
    pub(super) fn place(&self, position: [f32; 3]) -> Vector3<f32> {
        ((self.turn * Vec3::from(position.map(f64::from)) - self.center) * self.scale).cast()
    }

    /// Returns a plane in the coordinates of the camera: a point and the unit normal. `None` without a direction.
    pub(super) fn plane(&self, plane: &PlaneAt) -> Option<(Vector3<f32>, Vector3<f32>)> {
        let normal = (self.turn * Vec3::from(plane.normal)).try_normalize(0.0)?;
        let offset = self.turn * Vec3::from(plane.point) - self.center;
        // The point of the plane that is next to the center of the picture.
        let point = normal * normal.dot(&offset) * self.scale;
        Some((point.cast(), normal.cast()))
    }

    /// Returns the pixel of a point, from the upper left corner, and the inverse of its distance along the view: not
    /// above 0 behind the camera.
    pub(super) fn project(&self, point: Vector3<f32>, size: [u32; 2]) -> [f32; 3] {
        let to = point - self.eye;
        let depth = -self.axes[2].dot(&to);
        let inverse = if depth > 1e-4 { depth.recip() } else { 0.0 };
        let [x, y] = [0, 1].map(|axis| self.focal * self.axes[axis].dot(&to) * inverse);
        [0.5 * size[0] as f32 + x, 0.5 * size[1] as f32 - y, inverse]
    }

    /// Returns the direction of the ray through a pixel, whose length along the view is 1.
    pub(super) fn ray(&self, [x, y]: [f32; 2], size: [u32; 2]) -> Vector3<f32> {
        let x = (x - 0.5 * size[0] as f32) / self.focal;
        let y = (0.5 * size[1] as f32 - y) / self.focal;
        x * self.axes[0] + y * self.axes[1] - self.axes[2]
    }
}
