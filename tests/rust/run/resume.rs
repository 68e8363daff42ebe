//! Jobs: observers, stopping and resuming, checkpoints, errors, automatic substeps.

use std::path::Path;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use supple::{RegionSize, Resolution, Selection, Simulation, StepReason, VolumeMeasure};
use supple_io::run::{
    CHECKPOINT, Flow, Input, Job, LOCK, Note, Observer, Outcome, Progress, Resume, RunError, prepare,
};
use supple_io::scene::{Scene, Substeps};

use crate::cube;

const SCENE: &str = r#"
[simulation]
frames = 10

[[body]]
name = "cube"
mesh = "cube.obj"
translate = [0, 0.5, 0]
lattice_vertices = 64

[[collider]]
plane = { point = [0, 0, 0], normal = [0, 1, 0] }
"#;

fn scene(folder: &Path, overrides: &[&str]) -> Scene {
    cube::scene(SCENE, folder, overrides)
}

/// Records the calls that it receives, and stops the job after the frame `stop_after`.
#[derive(Default)]
struct Recorder {
    span: Option<(u32, u32)>,
    frames: Vec<u32>,
    times: Vec<f64>,
    notes: Vec<Note>,
    stop_after: Option<u32>,
}

impl Observer for Recorder {
    fn started(&mut self, first: u32, last: u32) {
        self.span = Some((first, last));
    }

    fn frame(&mut self, progress: &Progress) -> Flow {
        self.frames.push(progress.frame);
        self.times.push(progress.time);
        if self.stop_after == Some(progress.frame) { Flow::Stop } else { Flow::Continue }
    }

    fn note(&mut self, note: &Note) {
        self.notes.push(note.clone());
    }
}

#[test]
fn an_observer_is_called_for_every_frame_and_a_job_that_it_stops_can_resume() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scene(folder.path(), &[]);
    let mut job = Job::new(scene, folder.path().join("out"));
    let mut recorder = Recorder { stop_after: Some(4), ..Recorder::default() };
    let report = job.run(&mut recorder).unwrap();
    assert_eq!((report.outcome, report.last, report.written), (Outcome::Stopped, 4, 5));
    assert_eq!((recorder.span, recorder.frames), (Some((0, 10)), vec![0, 1, 2, 3, 4]));
    assert!(job.directory.join(CHECKPOINT).is_file() && !job.directory.join(LOCK).exists());

    job.resume = true.into();
    let mut recorder = Recorder::default();
    let report = job.run(&mut recorder).unwrap();
    assert_eq!((report.outcome, report.resumed_after, report.written), (Outcome::Finished, Some(4), 6));
    assert_eq!((recorder.span, recorder.frames), (Some((5, 10)), (5..=10).collect()));
    assert_eq!(recorder.notes, [Note::Resumed { frame: 4 }]);
    // The time is frame / fps, not an accumulated sum.
    for (frame, time) in (5..=10).zip(&recorder.times) {
        assert!((time - f64::from(frame) / 30.0).abs() < 1e-14);
    }
    let body = &report.bodies[0];
    assert!((body.volume.after / body.volume.rest - 1.0).abs() < 1e-6, "{body:?}");

    let report = job.run(&mut Recorder::default()).unwrap();
    assert_eq!((report.outcome, report.written), (Outcome::AlreadyFinished, 0));
}

#[test]
fn a_job_that_resumes_automatically_starts_again_if_the_scene_has_changed() {
    let folder = tempfile::tempdir().unwrap();
    let mut job = Job::new(scene(folder.path(), &[]), folder.path().join("out"));
    job.run(&mut Recorder { stop_after: Some(4), ..Recorder::default() }).unwrap();
    job.scene = scene(folder.path(), &["body.cube.density=500"]);
    job.resume = Resume::Yes;
    assert!(matches!(job.run(&mut ()), Err(RunError::Differs { .. })));
    job.resume = Resume::Auto;
    let mut recorder = Recorder { stop_after: Some(6), ..Recorder::default() };
    job.run(&mut recorder).unwrap();
    assert_eq!(recorder.span, Some((0, 10)));
    // The cautions about the scene follow.
    assert!(matches!(&recorder.notes[0], Note::Restarted { reason } if reason.contains("density")));
    let mut recorder = Recorder::default();
    job.run(&mut recorder).unwrap();
    assert_eq!((recorder.span, recorder.notes), (Some((7, 10)), vec![Note::Resumed { frame: 6 }]));
}

