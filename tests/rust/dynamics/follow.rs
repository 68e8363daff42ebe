//! Handles that follow an animated mesh.

use nalgebra::{Point3, Rotation3, Vector3};
use supple::{
    Body, BodyBuilder, Error, Goal, Handle, HandleMotion, Key, Mesh, MeshAnimation, Preservation, Selection,
    Simulation, SkinKind, StepReason, Substeps, TimeWindow,
};
use supple_io::saved_state::{restore, save};

use supple_tests::{block, half_cells, surface_of};

/// Everything, as a shape.
const ALL: Selection = Selection::Plane { point: [-1e3, 0.0, 0.0], normal: [1.0, 0.0, 0.0] };

/// Returns the mesh of the surface of cells of edge 1, with vertices at their corners.
fn mesh(cells: &[[i32; 3]]) -> Mesh {
    let (vertices, faces) = surface_of(cells);
    Mesh::new(vertices, &faces).unwrap()
}

/// Returns an animation with a sample every `interval` seconds from time 0 on. `place` gives the position of a vertex in a
/// sample.
fn animate(
    mesh: &Mesh,
    samples: usize,
    interval: f64,
    place: impl Fn(usize, Point3<f64>) -> Point3<f64>,
) -> MeshAnimation {
    let positions = (0..samples).flat_map(|sample| {
        let place = &place;
        mesh.vertices().iter().map(move |&vertex| place(sample, vertex).coords.map(|x| x as f32).into())
    });
    MeshAnimation::new(positions.collect(), mesh.vertices().len(), 0.0, interval).unwrap()
}

fn follow(selection: Selection, animation: &MeshAnimation) -> Handle {
    Handle {
        goal: None,
        selection,
        motion: HandleMotion::Follow(animation.clone()),
        window: TimeWindow::default(),
    }
}

fn bar() -> Mesh {
    mesh(&block([12, 3, 3]))
}

fn body(mesh: &Mesh) -> BodyBuilder {
    Body::builder(mesh.clone()).cell_size(1.0).volume(Preservation::Off)
}

/// Returns a simulation in steps of `dt` seconds with gravity.
fn simulate(body: Body, dt: f64) -> Simulation {
    Simulation::builder().body(body).dt(dt).threads(1).build().unwrap()
}

/// Returns a rotation by `degrees` about an oblique axis.
fn turn(degrees: f64) -> Rotation3<f64> {
    Rotation3::from_scaled_axis(Vector3::new(1.0, 2.0, -2.0) / 3.0 * degrees.to_radians())
}

/// Returns the greatest distance between points.
fn worst(a: &[Point3<f64>], b: impl IntoIterator<Item = Point3<f64>>) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
}

#[test]
fn a_rigid_animation_moves_the_held_vertices_rigidly_whatever_they_are() {
    let bar = bar();
    let center = Point3::new(3.0, 1.0, 2.0);
    let rigid = |sample: usize, p: Point3<f64>| {
        center + turn(25.0 * sample as f64) * (p - center) + Vector3::new(0.3, -0.2, 0.1) * sample as f64
    };
    let animation = animate(&bar, 16, 0.1, rigid);
    for (selection, count) in
        [(ALL, 208), (Selection::Vertices((0..208).collect()), 208), (Selection::Vertices(vec![0]), 1)]
    {
        let body =
            body(&bar).scale(2.0).cell_size(2.0).rotate([20.0, 0.0, -50.0]).translate([0.5, -3.0, 0.2]);
        let body = body.handle(follow(selection, &animation)).build().unwrap();
        assert_eq!(body.lattice().len(), 13 * 4 * 4);
        let held = body.constraint(0).unwrap().vertices().to_vec();
        assert_eq!(held.len(), count);
        let model: Vec<_> = held.iter().map(|&vertex| body.lattice().rest_position(vertex)).collect();
        let rest: Vec<_> = held.iter().map(|&vertex| body.positions()[vertex as usize]).collect();
        // The placement, from the model's frame to world space, by three differences of positions.
        let to_world = supple::Placement { rotate: [20.0, 0.0, -50.0], ..supple::Placement::default() };
        let to_world = to_world.rotation();
        let offset = rest[0] - to_world * model[0];
        let mut simulation = simulate(body, 0.1);
        for sample in 1..=15 {
            simulation.step();
            let expected =
                model.iter().map(|p| to_world * (2.0 * rigid(sample, Point3::from(p.coords / 2.0)).coords));
            let expected: Vec<Point3<f64>> = expected.map(|p| Point3::from(p + offset)).collect();
            let positions = simulation.body(0).positions();
            let found: Vec<_> = held.iter().map(|&vertex| positions[vertex as usize]).collect();
            // Coordinates of up to 40 are rounded to f32, and a rotation multiplies their errors at the neighbors, about
            // a cell away, by the distance from their mean, less than a cell.
            let error = worst(&found, expected);
            assert!(error < 40.0 * f64::from(f32::EPSILON), "sample {sample}: {error}");
        }
    }
}

