//! Colliders that are enabled and disabled: no file shows them in the frames in which they are disabled.

use std::fs;
use std::path::Path;
use std::sync::{Arc, Mutex};

use nalgebra::Vector3;
use supple::Simulation;
use supple_io::run::{Flow, Input, Job, Observer, Outcome, Progress};
use supple_io::scene::Scene;

use crate::film::Film;
use crate::glb::File;
use crate::page_reader::runs;
use crate::run_files::{StopAfter, written};

/// A wedge that rests without gravity, a ball that moves, and a sheet that rises by 1 in each frame.
const SCENE: &str = r#"
[simulation]
frames = 6
fps = 10
substeps = 4
gravity = [0, 0, 0]

[output]
format = ["glb", "html", "film"]
film_size = [200, 150]

[[body]]
name = "wedge"
mesh = "wedge.obj"
lattice_vertices = 100

[[collider]]
sphere = { center = [9, 0, 0], radius = 0.5 }
keys = [{ time = 0 }, { time = 0.6, translate = [0, 0, 6], rotate = [0, 90, 0] }]

[[collider]]
mesh = "sheet.obj"
animation = "sheet.pc2"
"#;

/// A tetrahedron in one corner of its bounds.
const WEDGE: &str = "v 0 0 0\nv 4 0 0\nv 0 4 0\nv 0 0 4\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

/// The keyframes of frames 2 and 4.
const OUT_AND_IN: &str = "enabled=[{ time = 0.2, value = false }, { time = 0.4, value = true }]";

/// Whether the collider is enabled along them.
const SHOWN: [bool; 7] = [true, true, false, false, true, true, true];

fn job(folder: &Path, out: &str, overrides: &[&str]) -> Job {
    fs::write(folder.join("wedge.obj"), WEDGE).unwrap();
    fs::write(folder.join("sheet.obj"), "v -1 0 -1\nv 1 0 -1\nv 0 0 1\nf 1 2 3\n").unwrap();
    let mut bytes = b"POINTCACHE2\0".to_vec();
    bytes.extend([1_i32, 3].iter().flat_map(|word| word.to_le_bytes()));
    bytes.extend([0.0_f32, 1.0].iter().flat_map(|word| word.to_le_bytes()));
    bytes.extend(7_i32.to_le_bytes());
    for height in 0..7 {
        let points = [[-1.0, -1.0], [1.0, -1.0], [0.0, 1.0]].map(|[x, z]| [x, height as f32 - 20.0, z]);
        bytes.extend(points.as_flattened().iter().flat_map(|number: &f32| number.to_le_bytes()));
    }
    fs::write(folder.join("sheet.pc2"), bytes).unwrap();
    let overrides: Vec<String> = overrides.iter().map(ToString::to_string).collect();
    let mut job = Job::new(Scene::parse(SCENE, "scene.toml", folder, &overrides).unwrap(), folder.join(out));
    // The name of the run is in the files.
    job.scene_file = Some(folder.join("scene.toml"));
    job
}

#[test]
fn nodes_of_disabled_colliders_have_the_scale_zero_in_glb_files() {
    let folder = tempfile::tempdir().unwrap();
    let both = [0, 1].map(|index| format!("collider.{index}.{OUT_AND_IN}"));
    let job = job(folder.path(), "out", &["output.format=glb", &both[0], &both[1]]);
    job.run(&mut ()).unwrap();
    let file = File::read(&job.directory.join("supple.glb"));
    let (ball, sheet) = (file.play("sphere 0"), file.play("mesh 1"));
    assert_eq!((&ball.is_shown[..], &sheet.is_shown[..]), (&SHOWN[..], &SHOWN[..]));
    assert!(file.play("wedge").is_shown.iter().all(|&is_shown| is_shown));
    for frame in 0..7 {
        // While it is disabled, a collider stays where it was.
        let posed = if SHOWN[frame] { frame } else { 1 } as f64;
        let center = Vector3::new(9.0, 0.0, posed);
        // Coordinates of 32 bits, below 16.
        assert!(ball.frames[frame].iter().all(|point| ((point - center).norm() - 0.5).abs() < 1e-5));
        // The error that is asked by default, of a size of 2.
        assert!(sheet.frames[frame].iter().all(|point| (point.y - posed + 20.0).abs() < 2e-3 + 1e-5));
        assert!(sheet.normals[frame].iter().all(|normal| (normal.y.abs() - 1.0).abs() < 1e-5));
    }
}

