//! Chooses the number of steps per frame for [`Substeps::Auto`].
//!
//! It is the least number, from 1 to 1000, that meets these conditions for each body, with h the edge of a cell, v the
//! greatest speed that is expected, and L the size of the body:
//!
//! * [`StepReason::Material`]: a body with a Young's modulus reaches it (alpha is at most the greatest one, 1 or
//!   1.5/(1 + k): see [`ElasticLaw`](crate::ElasticLaw)) with the regions of its [`Accuracy`](crate::Accuracy). Larger
//!   regions would make the body stiffer in bending and twist, as 1 + 0.6 R²/t² and 1 + 4 R²/t² where the thickness is
//!   t. A body with a `frequency`
//!   f has at least six steps per period: alpha = 2 (1 - cos(2 π f dt)) is then at most 1.
//! * [`StepReason::Motion`]: the fastest handle or collider crosses at most one cell in a step.
//! * [`StepReason::Fall`]: the body crosses at most one cell in a step at the speed u after a fall to the farthest
//!   collider below it: u² = v0² + 2 g d, with its greatest initial speed v0, and the depth d.
//! * [`StepReason::Slip`]: a layer of vertices that is held, or rests on a collider, slips by at most half a cell under
//!   the weight of the body: 2 w (w + 1)/3 ρ g L (1 + ν)/E <= 1/2.
//! * [`StepReason::Goals`]: a [soft goal](crate::Goal) has at least six steps per period, as long as this takes at most
//!   eight steps per frame: with fewer, vertices are at their targets after each step.
//! * [`StepReason::Load`]: where bodies may come to lie on each other, the layer at which they touch moves by at most a
//!   fifth of a cell in a step under the weight of the bodies above it: 2 g H dt²/h <= h/5, with the height H of a
//!   column of the body's material that has the mass of the body and of those above it, and the body's mean cross
//!   section. Of a body above, the part counts that covers the body, seen along gravity. Contact would have to take
//!   back a longer displacement in each step.

use nalgebra::{Point3, Vector3};

use super::load::stacked_masses;
use crate::body::Body;
use crate::contact::bodies::BodyContacts;
use crate::contact::{Collider, Colliders, Shape};
use crate::dynamics::{Constraint, half_width_of};
use crate::motion::Motion;

/// Greatest number of steps per frame that is chosen automatically.
const MAX_STEPS: f64 = 1000.0;

/// Greatest slip of a held layer in cells.
const MAX_SLIP: f64 = 0.5;

/// Greatest displacement in cells of a layer in a step under the weight of the bodies above it.
const MAX_LOAD_DISPLACEMENT: f64 = 0.2;

/// Greatest number of steps per frame for soft goals.
const MAX_GOAL_STEPS: f64 = 8.0;

/// The number of steps per frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Substeps {
    /// A fixed number, at least 1.
    Fixed(u32),
    /// The least number that the bodies and motions need, from 1 to 1000. It is determined once, at the first step.
    Auto,
}

/// The condition that determines the number of steps per frame of [`Substeps::Auto`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum StepReason {
    /// One step is enough.
    One,
    /// The elasticity of a body.
    Material,
    /// The speed of a handle or a collider.
    Motion,
    /// The speed of a falling body.
    Fall,
    /// The slip of a layer of vertices that is held or rests on a collider.
    Slip,
    /// The frequency of a soft goal.
    Goals,
    /// The weight of the bodies that may come to lie on a body.
    Load,
}

impl StepReason {
    /// Returns a description, as in "12 per frame, for ...".
    pub fn description(self) -> &'static str {
        match self {
            Self::One => "one step is enough",
            Self::Material => "for the stiffness of",
            Self::Motion => "for the speed of the handles and colliders near",
            Self::Fall => "for the speed of the fall of",
            Self::Slip => "against slip at the pins and colliders of",
            Self::Goals => "for the weights of the pins and handles of",
            Self::Load => "for the weight of the bodies above",
        }
    }
}

/// The number of steps per frame that was chosen, and why.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ChosenSubsteps {
    /// The number of steps per frame.
    pub steps: u32,
    /// The condition that needs most steps.
    pub reason: StepReason,
    /// Index of the body that needs them.
    pub body: usize,
}

/// Chooses the number of steps per frame.
pub(super) fn choose(
    bodies: &[Body],
    (contacts, colliders): (Option<&BodyContacts>, &Colliders),
    gravity: Vector3<f64>,
    fps: f64,
) -> ChosenSubsteps {
    let collider_speed = colliders.list().map(collider_speed).fold(0.0, f64::max);
    let stacked_masses = stacked_masses(bodies, contacts, &gravity);
    let mut most = (1.0, StepReason::One, 0);
    for (index, (body, stacked_mass)) in bodies.iter().zip(stacked_masses).enumerate() {
        let needs = Needs::of(body, colliders, gravity);
        let speed = |speed: f64| (speed + collider_speed) / body.lattice().cell_size();
        let rates = [
            (needs.material, StepReason::Material),
            (speed(needs.handle_speed), StepReason::Motion),
            (speed(needs.fall_speed), StepReason::Fall),
            (needs.slip, StepReason::Slip),
            (needs.goals.min(MAX_GOAL_STEPS * fps), StepReason::Goals),
            (load_rate(body, stacked_mass, gravity.norm()), StepReason::Load),
        ];
        for (rate, reason) in rates {
            if rate / fps > most.0 {
                most = (rate / fps, reason, index);
            }
        }
    }
    // The factor 1 - 1e-9 prevents a rounding error from increasing a whole number of steps by one.
    let steps = (most.0 * (1.0 - 1e-9)).ceil().clamp(1.0, MAX_STEPS) as u32;
    ChosenSubsteps { steps, reason: most.1, body: most.2 }
}

