//! Tests the study of a small scene: figures, files, stopping and resuming.

use std::fs;

use supple_io::run::{Flow, prepare};
use supple_io::scene::Scene;
use supple_study::{Axis, Front, Observer, Outcome, Point, Progress, Report, Study, StudyError};
use tempfile::TempDir;

/// OBJ text of a closed block of 2 x 3 x 1 scene units.
const BLOCK: &str = include_str!("block.obj");

/// A block that is pinned at one side above the ground and pulled at the opposite side. Both sides are
/// released at 0.2 s, and the block falls.
const SCENE: &str = r#"
[simulation]
frames = 12
fps = 30
substeps = 4

[[body]]
name = "block"
mesh = "block.obj"
translate = [0, 0.4, 0]
rotate = [0, 20, 10]
lattice_vertices = 100
half_width = 2
stiffness = 0.6
region_damping = 0.05
spin = [1, 2, 3]

[[body.pin]]
box = { min = [-9, -9, -9], max = [-0.7, 9, 9] }
end = 0.2

[[body.handle]]
box = { min = [0.7, -9, -9], max = [9, 9, 9] }
keys = [ { time = 0 }, { time = 0.2, translate = [0.3, 0.1, 0], rotate = [0, 0, 10] } ]
end = 0.2

[[collider]]
plane = { point = [0, 0, 0], normal = [0, 1, 0] }
"#;

/// Rounding error of the goal positions in cells. The numbers of a body of 8 to 16 cells have a spacing of 2^-20 in
/// f32. A goal position is the sum of a center and a rotated arm, each rounded a few times: four spacings.
const GOAL_ROUNDING: f64 = 4e-6;
/// Rounding error of a path in cells: in 48 steps of a damped motion, five times that of the goal positions.
const PATH_ROUNDING: f64 = 2e-5;

/// Creates a temporary directory with the scene, and a study of the scene.
fn small_study() -> (TempDir, Study) {
    let temporary = tempfile::tempdir().unwrap();
    fs::write(temporary.path().join("block.obj"), BLOCK).unwrap();
    let scene = Scene::parse(SCENE, "scene.toml", temporary.path(), &[]).unwrap();
    let directory = temporary.path().join("out");
    (temporary, Study { scene, name: "scene.toml".to_owned(), directory, quick: true, resume: false })
}

/// Requests a stop when `points` points have been measured and the next one begins.
struct StopsAfter {
    points: usize,
    last: String,
}

impl Observer for StopsAfter {
    fn progress(&mut self, progress: &Progress<'_>) -> Flow {
        assert!((0.0..=1.0).contains(&progress.done));
        if progress.point != self.last {
            self.last = progress.point.to_owned();
            if self.points == 0 {
                return Flow::Stop;
            }
            self.points -= 1;
        }
        Flow::Continue
    }
}

/// Returns the points on an axis.
fn on(report: &Report, axis: Axis) -> Vec<&Point> {
    report.points.iter().filter(|point| point.axis == axis).collect()
}

#[test]
fn figures_satisfy_their_bounds() {
    let (_directory, study) = small_study();
    let (report, outcome) = study.run(&mut ()).unwrap();
    assert_eq!(outcome, Outcome::Finished);
    let base = on(&report, Axis::Base)[0];
    assert_eq!((base.method.as_str(), base.half_width.cells(), base.substeps), ("mesh global", 2.0, 4));
    assert!((base.alpha - 0.6).abs() < 1e-12);
    assert_eq!(report.points.iter().filter(|point| point.finest).count(), 1);
    for point in &report.points {
        let Point { name, errors, timing, .. } = point;
        assert!(timing.samples.iter().all(|sample| sample.total() > 0.0), "{name}");
        assert_eq!(timing.warm_up.is_some(), point.sums == "fast");
        // Only the measure `mesh` preserves the volume of the mesh to rounding.
        let volume = errors.mesh_volume.unwrap();
        match point.method.starts_with("mesh") && errors.capped == 0 {
            true => assert!(volume < 1e-6, "{name}: {volume:e}"),
            false => assert!(volume > 1e-4, "{name}: {volume:e}"),
        }
        assert!(errors.surface_hausdorff >= Some(0.0) && errors.surface_hausdorff < Some(0.3), "{name}");
        assert_eq!(errors.surface_rms == Some(0.0), point.finest, "{name}");
        let path = errors.path.unwrap();
        assert_eq!(path.frames, report.frames);
        let (goals, path) = (errors.goals.unwrap(), path.distances);
        // In a block, staircase and breadth-first regions are equal.
        let bounds = if point.sums == "fast" { [GOAL_ROUNDING, PATH_ROUNDING] } else { [0.0, 0.0] };
        assert!(goals.max_cells <= bounds[0] && path.max_cells <= bounds[1], "{name}: {goals:?} {path:?}");
        if let Some(free) = &point.free {
            assert!(free.linear_momentum < 1e-6 && free.angular_momentum < 1e-6, "{name}: {free:?}");
            assert!(free.energy_gain < Some(0.1) && free.energy_loss < Some(0.1), "{name}: {free:?}");
        }
    }
    // The integrator is of second order, so twice as many steps give approximately a quarter of the energy
    // change.
    let change = |point: &Point| {
        let free = point.free.as_ref().unwrap();
        free.energy_gain.unwrap() + free.energy_loss.unwrap()
    };
    let more_steps = on(&report, Axis::Substeps).into_iter().find(|point| point.substeps == 8).unwrap();
    let ratio = change(base) / change(more_steps);
    assert!((2.5..6.0).contains(&ratio), "{ratio}");
}

