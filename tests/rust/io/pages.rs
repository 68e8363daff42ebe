//! Pages: their data equal the frames of other formats, they resume to the same bytes, they are joined without a
//! change.

use std::fs;
use std::path::Path;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use supple::{Collider, Simulation};
use supple_io::frames::{Format, FrameWriter, OutputError, Sequence, Source};
use supple_io::obj::Document;
use supple_io::pages::{PageError, join};
use supple_io::run::{Flow, Input, Job, Note, Observer, Outcome, Progress};
use supple_io::scene::Scene;

use crate::page_reader::{data, runs};
use crate::run_files::{BLOCK, CopyAfter, StopAfter, written};

/// Two bodies, one of which is turned by a handle, a plane whose point needs all digits, a ball that moves, and a mesh
/// that is animated.
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
volume = "off"

[[collider]]
plane = { point = [31.245270191439438, 0, 121.48791951161945], normal = [0, 1, 0] }

[[collider]]
sphere = { center = [4, -1, 0], radius = 1.5 }
keys = [{ time = 0 }, { time = 0.5, translate = [0, 0.6, 0], rotate = [0, 0, 90] }]

[[collider]]
mesh = "sheet.obj"
animation = "sheet.pc2"
scale = 2
"#;

const SHEET: &str = "v -9 -9 -9\nv 9 -9 -9\nv 0 -9 9\nf 1 2 3\n";

/// Writes the files of [`SCENE`] to a folder, and returns the scene.
fn scene(folder: &Path, overrides: &[&str]) -> Scene {
    fs::write(folder.join("block.obj"), BLOCK).unwrap();
    fs::write(folder.join("sheet.obj"), SHEET).unwrap();
    fs::write(folder.join("sheet.pc2"), sheet_animation()).unwrap();
    let overrides: Vec<String> = overrides.iter().map(ToString::to_string).collect();
    Scene::parse(SCENE, "scene.toml", folder, &overrides).unwrap()
}

/// Returns a PC2 file of three samples, one a frame, in which the sheet rises by 1 a frame.
fn sheet_animation() -> Vec<u8> {
    let mut bytes = b"POINTCACHE2\0".to_vec();
    for word in [1, 3] {
        bytes.extend(i32::to_le_bytes(word));
    }
    for number in [0.0, 1.0] {
        bytes.extend(f32::to_le_bytes(number));
    }
    bytes.extend(i32::to_le_bytes(3));
    for rise in [0.0_f32, 1.0, 2.0] {
        let points = [[-9.0, -9.0 + rise, -9.0], [9.0, -9.0 + rise, -9.0], [0.0, -9.0 + rise, 9.0]];
        bytes.extend(points.iter().flatten().flat_map(|number| number.to_le_bytes()));
    }
    bytes
}

fn job(folder: &Path, out: &str, overrides: &[&str]) -> Job {
    Job::new(scene(folder, overrides), folder.join(out))
}

fn page(folder: &Path, out: &str) -> Vec<u8> {
    fs::read(folder.join(out).join("supple.html")).unwrap()
}

#[test]
fn every_position_of_a_page_is_that_of_the_frames_to_half_a_grid_step() {
    let folder = tempfile::tempdir().unwrap();
    let mut job = job(folder.path(), "out", &["output.format=[\"obj\", \"html\"]"]);
    job.start_frame = 100;
    job.every = 3;
    job.run(&mut ()).unwrap();
    let text = String::from_utf8(page(folder.path(), "out")).unwrap();
    let [run] = &runs(&text)[..] else { panic!("a page of a run has one run") };
    for (key, value) in [("first", 100), ("every", 3), ("frames", 5), ("fps", 24)] {
        assert_eq!(run.header[key].as_f64().unwrap(), f64::from(value), "{key}");
    }
    for (frame, sets) in run.sets.iter().enumerate() {
        for (body, name) in ["soft", "second"].into_iter().enumerate() {
            let path = folder.path().join(format!("out/{name}_{:04}.obj", 100 + 3 * frame));
            let mesh = Document::read(path).unwrap().part(None).unwrap().mesh().clone();
            let set = &sets[2 * body];
            assert_eq!(set.positions.len(), mesh.vertices().len());
            let mut extent = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
            // Frames contain the shortest text of numbers in f32.
            let numbers = mesh.vertices().iter().map(|vertex| vertex.map(|x| f64::from(x as f32)));
            for (position, vertex) in set.positions.iter().zip(numbers) {
                for axis in 0..3 {
                    // Half of a step, and the rounding of the sums in f64.
                    let bound = 0.5 * set.step[axis] + 1e-14;
                    assert!((position[axis] - vertex[axis]).abs() <= bound, "{name}, frame {frame}");
                    extent[0][axis] = extent[0][axis].min(vertex[axis]);
                    extent[1][axis] = extent[1][axis].max(vertex[axis]);
                }
            }
            for axis in 0..3 {
                let step = (extent[1][axis] - extent[0][axis]) / 65535.0;
                assert!((set.step[axis] - step).abs() <= 1e-15, "the grid is that of the body in the frame");
            }
        }
    }
    let ranges = |body: usize| run.volumes.iter().map(move |frame| frame[body][2] / frame[body][0]);
    assert!(ranges(0).all(|ratio| (ratio - 1.0).abs() < 1e-5), "the volume of the first body is preserved");
    assert!(ranges(1).any(|ratio| (ratio - 1.0).abs() > 1e-3), "that of the second body is not");
}