/// Applies a force in every frame, changes settings at frame 2, and stops the job after the frame whose
/// number is the second field.
struct Driver(Option<Arc<Mutex<Simulation>>>, u32);

impl Observer for Driver {
    fn built(&mut self, simulation: &Arc<Mutex<Simulation>>, inputs: &[Input]) {
        assert_eq!(inputs.len(), simulation.lock().unwrap().bodies().len());
        self.0 = Some(simulation.clone());
    }

    fn frame(&mut self, progress: &Progress) -> Flow {
        // The job does not hold the lock during the call.
        let mut simulation = self.0.as_ref().unwrap().try_lock().unwrap();
        assert_eq!(simulation.time(), progress.time);
        if progress.frame == 2 {
            simulation.set_gravity([0.0, 2.0, 0.0]).unwrap();
            simulation.body_mut(0).set_region_size(RegionSize::Cells(1.into())).unwrap();
            simulation.body_mut(0).set_volume(VolumeMeasure::Lattice).unwrap();
            // Until frame 8, after the frame of the stop.
            simulation.collider_mut(0).move_to_in([0.0, 0.2, 0.0], [0.0; 3], 0.2).unwrap();
        }
        if progress.frame >= 8 {
            assert_eq!(simulation.collider(0).translation(), [0.0, 0.2, 0.0]);
        }
        let top = Selection::Plane { point: [0.0, 0.9, 0.0], normal: [0.0, 1.0, 0.0] };
        simulation.body_mut(0).apply_force([4e3, 1e4, 0.0], &top).unwrap();
        if progress.frame == self.1 { Flow::Stop } else { Flow::Continue }
    }
}

/// Lists the files in a folder at a frame, and stops the job after it.
struct Lister<'a> {
    folder: &'a Path,
    at: u32,
    found: Vec<String>,
}

impl Observer for Lister<'_> {
    fn frame(&mut self, progress: &Progress) -> Flow {
        if progress.frame < self.at {
            return Flow::Continue;
        }
        self.found = files(self.folder);
        Flow::Stop
    }
}

/// Returns the names of the frames in a folder, also of incomplete ones, sorted.
fn files(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut names: Vec<_> = names.filter(|name| name.starts_with("cube_")).collect();
    names.sort();
    names
}

#[test]
fn frames_of_an_earlier_run_have_temporary_names_until_they_are_replaced_or_removed() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let job = |overrides: &[&str]| Job::new(scene(folder.path(), overrides), &out);
    job(&["simulation.frames=8"]).run(&mut Recorder::default()).unwrap();
    std::fs::copy(out.join("cube_0007.obj"), out.join("cube_0003.obj.part")).unwrap();
    std::fs::copy(out.join("cube_0007.obj"), out.join("cube_00002.obj")).unwrap();
    let mut lister = Lister { folder: &out, at: 3, found: Vec::new() };
    job(&["simulation.frames=5"]).run(&mut lister).unwrap();
    let name = |k: u32| format!("cube_{k:04}.obj");
    let complete: Vec<_> = (0..4).map(name).collect();
    let aside = (4..6).map(|k| format!("{}.part", name(k)));
    assert_eq!(lister.found, complete.iter().cloned().chain(aside).collect::<Vec<_>>());
    assert_eq!(files(&out), complete, "older frames are removed when the job stops");
    job(&[]).run(&mut Recorder::default()).unwrap();
    assert_eq!(files(&out), (0..11).map(name).collect::<Vec<_>>());
}

#[test]
fn changes_by_an_observer_survive_stopping_and_resuming() {
    let folder = tempfile::tempdir().unwrap();
    let frame = |name: &str| std::fs::read(folder.path().join(name).join("cube_0010.obj")).unwrap();
    let mut job = Job::new(scene(folder.path(), &[]), folder.path().join("whole"));
    job.run(&mut Driver(None, 10)).unwrap();
    job.directory = folder.path().join("parts");
    job.run(&mut Driver(None, 5)).unwrap();
    job.resume = true.into();
    let report = job.run(&mut Driver(None, 10)).unwrap();
    assert_eq!((report.resumed_after, report.bodies[0].volume.measure), (Some(5), VolumeMeasure::Lattice));
    assert_eq!(frame("parts"), frame("whole"));
    job.directory = folder.path().join("alone");
    job.run(&mut ()).unwrap();
    assert_ne!(frame("alone"), frame("whole"));
}

