//! USD stages: the values in their frames equal the frames of other formats, they resume to the same bytes, and the
//! axes and the scale of the files are the same in every format. The tests in Python read the whole stage.

use std::fs;
use std::path::Path;
use std::time::Duration;

use nalgebra::Point3;
use supple::{Body, Lattice, Simulation};
use supple_io::frames::{Format, FrameWriter, OutputError, Sequence, Source, read_pc2};
use supple_io::obj::Document;
use supple_io::run::{Job, Note, Observer, Outcome, Recording, RecordingOptions};
use supple_io::scene::{Scene, Up};

use crate::page_reader::runs;
use crate::run_files::{BLOCK, CopyAfter, StopAfter, written};

/// Two bodies, one of which is turned by a handle, and a ball that moves.
const SCENE: &str = r#"
[simulation]
frames = 12
fps = 24
substeps = 2

[[body]]
name = "soft"
mesh = "block.obj"
translate = [0, 0.2, 0]
lattice_vertices = 60

[[body.handle]]
plane = { point = [0, 2, 0], normal = [0, 1, 0] }
keys = [{ time = 0 }, { time = 0.5, translate = [0, 1, 0], rotate = [0, 90, 0] }]

[[body]]
name = "second"
mesh = "block.obj"
scale = 0.5
translate = [4, 1, 0]

[[collider]]
plane = { point = [0, 0, 0], normal = [0, 1, 0] }

[[collider]]
sphere = { center = [4, -1, 0], radius = 1.5 }
keys = [{ time = 0 }, { time = 0.5, translate = [0, 0.6, 0], rotate = [0, 0, 90] }]
"#;

/// Points of the block.
const POINTS: usize = 8;

/// Size of a frame: points and bounds of two bodies, each array after its number of elements, and two matrices.
const FRAME: usize = 2 * (8 + 12 * POINTS + 8 + 24) + 2 * 128;

/// Offset of the first frame.
const FRAMES: usize = 96;

fn job(folder: &Path, out: &str, overrides: &[&str]) -> Job {
    fs::write(folder.join("block.obj"), BLOCK).unwrap();
    let overrides: Vec<String> = overrides.iter().map(ToString::to_string).collect();
    Job::new(Scene::parse(SCENE, "scene.toml", folder, &overrides).unwrap(), folder.join(out))
}

/// Returns the points and the bounds of a body in a frame of a stage, by the description of its layout.
fn points(stage: &[u8], frame: usize, body: usize) -> (Vec<[f32; 3]>, [[f32; 3]; 2]) {
    let array = |at: usize, count: usize| -> Vec<[f32; 3]> {
        let bytes = &stage[FRAMES + FRAME * frame + at..];
        assert_eq!(u64::from_le_bytes(bytes[..8].try_into().unwrap()), count as u64);
        let numbers =
            bytes[8..8 + 12 * count].as_chunks::<4>().0.iter().map(|bytes| f32::from_le_bytes(*bytes));
        numbers.collect::<Vec<f32>>().as_chunks::<3>().0.to_vec()
    };
    let at = body * (8 + 12 * POINTS + 8 + 24);
    (array(at, POINTS), array(at + 8 + 12 * POINTS, 2).try_into().unwrap())
}

fn obj_points(path: &Path) -> Vec<[f32; 3]> {
    let mesh = Document::read(path).unwrap().part(None).unwrap().into_mesh();
    mesh.vertices().iter().map(|vertex| vertex.cast::<f32>().into()).collect()
}

#[test]
fn the_points_of_every_frame_have_the_bits_of_the_obj_frames_and_lie_in_their_bounds() {
    let folder = tempfile::tempdir().unwrap();
    let mut job = job(folder.path(), "out", &["output.format=[\"obj\", \"usd\"]"]);
    job.start_frame = 1001;
    job.every = 3;
    job.run(&mut ()).unwrap();
    let stage = fs::read(folder.path().join("out/supple.usd")).unwrap();
    assert!(stage.starts_with(b"PXR-USDC\0\x08\0"));
    for frame in 0..5 {
        for (body, name) in ["soft", "second"].into_iter().enumerate() {
            let path = folder.path().join(format!("out/{name}_{}.obj", 1001 + 3 * frame));
            let (points, [low, high]) = points(&stage, frame, body);
            assert_eq!(points, obj_points(&path), "{name}, frame {frame}");
            for axis in 0..3 {
                let values = || points.iter().map(|point| point[axis]);
                assert_eq!(values().fold(f32::INFINITY, f32::min), low[axis]);
                assert_eq!(values().fold(f32::NEG_INFINITY, f32::max), high[axis]);
            }
        }
    }
}

