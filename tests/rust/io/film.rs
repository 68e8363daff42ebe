//! Films, decoded as a viewer does: durations, where the bodies and their shadows are, the same bytes for any number of
//! threads, and runs that are stopped and killed.

use std::f64::consts::PI;
use std::fs;
use std::io::Cursor;
use std::path::Path;
use std::time::Duration;

use image_webp::WebPDecoder;
use supple_io::films::{FilmRequest, film};
use supple_io::run::{Job, Note, Observer, Outcome};
use supple_io::scene::Scene;

use crate::piece_frames::bar;
use crate::run_files::{CopyAfter, StopAfter, written};

/// Tangent of half the angle of view along the shorter side, and the share of the picture that is filled.
const VIEW_ANGLE: f64 = 0.24;
const FILLED: f64 = 0.86;

/// A ball with radius 1 about (0, 2, 0), which rests without gravity, and a level plane.
const BALL: &str = r#"
[simulation]
frames = 3
gravity = [0, 0, 0]

[output]
format = "film"

[[body]]
name = "ball"
mesh = "ball.obj"
translate = [0, 2, 0]
cell_size = 0.5

[[collider]]
plane = { point = [0, 0, 0], normal = [0, 1, 0] }
"#;

/// A bar that is pulled apart, and one that falls on a sphere.
const BARS: &str = r#"
[simulation]
frames = 14

[output]
format = "film"
film_size = [160, 120]

[[body]]
name = "still"
mesh = "bar.obj"
translate = [0, 0, 3]
cell_size = 0.5

[[body]]
name = "bar"
mesh = "bar.obj"
cell_size = 0.25
half_width = 1

[body.fracture]
strain = 0.1

[[body.pin]]
box = { min = [-1, -1, -1], max = [0.1, 2, 2] }

[[body.handle]]
box = { min = [3.9, -1, -1], max = [5, 2, 2] }
keys = [{ time = 0.1 }, { time = 0.4, translate = [2, 0.5, 0] }]

[[collider]]
sphere = { center = [2, -2, 3], radius = 1.5 }
keys = [{ time = 0 }, { time = 1, translate = [0, 0.5, 0] }]

[[collider]]
box = { center = [2, -2, 0], half_extents = [1, 0.2, 1], rotate = [0, 30, 10] }
"#;

fn job(folder: &Path, scene: &str, out: &str, overrides: &[&str]) -> Job {
    fs::write(folder.join("ball.obj"), ball()).unwrap();
    fs::write(folder.join("bar.obj"), bar()).unwrap();
    let overrides: Vec<String> = overrides.iter().map(ToString::to_string).collect();
    Job::new(Scene::parse(scene, "scene.toml", folder, &overrides).unwrap(), folder.join(out))
}

/// A ball with radius 1 as an OBJ file, of 64 x 32 faces.
fn ball() -> String {
    let mut text = String::from("v 0 1 0\nv 0 -1 0\n");
    let (around, rings) = (64, 32);
    for ring in 1..rings {
        for step in 0..around {
            let (down, turn) =
                (PI * f64::from(ring) / f64::from(rings), 2.0 * PI * f64::from(step) / f64::from(around));
            text += &format!("v {} {} {}\n", down.sin() * turn.sin(), down.cos(), down.sin() * turn.cos());
        }
    }
    let at = |ring: i32, step: i32| 3 + (ring - 1) * around + step % around;
    for step in 0..around {
        text += &format!("f 1 {} {}\n", at(1, step), at(1, step + 1));
        for ring in 1..rings - 1 {
            let (a, b) = (at(ring, step), at(ring, step + 1));
            text += &format!("f {a} {} {} {b}\n", at(ring + 1, step), at(ring + 1, step + 1));
        }
        text += &format!("f 2 {} {}\n", at(rings - 1, step + 1), at(rings - 1, step));
    }
    text
}

/// A film: its size, and its pictures with their durations in ms.
pub(crate) struct Film {
    size: [usize; 2],
    pub(crate) pictures: Vec<(Vec<u8>, u32)>,
}

impl Film {
    pub(crate) fn read(path: &Path) -> Self {
        let mut decoder = WebPDecoder::new(Cursor::new(fs::read(path).unwrap())).unwrap();
        let (width, height) = decoder.dimensions();
        let channels = if decoder.has_alpha() { 4 } else { 3 };
        let mut picture = |_| {
            let mut pixels = vec![0; decoder.output_buffer_size().unwrap()];
            let duration = decoder.read_frame(&mut pixels).unwrap();
            (pixels.chunks(channels).flat_map(|pixel| pixel[..3].to_vec()).collect(), duration)
        };
        let frames = WebPDecoder::new(Cursor::new(fs::read(path).unwrap())).unwrap().num_frames();
        Self { size: [width as usize, height as usize], pictures: (0..frames).map(&mut picture).collect() }
    }

