//! Forces that pins and handles exert on a body.

use nalgebra::Vector3;
use supple::{
    Body, BodyBuilder, Handle, HoldForce, Key, Pin, Selection, Simulation, Substeps, TimeWindow, Zone,
};
use supple_tests::{block, half_cells, lattice};

/// Selects the lattice vertices of a bar along x at the coordinate `x`, on the side away from its middle `middle`.
fn end(x: f64, middle: f64) -> Selection {
    Selection::Plane { point: [x, 0.0, 0.0], normal: [x - middle, 0.0, 0.0] }
}

fn pin(selection: Selection) -> Pin {
    Pin { goal: None, selection, window: TimeWindow::default() }
}

fn force(sim: &Simulation, index: usize) -> HoldForce {
    sim.body(0).hold_force(index).unwrap().unwrap()
}

/// Returns a bar of 12 x 3 x 3 cells of edge 1 along x.
fn bar() -> BodyBuilder {
    Body::from_lattice(lattice(&block([12, 3, 3])))
}

#[test]
fn a_pin_carries_the_weight_of_a_body_at_rest_and_its_moment() {
    // One layer, and a deep part, of which the other end hangs free.
    for x in [0.0, 3.0] {
        let body = bar().damping_ratio(1.0).density(2.0).pin(pin(end(x, 6.0))).build().unwrap();
        let world = Simulation::builder().body(body).gravity([0.0, -9.81, 0.0]).sleep(false).fps(30.0);
        let mut sim = world.substeps(Substeps::Auto).build().unwrap();
        sim.advance(600);
        let HoldForce { force, torque, center, .. } = force(&sim, 0);
        let body = sim.body(0);
        let weight = body.mass() * Vector3::new(0.0, -9.81, 0.0);
        // The slowest motion, the swing of the free end, has decayed by more than a thousandth.
        assert!((force + weight).norm() < 0.01 * weight.norm(), "{force} {weight}");
        let moment = (body.center_of_mass() - center).cross(&weight);
        assert!((torque + moment).norm() < 0.01 * moment.norm(), "{torque} {moment}");
    }
}

/// Returns sums over 300 steps: of the differences between the change of the momentum in a step and what the forces of
/// two holds before it predict, and of these changes.
fn errors_and_changes(sim: &mut Simulation) -> (f64, f64) {
    let (gravity, mass, dt) = (Vector3::from(sim.gravity()), sim.body(0).mass(), sim.dt());
    let (mut errors, mut changes) = (0.0, 0.0);
    for _ in 0..300 {
        let forces = force(sim, 0).force + force(sim, 1).force;
        let before = sim.body(0).linear_momentum();
        sim.step();
        let change = sim.body(0).linear_momentum() - before;
        errors += (change - (forces + mass * gravity) * dt).norm();
        changes += change.norm();
    }
    assert!(changes > mass, "the body is accelerated: {changes}");
    (errors, changes)
}

/// Returns a simulation of a bar, pinned at one end and moved at the other.
fn moved(body: BodyBuilder) -> Simulation {
    let key = |time, x, turn| Key { time, translate: [x, 0.3 * x, 0.0], rotate: [turn, 0.0, 0.0] };
    let keys = vec![key(0.0, 0.0, 0.0), key(0.3, 2.0, 40.0), key(0.5, 0.5, 0.0)];
    let handle =
        Handle { goal: None, selection: end(12.0, 6.0), motion: keys.into(), window: TimeWindow::default() };
    let zone = Zone::new(Selection::Sphere { center: [8.0, 1.0, 1.0], radius: 2.0 }, 3.0);
    let body = body.youngs_modulus(3e5).zone(zone).pin(pin(end(1.0, 6.0))).handle(handle).build().unwrap();
    let world = Simulation::builder().body(body).gravity([1.0, -9.81, 2.0]).sleep(false).fps(30.0);
    world.substeps(Substeps::Auto).build().unwrap()
}

#[test]
fn forces_and_weight_are_the_change_of_the_momentum() {
    let mut sim = moved(bar().damping_ratio(0.0));
    sim.step();
    let (errors, changes) = errors_and_changes(&mut sim);
    // The f32 goal positions are rounded by 1e-6 cells, beside distances of about 0.1 cell.
    assert!(errors < 1e-3 * changes, "{errors} {changes}");
}

#[test]
fn the_reaction_of_the_damping_is_a_force_of_the_holds() {
    let mut sim = moved(bar().damping_ratio(0.3));
    sim.step();
    let (errors, changes) = errors_and_changes(&mut sim);
    // The rigid motion to which the body is damped is that of the step before.
    assert!(errors < 0.02 * changes, "{errors} {changes}");
}

#[test]
fn overlapping_holds_share_no_vertex_and_inactive_ones_exert_nothing() {
    let body = Body::from_lattice(half_cells()).density(3.0);
    let all = Selection::Plane { point: [0.0; 3], normal: [1.0, 0.0, 0.0] };
    let late =
        Pin { goal: None, selection: all.clone(), window: TimeWindow { start: 9.0, end: f64::INFINITY } };
    let part = Selection::Plane { point: [2.9, 0.0, 0.0], normal: [1.0, 0.0, 0.0] };
    let mut body = body.pin(pin(all)).pin(pin(part)).pin(late).build().unwrap();
    body.pin(&pin(Selection::Vertices(vec![0]))).unwrap();
    assert_eq!(body.alone().hold_force(0).unwrap(), None);
    let mut sim = Simulation::builder().body(body).gravity([0.0, -10.0, 0.0]).build().unwrap();
    assert_eq!(force(&sim, 0).force, Vector3::zeros(), "no step yet");
    sim.steps(3);
    // All vertices are held at rest: each hold carries the weight of its own.
    let masses = sim.body(0).masses();
    let count = |index: usize| sim.body(0).constraint(index).unwrap().vertices().to_vec();
    let part: f64 = count(1).iter().map(|&vertex| masses[vertex as usize]).sum();
    let expected = [sim.body(0).mass() - part - masses[0], part, 0.0, masses[0]];
    for (index, mass) in expected.into_iter().enumerate() {
        let found = force(&sim, index).force;
        // Nothing is deformed, and positions are rounded to f32.
        assert!(
            (found - Vector3::new(0.0, 10.0 * mass, 0.0)).norm() < 0.01 * sim.body(0).mass(),
            "{index}: {found}"
        );
    }
    sim.bodies_mut()[0].release(1).unwrap();
    assert!(sim.body(0).hold_force(1).is_err() && sim.body(0).hold_force(9).is_err());
}
