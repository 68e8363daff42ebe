//! Colliders in GLB files: the nodes have the shapes and the places of the scene.

use std::fs;
use std::path::Path;

use nalgebra::{Rotation3, Vector3};
use supple_io::model;
use supple_io::obj::Document;
use supple_io::run::{Job, Outcome};
use supple_io::scene::Scene;

use crate::glb::{File, Played};
use crate::run_files::{BLOCK, StopAfter};

const SCENE: &str = r#"
[simulation]
frames = 12
fps = 12
substeps = 4

[output]
format = ["glb", "obj"]

[[body]]
name = "block"
mesh = "block.obj"
translate = [0, 3, 0]

[[collider]]
plane = { point = [0, -1, 0], normal = [0, 1, 1] }

[[collider]]
sphere = { center = [4, 0, 0], radius = 0.5 }
keys = [{ time = 0 }, { time = 1, translate = [0, 0, 2] }]

[[collider]]
box = { center = [-4, 0, 0], half_extents = [1, 0.5, 0.25], rotate = [0, 0, 30] }
keys = [{ time = 0 }, { time = 1, rotate = [0, 90, 0] }]

[[collider]]
capsule = { a = [0, 0, 5], b = [2, 0, 5], radius = 0.5 }

[[collider]]
mesh = "block.obj"
scale = 2
translate = [9, 0, 0]
"#;

fn job(folder: &Path, overrides: &[&str]) -> Job {
    fs::write(folder.join("block.obj"), BLOCK).unwrap();
    let overrides: Vec<String> = overrides.iter().map(ToString::to_string).collect();
    Job::new(Scene::parse(SCENE, "scene.toml", folder, &overrides).unwrap(), folder.join("out"))
}

/// Coordinates and sines have 24 bits; lengths are below 16.
const ROUNDING: f64 = 1e-5;

/// Checks the points of a collider in each frame by their distance from its surface.
fn check(played: &Played, distance: impl Fn(usize, Vector3<f64>) -> f64) {
    assert_eq!(played.frames.len(), 13);
    for (frame, points) in played.frames.iter().enumerate() {
        for point in points {
            let distance = distance(frame, *point);
            assert!(distance.abs() < ROUNDING, "frame {frame}: {point} is {distance} from the surface");
        }
    }
}

#[test]
fn colliders_are_nodes_with_their_shapes_and_motions() {
    let folder = tempfile::tempdir().unwrap();
    let job = job(folder.path(), &[]);
    job.run(&mut ()).unwrap();
    let file = File::read(&job.directory.join("supple.glb"));
    let group = file.gltf.nodes().find(|node| node.name() == Some("supple colliders")).unwrap();
    let children: Vec<String> = group.children().map(|node| node.name().unwrap().to_owned()).collect();
    assert_eq!(children, ["plane 0", "sphere 1", "box 2", "capsule 3", "mesh 4"]);
    let scene = file.gltf.scenes().next().unwrap();
    let roots: Vec<String> = scene.nodes().map(|node| node.name().unwrap().to_owned()).collect();
    assert_eq!(roots, ["block", "supple colliders"]);

    // A square on which the whole motion is.
    let plane = file.play("plane 0");
    let normal = Vector3::new(0.0, 1.0, 1.0).normalize();
    check(&plane, |_, point| normal.dot(&(point - Vector3::new(0.0, -1.0, 0.0))));
    assert!(plane.normals[0].iter().all(|found| (found - normal).norm() < ROUNDING));
    let corners = &plane.frames[0];
    assert_eq!(corners.len(), 4);
    let middle = corners.iter().sum::<Vector3<f64>>() / 4.0;
    let half = corners.iter().map(|corner| (corner - middle).norm()).fold(0.0, f64::max) / 2_f64.sqrt();
    for point in file.play("block").frames.iter().flatten() {
        let shift = point - middle;
        assert!((shift - normal * normal.dot(&shift)).norm() <= half);
    }

    let sphere = file.play("sphere 1");
    let center = |frame: usize| Vector3::new(4.0, 0.0, 2.0 * frame as f64 / 12.0);
    check(&sphere, |frame, point| (point - center(frame)).norm() - 0.5);
    for (points, normals) in sphere.frames.iter().zip(&sphere.normals) {
        let is_outwards = |(frame, (point, normal)): (usize, (&Vector3<f64>, &Vector3<f64>))| {
            // Normals of the triangles of a sphere of 32 x 16 parts.
            (point - center(frame)).normalize().dot(normal) > 0.99
        };
        let frame = sphere.frames.iter().position(|found| found == points).unwrap();
        assert!(points.iter().zip(normals).all(|pair| is_outwards((frame, pair))));
    }

    check(&file.play("box 2"), |frame, point| {
        let turn = Rotation3::from_euler_angles(0.0, (90.0 * frame as f64 / 12.0).to_radians(), 0.0);
        let placed = turn * Rotation3::from_euler_angles(0.0, 0.0, 30_f64.to_radians());
        let local = placed.inverse() * (point - Vector3::new(-4.0, 0.0, 0.0));
        (local.abs() - Vector3::new(1.0, 0.5, 0.25)).abs().max()
    });
    check(&file.play("capsule 3"), |_, point| {
        let on_axis = Vector3::new(point.x.clamp(0.0, 2.0), 0.0, 5.0);
        (point - on_axis).norm() - 0.5
    });
    let block = Document::read(folder.path().join("block.obj")).unwrap().part(None).unwrap().into_mesh();
    let expected: Vec<Vector3<f64>> =
        block.vertices().iter().map(|vertex| 2.0 * vertex.coords + Vector3::new(9.0, 0.0, 0.0)).collect();
    check(&file.play("mesh 4"), |_, point| {
        expected.iter().map(|vertex| (vertex - point).norm()).fold(f64::INFINITY, f64::min)
    });
}