#[test]
fn goals_and_paths_of_partly_filled_lattices_agree_while_constraints_begin_and_end() {
    let (directory, mut study) = small_study();
    let scene = SCENE
        .replace("half_width = 2\nstiffness = 0.6", "material = \"rubber\"")
        .replace("lattice_vertices = 100", "cell_size = 0.43")
        .replace("time = 0 }, {", "time = 0.1 }, {")
        .replace("end = 0.2\n\n[[collider]]", "start = 0.1\nend = 0.3\n\n[[collider]]");
    assert_eq!(scene.matches("0.1 }, {").count() + scene.matches("start = 0.1").count(), 2);
    study.scene = Scene::parse(&scene, "scene.toml", directory.path(), &[]).unwrap();
    let prepared = prepare(&study.scene).unwrap();
    let body = prepared.simulation.body(0);
    let full_cell = body.material().density * body.lattice().cell_size().powi(3);
    let masses = body.masses();
    let mut vertices = masses.iter().zip(body.lattice().occupied_cells());
    assert!(vertices.any(|(mass, &cells)| mass / full_cell < 0.9 * f64::from(cells) / 8.0));
    let (report, _) = study.run(&mut StopsAfter { points: 3, last: String::new() }).unwrap();
    assert!(!report.points.is_empty());
    for point in &report.points {
        let (goals, path) = (point.errors.goals.unwrap(), point.errors.path.unwrap());
        assert_eq!(path.frames, report.frames);
        let is_rounding = goals.max_cells <= GOAL_ROUNDING && path.distances.max_cells <= PATH_ROUNDING;
        assert!(is_rounding, "{}: {goals:?} {path:?}", point.name);
    }
}

#[test]
fn scenes_with_an_open_mesh_preserve_the_volume_of_the_cells() {
    let (directory, mut study) = small_study();
    let open: String =
        BLOCK.lines().filter(|line| *line != "f 4 3 2 1").map(|line| format!("{line}\n")).collect();
    fs::write(directory.path().join("open.obj"), open).unwrap();
    let second =
        "[[body]]\nname = \"open\"\nmesh = \"open.obj\"\ntranslate = [9, 1, 0]\nlattice_vertices = 40\n";
    study.scene = Scene::parse(&(SCENE.to_owned() + second), "scene.toml", directory.path(), &[]).unwrap();
    study.scene.simulation.frames = 3;
    assert!(matches!(study.run(&mut ()), Err(StudyError::BodyContact)));
    study.scene.simulation.contact = false;
    let (report, outcome) = study.run(&mut ()).unwrap();
    assert_eq!((outcome, report.method.as_str()), (Outcome::Finished, "cells global"));
    assert!(report.points.iter().all(|point| point.errors.mesh_volume.is_none()));
    let base = on(&report, Axis::Base)[0];
    assert!(base.errors.cells_volume.unwrap() < 1e-6);
}