/// Bends a bar of 12 x 3 x 3, at time 1 to a quarter of a circle.
fn bend(time: f64, p: Point3<f64>) -> Point3<f64> {
    let angle = time * 90.0_f64.to_radians() / 12.0;
    let radius = 1.0 / angle.max(1e-9);
    let (sin, cos) = (p.x * angle).sin_cos();
    Point3::new((radius - p.y + 1.5) * sin, radius - (radius - p.y + 1.5) * cos + 1.5, p.z)
}

/// Returns the greatest distance between the displayed surface of a bar that is held everywhere and its animation, in
/// units of its edges, for cells of a size.
fn error_of(cell_size: f64, skin: SkinKind, place: impl Fn(f64, Point3<f64>) -> Point3<f64>) -> f64 {
    let cells = block([24, 6, 6]);
    let (vertices, faces) = surface_of(&cells);
    let bar = Mesh::new(vertices.iter().map(|p| p.map(|x| x / 2.0)).collect(), &faces).unwrap();
    let animation = animate(&bar, 11, 0.1, |sample, p| place(sample as f64 / 10.0, p));
    let body = body(&bar).cell_size(cell_size).skin(skin).handle(follow(ALL, &animation)).build().unwrap();
    let mut simulation = simulate(body, 0.05);
    let mut greatest = 0.0_f64;
    for step in 1..=20 {
        simulation.step();
        let mut expected = Vec::new();
        animation.positions_at_time(f64::from(step) * 0.05, &mut expected);
        greatest = greatest.max(worst(&simulation.body(0).surface().positions, expected));
    }
    greatest
}

#[test]
fn a_body_that_is_held_everywhere_shows_the_animation_to_the_resolution_of_its_lattice() {
    // Twists the bar by 90 degrees.
    let twist = |time: f64, p: Point3<f64>| {
        let (sin, cos) = (time * p.x / 12.0 * 90.0_f64.to_radians()).sin_cos();
        let (y, z) = (p.y - 1.5, p.z - 1.5);
        Point3::new(p.x, 1.5 + cos * y - sin * z, 1.5 + sin * y + cos * z)
    };
    for skin in [SkinKind::Linear, SkinKind::Smooth] {
        for place in [&bend as &dyn Fn(f64, Point3<f64>) -> Point3<f64>, &twist] {
            // The greatest sagitta of an arc across a cell is (7.6 + 1.5) (90°/12)² / 8 = 0.02 of its edge, at the outer
            // side of the bend. In the fine lattice, every mesh vertex is a lattice vertex.
            let (coarse, fine) = (error_of(1.0, skin, place), error_of(0.5, skin, place));
            assert!(coarse < 0.04 && fine < 1e-5, "{skin:?}: {coarse} {fine}");
        }
    }
}