#[test]
fn stopped_killed_and_extended_runs_have_the_stage_of_an_uninterrupted_run() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let formats = "output.format=[\"usd\", \"pc2\"]";
    let mut whole = job(folder.path(), "whole", &[formats]);
    whole.checkpoint_interval = Duration::ZERO;
    // Copies of the run as it is after frames 0, 4 and 5, with a frame after the checkpoint.
    for frame in [0, 4, 5] {
        let to = at(&format!("killed{frame}"));
        whole.run(&mut CopyAfter { frame, from: at("whole"), to: to.clone() }).unwrap();
        assert!(to.join("supple.usd.part").exists() && !to.join("supple.usd").exists());
    }
    let expected = written(&at("whole"));
    assert_eq!(expected.keys().collect::<Vec<_>>(), ["second.pc2", "soft.pc2", "supple.usd"]);

    let resumed = |out: &str, overrides: &[&str], observer: &mut dyn Observer| {
        let mut job = job(folder.path(), out, &[&[formats], overrides].concat());
        job.resume = true.into();
        job.verify = true;
        job.run(observer).unwrap()
    };
    // A killed run that is to end at the frame of its checkpoint only lacks its structure.
    crate::run_files::copy(&at("killed5"), &at("shorter"));
    assert_eq!(resumed("shorter", &["simulation.frames=3"], &mut ()).outcome, Outcome::AlreadyFinished);
    let short = job(folder.path(), "short", &[formats, "simulation.frames=4"]);
    short.run(&mut ()).unwrap();
    assert!(written(&at("shorter"))["supple.usd"] == written(&at("short"))["supple.usd"]);
    for frame in [0, 4, 5] {
        let out = format!("killed{frame}");
        resumed(&out, &[], &mut ());
        assert!(written(&at(&out)) == expected, "killed after frame {frame}");
    }
    // Stopped twice: the stage is complete after each stop, and is continued.
    assert_eq!(resumed("stopped", &[], &mut StopAfter(3)).outcome, Outcome::Stopped);
    assert!(at("stopped/supple.usd").exists());
    assert_eq!(resumed("stopped", &[], &mut StopAfter(7)).resumed_after, Some(3));
    assert_eq!(resumed("stopped", &[], &mut ()).resumed_after, Some(7));
    assert!(written(&at("stopped")) == expected);
    // Extended after its end.
    resumed("extended", &["simulation.frames=6"], &mut ());
    assert_eq!(resumed("extended", &[], &mut ()).resumed_after, Some(6));
    assert!(written(&at("extended")) == expected);
    let before = fs::metadata(at("extended/supple.usd")).unwrap().modified().unwrap();
    assert_eq!(resumed("extended", &[], &mut ()).outcome, Outcome::AlreadyFinished);
    assert_eq!(fs::metadata(at("extended/supple.usd")).unwrap().modified().unwrap(), before);
}

/// Returns bytes with one bit changed.
fn flipped(bytes: &[u8], at: usize) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    bytes[at] ^= 1;
    bytes
}

