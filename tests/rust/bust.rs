//! The main job on a real mesh: a bust is stretched, let go, and dropped.

use nalgebra::{Matrix3, Vector3};
use supple::{
    Body, Collider, Handle, Key, Mesh, Pin, Selection, Simulation, VolumeMeasure, VolumeOptions, Window,
};

const DT: f64 = 1.0 / 120.0;
const SUBSTEPS: u64 = 4;

/// Head and shoulders, the base at y = 0.
fn bust() -> Mesh {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/scenes/bust.obj");
    let mesh = supple::obj::read(path).unwrap();
    let (low, _) = mesh.bounds();
    let vertices = mesh.vertices().iter().map(|p| [p.x, p.y - low.y, p.z]).collect();
    let faces: Vec<_> = mesh.faces().map(<[u32]>::to_vec).collect();
    Mesh::new(vertices, &faces).unwrap()
}

/// Shoulders held and crown pulled up until 1.5 s, then let go above the ground.
fn scene(volume: impl Into<VolumeOptions>) -> Simulation {
    let window = Window { from: 0.0, until: 1.5 };
    let far = 100.0;
    let shoulders = Selection::Box { min: [-far; 3], max: [far, 0.9, far] };
    let crown = Selection::Box { min: [-far, 3.75, -far], max: [far, far, far] };
    let keys = vec![
        Key { time: 0.0, translate: [0.0; 3], rotate: [0.0; 3] },
        Key { time: 1.0, translate: [0.0, 1.3, 0.0], rotate: [0.0; 3] },
    ];
    let body = Body::builder(bust())
        .translate([0.0, 0.5, 0.0])
        .half_width(3)
        .frequency(12.0)
        .damping_rate(40.0)
        .volume(volume)
        .pin(Pin { selection: shoulders, window })
        .handle(Handle { selection: crown, keys, window })
        .build()
        .unwrap();
    let ground = Collider::plane([0.0; 3], [0.0, 1.0, 0.0]);
    Simulation::builder()
        .body(body)
        .collider(Collider { friction: 0.5, ..ground })
        .dt(DT)
        .substeps(SUBSTEPS)
        .build()
        .unwrap()
}

/// The enclosed volume of the surface as it is written: f32 coordinates.
fn written_volume(sim: &Simulation) -> f64 {
    let body = sim.body(0);
    let mesh = body.mesh().unwrap();
    let mut surface = vec![[0.0_f32; 3]; mesh.vertices().len()];
    body.surface_into(&mut surface, None);
    let at = |v: u32| Vector3::from(surface[v as usize].map(f64::from));
    mesh.triangles().iter().map(|t| at(t[0]).dot(&at(t[1]).cross(&at(t[2]))) / 6.0).sum()
}

/// Cells that are turned inside out somewhere at a corner.
fn inverted_cells(body: &Body) -> usize {
    let x = body.positions();
    let cells = 0..body.lattice().cells().len() as u32;
    cells
        .filter(|&cell| {
            let corners = body.lattice().cell_corners(cell);
            (0..8).any(|k| {
                let along = |axis: usize| {
                    let (low, high) = (corners[k & !(1 << axis)], corners[k | 1 << axis]);
                    x[high as usize] - x[low as usize]
                };
                Matrix3::from_columns(&[along(0), along(1), along(2)]).determinant() <= 0.0
            })
        })
        .count()
}

#[test]
fn the_volume_is_kept_in_every_frame() {
    let mut sim = scene(VolumeMeasure::Mesh);
    let rest = sim.body(0).mesh().unwrap().volume();
    for frame in 0..=120 {
        let volume = written_volume(&sim);
        assert!((volume / rest - 1.0).abs() < 1e-5, "frame {frame}: {volume} of {rest}");
        let report = sim.body(0).volume_report();
        assert!(!report.capped && report.residual.abs() < 1e-6, "frame {frame}: {report:?}");
        sim.steps(SUBSTEPS);
    }
}

#[test]
fn without_correction_it_grows_by_more_than_a_quarter() {
    let mut sim = scene(VolumeOptions::off());
    let rest = sim.body(0).mesh().unwrap().volume();
    sim.steps((1.4 / DT) as u64);
    let grown = written_volume(&sim) / rest;
    println!("at full stretch {grown}");
    assert!(grown > 1.25, "{grown}");
}

#[test]
fn it_snaps_back_and_comes_to_rest_on_the_ground() {
    let mut sim = scene(VolumeMeasure::Mesh);
    sim.steps((12.0 / DT) as u64);
    let body = sim.body(0);
    assert_eq!(inverted_cells(body), 0);
    let lowest = body.surface().positions.iter().map(|p| p.y).fold(f64::INFINITY, f64::min);
    let cell_size = body.lattice().cell_size();
    println!("lowest point {} of a cell above the ground", lowest / cell_size);
    assert!(lowest.abs() < 0.05 * cell_size, "{lowest} with cells of {cell_size}");
    let fastest = body.velocities().iter().map(|v| v.norm()).fold(0.0, f64::max);
    println!("fastest vertex {fastest}");
    assert!(fastest < 0.1, "{fastest}");
}

#[test]
fn looking_changes_no_bit() {
    let run = |looks: bool| {
        let mut sim = scene(VolumeMeasure::Lattice);
        for _ in 0..100 {
            sim.step();
            if looks {
                sim.body(0).surface();
                sim.body(0).goals();
                sim.body(0).volume_report();
            }
        }
        (sim.body(0).positions(), sim.body(0).velocities())
    };
    assert_eq!(run(false), run(true));
}
