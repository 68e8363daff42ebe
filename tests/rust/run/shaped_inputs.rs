//! Scenes that change the mesh on its way in: scales by axis, mirrors, and divided faces. Their frames have the changed mesh.

use std::fs;
use std::path::Path;

use nalgebra::{Point3, Vector3};
use supple::{Mesh, Scale};
use supple_io::obj::{self, Document};
use supple_io::run::{Job, Outcome, prepare};
use supple_io::scene::Scene;

/// A prism over an L, 2 by 2 by 1, with one concave face above and one below, hard normals, texture coordinates, a
/// material, another object, and corners that count back.
const PRISM: &str = "mtllib a.mtl\nv 9 9 9\nv 9 8 9\nv 8 9 9\no other\nf 1 2 3\no prism\n\
    v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\n\
    v 0 0 1\nv 2 0 1\nv 2 1 1\nv 1 1 1\nv 1 2 1\nv 0 2 1\n\
    vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 0 1\nvn 0 0 -1\nvn 0 -1 0\nvn 0.6 0.8 0\nusemtl red\n\
    f 10/1/1 11/2/1 12/3/1 13/4/1 14/1/1 15/2/1\n\
    f 9//2 8//2 7//2 6//2 5//2 4//2 # below\n\
    f 4/1/3 5/2/3 11/3/3 10/4/3\nusemtl blue\n\
    f -11/1/4 -10/2/4 -4/3/4 -5/4/4\nf 6/1 7/2 13/3 12/4\nf 7/1 8/2 14/3 13/4\nf 8/1 9/2 15/3 14/4\n\
    f 9/1 4/2 10/3 15/4\n";

fn scene(folder: &Path, keys: &str) -> Result<Scene, supple_io::scene::SceneError> {
    fs::write(folder.join("prism.obj"), PRISM).unwrap();
    let text = format!(
        "[simulation]\nframes = 2\ngravity = [0, 0, 0]\n[output]\ndirectory = \"frames\"\n\
         format = [\"obj\", \"ply\", \"usd\", \"html\"]\n[[body]]\nname = \"prism\"\nmesh = \"prism.obj\"\n\
         object = \"prism\"\ncell_size = 0.25\n{keys}\n"
    );
    Scene::parse(&text, "scene.toml", folder, &[])
}

/// Runs a scene, and returns the document of its last OBJ frame.
fn last_frame(folder: &Path, keys: &str) -> Document {
    let scene = scene(folder, keys).unwrap();
    assert_eq!(
        Scene::parse(&scene.to_toml(), "scene.toml", folder, &[]).unwrap(),
        scene,
        "written and read again"
    );
    let outcome = Job::new(scene, folder.join("frames")).run(&mut ()).unwrap();
    assert!(matches!(outcome.outcome, Outcome::Finished));
    Document::read(folder.join("frames/prism_0002.obj")).unwrap()
}

/// Asserts that faces have the normals of the file turned as the faces are.
fn assert_normals_fit(mesh: &Mesh, frame: &str, down: Vector3<f64>) {
    let document = ::obj::raw::parse_obj(frame.as_bytes()).unwrap();
    let (x, y, z) = document.normals[1];
    let [x, y, z] = [x, y, z].map(f64::from);
    assert!((Vector3::new(x, y, z) - down).norm() < 1e-5, "the normal of the face below is {x} {y} {z}");
    assert!(mesh.signed_volume() > 0.0, "faces are counter-clockwise seen from outside");
}

#[test]
fn axes_are_scaled_and_mirrored_before_the_lattice_and_in_all_frames() {
    let folder = tempfile::tempdir().unwrap();
    let keys = "scale = [1, 2, -3]\ntranslate = [0, 0, 10]";
    let prepared = prepare(&scene(folder.path(), keys).unwrap()).unwrap();
    let body = &prepared.simulation.bodies()[0];
    assert_eq!(body.scale(), Scale::PerAxis([1.0, 2.0, -3.0]));
    let (low, high) = body.mesh().unwrap().bounds();
    assert_eq!((low, high), (Point3::new(0.0, 0.0, -3.0), Point3::new(2.0, 4.0, 0.0)));
    // 3 squares of area 1 times 6. The cells of the lattice fill the prism.
    assert!((body.mesh().unwrap().signed_volume() - 18.0).abs() < 1e-12);
    assert!((body.mass() - 18_000.0).abs() < 1e-6 * 18_000.0, "{}", body.mass());
    assert_eq!(body.lattice().cells().len(), 18 * 64);

    let frame = last_frame(folder.path(), keys);
    let mesh = frame.mesh(Some("prism")).unwrap();
    assert!((mesh.volume() - 18.0).abs() < 1e-4 && mesh.is_closed());
    let text = fs::read_to_string(folder.path().join("frames/prism_0002.obj")).unwrap();
    assert_normals_fit(&mesh, &text, Vector3::z());
    assert!(text.contains("f 9//2 4//2 5//2 6//2 7//2 8//2 # below\n"), "{text}");
    assert!(text.contains("f 1 2 3\n"), "another object keeps its faces");
    assert!(text.contains("f -11/1/4 -5/4/4 -4/3/4 -10/2/4\n"), "{text}");
    let ply = fs::read(folder.path().join("frames/prism_0002.ply")).unwrap();
    assert!(
        ply.windows(15).any(|bytes| bytes == b"element face 20"),
        "concave faces are written as triangles"
    );
}

