//! Grids of VTK: their arrays are the frames of other formats, and the deformation of the cells is that of the motion.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::time::Duration;

use supple_io::run::Job;
use supple_io::scene::Scene;

use crate::run_files::{BLOCK, CopyAfter, written};

const SCENE: &str = r#"
[simulation]
frames = 8
fps = 24
substeps = 2
gravity = [0, -2, 0]

[output]
format = ["vtu", "lattice", "ply"]
scale = 10

[[body]]
name = "block"
mesh = "block.obj"
lattice_vertices = 60
"#;

fn job(folder: &Path, out: &str, overrides: &[&str]) -> Job {
    fs::write(folder.join("block.obj"), BLOCK).unwrap();
    let overrides: Vec<String> = overrides.iter().map(ToString::to_string).collect();
    Job::new(Scene::parse(SCENE, "scene.toml", folder, &overrides).unwrap(), folder.join(out))
}

/// A grid: the bytes of its arrays by their names.
pub(crate) struct Grid {
    points: usize,
    cells: usize,
    arrays: BTreeMap<String, Vec<u8>>,
}

impl Grid {
    /// Reads a file, by the description of the format.
    pub(crate) fn read(path: &Path) -> Self {
        let bytes = fs::read(path).unwrap();
        let data = bytes.windows(2).position(|text| text == b"\n_").unwrap() + 2;
        let head = std::str::from_utf8(&bytes[..data]).unwrap();
        assert!(head.contains("byte_order=\"LittleEndian\"") && head.contains("header_type=\"UInt64\""));
        let value = |text: &str, key: &str| -> String {
            let start = text.find(&format!("{key}=\"")).unwrap() + key.len() + 2;
            text[start..].split('"').next().unwrap().to_owned()
        };
        let arrays = head.split("<DataArray ").skip(1).map(|text| {
            let at = data + value(text, "offset").parse::<usize>().unwrap();
            let size = u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap()) as usize;
            (value(text, "Name"), bytes[at + 8..at + 8 + size].to_vec())
        });
        let count = |key: &str| value(head, key).parse().unwrap();
        let end = b"\n</AppendedData>\n</VTKFile>\n";
        assert!(bytes.ends_with(end));
        Self { points: count("NumberOfPoints"), cells: count("NumberOfCells"), arrays: arrays.collect() }
    }

    pub(crate) fn numbers(&self, name: &str) -> Vec<f32> {
        self.arrays[name].as_chunks::<4>().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect()
    }

    fn indices(&self, name: &str) -> Vec<i64> {
        self.arrays[name].as_chunks::<8>().0.iter().map(|bytes| i64::from_le_bytes(*bytes)).collect()
    }
}

#[test]
fn the_arrays_of_a_surface_have_the_bits_of_the_ply_frames() {
    let folder = tempfile::tempdir().unwrap();
    let mut job = job(folder.path(), "out", &[]);
    (job.every, job.start_frame) = (4, 1001);
    job.run(&mut ()).unwrap();
    for frame in [1001, 1005, 1009] {
        let grid = Grid::read(&job.directory.join(format!("block_{frame}.vtu")));
        assert_eq!((grid.points, grid.cells), (8, 6));
        let ply = fs::read(job.directory.join(format!("block_{frame}.ply"))).unwrap();
        let start = ply.windows(11).position(|text| text == b"end_header\n").unwrap() + 11;
        let vertices = (0..8).map(|vertex| &ply[start + 24 * vertex..start + 24 * vertex + 24]);
        let (points, normals): (Vec<_>, Vec<_>) = vertices.map(|vertex| vertex.split_at(12)).unzip();
        assert_eq!(grid.arrays["Points"], points.concat());
        assert_eq!(grid.arrays["Normals"], normals.concat());
        // The faces of the block.
        assert_eq!(grid.indices("connectivity")[..8], [3, 2, 1, 0, 4, 5, 6, 7]);
        assert_eq!(grid.indices("offsets"), [4, 8, 12, 16, 20, 24]);
        assert_eq!(grid.arrays["types"], [9; 6]);
    }
    let times = fs::read_to_string(job.directory.join("block.pvd")).unwrap();
    for (frame, time) in [(1001, 0.0), (1005, 4.0 / 24.0), (1009, 8.0 / 24.0)] {
        assert!(
            times.contains(&format!("<DataSet timestep=\"{time}\" file=\"block_{frame}.vtu\"/>")),
            "{times}"
        );
    }
}

