//! Maps: colors and other numbers of vertices, which selections of scenes take as weights.

use std::collections::BTreeMap;
use std::path::Path;

use serde_json::json;
use supple_io::model;
use supple_io::obj::Document;
use supple_io::run::{Job, prepare};
use supple_io::scene::Scene;

use super::files::{Gltf, Shape, cube, tetrahedron};
use crate::run_files::written;

fn read(bytes: impl Into<Vec<u8>>) -> Document {
    model::from_bytes("model", bytes.into()).unwrap()
}

/// Returns the maps of a file.
fn maps(bytes: impl Into<Vec<u8>>) -> BTreeMap<String, Vec<f32>> {
    read(bytes).maps().into_iter().collect()
}

fn expected<const N: usize>(maps: [(&str, &[f32]); N]) -> BTreeMap<String, Vec<f32>> {
    maps.into_iter().map(|(name, values)| (name.to_owned(), values.to_vec())).collect()
}

/// Returns an OBJ file of a tetrahedron, whose vertices have these words after their positions.
fn obj(words: [&str; 4]) -> String {
    let shape = tetrahedron().obj();
    let mut words = words.into_iter();
    let line = |line: &str| match line.starts_with('v') {
        true => format!("{line} {}\n", words.next().unwrap()),
        false => format!("{line}\n"),
    };
    shape.lines().map(line).collect()
}

#[test]
fn colors_of_obj_vertices_are_maps() {
    let reals = maps(obj(["0 0.5 1", "0.25 0 0 # color", "1 1 \\\n 1", "0 0 0.125"]));
    let [red, green, blue] =
        [[0.0, 0.25, 1.0, 0.0], [0.5, 0.0, 1.0, 0.0], [1.0, 0.0, 1.0, 0.125]].map(|map: [f32; 4]| map);
    assert_eq!(reals, expected([("red", &red), ("green", &green), ("blue", &blue)]));

    // One number above 1 makes bytes of all.
    let bytes = maps(obj(["255 0 1 51", "0 0 0 255", "0 1 0 0", "0 0 0 0"]));
    assert_eq!(bytes["red"], [1.0, 0.0, 0.0, 0.0]);
    assert_eq!(bytes["green"], [0.0, 0.0, 1.0 / 255.0, 0.0]);
    assert_eq!(bytes["alpha"], [0.2, 1.0, 0.0, 0.0]);
    assert_eq!(bytes.len(), 4);
}

#[test]
fn obj_vertices_without_a_color_are_white() {
    let some = maps(obj(["", "0 51 255", "1", "1 2 3 4 5"]));
    let white = 1.0;
    assert_eq!(some["red"], [white, 0.0, white, white]);
    assert_eq!(some["green"], [white, 0.2, white, white]);
    assert_eq!(some.len(), 3);
    // A color without an opacity is opaque.
    assert_eq!(maps(obj(["0 0 0", "0 0 0 0.5", "", ""]))["alpha"], [1.0, 0.5, 1.0, 1.0]);
    // Without any color, and with weights, of which the format has one after a position, there are no maps.
    assert!(maps(obj([""; 4])).is_empty());
    assert!(maps(obj(["1", "1 1", "1", "1 1 1 1 1"])).is_empty());
}

#[test]
fn text_that_is_no_finite_number_counts_as_zero() {
    let found = maps(obj(["nan inf 1e99", "x 1 -0.5", "0 0 0", "0 0 0"]));
    assert_eq!(found["red"], [0.0; 4]);
    assert_eq!(found["green"], [0.0, 1.0, 0.0, 0.0]);
    assert_eq!(found["blue"], [0.0, -0.5, 0.0, 0.0]);
}

#[test]
fn a_part_has_the_numbers_of_its_vertices() {
    let text = "v 9 9 9 0 0 0\nv 0 0 0 0.5 0 0\nv 1 0 0 0.25 0 0\nv 0 1 0 1 0 0\nv 0 0 1 0.125 0 0\n\
                o left\nf 1 2 3\no right\nf 5 4 2\n";
    let document = read(text);
    let part = document.part(Some("right")).unwrap();
    assert!(part.mesh().maps().is_empty());
    let mesh = part.with_groups(&document).with_maps(&document).into_mesh();
    assert_eq!(mesh.map("red"), Some(&[0.5, 1.0, 0.125][..]));
    assert!(mesh.group("right").is_some());
    let mesh = document.grouped_mesh(None).unwrap();
    assert_eq!(mesh.map("red"), Some(&[0.0, 0.5, 0.25, 1.0, 0.125][..]));
    assert_eq!(mesh.maps().len(), 3);
}

