//! Invalid files: the message names the file, the element, the value and the way out.

use serde_json::{Value, json};
use supple_io::model;

use super::files::{Gltf, cube, tetrahedron};

fn refusal(bytes: impl Into<Vec<u8>>) -> String {
    let refused = model::from_bytes("x.model", bytes.into()).and_then(|document| Ok(document.mesh(None)?));
    let message = refused.expect_err("refused").to_string();
    message.strip_prefix("x.model: ").expect("the file").to_owned()
}

/// Asserts that the changed glTF file of a tetrahedron is refused with these words, as GLB and as glTF.
fn assert_refused(change: impl Fn(&mut Gltf), words: &str) {
    let mut gltf = tetrahedron().gltf(true);
    change(&mut gltf);
    for bytes in [gltf.glb(), gltf.embedded()] {
        let message = refusal(bytes);
        assert!(message.contains(words), "{message}");
    }
}

/// Asserts that a change of a value in the JSON is refused with these words.
fn assert_value(pointer: &str, value: &Value, words: &str) {
    let change = |gltf: &mut Gltf| match gltf.root.pointer_mut(pointer) {
        Some(place) => *place = value.clone(),
        None => {
            let (parent, key) = pointer.rsplit_once('/').unwrap();
            gltf.root.pointer_mut(parent).unwrap()[key] = value.clone();
        }
    };
    assert_refused(change, words);
}

#[test]
fn compressed_and_quantized_files_are_refused_with_the_command_that_undoes_it() {
    for (name, command) in [
        ("KHR_draco_mesh_compression", "gltf-transform copy IN OUT"),
        ("EXT_meshopt_compression", "gltf-transform copy IN OUT"),
        ("KHR_mesh_quantization", "gltf-transform dequantize IN OUT"),
    ] {
        let expected = format!(
            "is compressed or quantized with {name}, which is not read; export it without compression, or run: {command}"
        );
        assert_value("/extensionsRequired", &json!(["KHR_materials_unlit", name]), &expected);
    }
    assert_value("/extensionsRequired", &json!(["ABC_d"]), "needs the extension ABC_d, which is not read");
    assert_value("/accessors/0/componentType", &json!(5122), "mesh 0, primitive 0, POSITION is quantized");
    let mut gltf = tetrahedron().gltf(false);
    gltf.root["extensionsRequired"] = json!(["KHR_materials_unlit"]);
    assert!(model::from_bytes("x", gltf.glb()).is_ok());
}

