//! Acceleration fields.

use nalgebra::{Point3, Vector3};
use supple::{
    Attraction, Body, Collider, Curve, CurveKey, Field, FieldLaw, Material, Selection, Simulation,
    SimulationBuilder, Vortex, Wind,
};
use supple_tests::{block, half_cells, lattice};

fn cube(name: &str) -> Body {
    Body::from_lattice(lattice(&block([2, 2, 2]))).name(name).youngs_modulus(1e6).build().unwrap()
}

fn with_field(field: Field) -> SimulationBuilder {
    Simulation::builder().body(cube("cube")).gravity([0.0; 3]).dt(1.0 / 120.0).field(field)
}

fn velocity(simulation: &Simulation, body: usize) -> Vector3<f64> {
    let body = &simulation.bodies()[body];
    body.linear_momentum() / body.mass()
}

#[test]
fn a_gravity_field_acts_like_gravity() {
    let gravity = [1.0, -9.81, 0.5];
    let mut by_field = with_field(Field::new(FieldLaw::Gravity(gravity))).build().unwrap();
    let mut by_gravity =
        Simulation::builder().body(cube("cube")).gravity(gravity).dt(1.0 / 120.0).build().unwrap();
    for simulation in [&mut by_field, &mut by_gravity] {
        simulation.steps(120);
    }
    let [a, b] = [&by_field, &by_gravity].map(|simulation| simulation.bodies()[0].positions());
    for (a, b) in a.iter().zip(b) {
        assert!((a - b).norm() < 1e-4, "{a} {b}");
    }
}

#[test]
fn drag_lets_a_body_lose_its_speed_by_the_law_and_keeps_its_shape() {
    for dt in [1.0 / 30.0, 1.0 / 240.0] {
        let body = Body::from_lattice(half_cells()).velocity([3.0, 0.0, -1.0]).build().unwrap();
        let field = Field::new(FieldLaw::Drag(0.7));
        let mut simulation =
            Simulation::builder().body(body).gravity([0.0; 3]).dt(dt).field(field).build().unwrap();
        simulation.steps((2.0 / dt).round() as u64);
        let expected = Vector3::new(3.0, 0.0, -1.0) * (-1.4_f64).exp();
        let error = velocity(&simulation, 0) - expected;
        assert!(error.norm() < 1e-5 * expected.norm(), "{error}");
    }
}

#[test]
fn a_body_takes_the_velocity_of_the_wind_and_of_a_vortex() {
    let wind = Wind { velocity: [4.0, 0.0, 1.0], drag: 2.0, ..Wind::default() };
    let mut simulation = with_field(Field::new(FieldLaw::Wind(wind))).build().unwrap();
    simulation.steps(240);
    let expected = Vector3::new(4.0, 0.0, 1.0) * (1.0 - (-4.0_f64).exp());
    assert!((velocity(&simulation, 0) - expected).norm() < 1e-4 * expected.norm());

    // The cube, whose center is on the axis, turns with the air.
    let vortex = Vortex { center: [1.0; 3], radius: 10.0, spin: 1.5, drag: 3.0, ..Vortex::default() };
    let mut simulation = with_field(Field::new(FieldLaw::Vortex(vortex))).build().unwrap();
    simulation.steps(360);
    let body = &simulation.bodies()[0];
    let about_axis: f64 = body
        .positions()
        .iter()
        .zip(body.masses())
        .map(|(p, m)| {
            let arm = p - Point3::new(1.0, p.y, 1.0);
            m * arm.norm_squared()
        })
        .sum();
    let spin = body.angular_momentum() / about_axis;
    assert!((spin - Vector3::new(0.0, 1.5, 0.0)).norm() < 0.01, "{spin}");
}

#[test]
fn an_attraction_has_the_period_of_its_spring() {
    // Within the radius the acceleration is -(acceleration/radius) r: a period of 2 pi sqrt(radius/acceleration).
    let attraction = Attraction { center: [6.0, 1.0, 1.0], acceleration: 8.0, radius: 20.0, power: 0.0 };
    let mut simulation = with_field(Field::new(FieldLaw::Attract(attraction))).build().unwrap();
    let half = std::f64::consts::PI * (20.0_f64 / 8.0).sqrt();
    simulation.steps((half * 120.0).round() as u64);
    let center = simulation.bodies()[0].center_of_mass();
    assert!((center - Point3::new(11.0, 1.0, 1.0)).norm() < 0.02, "{center}");
}

