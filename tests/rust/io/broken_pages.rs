//! Pages of bodies that break: their data are those of the other frames, and runs resume to the same bytes in the
//! middle of a crack.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::time::Duration;

use nalgebra::Vector3;
use supple::{Body, BreakLimit, FractureOptions, Simulation};
use supple_io::obj::Document;
use supple_io::pages::join;
use supple_io::run::{Job, Note, Observer, Outcome, Recording, RecordingOptions};
use supple_io::scene::Scene;

use crate::page_reader::{PagePieces, PageRun, runs};
use crate::piece_frames::{bar, faces, numbers};
use crate::run_files::{CopyAfter, StopAfter, written};

/// A bar that is pulled apart beside one that is at rest.
const SCENE: &str = r#"
[simulation]
frames = 14
gravity = [0, 0, 0]

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
keys = [{ time = 0.1 }, { time = 0.6, translate = [2, 0.5, 0] }]
"#;

/// The last frame of the scene.
const LAST: usize = 14;

/// Index of the bar that breaks, and of the sets of its mesh and its lattice.
const BAR: usize = 1;
const SETS: [usize; 2] = [2, 3];

fn job(folder: &Path, directory: &str, overrides: &[&str]) -> Job {
    fs::write(folder.join("bar.obj"), bar()).unwrap();
    let overrides: Vec<String> = overrides.iter().map(ToString::to_string).collect();
    let scene = Scene::parse(SCENE, "scene.toml", folder, &overrides).unwrap();
    let mut job = Job::new(scene, folder.join(directory));
    // The name in the page is that of the scene file.
    job.scene_file = Some(folder.join("scene.toml"));
    job
}

fn page(directory: &Path) -> PageRun {
    let page = fs::read_to_string(directory.join("supple.html")).unwrap();
    runs(&page).pop().unwrap()
}

/// Returns the pieces of a body of a run, in all frames.
fn pieces(run: &PageRun, body: usize) -> Vec<Option<&PagePieces>> {
    run.pieces.iter().map(|frame| frame[body].as_deref()).collect()
}

/// Returns the number of connected components of a graph.
fn components(points: usize, links: &[[u32; 2]]) -> usize {
    let mut first: Vec<usize> = (0..points).collect();
    let root = |first: &[usize], mut point: usize| {
        while first[point] != point {
            point = first[point];
        }
        point
    };
    for link in links {
        let [a, b] = link.map(|point| root(&first, point as usize));
        first[a.max(b)] = a.min(b);
    }
    (0..points).filter(|&point| first[point] == point).count()
}

/// Returns a face that begins at its lowest corner.
fn turned(mut face: Vec<u32>) -> Vec<u32> {
    let lowest = (0..face.len()).min_by_key(|&corner| face[corner]).unwrap();
    face.rotate_left(lowest);
    face
}