/// The trilinear weights of vertices that scatter about the faces of cells nearly cancel on the far side of the cells.
#[test]
fn faces_that_scatter_about_grid_planes_move_the_lattice_smoothly() {
    for scatter in [1e-8, 1e-6, 1e-4] {
        let (vertices, faces) = surface_of(&block([24, 6, 6]));
        let scattered = (0..).zip(&vertices).map(|(index, p)| {
            let noise =
                |axis: u64| f64::from((((3 * index + axis) * 2_654_435_761) >> 8) as u16) / 32_768.0 - 1.0;
            [0, 1, 2].map(|axis| p[axis] / 2.0 + scatter * noise(axis as u64))
        });
        let bar = Mesh::new(scattered.collect(), &faces).unwrap();
        let animation = animate(&bar, 2, 1.0, |sample, p| bend(sample as f64, p));
        let body = body(&bar).handle(follow(ALL, &animation)).build().unwrap();
        let held = body.constraint(0).unwrap().vertices().to_vec();
        let of_held = |body: &Body| held.iter().map(|&vertex| body.positions()[vertex as usize]).collect();
        let rest: Vec<_> = of_held(&body);
        let mut simulation = simulate(body, 1.0);
        simulation.step();
        // A rigid fit to vertices within 2 cells turns by 15 degrees at most, so that it is off by less than half a cell.
        let found: Vec<_> = of_held(simulation.body(0).get());
        let error = worst(&found, rest.iter().map(|&p| bend(1.0, p)));
        assert!(error < 0.5, "{scatter}: {error}");
    }
}

#[test]
fn legs_that_are_close_together_do_not_follow_each_other() {
    let leg = |x: i32| block([3, 8, 3]).into_iter().map(move |c| [c[0] + x, c[1] - 8, c[2]]);
    let cells: Vec<_> = block([8, 2, 3]).into_iter().chain(leg(0)).chain(leg(5)).collect();
    let legs = mesh(&cells);
    let pose = |sample: usize, p: Point3<f64>| {
        let side = if p.x < 4.0 { 1.0 } else { -1.0 };
        let center = Point3::new(4.0 - side * 2.5, 0.0, 1.5);
        let swing =
            Rotation3::from_axis_angle(&Vector3::x_axis(), side * 10.0_f64.to_radians() * sample as f64);
        center + swing * (p - center)
    };
    let animation = animate(&legs, 4, 0.1, pose);
    let lower = Selection::Box { min: [-1.0, -9.0, -1.0], max: [9.0, -2.0, 4.0] };
    let mut simulation = simulate(body(&legs).handle(follow(lower, &animation)).build().unwrap(), 0.1);
    let held = simulation.body(0).constraint(0).unwrap().vertices().to_vec();
    let rest: Vec<_> =
        held.iter().map(|&vertex| simulation.body(0).lattice().rest_position(vertex)).collect();
    for sample in 1..4 {
        simulation.step();
        let positions = simulation.body(0).positions();
        let found: Vec<_> = held.iter().map(|&vertex| positions[vertex as usize]).collect();
        // The rotation of both legs together is weighted by 1e-4, more where the neighbors are nearly on a line.
        let error = worst(&found, rest.iter().map(|&p| pose(sample, p)));
        assert!(error < 1e-3, "sample {sample}: {error}");
    }
}