    /// Returns a pixel of the first picture.
    fn pixel(&self, x: usize, y: usize) -> [f64; 3] {
        let at = 3 * (y * self.size[0] + x);
        [0, 1, 2].map(|k| f64::from(self.pictures[0].0[at + k]))
    }
}

/// Returns whether a pixel has the blue of the first body, and not the gray of planes and of what is behind them.
fn is_body([r, _, b]: [f64; 3]) -> bool {
    b - r > 0.18 * b
}

#[test]
fn a_ball_covers_its_projection_and_frames_last_as_long_as_those_of_the_run() {
    let folder = tempfile::tempdir().unwrap();
    let job = job(folder.path(), BALL, "out", &["output.film_view=[0, 0, 1]"]);
    job.run(&mut ()).unwrap();
    assert_eq!(written(&job.directory).keys().collect::<Vec<_>>(), ["supple.webp"]);
    let film = Film::read(&job.directory.join("supple.webp"));
    assert_eq!(film.size, [800, 600]);
    let durations: Vec<u32> = film.pictures.iter().map(|(_, duration)| *duration).collect();
    assert_eq!(durations, [33, 34, 33, 33]);
    // The camera is so far that the near side of the bounds, a square of side 2, fills its part of the height.
    let distance = 1.0 + 1.0 / (FILLED * VIEW_ANGLE);
    let focal = 300.0 / VIEW_ANGLE;
    let radius = focal / (distance * distance - 1.0).sqrt();
    let (mut area, mut center) = (0.0, [0.0; 2]);
    for y in 0..600 {
        for x in 0..800 {
            if is_body(film.pixel(x, y)) {
                area += 1.0;
                center = [center[0] + x as f64 + 0.5, center[1] + y as f64 + 0.5];
            }
        }
    }
    // The outline of the mesh is inside of the circle by 0.2 %, and half of the pixels at the edge may count or not.
    assert!((area / (PI * radius * radius) - 1.0).abs() < 0.015, "{area} for a radius of {radius}");
    let center = center.map(|sum| sum / area);
    assert!((center[0] - 400.0).abs() < 2.0 && (center[1] - 300.0).abs() < 2.0, "{center:?}");
}

#[test]
fn the_shadow_is_where_the_light_throws_it() {
    let folder = tempfile::tempdir().unwrap();
    let job = job(folder.path(), BALL, "out", &["output.film_view=[0, 1, 0]"]);
    job.run(&mut ()).unwrap();
    let film = Film::read(&job.directory.join("supple.webp"));
    // Seen from above, x is to the right and z down. The light comes from the left and below: for a height of 1 it moves by
    // 0.62 to the right and 0.42 up. The center of the ball is 2 above the plane.
    let distance = 1.0 + 1.0 / (FILLED * VIEW_ANGLE);
    let scale = 300.0 / VIEW_ANGLE / (distance + 2.0);
    let at = |x: f64, z: f64| film.pixel((400.0 + scale * x) as usize, (300.0 + scale * z) as usize);
    // Two thirds of the shadow, which is an ellipse, are hidden by the ball.
    let (shadow, lit) = (at(2.0 * 0.62 + 0.2, -2.0 * 0.42 - 0.2), at(-2.0 * 0.62 - 0.2, 2.0 * 0.42 + 0.2));
    assert!(!is_body(shadow) && !is_body(lit), "{shadow:?} {lit:?}");
    assert!(shadow[1] < 0.85 * lit[1], "{shadow:?} {lit:?}");
}

#[test]
fn the_bytes_do_not_depend_on_the_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = |threads: &str| {
        let set = [&format!("simulation.threads={threads}")[..], "output.format=[\"film\", \"gif\"]"];
        let job = job(folder.path(), BARS, &format!("out{threads}"), &set);
        job.run(&mut ()).unwrap();
        ["supple.webp", "supple.gif"].map(|name| fs::read(job.directory.join(name)).unwrap())
    };
    let one = bytes("1");
    assert!(one == bytes("2") && one == bytes("3"));
    let mut options = gif::DecodeOptions::new();
    options.set_color_output(gif::ColorOutput::RGBA);
    let mut decoder = options.read_info(&one[1][..]).unwrap();
    assert_eq!((decoder.width(), decoder.height()), (160, 120));
    let mut delays = Vec::new();
    while let Some(frame) = decoder.read_next_frame().unwrap() {
        delays.push(frame.delay);
    }
    // Hundredths of a second: 15 frames at 30 per second.
    assert_eq!((delays.len(), delays.iter().sum::<u16>()), (15, 50));
}