#[test]
fn a_run_whose_stage_is_damaged_starts_again() {
    struct Notes(Vec<Note>);
    impl Observer for Notes {
        fn note(&mut self, note: &Note) {
            // The cubes of the scene have large faces.
            if !matches!(note, Note::Caution(_)) {
                self.0.push(note.clone());
            }
        }
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out/supple.usd");
    let run = |frames: &str, resume: bool, verify: bool| {
        let mut job = job(folder.path(), "out", &["output.format=usd", frames]);
        (job.resume, job.verify) = (resume.into(), verify);
        let mut notes = Notes(Vec::new());
        job.run(&mut notes).unwrap();
        match &notes.0[..] {
            [Note::Restarted { reason }] => Some(reason.clone()),
            [] | [Note::Resumed { .. }] => None,
            notes => panic!("{notes:?}"),
        }
    };
    run("simulation.frames=6", false, false);
    let expected = fs::read(&path).unwrap();
    run("simulation.frames=5", false, false);
    let whole = fs::read(&path).unwrap();
    let again = |damaged: &[u8], verify: bool| {
        run("simulation.frames=5", false, false);
        fs::write(&path, damaged).unwrap();
        let reason = run("simulation.frames=6", true, verify);
        assert!(fs::read(&path).unwrap() == expected);
        reason
    };
    assert_eq!(again(&whole, true), None);
    assert!(again(&whole[..FRAMES + 5 * FRAME], false).unwrap().contains("it has 5 of 6 frames to keep"));
    assert!(again(b"PXR-USDC", false).unwrap().contains("its beginning is incomplete or was changed"));
    assert!(again(&whole[1..], false).unwrap().contains("its beginning is incomplete or was changed"));
    assert!(again(&flipped(&whole, FRAMES + 2 * FRAME + 9), true).unwrap().contains("frame 2 of"));
    // What follows the frames is written again.
    assert_eq!(again(&whole[..FRAMES + 6 * FRAME], true), None);
    // So it is if all frames exist.
    for (damaged, verify) in [
        (&whole[..whole.len() - 1], false),
        (&whole[..FRAMES + 6 * FRAME], false),
        (&[&whole[..], &[0]].concat(), false),
        (&flipped(&whole, whole.len() - 9), true),
        (&flipped(&whole, FRAMES + 6 * FRAME + 3), true),
        (&flipped(&whole, 20), false),
        (&flipped(&whole, 30), true),
        (&flipped(&whole, 90), true),
    ] {
        run("simulation.frames=5", false, false);
        fs::write(&path, damaged).unwrap();
        assert_eq!(run("simulation.frames=5", true, verify), None);
        assert!(fs::read(&path).unwrap() == whole);
    }
    fs::remove_file(&path).unwrap();
    assert!(run("simulation.frames=7", true, false).unwrap().contains("it is missing"));
}

#[test]
fn the_axis_that_points_up_and_the_scale_are_the_same_in_every_format() {
    let folder = tempfile::tempdir().unwrap();
    let formats = "output.format=[\"obj\", \"ply\", \"pc2\", \"usd\", \"html\"]";
    job(folder.path(), "plain", &[formats]).run(&mut ()).unwrap();
    let changed = [formats, "output.up=z", "output.scale=100", "output.fps=48"];
    job(folder.path(), "turned", &changed).run(&mut ()).unwrap();
    let path = |out: &str, name: &str| folder.path().join(out).join(name);
    let turned = |positions: Vec<[f32; 3]>| -> Vec<[f32; 3]> {
        positions.into_iter().map(|[x, y, z]| [x, -z, y].map(|x| (100.0 * f64::from(x)) as f32)).collect()
    };
    let [stage, plain_stage] = ["turned", "plain"].map(|out| fs::read(path(out, "supple.usd")).unwrap());
    let page = runs(&fs::read_to_string(path("turned", "supple.html")).unwrap()).remove(0);
    assert_eq!(page.header["fps"], 48.0);
    assert_eq!(page.header["up"].to_string(), "[-0.0,0.0,1.0]");
    for frame in 0..13 {
        for (body, name) in ["soft", "second"].into_iter().enumerate() {
            let expected = turned(obj_points(&path("plain", &format!("{name}_{frame:04}.obj"))));
            assert_eq!(points(&stage, frame, body).0, expected, "{name}, frame {frame}");
            assert_eq!(turned(points(&plain_stage, frame, body).0), expected);
            assert_eq!(obj_points(&path("turned", &format!("{name}_{frame:04}.obj"))), expected);
            let cache = read_pc2(path("turned", &format!("{name}.pc2"))).unwrap();
            let sample = &cache.positions[POINTS * frame..POINTS * (frame + 1)];
            assert_eq!(sample, expected);
            // Positions and normals of a PLY file are six floats per vertex after the header.
            let ply = fs::read(path("turned", &format!("{name}_{frame:04}.ply"))).unwrap();
            let plain = fs::read(path("plain", &format!("{name}_{frame:04}.ply"))).unwrap();
            let start = ply.windows(11).position(|window| window == b"end_header\n").unwrap() + 11;
            let vertices = |bytes: &[u8]| -> Vec<f32> {
                let numbers = bytes[start..start + 24 * POINTS].as_chunks::<4>().0;
                numbers.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect()
            };
            for (vertex, (found, before)) in
                vertices(&ply).chunks(6).zip(vertices(&plain).chunks(6)).enumerate()
            {
                assert_eq!(found[..3], expected[vertex]);
                let [.., x, y, z] = *before else { panic!("a vertex has six numbers") };
                assert_eq!(found[3..], [x, -z, y]);
            }
            let set = &page.sets[frame][2 * body];
            for (found, expected) in set.positions.iter().zip(&expected) {
                for axis in 0..3 {
                    let error = (found[axis] - f64::from(expected[axis])).abs();
                    // Half of a step of the page, and the rounding of the sums in f64.
                    assert!(error <= 0.5 * set.step[axis] + 1e-11);
                }
            }
        }
    }
    // The ball of the page has the size and the place of the scene in the file, and moves along z.
    let ball = &page.header["colliders"][1];
    assert_eq!(
        (ball["radius"].as_f64(), ball["center"].to_string().as_str()),
        (Some(150.0), "[400.0,-0.0,-100.0]")
    );
    assert!((page.poses[12][1][2] - 60.0).abs() < 1e-9);
    // Volumes grow by the third power.
    let plain_page = runs(&fs::read_to_string(path("plain", "supple.html")).unwrap()).remove(0);
    let ratio = page.volumes[0][0][0] / plain_page.volumes[0][0][0];
    assert!((ratio / 1e6 - 1.0).abs() < 1e-12, "{ratio}");
}

#[test]
fn other_axes_units_or_rates_are_no_continuation() {
    let folder = tempfile::tempdir().unwrap();
    job(folder.path(), "out", &["output.format=usd", "simulation.frames=2"]).run(&mut ()).unwrap();
    let resumed = |change: &str| {
        let mut job = job(folder.path(), "out", &["output.format=usd", change]);
        job.resume = true.into();
        job.run(&mut ())
    };
    for (change, words) in [
        ("output.up=z", "`output.up` of the files changed from y to z"),
        ("output.scale=0.01", "`output.scale` of the files changed from 1 to 0.01"),
        ("output.fps=25", "`output.fps` of the files changed from 24 to 25"),
        ("output.meters_per_unit=0.01", "`output.meters_per_unit` of the files changed from 1 to 0.01"),
    ] {
        let error = resumed(change).unwrap_err();
        assert!(error.is_input() && error.to_string().contains(words), "{error}");
    }
    // The values that are meant by default are no change.
    assert!(resumed("output.up=y").is_ok() && resumed("output.fps=24").is_ok());
}

#[test]
fn a_stage_does_not_depend_on_the_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    let stage = |threads: &str| {
        job(folder.path(), threads, &["output.format=usd", threads]).run(&mut ()).unwrap();
        fs::read(folder.path().join(threads).join("supple.usd")).unwrap()
    };
    assert!(stage("simulation.threads=1") == stage("simulation.threads=3"));
}