#[test]
fn fronts_contain_exactly_the_points_that_are_not_dominated() {
    let (_directory, study) = small_study();
    let (report, _) = study.run(&mut ()).unwrap();
    for front in Front::ALL {
        let costs = |point: &Point| Some([point.timing.total.median, front.error(point)?]);
        let candidates: Vec<&Point> = report
            .points
            .iter()
            .filter(|point| point.region_factor == 1.0 && !point.softened && costs(point).is_some())
            .filter(|point| front != Front::Path || point.method == report.method)
            .collect();
        assert!(!candidates.is_empty());
        for point in &report.points {
            let candidate = candidates.iter().any(|other| other.name == point.name);
            let dominated = candidates.iter().any(|other| {
                let (a, b) = (costs(other).unwrap(), costs(point).unwrap_or([0.0; 2]));
                a[0] <= b[0] && a[1] <= b[1] && a != b
            });
            assert_eq!(point.front.contains(&front), candidate && !dominated, "{}: {front:?}", point.name);
        }
    }
}

#[test]
fn files_contain_all_points_and_the_table_fits_80_columns() {
    let (_directory, study) = small_study();
    let (report, _) = study.run(&mut ()).unwrap();
    let read = |name: &str| fs::read_to_string(study.directory.join(name)).unwrap();
    assert_eq!(serde_json::from_str::<Report>(&read("study.json")).unwrap(), report);
    assert_eq!(read("study.csv").lines().count(), report.points.len() + 1);
    let svg = read("study.svg");
    assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"));
    for words in ["scene.toml: error against run time", "run time of a frame, ms", "mesh regional", "front"] {
        assert!(svg.contains(words), "{words}");
    }
    let table = report.table();
    assert!(table.lines().all(|line| line.chars().count() <= 80), "{table}");
    let mut files: Vec<_> =
        fs::read_dir(&study.directory).unwrap().map(|file| file.unwrap().file_name()).collect();
    files.sort();
    assert_eq!(files, ["study.csv", "study.json", "study.svg"]);
}

#[test]
fn a_resumed_study_gives_the_same_errors_as_an_uninterrupted_one() {
    let (_directory, mut study) = small_study();
    let (whole, _) = study.run(&mut ()).unwrap();
    let (_other_directory, stopped) = small_study();
    study.directory = stopped.directory.clone();
    let (part, outcome) = study.run(&mut StopsAfter { points: 5, last: String::new() }).unwrap();
    assert_eq!((outcome, part.points.len(), part.complete), (Outcome::Stopped, 4, false));
    assert!(study.directory.join("study.svg").exists());
    study.resume = true;
    let (resumed, outcome) = study.run(&mut ()).unwrap();
    assert_eq!((outcome, resumed.complete), (Outcome::Finished, true));
    assert_eq!(resumed.points[..4].iter().map(|point| &point.timing).collect::<Vec<_>>(), {
        part.points.iter().map(|point| &point.timing).collect::<Vec<_>>()
    });
    let errors = |report: &Report| -> Vec<_> {
        report
            .points
            .iter()
            .map(|point| (point.name.clone(), point.errors.clone(), point.free.clone()))
            .collect()
    };
    assert_eq!(errors(&resumed), errors(&whole));

    let before = fs::read(study.directory.join("study.json")).unwrap();
    let (_, outcome) = study.run(&mut ()).unwrap();
    assert_eq!(outcome, Outcome::AlreadyFinished);
    assert_eq!(fs::read(study.directory.join("study.json")).unwrap(), before);
}

#[test]
fn resuming_a_different_study_is_refused() {
    let (_directory, mut study) = small_study();
    let stop = || StopsAfter { points: 1, last: String::new() };
    study.run(&mut stop()).unwrap();
    study.resume = true;
    let refused = |study: &Study, words: &str| {
        let error = study.run(&mut ()).unwrap_err();
        assert!(error.is_input() && matches!(error, StudyError::Resume { .. }), "{error}");
        assert!(error.to_string().contains(words), "{error}");
    };
    let change = |change: &dyn Fn(&mut Study)| {
        let mut other = study.clone();
        change(&mut other);
        other
    };
    refused(&change(&|study| study.quick = false), "quick");
    refused(&change(&|study| study.scene.simulation.frames = 13), "frames");
    refused(&change(&|study| study.scene.bodies[0].material.density = 7.0), "density");
    fs::write(study.directory.join("study.json"), "[]").unwrap();
    refused(&study, "not a study");
    study.scene.simulation.frames = 0;
    assert!(matches!(study.run(&mut ()), Err(StudyError::NoFrames)));
}

