//! Displayed surfaces of bodies that are near each other: the volume correction does not move them into each other. And the
//! steps of bodies that lie on each other.

use nalgebra::Point3;
use supple::{
    Body, BodyRef, Collider, Display, Handle, Key, Mesh, Pin, Selection, Simulation, SimulationBuilder,
    StepReason, Substeps, TimeWindow, VolumeOptions,
};

use supple_tests::{block, surface_of};

/// Edge of a cell.
const CELL: f64 = 0.25;

/// Returns the keyframes of a displacement in the first second.
pub(crate) fn moving_by(translate: [f64; 3]) -> Vec<Key> {
    vec![Key::default(), Key { time: 1.0, translate, ..Key::default() }]
}

/// A block of cells whose lowest layer is held, and whose highest layer is pressed down by a quarter of its height in a second.
fn pressed(cells: [i32; 3], corner: [f64; 3]) -> Body {
    let mut body = resting(cells, corner, 1e6);
    let height = f64::from(cells[1]) * CELL;
    let at = |low: f64, high: f64| {
        let [low, high] = [low, high].map(|y| corner[1] + y);
        Selection::Box { min: [-10.0, low - 0.01, -10.0], max: [10.0, high + 0.01, 10.0] }
    };
    body.pin(&Pin { goal: None, selection: at(0.0, 0.0), window: TimeWindow::default() }).unwrap();
    let handle = Handle {
        goal: None,
        selection: at(height, height),
        motion: moving_by([0.0, -height / 4.0, 0.0]).into(),
        window: TimeWindow::default(),
    };
    body.handle(&handle).unwrap();
    body
}

/// A block of cells with a mesh of their faces.
fn resting(cells: [i32; 3], corner: [f64; 3], youngs_modulus: f64) -> Body {
    let (vertices, faces) = surface_of(&block(cells));
    let place = |p: [f64; 3]| std::array::from_fn(|a| corner[a] + p[a] * CELL);
    let mesh = Mesh::new(vertices.into_iter().map(place).collect(), &faces).unwrap();
    Body::builder(mesh).cell_size(CELL).youngs_modulus(youngs_modulus).build().unwrap()
}

pub(crate) fn with_bodies(bodies: impl IntoIterator<Item = Body>) -> SimulationBuilder {
    bodies.into_iter().fold(Simulation::builder(), SimulationBuilder::body)
}

/// Two columns side by side that are pressed, with a gap between them, and the greatest and least x coordinates of their
/// displayed surfaces at the gap.
fn pressed_columns(gap: f64, contact: bool) -> (Simulation, f64, f64) {
    let size = [4, 6, 4];
    let bodies = [pressed(size, [-4.0 * CELL - gap / 2.0, 0.0, 0.0]), pressed(size, [gap / 2.0, 0.0, 0.0])];
    let builder = with_bodies(bodies).gravity([0.0; 3]).contact(contact);
    let mut sim = builder.fps(60.0).substeps(Substeps::Fixed(4)).build().unwrap();
    sim.advance(60);
    let coordinates = |k: usize| sim.body(k).surface().positions.into_iter().map(|p: Point3<f64>| p.x);
    let (left, right) =
        (coordinates(0).fold(f64::NEG_INFINITY, f64::max), coordinates(1).fold(f64::INFINITY, f64::min));
    (sim, left, right)
}

#[test]
fn displayed_surfaces_take_half_of_a_gap_each_and_keep_their_volumes() {
    for gap in [0.1 * CELL, 0.3 * CELL] {
        let (_, left, right) = pressed_columns(gap, false);
        assert!(left > 0.1 * CELL && right < -0.1 * CELL, "without contact they overlap: {left} {right}");
        let (sim, left, right) = pressed_columns(gap, true);
        // The dynamics keep the sides of the columns where they are, and the mesh vertices are samples, so that only rounding in
        // f32 remains: 1e-6 of some cells.
        // Without contact they overlap, so that both reach their limits.
        assert!(left.abs() < 1e-5 * CELL && right.abs() < 1e-5 * CELL, "gap {gap}: {left} {right}");
        for k in 0..2 {
            let report = sim.body(k).volume_report();
            assert!((report.after / report.rest - 1.0).abs() < 1e-6, "gap {gap}: {report:?}");
        }
    }
}