#[test]
fn a_stage_is_not_written_by_the_writer_of_a_body() {
    let folder = tempfile::tempdir().unwrap();
    let document = Document::from_bytes("block.obj", BLOCK.into()).unwrap();
    let mesh = document.mesh(None).unwrap();
    let sequence = Sequence {
        directory: folder.path().into(),
        name: "a".into(),
        format: Format::Usd,
        first: 0,
        every: 1,
        last: 9,
    };
    let error = FrameWriter::create(sequence, Source::Mesh(&mesh)).unwrap_err();
    assert!(matches!(error, OutputError::NotPerBody { format: Format::Usd }) && error.is_input());
    assert!(error.to_string().contains("for usd run a job instead"), "{error}");
}

#[test]
fn recordings_have_the_frames_of_a_job() {
    let folder = tempfile::tempdir().unwrap();
    let job =
        job(folder.path(), "out", &["output.format=[\"usd\", \"html\"]", "output.up=z", "output.scale=2"]);
    job.run(&mut ()).unwrap();
    let mut options = RecordingOptions::default();
    (options.up, options.scale) = (Some(Up::Z), 2.0);
    fs::create_dir(folder.path().join("mine")).unwrap();
    for name in ["mine/a.usd", "mine/b.html"] {
        let mut simulation = supple_io::run::prepare(&job.scene).unwrap().simulation;
        let mut recording = Recording::create(&folder.path().join(name), &simulation, &options).unwrap();
        for frame in 0..13 {
            simulation.advance(u64::from(frame > 0));
            recording.write(&simulation).unwrap();
        }
        assert_eq!(recording.frames(), 13);
        recording.finish().unwrap();
    }
    let frames = |path: &str| {
        let stage = fs::read(folder.path().join(path)).unwrap();
        stage[FRAMES..FRAMES + 13 * FRAME].to_vec()
    };
    assert!(frames("mine/a.usd") == frames("out/supple.usd"));
    let page = |path: &str| runs(&fs::read_to_string(folder.path().join(path)).unwrap()).remove(0);
    let (mine, whole) = (page("mine/b.html"), page("out/supple.html"));
    for (mine, whole) in mine.sets.iter().flatten().zip(whole.sets.iter().flatten()) {
        assert_eq!(mine.positions, whole.positions);
    }
    let names: Vec<String> = written(&folder.path().join("mine")).into_keys().collect();
    assert_eq!(names, ["a.usd", "b.html"]);
}