#[test]
fn indices_and_ranges_of_gltf_files_are_checked() {
    for (pointer, value, words) in [
        ("/accessors/0/count", json!(4_000_000_000_u32), "its meshes together"),
        ("/accessors/0/count", json!(5), "POSITION: bytes up to 60 of buffer view 0 with 48"),
        ("/accessors/0/count", json!(0), "index 0 refers to vertex 0 of 0"),
        ("/accessors/0/count", json!(2), "mesh 0, primitive 0: index 1 refers to vertex 2 of 2"),
        ("/accessors/0/byteOffset", json!(u64::MAX), "more than 64 bits can count"),
        ("/accessors/0/type", json!("VEC2"), "POSITION is Vec2 of F32 in place of VEC3"),
        ("/accessors/0/type", json!("VEC5"), "`accessors[0].type`: invalid value"),
        ("/accessors/0/componentType", json!(1), "`accessors[0].componentType`: invalid value"),
        ("/accessors/0/bufferView", json!(99), "`accessors[0].bufferView`: index out of bounds"),
        ("/accessors/1/componentType", json!(5126), "indices is Scalar of F32"),
        ("/accessors/2/count", json!(3), "TEXCOORD_0: fewer than vertices"),
        ("/bufferViews/0/byteLength", json!(1_000_000), "bytes up to 1000000 of buffer 0 with"),
        ("/bufferViews/0/byteOffset", json!(u64::MAX), "more than 64 bits can count"),
        ("/bufferViews/0/byteStride", json!(4), "a stride of 4 bytes for elements of 12"),
        ("/meshes/0/primitives/0/attributes/POSITION", json!(7), "POSITION is accessor 7 of 3"),
        ("/meshes/0/primitives/0/attributes", json!({}), "mesh 0, primitive 0 has no POSITION"),
        ("/meshes/0/primitives/0/indices", json!(7), "primitives[0].indices`: index out of bounds"),
        ("/meshes/0/primitives/0/material", json!(0), "primitives[0].material`: index out of bounds"),
        ("/meshes/0/primitives/0/mode", json!(9), "primitives[0].mode`: invalid value"),
        ("/meshes/0/primitives/0/mode", json!(0), "only points and lines in its scene"),
        ("/nodes/0/mesh", json!(1), "`nodes[0].mesh`: index out of bounds"),
        ("/nodes/0/skin", json!(0), "`nodes[0].skin`: index out of bounds"),
        ("/nodes/0/children", json!([0]), "node 0 is its own ancestor"),
        ("/nodes/0/translation", json!([1e39, 0, 0]), "number out of range"),
        ("/nodes/0/scale", json!([3.3e38, 1, 1]), "mesh 0, primitive 0, vertex 1 has the coordinate 3"),
        ("/nodes/0/rotation", json!([0, 0, 0, 0]), "vertex 0 has the coordinate NaN"),
        ("/nodes", json!([]), "index out of bounds"),
        ("/scenes/0/nodes", json!([]), "no mesh with triangles in its scene"),
        ("/scene", json!(3), "`scene`: index out of bounds"),
        ("/asset", json!(1), "the JSON of the glTF file is invalid"),
    ] {
        assert_value(pointer, &value, words);
    }
    let nodes = json!([{ "children": [1, 2], "mesh": 0 }, { "children": [2] }, { "children": [] }]);
    assert_value("/nodes", &nodes, "node 2 has two parents");
    let sparse = |count: u32| json!({ "count": count, "indices": { "bufferView": 1, "componentType": 5123 }, "values": { "bufferView": 0 } });
    assert_value("/accessors/0/sparse", &sparse(0), "0 sparse values of 4");
    assert_value("/accessors/0/sparse", &sparse(5), "5 sparse values of 4");
    // A number that is not finite.
    assert_refused(
        |gltf| gltf.buffer[4..8].copy_from_slice(&f32::NAN.to_le_bytes()),
        "mesh 0, primitive 0, vertex 0 has the coordinate NaN; numbers must be finite",
    );
}

#[test]
fn deep_and_repeated_nodes_take_bounded_memory_and_time() {
    let mut gltf = cube().triangulated().gltf(false);
    let deep = 100_000;
    let chain = (0..deep)
        .map(|node| if node + 1 < deep { json!({ "children": [node + 1] }) } else { json!({ "mesh": 0 }) });
    gltf.root["nodes"] = chain.collect();
    assert!(model::from_bytes("x", gltf.glb()).is_ok());
    let many = format!("{{\"asset\": {{}}, \"nodes\": [{}]}}", "{},".repeat(1_000_000));
    assert!(refusal(many).starts_with("its JSON has 1000002 objects, such as nodes"));
    // Each node shows a mesh of many primitives with the same accessors.
    let primitive = gltf.root["meshes"][0]["primitives"][0].clone();
    gltf.root["meshes"][0]["primitives"] = vec![primitive; 1000].into();
    gltf.root["nodes"] = vec![json!({ "mesh": 0 }); 10_000].into();
    gltf.root["scenes"] = json!([{ "nodes": (0..10_000).collect::<Vec<_>>() }]);
    let message = refusal(gltf.glb());
    assert!(
        message.starts_with("its meshes together, each as often as nodes show it, have 4194304 elements"),
        "{message}"
    );
}

#[test]
fn images_that_are_no_files_change_nothing() {
    for image in [json!({}), json!({ "bufferView": 0 }), json!({ "uri": "https://example.org/a.png" })] {
        for texture in [json!({}), json!({ "source": 0 })] {
            let mut gltf = tetrahedron().gltf(true);
            gltf.root["images"] = json!([image]);
            gltf.root["textures"] = json!([texture]);
            gltf.root["materials"] =
                json!([{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }]);
            gltf.root["meshes"][0]["primitives"][0]["material"] = json!(0);
            let document = model::from_bytes("x", gltf.glb()).unwrap();
            assert_eq!(document.material_colors()["material 0"].image, None);
        }
    }
}

