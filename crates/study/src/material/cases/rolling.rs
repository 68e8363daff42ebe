//! Cases with a ball of the diameter 1 that rolls down a slope or bounces.

use supple::{Body, BodyBuilder, Collider, Preservation};

use crate::material::bodies::{GRAVITY, automatic, ball, ground, mean_velocity};
use crate::material::case::{Case, Measured, Outcome, Quantity, Target};
use crate::material::trace::slope;

/// Angle of the slope in degrees.
const DEGREES: f64 = 10.0;

/// Drop height: the distance of the lowest point from the ground.
const DROP: f64 = 1.0;

/// Creates a builder of the ball at the given height of its center.
fn at(height: f64, vertices: usize) -> Result<BodyBuilder, supple::Error> {
    let body = Body::builder(ball()?).lattice_vertices(vertices).volume(Preservation::Off);
    Ok(body.translate([0.0, height, 0.0]))
}

/// Lets the ball roll, and measures its acceleration from 0.5 to 3 s. The law is 5/7 g sin of the slope, that of a
/// rigid ball.
fn rolled(vertices: usize, damped: bool) -> Outcome {
    let body = at(0.5, vertices)?;
    let body = if damped { body } else { body.damping_ratio(0.0) };
    let (sine, cosine) = DEGREES.to_radians().sin_cos();
    let gravity = [GRAVITY * sine, -GRAVITY * cosine, 0.0];
    let mut simulation = automatic(body.build()?, gravity).collider(ground()).build()?;
    simulation.advance(30);
    let mut velocity = |_| {
        simulation.advance(1);
        (simulation.time(), mean_velocity(&simulation.bodies()[0]).x)
    };
    let velocities: Vec<_> = (0..150).map(&mut velocity).collect();
    Ok(vec![Measured::by_law(slope(&velocities), 5.0 / 7.0 * GRAVITY * sine)])
}

/// Drops a ball, and measures how high it rises again, over the drop height.
fn bounced(vertices: usize, damping_ratio: f64, restitution: f64) -> Outcome {
    let body = at(0.5 + DROP, vertices)?.damping_ratio(damping_ratio).build()?;
    let ground = Collider { restitution, ..ground() };
    let mut simulation = automatic(body, [0.0, -GRAVITY, 0.0]).collider(ground).build()?;
    let (mut highest, mut has_bounced) = (0.0_f64, false);
    // It falls for √(2 DROP/g) = 0.45 s, and rises again for less.
    for _ in 0..90 {
        simulation.advance(1);
        let body = &simulation.bodies()[0];
        has_bounced |= simulation.time() > 0.3 && mean_velocity(body).y > 0.0;
        if has_bounced {
            highest = highest.max(body.center_of_mass().y - 0.5);
        }
    }
    Ok(vec![Measured::by_law(highest, DROP)])
}

/// Returns the cases of this family.
pub(super) fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for vertices in [500, 4_000] {
        for (name, damped) in [("default damping", true), ("undamped", false)] {
            let quantity = Quantity::new("acceleration, m/s^2", Target::at_least(0.9));
            let quantity = match vertices {
                500 => quantity.misses("8 cells across are too coarse for a ball"),
                _ => quantity,
            };
            let name = format!("rolls down 10 degrees, {vertices} vertices, {name}");
            cases.push(Case::new(name, [quantity], move || rolled(vertices, damped)));
        }
    }
    for vertices in [500, 4_000] {
        let quantity = Quantity::new("bounce height, m", Target::within(0.75, 1.0));
        let name = format!("bounces, {vertices} vertices, undamped");
        cases.push(Case::new(name, [quantity], move || bounced(vertices, 0.0, 0.0)));
        let quantity = Quantity::new("bounce height, m", Target::within(0.5, 0.8));
        let name = format!("bounces, {vertices} vertices, damping ratio 0.02, restitution 0.8");
        cases.push(Case::new(name, [quantity], move || bounced(vertices, 0.02, 0.8)));
    }
    cases
}
