//! Links: glue and springs between bodies.

use nalgebra::{Point3, Vector3};
use supple::{Body, BodyBuilder, Lattice, Link, Selection, Simulation, SimulationBuilder};
use supple_tests::block;

/// A cube of edge 1 of 3³ cells with its lowest corner at `x`, 0, 0.
fn cube(name: &str, x: f64) -> BodyBuilder {
    let lattice = Lattice::from_cells(&block([3; 3]), 1.0 / 3.0, Point3::origin(), true).unwrap();
    Body::from_lattice(lattice).name(name).youngs_modulus(1e6).translate([x, 0.0, 0.0])
}

/// The face of the cube `a` that touches the cube `b`, or the other face.
fn face(x: f64) -> Selection {
    Selection::Box { min: [x - 0.1, -1.0, -1.0], max: [x + 0.1, 2.0, 2.0] }
}

fn linked(link: Link, gap: f64) -> SimulationBuilder {
    let bodies = [cube("a", 0.0), cube("b", 1.0 + gap)].map(|body| body.build().unwrap());
    let [a, b] = bodies;
    Simulation::builder().body(a).body(b).contact(false).gravity([0.0; 3]).dt(1.0 / 120.0).link(link)
}

fn glue() -> Link {
    Link { other: Some("b".to_owned()), ..Link::new("a", face(1.0)) }
}

fn total(simulation: &Simulation) -> (Vector3<f64>, Vector3<f64>) {
    let bodies = simulation.bodies();
    let momentum = bodies.iter().map(Body::linear_momentum).sum();
    let about = |body: &Body| body.center_of_mass().coords.cross(&body.linear_momentum());
    (momentum, bodies.iter().map(|body| body.angular_momentum() + about(body)).sum())
}

/// Returns the greatest distance between vertices of the faces that touched.
fn opening(simulation: &Simulation) -> f64 {
    let [a, b] = [0, 1].map(|body| simulation.bodies()[body].positions());
    let indices = simulation.bodies()[0].lattice().indices();
    let pairs = indices.iter().enumerate().filter(|(_, index)| index[0] == 3).map(|(vertex, index)| {
        let other = simulation.bodies()[1].lattice().vertex_at([0, index[1], index[2]]).unwrap();
        (a[vertex] - b[other as usize]).norm()
    });
    pairs.fold(0.0, f64::max)
}

#[test]
fn links_keep_momentum_and_angular_momentum() {
    for link in [glue(), Link { stiffness: Some(2e4), ..glue() }] {
        for gap in [0.0, 0.2] {
            let mut simulation = linked(link.clone(), gap).build().unwrap();
            simulation.body_mut(0).apply_impulse([50.0, 20.0, -30.0], &face(0.0)).unwrap();
            simulation.step();
            let before = total(&simulation);
            simulation.steps(240);
            let after = total(&simulation);
            let scale = before.0.norm();
            assert!((after.0 - before.0).norm() < 1e-4 * scale, "{} {}", after.0, before.0);
            assert!(
                (after.1 - before.1).norm() < 2e-3 * before.1.norm().max(scale),
                "{} {}",
                after.1,
                before.1
            );
            let force = simulation.links().next().unwrap().force;
            assert!(force.iter().all(|x| x.is_finite()));
        }
    }
}

/// Two cubes that are glued move as one: the faces stay together, and a push on one moves both.
#[test]
fn glued_faces_stay_together() {
    let mut simulation = linked(glue(), 0.0).build().unwrap();
    let push = supple::Force { duration: supple::ForceDuration::Seconds(0.5), ..[0.0, 0.0, 800.0].into() };
    simulation.body_mut(0).apply_force(push, &face(0.0)).unwrap();
    let mut widest = 0.0_f64;
    for _ in 0..240 {
        simulation.step();
        widest = widest.max(opening(&simulation));
    }
    // A cell is 1/3 long.
    assert!(widest < 0.01, "{widest}");
    let speeds = [0, 1].map(|body| {
        let body = &simulation.bodies()[body];
        (body.linear_momentum() / body.mass()).norm()
    });
    assert!(speeds[1] > 0.05, "{speeds:?}");
}

/// Two free bodies on a spring: the frequency is that of the reduced mass.
#[test]
fn a_spring_has_its_frequency() {
    for dt in [1.0 / 60.0, 1.0 / 480.0] {
        let link = Link { stiffness: Some(3e4), damping_ratio: 0.0, ..glue() };
        let everywhere = Selection::Vertices((0..64).collect());
        let link = Link { selection: everywhere.clone(), ..link };
        let bodies = [cube("a", 0.0), cube("b", 0.0)].map(|body| body.youngs_modulus(1e8).build().unwrap());
        let [a, b] = bodies;
        let builder = Simulation::builder().body(a).body(b).contact(false).gravity([0.0; 3]).dt(dt);
        let mut simulation = builder.link(link).build().unwrap();
        simulation.body_mut(0).apply_impulse([0.0, 100.0, 0.0], &everywhere).unwrap();
        let difference = |simulation: &Simulation| {
            let [a, b] = [0, 1].map(|body| simulation.bodies()[body].center_of_mass());
            a.y - b.y
        };
        let (mut crossings, mut before, mut time) = (Vec::new(), 0.0, 0.0);
        while crossings.len() < 6 {
            simulation.step();
            let now = difference(&simulation);
            if before < 0.0 && now >= 0.0 {
                crossings.push(time + dt * before / (before - now));
            }
            (before, time) = (now, time + dt);
        }
        let found = 5.0 / (crossings[5] - crossings[0]);
        // Cubes of 1,000 kg each: the reduced mass is 500 kg.
        let expected = (3e4_f64 / 500.0).sqrt() / std::f64::consts::TAU;
        assert!((found / expected - 1.0).abs() < 0.03, "{dt}: {found} {expected}");
    }
}

