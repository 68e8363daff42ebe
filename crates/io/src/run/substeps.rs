//! Chooses the number of steps per frame for `substeps = "auto"`, from the stiffest body and the fastest
//! motion.
//!
//! The length of a step, dt, must not exceed two times:
//!
//! * A sixth of a period of the `frequency` f of the stiffest body. The stiffness per step is
//!   alpha = 2 (1 - cos(2 pi f dt)), which reaches its largest value, 1, at f dt = 1/6. With a longer step
//!   the body would be softer than specified.
//! * The time in which the fastest motion crosses one cell, so that contacts and handles are resolved within
//!   a cell.
//!
//! The speed v of a body is the speed of the fastest collider plus the larger of two speeds: the speed of the
//! fastest handle of the body, and the speed u after a fall over a distance d to the farthest collider below
//! the body, u^2 = v0^2 + 2 g d. Here g is the gravitational acceleration, and v0 is the initial speed: the
//! velocity, plus the speed of the spin at the corners of the bounding box. A body without a `frequency` has
//! a stiffness per step, which sets no limit. With the cell size h, the number of steps per frame is
//!
//! ```text
//! substeps = max over bodies of ceil(max(6 f / fps, v / (fps h))), from 1 to 1000
//! ```

use nalgebra::{Point3, Vector3};

pub(super) use crate::scene::MAX_SUBSTEPS;
use crate::scene::{BodyData, Scene};
use supple::{Collider, Key, Shape, Stiffness};

/// Largest number of steps per frame that is chosen automatically.
const MAX_STEPS: f64 = 1000.0;
/// Number of steps per period at alpha = 1.
const STEPS_PER_PERIOD: f64 = 6.0;

/// Returns the largest frequency, in Hz, that steps of `dt` seconds represent: a sixth of the step rate. A body
/// with a higher `frequency` is softer than specified.
pub fn largest_frequency(dt: f64) -> f64 {
    1.0 / (STEPS_PER_PERIOD * dt)
}

/// Returns the number of steps per frame that represent a frequency, at least 1. `frame` is the duration of a
/// frame in seconds.
pub(super) fn steps_for(frequency: f64, frame: f64) -> f64 {
    whole_steps(STEPS_PER_PERIOD * frequency * frame)
}

/// Rounds up a number of steps, to at least 1.
fn whole_steps(needed: f64) -> f64 {
    // The factor 1 - 1e-9 prevents a rounding error from increasing a whole number of steps by one.
    (needed * (1.0 - 1e-9)).ceil().max(1.0)
}

/// Bounding box and cell size of a placed body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placed {
    /// Corner of the bounding box with the smallest coordinates.
    pub low: Point3<f64>,
    /// Corner of the bounding box with the largest coordinates.
    pub high: Point3<f64>,
    /// Edge length of a cell.
    pub cell_size: f64,
}

/// Returns the number of steps per frame that a scene needs. `placed` has one entry per body of the scene.
pub fn substeps(scene: &Scene, placed: &[Placed]) -> u32 {
    let fps = scene.simulation.fps;
    let collider_speed = scene.colliders.iter().map(collider_speed).fold(0.0, f64::max);
    let needed = scene.bodies.iter().zip(placed).map(|(body, placed)| {
        let frequency = match body.material.stiffness {
            Stiffness::Frequency(frequency) => frequency,
            Stiffness::PerStep(_) => 0.0,
        };
        let speed = collider_speed + fall_speed(scene, body, placed).max(handle_speed(body, placed));
        (STEPS_PER_PERIOD * frequency / fps).max(speed / (fps * placed.cell_size))
    });
    whole_steps(needed.fold(1.0, f64::max)).min(MAX_STEPS) as u32
}

/// Returns half the diagonal of the bounding box of a body.
fn radius(placed: &Placed) -> f64 {
    (placed.high - placed.low).norm() / 2.0
}

/// Returns the speed of a body after a fall to the farthest collider below it. The fall starts at the largest
/// height to which a handle lifts the body.
fn fall_speed(scene: &Scene, body: &BodyData, placed: &Placed) -> f64 {
    let initial_speed = Vector3::from(body.placement.velocity).norm()
        + Vector3::from(body.placement.spin).norm() * radius(placed);
    let gravity = Vector3::from(scene.simulation.gravity);
    let g = gravity.norm();
    if g == 0.0 {
        return initial_speed;
    }
    let down = gravity / g;
    let center = nalgebra::center(&placed.low, &placed.high);
    let lift = |keyframe: &Key| -Vector3::from(keyframe.translate).dot(&down);
    let lifted = body.handles.iter().flat_map(|handle| &handle.keys).map(lift).fold(0.0, f64::max);
    let depths = scene.colliders.iter().map(|collider| depth_below(&collider.shape, &center, &down));
    let fall = lifted + depths.fold(0.0, f64::max);
    (initial_speed * initial_speed + 2.0 * g * fall).sqrt()
}

/// Returns the distance along `down` from a point to a plane, to the center of a sphere or box, or to the
/// lower end of the axis of a capsule.
fn depth_below(shape: &Shape, start: &Point3<f64>, down: &Vector3<f64>) -> f64 {
    let depth_of = |point: [f64; 3]| (Point3::from(point) - start).dot(down);
    match *shape {
        Shape::Plane { point, normal } => {
            let normal = Vector3::from(normal).normalize();
            let cosine = normal.dot(down);
            // A body does not fall onto a wall or a ceiling.
            if cosine > -1e-6 { 0.0 } else { (Point3::from(point) - start).dot(&normal) / cosine }
        }
        Shape::Sphere { center, .. } | Shape::Box { center, .. } => depth_of(center),
        Shape::Capsule { a, b, .. } => depth_of(a).max(depth_of(b)),
    }
}

/// Returns the largest speed of the handles of a body.
fn handle_speed(body: &BodyData, placed: &Placed) -> f64 {
    let radius = radius(placed);
    body.handles.iter().map(|handle| motion_speed(&handle.keys, radius)).fold(0.0, f64::max)
}

/// Returns the largest speed of a collider.
fn collider_speed(collider: &Collider) -> f64 {
    let radius = match collider.shape {
        // A plane is infinite. Contacts are assumed to be near its center of rotation.
        Shape::Plane { .. } => 0.0,
        Shape::Sphere { radius, .. } => radius,
        Shape::Box { half_extents, .. } => Vector3::from(half_extents).norm(),
        Shape::Capsule { a, b, radius } => (Vector3::from(a) - Vector3::from(b)).norm() / 2.0 + radius,
    };
    motion_speed(&collider.keys, radius)
}

/// Returns the largest speed of a motion, for a point at distance `radius` from the center of rotation.
fn motion_speed(keyframes: &[Key], radius: f64) -> f64 {
    let speed = |pair: &[Key]| {
        let translation = Vector3::from(pair[1].translate) - Vector3::from(pair[0].translate);
        let degrees = Vector3::from(pair[1].rotate) - Vector3::from(pair[0].rotate);
        (translation.norm() + degrees.norm().to_radians() * radius) / (pair[1].time - pair[0].time)
    };
    keyframes.windows(2).map(speed).fold(0.0, f64::max)
}
