//! Forces add up: gravity and the contacts that are reported change the momentum of a body, at any damping, and a contact gives
//! only what it can: it does not pull, and without friction it does not push sideways.

use nalgebra::Vector3;
use supple::{
    Body, BodyBuilder, Collider, Selection, Simulation, SimulationBuilder, Substeps, Touched, Zone,
};
use supple_tests::{block, lattice};

const GRAVITY: f64 = 9.81;
const DAMPING: [f64; 4] = [0.0, 0.1, 0.3, 1.0];

/// Returns a cube of the default material with an edge of 1 and 125 lattice vertices.
fn cube(name: &str, damping_ratio: f64) -> BodyBuilder {
    Body::from_lattice(lattice(&block([4; 3])).scaled(0.25).unwrap()).name(name).damping_ratio(damping_ratio)
}

fn ground(friction: f64) -> Collider {
    Collider { friction, ..Collider::plane([0.0; 3], [0.0, 1.0, 0.0]) }
}

fn build(builder: SimulationBuilder) -> Simulation {
    builder.fps(60.0).substeps(Substeps::Auto).threads(1).sleep(false).build().unwrap()
}

/// The momentum of each body before a step, and what a step shows.
struct Balance {
    momenta: Vec<Vector3<f64>>,
    /// Greatest force that a momentum shows beside gravity, greatest difference of it to the reported contacts, and
    /// greatest pull of a contact.
    largest: f64,
    missing: f64,
    pull: f64,
}

impl Balance {
    fn new(simulation: &Simulation) -> Self {
        let momenta = simulation.bodies().iter().map(|body| body.linear_momentum()).collect();
        Self { momenta, largest: 0.0, missing: 0.0, pull: 0.0 }
    }

    fn step(&mut self, simulation: &mut Simulation) {
        simulation.step();
        let mut reported = vec![Vector3::zeros(); self.momenta.len()];
        for contact in simulation.contacts() {
            reported[contact.body] += contact.force;
            match contact.other {
                Touched::Body(other) => reported[other] -= contact.force,
                Touched::Collider(_) => {}
            }
            self.pull = self.pull.max(-contact.force.dot(&contact.normal));
        }
        for (index, before) in self.momenta.iter_mut().enumerate() {
            let body = simulation.body(index);
            let after = body.linear_momentum();
            let gravity = Vector3::from(simulation.gravity()) * body.mass();
            let force = (after - std::mem::replace(before, after)) / simulation.dt() - gravity;
            self.largest = self.largest.max(force.norm());
            self.missing = self.missing.max((force - reported[index]).norm());
        }
    }
}

/// Asserts for 1.5 seconds that the reported contacts are all that gravity leaves of the change of the momenta, to 1e-4
/// of the largest force.
fn assert_adds_up(name: &str, simulation: Simulation) {
    let pull = assert_nothing_is_missing(name, simulation);
    assert!(pull <= 1e-4, "{name}: a contact pulls with {pull} of the largest force");
}

/// The first part of [`assert_adds_up`]. Returns the greatest pull of a contact over the largest force.
fn assert_nothing_is_missing(name: &str, mut simulation: Simulation) -> f64 {
    simulation.step();
    let mut balance = Balance::new(&simulation);
    while simulation.time() < 1.5 {
        balance.step(&mut simulation);
    }
    let Balance { largest, missing, pull, .. } = balance;
    assert!(largest > 0.0, "{name}");
    assert!(missing <= 1e-4 * largest, "{name}: {missing} of {largest} is not reported");
    pull / largest
}

#[test]
fn contacts_with_colliders_are_all_that_changes_the_momentum_beside_gravity() {
    for damping in DAMPING {
        for (name, rotation, friction) in
            [("flat", [0.0; 3], 0.5), ("tilted", [20.0, 0.0, 15.0], 0.5), ("smooth", [20.0, 0.0, 15.0], 0.0)]
        {
            let body = cube("cube", damping).rotate(rotation).translate([0.0, 1.0, 0.0]).build().unwrap();
            let simulation = build(Simulation::builder().body(body).collider(ground(friction)));
            assert_adds_up(&format!("{name}, damping ratio {damping}"), simulation);
        }
    }
}