/// Returns a PLY file of a tetrahedron with properties of its vertices, by type and name, and their values.
fn ply(encoding: &str, properties: &[(&str, &str, [f64; 4])]) -> Vec<u8> {
    let Shape { vertices, faces } = tetrahedron();
    let mut file = format!("ply\nformat {encoding} 1.0\nelement vertex {}\n", vertices.len());
    let position = |axis: usize| [0, 1, 2, 3].map(|vertex: usize| f64::from(vertices[vertex][axis]));
    let positions = [("float", "x", position(0)), ("float", "y", position(1)), ("float", "z", position(2))];
    // Properties come before the positions and after them.
    let (first, last) = properties.split_at(1);
    let all: Vec<_> = first.iter().chain(&positions).chain(last).collect();
    file.extend(all.iter().map(|(kind, name, _)| format!("property {kind} {name}\n")));
    file += &format!(
        "element face {}\nproperty uchar red\nproperty list uchar int vertex_index\nend_header\n",
        faces.len()
    );
    let mut bytes = file.into_bytes();
    let mut push = |number: f64, kind: &str, end: &str| {
        let mut value = match kind {
            "uchar" => vec![number as u8],
            "ushort" => (number as u16).to_le_bytes().to_vec(),
            "int" => (number as i32).to_le_bytes().to_vec(),
            "double" => number.to_le_bytes().to_vec(),
            _ => (number as f32).to_le_bytes().to_vec(),
        };
        if encoding == "binary_big_endian" {
            value.reverse();
        }
        bytes.extend(if encoding == "ascii" { format!("{number}{end}").into_bytes() } else { value });
    };
    for vertex in 0..vertices.len() {
        for (at, (kind, _, values)) in all.iter().enumerate() {
            push(values[vertex], kind, if at + 1 == all.len() { "\n" } else { " " });
        }
    }
    for face in faces {
        push(9.0, "uchar", " ");
        push(3.0, "uchar", " ");
        let ends = [" ", " ", "\n"];
        face.iter().zip(ends).for_each(|(&corner, end)| push(corner.into(), "int", end));
    }
    bytes
}

#[test]
fn numbers_of_ply_vertices_are_maps() {
    for encoding in ["ascii", "binary_little_endian", "binary_big_endian"] {
        // A number beyond those of 32 bits is not finite. Texts have no other ones.
        let odd = if encoding == "ascii" { -1e300 } else { f64::NAN };
        let file = ply(
            encoding,
            &[
                ("uchar", "red", [0.0, 51.0, 255.0, 102.0]),
                ("ushort", "green", [0.0, 65535.0, 13107.0, 0.0]),
                ("float", "blue", [0.0, 0.5, 1.0, 0.25]),
                ("double", "quality", [-3.0, 0.5, odd, 1e300]),
                ("int", "label", [7.0, -1.0, 0.0, 2.0]),
                ("float", "nx", [1.0; 4]),
                ("float", "ny", [0.0; 4]),
                ("float", "nz", [0.0; 4]),
                ("float", "s", [0.5; 4]),
                ("float", "t", [0.5; 4]),
            ],
        );
        let found = maps(file);
        let values: [(&str, &[f32]); 5] = [
            ("red", &[0.0, 0.2, 1.0, 0.4]),
            ("green", &[0.0, 1.0, 0.2, 0.0]),
            ("blue", &[0.0, 0.5, 1.0, 0.25]),
            ("quality", &[-3.0, 0.5, 0.0, 0.0]),
            ("label", &[7.0, -1.0, 0.0, 2.0]),
        ];
        assert_eq!(found, expected(values), "{encoding}");
    }
    assert!(maps(ply("ascii", &[("float", "nx", [1.0; 4])])).is_empty());
    assert!(maps(tetrahedron().stl_binary("")).is_empty());
}

/// Adds attributes to the only primitive of a file.
fn with_attributes(mut gltf: Gltf, attributes: &[(&str, serde_json::Value)]) -> Gltf {
    for (name, accessor) in attributes {
        gltf.root["meshes"][0]["primitives"][0]["attributes"][name] = accessor.clone();
    }
    gltf
}

fn scalars(gltf: &mut Gltf, values: &[f32]) -> serde_json::Value {
    let bytes = values.iter().flat_map(|x| x.to_le_bytes()).collect();
    gltf.accessor(bytes, json!({ "componentType": 5126, "count": values.len(), "type": "SCALAR" }))
}

fn bytes(gltf: &mut Gltf, kind: &str, is_normalized: bool, values: &[u8], count: usize) -> serde_json::Value {
    let accessor =
        json!({ "componentType": 5121, "count": count, "type": kind, "normalized": is_normalized });
    gltf.accessor(values.to_vec(), accessor)
}

