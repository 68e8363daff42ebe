//! OBJ frames: text kept from the input, transformed normals, paths of material libraries.

use std::fs;
use std::sync::Arc;

use nalgebra::{Matrix3, Rotation3, Vector3};
use supple_io::frames::{Format, FrameWriter, Source, count_shared_normals};
use supple_io::obj::{Document, Part};
use tempfile::TempDir;

use crate::frames::{open, rest, sequence};

/// Writes frame 0 of a file as OBJ and returns its text.
fn obj_frame(document: &Arc<Document>, part: &Part, positions: &[[f32; 3]]) -> Vec<u8> {
    let directory = TempDir::new().unwrap();
    let source = Source::Document(document, part);
    let mut writer = FrameWriter::create(sequence(directory.path(), Format::Obj), source).unwrap();
    writer.write(0, positions, &[]).unwrap();
    writer.finish().unwrap();
    fs::read(directory.path().join("body_0000.obj")).unwrap()
}

/// Splits a text into lines with their line ends. Continuation lines are separate lines.
fn lines(text: &[u8]) -> Vec<&[u8]> {
    text.split_inclusive(|&byte| byte == b'\n').collect()
}

fn numbers(line: &[u8]) -> Vec<f32> {
    let text: String = line.iter().map(|&byte| char::from(byte)).collect();
    text.split_whitespace().filter_map(|word| word.parse().ok()).collect()
}

#[test]
fn a_frame_keeps_every_byte_except_positions_normals_and_library_paths() {
    let (document, part) = open("tests/data/odd.obj", None);
    let mut positions = rest(part.mesh());
    positions.iter_mut().for_each(|position| *position = position.map(|x| 0.1 + x * 1.7));
    let frame = obj_frame(&document, &part, &positions);
    let (input, output) = (lines(document.bytes()), lines(&frame));
    assert_eq!(input.len(), output.len());
    let mut changed = Vec::new();
    for (number, (before, after)) in input.iter().zip(&output).enumerate() {
        if before != after {
            changed.push((number + 1, String::from_utf8_lossy(after).into_owned()));
        }
    }
    let texts: Vec<_> = changed.iter().map(|(number, text)| (*number, text.as_str())).collect();
    assert!(texts[0].1.starts_with("mtllib  ") && texts[0].1.ends_with("odd.mtl # two libraries\r\n"));
    let expected = [
        (4, "  v\t0.1 0.1 0.1 0.25 0.5 0.75\r\n"),
        (5, "v 1.8000001 0.1 0.1 1.0\r\n"),
        (6, "v 0.1 1.8000001 0.1 # third\r\n"),
        (7, "v 1.8000001 \\\r\n"),
        (8, "   1.8000001 \\\r\n"),
        (9, "   0.1 0.1 0.2 0.3\r\n"),
        (10, "v 0.1 0.1 1.8000001\r\n"),
        (11, "v 1.8000001 0.1 1.8000001\r\n"),
        (12, "v 0.1 1.8000001 1.8000001\r\n"),
        (13, "v 1.8000001 1.8000001 1.8000001\r\n"),
        (14, "v 15.400001 15.400001 15.400001\r\n"),
        (18, "vn 0 0 1 \r\n"),
    ];
    assert_eq!(texts[1..], expected);
}

#[test]
fn an_undeformed_frame_has_the_same_numbers_as_the_input() {
    for name in ["tests/data/odd.obj", "examples/scenes/bust.obj", "tests/data/hard_edges.obj"] {
        let (document, part) = open(name, None);
        let frame = obj_frame(&document, &part, &rest(part.mesh()));
        let again = Document::from_bytes("again.obj", frame.clone()).unwrap().mesh(None).unwrap();
        assert_eq!(rest(part.mesh()), rest(&again), "{name}");
        for (before, after) in lines(document.bytes()).iter().zip(lines(&frame)) {
            if !before.starts_with(b"mtllib") {
                let bits = |line| numbers(line).into_iter().map(f32::to_bits).collect::<Vec<_>>();
                assert_eq!(bits(before), bits(after), "{name}");
            }
        }
    }
    let bust = open("examples/scenes/bust.obj", None);
    assert_eq!(
        obj_frame(&bust.0, &bust.1, &rest(bust.1.mesh())),
        bust.0.bytes(),
        "the numbers of the bust are in shortest form already"
    );
}

