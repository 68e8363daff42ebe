//! The half-width of regions that each accuracy chooses, and the widths of a body by which it does.

use supple::{
    Accuracy, Body, BodyBuilder, BreakLimit, FractureOptions, HalfWidth, Plasticity, Preset, Simulation,
    Substeps,
};
use supple_tests::{ball, block, lattice, square_sheet};

/// Returns the half-width in a simulation with automatic steps.
fn half_width(body: BodyBuilder) -> HalfWidth {
    let simulation = Simulation::builder().body(body.build().unwrap()).fps(30.0).substeps(Substeps::Auto);
    simulation.build().unwrap().body(0).half_width()
}

/// So stiff that the steps of a frame are many, and their whole number makes no regions narrower.
fn stiff(extents: [i32; 3]) -> BodyBuilder {
    Body::from_lattice(lattice(&block(extents))).youngs_modulus(1e10)
}

fn hollow(outer: i32, inner: i32) -> Vec<[i32; 3]> {
    let wall = (outer - inner) / 2;
    let is_inside = |cell: &[i32; 3]| cell.iter().all(|&c| c >= wall && c < wall + inner);
    block([outer; 3]).into_iter().filter(|cell| !is_inside(cell)).collect()
}

#[test]
fn the_least_width_is_the_shortest_side_or_three_times_that_of_walls() {
    let of_cells = |cells: &[[i32; 3]]| Body::from_lattice(lattice(cells)).build().unwrap().least_width();
    assert!((of_cells(&block([20, 5, 8])) - 5.0).abs() < 1e-6);
    // 6 V/A of walls of two cells.
    let walls = of_cells(&hollow(20, 16));
    assert!((walls - 6.0 * 3904.0 / 3936.0).abs() < 1e-9, "{walls}");
    // The root of 12 r²/5, of a ball of triangles that is somewhat smaller.
    let round = Body::builder(ball(1.0)).cell_size(0.2).build().unwrap().least_width();
    assert!((1.5..2.4_f64.sqrt()).contains(&round), "{round}");
    assert_eq!(Body::builder(square_sheet(1.0, 8)).cell_size(0.2).build().unwrap().least_width(), 0.0);
}

#[test]
fn fast_regions_are_narrow_beside_the_size_and_the_least_width() {
    let fast = |extents| half_width(stiff(extents).accuracy(Accuracy::Fast));
    // R² = w (w + 1): 12 <= (0.15 x 24)² < 20; two cells in smaller bodies.
    assert_eq!([fast([24; 3]), fast([9; 3])], [3, 2]);
    // 2 <= (0.3 x 8)² < 6, and w = 1 in thinner bodies, though L = 23.4 and 14.7.
    assert_eq!([fast([40, 40, 8]), fast([40, 40, 2]), fast([4; 3])], [1, 1, 1]);
}

#[test]
fn balanced_regions_are_those_of_fast_if_steps_are_too_many_and_exact_ones_are_cells() {
    assert_eq!(half_width(stiff([24; 3])), 3);
    assert!(half_width(stiff([24; 3]).accuracy(Accuracy::Exact)).is_cell());
}

/// Dents and cracks follow the strain of the regions: these are at most one cell wide, if nothing else is asked.
#[test]
fn plastic_and_breaking_bodies_choose_narrow_regions() {
    let body = || Body::from_lattice(lattice(&block([40, 20, 20]))).preset(Preset::Rubber);
    let fracture = FractureOptions::new(BreakLimit::Strain(0.1));
    assert!(half_width(body()).cells() > 1.0);
    assert_eq!(half_width(body().plastic(Plasticity::default())), 1);
    assert_eq!(half_width(body().fracture(fracture)), 1);
    assert!(half_width(body().fracture(fracture).accuracy(Accuracy::Fast)).cells() > 1.0);
    assert!(half_width(body().fracture(fracture).accuracy(Accuracy::Exact)).is_cell());
}