#[test]
fn skins_are_checked() {
    let skinned = |joints: Value, joint: u8, bind: usize| {
        move |gltf: &mut Gltf| {
            let of_vertices = gltf.joints(&[[joint; 4]; 4]);
            let weights = gltf.floats(&[[0.25; 4]; 4]);
            let bind = gltf.floats(&vec![[0.0; 16]; bind]);
            let attributes = &mut gltf.root["meshes"][0]["primitives"][0]["attributes"];
            (attributes["JOINTS_0"], attributes["WEIGHTS_0"]) = (of_vertices, weights);
            gltf.root["skins"] = json!([{ "joints": joints, "inverseBindMatrices": bind }]);
            gltf.root["nodes"][0]["skin"] = json!(0);
        }
    };
    assert_refused(skinned(json!([0]), 3, 1), "mesh 0, primitive 0, vertex 0 has joint 3 of 1");
    assert_refused(skinned(json!([0, 0]), 0, 1), "skin 0, inverse bind matrices: 1 for 2 joints");
    assert_refused(skinned(json!([9]), 0, 1), "`skins[0].joints[0]`: index out of bounds");
    let without = |gltf: &mut Gltf| {
        gltf.root["skins"] = json!([{ "joints": [0] }]);
        gltf.root["nodes"][0]["skin"] = json!(0);
    };
    assert_refused(without, "has a skin, and no JOINTS_0 and WEIGHTS_0");
}

#[test]
fn missing_and_short_buffers_are_named() {
    let gltf = tetrahedron().gltf(false);
    let message = refusal(gltf.json("no such.bin"));
    assert!(message.starts_with("buffer 0, the file no such.bin, cannot be read: "), "{message}");
    assert!(message.ends_with("; copy it there, or export the model as GLB"), "{message}");
    let message = refusal(gltf.json("https://example.org/a.bin"));
    assert_eq!(
        message,
        "buffer 0 is at `https://example.org/a.bin`; save it beside the file, and write its name there"
    );
    assert!(refusal(gltf.json("data:,hello")).contains("buffer 0: the data in its `uri` are not base64"));
    let message = refusal(gltf.json("data:;base64,AAAA"));
    assert!(message.starts_with("buffer 0 has 3 bytes in place of "), "{message}");
    let text = String::from_utf8(gltf.json("")).unwrap().replace(",\"uri\":\"\"", "");
    assert!(refusal(text).contains("buffer 0 has no `uri`, and the file no binary chunk for it"));
}

#[test]
fn headers_of_glb_files_are_checked() {
    let glb = tetrahedron().gltf(false).glb();
    let with = |at: usize, number: u32| {
        let mut glb = glb.clone();
        glb[at..at + 4].copy_from_slice(&number.to_le_bytes());
        refusal(glb)
    };
    assert_eq!(with(4, 1), "has version 1 of GLB; export it as glTF 2.0");
    assert!(
        with(8, 3).starts_with("the header of the GLB file tells 3 bytes, and it has "),
        "{}",
        with(8, 3)
    );
    assert!(with(8, u32::MAX).contains("tells 4294967295 bytes"));
    assert!(with(12, u32::MAX).contains("the GLB file is invalid"));
    for length in 4..glb.len() {
        refusal(&glb[..length]);
    }
    assert!(refusal("{\"asset\": [[[[").contains("the JSON of the glTF file is invalid"));
    assert!(
        refusal(format!("{{\"asset\": {}", "[".repeat(100_000)))
            .contains("the JSON of the glTF file is invalid")
    );
}

