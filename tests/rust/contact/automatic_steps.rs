//! Automatic steps are short enough for the loads that bodies put on each other.

use supple::{Body, BodyBuilder, Collider, Handle, Key, Preset, Selection, Simulation, Substeps, TimeWindow};
use supple_tests::{mesh_of, plain_box, torus};

/// Returns a body of 800 lattice vertices, a ring that is pulled along x by 1.2 radii in two seconds at its outer end.
fn pulled_ring(side: f64, rotate: [f64; 3]) -> Body {
    let body = Body::builder(torus(0.25, 48, 16)).lattice_vertices(800).rotate(rotate);
    let mut body = body.translate([0.5 * side, 0.0, 0.0]).build().unwrap();
    let selection = Selection::Plane { point: [1.4 * side, 0.0, 0.0], normal: [side, 0.0, 0.0] };
    let end = Key { time: 2.0, translate: [1.2 * side, 0.0, 0.0], ..Key::default() };
    let motion = vec![Key::default(), end].into();
    body.handle(&Handle { goal: None, selection, motion, window: TimeWindow::default() }).unwrap();
    body
}

/// The tubes of two linked rings touch where each passes through the other. Pulled apart, they become long, and stay
/// linked.
#[test]
fn linked_rings_that_are_pulled_apart_hold() {
    let [left, right] = [pulled_ring(-1.0, [0.0; 3]), pulled_ring(1.0, [90.0, 0.0, 0.0])];
    let builder = Simulation::builder().gravity([0.0; 3]).fps(30.0).substeps(Substeps::Auto);
    let mut sim = builder.body(left).body(right).build().unwrap();
    sim.advance(90);
    let [left, right] = [0, 1].map(|index| sim.bodies()[index].positions());
    let end = left.iter().map(|p| p.x).fold(f64::NEG_INFINITY, f64::max);
    let start = right.iter().map(|p| p.x).fold(f64::INFINITY, f64::min);
    // Both tubes are between the two ends, and are pressed to no less than half of their diameter.
    assert!(end - start > 0.5, "the left ring ends at {end}, the right one begins at {start}");
}

/// A cube of ten times the density, put on a cube of rubber a little off its middle, compresses it by 3 % and stays on it.
#[test]
fn a_heavy_body_stays_on_a_light_one() {
    let cube = |low: [f64; 3]| -> BodyBuilder {
        Body::builder(mesh_of(plain_box([0.0; 3], [1.0; 3])))
            .lattice_vertices(200)
            .preset(Preset::Rubber)
            .translate(low)
    };
    let heavy = cube([0.02, 1.03, 0.03]).density(10_000.0).build().unwrap();
    let builder = Simulation::builder().body(cube([0.0, 0.01, 0.0]).build().unwrap()).body(heavy);
    let builder = builder.collider(Collider::plane([0.0; 3], [0.0, 1.0, 0.0])).gravity([0.0, -9.81, 0.0]);
    let mut sim = builder.fps(60.0).substeps(Substeps::Auto).build().unwrap();
    sim.advance(400);
    let center = sim.body(1).center_of_mass();
    assert!(center.y > 1.4 && center.x < 0.6 && center.z < 0.6, "{center}");
    assert!(sim.bodies().iter().all(Body::is_asleep));
}
