//! Each format gives the surface of the OBJ file with the same numbers.

use supple::Mesh;
use supple_io::model;
use supple_io::obj::Document;

use super::files::{Shape, cube, shapes, tetrahedron};

/// Reads a file whose extension says nothing.
fn read(bytes: Vec<u8>) -> Document {
    model::from_bytes("model", bytes).unwrap()
}

fn mesh(bytes: Vec<u8>) -> Mesh {
    read(bytes).mesh(None).unwrap()
}

/// Asserts that a surface has the vertices and faces of a shape, with the same bits as from its OBJ file.
fn assert_same(found: &Mesh, shape: &Shape) {
    let expected = shape.mesh();
    assert_eq!(found.vertices(), expected.vertices());
    assert!(found.faces().eq(expected.faces()));
    for (found, expected) in found.vertices().iter().zip(&shape.vertices) {
        assert_eq!(
            found.cast::<f32>().coords.map(f32::to_bits),
            nalgebra::Vector3::from(expected.map(f32::to_bits))
        );
    }
}

/// Asserts that a surface has the triangles of a shape, and each position once.
fn assert_welded(found: &Mesh, shape: &Shape) {
    let corners: Vec<[f32; 3]> = found
        .faces()
        .flatten()
        .map(|&vertex| found.vertices()[vertex as usize].cast::<f32>().into())
        .collect();
    assert_eq!(corners, shape.corners());
    let mut positions: Vec<[u32; 3]> = shape.corners().iter().map(|p| p.map(f32::to_bits)).collect();
    positions.sort_unstable();
    positions.dedup();
    assert_eq!(found.vertices().len(), positions.len());
    assert_eq!(found.is_closed(), shape.mesh().is_closed());
}

/// Returns the texture coordinates of all corners.
fn coordinates(document: &Document) -> Vec<[f32; 2]> {
    let appearance = document.appearance(&document.part(None).unwrap());
    appearance.corners.iter().map(|&corner| appearance.coordinates[corner as usize]).collect()
}

#[test]
fn ply_files_of_all_encodings_have_the_faces_and_numbers_of_the_obj_file() {
    for shape in shapes() {
        for encoding in ["ascii", "binary_little_endian", "binary_big_endian"] {
            for kind in ["float", "double"] {
                let document = read(shape.ply(encoding, kind, false));
                assert_same(&document.mesh(None).unwrap(), &shape);
                assert_eq!(document.ignored_parts(), ["1 element `edge`"]);
                assert!(coordinates(&document).is_empty());
            }
            let expected: Vec<_> =
                shape.faces.iter().flatten().map(|&v| shape.coordinates()[v as usize]).collect();
            assert_eq!(coordinates(&read(shape.ply(encoding, "float", true))), expected);
        }
    }
}

#[test]
fn stl_files_are_welded_and_have_the_triangles_of_the_obj_file() {
    for shape in shapes().map(|shape| shape.triangulated()) {
        for bytes in [
            shape.stl_binary("made by a test"),
            shape.stl_binary("solid made by a test"),
            shape.stl_text(&["a b"]),
            shape.stl_text(&[""]),
            shape.stl_text(&["a", "b"]),
            shape.stl_text(&["a"]).to_ascii_uppercase(),
        ] {
            assert_welded(&mesh(bytes), &shape);
        }
        let solids = read(shape.stl_text(&["the head", ""]));
        assert_eq!(solids.groups().map(|group| &*group.name).collect::<Vec<_>>(), ["the head", "solid 2"]);
        assert!(solids.mesh(Some("the head")).unwrap().face_count() < shape.faces.len());
    }
}

#[test]
fn glb_and_gltf_files_have_the_triangles_and_numbers_of_the_obj_file() {
    let folder = tempfile::tempdir().unwrap();
    for shape in shapes().map(|shape| shape.triangulated()) {
        let gltf = shape.gltf(true);
        std::fs::write(folder.path().join("my buffer.bin"), &gltf.buffer).unwrap();
        let path = folder.path().join("model.gltf");
        let separate = model::from_bytes(path, gltf.json("my%20buffer.bin")).unwrap();
        for document in [read(gltf.glb()), read(gltf.embedded()), separate] {
            let found = document.mesh(None).unwrap();
            assert_welded(&found, &shape);
            // The shape has each position once, unless it has seams.
            if found.vertices().len() == shape.vertices.len() {
                assert_same(&found, &shape);
            }
            let expected: Vec<_> =
                shape.faces.iter().flatten().map(|&v| shape.coordinates()[v as usize]).collect();
            assert_eq!(coordinates(&document), expected);
        }
    }
}

#[test]
fn the_content_of_a_file_determines_its_format_and_else_its_extension() {
    let cube = cube().triangulated();
    let files = [
        cube.obj().into_bytes(),
        cube.gltf(false).glb(),
        cube.gltf(false).embedded(),
        cube.stl_binary("x"),
        cube.stl_text(&["x"]),
        cube.ply("ascii", "float", false),
    ];
    for extension in ["obj", "glb", "gltf", "stl", "ply", "OBJ", "dat"] {
        for bytes in &files {
            let document = model::from_bytes(format!("model.{extension}"), bytes.clone()).unwrap();
            assert_eq!(document.mesh(None).unwrap().face_count(), 12, "{extension}");
        }
    }
    let message = |name: &str| model::from_bytes(name, b"hello\n".to_vec()).unwrap_err().to_string();
    assert_eq!(
        message("a.fbx"),
        "a.fbx: files with the extension .fbx are not read; give a model: OBJ (.obj), GLB (.glb), glTF (.gltf), STL (.stl) \
         or PLY (.ply)"
    );
    assert!(message("a").starts_with("a: files without an extension are not read; give a model"));
    for name in ["a.obj", "a.stl", "a.ply", "a.glb", "a.gltf"] {
        assert!(message(name).starts_with(name), "{}", message(name));
    }
    assert!(
        model::read("no such file.glb", None)
            .unwrap_err()
            .to_string()
            .starts_with("no such file.glb: cannot be read")
    );
}

#[test]
fn numbers_of_64_bits_keep_their_digits() {
    let text = "ply\nformat ascii 1.0\nelement vertex 3\nproperty double x\nproperty double y\nproperty double z\n\
                element face 2\nproperty list uint8 int32 vertex_index\nproperty list uint8 float texcoord\nend_header\n\
                1000000.123456789 0 0\n1000001 0 0\n1000000 1e-30 1\n3 0 1 2 6 0 0 0.5 0 0 0.25\n2 0 1 0\n";
    let document = read(text.into());
    assert_eq!(document.mesh(None).unwrap().vertices()[0].x, 1000000.123456789);
    assert_eq!(document.mesh(None).unwrap().vertices()[2].y, 1e-30);
    assert_eq!(coordinates(&document), [[0.0, 0.0], [0.5, 0.0], [0.0, 0.25]]);
    assert_eq!(document.ignored_parts(), ["1 face of fewer than three corners"]);
}

#[test]
fn triangles_without_area_are_read() {
    let mut shape = tetrahedron();
    shape.faces.push(vec![0, 0, 1]);
    assert_eq!(mesh(shape.stl_binary("")).face_count(), 5);
    assert_eq!(mesh(shape.gltf(false).glb()).face_count(), 5);
    assert_eq!(mesh(shape.ply("ascii", "float", false)).face_count(), 5);
}