/// The steps per second that a body needs, and the speeds that follow from its surroundings.
struct Needs {
    material: f64,
    slip: f64,
    goals: f64,
    handle_speed: f64,
    fall_speed: f64,
}

impl Needs {
    fn of(body: &Body, colliders: &Colliders, gravity: Vector3<f64>) -> Self {
        let (low, high) = body.bounds();
        let radius = (high - low).norm() / 2.0;
        let speeds = body.constraints().map(|constraint| constraint.greatest_speed(radius));
        let handle_speed = speeds.fold(0.0, f64::max);
        let up = -gravity / gravity.norm();
        let lifts = body.constraints().map(|constraint| constraint.greatest_displacement(&up));
        let height = lifts.fold(0.0, f64::max);
        let center = nalgebra::center(&low, &high);
        let initial_speed = body.velocities().iter().map(|velocity| velocity.norm()).fold(0.0, f64::max);
        let fall_speed = if gravity == Vector3::zeros() {
            initial_speed
        } else {
            let depths =
                colliders.list().map(|collider| depth_below(&collider.shape, &center, &gravity.normalize()));
            let fall = height + depths.fold(0.0, f64::max);
            (initial_speed * initial_speed + 2.0 * gravity.norm() * fall).sqrt()
        };
        // Six steps in a period, as for the frequency of a body.
        let goals = 6.0 * body.constraints().map(Constraint::goal_frequency).fold(0.0, f64::max);
        let rests = !colliders.is_empty() || body.constraints().next().is_some();
        let [material, slip] = match body.modulus_to_reach(gravity.norm()) {
            Some(modulus) => {
                let slip = if rests { slip_rate(body, modulus, gravity.norm()) } else { 0.0 };
                [material_rate(body, modulus), slip]
            }
            None => {
                let steps = body.steps_per_period();
                [body.frequency().map_or(0.0, |frequency| steps * frequency), 0.0]
            }
        };
        Self { material, slip, goals, handle_speed, fall_speed }
    }
}

/// Returns the steps per second at which a body reaches its greatest Young's modulus with the regions of its accuracy.
fn material_rate(body: &Body, modulus: f64) -> f64 {
    body.step_rate(body.chosen_half_width(modulus), body.factor_range().1 * modulus)
}

/// Returns the steps per second at which the least sufficient regions are so small that a held layer slips little.
fn slip_rate(body: &Body, modulus: f64, gravity: f64) -> f64 {
    // A constraint or contact acts on the corners of a cell.
    if body.chosen_half_width(modulus).is_cell() {
        return 0.0;
    }
    let (least, greatest) = body.factor_range();
    let (density, poisson_ratio) = (body.material().density, body.greatest_poisson_ratio());
    let modulus_without = modulus / (1.0 + poisson_ratio);
    let product = 1.5 * MAX_SLIP * least * modulus_without / (density * gravity * body.size());
    let half_width = half_width_of(product).floor().max(1.0);
    if half_width.is_finite() { body.step_rate(half_width.into(), greatest * modulus) } else { 0.0 }
}

/// Returns the steps per second at which the layer where a body touches those above it moves little under their weight.
/// `stacked_mass`: mass of the body and of those above it.
fn load_rate(body: &Body, stacked_mass: f64, gravity: f64) -> f64 {
    if stacked_mass <= body.mass() {
        return 0.0;
    }
    let density = body.material().density;
    let height = stacked_mass / density / libm::pow(body.mass() / density, 2.0 / 3.0);
    (2.0 * gravity * height / MAX_LOAD_DISPLACEMENT).sqrt() / body.lattice().cell_size()
}

/// Returns the distance along `down` from a point to a plane, to the center of a sphere, box or mesh, or to the lower
/// end of the axis of a capsule.
fn depth_below(shape: &Shape, start: &Point3<f64>, down: &Vector3<f64>) -> f64 {
    let depth_of = |point: [f64; 3]| (Point3::from(point) - start).dot(down);
    match *shape {
        Shape::Mesh { .. } => depth_of(shape.center().into()),
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

/// Returns the largest speed of a collider.
fn collider_speed(collider: &Collider) -> f64 {
    let radius = match &collider.shape {
        // A plane is infinite. Contacts are assumed to be near its center of rotation.
        Shape::Plane { .. } => 0.0,
        Shape::Sphere { radius, .. } => *radius,
        Shape::Box { half_extents, .. } => Vector3::from(*half_extents).norm(),
        Shape::Capsule { a, b, radius } => (Vector3::from(*a) - Vector3::from(*b)).norm() / 2.0 + radius,
        Shape::Mesh { mesh, scale, .. } => {
            let (low, high) = mesh.mesh().bounds();
            scale * (high - low).norm() / 2.0
        }
    };
    let deformation = match &collider.shape {
        Shape::Mesh { mesh, scale, .. } => {
            mesh.animation().map_or(0.0, |animation| scale * animation.greatest_speed())
        }
        _ => 0.0,
    };
    let motion = Motion::new(collider.keys.clone()).map(|motion| motion.interpolated(collider.interpolation));
    motion.map_or(0.0, |motion| motion.greatest_speed(radius)) + deformation
}