#[test]
fn a_scale_of_equal_factors_has_the_body_of_one_factor() {
    let folder = tempfile::tempdir().unwrap();
    let positions = |keys: &str| {
        let prepared = prepare(&scene(folder.path(), keys).unwrap()).unwrap();
        prepared.simulation.bodies()[0].positions()
    };
    assert_eq!(positions("scale = 2"), positions("scale = [2, 2, 2]"));
}

#[test]
fn scales_that_are_no_scales_are_refused_with_their_line() {
    let folder = tempfile::tempdir().unwrap();
    for scale in ["0", "-1", "[1, 2]", "[1, 0, 1]", "[1, 1, inf]", "\"big\"", "nan", "[1, 1, \"a\"]"] {
        let error = scene(folder.path(), &format!("scale = {scale}")).unwrap_err().to_string();
        let is_clear =
            ["scene.toml:12", "body.prism.scale", "three numbers"].iter().all(|part| error.contains(part));
        assert!(is_clear, "{scale}: {error}");
    }
}

#[test]
fn mirrored_colliders_hold_bodies_like_scaled_ones() {
    let folder = tempfile::tempdir().unwrap();
    let height = |scale: &str| {
        scene(folder.path(), "").unwrap();
        let text = format!(
            "[simulation]\nframes = 120\ngravity = [0, 0, -9.81]\n[[body]]\nname = \"prism\"\nmesh = \"prism.obj\"\n\
             object = \"prism\"\ncell_size = 0.5\ntranslate = [0, 0, 2]\n[[collider]]\nmesh = \"slab.obj\"\nscale = {scale}\n"
        );
        let slab = "v -9 -9 0\nv 9 -9 0\nv 9 9 0\nv -9 9 0\nv -9 -9 1\nv 9 -9 1\nv 9 9 1\nv -9 9 1\n\
                    f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
        fs::write(folder.path().join("slab.obj"), slab).unwrap();
        let scene = Scene::parse(&text, "scene.toml", folder.path(), &[]).unwrap();
        let mut simulation = prepare(&scene).unwrap().simulation;
        simulation.advance(120);
        simulation.bodies()[0].center_of_mass().z
    };
    // A mirrored slab lies below the plane z = 0, and another one above it.
    let (up, down) = (height("[1, 1, 1.5]"), height("[1, 1, -1.5]"));
    assert!((up - 2.0).abs() < 0.1 && (down - 0.5).abs() < 0.1, "{up} {down}");
}

#[test]
fn divided_faces_bend_and_frames_have_their_vertices() {
    let folder = tempfile::tempdir().unwrap();
    let prepared = prepare(&scene(folder.path(), "refine = \"auto\"").unwrap()).unwrap();
    assert_eq!(prepared.cautions, [], "no face is larger than a cell");
    let body = &prepared.simulation.bodies()[0];
    let mesh = body.mesh().unwrap();
    let frame = last_frame(folder.path(), "refine = \"auto\"");
    let written = frame.mesh(Some("prism")).unwrap();
    assert!(written.faces().eq(mesh.faces()), "the faces of the file are those of the body");
    assert!(written.is_closed() && (written.volume() - 3.0).abs() < 1e-5, "{}", written.volume());
    let longest = written.triangles().iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).map(|edge| {
        let [a, b] = edge.map(|vertex| written.vertices()[vertex as usize]);
        nalgebra::distance(&a, &b)
    });
    assert!(longest.fold(0.0, f64::max) <= 1.5 * 0.25 + 1e-6);
    // New corners have the texture coordinates and the hard normals of their faces.
    let text = fs::read_to_string(folder.path().join("frames/prism_0002.obj")).unwrap();
    let raw = ::obj::raw::parse_obj(text.as_bytes()).unwrap();
    assert!(
        raw.tex_coords.len() > 4
            && raw.tex_coords.iter().all(|&(u, v, _)| u.min(v) >= 0.0 && u.max(v) <= 1.0)
    );
    assert_eq!(raw.meshes.keys().len(), 3, "faces without a material, red and blue");
    assert_normals_fit(&written, &text, -Vector3::z());
    // The other object is as it was.
    assert_eq!(frame.mesh(Some("other")).unwrap().face_count(), 1);
    assert!(obj::read(folder.path().join("frames/prism_0002.obj")).is_ok());
}

#[test]
fn divided_faces_of_a_scaled_and_mirrored_mesh_fit_their_body() {
    let folder = tempfile::tempdir().unwrap();
    let keys = "scale = [0.5, 1, -1]\nrefine = \"auto\"\n[body.fracture]\nstrain = 0.5";
    let prepared = prepare(&scene(folder.path(), keys).unwrap()).unwrap();
    let body = &prepared.simulation.bodies()[0];
    let part = prepared.inputs[0].part.mesh();
    assert!(part.faces().eq(body.mesh().unwrap().faces()));
    assert!((part.signed_volume() - 1.5).abs() < 1e-9 && (body.mass() - 1500.0).abs() < 1e-3);
}