#[test]
fn contacts_between_bodies_are_all_that_changes_their_momenta_beside_gravity() {
    for damping in DAMPING {
        let mut first = cube("first", damping).build().unwrap();
        let velocities = vec![Vector3::new(1.0, 0.0, 0.0); first.lattice().len()];
        first.set_velocities(&velocities).unwrap();
        let second = cube("second", damping).translate([1.2, 0.3, 0.2]).build().unwrap();
        let free = Simulation::builder().body(first).body(second).gravity([0.0; 3]);
        assert_adds_up(&format!("free, damping ratio {damping}"), build(free));
        let first = cube("first", damping).build().unwrap();
        let second = cube("second", damping).translate([0.2, 1.3, 0.1]).build().unwrap();
        let stack = Simulation::builder().body(first).body(second).collider(ground(0.5));
        assert_adds_up(&format!("stack, damping ratio {damping}"), build(stack));
    }
}

/// Damping and friction that vary over the bodies change nothing in the law.
#[test]
fn forces_of_bodies_with_zones_add_up() {
    let half = |low: f64| Selection::Box { min: [low, -1.0, -1.0], max: [low + 0.6, 3.0, 3.0] };
    let zoned = |name, damping| {
        let damped = Zone { damping: 20.0, friction: 0.2, ..Zone::new(half(-0.1), 1.0) };
        let rough = Zone { damping: 0.1, friction: 4.0, ..Zone::new(half(0.6), 1.0) };
        cube(name, damping).zone(damped).zone(rough)
    };
    let mut pull = 0.0_f64;
    for damping in DAMPING {
        let body = zoned("tilted", damping).rotate([20.0, 0.0, 15.0]).translate([0.0, 1.0, 0.0]);
        let scene = Simulation::builder().body(body.build().unwrap()).collider(ground(0.5));
        pull = pull.max(assert_nothing_is_missing(&format!("tilted, damping ratio {damping}"), build(scene)));
        let first = zoned("first", damping).build().unwrap();
        let second = zoned("second", damping).translate([0.2, 1.3, 0.1]).build().unwrap();
        let stack = Simulation::builder().body(first).body(second).collider(ground(0.5));
        pull = pull.max(assert_nothing_is_missing(&format!("stack, damping ratio {damping}"), build(stack)));
    }
    // The reaction of the damping is limited along the mean normal of the contacts, and shared by contacts with others.
    assert!(pull <= 1e-3, "{pull}");
}

/// Without friction nothing changes the momentum along a plane: a tilted cube that falls does not drift, and a cube that
/// slides keeps its velocity.
#[test]
fn bodies_keep_their_momentum_along_a_plane_without_friction() {
    for damping in DAMPING {
        for (rotation, height, speed) in [([20.0, 0.0, 15.0], 1.0, 0.0), ([0.0; 3], 0.0, 0.05)] {
            let mut body =
                cube("cube", damping).rotate(rotation).translate([0.0, height, 0.0]).build().unwrap();
            body.set_velocities(&vec![Vector3::new(speed, 0.0, 0.0); body.lattice().len()]).unwrap();
            let mut simulation = build(Simulation::builder().body(body).collider(ground(0.0)));
            simulation.advance(120);
            let body = simulation.body(0);
            let velocity = body.linear_momentum() / body.mass();
            // Rounding of single-precision velocities in at most 10^4 steps, if every step rounds in the same direction.
            let fastest = speed.max((2.0 * GRAVITY * height).sqrt());
            let drift = (velocity.x - speed).hypot(velocity.z);
            assert!(drift < fastest * 6e-8 * 1e4, "damping ratio {damping}, tilted by {rotation:?}: {drift}");
        }
    }
}

/// A body that is pulled up with more than its weight rises as a free one does: the ground does not hold it.
#[test]
fn the_ground_does_not_hold_a_body_that_is_pulled_up() {
    for damping in DAMPING {
        let body = cube("cube", damping).build().unwrap();
        let mut simulation = build(Simulation::builder().body(body).collider(ground(0.5)));
        simulation.advance(120);
        let start = simulation.body(0).center_of_mass().y;
        let lift = 1.5 * GRAVITY * simulation.body(0).mass();
        let began = simulation.time();
        while simulation.time() < began + 1.0 {
            let everywhere = Selection::Sphere { center: [0.0; 3], radius: 100.0 };
            simulation.body_mut(0).apply_force([0.0, lift, 0.0], &everywhere).unwrap();
            simulation.step();
        }
        let rise = simulation.body(0).center_of_mass().y - start;
        let time = simulation.time() - began;
        // It is free as soon as the ground does not press: within the time in which the pressed layer expands, a fraction
        // of the period of its lowest mode, of about 0.1 s.
        let law = 0.25 * GRAVITY * time * time;
        assert!((rise / law - 1.0).abs() < 0.15, "damping ratio {damping}: {rise} of {law}");
    }
}