/// Returns an OBJ text of a sphere with a `vn` after each `v`. The mesh update of the sphere is large enough that several
/// threads share it.
fn ball() -> String {
    let (vertices, faces) = supple_tests::sphere([0.0; 3], 1.0, 32);
    let elements = vertices.iter().map(|[x, y, z]| format!("v {x} {y} {z}\nvn {x} {y} {z}\n"));
    let corner = |&vertex: &u32| format!(" {0}//{0}", vertex + 1);
    let faces = faces.iter().map(|face| format!("f{}\n", face.iter().map(corner).collect::<String>()));
    elements.chain(faces).collect()
}

#[test]
fn frames_have_the_same_bytes_for_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    let frame = |format: &str, threads: usize| {
        let overrides = [
            "simulation.frames=3".to_owned(),
            format!("simulation.threads={threads}"),
            format!("output.format={format}"),
            "body.cube.spin=[1, 2, 3]".to_owned(),
        ];
        let overrides: Vec<&str> = overrides.iter().map(String::as_str).collect();
        let scene = scene(folder.path(), &overrides);
        std::fs::write(folder.path().join("cube.obj"), ball()).unwrap();
        let out = folder.path().join(format!("{format}{threads}"));
        Job::new(scene, &out).run(&mut ()).unwrap();
        let name = if format == "pc2" { "cube.pc2" } else { &format!("cube_0003.{format}") };
        std::fs::read(out.join(name)).unwrap()
    };
    for format in ["obj", "ply", "pc2"] {
        let one = frame(format, 1);
        assert!(one.len() > 12 * 6100);
        assert!([2, 3].iter().all(|&threads| frame(format, threads) == one), "{format}");
    }
}

#[test]
fn invalid_jobs_are_input_errors_before_anything_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let refused = |job: Job| {
        let error = job.run(&mut ()).unwrap_err();
        assert!(error.is_input() && !out.exists(), "{error}");
        error.to_string()
    };
    let job = |overrides: &[&str]| Job::new(scene(folder.path(), overrides), &out);
    assert!(refused(Job { every: 0, ..job(&[]) }).contains("`every` is 0; it must be at least 1"));
    assert!(
        refused(Job { stats: Some("rows.txt".into()), ..job(&[]) })
            .contains("rows.txt must end in .csv or .json")
    );
    assert!(refused(job(&["body.cube.mesh=none.obj"])).starts_with("`body.cube.mesh`: cannot read "));
    assert!(refused(job(&["body.cube.object=Head"])).contains("no object or group `Head` with faces"));
    let pin = "body.cube.pin=[{ sphere = { center = [9, 0, 0], radius = 1 } }]";
    assert!(refused(job(&[pin])).contains("body.cube.pin.0: the sphere selects nothing"));
    let open = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let of_mesh = job(&["body.cube.volume=mesh"]);
    std::fs::write(folder.path().join("cube.obj"), open).unwrap();
    assert!(refused(of_mesh).contains("3 edges of this one are open"));
}

#[test]
fn a_write_failure_is_not_an_input_error() {
    let folder = tempfile::tempdir().unwrap();
    let job = Job::new(scene(folder.path(), &[]), folder.path().join("cube.obj/out"));
    let error = job.run(&mut ()).unwrap_err();
    assert!(matches!(error, RunError::Io { .. }) && !error.is_input(), "{error}");
}

#[test]
fn checkpoints_are_written_after_the_checkpoint_interval() {
    let folder = tempfile::tempdir().unwrap();
    let mut job = Job::new(scene(folder.path(), &[]), folder.path().join("out"));
    /// Counts the frames at which the checkpoint exists.
    struct CheckpointCounter<'a>(&'a Path, usize);
    impl Observer for CheckpointCounter<'_> {
        fn frame(&mut self, _: &Progress) -> Flow {
            self.1 += usize::from(self.0.is_file());
            Flow::Continue
        }
    }
    let path = job.directory.join(CHECKPOINT);
    for (interval, expected) in [(Duration::from_secs(1000), 0), (Duration::ZERO, 10)] {
        job.checkpoint_interval = interval;
        let mut counter = CheckpointCounter(&path, 0);
        job.run(&mut counter).unwrap();
        assert_eq!(counter.1, expected);
    }
}