#[test]
fn a_handle_follows_from_its_start_to_its_end_and_the_rest_swings() {
    let bar = bar();
    let lift = |sample: usize, p: Point3<f64>| p + Vector3::new(0.0, 0.2 * sample as f64, 0.0);
    let animation = animate(&bar, 11, 0.1, lift);
    let window = TimeWindow { start: 0.3, end: 0.7 };
    let left = Selection::Plane { point: [2.0, 0.0, 0.0], normal: [-1.0, 0.0, 0.0] };
    let handle = Handle { window, ..follow(left, &animation) };
    let mut simulation = simulate(body(&bar).handle(handle).build().unwrap(), 0.05);
    let mut falling = simulate(body(&bar).build().unwrap(), 0.05);
    let height = |simulation: &Simulation, vertex: usize| simulation.body(0).positions()[vertex].y;
    let mut free = Vec::new();
    for step in 1..=20 {
        simulation.step();
        let hold = simulation.body(0).constraint(0).unwrap().clone();
        assert_eq!(hold.is_active(), (7..=14).contains(&step), "{step}");
        let vertex = hold.vertices()[0] as usize;
        let rest = simulation.body(0).lattice().rest_position(vertex as u32).y;
        if hold.is_active() {
            let expected = rest + 2.0 * 0.05 * f64::from(step);
            assert!((height(&simulation, vertex) - expected).abs() < 1e-5);
            assert!((simulation.body(0).velocities()[vertex].y - 2.0).abs() < 1e-4);
        }
        falling.step();
        let last = simulation.body(0).lattice().len() - 1;
        free.push(height(&simulation, last) - height(&falling, last));
    }
    // The last vertex falls freely until the handle begins. In 0.35 s the lifted part has an effect on it.
    assert!(free[..6].iter().all(|difference| difference.abs() < 1e-5), "{free:?}");
    assert!(free[14] > 0.1, "{free:?}");

    // Keyframes are relative to the pose in which the handle gets them.
    simulation.set_time(0.5).unwrap();
    simulation.step();
    let vertex = simulation.body(0).constraint(0).unwrap().vertices()[0] as usize;
    let before = height(&simulation, vertex);
    let key = |time, y| Key { time, translate: [0.0, y, 0.0], rotate: [0.0; 3] };
    simulation.body_mut(0).set_keys(0, &[key(0.55, 0.0), key(0.6, 0.25)], None).unwrap();
    simulation.step();
    assert!((height(&simulation, vertex) - before - 0.25).abs() < 1e-5);
    assert!(simulation.body(0).constraint(0).unwrap().followed().is_none());
}

#[test]
fn parts_without_a_rotation_and_collapsed_or_mirrored_animations_have_finite_targets() {
    let bar = bar();
    let at = |x: f64| Selection::Box { min: [x, -0.1, -0.1], max: [x + 0.1, 0.1, 0.1] };
    let edge = Selection::Box { min: [-0.1; 3], max: [12.1, 0.1, 0.1] };
    let moves: [&dyn Fn(usize, Point3<f64>) -> Point3<f64>; 4] = [
        &|sample, p| p + Vector3::new(sample as f64, 0.0, 0.0),
        &|_, _| Point3::new(3.0, 2.0, 1.0),
        &|sample, p| Point3::new(if sample % 2 == 0 { p.x } else { -p.x }, p.y, p.z),
        &|sample, p| Point3::new(p.x, p.y * (sample % 2) as f64, 0.0),
    ];
    for (index, place) in moves.into_iter().enumerate() {
        let animation = animate(&bar, 6, 0.05, place);
        for selection in [at(0.0), at(5.0), edge.clone(), ALL, Selection::Vertices(vec![3])] {
            let mut simulation =
                simulate(body(&bar).handle(follow(selection, &animation)).build().unwrap(), 0.02);
            simulation.steps(15);
            let body = simulation.body(0);
            assert!(body.positions().iter().all(|p| p.coords.amax() < 1e3), "animation {index}");
            let held = body.constraint(0).unwrap().vertices()[0];
            if index == 0 {
                // No rotation, or one that is not determined, is none.
                let moved = body.positions()[held as usize] - body.lattice().rest_position(held);
                assert!((moved - Vector3::new(5.0, 0.0, 0.0)).norm() < 1e-5, "{moved}");
            }
        }
    }
}