#[test]
fn attributes_of_gltf_vertices_are_maps() {
    let mut gltf = tetrahedron().gltf(false);
    let colors = gltf.floats(&[[0.0, 0.5, 1.0], [0.25, 0.0, f32::NAN], [1.0; 3], [0.0; 3]]);
    let weights = scalars(&mut gltf, &[0.5, f32::INFINITY, 2.0, 0.0]);
    let flags = bytes(&mut gltf, "SCALAR", false, &[0, 1, 2, 255], 4);
    let shares = bytes(&mut gltf, "SCALAR", true, &[0, 51, 102, 255], 4);
    let vectors = gltf.floats(&[[1.0, 2.0]; 4]);
    let attributes = [
        ("COLOR_0", colors.clone()),
        ("COLOR_1", weights.clone()),
        ("_Soft_Part", weights.clone()),
        ("_FLAG", flags),
        ("_share", shares),
        ("_VECTOR", vectors),
        ("_RED", weights),
    ];
    let values: [(&str, &[f32]); 6] = [
        ("red", &[0.0, 0.25, 1.0, 0.0]),
        ("green", &[0.5, 0.0, 1.0, 0.0]),
        ("blue", &[1.0, 0.0, 1.0, 0.0]),
        ("soft_part", &[0.5, 0.0, 2.0, 0.0]),
        ("flag", &[0.0, 1.0, 2.0, 255.0]),
        ("share", &[0.0, 0.2, 0.4, 1.0]),
    ];
    let gltf = with_attributes(gltf, &attributes);
    assert_eq!(maps(gltf.glb()), expected(values));
    assert_eq!(maps(gltf.embedded()), expected(values));

    // Whole numbers in four channels.
    let mut gltf = tetrahedron().gltf(false);
    let colors = bytes(&mut gltf, "VEC4", true, &[255, 0, 51, 102].repeat(4), 4);
    let found = maps(with_attributes(gltf, &[("COLOR_0", colors)]).glb());
    let [red, green, blue, alpha] = [1.0, 0.0, 0.2, 0.4].map(|value: f32| [value; 4]);
    assert_eq!(found, expected([("red", &red), ("green", &green), ("blue", &blue), ("alpha", &alpha)]));

    for (name, count, words) in [
        ("COLOR_0", 3, "mesh 0, primitive 0, COLOR_0: fewer than vertices"),
        ("_PART", 3, "mesh 0, primitive 0, _PART: fewer than vertices"),
        ("COLOR_0", 4, "mesh 0, primitive 0, COLOR_0 is Scalar of U8 in place of VEC3 or VEC4"),
    ] {
        let mut gltf = tetrahedron().gltf(false);
        let kind = if count == 3 && name == "COLOR_0" { "VEC3" } else { "SCALAR" };
        let accessor = bytes(&mut gltf, kind, true, &[0; 12], count);
        let gltf = with_attributes(gltf, &[(name, accessor)]);
        let message = model::from_bytes("model", gltf.glb()).unwrap_err().to_string();
        assert!(message.contains(words), "{message}");
    }
}

/// The second primitive has a vertex of its own, at the place of none of the first.
#[test]
fn vertices_that_are_welded_have_the_numbers_of_the_first_and_missing_attributes_are_white_or_zero() {
    let shape = tetrahedron();
    let mut gltf = Gltf::default();
    let corners = |vertices: &[usize]| vertices.iter().map(|&v| shape.vertices[v]).collect::<Vec<_>>();
    let position = [gltf.floats(&corners(&[0, 2, 1])), gltf.floats(&corners(&[0, 1, 3]))];
    let green = gltf.floats(&[[0.0, 1.0, 0.5]; 3]);
    let (early, late) = (scalars(&mut gltf, &[0.25, 0.5, 0.75]), scalars(&mut gltf, &[9.0, 9.0, 2.0]));
    let primitives = |attributes: [serde_json::Value; 2]| {
        let mut gltf = gltf.clone();
        gltf.root["meshes"] = json!([{ "primitives": attributes.map(|of| json!({ "attributes": of })) }]);
        gltf.root["nodes"] = json!([{ "mesh": 0 }]);
        maps(gltf.glb())
    };
    let [first, second] = &position;
    // Both have the attribute `_A`, the first alone `_B`, the second alone the color and `_C`.
    let found = primitives([
        json!({ "POSITION": first, "_A": early, "_B": early }),
        json!({ "POSITION": second, "_A": late, "COLOR_0": green, "_C": late }),
    ]);
    let values: [(&str, &[f32]); 6] = [
        ("a", &[0.25, 0.5, 0.75, 2.0]),
        ("b", &[0.25, 0.5, 0.75, 0.0]),
        ("c", &[0.0, 0.0, 0.0, 2.0]),
        ("red", &[1.0, 1.0, 1.0, 0.0]),
        ("green", &[1.0; 4]),
        ("blue", &[1.0, 1.0, 1.0, 0.5]),
    ];
    assert_eq!(found, expected(values));
}