#[test]
fn glb_files_leave_out_colliders_that_are_never_enabled() {
    let folder = tempfile::tempdir().unwrap();
    let colliders = |out: &str, overrides: &[&str]| {
        let job = job(folder.path(), out, &[&["output.format=glb"], overrides].concat());
        job.run(&mut ()).unwrap();
        let file = File::read(&job.directory.join("supple.glb"));
        let names = file.gltf.nodes().map(|node| node.name().unwrap().to_owned());
        (names.collect::<Vec<_>>(), job.directory.join("supple.glb"))
    };
    let ball = ["wedge", "sphere 0", "supple colliders"];
    assert_eq!(colliders("one", &["collider.1.enabled=false"]).0, ball);
    let (names, path) = colliders("none", &["collider.0.enabled=false", "collider.1.enabled=false"]);
    assert_eq!(names, ["wedge"]);
    // A collider that is disabled at first is hidden by a viewer that plays no animation too.
    let late = "collider.0.enabled=[{ time = 0.3, value = true }]";
    let (names, path_of_late) = colliders("late", &[late, "collider.1.enabled=false"]);
    assert_eq!(names, ball);
    let played = File::read(&path_of_late).play("sphere 0");
    assert_eq!(played.is_shown, [false, false, false, true, true, true, true]);
    assert!(
        played.frames[0]
            .iter()
            .all(|point| ((point - Vector3::new(9.0, 0.0, 3.0)).norm() - 0.5).abs() < 1e-5)
    );
    assert_eq!(File::read(&path).play("wedge").frames.len(), 7);
}

#[test]
fn poses_of_disabled_colliders_are_nan_in_pages_and_films_do_not_show_them() {
    let folder = tempfile::tempdir().unwrap();
    // Within the bounds of the wedge, so that the camera is the same without it, and 2.4 away from the wedge.
    let near = "collider.0.sphere={ center = [3, 3, 3], radius = 0.5 }";
    let rest = ["collider.0.keys=[{ time = 0 }]", "collider.1.enabled=false", near];
    let run = |out: &str, enabled: &str| {
        let job = job(folder.path(), out, &[&rest[..], &[enabled]].concat());
        job.run(&mut ()).unwrap();
        let page = fs::read_to_string(job.directory.join("supple.html")).unwrap();
        (runs(&page).remove(0), Film::read(&job.directory.join("supple.webp")))
    };
    let (always, never) =
        (run("always", "collider.0.enabled=true"), run("never", "collider.0.enabled=false"));
    let switched = run("switched", &format!("collider.0.{OUT_AND_IN}"));
    let is_near = |a: &[u8], b: &[u8]| a.iter().zip(b).all(|(a, b)| a.abs_diff(*b) <= 1);
    for (frame, is_shown) in SHOWN.into_iter().enumerate() {
        assert_eq!(switched.0.poses[frame][0].map(f64::is_nan), [!is_shown; 6]);
        let expected = if is_shown { &always } else { &never };
        // Changes by 1 of 255 are left out of films.
        let pictures = [expected, &switched].map(|(_, film)| &film.pictures[frame].0);
        assert!(is_near(pictures[0], pictures[1]), "frame {frame}");
    }
    assert!(!is_near(&always.1.pictures[0].0, &never.1.pictures[0].0));
    assert!(always.0.poses.iter().flatten().all(|pose| pose[0].is_nan() || *pose == [0.0; 6]));
}

/// Disables the first collider after a frame.
struct DisableAfter(u32, Option<Arc<Mutex<Simulation>>>);

impl Observer for DisableAfter {
    fn built(&mut self, simulation: &Arc<Mutex<Simulation>>, _: &[Input]) {
        self.1 = Some(simulation.clone());
    }

    fn frame(&mut self, progress: &Progress) -> Flow {
        if progress.frame == self.0 {
            self.1.as_ref().unwrap().lock().unwrap().collider_mut(0).set_enabled(false);
        }
        Flow::Continue
    }
}

#[test]
fn files_follow_a_program_that_disables_a_collider_and_runs_that_are_stopped() {
    let folder = tempfile::tempdir().unwrap();
    let formats = "output.format=[\"glb\", \"html\"]";
    let by_program = job(folder.path(), "program", &[formats]);
    by_program.run(&mut DisableAfter(3, None)).unwrap();
    let shown = [true, true, true, true, false, false, false];
    assert_eq!(File::read(&by_program.directory.join("supple.glb")).play("sphere 0").is_shown, shown);
    let page = fs::read_to_string(by_program.directory.join("supple.html")).unwrap();
    let is_nan: Vec<bool> = runs(&page)[0].poses.iter().map(|poses| poses[0][0].is_nan()).collect();
    assert_eq!(is_nan, shown.map(|is_shown| !is_shown));

    let formats = "output.format=[\"glb\", \"html\", \"usd\"]";
    let both = [0, 1].map(|index| format!("collider.{index}.{OUT_AND_IN}"));
    let whole = job(folder.path(), "whole", &[formats, &both[0], &both[1]]);
    whole.run(&mut ()).unwrap();
    let mut stopped = job(folder.path(), "stopped", &[formats, &both[0], &both[1]]);
    assert_eq!(stopped.run(&mut StopAfter(3)).unwrap().outcome, Outcome::Stopped);
    stopped.resume = true.into();
    stopped.verify = true;
    stopped.run(&mut ()).unwrap();
    assert!(written(&stopped.directory) == written(&whole.directory));
}