#[test]
fn invalid_animations_of_handles_are_errors_with_the_way_out() {
    let bar = bar();
    let count = bar.vertices().len();
    let other = MeshAnimation::new(vec![[0.0; 3]; 5], 5, 0.0, 1.0).unwrap();
    let error = body(&bar).handle(follow(ALL, &other)).build().unwrap_err().to_string();
    let words =
        format!("it has 5 vertices, and the mesh has {count}; export the animation with the vertices");
    assert!(error.contains(&words), "{error}");
    let far = animate(&bar, 2, 1.0, |_, p| p * 1e30);
    let error = body(&bar).handle(follow(ALL, &far)).build().unwrap_err();
    assert!(matches!(error, Error::Constraint(_)) && error.to_string().contains("too far"), "{error}");
    let animation = animate(&bar, 2, 1.0, |_, p| p);
    let error = Body::from_lattice(half_cells()).handle(follow(ALL, &animation)).build().unwrap_err();
    assert!(error.to_string().contains("without a mesh"), "{error}");
    let nothing = Selection::Sphere { center: [99.0; 3], radius: 1.0 };
    assert!(matches!(body(&bar).handle(follow(nothing, &animation)).build(), Err(Error::Selection(_))));
    assert!(animation.timed(0.0, f64::NAN).is_err());
}

#[test]
fn a_body_is_awake_while_its_animation_moves_and_falls_asleep_afterwards() {
    let bar = bar();
    // Moves for half a second, rests for 1.5 s, and moves again.
    let height = |sample: usize| [0.0, 0.05, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 0.15][sample.min(9)];
    let lift = |sample: usize, p: Point3<f64>| p + Vector3::new(0.0, height(sample), 0.0);
    let animation = animate(&bar, 10, 0.25, lift);
    let held = body(&bar).damping_ratio(1.0).handle(follow(ALL, &animation)).build().unwrap();
    let world = Simulation::builder().body(held).gravity([0.0; 3]).fps(60.0).threads(1);
    let mut simulation = world.build().unwrap();
    let mut asleep = Vec::new();
    for frame in 1..=240 {
        simulation.advance(1);
        if simulation.body(0).is_asleep() {
            asleep.push(frame);
        }
    }
    // A rest of half a second precedes sleep.
    assert!(asleep.iter().all(|frame| (61..=120).contains(frame) || *frame > 165), "{asleep:?}");
    assert!(asleep.contains(&120) && asleep.contains(&240), "{asleep:?}");
}

#[test]
fn following_has_the_same_bits_for_any_number_of_threads_and_after_a_restored_state() {
    let long = mesh(&block([60, 8, 8]));
    let swing = |sample: usize, p: Point3<f64>| {
        let angle = (0.05 * sample as f64 * p.x / 60.0).sin_cos();
        Point3::new(p.x, p.y * angle.1 - p.z * angle.0, p.y * angle.0 + p.z * angle.1)
    };
    let animation = animate(&long, 200, 1.0 / 30.0, swing);
    let upper = Selection::Plane { point: [0.0, 3.0, 0.0], normal: [0.0, 1.0, 0.0] };
    let build = |threads: usize| {
        let body = body(&long).handle(follow(upper.clone(), &animation)).build().unwrap();
        assert!(body.constraint(0).unwrap().vertices().len() > 1200, "more than two tasks of 512 vertices");
        Simulation::builder().body(body).fps(60.0).threads(threads).build().unwrap()
    };
    let mut one = build(1);
    one.advance(20);
    let bytes = save(&one);
    let samples = size_of_val(animation.positions());
    assert!(bytes.len() < samples / 5, "{} {samples}", bytes.len());
    one.advance(10);
    let expected = save(&one);
    let mut three = build(3);
    three.advance(30);
    assert!(save(&three) == expected, "three threads differ from one");
    restore(&mut three, &bytes).unwrap();
    assert!(save(&three) == bytes);
    three.advance(10);
    assert!(save(&three) == expected, "the restored state continues with other bits");

    // A handle that was released needs no animation, also in a state from before the next step.
    three.body_mut(0).release(0).unwrap();
    let released = save(&three);
    three.step();
    restore(&mut three, &released).unwrap();
    three.body_mut(0).handle(&follow(upper.clone(), &animation)).unwrap();
    restore(&mut three, &bytes).unwrap();

    // A state does not contain the animation.
    three.body_mut(0).release(0).unwrap();
    three.step();
    let error = restore(&mut three, &bytes).unwrap_err().to_string();
    assert!(error.contains("handle 0 of the state follows an animation"), "{error}");
    three.body_mut(0).handle(&follow(upper.clone(), &animation)).unwrap();
    restore(&mut three, &bytes).unwrap();
    three.advance(10);
    assert!(save(&three) == expected);
    let other = animate(&long, 200, 1.0 / 30.0, |sample, p| swing(sample + 1, p));
    three.body_mut(0).release(0).unwrap();
    three.body_mut(0).handle(&follow(upper.clone(), &other)).unwrap();
    three.step();
    assert!(restore(&mut three, &bytes).is_err(), "another animation");
}

