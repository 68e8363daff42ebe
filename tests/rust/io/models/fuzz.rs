//! Fuzzing of the readers of models: they return a surface or an error.

use supple_io::model;

use super::files::{Gltf, cube, tetrahedron};
use crate::fuzz::{Target, fuzz};

fn read(input: &[u8]) -> String {
    let document = match model::from_bytes("model", input.to_vec()) {
        Err(error) => return error.to_string(),
        Ok(document) => document,
    };
    let part = match document.part(None) {
        Err(error) => return error.to_string(),
        Ok(part) => part,
    };
    let mesh = part.mesh();
    assert!(mesh.vertices().iter().all(|p| p.coords.iter().all(|&x| (x as f32).is_finite())));
    assert!(mesh.faces().flatten().all(|&vertex| (vertex as usize) < mesh.vertices().len()));
    let maps = document.maps();
    assert!(maps.iter().all(|(_, values)| values.len() == document.vertex_count()));
    assert!(maps.iter().flat_map(|(_, values)| values).all(|value| value.is_finite()));
    let appearance = document.appearance(&part);
    assert!(appearance.corners.iter().all(|&corner| (corner as usize) < appearance.coordinates.len()));
    let has = |what: &str, is: bool| if is { what.to_owned() } else { String::new() };
    format!(
        "surface {} {} {} {}",
        has("maps", !maps.is_empty()),
        has("textured", !appearance.coordinates.is_empty()),
        has("materials", !appearance.materials.is_empty()),
        has("ignored", !document.ignored_parts().is_empty())
    )
}

#[test]
fn mutated_gltf_files_are_read_or_refused_without_panics() {
    let mut skinned: Gltf = tetrahedron().gltf(true);
    let (joints, weights) = (skinned.joints(&[[0, 1, 0, 0]; 4]), skinned.floats(&[[0.5, 0.5, 0.0, 0.0]; 4]));
    let (bind, moved) = (skinned.floats(&[[1.0; 16]; 2]), skinned.floats(&[[0.0, 1.0, 0.0]; 4]));
    let colors = skinned.floats(&[[0.5, 1.0, 0.0, 1.0]; 4]);
    let numbers = skinned.indices(&[0, 1, 2, 3]);
    let primitive = &mut skinned.root["meshes"][0]["primitives"][0];
    (primitive["attributes"]["JOINTS_0"], primitive["attributes"]["WEIGHTS_0"]) = (joints, weights);
    (primitive["attributes"]["COLOR_0"], primitive["attributes"]["_A"]) = (colors, numbers);
    primitive["targets"] = serde_json::json!([{ "POSITION": moved }]);
    (primitive["material"], primitive["mode"]) = (0.into(), 5.into());
    skinned.root["meshes"][0]["weights"] = serde_json::json!([0.5]);
    skinned.root["images"] =
        serde_json::json!([{ "uri": "a.png" }, { "bufferView": 0, "mimeType": "image/png" }]);
    skinned.root["textures"] = serde_json::json!([{ "source": 0 }, { "source": 1 }]);
    skinned.root["materials"] = serde_json::json!([{ "name": "m", "pbrMetallicRoughness": { "baseColorFactor": [1, 1, 1, 1], "baseColorTexture": { "index": 1 } } }]);
    skinned.root["skins"] = serde_json::json!([{ "joints": [0, 1], "inverseBindMatrices": bind }]);
    skinned.root["nodes"] = serde_json::json!([
        { "mesh": 0, "skin": 0, "children": [1] }, { "rotation": [0, 0, 0, 1], "scale": [1, 2, 3] },
    ]);
    skinned.root["accessors"][0]["sparse"] = serde_json::json!({
        "count": 2, "indices": { "bufferView": 1, "componentType": 5121 }, "values": { "bufferView": 0 },
    });
    let plain = cube().triangulated().gltf(false);
    const WORDS: &[&str] = &[
        "POSITION",
        "TEXCOORD_0",
        "JOINTS_0",
        "WEIGHTS_0",
        "COLOR_0",
        "_A",
        "normalized",
        "accessors",
        "bufferView",
        "byteOffset",
        "byteStride",
        "count",
        "SCALAR",
        "VEC2",
        "VEC3",
        "VEC4",
        "MAT4",
        "5120",
        "5121",
        "5122",
        "5123",
        "5125",
        "5126",
        "mode",
        "children",
        "sparse",
        "indices",
        "values",
        "matrix",
        "mesh",
        "skin",
        "uri",
        "source",
        "images",
        "mimeType",
    ];
    let corpus = vec![plain.glb(), plain.embedded(), skinned.glb(), skinned.embedded()];
    fuzz(&Target { name: "gltf", words: WORDS, read }, corpus);
}

#[test]
fn mutated_stl_files_are_read_or_refused_without_panics() {
    let shape = cube().triangulated();
    const WORDS: &[&str] =
        &["solid", "facet", "normal", "outer", "loop", "vertex", "endloop", "endfacet", "endsolid"];
    let corpus = vec![shape.stl_binary("x"), shape.stl_binary("solid x"), shape.stl_text(&["a", "b c"])];
    fuzz(&Target { name: "stl", words: WORDS, read }, corpus);
}

#[test]
fn mutated_ply_files_are_read_or_refused_without_panics() {
    const WORDS: &[&str] = &[
        "ply",
        "format",
        "ascii",
        "binary_little_endian",
        "binary_big_endian",
        "element",
        "property",
        "list",
        "red",
        "uchar",
        "ushort",
        "char",
        "short",
        "int",
        "uint",
        "float",
        "double",
        "vertex",
        "face",
        "vertex_indices",
        "texcoord",
        "x",
        "y",
        "z",
        "s",
        "t",
        "comment",
        "end_header",
    ];
    let encodings = ["ascii", "binary_little_endian", "binary_big_endian"];
    let corpus = encodings.map(|encoding| cube().ply(encoding, "float", true)).to_vec();
    fuzz(&Target { name: "ply", words: WORDS, read }, corpus);
}
