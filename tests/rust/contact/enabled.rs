//! Colliders that are enabled and disabled, by keyframes and between steps.

use nalgebra::{Point3, Vector3};
use supple::{Body, Collider, Key, Lattice, Preset, Simulation, SimulationBuilder, Switch, SwitchKey};
use supple_tests::{block, greatest_distance};

const DT: f64 = 1.0 / 120.0;
const CELL: f64 = 0.25;

/// Returns a cube with edges of 1, with its lowest corner at `corner`.
fn cube(name: &str, corner: [f64; 3]) -> Body {
    let lattice = Lattice::from_cells(&block([4; 3]), CELL, Point3::from(corner), true).unwrap();
    Body::from_lattice(lattice).name(name).preset(Preset::Rubber).build().unwrap()
}

fn switch(keys: &[(f64, bool)]) -> Switch {
    Switch::new(keys.iter().map(|&(time, value)| SwitchKey { time, value }).collect()).unwrap()
}

/// Returns a box from y = -1 to y = 0 around `x`.
fn door(x: f64, enabled: impl Into<Switch>) -> Collider {
    let door = Collider::cuboid([x, -0.5, 0.0], [1.0, 0.5, 1.0], [0.0; 3]);
    Collider { enabled: enabled.into(), ..door }
}

fn of(bodies: impl IntoIterator<Item = Body>) -> SimulationBuilder {
    let builder = Simulation::builder().dt(DT).threads(1).gravity([0.0, -9.81, 0.0]);
    bodies.into_iter().fold(builder, |builder, body| builder.body(body))
}

fn lowest(simulation: &Simulation, body: usize) -> f64 {
    simulation.bodies()[body].positions().iter().map(|p| p.y).fold(f64::INFINITY, f64::min)
}

/// Returns the bits of the positions and velocities of the bodies.
fn bits(simulation: &Simulation) -> Vec<[u64; 3]> {
    let vectors = simulation.bodies().iter().flat_map(|body| {
        let positions = body.positions().into_iter().map(|p| p.coords);
        positions.chain(body.velocities()).collect::<Vec<_>>()
    });
    vectors.map(|v: Vector3<f64>| <[f64; 3]>::from(v).map(f64::to_bits)).collect()
}

#[test]
fn a_disabled_collider_touches_nothing() {
    let run = |colliders: &[Collider]| {
        let builder = of([cube("a", [-0.5, 0.1, -0.5])]);
        let mut simulation =
            colliders.iter().fold(builder, |builder, c| builder.collider(c.clone())).build().unwrap();
        simulation.steps(120);
        simulation
    };
    let mesh = supple_tests::mesh_of(supple_tests::plain_box([-2.0, -3.0, -2.0], [2.0, -1.0, 2.0]));
    let ground = Collider::plane([0.0; 3], [0.0, 1.0, 0.0]);
    let disabled = [
        door(0.0, false),
        Collider { enabled: false.into(), ..Collider::mesh(mesh).unwrap() },
        Collider { enabled: switch(&[(0.0, false), (9.0, true)]), ..ground.clone() },
    ];
    let falling = run(&disabled);
    // As with a collider that is far away.
    assert_eq!(bits(&falling), bits(&run(&[Collider::plane([0.0, -100.0, 0.0], [0.0, 1.0, 0.0])])));
    assert!(falling.contacts().is_empty() && lowest(&falling, 0) < -4.0);
    assert_eq!([0, 1, 2].map(|index| falling.collider(index).is_enabled()), [false; 3]);

    // The surface of a body in a disabled collider is displayed as without it, and no ray meets the collider.
    let inside = |enabled: bool| {
        let plane = Collider { enabled: enabled.into(), ..ground.clone() };
        of([cube("a", [-0.5, -0.01, -0.5])]).gravity([0.0; 3]).collider(plane).build().unwrap()
    };
    let ray = [([9.0, 1.0, 0.0], [0.0, -1.0, 0.0])];
    assert!(inside(true).raycast(&ray, f64::INFINITY).unwrap()[0].is_some());
    assert!(inside(false).raycast(&ray, f64::INFINITY).unwrap()[0].is_none());
    let near = |enabled| inside(enabled).nearest(&[[9.0, 1.0, 0.0]]).unwrap()[0].unwrap().distance;
    assert!(near(true) == 1.0 && near(false) > 8.0);
}

/// Returns a stack of two cubes on a collider that is disabled from 2 s to 3 s, and a cube far away on another one.
fn on_doors() -> Simulation {
    let places = [("near", [-0.5, 0.0]), ("above", [-0.5, 1.0]), ("far", [19.5, 0.0])];
    let bodies = places.map(|(name, [x, y])| cube(name, [x, y, -0.5]));
    let away = switch(&[(2.0, false), (3.0, true)]);
    of(bodies).collider(door(0.0, away)).collider(door(20.0, true)).build().unwrap()
}

fn asleep(simulation: &Simulation) -> Vec<bool> {
    simulation.bodies().iter().map(Body::is_asleep).collect()
}

