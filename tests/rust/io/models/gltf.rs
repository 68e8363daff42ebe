//! Places, skins, morph targets, materials and modes of glTF files.

use serde_json::json;
use supple::Mesh;
use supple_io::model;
use supple_io::obj::Document;

use super::files::{Gltf, Shape, tetrahedron};

fn read(gltf: &Gltf) -> Document {
    model::from_bytes("model.glb", gltf.glb()).unwrap()
}

fn positions(mesh: &Mesh) -> Vec<[f32; 3]> {
    mesh.vertices().iter().map(|p| p.cast::<f32>().into()).collect()
}

fn moved(shape: &Shape, by: impl Fn([f32; 3]) -> [f32; 3]) -> Vec<[f32; 3]> {
    shape.vertices.iter().map(|&p| by(p)).collect()
}

#[test]
fn nodes_are_objects_at_their_places() {
    let shape = tetrahedron();
    let mut gltf = shape.gltf(false);
    let half = 0.5_f32.sqrt();
    gltf.root["nodes"] = json!([
        { "children": [1, 2], "translation": [1, 2, 3] },
        // A quarter turn about z.
        { "name": "turned # \\", "mesh": 0, "rotation": [0, 0, half, half], "scale": [2, 1, 1] },
        // The matrix has columns, and mirrors.
        { "name": "mirrored", "mesh": 0, "matrix": [-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 0, 0, 1] },
        { "name": "in no scene", "mesh": 0 },
    ]);
    let document = read(&gltf);
    assert_eq!(document.groups().map(|group| &*group.name).collect::<Vec<_>>(), ["turned", "mirrored"]);
    let turned = document.mesh(Some("turned")).unwrap();
    for (found, [x, y, z]) in turned.vertices().iter().zip(&shape.vertices) {
        let expected = [1.0 - y, 2.0 + 2.0 * x, 3.0 + z].map(f64::from);
        assert!((found - nalgebra::Point3::from(expected)).norm() < 1e-6);
    }
    let mirrored = document.mesh(Some("mirrored")).unwrap();
    assert_eq!(positions(&mirrored), moved(&shape, |[x, y, z]| [6.0 - x, 2.0 + y, 3.0 + z]));
    // Both are oriented outwards.
    assert!(turned.signed_volume() > 0.0 && mirrored.signed_volume() > 0.0);
    let message = document.mesh(Some("other")).unwrap_err().to_string();
    assert_eq!(
        message,
        "model.glb: no object or group `other` with faces; the file has: `turned`, `mirrored`"
    );
}

#[test]
fn joints_place_skinned_meshes_and_their_nodes_do_not() {
    let shape = tetrahedron();
    let mut gltf = shape.gltf(false);
    let joints = gltf.joints(&[[0, 0, 0, 0], [1, 0, 0, 0], [0, 1, 0, 0], [0, 1, 0, 0]]);
    let weights = gltf.floats(&[
        [1.0, 0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0, 0.0],
        [0.5, 0.5, 0.0, 0.0],
        [0.25, 0.75, 0.0, 0.0],
    ]);
    let inverse = |x: f32| {
        let mut matrix: [f32; 16] = std::array::from_fn(|at| f32::from(at % 5 == 0));
        matrix[12] = -x;
        matrix
    };
    let bind = gltf.floats(&[inverse(0.0), inverse(1.0)]);
    let attributes = &mut gltf.root["meshes"][0]["primitives"][0]["attributes"];
    (attributes["JOINTS_0"], attributes["WEIGHTS_0"]) = (joints, weights);
    gltf.root["skins"] = json!([{ "joints": [1, 2], "inverseBindMatrices": bind }]);
    gltf.root["nodes"] = json!([
        { "mesh": 0, "skin": 0, "translation": [100, 0, 0] },
        { "children": [2] },
        // One unit above the place to which it is bound.
        { "translation": [1, 1, 0] },
    ]);
    gltf.root["scenes"] = json!([{ "nodes": [0, 1] }]);
    let found = positions(&read(&gltf).mesh(None).unwrap());
    let up = [0.0, 1.0, 0.5, 0.75];
    let expected: Vec<_> = shape.vertices.iter().zip(up).map(|(&[x, y, z], up)| [x, y + up, z]).collect();
    assert_eq!(found, expected);
}

#[test]
fn morph_targets_have_their_default_weights() {
    let shape = tetrahedron();
    let mut gltf = shape.gltf(false);
    let raised = gltf.floats(&[[0.0, 1.0, 0.0]; 4]);
    let shifted = gltf.floats(&[[1.0, 0.0, 0.0]; 4]);
    gltf.root["meshes"][0]["primitives"][0]["targets"] =
        json!([{ "POSITION": raised }, { "POSITION": shifted }]);
    let found = |gltf: &Gltf| positions(&read(gltf).mesh(None).unwrap());
    assert_eq!(found(&gltf), shape.vertices);
    gltf.root["meshes"][0]["weights"] = json!([0.5, 0]);
    assert_eq!(found(&gltf), moved(&shape, |[x, y, z]| [x, y + 0.5, z]));
    gltf.root["nodes"][0]["weights"] = json!([0, 2]);
    assert_eq!(found(&gltf), moved(&shape, |[x, y, z]| [x + 2.0, y, z]));
}

