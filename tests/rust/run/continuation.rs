//! Jobs that continue from a kept state with a changed scene: they have the frames of a simulation in which the state is
//! restored and the setting is changed.

use std::path::Path;

use supple::{Key, Simulation, Substeps};
use supple_io::run::{Job, prepare};
use supple_io::scene::Scene;

use crate::cube;

const SCENE: &str = r#"
[simulation]
frames = 10
substeps = 3

[output]
format = "ply"
states = 4

[[body]]
name = "cube"
mesh = "cube.obj"
translate = [0, 0.1, 0]
lattice_vertices = 64
half_width = 1

[[body.handle]]
plane = { point = [0.1, 0, 0], normal = [-1, 0, 0] }
start = 0.05
keys = [ { time = 0.05 }, { time = 0.25, translate = [0, 0.3, 0.2] } ]

[[collider]]
plane = { point = [0, 0, 0], normal = [0, 1, 0] }
"#;

fn scene(folder: &Path, overrides: &[&str]) -> Scene {
    cube::scene(SCENE, folder, overrides)
}

/// Checks that a job that continues after frame 4 with an override has the frames of a simulation that is changed after
/// frame 4.
fn check(change: &str, apply: impl FnOnce(&mut Simulation)) {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    Job::new(scene(folder.path(), &[]), &out).run(&mut ()).unwrap();
    let mut job = Job::new(scene(folder.path(), &[change]), &out);
    job.from = Some(6);
    assert_eq!(job.run(&mut ()).unwrap().resumed_after, Some(4));

    let mut simulation = prepare(&scene(folder.path(), &[])).unwrap().simulation;
    simulation.advance(4);
    apply(&mut simulation);
    for frame in 5..=10 {
        simulation.advance(1);
        let surface = simulation.body(0).surface().positions;
        let bytes =
            |point: &nalgebra::Point3<f64>| [point.x, point.y, point.z].map(|x| (x as f32).to_le_bytes());
        let expected: Vec<u8> = surface.iter().flat_map(bytes).flatten().collect();
        let ply = std::fs::read(out.join(format!("cube_{frame:04}.ply"))).unwrap();
        let header = ply.windows(11).position(|bytes| bytes == b"end_header\n").unwrap() + 11;
        // Positions and normals alternate.
        let points: Vec<u8> =
            ply[header..].chunks_exact(24).take(8).flat_map(|point| point[..12].to_vec()).collect();
        assert!(points == expected, "{change}: frame {frame}");
    }
}

#[test]
fn a_changed_handle_moves_from_the_captured_positions() {
    let keys = [(0.05, [0.0; 3]), (0.2, [0.0, 0.1, -0.2])].map(|(time, translate)| Key {
        time,
        translate,
        ..Key::default()
    });
    check(
        "body.cube.handle.0.keys=[{ time = 0.05 }, { time = 0.2, translate = [0, 0.1, -0.2] }]",
        |simulation| simulation.body_mut(0).set_keys(0, &keys, None).unwrap(),
    );
}

#[test]
fn a_changed_gravity_number_of_steps_or_density_acts_from_the_next_step() {
    check("simulation.gravity=[0, 2, 1]", |simulation| simulation.set_gravity([0.0, 2.0, 1.0]).unwrap());
    check("simulation.substeps=5", |simulation| simulation.set_substeps(Substeps::Fixed(5)).unwrap());
    check("body.cube.density=20", |simulation| simulation.body_mut(0).set_density(20.0).unwrap());
    check("body.cube.region_damping=0.3", |simulation| {
        simulation.body_mut(0).set_region_damping(supple::RegionDamping::PerStep(0.3)).unwrap();
    });
}

#[test]
fn a_removed_handle_releases_its_vertices() {
    check("body.cube.handle=[]", |simulation| simulation.body_mut(0).release(0).unwrap());
}