/// Returns the small study with a line added to its body.
fn study_with(line: &str) -> (TempDir, Study) {
    let (directory, mut study) = small_study();
    let text = SCENE.replacen("half_width = 2\n", &format!("half_width = 2\n{line}\n"), 1);
    study.scene = Scene::parse(&text, "scene.toml", directory.path(), &[]).unwrap();
    (directory, study)
}

/// Runs a study up to the point of the unchanged scene, and returns its report and this point.
fn base(study: &Study) -> (Report, Point) {
    let (report, _) = study.run(&mut StopsAfter { points: 2, last: String::new() }).unwrap();
    let base = on(&report, Axis::Base)[0].clone();
    (report, base)
}

/// The naive sums have plastic shapes of their own, which flow by the same law.
#[test]
fn the_path_of_a_plastic_body_is_that_of_the_naive_sums() {
    let (_directory, elastic) = small_study();
    let (_other_directory, plastic) = study_with("plastic = { yield = 0.02, creep = 30 }");
    let [elastic, plastic] = [elastic, plastic].map(|study| base(&study).1.errors.path.unwrap());
    assert_eq!(plastic.frames, 12);
    assert!(elastic.distances.max_cells < PATH_ROUNDING, "{elastic:?}");
    // The factor of the strain beyond the yield strain amplifies rounding.
    assert!(plastic.distances.max_cells < 10.0 * PATH_ROUNDING, "{plastic:?}");
}

#[test]
fn a_body_that_can_break_stays_whole_in_a_study() {
    let (_directory, whole) = small_study();
    let (_other_directory, study) = study_with("fracture = { strain = 1e-3 }");
    // The scene itself breaks.
    let mut prepared = prepare(&study.scene).unwrap();
    prepared.simulation.steps(24);
    assert!(prepared.simulation.bodies()[0].broken_joints() > 0);
    let (expected, mut point) = base(&whole);
    let (report, found) = base(&study);
    assert_eq!(report.kept_whole, ["block"]);
    point.timing = found.timing.clone();
    point.front.clone_from(&found.front);
    assert_eq!(found, point);
    assert!(report.table().contains("leaves out [body.fracture]"), "{}", report.table());
    assert!(report.table().lines().all(|line| line.chars().count() <= 80));
    assert!(expected.kept_whole.is_empty() && !expected.table().contains("[body.fracture]"));
}

#[test]
fn a_frame_with_two_capped_bodies_counts_once() {
    let (directory, mut study) = small_study();
    let second = "[[body]]\nname = \"other\"\nmesh = \"block.obj\"\ntranslate = [9, 1, 0]\nspin = [3, 2, 1]\n\
                  lattice_vertices = 40\n";
    study.scene = Scene::parse(&(SCENE.to_owned() + second), "scene.toml", directory.path(), &[]).unwrap();
    study.scene.simulation.frames = 3;
    study.scene.simulation.contact = false;
    for body in &mut study.scene.bodies {
        body.volume.max_correction = 1e-9;
    }
    // The two points that the observer sees are the finest lattice and the unchanged scene; only the latter
    // is reported.
    let (report, _) = study.run(&mut StopsAfter { points: 2, last: String::new() }).unwrap();
    assert_eq!(report.points.iter().map(|point| point.errors.capped).collect::<Vec<_>>(), [3]);
}

#[test]
fn a_point_that_cannot_be_built_is_not_an_input_error() {
    let (_directory, mut study) = small_study();
    // Vertex 90 exists in the lattice of the scene, but not in the coarser lattice.
    let vertices = supple::Selection::Vertices(vec![90]);
    study.scene.bodies[0].pins[0].selection = vertices;
    let error = study.run(&mut ()).unwrap_err();
    assert!(matches!(error, StudyError::AfterStart { .. }) && !error.is_input(), "{error}");
    let path = study.directory.join("study.json");
    assert!(error.to_string().contains(&path.display().to_string()), "{error}");
    let report: Report = serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap();
    assert!(!report.complete && !report.points.is_empty());
    // An invalid scene is refused before anything is written.
    let (_directory, mut study) = small_study();
    study.scene.bodies[0].material.density = -1.0;
    assert!(study.run(&mut ()).unwrap_err().is_input() && !study.directory.exists());
}