#[test]
fn a_recording_goes_on_after_a_frame_that_cannot_be_written() {
    let folder = tempfile::tempdir().unwrap();
    let job = job(folder.path(), "out", &[]);
    let mut options = RecordingOptions::default();
    options.scale = 1e30;
    for name in ["a.usd", "b.html"] {
        let path = folder.path().join(name);
        let mut simulation = supple_io::run::prepare(&job.scene).unwrap().simulation;
        let mut recording = Recording::create(&path, &simulation, &options).unwrap();
        recording.write(&simulation).unwrap();
        let before = simulation.state();
        // The second body leaves the range of 32-bit numbers in the file.
        let far = vec![Point3::new(1e9, 0.0, 0.0); simulation.body(1).lattice().len()];
        simulation.body_mut(1).set_positions(&far).unwrap();
        let error = recording.write(&simulation).unwrap_err();
        assert!(matches!(error, OutputError::NotFinite { frame: 1, .. }), "{error}");
        simulation.restore(&before).unwrap();
        recording.write(&simulation).unwrap();
        recording.finish().unwrap();
        if name == "a.usd" {
            let stage = fs::read(path).unwrap();
            assert_eq!(
                [0, 1].map(|body| points(&stage, 1, body)),
                [0, 1].map(|body| points(&stage, 0, body))
            );
        } else {
            let run = runs(&fs::read_to_string(path).unwrap()).remove(0);
            assert!(run.sets[0].iter().zip(&run.sets[1]).all(|(a, b)| a.positions == b.positions));
        }
    }
}

#[test]
fn recordings_of_other_files_or_of_bare_lattices_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let lattice = Lattice::from_cells(&[[0, 0, 0], [1, 0, 0]], 1.0, [0.0; 3], true).unwrap();
    let bare = Body::from_lattice(lattice).build().unwrap();
    let simulation = Simulation::builder().body(bare).build().unwrap();
    let refused = |name: &str| {
        let path = folder.path().join(name);
        let error = Recording::create(&path, &simulation, &RecordingOptions::default()).unwrap_err();
        assert!(error.is_input());
        error.to_string()
    };
    for name in ["a.obj", "a.pc2", "a", "a.abc"] {
        let endings = "the name of a recording ends in .usd, .usdz, .html, .glb, .webp or .gif";
        assert!(refused(name).ends_with(endings), "{}", refused(name));
    }
    assert!(refused("a.usd").contains("is a bare lattice"), "{}", refused("a.usd"));
    assert!(fs::read_dir(folder.path()).unwrap().next().is_none());
}

/// A block that flies above the ground.
const FALL: &str = r#"
[simulation]
fps = 24
substeps = 4

[output]
up = "z"
scale = 10
fps = 12
usd_velocities = true

[[body]]
name = "soft"
mesh = "block.obj"
translate = [0, 0.4, 0]
lattice_vertices = 60
volume = "off"
velocity = [3, 0, 1]