#[test]
fn a_held_body_at_rest_is_carried_and_a_fast_animation_needs_more_steps() {
    let bar = bar();
    let rest = animate(&bar, 1, 1.0, |_, p| p);
    let mut simulation = simulate(body(&bar).handle(follow(ALL, &rest)).build().unwrap(), 0.01);
    simulation.steps(3);
    let (body_at_rest, weight) = (simulation.body(0), simulation.body(0).mass() * 9.81);
    let held: f64 = {
        let masses = body_at_rest.masses();
        body_at_rest.constraint(0).unwrap().vertices().iter().map(|&v| masses[v as usize]).sum()
    };
    let force = body_at_rest.hold_force(0).unwrap().unwrap().force;
    // The vertices inside, which are not held, have fallen for three steps and hang on the others.
    assert!(force.y > 9.8 * held && force.y < 3.0 * weight, "{force} {weight}");

    let steps = |speed: f64| {
        let fast = animate(&bar, 2, 1.0, |sample, p| p + Vector3::new(0.0, 0.0, speed * sample as f64));
        let body = body(&bar).handle(follow(ALL, &fast)).build().unwrap();
        let world = Simulation::builder().body(body).fps(30.0).substeps(Substeps::Auto).gravity([0.0; 3]);
        world.threads(1).build().unwrap().chosen_substeps().unwrap()
    };
    // At most a cell in a step.
    let chosen = steps(30.0 * 40.0);
    assert!(chosen.steps >= 40 && chosen.reason == StepReason::Motion, "{chosen:?}");
    assert!(steps(1.0).steps < 40);
}

/// A body that follows an accelerated animation with a weight swings behind it: by (a/ω²)(1 - cos ωt) for the acceleration a
/// of the animation, which is 2 a/ω² after half a period and 0 after a whole one.
#[test]
fn a_weight_mixes_an_animation_with_swinging() {
    let (mesh, rate, acceleration) = (mesh(&block([3; 3])), 240.0, 20.0);
    let place = |sample: usize| 0.5 * acceleration * (sample as f64 / rate).powi(2);
    let animation =
        animate(&mesh, 100, 1.0 / rate, |sample, point| point + Vector3::new(place(sample), 0.0, 0.0));
    // 2 Hz x √(0.8/0.2) = 4 Hz: 60 steps in a period.
    let goal = Some(Goal { weight: 0.8.into(), frequency: 2.0, damping_ratio: 0.0 });
    let body = body(&mesh).damping_ratio(0.0).handle(Handle { goal, ..follow(ALL, &animation) });
    let builder = Simulation::builder().body(body.build().unwrap()).gravity([0.0; 3]).dt(1.0 / rate);
    let mut simulation = builder.build().unwrap();
    let start = simulation.body(0).center_of_mass().x;
    let greatest = 2.0 * acceleration / (std::f64::consts::TAU * 4.0).powi(2);
    for (steps, expected) in [(15, 0.5 * greatest), (30, greatest), (45, 0.5 * greatest), (60, 0.0)] {
        simulation.steps(steps - simulation.step_count());
        let lag = place(steps as usize) - (simulation.body(0).center_of_mass().x - start);
        assert!((lag - expected).abs() < 0.03 * greatest, "{steps}: {lag} {expected}");
    }
}