#[test]
fn many_bodies_list_the_output_directory_once() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("cube.obj"), cube::CUBE).unwrap();
    let mut text = "[simulation]\nframes = 1\nsubsteps = 1\n".to_owned();
    for body in 0..200 {
        let place = format!("translate = [{}, 0, 0]", 2 * body);
        text +=
            &format!("[[body]]\nname = \"b{body}\"\nmesh = \"cube.obj\"\nlattice_vertices = 8\n{place}\n");
    }
    let scene = Scene::parse(&text, "scene.toml", folder.path(), &[]).unwrap();
    let job = Job { resume: true.into(), ..Job::new(scene, folder.path().join("out")) };
    job.run(&mut ()).unwrap();
    let others = |count: usize| {
        for file in 0..count {
            std::fs::write(job.directory.join(format!("other_{file:05}.obj")), "").unwrap();
        }
    };
    let time = |frames: u32, resume: bool| {
        let mut job = Job { resume: resume.into(), ..job.clone() };
        job.scene.simulation.frames = frames;
        let start = Instant::now();
        job.run(&mut ()).unwrap();
        start.elapsed()
    };
    others(100);
    let few = time(2, true) + time(1, false);
    others(20_000);
    // One listing of 20,000 files takes milliseconds, a listing per body takes 200 times as long in each try.
    let many = || time(2, true) + time(1, false);
    assert!((0..3).any(|_| many() < few + Duration::from_secs(2)), "{few:?} with few files");
}

/// Returns the automatic number of steps per frame of the scene with overrides and cells of edge `cell_size`, and its
/// reason. The body is a unit cube with its base at y = 0.5.
fn chosen(overrides: &[&str], cell_size: f64) -> (u32, StepReason) {
    let folder = tempfile::tempdir().unwrap();
    let mut scene = scene(folder.path(), overrides);
    scene.bodies[0].resolution = Resolution::CellSize(cell_size);
    assert_eq!(scene.simulation.substeps, Substeps::Auto, "the default");
    let prepared = prepare(&scene).unwrap();
    let chosen = prepared.simulation.chosen_substeps().unwrap();
    assert_eq!((prepared.substeps, chosen.body), (chosen.steps, 0));
    assert!((prepared.simulation.dt() * 30.0 * f64::from(chosen.steps) - 1.0).abs() < 1e-14);
    (chosen.steps, chosen.reason)
}

#[test]
fn auto_substeps_follow_frequency_and_speed() {
    use StepReason::{Fall, Material, Motion, One};
    let still = "simulation.gravity=[0, 0, 0]";
    // The stiffness per step needs no steps.
    let stiffness = "body.cube.half_width=2";
    assert_eq!(chosen(&[still, stiffness], 0.1), (1, One));
    // At least six steps per period: alpha = 2 (1 - cos(2 pi / 6)) = 1.
    for (frequency, expected) in [("5", (1, One)), ("10", (2, Material)), ("10.1", (3, Material))] {
        assert_eq!(
            chosen(&[still, &format!("body.cube.frequency={frequency}")], 0.1),
            expected,
            "{frequency}"
        );
    }
    // At most one cell per step: 12 / (30 x 0.1) = 4.
    assert_eq!(chosen(&[still, stiffness, "body.cube.velocity=[12, 0, 0]"], 0.1), (4, Fall));
    assert_eq!(chosen(&[still, stiffness, "body.cube.velocity=[12, 0, 0]"], 0.4), (1, One));
    // The center falls from y = 1 to the plane: v = sqrt(2 x 72 x 1) = 12, and 12 / (30 x 0.1) = 4.
    assert_eq!(chosen(&["simulation.gravity=[0, -72, 0]", stiffness], 0.1), (4, Fall));
    assert_eq!(chosen(&["simulation.gravity=[0, 72, 0]", stiffness], 0.1), (1, One));
    let mover = "collider.0.keys=[{ time = 0 }, { time = 0.5, translate = [0, 6, 0] }]";
    assert_eq!(chosen(&[still, stiffness, mover], 0.1), (4, Motion));
    let handle = "body.cube.handle=[{ sphere = { center = [0, 1, 0], radius = 1 }, \
                  keys = [{ time = 0 }, { time = 1, translate = [12, 0, 0] }] }]";
    assert_eq!(chosen(&[still, stiffness, handle], 0.1), (4, Motion));
}

/// The widest regions.
const FAST: &str = "body.cube.accuracy=fast";

