//! Bodies of flesh and jelly that are pressed, pulled and dropped hard, as they are displayed.

use nalgebra::{Point3, Vector3};
use supple::{
    Body, BodyBuilder, Collider, Display, Handle, Interpolation, Key, Mesh, Pin, Preset, Selection,
    Simulation, Substeps, TimeWindow, VolumeOptions,
};
use supple_tests::{mesh_of, sphere};

/// Returns an ellipsoid about the origin.
fn ellipsoid(radii: [f64; 3]) -> Mesh {
    mesh_of(sphere([0.0; 3], 1.0, 24)).scaled(radii).unwrap()
}

fn key(time: f64, translate: [f64; 3]) -> Key {
    Key { time, translate, rotate: [0.0; 3] }
}

fn of_flesh(mesh: Mesh, vertices: usize) -> BodyBuilder {
    Body::builder(mesh).lattice_vertices(vertices).preset(Preset::Flesh)
}

/// Returns the positions of the lattice and those of the surface in each of some frames.
fn frames(simulation: &mut Simulation, count: usize) -> [Vec<Vec<Point3<f64>>>; 2] {
    let mut display = Display::new();
    let mut frames = [Vec::new(), Vec::new()];
    for _ in 0..count {
        simulation.advance(1);
        frames[0].push(simulation.body(0).positions());
        frames[1].push(display.evaluate(simulation.body(0)).surface().positions);
    }
    frames
}

/// Returns the greatest distance of a point from the mean of its places in the frames before and after.
fn flicker(frames: &[Vec<Point3<f64>>]) -> f64 {
    let of_three = |frames: &[Vec<Point3<f64>>]| {
        let difference = |k: usize| (frames[0][k].coords + frames[2][k].coords) / 2.0 - frames[1][k].coords;
        (0..frames[0].len()).map(|k| difference(k).norm()).fold(0.0, f64::max)
    };
    frames.windows(3).map(of_three).fold(0.0, f64::max)
}

/// A ball of flesh between plates at 0.6 of its height: the surface lies on both within 0.1 cells, the greatest gap of samples
/// between lattice vertices at the rim of a contact, and held still it is shown still.
#[test]
fn a_pressed_ball_lies_on_its_plates_and_is_shown_still() {
    let body = of_flesh(mesh_of(sphere([0.0; 3], 1.0, 40)), 1500).translate([0.0, 1.01, 0.0]);
    let plate = Collider {
        keys: vec![key(0.2, [0.0; 3]), key(1.2, [0.0, -0.82, 0.0])],
        interpolation: Interpolation::Smooth,
        ..Collider::cuboid([0.0, 2.12, 0.0], [2.0, 0.1, 2.0], [0.0; 3])
    };
    let simulation = Simulation::builder().body(body.build().unwrap()).fps(30.0).substeps(Substeps::Auto);
    let simulation = simulation.collider(Collider::plane([0.0; 3], [0.0, 1.0, 0.0])).collider(plate);
    let mut simulation = simulation.build().unwrap();
    let [lattice, surface] = frames(&mut simulation, 60);
    let cell = simulation.body(0).lattice().cell_size();
    let end = &surface[59];
    for gap in [|p: &Point3<f64>| p.y, |p: &Point3<f64>| 1.2 - p.y] {
        let radius = |p: &Point3<f64>| p.x.hypot(p.z);
        let rim = end.iter().filter(|p| gap(p) < 0.1 * cell).map(radius).fold(0.0, f64::max);
        assert!(rim > 0.7, "the radius of the contact is {rim}");
        let inside = end.iter().filter(|p| gap(p) < 0.5 && radius(p) < 0.8 * rim);
        let greatest = inside.map(gap).fold(0.0, f64::max);
        assert!(greatest < 0.1 * cell, "a gap of {} cells", greatest / cell);
    }
    let [of_lattice, of_surface] = [&lattice[40..], &surface[40..]].map(flicker);
    let size = 2.0 * 3.0_f64.sqrt();
    assert!(of_surface <= 3.0 * of_lattice + 1e-6 * size, "{of_surface} for {of_lattice}");
    assert!(of_surface <= 2.0 * 5e-4 * size, "{of_surface}");
}