/// Returns the greatest depth of a vertex of a displayed surface in the surface of another body.
pub(crate) fn greatest_depth(sim: &Simulation, bodies: [usize; 2]) -> f64 {
    let [points, other] = bodies.map(|k| sim.body(k).surface().positions);
    let other = other.into_iter().map(|p: Point3<f64>| p.into()).collect::<Vec<[f64; 3]>>();
    let other = Collider::mesh(Mesh::new(other, sim.body(bodies[1]).mesh().unwrap().triangles()).unwrap());
    let collider = other.unwrap();
    let distance = collider.signed_distance_at(0.0).unwrap();
    points.into_iter().map(|point| -distance(point.into())).fold(0.0, f64::max)
}

/// A cube, pressed to 0.4 of its height between two plates, with a body beside it that nothing holds.
fn pressed_between_plates(gap: f64, volume: VolumeOptions) -> Simulation {
    let whole = || Selection::Box { min: [-100.0; 3], max: [100.0; 3] };
    let plate = |y: f64| resting([8, 1, 8], [-CELL, y * CELL, -CELL], 1e7);
    let (mut low, mut high) = (plate(-1.01), plate(6.01));
    low.pin(&Pin { goal: None, selection: whole(), window: TimeWindow::default() }).unwrap();
    high.handle(&Handle {
        goal: None,
        selection: whole(),
        motion: moving_by([0.0, -3.6 * CELL, 0.0]).into(),
        window: TimeWindow::default(),
    })
    .unwrap();
    let mut bodies = [
        resting([6; 3], [0.0; 3], 3e5),
        resting([6, 2, 6], [(6.0 + gap) * CELL, 0.2 * CELL, 0.0], 3e5),
        low,
        high,
    ];
    bodies.iter_mut().for_each(|body| body.set_volume(volume).unwrap());
    let builder = with_bodies(bodies).gravity([0.0; 3]).fps(60.0).substeps(Substeps::Fixed(4));
    let mut sim = builder.build().unwrap();
    sim.advance(60);
    sim
}

#[test]
fn a_pressed_body_is_displayed_outside_the_bodies_around_it() {
    for gap in [0.8, 2.4] {
        let [sim, plain] = [VolumeOptions::default(), VolumeOptions::off()]
            .map(|volume| pressed_between_plates(gap, volume));
        for other in 1..4 {
            for bodies in [[0, other], [other, 0]] {
                let [depth, of_lattices] = [&sim, &plain].map(|sim| greatest_depth(sim, bodies) / CELL);
                assert!(depth < of_lattices + 0.1, "gap {gap}, {bodies:?}: {depth} {of_lattices}");
            }
        }
        // The free sides have enough space for the volume, or the report says that they have not.
        let component = sim.body(0).volume_report();
        let residual = component.after / component.rest - 1.0;
        assert!(residual.abs() < 1e-5 || component.capped, "gap {gap}: {component:?}");
    }
}