#[test]
fn a_part_that_is_glued_to_the_world_carries_its_body_until_it_breaks() {
    let hang = |limit: Option<f64>| {
        let top = Selection::Box { min: [-1.0, 0.5, -1.0], max: [2.0; 3] };
        let link = Link { break_force: limit, ..Link::new("a", top) };
        let builder = Simulation::builder().body(cube("a", 0.0).damping_ratio(1.0).build().unwrap());
        let mut simulation = builder.dt(1.0 / 240.0).link(link).build().unwrap();
        simulation.steps(480);
        simulation
    };
    let simulation = hang(None);
    let body = &simulation.bodies()[0];
    let weight = 9.81 * body.mass();
    let force = simulation.links().next().unwrap().force;
    assert!((force - Vector3::new(0.0, weight, 0.0)).norm() < 0.01 * weight, "{force} {weight}");
    assert!(body.center_of_mass().y > 0.4);
    let torn = hang(Some(0.5 * weight));
    assert!(torn.links().next().unwrap().is_broken && torn.bodies()[0].center_of_mass().y < -10.0);
    assert_eq!(torn.links().next().unwrap().force, Vector3::zeros());
}

#[test]
fn saved_states_have_the_broken_links() {
    let build = || linked(Link { break_force: Some(40.0), ..glue() }, 0.0).build().unwrap();
    let (mut one, mut other) = (build(), build());
    one.body_mut(0).apply_impulse([-200.0, 0.0, 0.0], &face(0.0)).unwrap();
    one.steps(30);
    assert!(one.links().next().unwrap().is_broken);
    other.restore(&one.state()).unwrap();
    one.steps(20);
    other.steps(20);
    assert!(other.links().next().unwrap().is_broken);
    assert_eq!(one.state(), other.state());
}

#[test]
fn wrong_links_are_errors_with_the_way_out() {
    let error = |link: Link, gap: f64| linked(link, gap).build().unwrap_err().to_string();
    assert!(
        error(Link { other: Some("c".to_owned()), ..glue() }, 0.0).contains(r#"a link names the body "c""#)
    );
    assert!(error(Link { other: Some("a".to_owned()), ..glue() }, 0.0).contains("to itself"));
    assert!(error(Link { stiffness: Some(0.0), ..glue() }, 0.0).contains("stiffness = 0"));
    assert!(error(Link { break_force: Some(-1.0), ..glue() }, 0.0).contains("break = -1"));
    assert!(error(glue(), 1.0).contains("3.0 cells away"));
    assert!(error(Link { selection: face(9.0), ..glue() }, 0.0).contains("selects nothing"));
}

/// A rigid body hangs on glue and on springs at one of its corners: the force carries its weight, and glue gives way by no
/// more than g h², because the whole mass resists it.
#[test]
fn a_rigid_body_hangs_on_glue_and_on_springs() {
    let corner = Selection::Box { min: [-0.1; 3], max: [0.4, 1.1, 0.4] };
    for stiffness in [None, Some(2e5)] {
        let body = Body::from_lattice(
            Lattice::from_cells(&block([3; 3]), 1.0 / 3.0, Point3::origin(), true).unwrap(),
        );
        let body = body.name("a").rigid(true).build().unwrap();
        let link = Link { stiffness, damping_ratio: 0.5, ..Link::new("a", corner.clone()) };
        let vertices = body.select(&corner).unwrap();
        let start = body.positions();
        let mut simulation = Simulation::builder().body(body).dt(1.0 / 240.0).link(link).build().unwrap();
        simulation.steps(2400);
        let body = &simulation.bodies()[0];
        let force = simulation.links().next().unwrap().force;
        let weight = 9.81 * body.mass();
        assert!((force - Vector3::new(0.0, weight, 0.0)).norm() < 0.05 * weight, "{stiffness:?} {force}");
        let positions = body.positions();
        let moved = vertices.iter().map(|&v| (positions[v as usize] - start[v as usize]).norm());
        let most = moved.fold(0.0, f64::max);
        // Ten times the sag of the springs, of which those at one side carry more.
        let bound = stiffness.map_or(0.005, |stiffness| 10.0 * weight / stiffness);
        assert!(most < bound, "{stiffness:?}: {most} {bound}");
    }
}