#[test]
fn a_mesh_in_several_places_has_its_numbers_in_each() {
    let mut gltf = tetrahedron().gltf(false);
    let part = scalars(&mut gltf, &[0.0, 0.5, 0.25, 1.0]);
    let mut gltf = with_attributes(gltf, &[("_PART", part)]);
    gltf.root["nodes"] = json!([
        { "name": "one", "mesh": 0 }, { "name": "two", "mesh": 0, "translation": [5, 0, 0] },
    ]);
    gltf.root["scenes"] = json!([{ "nodes": [0, 1] }]);
    let document = read(gltf.glb());
    assert_eq!(maps(gltf.glb())["part"], [0.0, 0.5, 0.25, 1.0].repeat(2));
    let two = document.grouped_mesh(Some("two")).unwrap();
    assert_eq!(two.map("part"), Some(&[0.0, 0.5, 0.25, 1.0][..]));
    assert!(two.vertices().iter().all(|vertex| vertex.x >= 5.0));
}

#[test]
fn too_many_maps_of_a_gltf_file_are_left_out() {
    let mut gltf = tetrahedron().gltf(false);
    let part = scalars(&mut gltf, &[1.0; 4]);
    let position = gltf.root["meshes"][0]["primitives"][0]["attributes"]["POSITION"].clone();
    // Each primitive of a node has a map of its own, which the vertices of all other nodes have as 0.
    let document = |count: usize| {
        let mut gltf = gltf.clone();
        gltf.root["meshes"] = (0..count)
            .map(|map| json!({ "primitives": [{ "attributes": { "POSITION": position, format!("_{map}"): part } }] }))
            .collect();
        gltf.root["nodes"] = (0..count).map(|mesh| json!({ "mesh": mesh })).collect();
        gltf.root["scenes"] = json!([{ "nodes": (0..count).collect::<Vec<_>>() }]);
        read(gltf.glb())
    };
    let few = document(20);
    assert_eq!((few.maps().len(), few.vertex_count()), (20, 80));
    assert!(few.ignored_parts().is_empty());
    // 4 x 2000 x 2000 values are more than four times the limit of 2^22 and the size of the file.
    let many = document(2000);
    assert!(many.bytes().len() < 1_000_000 && many.maps().is_empty());
    assert_eq!(many.ignored_parts(), ["colors and attributes of vertices, of which there are too many"]);
}

/// Weights of the vertices of a cube, by their height.
fn by_height(shape: &Shape, of: impl Fn(bool) -> u8) -> Vec<u8> {
    shape.vertices.iter().map(|[_, y, _]| of(*y > 1.0)).collect()
}

/// Writes a cube whose color is red above and blue below, in three formats.
fn write_painted(folder: &Path) -> Vec<&'static str> {
    let shape = cube().triangulated();
    let (red, blue) = (
        by_height(&shape, |top| if top { 255 } else { 51 }),
        by_height(&shape, |top| if top { 0 } else { 255 }),
    );
    let mut color = red.iter().zip(&blue).map(|(red, blue)| format!(" {red} 0 {blue}\n"));
    let obj: String = (shape.obj().lines())
        .map(|line| {
            if line.starts_with('v') { line.to_owned() + &color.next().unwrap() } else { format!("{line}\n") }
        })
        .collect();
    let mut gltf = shape.gltf(false);
    let colors: Vec<u8> = red.iter().zip(&blue).flat_map(|(&red, &blue)| [red, 0, blue, 255]).collect();
    let colors = bytes(&mut gltf, "VEC4", true, &colors, red.len());
    let gltf = with_attributes(gltf, &[("COLOR_0", colors)]);
    let mut vertices = shape.vertices.iter().zip(red.iter().zip(&blue));
    let mut ply = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\n\
         property uchar blue\nelement face {}\nproperty list uchar int vertex_index\nend_header\n",
        shape.vertices.len(),
        shape.faces.len()
    );
    ply.extend(vertices.by_ref().map(|([x, y, z], (red, blue))| format!("{x} {y} {z} {red} {blue}\n")));
    ply.extend(shape.faces.iter().map(|face| format!("3 {} {} {}\n", face[0], face[1], face[2])));
    std::fs::write(folder.join("painted.obj"), obj).unwrap();
    std::fs::write(folder.join("painted.glb"), gltf.glb()).unwrap();
    std::fs::write(folder.join("painted.ply"), ply).unwrap();
    vec!["painted.obj", "painted.glb", "painted.ply"]
}