#[test]
fn bodies_that_sleep_on_a_collider_wake_up_when_it_goes_and_others_sleep_on() {
    let mut simulation = on_doors();
    simulation.steps(239);
    assert_eq!(asleep(&simulation), [true; 3]);
    let saved = simulation.state();
    let height = lowest(&simulation, 0);
    // At 2 s the collider goes: the body on it wakes up, and with it the body above.
    simulation.steps(2);
    assert_eq!(asleep(&simulation), [false, false, true]);
    simulation.steps(58);
    // The sum of 59 steps of free fall, and what the weight of both, a strain of 2/300 of rubber, pushes when it is gone: with
    // at most the speed 2/300 √(E/ρ), E = 300 ρ L g.
    let (fall, push) =
        (9.81 * DT * DT * 59.0 * 60.0 / 2.0, 2.0 / 300.0 * (300.0 * 9.81_f64).sqrt() * 59.0 * DT);
    let fallen = height - lowest(&simulation, 0);
    assert!(fallen > 0.98 * fall && fallen < fall + push, "{fallen} {fall} {push}");
    let expected = bits(&simulation);
    simulation.restore(&saved).unwrap();
    assert!(simulation.collider(0).is_enabled());
    simulation.steps(60);
    assert_eq!(bits(&simulation), expected);
    // After a reset they are the same steps again.
    let mut fresh = on_doors();
    fresh.steps(250);
    simulation.reset();
    assert!(simulation.collider(0).is_enabled());
    simulation.steps(250);
    assert_eq!(bits(&simulation), bits(&fresh));
}

#[test]
fn a_sleeping_body_wakes_up_without_its_support_in_a_restored_state_and_beside_a_collider_that_comes() {
    let mut simulation = of([cube("a", [-0.5, 0.0, -0.5])])
        .collider(door(0.0, true))
        .collider(door(2.0, false))
        .build()
        .unwrap();
    simulation.steps(150);
    assert_eq!(asleep(&simulation), [true]);
    let saved = simulation.state();
    simulation.collider_mut(1).set_enabled(true);
    assert_eq!((asleep(&simulation), simulation.collider(1).is_enabled()), (vec![false], true));
    simulation.collider_mut(0).set_enabled(false);
    simulation.restore(&saved).unwrap();
    assert_eq!(asleep(&simulation), [true]);
    simulation.steps(1);
    assert_eq!(asleep(&simulation), [false]);
}

#[test]
fn a_body_inside_a_collider_that_is_enabled_leaves_it_whole() {
    let wall =
        Collider { enabled: switch(&[(1.0, true)]), ..Collider::cuboid([0.2, 0.0, 0.0], [1.0; 3], [0.0; 3]) };
    let key = |time, x| Key { time, translate: [x, 0.0, 0.0], rotate: [0.0; 3] };
    // The wall moves along its keyframes while it is disabled.
    let moving = Collider { keys: vec![key(0.0, 9.0), key(0.9, 0.0)], ..wall.clone() };
    for collider in [wall.clone(), moving] {
        let builder = of([cube("a", [-0.5; 3]), cube("far", [9.5, -0.5, -0.5])]).gravity([0.0; 3]);
        let mut simulation = builder.collider(collider).build().unwrap();
        let start = simulation.body(0).positions();
        simulation.steps(119);
        // It is at rest, to the rounding of f32.
        assert!(greatest_distance(&simulation.body(0).positions(), &start) < 1e-6);
        simulation.steps(1);
        assert!(simulation.collider(0).is_enabled());
        let saved = simulation.state();
        let mut shift = Vector3::zeros();
        for _ in 0..64 {
            simulation.step();
            let positions = simulation.body(0).positions();
            shift = positions[0] - start[0];
            // One translation of all vertices. At its end, contacts remove depths of up to 0.01 cells.
            let moved: Vec<_> = start.iter().map(|point| point + shift).collect();
            let deformation = greatest_distance(&positions, &moved);
            assert!(deformation < 0.01 * CELL, "{deformation}");
        }
        // Out of the nearest face, at x = -0.8, to 0.01 cells, which contacts remove.
        let depth = |p: &Point3<f64>| -wall.shape.signed_distance((*p).into()).distance;
        let deepest = simulation.body(0).positions().iter().map(depth).fold(f64::NEG_INFINITY, f64::max);
        assert!(deepest < 0.02 * CELL && (shift.x + 1.3).abs() < 0.1, "{deepest} {shift}");
        let expected = bits(&simulation);
        simulation.restore(&saved).unwrap();
        simulation.steps(64);
        assert_eq!(bits(&simulation), expected);
    }
}

/// A body that leaves a collider falls as soon as that is gone.
#[test]
fn a_body_no_longer_leaves_a_collider_that_is_disabled() {
    let deep =
        Collider { enabled: switch(&[(0.1, false)]), ..Collider::cuboid([0.0; 3], [9.0; 3], [0.0; 3]) };
    let mut simulation = of([cube("a", [-0.5; 3])]).collider(deep).build().unwrap();
    simulation.steps(14);
    assert!(!simulation.collider(0).is_enabled());
    let speed = |simulation: &Simulation| simulation.body(0).linear_momentum().y / simulation.body(0).mass();
    let (before, dt) = (speed(&simulation), simulation.dt());
    simulation.steps(20);
    let gained = speed(&simulation) - before;
    assert!((gained + 9.81 * 20.0 * dt).abs() < 1e-3 * 9.81 * 20.0 * dt, "{gained}");
}

/// The force of a resting body on a collider is its weight.
#[test]
fn the_force_on_a_collider_is_the_opposite_of_those_of_its_contacts() {
    let mut simulation = of([cube("a", [-0.5, 0.0, -0.5]), cube("b", [19.5, 0.0, -0.5])])
        .collider(door(0.0, true))
        .collider(door(20.0, true))
        .build()
        .unwrap();
    simulation.steps(150);
    assert_eq!(["a", "b", "c"].map(|name| simulation.body_index(name)), [Some(0), Some(1), None]);
    for (index, body) in simulation.bodies().iter().enumerate() {
        let [x, y, z] = simulation.collider(index).force();
        let weight = 9.81 * body.mass();
        // To the tolerance with which the contacts of a body at rest are solved.
        assert!((y + weight).abs() < 0.02 * weight && x.hypot(z) < 0.02 * weight, "{x} {y} {z} {weight}");
    }
}
