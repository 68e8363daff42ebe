//! Chooses the steps per frame for `substeps = "auto"` from the stiffest body and the fastest motion.
//!
//! A step must not be longer than
//!
//! * a sixth of a period of the `frequency` f of any body: alpha = 2 (1 - cos(2 pi f dt)) reaches its cap of
//!   1 at f dt = 1/6, and with a longer step the body would be softer than specified;
//! * the time in which the fastest motion crosses one cell, so that contacts and handles are resolved within
//!   a cell.
//!
//! The speed v of a body is the larger of two speeds, plus the speed of the fastest collider. One is the
//! speed after falling a distance d to the farthest collider below it, v^2 = v0^2 + 2 g d, with the initial
//! speed v0 (velocity, and spin at the rim). The other is the speed of its fastest handle. The stiffness of a
//! body without a `frequency` is per step and sets no limit. With the cell size h, the steps per frame are
//!
//! ```text
//! substeps = max over bodies of ceil(max(6 f / fps, v / (fps h))), at least 1
//! ```

use nalgebra::{Point3, Vector3};

use crate::scene::{BodyData, Scene};
use supple::{Collider, Key, Shape, Stiffness};

/// Largest number of steps per frame that is chosen automatically.
const MAX_STEPS: f64 = 1000.0;
/// Steps per period at alpha = 1.
const STEPS_PER_PERIOD: f64 = 6.0;

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

/// Returns the steps per frame that a scene needs. `placed` has one entry per body of the scene.
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
    // The factor prevents a rounding error from increasing a whole number of steps by one.
    let steps = (needed.fold(1.0, f64::max) * (1.0 - 1e-9)).ceil();
    steps.clamp(1.0, MAX_STEPS) as u32
}

/// Returns half the diagonal of the bounding box of a body.
fn radius(placed: &Placed) -> f64 {
    (placed.high - placed.low).norm() / 2.0
}

/// Returns the speed of a body after a fall to the farthest collider below it. Its handles may lift it first.
fn fall_speed(scene: &Scene, body: &BodyData, placed: &Placed) -> f64 {
    let start = Vector3::from(body.placement.velocity).norm()
        + Vector3::from(body.placement.spin).norm() * radius(placed);
    let gravity = Vector3::from(scene.simulation.gravity);
    let g = gravity.norm();
    if g == 0.0 {
        return start;
    }
    let down = gravity / g;
    let center = nalgebra::center(&placed.low, &placed.high);
    let lift = |key: &Key| -Vector3::from(key.translate).dot(&down);
    let lifted = body.handles.iter().flat_map(|handle| &handle.keys).map(lift).fold(0.0, f64::max);
    let depth = scene.colliders.iter().map(|collider| below(&collider.shape, &center, &down));
    let fall = lifted + depth.fold(0.0, f64::max);
    (start * start + 2.0 * g * fall).sqrt()
}

/// Returns how far a point falls until it reaches a plane, or the height of the center of another shape. For
/// a capsule the lower end of its axis counts.
fn below(shape: &Shape, from: &Point3<f64>, down: &Vector3<f64>) -> f64 {
    let to = |point: [f64; 3]| (Point3::from(point) - from).dot(down);
    match *shape {
        Shape::Plane { point, normal } => {
            let normal = Vector3::from(normal).normalize();
            let towards = normal.dot(down);
            // Nothing falls onto a wall or a ceiling.
            if towards > -1e-6 { 0.0 } else { (Point3::from(point) - from).dot(&normal) / towards }
        }
        Shape::Sphere { center, .. } | Shape::Box { center, .. } => to(center),
        Shape::Capsule { a, b, .. } => to(a).max(to(b)),
    }
}

/// Returns the largest speed of the handles of a body.
fn handle_speed(body: &BodyData, placed: &Placed) -> f64 {
    let radius = radius(placed);
    body.handles.iter().map(|handle| key_speed(&handle.keys, radius)).fold(0.0, f64::max)
}

/// Returns the largest speed of a collider.
fn collider_speed(collider: &Collider) -> f64 {
    let radius = match collider.shape {
        // A rotating plane has no rim; contacts are assumed to be near its center of rotation.
        Shape::Plane { .. } => 0.0,
        Shape::Sphere { radius, .. } => radius,
        Shape::Box { half_extents, .. } => Vector3::from(half_extents).norm(),
        Shape::Capsule { a, b, radius } => (Vector3::from(a) - Vector3::from(b)).norm() / 2.0 + radius,
    };
    key_speed(&collider.keys, radius)
}

/// Returns the largest speed between two keys of a point at distance `radius` from the center of rotation.
fn key_speed(keys: &[Key], radius: f64) -> f64 {
    let speed = |pair: &[Key]| {
        let shift = Vector3::from(pair[1].translate) - Vector3::from(pair[0].translate);
        let turn = Vector3::from(pair[1].rotate) - Vector3::from(pair[0].rotate);
        (shift.norm() + turn.norm().to_radians() * radius) / (pair[1].time - pair[0].time)
    };
    keys.windows(2).map(speed).fold(0.0, f64::max)
}
