//! Runs of models of all formats.

use std::collections::BTreeMap;
use std::path::Path;

use serde_json::json;
use supple_io::model;
use supple_io::obj::Document;
use supple_io::run::{Job, RunError};
use supple_io::scene::{Scene, Up};

use super::files::{Gltf, cube, tetrahedron};
use crate::run_files::{StopAfter, written};

/// Runs a scene or a model for three frames, and returns the files.
fn run(folder: &Path, input: &str, overrides: &[&str]) -> BTreeMap<String, Vec<u8>> {
    let overrides: Vec<String> = overrides.iter().map(|text| (*text).to_owned()).collect();
    let mut scene = Scene::open(folder.join(input), Up::Y, &overrides).unwrap();
    scene.simulation.frames = 3;
    let output = folder.join(format!("frames of {input} {}", overrides.join(" ")));
    Job::new(scene, &output).run(&mut ()).unwrap();
    written(&output)
}

/// Returns the text of a frame without the names of objects.
fn without_objects(files: &BTreeMap<String, Vec<u8>>) -> Vec<String> {
    let text = |bytes: &Vec<u8>| {
        let text = std::str::from_utf8(bytes).unwrap();
        text.lines()
            .filter(|line| !line.starts_with("o "))
            .fold(String::new(), |text, line| text + line + "\n")
    };
    files.values().map(text).collect()
}

#[test]
fn runs_of_all_formats_give_the_frames_of_the_obj_file() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let shape = cube().triangulated();
    for (extension, bytes) in [
        ("glb", shape.gltf(false).glb()),
        ("gltf", shape.gltf(false).embedded()),
        ("ply", shape.ply("binary_big_endian", "float", false)),
        ("stl", shape.stl_binary("solid")),
    ] {
        let name = format!("{extension}_model");
        std::fs::write(at(&format!("{name}.{extension}")), &bytes).unwrap();
        let document = model::read_document(at(&format!("{name}.{extension}"))).unwrap();
        // The vertices of an STL file have the order of its triangles.
        let text = if extension == "stl" { document.bytes().to_vec() } else { shape.obj().into_bytes() };
        std::fs::write(at(&format!("{name}.obj")), text).unwrap();
        let frames = run(folder.path(), &format!("{name}.{extension}"), &[]);
        assert_eq!(
            frames.keys().collect::<Vec<_>>(),
            [0, 1, 2, 3].map(|frame| format!("{name}_000{frame}.obj")).each_ref()
        );
        assert_eq!(
            without_objects(&frames),
            without_objects(&run(folder.path(), &format!("{name}.obj"), &[]))
        );
    }
}

/// A tetrahedron with a blue material.
fn blue() -> Gltf {
    let mut gltf = tetrahedron().gltf(true);
    gltf.root["meshes"][0]["primitives"][0]["material"] = json!(0);
    let color = json!({ "baseColorFactor": [0, 0.25, 1, 0.5] });
    gltf.root["materials"] = json!([{ "name": "blue", "alphaMode": "BLEND", "pbrMetallicRoughness": color }]);
    gltf
}

#[test]
fn the_materials_of_a_model_are_beside_its_frames() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("blue.glb"), blue().glb()).unwrap();
    let overrides = ["output.format=[\"obj\", \"ply\", \"pc2\", \"usd\", \"html\"]"];
    let files = run(folder.path(), "blue.glb", &overrides);
    assert_eq!(files["blue_frames.mtl"], b"newmtl blue\nKd 0 0.25 1\nd 0.5\n");
    assert!(files["blue_0001.obj"].starts_with(b"mtllib blue_frames.mtl\nv "));
    assert!(
        ["blue.pc2", "supple.usd", "supple.html", "blue_0003.ply"]
            .iter()
            .all(|name| files.contains_key(*name))
    );
    let output = folder.path().join(format!("frames of blue.glb {}", overrides[0]));
    let frame = Document::read(output.join("blue_0001.obj")).unwrap();
    let color = &frame.material_colors()["blue"];
    assert_eq!((color.diffuse, color.opacity), ([0.0, 0.25, 1.0], 0.5));
    let part = frame.part(None).unwrap();
    assert_eq!(frame.appearance(&part).coordinates.len(), 4);
    assert_eq!(frame.appearance(&part).materials.len(), 1);
}

#[test]
fn models_are_refined_mirrored_broken_and_meshes_of_colliders() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("blue.glb"), blue().glb()).unwrap();
    std::fs::write(folder.path().join("floor.stl"), cube().triangulated().stl_text(&["floor"])).unwrap();
    let scene = "[[body]]\nname = \"blue\"\nmesh = \"blue.glb\"\nobject = \"mesh 0\"\nscale = [1, 1, -800]\n\
                 refine = \"auto\"\ncell_size = 0.3\n[body.fracture]\nstrain = 0.001\n\
                 [[collider]]\nmesh = \"floor.stl\"\ntranslate = [0, -3, 0]\n";
    std::fs::write(folder.path().join("scene.toml"), scene).unwrap();
    let files = run(folder.path(), "scene.toml", &[]);
    let whole = Document::from_bytes("x.obj", files["blue_0000.obj"].clone()).unwrap();
    assert!(whole.vertex_count() > 4 && whole.libraries().len() == 1);
    assert!(whole.mesh(None).unwrap().signed_volume() > 0.0);
}

#[test]
fn a_changed_buffer_beside_the_model_is_a_changed_mesh() {
    let folder = tempfile::tempdir().unwrap();
    let gltf = tetrahedron().gltf(false);
    let buffer = folder.path().join("b.bin");
    std::fs::write(folder.path().join("a.gltf"), gltf.json("b.bin")).unwrap();
    std::fs::write(&buffer, &gltf.buffer).unwrap();
    let scene = Scene::open(folder.path().join("a.gltf"), Up::Y, &[]).unwrap();
    let mut job = Job::new(scene, folder.path().join("out"));
    job.run(&mut StopAfter(2)).unwrap();
    job.resume = true.into();
    let mut changed = gltf.buffer.clone();
    changed[0] ^= 1;
    std::fs::write(&buffer, changed).unwrap();
    let message = job.run(&mut ()).unwrap_err().to_string();
    assert!(message.contains("the mesh file has changed"), "{message}");
    std::fs::remove_file(&buffer).unwrap();
    let error = job.run(&mut ()).unwrap_err();
    assert!(matches!(error, RunError::MeshFile { ref path, .. } if *path == buffer), "{error}");
}
