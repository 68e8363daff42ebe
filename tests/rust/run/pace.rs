//! The time scale and the pre-roll of runs.

use std::path::Path;

use supple_io::run::{Flow, Job, Observer, Outcome, Progress, Resume, RunError, prepare, preroll};
use supple_io::scene::Scene;

use crate::cube;

/// A cube with a handle that falls to the ground.
const SCENE: &str = r#"
[simulation]
frames = 12
fps = 32
substeps = 4

[output]
format = "ply"

[[body]]
name = "cube"
mesh = "cube.obj"
translate = [0, 0.2, 0]
lattice_vertices = 64
half_width = 1

[[body.pin]]
plane = { point = [0, 1.1, 0], normal = [0, 1, 0] }
end = 0.125

[[body.handle]]
plane = { point = [0.1, 0, 0], normal = [-1, 0, 0] }
keys = [ { time = 0 }, { time = 0.25, translate = [0, 0, 0.2] } ]

[[collider]]
plane = { point = [0, 0, 0], normal = [0, 1, 0] }
"#;

fn scene(folder: &Path, overrides: &[&str]) -> Scene {
    cube::scene(SCENE, folder, overrides)
}

/// Records the times of the frames and the shares of the pre-roll, and stops after a frame.
#[derive(Default)]
struct Recorder {
    times: Vec<f64>,
    shares: Vec<f64>,
    stop_after: Option<u32>,
    stop_preroll: bool,
}

impl Observer for Recorder {
    fn preroll(&mut self, done: f64) -> Flow {
        self.shares.push(done);
        if self.stop_preroll && self.shares.len() == 3 { Flow::Stop } else { Flow::Continue }
    }

    fn frame(&mut self, progress: &Progress) -> Flow {
        self.times.push(progress.time);
        if self.stop_after == Some(progress.frame) { Flow::Stop } else { Flow::Continue }
    }
}

/// The frames of a run, and what its observer recorded.
struct Frames {
    folder: tempfile::TempDir,
    recorder: Recorder,
}

impl Frames {
    fn of(overrides: &[&str]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let mut recorder = Recorder::default();
        let report = Job::new(scene(folder.path(), overrides), folder.path()).run(&mut recorder).unwrap();
        assert_eq!(report.outcome, Outcome::Finished);
        Self { folder, recorder }
    }

    fn bytes(&self, frame: u32) -> Vec<u8> {
        std::fs::read(self.folder.path().join(format!("cube_{frame:04}.ply"))).unwrap()
    }
}

#[test]
fn a_constant_time_scale_shows_the_same_steps_in_more_or_fewer_frames() {
    let (whole, same) = (Frames::of(&[]), Frames::of(&["simulation.time_scale=1", "simulation.preroll=0"]));
    let (slow, fast) = (Frames::of(&["simulation.time_scale=0.5"]), Frames::of(&["simulation.time_scale=2"]));
    for frame in 0..=12 {
        assert!(whole.bytes(frame) == same.bytes(frame), "{frame}");
        let frames = f64::from(frame);
        assert_eq!(whole.recorder.times[frame as usize], frames / 32.0);
        assert_eq!(slow.recorder.times[frame as usize], frames / 64.0);
        assert_eq!(fast.recorder.times[frame as usize], frames / 16.0);
        if frame <= 6 {
            assert!(slow.bytes(2 * frame) == whole.bytes(frame), "{frame}");
            assert!(fast.bytes(frame) == whole.bytes(2 * frame), "{frame}");
        }
    }
    assert!(slow.bytes(1) != slow.bytes(0) && slow.bytes(1) != whole.bytes(1));
}

#[test]
fn slow_motion_has_a_step_in_each_frame_and_keyframes_integrate_to_the_simulated_time() {
    let slow = Frames::of(&["simulation.time_scale=0.01"]);
    for frame in 1..=12 {
        let expected = 0.01 * f64::from(frame) / 32.0;
        assert!((slow.recorder.times[frame as usize] - expected).abs() < 1e-15);
        assert!(slow.bytes(frame) != slow.bytes(frame - 1), "{frame}");
    }
    // From 1 to 0.2 between 0.0625 s and 0.1875 s, frames 2 and 6.
    let keys = "simulation.time_scale=[{ time = 0.0625, value = 1 }, { time = 0.1875, value = 0.2 }]";
    let ramp = Frames::of(&[keys]);
    let times = &ramp.recorder.times;
    assert_eq!(times[2], 2.0 / 32.0);
    assert!((times[6] - times[2] - 0.6 * 4.0 / 32.0).abs() < 1e-12);
    assert!((times[12] - times[6] - 0.2 * 6.0 / 32.0).abs() < 1e-12);
}