/// An inner vertex that was moved through a face turns the cells before it inside out. Untangled, they push the face
/// outwards, in a simulation by at most half of the gap to the body beside it.
#[test]
fn untangled_cells_take_at_most_half_of_a_gap() {
    let gap = 0.1 * CELL;
    let bodies = [resting([4; 3], [0.0; 3], 1e5), resting([4; 3], [4.0 * CELL + gap, 0.0, 0.0], 1e5)];
    let mut sim = with_bodies(bodies).gravity([0.0; 3]).build().unwrap();
    sim.bodies_mut().iter_mut().for_each(|body| body.set_volume(VolumeOptions::off()).unwrap());
    sim.advance(1);
    let mut positions = sim.body(0).positions();
    let inner = positions.iter_mut().find(|p| (**p - Point3::new(3.0, 2.0, 2.0) * CELL).norm() < 0.01 * CELL);
    inner.unwrap().x += 1.3 * CELL;
    sim.bodies_mut()[0].set_positions(&positions).unwrap();
    let displayed = |body: BodyRef<'_>| {
        let mut display = Display::new();
        let mut displayed = display.evaluate(body);
        assert!(displayed.untangling().displacements > 0);
        let positions = displayed.surface().positions;
        positions.into_iter().map(|p| p.x / CELL - 4.0).fold(f64::NEG_INFINITY, f64::max)
    };
    let (within, alone) = (displayed(sim.body(0)), displayed(sim.bodies()[0].alone()));
    assert!(alone > 0.1, "outside of the simulation nothing limits it: {alone}");
    // A limit may be exceeded by a thousandth of a cell before the vertices are moved again.
    assert!(within > 0.01 && within < 0.05 + 2e-3, "{within}");
}

#[test]
fn bodies_far_apart_are_displayed_as_without_contact() {
    let gap = 8.0 * CELL;
    let [with, without] = [true, false].map(|contact| pressed_columns(gap, contact).0);
    for k in 0..2 {
        assert_eq!(with.body(k).surface().positions, without.body(k).surface().positions);
    }
}

#[test]
fn a_restored_simulation_is_displayed_with_the_same_gaps() {
    let (sim, ..) = pressed_columns(0.2 * CELL, true);
    let (mut other, ..) = pressed_columns(0.2 * CELL, true);
    other.advance(10);
    assert_ne!(sim.body(0).surface().positions, other.body(0).surface().positions);
    other.restore(&sim.state()).unwrap();
    for k in 0..2 {
        assert_eq!(sim.body(k).surface().positions, other.body(k).surface().positions);
    }
}

#[test]
fn bodies_that_lie_on_each_other_need_more_steps() {
    // Cubes of 1 m.
    let chosen = |places: &[[f64; 3]], contact: bool| {
        let bodies: Vec<Body> = places.iter().map(|place| resting([4; 3], *place, 3e4)).collect();
        let builder = with_bodies(bodies).contact(contact).fps(60.0);
        let builder = builder.collider(Collider::plane([0.0; 3], [0.0, 1.0, 0.0]));
        let mut sim = builder.substeps(Substeps::Auto).build().unwrap();
        sim.step();
        sim.chosen_substeps().unwrap()
    };
    let stack: Vec<[f64; 3]> = (0..5).map(|k| [0.0, 0.1 + 1.05 * f64::from(k), 0.0]).collect();
    let row: Vec<[f64; 3]> = (0..5).map(|k| [1.5 * f64::from(k), 0.1, 0.0]).collect();
    let stacked = chosen(&stack, true);
    // 2 g H dt²/h² = 0.2 with H = 5 m.
    let rate = (2.0 * 9.81 * 5.0 / 0.2_f64).sqrt() / CELL;
    assert_eq!((stacked.reason, stacked.body), (StepReason::Load, 0), "{stacked:?}");
    assert_eq!(f64::from(stacked.steps), (rate / 60.0).ceil());
    // The slab covers the cube with a ninth of its area, which is as much as another cube.
    let slab = |slab: bool| {
        let upper = if slab { [12, 4, 12] } else { [4; 3] };
        let bodies = [resting([4; 3], [0.0, 0.1, 0.0], 3e4), resting(upper, [0.0, 1.2, 0.0], 3e4)];
        let builder = with_bodies(bodies).fps(10.0).substeps(Substeps::Auto);
        let mut sim = builder.collider(Collider::plane([0.0; 3], [0.0, 1.0, 0.0])).build().unwrap();
        sim.step();
        sim.chosen_substeps().unwrap()
    };
    assert_eq!(slab(true).steps, slab(false).steps);
    for other in [chosen(&row, true), chosen(&row, false), chosen(&stack[..1], true)] {
        assert!(other.reason != StepReason::Load && other.steps < stacked.steps, "{other:?}");
    }
}