/// An ellipsoid of flesh that is held at one end, pulled at the other, and let go: the volume correction adds no ring where it is
/// held, and no vertex jumps.
#[test]
fn a_pulled_body_has_no_ring_where_it_is_held_and_does_not_pop() {
    let run = |volume: VolumeOptions| {
        let held = |z: f64| Selection::Plane { point: [0.0, 0.0, z], normal: [0.0, 0.0, z.signum()] };
        let keys = vec![key(0.2, [0.0; 3]), key(1.4, [0.0, 0.0, -2.0])];
        let handle = Handle {
            goal: None,
            selection: held(-1.3),
            motion: keys.into(),
            window: TimeWindow { end: 1.8, ..TimeWindow::default() },
        };
        let body = of_flesh(ellipsoid([0.6, 0.9, 2.0]), 1000).volume(volume).handle(handle);
        let body = body
            .pin(Pin { goal: None, selection: held(0.6), window: TimeWindow::default() })
            .build()
            .unwrap();
        let simulation = Simulation::builder().body(body).gravity([0.0; 3]).fps(30.0);
        let mut simulation = simulation.substeps(Substeps::Auto).build().unwrap();
        (frames(&mut simulation, 75), simulation)
    };
    let ([lattice, corrected], simulation) = run(VolumeOptions::default());
    let ([same, plain], _) = run(VolumeOptions::off());
    assert!(lattice == same);

    let mesh = simulation.body(0).mesh().unwrap();
    let mut neighbors = vec![Vec::new(); mesh.vertices().len()];
    for &[a, b, c] in mesh.triangles() {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            neighbors[from as usize].push(to as usize);
        }
    }
    // The greatest second difference along the surface of the displacements, near what is held.
    let second_difference = |points: &[Point3<f64>]| {
        let moved = |k: usize| points[k] - mesh.vertices()[k];
        let is_near = |k: &usize| [-1.3, 0.6].iter().any(|at| (mesh.vertices()[*k].z - at).abs() < 0.3);
        let of_vertex = |k: usize| {
            let sum: Vector3<f64> = neighbors[k].iter().map(|&other| moved(other) - moved(k)).sum();
            sum.norm() / neighbors[k].len() as f64
        };
        (0..points.len()).filter(is_near).map(of_vertex).fold(0.0, f64::max)
    };
    for frame in [20, 30, 41, 53] {
        let [with, without] = [&corrected[frame], &plain[frame]].map(|points| second_difference(points));
        assert!(with <= 1.5 * without, "frame {frame}: {with} for {without}");
    }
    let motion = |frames: &[Vec<Point3<f64>>], k: usize| {
        frames[k].iter().zip(&frames[k - 1]).map(|(now, before)| (now - before).norm()).fold(0.0, f64::max)
    };
    for frame in 10..75 {
        let [of_surface, of_lattice] = [&corrected, &lattice].map(|frames| motion(frames, frame));
        assert!(of_surface <= 1.3 * of_lattice + 1e-3, "frame {frame}: {of_surface} for {of_lattice}");
    }
}

/// A ball of jelly that is dropped from twice its height has its volume in each frame.
#[test]
fn a_ball_of_jelly_keeps_its_volume_when_it_hits_the_ground() {
    let body = Body::builder(mesh_of(sphere([0.0; 3], 1.0, 20))).lattice_vertices(1000).preset(Preset::Jelly);
    let body = body.translate([0.0, 5.0, 0.0]).build().unwrap();
    let simulation = Simulation::builder().body(body).collider(Collider::plane([0.0; 3], [0.0, 1.0, 0.0]));
    let mut simulation = simulation.fps(30.0).substeps(Substeps::Auto).build().unwrap();
    let mut display = Display::new();
    let mut least_before = 1.0_f64;
    for frame in 0..90 {
        simulation.advance(1);
        let report = display.evaluate(simulation.body(0)).volume_report();
        assert!((report.after / report.rest - 1.0).abs() < 1e-6, "frame {frame}: {}", report.residual);
        least_before = least_before.min(report.before / report.rest);
    }
    // The motion itself keeps most of it.
    assert!((0.9..0.99).contains(&least_before), "{least_before}");
}