#[test]
fn fields_act_on_their_bodies_in_their_part_of_space_with_their_strength() {
    let second = Body::from_lattice(lattice(&block([2, 2, 2]))).name("other").translate([20.0, 0.0, 0.0]);
    let push = Field { bodies: vec!["other".to_owned()], ..Field::new(FieldLaw::Gravity([0.0, 1.0, 0.0])) };
    let key = |time, value| CurveKey { time, value };
    let keyed = Field {
        strength: Curve::new(vec![key(0.0, 0.0), key(1.0, 2.0)]).unwrap(),
        within: Some(Selection::Sphere { center: [0.0; 3], radius: 10.0 }),
        ..Field::new(FieldLaw::Gravity([0.0, 0.0, 3.0]))
    };
    let mut simulation = with_field(push).field(keyed).body(second.build().unwrap()).build().unwrap();
    simulation.steps(120);
    let [first, second] = [0, 1].map(|body| velocity(&simulation, body));
    // The strength grows from 0 to 2 in a second; steps take its value at their begin.
    assert!((first - Vector3::new(0.0, 0.0, 3.0)).norm() < 0.03, "{first}");
    assert!((second - Vector3::new(0.0, 1.0, 0.0)).norm() < 1e-4, "{second}");
    simulation.set_fields(Vec::new()).unwrap();
    simulation.steps(10);
    assert!((velocity(&simulation, 1) - second).norm() < 1e-5);
}

#[test]
fn a_body_sleeps_in_a_steady_wind_and_wakes_when_it_changes() {
    let wind = Wind { velocity: [0.5, 0.0, 0.0], drag: 0.5, ..Wind::default() };
    let key = |time, value| CurveKey { time, value };
    let strength = Curve::new(vec![key(0.0, 1.0), key(6.0, 1.0), key(6.5, 8.0)]).unwrap();
    let steady = Field::new(FieldLaw::Wind(wind));
    for (field, wakes) in [(steady.clone(), false), (Field { strength, ..steady }, true)] {
        let ground = Collider::plane([0.0; 3], [0.0, 1.0, 0.0]);
        let mut simulation = Simulation::builder().body(cube("cube")).collider(ground).field(field);
        simulation = simulation.fps(30.0).substeps(supple::Substeps::Fixed(8));
        let mut simulation = simulation.build().unwrap();
        simulation.advance(179);
        assert!(simulation.bodies()[0].is_asleep());
        simulation.advance(6);
        assert_eq!(simulation.bodies()[0].is_asleep(), !wakes);
    }
}

#[test]
fn a_saved_state_continues_with_the_same_bits_in_a_gusty_wind() {
    let wind = Wind { velocity: [5.0, 1.0, 0.0], gust: 0.8, turbulence: 0.5, seed: 3, ..Wind::default() };
    let build = || with_field(Field::new(FieldLaw::Wind(wind))).build().unwrap();
    let (mut one, mut other) = (build(), build());
    one.steps(25);
    other.restore(&one.state()).unwrap();
    one.steps(25);
    other.steps(25);
    assert_eq!(one.state(), other.state());
}

#[test]
fn a_broken_body_is_still_in_the_field() {
    let body = Body::from_lattice(lattice(&block([4, 2, 2]))).material(Material::fast_lsm()).build().unwrap();
    let field = Field::new(FieldLaw::Gravity([0.0, 0.0, 2.0]));
    let mut simulation =
        Simulation::builder().body(body).gravity([0.0; 3]).dt(0.01).field(field).build().unwrap();
    simulation.steps(50);
    assert!(simulation.body_mut(0).cut([2.0, 1.0, 1.0], [1.0, 0.0, 0.0]).unwrap() > 0);
    simulation.steps(50);
    assert!((velocity(&simulation, 0) - Vector3::new(0.0, 0.0, 2.0)).norm() < 1e-4);
}

#[test]
fn a_field_of_a_body_that_does_not_exist_is_an_error() {
    let field = Field { bodies: vec!["cub".to_owned()], ..Field::new(FieldLaw::Drag(1.0)) };
    let error = with_field(field).build().unwrap_err().to_string();
    assert!(error.contains(r#"a field names the body "cub""#) && error.contains(r#"["cube"]"#), "{error}");
    let inside = Field { within: Some(Selection::Vertices(vec![0])), ..Field::new(FieldLaw::Drag(1.0)) };
    assert!(with_field(inside).build().unwrap_err().to_string().contains("part of space"));
}