#[test]
fn a_page_has_the_faces_and_positions_of_the_obj_frames_of_a_body_that_breaks() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    job(folder.path(), "out", &[r#"output.format=["obj", "html"]"#]).run(&mut ()).unwrap();
    let run = page(&out);
    assert_eq!(run.header["version"], 2);
    assert!(pieces(&run, 0).iter().all(Option::is_none), "the other bar is whole");
    let of_bar = pieces(&run, BAR);
    assert!(of_bar[0].is_none() && of_bar[LAST].is_some());
    let topologies = of_bar.windows(2).filter(|pair| pair[0] != pair[1]).count();
    assert!(topologies >= 2, "the crack grows over several frames, not {topologies}");
    let whole = Document::from_bytes("bar.obj", bar().into()).unwrap().mesh(None).unwrap();
    for (frame, (sets, of_bar)) in run.sets.iter().zip(&of_bar).enumerate() {
        let text = fs::read_to_string(out.join(format!("bar_{frame:04}.obj"))).unwrap();
        let vertices = numbers(&text, "v");
        let set = &sets[SETS[0]];
        assert_eq!(set.positions.len(), vertices.len(), "frame {frame}");
        for (position, vertex) in set.positions.iter().zip(&vertices) {
            for axis in 0..3 {
                // The digits are those of an f32. Half of a step, and the rounding of the sums in f64.
                let (expected, bound) = (f64::from(vertex[axis] as f32), 0.5 * set.step[axis] + 1e-14);
                assert!((position[axis] - expected).abs() <= bound, "frame {frame}");
            }
        }
        let Some(of_bar) = of_bar else {
            assert_eq!(vertices.len(), whole.vertices().len());
            continue;
        };
        assert_eq!(of_bar.points, SETS.map(|set| sets[set].positions.len()));
        let caps = of_bar.faces.len() - of_bar.sources.len();
        assert!(caps > 0);
        for is_cap in [false, true] {
            let expected: BTreeSet<Vec<u32>> = faces(&text)
                .into_iter()
                .filter(|(_, material)| (material == "bar_cap") == is_cap)
                .map(|(corners, _)| turned(corners.iter().map(|corner| corner[0].unwrap() as u32).collect()))
                .collect();
            let (of_whole, of_caps) = of_bar.faces.split_at(of_bar.sources.len());
            let found: BTreeSet<Vec<u32>> =
                if is_cap { of_caps } else { of_whole }.iter().cloned().map(turned).collect();
            assert_eq!(found, expected, "frame {frame}, caps: {is_cap}");
        }
        // All corners of a part lie at rest in the plane of its face of the whole bar, so that its input vertices do.
        let rest = whole.vertices();
        for (face, &source) in of_bar.faces.iter().zip(&of_bar.sources) {
            let of_whole: Vec<Vector3<f64>> = whole
                .faces()
                .nth(source as usize)
                .unwrap()
                .iter()
                .map(|&v| rest[v as usize].coords)
                .collect();
            let normal = (of_whole[1] - of_whole[0]).cross(&(of_whole[2] - of_whole[0]));
            for &corner in face.iter().filter(|&&corner| (corner as usize) < rest.len()) {
                assert_eq!(normal.dot(&(rest[corner as usize].coords - of_whole[0])), 0.0, "frame {frame}");
            }
        }
        // The first vertex at a position is an earlier one at the same position.
        for (vertex, &first) in of_bar.weld.iter().enumerate() {
            assert!(first as usize <= vertex && vertices[first as usize] == vertices[vertex]);
        }
    }
}

#[test]
fn the_lattice_of_a_page_comes_apart_with_its_body() {
    let folder = tempfile::tempdir().unwrap();
    job(folder.path(), "out", &["output.format=html"]).run(&mut ()).unwrap();
    let run = page(&folder.path().join("out"));
    let of_bar = pieces(&run, BAR);
    let last = of_bar[LAST].unwrap();
    let edges = last.faces.iter().flat_map(|face| face.windows(2).map(|edge| [edge[0], edge[1]]));
    let welds = last.weld.iter().enumerate().map(|(vertex, &first)| [vertex as u32, first]);
    let edges: Vec<[u32; 2]> = edges.chain(welds).collect();
    let count = components(last.points[1], &last.links);
    assert!(count >= 2 && count == components(last.points[0], &edges), "{count}");
    let first = of_bar.iter().flatten().next().unwrap();
    assert_eq!(components(first.points[1], &first.links), 1, "the crack has not passed through the bar");
    assert!(first.points[1] < last.points[1] && first.links.len() < last.links.len());
    // No link spans the gap between the pieces, which is wider than three cells.
    let lattice = &run.sets[LAST][SETS[1]].positions;
    let length = |link: &[u32; 2]| {
        let [a, b] = link.map(|vertex| Vector3::from(lattice[vertex as usize]));
        (b - a).norm()
    };
    let longest = last.links.iter().map(length).fold(0.0, f64::max);
    assert!(longest < 0.5, "{longest}");
}

#[test]
fn runs_resume_in_the_middle_of_a_crack_to_the_same_page() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let format = "output.format=html";
    let mut whole = job(folder.path(), "whole", &[format]);
    whole.checkpoint_interval = Duration::ZERO;
    whole.run(&mut ()).unwrap();
    let expected = written(&at("whole"));
    let run = page(&at("whole"));
    let of_bar = pieces(&run, BAR);
    // The frames before and in which the body breaks, its crack grows, and it is broken as in the frame before.
    let breaks = of_bar.iter().position(Option::is_some).unwrap();
    let still = (breaks + 1..LAST).find(|&frame| of_bar[frame] == of_bar[frame - 1]).unwrap();
    assert!(still > breaks + 1, "the crack grows");

    let resumed = |out: &str, observer: &mut dyn Observer| {
        let mut job = job(folder.path(), out, &[format]);
        job.resume = true.into();
        job.verify = true;
        job.run(observer).unwrap()
    };
    for frame in [breaks - 1, breaks, still] {
        // Killed: the data have this frame, and the checkpoint is that of the frame before.
        let out = format!("killed{frame}");
        let frame = frame as u32;
        let mut killed = job(folder.path(), "source", &[format]);
        killed.checkpoint_interval = Duration::ZERO;
        killed.run(&mut CopyAfter { frame, from: at("source"), to: at(&out) }).unwrap();
        assert_eq!(resumed(&out, &mut ()).resumed_after, frame.checked_sub(1));
        assert!(written(&at(&out)) == expected, "killed after frame {frame}");
        // Stopped: the page becomes data again.
        let out = format!("stopped{frame}");
        assert_eq!(resumed(&out, &mut StopAfter(frame)).outcome, Outcome::Stopped);
        let of_bar = page(&at(&out));
        assert_eq!(of_bar.header["version"], if (frame as usize) < breaks { 1 } else { 2 });
        assert_eq!(resumed(&out, &mut ()).resumed_after, Some(frame));
        assert!(written(&at(&out)) == expected, "stopped after frame {frame}");
    }
}