#[test]
fn primitives_are_welded_in_their_mesh_and_have_materials() {
    let shape = tetrahedron();
    let mut gltf = shape.gltf(false);
    let (first, second) =
        (gltf.indices(&shape.faces[..2].concat()), gltf.indices(&shape.faces[2..].concat()));
    let (again, line) = (gltf.floats(&shape.vertices), gltf.indices(&[0, 1]));
    let primitive = &gltf.root["meshes"][0]["primitives"][0].clone();
    let at = |position: &serde_json::Value, indices, material: u32| json!({ "attributes": { "POSITION": position }, "indices": indices, "material": material });
    let mut lines = at(&again, line, 0);
    lines["mode"] = json!(1);
    let position = &primitive["attributes"]["POSITION"];
    let mesh = json!([at(position, first, 1), at(&again, second, 0), lines]);
    gltf.root["meshes"] = json!([{ "name": "skull", "primitives": mesh }]);
    gltf.root["images"] = json!([{ "uri": "no such image.png" }]);
    gltf.root["textures"] = json!([{ "source": 0 }]);
    gltf.root["materials"] = json!([
        { "name": "bone", "pbrMetallicRoughness": { "baseColorFactor": [1, 0.5, 0.25, 0.5], "baseColorTexture": { "index": 0 } } },
        { "name": "bone", "alphaMode": "BLEND", "pbrMetallicRoughness": { "baseColorFactor": [0, 0, 1, 0.5] } },
    ]);
    let document = read(&gltf);
    let part = document.part(Some("skull")).unwrap();
    assert_eq!((part.mesh().vertices().len(), part.mesh().is_closed()), (4, true));
    let named = |name: &str, faces: &[u32]| (name.to_owned(), faces.to_vec());
    assert_eq!(document.appearance(&part).materials, [named("bone", &[0, 1]), named("bone 0", &[2, 3])]);
    let colors = document.material_colors();
    assert_eq!((colors["bone"].diffuse, colors["bone"].opacity), ([0.0, 0.0, 1.0], 0.5));
    assert_eq!((colors["bone 0"].diffuse, colors["bone 0"].opacity), ([1.0, 0.5, 0.25], 1.0));
    assert_eq!(
        document.ignored_parts(),
        ["1 primitive of points or lines", "1 image missing, or neither PNG nor JPEG"]
    );
}

#[test]
fn strips_fans_sparse_and_interleaved_accessors_are_read() {
    let shape = tetrahedron();
    // A closed strip around a tetrahedron.
    let mut gltf = shape.gltf(false);
    let strip = gltf.indices(&[0, 2, 1, 3, 0, 2]);
    let primitive = &mut gltf.root["meshes"][0]["primitives"][0];
    (primitive["indices"], primitive["mode"]) = (strip, json!(5));
    let mesh = read(&gltf).mesh(None).unwrap();
    assert!(mesh.is_closed() && mesh.face_count() == 4 && mesh.signed_volume() > 0.0);
    // Three of the faces around vertex 3.
    let fan = gltf.indices(&[3, 0, 1, 2, 0]);
    let primitive = &mut gltf.root["meshes"][0]["primitives"][0];
    (primitive["indices"], primitive["mode"]) = (fan, json!(6));
    assert_eq!(read(&gltf).mesh(None).unwrap().face_count(), 3);

    // The corners of the triangles without indices, interleaved with other numbers.
    let mut gltf = Gltf::default();
    let corners: Vec<[f32; 4]> = shape.corners().iter().map(|&[x, y, z]| [x, y, z, 9.0]).collect();
    gltf.floats(&corners);
    gltf.root["bufferViews"][0]["byteStride"] = json!(16);
    let sparse_values = gltf.floats(&[[7.0, 8.0, 9.0]]);
    let sparse_indices = gltf.indices(&[2]);
    assert_eq!((&sparse_values, &sparse_indices), (&json!(1), &json!(2)));
    gltf.root["accessors"][0]["type"] = json!("VEC3");
    gltf.root["accessors"][0]["sparse"] = json!({
        "count": 1, "indices": { "bufferView": 2, "componentType": 5123 }, "values": { "bufferView": 1 },
    });
    gltf.root["meshes"] = json!([{ "primitives": [{ "attributes": { "POSITION": 0 } }] }]);
    gltf.root["nodes"] = json!([{ "mesh": 0 }]);
    let mesh = read(&gltf).mesh(None).unwrap();
    let found: Vec<[f32; 3]> =
        mesh.faces().flatten().map(|&v| mesh.vertices()[v as usize].cast::<f32>().into()).collect();
    let mut expected = shape.corners();
    expected[2] = [7.0, 8.0, 9.0];
    assert_eq!(found, expected);
}
