//! Cases with bodies that lie on the ground: creep on a slope, and layers that slip through the floor.

use nalgebra::Point3;
use supple::{Body, Lattice, Material, Preset};

use crate::material::bodies::{GRAVITY, automatic, bar, bar_vertices, ground, stepped};
use crate::material::case::{Case, Outcome, Quantity, Target};
use crate::shape::distance;

/// Steps in which the block settles on the slope, and then those in which it may creep.
const SLOPE_STEPS: [u64; 2] = [600, 3_000];

/// Greatest time in seconds in which the cube comes to rest.
const SECONDS: f64 = 8.0;

/// Lets an undamped block lie on a slope with friction 1, and measures its displacement in cells after it has settled.
fn on_a_slope(degrees: f64) -> Outcome {
    let cells: Vec<_> =
        (0..6).flat_map(|z| (0..6).flat_map(move |y| (0..6).map(move |x| [x, y, z]))).collect();
    let lattice = Lattice::from_cells(&cells, 1.0, Point3::origin(), false)?;
    let body = Body::from_lattice(lattice).material(Material::fast_lsm()).half_width(2).build()?;
    let (sine, cosine) = degrees.to_radians().sin_cos();
    let gravity = [GRAVITY * sine, -GRAVITY * cosine, 0.0];
    let mut simulation = stepped(body, gravity, 1.0 / 60.0).collider(ground()).build()?;
    let [before, after] = SLOPE_STEPS.map(|steps| {
        simulation.steps(steps);
        simulation.bodies()[0].positions().iter().map(|p| p.coords).collect::<Vec<_>>()
    });
    Ok(vec![distance(&before, &after).into()])
}

/// Lets a cube come to rest on the ground. Measures how deep its deepest vertex is below it, and how far the layer
/// above the lowest one slips towards it, both in cells.
fn resting(cells: i32, preset: Preset) -> Outcome {
    let body = bar(cells, 1)?.preset(preset).build()?;
    let mut simulation = automatic(body, [0.0, -GRAVITY, 0.0]).collider(ground()).build()?;
    while simulation.time() < SECONDS && !simulation.bodies()[0].is_asleep() {
        simulation.advance(1);
    }
    let body = &simulation.bodies()[0];
    let heights: Vec<f64> = body.positions().iter().map(|p| p.y * f64::from(cells)).collect();
    let layer = heights.iter().zip(body.lattice().indices()).filter(|(_, index)| index[1] == 1);
    let lowest = heights.iter().copied().fold(f64::INFINITY, f64::min);
    let slip = layer.map(|(height, _)| 1.0 - height).fold(0.0, f64::max);
    Ok(vec![(-lowest).max(0.0).into(), slip.into()])
}

/// Returns the cases of this family.
pub(super) fn cases() -> Vec<Case> {
    let slope = |degrees: f64| {
        let name = format!("undamped block on a slope of {degrees} degrees, friction 1");
        let quantity = Quantity::new("creep in 3,000 steps, cells", Target::at_most(0.2));
        let quantity = quantity
            .misses("its vibration unloads the contact; a rigid block under that normal force slides too");
        Case::new(name, [quantity], move || on_a_slope(degrees))
    };
    let mut cases = vec![slope(20.0), slope(27.0)];
    for cells in [10, 20, 45] {
        for (preset, most) in [(Preset::Rubber, 0.2), (Preset::Jelly, 1.0)] {
            let vertices = bar_vertices(cells, 1);
            let name = format!("cube of {vertices} vertices on the ground, {}", preset.name());
            let quantities = ["deepest vertex, cells", "slip, cells"]
                .map(|name| Quantity::new(name, Target::at_most(most)));
            cases.push(Case::new(name, quantities, move || resting(cells, preset)).of_vertices(vertices));
        }
    }
    cases
}