/// Returns the reason why a run starts again.
#[derive(Default)]
struct Restart(Option<String>);

impl Observer for Restart {
    fn note(&mut self, note: &Note) {
        if let Note::Restarted { reason } = note {
            self.0 = Some(reason.clone());
        }
    }
}

#[test]
fn a_run_whose_data_with_pieces_are_damaged_starts_again() {
    let folder = tempfile::tempdir().unwrap();
    let (out, data) = (folder.path().join("out"), folder.path().join("out/supple.html.data"));
    let mut whole = job(folder.path(), "source", &["output.format=html"]);
    whole.checkpoint_interval = Duration::ZERO;
    whole.run(&mut CopyAfter { frame: 12, from: folder.path().join("source"), to: out.clone() }).unwrap();
    let (kept, checkpoint) = (fs::read(&data).unwrap(), fs::read(out.join("supple.checkpoint")).unwrap());
    let expected = fs::read(folder.path().join("source/supple.html")).unwrap();
    let sizes: Vec<usize> = {
        let start = 16 + u64::from_le_bytes(kept[8..16].try_into().unwrap()) as usize;
        let size = |at: usize| u64::from_le_bytes(kept[at..at + 8].try_into().unwrap()) as usize;
        let next = |&at: &usize| (at < kept.len()).then(|| at + 8 + size(at));
        std::iter::successors(Some(start), next).collect()
    };
    assert_eq!((sizes.len(), sizes[13]), (14, kept.len()), "the data are 13 frames");
    let check = |bytes: &[u8], verify: bool, words: &str| {
        fs::write(&data, bytes).unwrap();
        fs::write(out.join("supple.checkpoint"), &checkpoint).unwrap();
        let mut job = job(folder.path(), "out", &["output.format=html"]);
        (job.resume, job.verify) = (true.into(), verify);
        let mut restart = Restart::default();
        job.run(&mut restart).unwrap();
        let reason = restart.0.unwrap();
        assert!(reason.contains(words), "{reason}");
        assert!(fs::read(out.join("supple.html")).unwrap() == expected);
    };
    check(&kept[..sizes[11] + 20], false, "it has 11 of 12 frames to keep");
    let mut changed = kept.clone();
    changed[sizes[10]] ^= 1;
    check(&changed, false, "frame 10 has");
    let mut changed = kept.clone();
    changed[sizes[11] + 500] ^= 1;
    check(&changed, true, "frame 11 of");
    let mut changed = kept.clone();
    changed[7] ^= 1;
    check(&changed, false, "its beginning is incomplete or was changed");
}

