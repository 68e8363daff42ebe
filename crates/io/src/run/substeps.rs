//! `substeps = "auto"`: as many steps as the stiffest body and the fastest motion need.
//!
//! A step must not be longer than
//!
//! * a sixth of a period of any body's `frequency` f: alpha = 2 (1 - cos(2 pi f dt)) reaches its
//!   cap of 1 at f dt = 1/6, and beyond it the body would be softer than asked for;
//! * the time in which the fastest motion crosses one cell, so that contacts and handles are met
//!   within a cell.
//!
//! The fastest motion of a body is its start speed (velocity, and spin at its rim) and what it gains
//! by falling until the farthest collider below it, v^2 = v0^2 + 2 g d, or the speed of its fastest
//! handle; the speed of the fastest collider adds to either. A body without a `frequency` asks for
//! nothing by its stiffness, which is then per step. Per frame that makes
//!
//! ```text
//! substeps = max over bodies of ceil(max(6 f / fps, v / (fps h))), at least 1
//! ```

use nalgebra::{Point3, Vector3};

use crate::scene::{BodyData, Scene};
use supple::{Collider, Key, Shape, Stiffness};

/// The most steps of a frame that are chosen by themselves.
const MOST: f64 = 1000.0;
/// Steps in a period: at alpha = 1.
const STEPS_PER_PERIOD: f64 = 6.0;

/// What is known of a body once its lattice is built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placed {
    /// Least corner of the box around the placed mesh.
    pub low: Point3<f64>,
    /// Greatest corner.
    pub high: Point3<f64>,
    /// Length of a cell.
    pub cell_size: f64,
}

/// Steps per frame that a scene needs; `placed` has one entry for each of its bodies.
pub fn substeps(scene: &Scene, placed: &[Placed]) -> u32 {
    let fps = scene.simulation.fps;
    let collider_speed = scene.colliders.iter().map(collider_speed).fold(0.0, f64::max);
    let wanted = scene.bodies.iter().zip(placed).map(|(body, placed)| {
        let frequency = match body.material.stiffness {
            Stiffness::Frequency(frequency) => frequency,
            Stiffness::PerStep(_) => 0.0,
        };
        let speed = collider_speed + fall_speed(scene, body, placed).max(handle_speed(body, placed));
        (STEPS_PER_PERIOD * frequency / fps).max(speed / (fps * placed.cell_size))
    });
    // Rounding must not turn exactly two steps into three.
    let steps = (wanted.fold(1.0, f64::max) * (1.0 - 1e-9)).ceil();
    steps.clamp(1.0, MOST) as u32
}

/// Half the diagonal of a body's box.
fn radius(placed: &Placed) -> f64 {
    (placed.high - placed.low).norm() / 2.0
}

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

/// How far a point may fall until it meets a shape, or passes beside its center.
fn below(shape: &Shape, from: &Point3<f64>, down: &Vector3<f64>) -> f64 {
    let to = |point: [f64; 3]| (Point3::from(point) - from).dot(down);
    match *shape {
        Shape::Plane { point, normal } => {
            let normal = Vector3::from(normal).normalize();
            let towards = normal.dot(down);
            // A wall, or a ceiling: nothing falls onto it.
            if towards > -1e-6 { 0.0 } else { (Point3::from(point) - from).dot(&normal) / towards }
        }
        Shape::Sphere { center, .. } | Shape::Box { center, .. } => to(center),
        Shape::Capsule { a, b, .. } => to(a).max(to(b)),
    }
}

fn handle_speed(body: &BodyData, placed: &Placed) -> f64 {
    let radius = radius(placed);
    body.handles.iter().map(|handle| key_speed(&handle.keys, radius)).fold(0.0, f64::max)
}

fn collider_speed(collider: &Collider) -> f64 {
    let radius = match collider.shape {
        // A turning plane has no rim; what touches it is near the point that it turns about.
        Shape::Plane { .. } => 0.0,
        Shape::Sphere { radius, .. } => radius,
        Shape::Box { half_extents, .. } => Vector3::from(half_extents).norm(),
        Shape::Capsule { a, b, radius } => (Vector3::from(a) - Vector3::from(b)).norm() / 2.0 + radius,
    };
    key_speed(&collider.keys, radius)
}

/// The greatest speed between two keys, of a point at this distance from the center of rotation.
fn key_speed(keys: &[Key], radius: f64) -> f64 {
    let speed = |pair: &[Key]| {
        let shift = Vector3::from(pair[1].translate) - Vector3::from(pair[0].translate);
        let turn = Vector3::from(pair[1].rotate) - Vector3::from(pair[0].rotate);
        (shift.norm() + turn.norm().to_radians() * radius) / (pair[1].time - pair[0].time)
    };
    keys.windows(2).map(speed).fold(0.0, f64::max)
}