#[test]
fn colliders_follow_the_axes_and_units_of_the_file_and_are_no_part_of_a_model() {
    let folder = tempfile::tempdir().unwrap();
    let overrides = ["simulation.gravity=[0, 0, -9.81]", "output.scale=2", "output.meters_per_unit=0.5"];
    let mut job = job(folder.path(), &overrides);
    assert_eq!(job.run(&mut StopAfter(5)).unwrap().outcome, Outcome::Stopped);
    job.resume = true.into();
    job.run(&mut ()).unwrap();
    let file = File::read(&job.directory.join("supple.glb"));
    // z is up in the scene, y in the file; the factors cancel each other.
    let center = |frame: usize| Vector3::new(4.0, 2.0 * frame as f64 / 12.0, 0.0);
    check(&file.play("sphere 1"), |frame, point| (point - center(frame)).norm() - 0.5);

    let again = model::read(job.directory.join("supple.glb"), None).unwrap();
    let block = model::read(folder.path().join("block.obj"), None).unwrap();
    assert_eq!(again.vertices().len(), block.vertices().len());
}

#[test]
fn an_animated_mesh_moves_as_its_file() {
    let folder = tempfile::tempdir().unwrap();
    // The block is recorded while it falls, and then is a collider.
    let mut first = job(folder.path(), &["output.format=pc2"]);
    first.directory = folder.path().to_owned();
    first.run(&mut ()).unwrap();
    let text = SCENE.replace("translate = [9, 0, 0]", "translate = [9, 0, 0]\nanimation = \"block.pc2\"");
    let scene = Scene::parse(&text, "scene.toml", folder.path(), &[]).unwrap();
    let moved = Job::new(scene, folder.path().join("moved"));
    moved.run(&mut ()).unwrap();
    let file = File::read(&moved.directory.join("supple.glb"));
    let played = file.play("mesh 4");
    let recorded = supple_io::frames::read_pc2(folder.path().join("block.pc2")).unwrap();
    let size = 2.0 * 3.0;
    for (frame, points) in played.frames.iter().enumerate() {
        for point in points {
            let of_frame = &recorded.positions[frame * recorded.points..][..recorded.points];
            let nearest = of_frame.iter().map(|vertex| {
                (2.0 * Vector3::from(vertex.map(f64::from)) + Vector3::new(9.0, 0.0, 0.0) - point).norm()
            });
            let distance = nearest.fold(f64::INFINITY, f64::min);
            // The error that is asked by default.
            assert!(distance <= 1e-3 * size + ROUNDING, "frame {frame}: {distance}");
        }
    }
}