#[test]
fn cells_have_their_strain_and_volume_and_vertices_their_velocities() {
    let folder = tempfile::tempdir().unwrap();
    let handle = "body.block.handle=[{ plane = { point = [0, 2.9, 0], normal = [0, 1, 0] }, keys = [{ time = 0 }, \
                  { time = 0.3, translate = [0, 1, 0] }] }]";
    let pin = "body.block.pin=[{ plane = { point = [0, 0.1, 0], normal = [0, -1, 0] } }]";
    let job = job(folder.path(), "out", &[handle, pin]);
    job.run(&mut ()).unwrap();
    let at = |frame: u32| Grid::read(&job.directory.join(format!("block_{frame:04}.lattice.vtu")));
    let (first, last) = (at(0), at(8));
    assert_eq!(first.arrays["types"], vec![12; first.cells]);
    assert_eq!(first.indices("connectivity").len(), 8 * first.cells);
    // Positions of 32 bits, of a size of a few cells.
    assert!(first.numbers("strain").iter().all(|strain| strain.abs() < 1e-5));
    assert!(first.numbers("volume_ratio").iter().all(|ratio| (ratio - 1.0).abs() < 1e-5));
    // The block, 3 high, is stretched by 1.
    let strains = last.numbers("strain");
    let mean = strains.iter().sum::<f32>() / strains.len() as f32;
    assert!((0.25..0.45).contains(&mean), "{mean}");
    // The volume of a cell is the product of its mean edges, here by the order of the corners in VTK.
    let cell_volumes = |grid: &Grid| -> Vec<f32> {
        let points = grid.numbers("Points");
        let place = |index: i64| nalgebra::Vector3::from_fn(|axis, _| points[3 * index as usize + axis]);
        let volume = |corners: &[i64; 8]| {
            let edge = |pairs: [[usize; 2]; 4]| -> nalgebra::Vector3<f32> {
                pairs
                    .iter()
                    .map(|&[a, b]| place(corners[b]) - place(corners[a]))
                    .sum::<nalgebra::Vector3<f32>>()
                    / 4.0
            };
            let x = edge([[0, 1], [3, 2], [4, 5], [7, 6]]);
            let y = edge([[0, 3], [1, 2], [4, 7], [5, 6]]);
            x.cross(&y).dot(&edge([[0, 4], [1, 5], [2, 6], [3, 7]]))
        };
        grid.indices("connectivity").as_chunks::<8>().0.iter().map(volume).collect()
    };
    let volumes = cell_volumes(&first).into_iter().zip(cell_volumes(&last));
    for (ratio, (before, after)) in last.numbers("volume_ratio").into_iter().zip(volumes) {
        assert!((ratio - after / before).abs() < 1e-4, "{ratio}, {before}, {after}");
    }
    // Before the end of its motion the handle moves by 1 in 0.3 s, which is 33 in the lengths of the files.
    let velocities = at(4).numbers("velocity");
    let fastest = velocities.as_chunks::<3>().0.iter().map(|[_, y, _]| *y).fold(0.0, f32::max);
    assert!((25.0..60.0).contains(&fastest), "{fastest}");
    // VTK goes around the corners of a face: each side of a hexahedron at rest is as long as a cell.
    let points = first.numbers("Points");
    let place = |index: i64| -> [f32; 3] { std::array::from_fn(|axis| points[3 * index as usize + axis]) };
    let corners = first.indices("connectivity");
    let length = |a: usize, b: usize| {
        let (a, b) = (place(corners[a]), place(corners[b]));
        (0..3).map(|axis| (a[axis] - b[axis]).powi(2)).sum::<f32>().sqrt()
    };
    let sides =
        [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)];
    for (a, b) in sides {
        assert!((length(a, b) / length(0, 1) - 1.0).abs() < 1e-4);
    }
}

