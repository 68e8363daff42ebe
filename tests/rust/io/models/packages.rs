//! Models of other people's packages (`tests/data/models`): their surfaces, and a frame of each.

use std::path::{Path, PathBuf};

use supple_io::model;
use supple_io::run::Job;
use supple_io::scene::{Scene, Up};

/// A model, and what trimesh 5.2.0 reads of it.
struct Model {
    file: &'static str,
    /// Numbers of vertices, for STL and glTF after they are merged at equal positions, and of triangles.
    counts: (usize, usize),
    is_closed: bool,
    extents: [f64; 3],
    /// Volume, positive. That of an open surface depends on the origin, and is not compared.
    volume: f64,
}

#[rustfmt::skip]
const MODELS: [Model; 8] = [
    // Normals and no texture coordinates; the cone has no base.
    Model { file: "cone.obj", counts: (33, 32), is_closed: false, extents: [2.0, 2.0, 2.0], volume: f64::NAN },
    // The library that it names is missing.
    Model { file: "textured_cube.obj", counts: (8, 12), is_closed: true, extents: [1.0, 1.0, 1.0], volume: 1.0 },
    Model { file: "fabella.stl", counts: (42, 80), is_closed: true, extents: [0.006579, 0.006079, 0.006814], volume: 1.261e-7 },
    Model { file: "bellows.stl", counts: (12, 20), is_closed: true, extents: [0.076356, 0.2988, 0.326808], volume: 0.0070633 },
    // Quads in a list with the old name `vertex_index`.
    Model { file: "cube.ply", counts: (8, 12), is_closed: true, extents: [1.0, 1.0, 1.0], volume: 1.0 },
    Model { file: "tetrahedron.ply", counts: (4, 4), is_closed: true, extents: [2.0, 2.0, 2.0], volume: 8.0 / 3.0 },
    // A node with a transform, beside lights and cameras.
    Model { file: "cube.glb", counts: (8, 12), is_closed: true, extents: [1.0, 1.0, 1.0], volume: 1.0 },
    // The faces point inwards.
    Model { file: "sparse_box.glb", counts: (8, 12), is_closed: true, extents: [1.0, 1.0, 1.0], volume: 1.0 },
];

fn path(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("data/models").join(file)
}

#[test]
fn models_of_other_packages_have_the_surfaces_that_another_reader_finds() {
    for Model { file, counts, is_closed, extents, volume } in MODELS {
        let mesh = model::read(path(file), None).unwrap();
        assert_eq!((mesh.vertices().len(), mesh.triangles().len()), counts, "{file}");
        assert_eq!(mesh.is_closed(), is_closed, "{file}");
        let (low, high) = mesh.bounds();
        for axis in 0..3 {
            // The digits of the table.
            assert!((high[axis] - low[axis] - extents[axis]).abs() < 6e-7, "{file}: {}", high - low);
        }
        if is_closed {
            let found = mesh.signed_volume().abs();
            assert!((found - volume).abs() < 1e-3 * volume, "{file}: {found}");
        }
    }
}

#[test]
fn models_of_other_packages_run() {
    let folder = tempfile::tempdir().unwrap();
    for Model { file, counts, .. } in MODELS {
        let overrides = ["output.format=ply".to_owned(), "body.0.lattice_vertices=100".to_owned()];
        let mut scene = Scene::open(path(file), Up::Y, &overrides).unwrap();
        scene.simulation.frames = 3;
        let name = scene.bodies[0].name.clone();
        let directory = folder.path().join(file);
        Job::new(scene, &directory).run(&mut ()).unwrap();
        let frame = model::read(directory.join(format!("{name}_0003.ply")), None).unwrap();
        assert_eq!((frame.vertices().len(), frame.triangles().len()), counts, "{file}");
    }
}