#[test]
fn a_frame_of_one_object_changes_only_its_vertices_and_the_library_path() {
    let (document, part) = open("examples/scenes/bust_parts.obj", Some("tongue"));
    let positions: Vec<_> = rest(part.mesh()).into_iter().map(|[x, y, z]| [x + 1.0, y, z]).collect();
    let frame = obj_frame(&document, &part, &positions);
    let again = Document::from_bytes("again.obj", frame.clone()).unwrap();
    assert_eq!(rest(&again.mesh(Some("tongue")).unwrap()), positions);
    let (input, output) = (lines(document.bytes()), lines(&frame));
    let changed = input.iter().zip(&output).filter(|(before, after)| before != after).count();
    assert_eq!(changed, part.mesh().vertices().len() + 1, "its vertices and the mtllib");
}

/// Returns the `vn` of an OBJ text.
fn written_normals(text: &[u8]) -> Vec<Vector3<f64>> {
    let is_normal = |line: &&[u8]| line.starts_with(b"vn ");
    lines(text)
        .into_iter()
        .filter(is_normal)
        .map(|line| Vector3::from_row_slice(&numbers(line)).cast())
        .collect()
}

#[test]
fn normals_rotate_with_the_surface_at_any_scale() {
    // Smooth, hard and arbitrary normals on a quad, a triangle and a pentagon with a corner of 180 degrees.
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0.2\nv 0 1 0\nv 2 0.5 1\nv 0.5 0 0\n\
                vn 0 0 1\nvn 0.6 0 0.8\nvn -0.1 0.7 -0.3\nvn 5 0 0\n\
                f 1//1 6//3 2//2 3//3 4//1\nf 2//2 5//4 3//4\nf 3//3 4//2 1//1\n";
    let document = Arc::new(Document::from_bytes("x.obj", text.into()).unwrap());
    let part = document.part(None).unwrap();
    let turn = Rotation3::from_euler_angles(1.0, -0.4, 2.5);
    for scale in [1.0, 1e-12, 1e12] {
        let place =
            |[x, y, z]: [f32; 3]| (turn * Vector3::new(x, y, z).cast::<f64>() * scale).cast::<f32>().into();
        let positions: Vec<[f32; 3]> = rest(part.mesh()).into_iter().map(place).collect();
        let written = written_normals(&obj_frame(&document, &part, &positions));
        for (normal, input) in written.iter().zip(written_normals(text.as_bytes())) {
            let expected = turn * input.normalize();
            assert!((normal - expected).norm() < 2e-6, "scale {scale}: {normal} is not {expected}");
        }
    }
}

#[test]
fn hard_edges_stay_hard_under_any_linear_deformation() {
    let (document, part) = open("tests/data/hard_edges.obj", None);
    assert_eq!(count_shared_normals(&document, &part), 6);
    let shear = Matrix3::new(2.0, 0.3, 0.0, -0.1, 0.5, 0.7, 0.4, 0.0, 1.5);
    let covariant = shear.try_inverse().unwrap().transpose();
    let deform = |[x, y, z]: [f32; 3]| (shear * Vector3::new(x, y, z).cast::<f64>()).cast::<f32>().into();
    let positions: Vec<[f32; 3]> = rest(part.mesh()).into_iter().map(deform).collect();
    let frame = obj_frame(&document, &part, &positions);
    for (normal, input) in written_normals(&frame).iter().zip(written_normals(document.bytes())) {
        assert!((normal - (covariant * input).normalize()).norm() < 1e-6);
    }
}