#[test]
fn a_page_has_lattices_and_the_poses_of_colliders() {
    let folder = tempfile::tempdir().unwrap();
    job(folder.path(), "out", &["output.format=html"]).run(&mut ()).unwrap();
    let run = runs(&String::from_utf8(page(folder.path(), "out")).unwrap()).remove(0);
    let shapes: Vec<&str> =
        run.header["colliders"].as_array().unwrap().iter().map(|c| c["shape"].as_str().unwrap()).collect();
    assert_eq!(shapes, ["plane", "sphere", "mesh"]);
    // The ball has half of its motion after half of the time; the plane is at rest.
    assert_eq!(run.poses[6][0], [0.0; 6]);
    for (value, expected) in run.poses[6][1].iter().zip([0.0, 0.3, 0.0, 0.0, 0.0, 45.0]) {
        assert!((value - expected).abs() < 1e-12, "{:?}", run.poses[6][1]);
    }
    // The sheet has twice the size of its file, and rises up to the third sample.
    let heights: Vec<f64> = run.sets.iter().map(|sets| sets[4].positions[0][1]).collect();
    assert_eq!(heights[..4], [-18.0, -16.0, -14.0, -14.0]);
    let lattice = run.header["bodies"][0]["lattice"].as_u64().unwrap() as usize;
    assert_eq!(run.sets[0][1].positions.len(), lattice);
    // The lattice covers the mesh.
    for axis in 0..3 {
        let range = |set: usize| {
            let values = run.sets[0][set].positions.iter().map(|position| position[axis]);
            values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)])
        };
        let ([low, high], [mesh_low, mesh_high]) = (range(1), range(0));
        let margin = run.sets[0][1].step[axis];
        assert!(low <= mesh_low + margin && high >= mesh_high - margin, "axis {axis}");
    }
}

#[test]
fn a_page_is_a_third_larger_than_its_packed_data_and_the_player() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = |frames: u32| {
        let frames = format!("simulation.frames={frames}");
        let out = format!("out{frames}");
        job(folder.path(), &out, &["output.format=html", &frames]).run(&mut ()).unwrap();
        let page = page(folder.path(), &out);
        let packed = runs(std::str::from_utf8(&page).unwrap())[0].compressed;
        (page.len() as f64, packed as f64)
    };
    let ((short, short_packed), (long, long_packed)) = (bytes(0), bytes(200));
    // The player is what remains of a page without its data.
    let player = short - 4.0 / 3.0 * short_packed;
    assert!(long <= 4.0 / 3.0 * long_packed + player + 64.0, "{long} bytes for {long_packed}");
    assert!(long_packed > 20.0 * short_packed, "the data have most of the size");
    assert!(player < 260e3, "{player}");
}

#[test]
fn stopped_killed_and_extended_runs_have_the_page_of_an_uninterrupted_run() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let formats = "output.format=[\"html\", \"pc2\"]";
    let mut whole = job(folder.path(), "whole", &[formats]);
    whole.checkpoint_interval = Duration::ZERO;
    // Copies of the run as it is after frames 4 and 5, with the data of a frame after the checkpoint.
    for frame in [0, 4, 5] {
        let to = at(&format!("killed{frame}"));
        whole.run(&mut CopyAfter { frame, from: at("whole"), to: to.clone() }).unwrap();
        assert!(to.join("supple.html.data").exists() && !to.join("supple.html").exists());
    }
    let expected = written(&at("whole"));
    assert_eq!(expected.keys().collect::<Vec<_>>(), ["second.pc2", "soft.pc2", "supple.html"]);

    let resumed = |out: &str, overrides: &[&str], observer: &mut dyn Observer| {
        let mut job = job(folder.path(), out, &[&[formats], overrides].concat());
        // The name in the page is that of the scene file, or of the directory.
        job.scene_file = Some(at("whole"));
        job.resume = true.into();
        job.verify = true;
        job.run(observer).unwrap()
    };
    for frame in [0, 4, 5] {
        let out = format!("killed{frame}");
        resumed(&out, &[], &mut ());
        assert!(written(&at(&out)) == expected, "killed after frame {frame}");
    }
    // Stopped twice: the page exists after each stop, and becomes data again.
    assert_eq!(resumed("stopped", &[], &mut StopAfter(3)).outcome, Outcome::Stopped);
    assert_eq!(runs(std::str::from_utf8(&page(folder.path(), "stopped")).unwrap())[0].sets.len(), 4);
    assert_eq!(resumed("stopped", &[], &mut StopAfter(7)).resumed_after, Some(3));
    assert_eq!(resumed("stopped", &[], &mut ()).resumed_after, Some(7));
    assert!(written(&at("stopped")) == expected);
    // Extended after its end, and killed between the page and the removal of its data.
    resumed("extended", &["simulation.frames=6"], &mut ());
    assert_eq!(resumed("extended", &[], &mut ()).resumed_after, Some(6));
    assert!(written(&at("extended")) == expected);
    let before = fs::metadata(at("extended/supple.html")).unwrap().modified().unwrap();
    assert_eq!(resumed("extended", &[], &mut ()).outcome, Outcome::AlreadyFinished);
    assert_eq!(fs::metadata(at("extended/supple.html")).unwrap().modified().unwrap(), before);
}