#[test]
fn joined_pages_have_runs_with_and_without_pieces() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    job(folder.path(), "broken", &["output.format=html"]).run(&mut ()).unwrap();
    let strong = "body.bar.fracture.strain=9";
    job(folder.path(), "whole", &["output.format=html", strong]).run(&mut ()).unwrap();
    let joined = at("joined.html");
    assert_eq!(join(&[at("broken"), at("whole"), at("broken")], &joined).unwrap(), 3);
    let joined = runs(&fs::read_to_string(&joined).unwrap());
    for (index, source) in ["broken", "whole", "broken"].into_iter().enumerate() {
        let (before, after) = (page(&at(source)), &joined[index]);
        assert_eq!(before.header["version"], if source == "whole" { 1 } else { 2 });
        assert_eq!(before.header["version"], after.header["version"]);
        assert_eq!((&before.volumes, &before.pieces), (&after.volumes, &after.pieces));
        assert_eq!(before.sets.len(), after.sets.len());
        for (before, after) in before.sets.iter().flatten().zip(after.sets.iter().flatten()) {
            assert_eq!(before.positions, after.positions);
        }
    }
}

#[test]
fn a_recording_shows_the_pieces_of_each_frame_also_when_states_are_restored() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = Document::from_bytes("bar.obj", bar().into()).unwrap().mesh(None).unwrap();
    let limit = FractureOptions::new(BreakLimit::Strain(9.0));
    let body = Body::builder(mesh).name("bar").cell_size(0.25).fracture(limit).build().unwrap();
    let mut simulation = Simulation::builder().body(body).build().unwrap();
    let whole = simulation.state();
    let cut = |simulation: &mut Simulation, x: f64| {
        simulation.body_mut(0).cut([x, 0.5, 0.5], [1.0, 0.2, 0.0]).unwrap();
    };
    let record = |simulation: &mut Simulation, path: &Path, changes: &[Option<f64>]| -> PageRun {
        let mut recording = Recording::create(path, simulation, &RecordingOptions::default()).unwrap();
        recording.write(simulation).unwrap();
        for change in changes {
            match *change {
                Some(x) => cut(simulation, x),
                None => simulation.restore(&whole).unwrap(),
            }
            recording.write(simulation).unwrap();
        }
        recording.finish().unwrap();
        runs(&fs::read_to_string(path).unwrap()).pop().unwrap()
    };
    // Whole, cut, whole, cut elsewhere, cut again; the two cuts have the same number of events.
    let path = folder.path().join("a.html");
    let run = record(&mut simulation, &path, &[Some(1.1), None, Some(2.9), Some(1.1)]);
    let of_bar = pieces(&run, 0);
    let count = |pieces: Option<&PagePieces>| pieces.map_or(1, |p| components(p.points[1], &p.links));
    assert_eq!(of_bar.iter().map(|pieces| count(*pieces)).collect::<Vec<_>>(), [1, 2, 1, 2, 3]);
    assert!(of_bar[1].is_some() && of_bar[1] != of_bar[3]);
    // Restored and cut elsewhere between two frames.
    let path = folder.path().join("b.html");
    let mut recording = {
        simulation.restore(&whole).unwrap();
        cut(&mut simulation, 1.1);
        Recording::create(&path, &simulation, &RecordingOptions::default()).unwrap()
    };
    recording.write(&simulation).unwrap();
    let version = simulation.body(0).topology_version();
    simulation.restore(&whole).unwrap();
    cut(&mut simulation, 2.9);
    assert_eq!(simulation.body(0).topology_version(), version);
    recording.write(&simulation).unwrap();
    recording.finish().unwrap();
    let later = runs(&fs::read_to_string(&path).unwrap()).pop().unwrap();
    assert_eq!(pieces(&later, 0), [of_bar[1], of_bar[3]]);
    // The description is that of the whole body, though the body was broken when the recording began.
    for key in ["surfaces", "bodies", "arrays"] {
        assert_eq!(later.header[key], run.header[key], "{key}");
    }
}