#[test]
fn smooth_normals_follow_a_stretch() {
    // A sphere with exact normals, stretched to an ellipsoid: the expected normals are those of the
    // ellipsoid.
    let (mut text, mut faces) = (String::new(), String::new());
    let (rings, sectors) = (24, 48);
    for ring in 0..=rings {
        for sector in 0..sectors {
            let (a, b) = (
                std::f64::consts::PI * f64::from(ring) / f64::from(rings),
                std::f64::consts::TAU * f64::from(sector) / f64::from(sectors),
            );
            let point = [a.sin() * b.cos(), a.sin() * b.sin(), a.cos()].map(|x| x as f32);
            text += &format!("v {0} {1} {2}\nvn {0} {1} {2}\n", point[0], point[1], point[2]);
            if ring < rings {
                let corner = |ring: i32, sector: i32| 1 + ring * sectors + sector % sectors;
                let quad = [
                    corner(ring, sector),
                    corner(ring + 1, sector),
                    corner(ring + 1, sector + 1),
                    corner(ring, sector + 1),
                ];
                faces += "f";
                quad.iter().for_each(|index| faces += &format!(" {index}//{index}"));
                faces += "\n";
            }
        }
    }
    let document = Arc::new(Document::from_bytes("x.obj", (text + &faces).into_bytes()).unwrap());
    let part = document.part(None).unwrap();
    assert_eq!(count_shared_normals(&document, &part), 0);
    let positions: Vec<[f32; 3]> = rest(part.mesh()).into_iter().map(|[x, y, z]| [2.0 * x, y, z]).collect();
    let written = written_normals(&obj_frame(&document, &part, &positions));
    for (normal, [x, y, z]) in written.iter().zip(rest(part.mesh())) {
        let expected = Vector3::new(x / 2.0, y, z).cast::<f64>().normalize();
        let angle = normal.angle(&expected).to_degrees();
        // Regression bounds. A vertex at a pole has only one corner, so its normal is not a mean over several
        // faces.
        let limit = if z.abs() == 1.0 { 2.0 } else { 0.25 };
        assert!(angle < limit, "at ({x}, {y}, {z}) off by {angle} degrees");
    }
}

#[test]
fn normals_of_collapsed_faces_are_unit_vectors() {
    let (document, part) = open("tests/data/hard_edges.obj", None);
    let to_point = |_: [f32; 3]| [1.0_f32; 3];
    let to_line = |[x, _, _]: [f32; 3]| [x, 0.0, 0.0];
    let to_plane = |[x, y, _]: [f32; 3]| [x, y, 0.0];
    // The faces along x and y keep their area in the plane, so their normals along z stay.
    for (collapse, keeps_z) in
        [(to_point as fn([f32; 3]) -> [f32; 3], false), (to_line, false), (to_plane, true)]
    {
        let positions: Vec<_> = rest(part.mesh()).into_iter().map(collapse).collect();
        let written = written_normals(&obj_frame(&document, &part, &positions));
        for (normal, input) in written.iter().zip(written_normals(document.bytes())) {
            assert!((normal.norm() - 1.0).abs() < 1e-6);
            assert!(!keeps_z || input.z == 0.0 || *normal == input, "{normal} is not {input}");
        }
    }
}

#[test]
fn library_paths_are_rewritten_to_resolve_from_the_output_directory() {
    let root = TempDir::new().unwrap();
    let at = |path: &str| root.path().join(path);
    fs::create_dir_all(at("in put/sub")).unwrap();
    fs::create_dir_all(at("out/deep")).unwrap();
    for name in ["in put/a b.mtl", "in put/c.mtl", "in put/sub/d.mtl", "e.mtl"] {
        fs::write(at(name), "newmtl m\n").unwrap();
    }
    let absolute = at("e.mtl").display().to_string();
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let head = format!(
        "mtllib a b.mtl  c.mtl\nmtllib sub/d.mtl ../e.mtl # why\nmtllib {absolute}\nmtllib gone.mtl\nmtllib sub\\d.mtl\n"
    );
    fs::write(at("in put/x.obj"), head.clone() + triangle).unwrap();
    let frame = |output: &str| {
        let document = Arc::new(Document::read(at("in put/x.obj")).unwrap());
        let part = document.part(None).unwrap();
        let source = Source::Document(&document, &part);
        let mut writer = FrameWriter::create(sequence(&at(output), Format::Obj), source).unwrap();
        writer.write(3, &rest(part.mesh()), &[]).unwrap();
        fs::read_to_string(at(output).join("body_0003.obj")).unwrap()
    };
    let expected = format!(
        "mtllib ../../in put/a b.mtl  ../../in put/c.mtl\nmtllib ../../in put/sub/d.mtl ../../e.mtl # why\n\
         mtllib {absolute}\nmtllib ../../in put/gone.mtl\nmtllib ../../in put/sub/d.mtl\n"
    );
    assert_eq!(frame("out/deep"), expected + triangle);
    assert_eq!(frame("in put"), head.clone() + triangle, "the paths are valid already");
    assert!(
        frame("in put/new")
            .starts_with("mtllib ../a b.mtl  ../c.mtl\nmtllib ../sub/d.mtl ../../e.mtl # why\n")
    );
    let document = Document::read(at("out/deep/body_0003.obj")).unwrap();
    let found: Vec<_> = document.libraries().iter().map(|library| library.exists).collect();
    assert_eq!(found, [true, true, true, true, true, false, true]);
}
