//! Cases with figures that are dropped from half their height, come to rest and fall asleep.

use std::error::Error;

use supple::{Body, Mesh};

use crate::material::bodies::{GRAVITY, automatic, bust, ground};
use crate::material::case::{Case, Outcome, Quantity, Target};
use crate::material::shapes::Figure;

/// Greatest simulated time in seconds.
const MAX_SECONDS: f64 = 16.0;

/// Drops a body of the default material, and measures when it falls asleep.
fn dropped(mesh: Mesh, vertices: usize) -> Outcome {
    let (low, high) = mesh.bounds();
    let height = high.y - low.y;
    let body = Body::builder(mesh).lattice_vertices(vertices).translate([0.0, 0.5 * height - low.y, 0.0]);
    let mut simulation = automatic(body.build()?, [0.0, -GRAVITY, 0.0]).collider(ground()).build()?;
    while simulation.time() < MAX_SECONDS && !simulation.bodies()[0].is_asleep() {
        simulation.advance(1);
    }
    Ok(vec![simulation.time().into()])
}

/// Creates the case of a mesh.
fn case(
    name: &str,
    vertices: usize,
    mesh: impl Fn() -> Result<Mesh, Box<dyn Error>> + Send + Sync + 'static,
) -> Case {
    let quantity = Quantity::new("asleep after (at most 16), s", Target::at_most(8.0));
    let quantity = match (name, vertices) {
        ("bust", 5_000 | 20_000) => {
            quantity.misses("it rocks on the edges of its base; a rigid motion is not damped")
        }
        _ => quantity,
    };
    Case::new(format!("{name}, {vertices} vertices"), [quantity], move || dropped(mesh()?, vertices))
}

/// Returns the cases of this family.
pub(super) fn cases() -> Vec<Case> {
    let mut cases: Vec<Case> = [1_000, 5_000, 20_000].map(|vertices| case("bust", vertices, bust)).into();
    for (name, figure) in Figure::NAMED {
        cases.extend([2_000, 10_000].map(|vertices| case(name, vertices, move || Ok(figure.mesh()?))));
    }
    cases
}