#[test]
fn runs_with_a_time_scale_and_a_preroll_resume_and_continue_bit_for_bit() {
    let keys = "simulation.time_scale=[{ time = 0.0625, value = 1 }, { time = 0.1875, value = 0.2 }]";
    let overrides = [keys, "simulation.preroll=0.1", "output.states=4"];
    let whole = Frames::of(&overrides);
    assert_eq!(whole.recorder.times[0], 0.0);
    let folder = tempfile::tempdir().unwrap();
    let mut job = Job::new(scene(folder.path(), &overrides), folder.path());
    let mut recorder = Recorder { stop_after: Some(5), ..Recorder::default() };
    assert_eq!(job.run(&mut recorder).unwrap().outcome, Outcome::Stopped);
    job.resume = Resume::Yes;
    let mut recorder = Recorder::default();
    assert_eq!(job.run(&mut recorder).unwrap().resumed_after, Some(5));
    assert_eq!((recorder.times, recorder.shares), (whole.recorder.times[6..].to_vec(), vec![]));
    let same = |folder: &Path| {
        (0..=12).all(|frame| {
            let name = format!("cube_{frame:04}.ply");
            std::fs::read(folder.join(name)).unwrap() == whole.bytes(frame)
        })
    };
    assert!(same(folder.path()));
    job.resume = Resume::No;
    job.from = Some(7);
    assert_eq!(job.run(&mut ()).unwrap().resumed_after, Some(4));
    assert!(same(folder.path()));
    // The pre-roll belongs to the frames that exist, and the time scale to the next ones.
    job.scene = scene(folder.path(), &[keys, "simulation.preroll=0.2"]);
    let refused = job.run(&mut ()).unwrap_err();
    assert!(refused.to_string().contains("`simulation.preroll` changed from 0.1 to 0.2"), "{refused}");
    job.scene = scene(folder.path(), &["simulation.time_scale=2", "simulation.preroll=0.1"]);
    let mut recorder = Recorder::default();
    job.run(&mut recorder).unwrap();
    assert!((recorder.times[0] - whole.recorder.times[4] - 2.0 / 32.0).abs() < 1e-12, "{:?}", recorder.times);
}

#[test]
fn frame_0_is_the_state_after_the_preroll_and_pins_hold_in_it() {
    // Nothing begins to move before 0.5 s.
    let late = "body.cube.handle.0.keys=[{ time = 0.5 }, { time = 0.75, translate = [0, 0, 0.2] }]";
    let pin = "body.cube.pin.0.end=0.5";
    let whole = Frames::of(&[late, pin]);
    let rolled = Frames::of(&[late, pin, "simulation.preroll=0.24"]);
    // Rounded up to 8 frames.
    assert_eq!(rolled.recorder.shares, (1..=8).map(|frame| f64::from(frame) / 8.0).collect::<Vec<_>>());
    assert_eq!(rolled.recorder.times, whole.recorder.times);
    for frame in 0..=4 {
        assert!(rolled.bytes(frame) == whole.bytes(frame + 8), "{frame}");
    }
    // A live simulation.
    let folder = tempfile::tempdir().unwrap();
    let mut live =
        prepare(&scene(folder.path(), &[late, pin, "simulation.preroll=0.24"])).unwrap().simulation;
    assert!(preroll(&mut live, 0.24, |_| true).unwrap());
    assert_eq!((live.time(), live.step_count()), (0.0, 32));
    assert!(preroll(&mut live, 0.0, |_| false).unwrap());
}

#[test]
fn a_stopped_preroll_leaves_an_earlier_sequence_as_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let earlier = Job::new(scene(folder.path(), &["simulation.frames=2"]), folder.path());
    earlier.run(&mut ()).unwrap();
    let before = std::fs::read(folder.path().join("cube_0002.ply")).unwrap();
    let job = Job::new(scene(folder.path(), &["simulation.preroll=1"]), folder.path());
    let mut recorder = Recorder { stop_preroll: true, ..Recorder::default() };
    assert!(matches!(job.run(&mut recorder), Err(RunError::Stopped)));
    assert_eq!(recorder.shares.len(), 3);
    assert_eq!(std::fs::read(folder.path().join("cube_0002.ply")).unwrap(), before);
}

#[test]
fn values_out_of_range_name_the_key_and_the_range() {
    let folder = tempfile::tempdir().unwrap();
    let error = |text: &str| {
        let overrides = [text.to_owned()];
        Scene::parse(SCENE, "scene.toml", folder.path(), &overrides).unwrap_err().to_string()
    };
    for value in ["0", "-1", "10.5", "nan", "[{ time = 0, value = 0 }]", "[]"] {
        assert!(error(&format!("simulation.time_scale={value}")).contains("time_scale"), "{value}");
    }
    assert!(error("simulation.time_scale=11").contains("(0, 10]"));
    for value in ["-1", "inf", "1e7"] {
        assert!(error(&format!("simulation.preroll={value}")).contains("preroll"), "{value}");
    }
    assert!(error("simulation.preroll=-1").contains("[0, 1e6]"));
    let job = Job::new(scene(folder.path(), &["simulation.time_scale=1e-12"]), folder.path().join("out"));
    let refused = job.run(&mut ()).unwrap_err();
    assert!(refused.is_input() && refused.to_string().contains("`simulation.time_scale` is"), "{refused}");
    assert!(!folder.path().join("out").exists());
}

#[test]
fn a_scene_keeps_its_time_scale_and_preroll_when_it_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let keys = "simulation.time_scale={ keys = [{ time = 0, value = 1 }, { time = 2, value = 0.2 }], interpolation = \"smooth\" }";
    for overrides in [vec![], vec![keys, "simulation.preroll=1.5", "output.states=30"]] {
        let written = scene(folder.path(), &overrides);
        let read = Scene::parse(&written.to_toml(), "scene.toml", folder.path(), &[]).unwrap();
        assert_eq!(read.simulation, written.simulation);
        assert_eq!(read.output, written.output);
    }
}