[[collider]]
plane = { point = [0, 0, 0], normal = [0, 1, 0] }
"#;

#[test]
fn velocities_are_the_changes_of_points_in_a_step_per_second_of_the_file() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("block.obj"), BLOCK).unwrap();
    let frame_size = 2 * (8 + 12 * POINTS) + 8 + 24 + 128;
    // The motion has the same steps, with a frame after every fourth one, or after each.
    let run = |name: &str, overrides: &[&str]| {
        let overrides: Vec<String> = overrides.iter().map(ToString::to_string).collect();
        let scene = Scene::parse(FALL, "scene.toml", folder.path(), &overrides).unwrap();
        Job::new(scene, folder.path().join(name)).run(&mut ()).unwrap();
    };
    run("coarse", &["output.format=\"usd\"", "simulation.frames=6"]);
    run(
        "fine",
        &["output.format=\"ply\"", "simulation.frames=24", "simulation.fps=96", "simulation.substeps=1"],
    );
    let stage = fs::read(folder.path().join("coarse/supple.usd")).unwrap();
    let vectors = |at: usize| -> Vec<f32> {
        assert_eq!(u64::from_le_bytes(stage[at..at + 8].try_into().unwrap()), POINTS as u64);
        let bytes = &stage[at + 8..at + 8 + 12 * POINTS];
        bytes.as_chunks::<4>().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect()
    };
    let ply = |frame: usize| -> Vec<f32> {
        let bytes = fs::read(folder.path().join(format!("fine/soft_{frame:04}.ply"))).unwrap();
        let start = bytes.windows(11).position(|text| text == b"end_header\n").unwrap() + 11;
        let rows = bytes[start..start + 24 * POINTS].as_chunks::<24>().0.iter().map(|row| &row[..12]);
        rows.flat_map(|row| row.as_chunks::<4>().0).map(|bytes| f32::from_le_bytes(*bytes)).collect()
    };
    // The block meets the ground after 0.28 s. Without a rotation, a step moves the points by their velocities after it.
    for frame in 1..=6 {
        let points = FRAMES + frame_size * frame;
        let velocities = vectors(points + 8 + 12 * POINTS + 8 + 24);
        let (before, after) = (ply(4 * frame - 1), ply(4 * frame));
        assert_eq!(vectors(points), after, "frame {frame}");
        let fastest = velocities.iter().fold(0.0_f32, |fastest, v| fastest.max(v.abs()));
        assert!(fastest > 10.0, "the lengths of the file are ten times those of the scene: {fastest}");
        for ((velocity, before), after) in velocities.iter().zip(before).zip(after) {
            // 96 steps per second, at half the speed. Coordinates are below 64, with steps of 4e-6 in f32; that of the
            // program, in cells, are as fine.
            let change = (after - before) * 48.0;
            assert!((velocity - change).abs() < 48.0 * 4.0 * 4e-6, "frame {frame}: {velocity}, {change}");
        }
    }
}

#[test]
fn a_broken_body_has_a_velocity_per_point() {
    let folder = tempfile::tempdir().unwrap();
    let scene = supple_tests::example("notch.toml");
    let overrides = ["output.format=\"usd\"", "output.usd_velocities=true", "simulation.frames=40"];
    let overrides = overrides.map(ToString::to_string);
    let mut killed = Job::new(Scene::read_with(&scene, &overrides).unwrap(), folder.path().join("killed"));
    let whole = Job { directory: folder.path().join("whole"), ..killed.clone() };
    whole.run(&mut ()).unwrap();
    killed.run(&mut StopAfter(30)).unwrap();
    killed.resume = true.into();
    killed.run(&mut ()).unwrap();
    let [whole, killed] = ["whole", "killed"].map(|name| folder.path().join(name));
    assert!(written(&killed) == written(&whole));
    let mut other = Job::new(Scene::read_with(&scene, &overrides[..1]).unwrap(), killed);
    (other.resume, other.scene.simulation.frames) = (true.into(), 40);
    let error = other.run(&mut ()).unwrap_err().to_string();
    assert!(error.contains("`output.usd_velocities` of the files changed from true to false"), "{error}");
}