#[test]
fn cells_have_the_modulus_of_their_material_and_zone() {
    let folder = tempfile::tempdir().unwrap();
    let zone = "body.block.zone=[{ plane = { point = [0, 1.5, 0], normal = [0, 1, 0] }, factor = 0.25 }]";
    let moduli = |out: &str, overrides: &[&str]| {
        let body = ["body.block.youngs_modulus=20000", "body.block.lattice_vertices=1000"];
        let overrides: Vec<&str> =
            body.into_iter().chain(["simulation.frames=1"]).chain(overrides.iter().copied()).collect();
        let job = job(folder.path(), out, &overrides);
        job.run(&mut ()).unwrap();
        let grid = Grid::read(&job.directory.join("block_0001.lattice.vtu"));
        let (points, corners) = (grid.numbers("Points"), grid.indices("connectivity"));
        // The lowest corner of each cell, in lengths of the scene.
        let lowest = |corners: &[i64; 8]| {
            corners.iter().map(|&corner| points[3 * corner as usize + 1] / 10.0).fold(f32::INFINITY, f32::min)
        };
        let heights = corners.as_chunks::<8>().0.iter().map(lowest);
        heights.zip(grid.numbers("E")).collect::<Vec<(f32, f32)>>()
    };
    // Lengths of the files are ten times those of the scene: a force per area of a hundred times the size is the tenth of a
    // mass per length and squared time.
    for (_, modulus) in moduli("plain", &[]) {
        assert!((modulus - 2000.0).abs() < 1.0, "{modulus}");
    }
    let zones = moduli("zone", &[zone]);
    // The factor changes over a cell around the plane.
    let cell = 3.0 / 11.0;
    let far: Vec<&(f32, f32)> =
        zones.iter().filter(|(height, _)| *height < 1.4 - 2.0 * cell || *height > 1.6 + cell).collect();
    for (height, modulus) in &far {
        let expected = if *height > 1.5 { 500.0 } else { 2000.0 };
        assert!((modulus - expected).abs() < 1.0, "{height}: {modulus}");
    }
    assert!(far.iter().any(|(height, _)| *height > 1.5) && far.iter().any(|(height, _)| *height < 1.5));
}

#[test]
fn a_killed_run_has_the_files_of_an_uninterrupted_run() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let mut whole = job(folder.path(), "whole", &["output.format=[\"vtu\", \"lattice\"]"]);
    whole.checkpoint_interval = Duration::ZERO;
    let (from, to) = (at("whole"), at("killed"));
    whole.run(&mut CopyAfter { frame: 5, from, to: to.clone() }).unwrap();
    let mut resumed = whole.clone();
    (resumed.directory, resumed.resume, resumed.verify) = (to, true.into(), true);
    resumed.run(&mut ()).unwrap();
    assert!(written(&at("killed")) == written(&at("whole")));
    assert_eq!(written(&at("whole")).len(), 20);
    // Only the file with the times is missing.
    fs::remove_file(at("killed/block.pvd")).unwrap();
    resumed.run(&mut ()).unwrap();
    assert!(written(&at("killed")) == written(&at("whole")));
}

#[test]
fn a_broken_body_has_the_faces_and_cells_of_its_pieces() {
    let folder = tempfile::tempdir().unwrap();
    let scene = supple_tests::example("notch.toml");
    let overrides =
        ["output.format=[\"vtu\", \"lattice\", \"obj\"]".to_owned(), "simulation.frames=40".to_owned()];
    let mut job = Job::new(Scene::read_with(&scene, &overrides).unwrap(), folder.path().join("out"));
    job.every = 40;
    job.run(&mut ()).unwrap();
    let name = job.scene.bodies[0].name.clone();
    let grid = |frame: u32, extension: &str| {
        Grid::read(&job.directory.join(format!("{name}_{frame:04}.{extension}")))
    };
    assert!(grid(40, "vtu").points > grid(0, "vtu").points);
    let (before, after) = (grid(0, "lattice.vtu"), grid(40, "lattice.vtu"));
    assert!(after.points > before.points && after.cells == before.cells);
}