#[test]
fn a_film_of_a_page_is_that_of_the_run() {
    let folder = tempfile::tempdir().unwrap();
    let job = job(folder.path(), BARS, "out", &["output.format=[\"film\", \"html\", \"obj\"]"]);
    job.run(&mut ()).unwrap();
    let of_run = Film::read(&job.directory.join("supple.webp"));
    let mut request = FilmRequest::default();
    request.look.size = [160, 120];
    let path = folder.path().join("page.webp");
    assert_eq!(film(&job.directory, &path, &request).unwrap(), 15);
    assert!(Film::read(&path).pictures == of_run.pictures);
    // Without the page there are frames, which have no colliders.
    fs::remove_file(job.directory.join("supple.html")).unwrap();
    assert_eq!(film(&job.directory, &path, &request).unwrap(), 15);
    let of_frames = Film::read(&path);
    assert_eq!(of_frames.pictures.len(), 15);
    let bodies = |film: &Film| {
        let pixels = (0..120).flat_map(|y| (0..160).map(move |x| (x, y)));
        pixels.filter(|&(x, y)| is_body(film.pixel(x, y))).count()
    };
    // The second body, in alphabetical order, is the first one in the scene: each is the blue one once.
    assert!(bodies(&of_frames) > 200 && bodies(&of_run) > 200);
}

#[test]
fn what_is_not_a_run_or_a_film_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |input: &str, output: &str| {
        let error = film(&folder.path().join(input), &folder.path().join(output), &FilmRequest::default());
        let error = error.unwrap_err();
        assert!(error.is_input());
        error.to_string()
    };
    assert!(refused("", "film.mp4").contains("must end in .webp or .gif"));
    assert!(refused("", "film.webp").contains("neither a page supple.html nor frames"));
    assert!(refused("missing", "film.webp").contains("cannot read"));
    fs::write(folder.path().join("a.html"), "<html></html>").unwrap();
    assert!(refused("a.html", "film.webp").contains("not a page of supple"));
    fs::write(folder.path().join("a_0000.obj"), "v 0 0 0\nf 1 2 3\n").unwrap();
    assert!(refused("", "film.webp").contains("cannot read"));
    assert_eq!(written(folder.path()).len(), 2);
    for (set, expected) in [
        ("output.film_size=[8, 600]", "film_size"),
        ("output.film_size=[800.5, 600]", "film_size"),
        ("output.film_size=[800, 5000]", "4096"),
        ("output.film_view=[0, 0, 0]", "film_view"),
        ("output.film_color=\"red\"", "film_color"),
    ] {
        let error =
            Scene::parse(BALL, "scene.toml", folder.path(), &[set.to_owned()]).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
}

#[test]
fn stopped_and_killed_runs_have_the_film_of_an_uninterrupted_run() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let mut whole = job(folder.path(), BARS, "whole", &[]);
    whole.checkpoint_interval = Duration::ZERO;
    whole.run(&mut CopyAfter { frame: 9, from: at("whole"), to: at("killed") }).unwrap();
    let expected = written(&at("whole"));
    assert!(at("killed/supple.webp.data").exists() && !at("killed/supple.webp").exists());
    let mut resumed = whole.clone();
    (resumed.directory, resumed.resume, resumed.verify) = (at("killed"), true.into(), true);
    resumed.run(&mut ()).unwrap();
    assert!(written(&at("killed")) == expected);
    // A run that is stopped has a film of its frames so far, and continues.
    let mut stopped = whole.clone();
    stopped.directory = at("stopped");
    stopped.run(&mut StopAfter(7)).unwrap();
    assert_eq!(Film::read(&at("stopped/supple.webp")).pictures.len(), 8);
    stopped.resume = true.into();
    stopped.run(&mut ()).unwrap();
    assert!(written(&at("stopped")) == expected);
    assert_eq!(stopped.run(&mut ()).unwrap().outcome, Outcome::AlreadyFinished);
    // A complete film is not continued: the run starts again, and says why. So it does if the film was changed.
    struct Reasons(Vec<String>);
    impl Observer for Reasons {
        fn note(&mut self, note: &Note) {
            if let Note::Restarted { reason } = note {
                self.0.push(reason.clone());
            }
        }
    }
    let mut reasons = Reasons(Vec::new());
    let whole = &expected["supple.webp"];
    fs::write(at("stopped/supple.webp"), &whole[..whole.len() - 200]).unwrap();
    stopped.run(&mut reasons).unwrap();
    assert!(reasons.0[0].contains("was changed") && written(&at("stopped")) == expected, "{:?}", reasons.0);
    let mut longer = job(folder.path(), BARS, "stopped", &["simulation.frames=16"]);
    longer.resume = true.into();
    longer.run(&mut reasons).unwrap();
    assert!(reasons.0.len() == 2 && reasons.0[1].contains("is complete"), "{:?}", reasons.0);
    // Another look is another film.
    let mut other =
        job(folder.path(), BARS, "stopped", &["simulation.frames=16", "output.film_size=[80, 60]"]);
    other.resume = true.into();
    let error = other.run(&mut ()).unwrap_err().to_string();
    assert!(error.contains("`output.film_size` of the files changed from [160, 120] to [80, 60]"), "{error}");
}