#[test]
fn auto_substeps_follow_the_material() {
    // alpha <= 1 with regions of R/h = sqrt(w (w + 1)) needs steps of at most R sqrt(rho/(3 E)). In a cube of 10 cells
    // w = 2, in one of 5 cells w = 1, because R <= 0.3 L.
    let fps = 30.0;
    let needed = |modulus: f64, cell_size: f64| {
        let squared: f64 = if cell_size > 0.1 { 2.0 } else { 6.0 };
        ((3.0 * modulus / 1000.0 / squared).sqrt() / (cell_size * fps)).ceil() as u32
    };
    let still = "simulation.gravity=[0, 0, 0]";
    for (modulus, cell_size) in [(1e5, 0.1), (1e6, 0.1), (1e6, 0.2)] {
        let text = format!("body.cube.youngs_modulus={modulus}");
        let expected = (needed(modulus, cell_size), StepReason::Material);
        assert_eq!(chosen(&[FAST, still, &text], cell_size), expected, "{modulus}, {cell_size}");
    }
    // The material of a preset depends on gravity: E = k rho L max(g, 8 L) with L = 1 and k = 80; without Poisson's ratio.
    for (gravity, effective) in [(0.0, 8.0), (9.81, 9.81), (40.0, 40.0)] {
        let text = format!("simulation.gravity=[0, {gravity}, 0]");
        let expected = (needed(80.0 * 1000.0 * effective, 0.1), StepReason::Material);
        let settings = [FAST, "body.cube.poisson_ratio=0", &text];
        assert_eq!(chosen(&settings, 0.1), expected, "{gravity}");
    }
    // A soft body on small cells would slip on the ground: 2 w (w + 1)/3 rho g L/E <= 1/2 allows w = 1 only, which
    // needs steps of at most h sqrt(2/3 rho/E), while the limit of the length of the regions, 0.15 L, allows w = 2.
    let (modulus, slip) = (5e4, (5e4_f64 / (2.0 / 3.0 * 1000.0)).sqrt() / (0.05 * 30.0));
    let text = format!("body.cube.youngs_modulus={modulus}");
    assert_eq!(
        chosen(&[FAST, "simulation.gravity=[0, -9.81, 0]", &text], 0.05),
        (slip.ceil() as u32, StepReason::Slip)
    );
}

/// Regions of one cell need steps of at most h/2 sqrt(rho/E), whatever the frame rate and the ground; `balanced` has
/// them where a second costs at most 0.12 s, at 20 ns per vertex and step, and otherwise the least that does.
#[test]
fn accuracy_chooses_the_regions_and_the_steps() {
    let ground = "simulation.gravity=[0, -9.81, 0]";
    let needed = |modulus: f64, cell_size: f64, moment: f64| {
        ((modulus / 1000.0 / moment).sqrt() / (cell_size * 30.0)).ceil() as u32
    };
    let steps = |accuracy: &str, modulus: f64, cell_size: f64| {
        let keys = [format!("body.cube.accuracy={accuracy}"), format!("body.cube.youngs_modulus={modulus}")];
        chosen(&[&keys[0], &keys[1], ground], cell_size).0
    };
    for modulus in [5e4, 1e6] {
        for cell_size in [0.1, 0.05] {
            assert_eq!(steps("exact", modulus, cell_size), needed(modulus, cell_size, 0.25));
        }
    }
    // 1,331 vertices, 200 steps a second; 9,261 vertices, 894 steps a second of one cell, or 548 of w = 1.
    assert_eq!(steps("balanced", 1e5, 0.1), needed(1e5, 0.1, 0.25));
    assert_eq!(steps("balanced", 5e5, 0.05), needed(5e5, 0.05, 2.0 / 3.0));
}

#[test]
fn a_scene_runs_with_its_auto_substeps() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scene(folder.path(), &["body.cube.frequency=40", "simulation.gravity=[0, 0, 0]"]);
    let prepared = prepare(&scene).unwrap();
    assert_eq!(prepared.substeps, 8);
    assert!((prepared.simulation.dt() - 1.0 / 240.0).abs() < 1e-18);
    assert_eq!(prepared.simulation.body(0).softened(), None);
}

/// The scene reader limits names to 200 bytes; a scene that is built in Rust has no such limit.
#[test]
fn a_body_name_too_long_for_a_file_name_is_an_error_before_the_run() {
    let folder = tempfile::tempdir().unwrap();
    let mut scene = scene(folder.path(), &["output.format=\"obj\""]);
    // `_0000.obj.part` has 14 bytes, and a file name has at most 255.
    scene.bodies[0].name = "n".repeat(242);
    let out = folder.path().join("out");
    let error = Job::new(scene, &out).run(&mut ()).unwrap_err();
    assert!(error.is_input() && !out.exists(), "{error}");
    for words in ["up to 256 bytes", "255", "shorter name"] {
        assert!(error.to_string().contains(words), "{error}");
    }
}