#[test]
fn stl_files_are_checked() {
    let shape = tetrahedron();
    let binary = shape.stl_binary("x");
    let stl = |bytes: &[u8]| model::from_bytes("x.stl", bytes.to_vec()).unwrap_err().to_string();
    let mut many = binary.clone();
    many[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
    assert_eq!(
        stl(&many),
        "x.stl: is no text that begins with `solid`, and as a binary STL file with the 4294967295 triangles of its header it \
         has 214748364834 bytes, not 284; export or copy it again"
    );
    assert!(stl(&binary[..200]).contains("not 200"));
    assert!(stl(b"hello").contains("a binary STL file, which has at least 84 bytes, not 5"));
    assert!(
        stl(&shape.stl_binary("x")[..84].iter().map(|_| 0).collect::<Vec<u8>>()).contains("no triangles")
    );
    let mut nan = binary;
    nan[84 + 50 + 12..][..4].copy_from_slice(&f32::INFINITY.to_le_bytes());
    assert_eq!(
        refusal(nan),
        "triangle 2 has the coordinate inf; numbers must be finite and within the range of f32"
    );
    let text = String::from_utf8(shape.stl_text(&["a b"])).unwrap();
    for (from, to, words) in [
        ("vertex 0 1.2", "vertex x 1.2", "solid `a b`, triangle 1: invalid float literal"),
        ("vertex 0 1.2", "vertex 1e39 1.2", "solid `a b`, triangle 1: expected finite f32"),
        (
            "endfacet\nendsolid",
            "endsolid",
            "solid `a b`, triangle 4: expected [\"endfacet\"], got [\"endsolid\"",
        ),
        ("endsolid a b\n", "", "solid `a b`, triangle 5: EOF while expecting facet or endsolid"),
        ("endsolid a b\n", "endsolid\nmore", "`more` in place of `solid` or the end of the file"),
    ] {
        let message = refusal(text.replacen(from, to, 1));
        assert!(message.contains(words), "{message}");
    }
    assert_eq!(refusal("solid a\nendsolid a\n"), "no triangles; export a surface");
}

#[test]
fn ply_files_are_checked() {
    let text = String::from_utf8(tetrahedron().ply("ascii", "float", false)).unwrap();
    for (from, to, words) in [
        (
            "element face 4",
            "element face 4000000000",
            "the PLY header counts 4000000000 elements `face` of at least 2 bytes, and ",
        ),
        ("element vertex 4", "element vertex 18446744073709551616", "the PLY header is invalid"),
        ("element edge 1", "element edge 18446744073709551615", "elements `edge` of at least"),
        ("end_header", "endheader", "the PLY header has no line `end_header`"),
        ("format ascii", "format utf8", "the PLY header is invalid"),
        ("property float x", "property float w", "no element `vertex` with x, y and z"),
        ("vertex_indices", "corners", "no `vertex_indices` or `vertex_index`"),
        ("list uchar int", "list uchar float", "face 0, counted from 0: PLY property 'vertex_indices'"),
        ("1.1 0 0 7", "1.1 0", "vertex 1, counted from 0: Expected element of type"),
        ("1.1 0 0 7", "nan 0 0 7", "vertex 1, counted from 0: Couldn't parse element line"),
        ("1.1 0 0 7", "1e39 0 0 7", "vertex 1 has the coordinate inf; numbers must be finite"),
        ("3 0 1 3", "3 0 1 4", "face 1 refers to vertex 4 of 4, counted from 0"),
        ("3 0 1 3", "3 0 1 -1", "face 1 refers to vertex -1 of 4, counted from 0"),
        ("3 0 1 3", "4000000000 0 1 3", "face 1, counted from 0: "),
    ] {
        assert!(text.contains(from), "{from} in {text}");
        let message = refusal(text.replacen(from, to, 1));
        assert!(message.contains(words), "{message}");
    }
    let cloud = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n0 0 0\n";
    assert!(
        refusal(cloud)
            .starts_with("a PLY file without faces is a point cloud, which has no surface; reconstruct one")
    );
    for encoding in ["binary_little_endian", "binary_big_endian"] {
        let bytes = tetrahedron().ply(encoding, "double", false);
        for length in 4..bytes.len() {
            refusal(&bytes[..length]);
        }
    }
    // Elements without data of their own.
    let empty = text.replace("element edge 1\nproperty int a", "element edge 4000000000");
    let empty = empty.strip_suffix("1 \n").unwrap();
    assert!(model::from_bytes("x", empty.into()).is_ok());
}