/// Returns a scene of a painted cube with a zone and a pin by these selections.
fn painted(folder: &Path, model: &str, body: &str, [zone, pin]: [&str; 2]) -> Scene {
    let text = format!(
        "[simulation]\nframes = 4\nsubsteps = 8\n[[body]]\nname = \"cube\"\nmesh = \"{model}\"\nlattice_vertices = 64\n\
         stiffness = 0.05\n{body}[[body.zone]]\n{zone}\nfactor = 9\n[[body.pin]]\n{pin}\n"
    );
    Scene::parse(&text, "scene.toml", folder, &[]).unwrap()
}

fn frames(folder: &Path, scene: Scene, name: &str) -> BTreeMap<String, Vec<u8>> {
    let output = folder.join(name);
    Job::new(scene, &output).run(&mut ()).unwrap();
    written(&output)
}

/// The weights of the vertices are the same in lists and in the colors of the file, and so are all frames.
#[test]
fn zones_and_pins_by_a_color_have_the_frames_of_those_by_a_list() {
    let folder = tempfile::tempdir().unwrap();
    let shape = cube().triangulated();
    let list = |weights: Vec<u8>| {
        let weights: Vec<f32> = weights.into_iter().map(|weight| f32::from(weight) / 255.0).collect();
        format!("map = {weights:?}")
    };
    let lists = [
        list(by_height(&shape, |top| if top { 255 } else { 51 })),
        list(by_height(&shape, |top| if top { 0 } else { 255 })),
    ];
    let [zone, pin] = &lists;
    for model in write_painted(folder.path()) {
        let by_color = painted(folder.path(), model, "", ["map = \"red\"", "map = \"blue\""]);
        let factors = |scene: &Scene| {
            let simulation = prepare(scene).unwrap().simulation;
            simulation.body(0).stiffness_factors().unwrap().to_vec()
        };
        let found = factors(&by_color);
        assert_eq!(found, factors(&painted(folder.path(), model, "", [zone, pin])));
        // The share is from 0.2 to 1.
        assert!(found.iter().all(|factor| (9_f64.powf(0.19)..9.01).contains(factor)));
        assert!(found.iter().any(|&factor| factor > 6.0) && found.iter().any(|&factor| factor < 3.0));
        let expected =
            frames(folder.path(), painted(folder.path(), model, "", [zone, pin]), &format!("{model} list"));
        let found = frames(folder.path(), by_color, &format!("{model} color"));
        assert_eq!(found, expected, "{model}");
        // Another color holds other vertices.
        let other = painted(folder.path(), model, "", [zone, "map = \"red\""]);
        assert_ne!(frames(folder.path(), other, &format!("{model} other")), expected, "{model}");
    }
    // The frames of an OBJ file keep its colors.
    let frame = Document::read(folder.path().join("painted.obj color/cube_0004.obj")).unwrap();
    assert_eq!(frame.maps(), read(std::fs::read(folder.path().join("painted.obj")).unwrap()).maps());
}

#[test]
fn only_scenes_that_select_a_map_by_its_name_read_maps() {
    let folder = tempfile::tempdir().unwrap();
    for model in write_painted(folder.path()) {
        let of_body = |selections, body: &str| {
            let prepared = prepare(&painted(folder.path(), model, body, selections)).unwrap();
            let simulation = prepared.simulation;
            simulation.body(0).mesh().unwrap().maps().len()
        };
        let plane = "plane = { point = [0, 1, 0], normal = [0, 1, 0] }";
        assert_eq!(of_body([plane, "map = [1, 1, 1, 1, 1, 1, 1, 1]"], ""), 0);
        assert!(of_body([plane, "map = \"blue\""], "") >= 2);
        // New vertices of a refined mesh have interpolated numbers, also where a mirror changes the file.
        assert!(of_body(["map = \"red\"", plane], "refine = \"auto\"\nscale = [1, 1, -1]\n") >= 2);
        let error =
            prepare(&painted(folder.path(), model, "", [plane, "map = \"hot\""])).unwrap_err().to_string();
        assert!(error.contains("body.cube.pin.0") && error.contains("no map \"hot\""), "{error}");
        assert!(error.contains("\"red\"") && error.contains("\"blue\""), "{error}");
    }
}