/// Replaces the colliders of the simulation after a frame.
struct NewColliders(Option<Arc<Mutex<Simulation>>>);

impl Observer for NewColliders {
    fn built(&mut self, simulation: &Arc<Mutex<Simulation>>, _: &[Input]) {
        self.0 = Some(simulation.clone());
    }

    fn frame(&mut self, progress: &Progress) -> Flow {
        let colliders = match progress.frame {
            2 => vec![Collider::sphere([0.0, -9.0, 0.0], 1.0)],
            4 => vec![Collider::sphere([0.0, -9.0, 0.0], 1.0); 5],
            _ => return Flow::Continue,
        };
        self.0.as_ref().unwrap().lock().unwrap().set_colliders(&colliders).unwrap();
        Flow::Continue
    }
}

#[test]
fn colliders_that_an_observer_replaces_do_not_change_the_layout() {
    let folder = tempfile::tempdir().unwrap();
    job(folder.path(), "out", &["output.format=html"]).run(&mut NewColliders(None)).unwrap();
    let run = runs(&String::from_utf8(page(folder.path(), "out")).unwrap()).remove(0);
    assert_eq!((run.sets.len(), run.header["colliders"].as_array().unwrap().len()), (13, 3));
    assert_ne!(run.poses[2][1], [0.0; 6]);
    assert!(run.poses[3..].iter().flatten().all(|pose| *pose == [0.0; 6]));
}

#[test]
fn a_run_whose_page_is_damaged_starts_again() {
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
    let path = folder.path().join("out/supple.html");
    let formats = "output.format=html";
    job(folder.path(), "out", &[formats, "simulation.frames=5"]).run(&mut ()).unwrap();
    let whole = fs::read(&path).unwrap();
    let run = |verify: bool| {
        let mut job = job(folder.path(), "out", &[formats, "simulation.frames=6"]);
        job.resume = true.into();
        job.verify = verify;
        let mut notes = Notes(Vec::new());
        job.run(&mut notes).unwrap();
        notes.0
    };
    let reason = |notes: Vec<Note>| match &notes[..] {
        [Note::Restarted { reason }] => reason.clone(),
        notes => panic!("{notes:?}"),
    };
    fs::remove_file(&path).unwrap();
    assert!(reason(run(false)).contains("it is missing"));
    for damaged in [&whole[..whole.len() / 2], &whole[..whole.len() - 9], b"<html></html>", b""] {
        job(folder.path(), "out", &[formats, "simulation.frames=5"]).run(&mut ()).unwrap();
        fs::write(&path, damaged).unwrap();
        assert!(reason(run(false)).contains("cannot continue"), "{} bytes", damaged.len());
        assert!(runs(&fs::read_to_string(&path).unwrap())[0].sets.len() == 7);
    }
    // The page of another run with the same bodies is found by its contents.
    job(folder.path(), "out", &[formats, "simulation.frames=5"]).run(&mut ()).unwrap();
    job(folder.path(), "other", &[formats, "simulation.frames=5", "simulation.gravity=[0, -1, 0]"])
        .run(&mut ())
        .unwrap();
    fs::copy(folder.path().join("other/supple.html"), &path).unwrap();
    assert!(reason(run(true)).contains("has changed since it was written"));
}

#[test]
fn joined_pages_have_the_data_of_each_run_and_their_names() {
    let folder = tempfile::tempdir().unwrap();
    for (out, overrides) in
        [("kept", &[][..]), ("plain", &["body.soft.volume=\"off\"", "simulation.frames=4"])]
    {
        job(folder.path(), out, &[overrides, &["output.format=html"]].concat()).run(&mut ()).unwrap();
    }
    let (kept, plain) = (folder.path().join("kept"), folder.path().join("plain/supple.html"));
    let joined = folder.path().join("side by side.html");
    let count = join(&[kept.clone(), plain.clone(), kept.clone()], &joined).unwrap();
    assert_eq!(count, 3);
    let text = fs::read_to_string(&joined).unwrap();
    let names: Vec<String> =
        runs(&text).iter().map(|run| run.header["name"].as_str().unwrap().to_owned()).collect();
    assert_eq!(names, ["kept", "plain", "kept (2)"]);
    for (index, source) in [&kept.join("supple.html"), &plain].into_iter().enumerate() {
        let [before, after] = [&fs::read_to_string(source).unwrap(), &text].map(|page| runs(page));
        let (before, after) = (&before[0], &after[index]);
        assert!(before.volumes == after.volumes && before.poses == after.poses);
        for (before, after) in before.sets.iter().flatten().zip(after.sets.iter().flatten()) {
            assert_eq!(before.positions, after.positions);
        }
        assert_eq!(before.sets.len(), after.sets.len());
    }
    // A page with several runs can be joined again; its runs keep their names.
    let again = folder.path().join("again.html");
    assert_eq!(join(&[joined.clone(), plain.clone()], &again).unwrap(), 4);
    // Four runs and the program.
    assert_eq!(data(&fs::read_to_string(&again).unwrap()).len(), 5);
    assert!(
        fs::read_to_string(&again)
            .unwrap()
            .contains("<title>kept · plain · kept (2) · plain (2) · supple</title>")
    );
}

#[test]
fn errors_of_joining_name_the_file_and_the_way_out() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::create_dir(at("empty")).unwrap();
    fs::write(at("other.html"), "<!doctype html><p>Hello</html>\n").unwrap();
    job(folder.path(), "out", &["output.format=html", "simulation.frames=1"]).run(&mut ()).unwrap();
    let refused = |input: &str, output: &str| {
        let error = join(&[at("out"), at(input)], &at(output)).unwrap_err();
        assert!(error.is_input() && !at("page.html").exists(), "{error}");
        error.to_string()
    };
    assert!(refused("missing", "page.html").contains("missing"));
    assert!(refused("empty", "page.html").contains("--format html"));
    assert!(refused("other.html", "page.html").contains("not a page of supple"));
    let before = page(folder.path(), "out");
    assert!(refused("out", "out/supple.html").contains("choose another name"));
    assert!(page(folder.path(), "out") == before);
    let error = join(&[at("out")], &at("none/page.html")).unwrap_err();
    assert!(matches!(error, PageError::Write { .. }) && !error.is_input(), "{error}");
}

#[test]
fn a_page_describes_its_runs_for_readers_without_scripts() {
    let folder = tempfile::tempdir().unwrap();
    let mut job = job(folder.path(), "out", &["output.format=html"]);
    job.scene_file = Some(folder.path().join("a <b> & \"c\".toml"));
    job.run(&mut ()).unwrap();
    let text = String::from_utf8(page(folder.path(), "out")).unwrap();
    for words in [
        "<title>a &lt;b&gt; &amp; &quot;c&quot; · supple</title>",
        "<p>2 bodies, 13 frames at 24 frames per second, 0.50 seconds.</p>",
        "<li>soft: volume from 100.00 % to 100.00 % of the volume at rest</li>",
        "aria-describedby=\"summary\"",
        "It needs JavaScript",
        "Permission is hereby granted",
    ] {
        assert!(text.contains(words), "{words}");
    }
    // Nothing is loaded from elsewhere.
    assert!(text.contains("default-src 'none'"));
    let markup: String = text
        .split("<script type=\"text/plain\"")
        .map(|part| part.split("</script>").last().unwrap())
        .collect();
    for words in ["src=\"", "href=\"http", "url(", "@import"] {
        assert!(!markup.contains(words), "{words}");
    }
}

#[test]
fn a_frame_writer_of_one_body_refuses_pages() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("supple.html"), "mine").unwrap();
    let mesh = supple::Mesh::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]]).unwrap();
    let sequence = Sequence {
        directory: folder.path().to_owned(),
        name: "supple".into(),
        format: Format::Html,
        first: 0,
        every: 1,
        last: 2,
    };
    let error = FrameWriter::create(sequence, Source::Mesh(&mesh)).unwrap_err();
    assert!(matches!(error, OutputError::NotPerBody { .. }) && error.is_input());
    assert_eq!(fs::read_to_string(folder.path().join("supple.html")).unwrap(), "mine");
}
