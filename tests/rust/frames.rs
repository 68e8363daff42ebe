//! Frames: what an OBJ frame keeps of its input, the layouts of PLY and PC2, and files that are whole or not there.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use nalgebra::{Matrix3, Rotation3, Vector3};
use supple::frames::{Format, FrameWriter, OutputError, Sequence, Source, shared_normals};
use supple::mesh::{Mesh, VertexNormals};
use supple::obj::{Document, Part};
use tempfile::TempDir;

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../").join(name)
}

fn sequence(directory: &Path, format: Format) -> Sequence {
    Sequence { directory: directory.into(), name: "body".into(), format, first: 0, every: 1, last: 20 }
}

fn open(name: &str, object: Option<&str>) -> (Arc<Document>, Part) {
    let document = Arc::new(Document::read(file(name)).unwrap());
    let part = document.part(object).unwrap();
    (document, part)
}

fn rest(mesh: &Mesh) -> Vec<[f32; 3]> {
    mesh.vertices().iter().map(|vertex| vertex.cast::<f32>().into()).collect()
}

/// Writes frame 0 of a file as OBJ, and returns its text.
fn obj_frame(document: &Arc<Document>, part: &Part, positions: &[[f32; 3]]) -> Vec<u8> {
    let directory = TempDir::new().unwrap();
    let source = Source::Document(document, part);
    let mut writer = FrameWriter::create(sequence(directory.path(), Format::Obj), source).unwrap();
    writer.write(0, positions, &[]).unwrap();
    writer.finish().unwrap();
    fs::read(directory.path().join("body_0000.obj")).unwrap()
}

/// The lines with their ends; lines that continue another are lines of their own.
fn lines(text: &[u8]) -> Vec<&[u8]> {
    text.split_inclusive(|&byte| byte == b'\n').collect()
}

fn numbers(line: &[u8]) -> Vec<f32> {
    let text: String = line.iter().map(|&byte| char::from(byte)).collect();
    text.split_whitespace().filter_map(|word| word.parse().ok()).collect()
}

#[test]
fn a_frame_keeps_every_byte_but_positions_normals_and_libraries() {
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
fn an_undeformed_frame_has_the_numbers_of_the_input() {
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
        "written in shortest form already"
    );
}

#[test]
fn an_object_moves_and_the_rest_keeps_its_text() {
    let (document, part) = open("examples/scenes/bust_parts.obj", Some("tongue"));
    let positions: Vec<_> = rest(part.mesh()).into_iter().map(|[x, y, z]| [x + 1.0, y, z]).collect();
    let frame = obj_frame(&document, &part, &positions);
    let again = Document::from_bytes("again.obj", frame.clone()).unwrap();
    assert_eq!(rest(&again.mesh(Some("tongue")).unwrap()), positions);
    let (input, output) = (lines(document.bytes()), lines(&frame));
    let changed = input.iter().zip(&output).filter(|(before, after)| before != after).count();
    assert_eq!(changed, part.mesh().vertices().len() + 1, "its vertices and the mtllib");
}

/// The `vn` of a text.
fn written_normals(text: &[u8]) -> Vec<Vector3<f64>> {
    let is_normal = |line: &&[u8]| line.starts_with(b"vn ");
    lines(text)
        .into_iter()
        .filter(is_normal)
        .map(|line| Vector3::from_row_slice(&numbers(line)).cast())
        .collect()
}

#[test]
fn normals_turn_with_the_surface_whatever_they_are() {
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
    assert_eq!(shared_normals(&document, &part), 6);
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
    // A sphere with its exact normals, made twice as long: those of the ellipsoid.
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
    assert_eq!(shared_normals(&document, &part), 0);
    let positions: Vec<[f32; 3]> = rest(part.mesh()).into_iter().map(|[x, y, z]| [2.0 * x, y, z]).collect();
    let written = written_normals(&obj_frame(&document, &part, &positions));
    for (normal, [x, y, z]) in written.iter().zip(rest(part.mesh())) {
        let expected = Vector3::new(x / 2.0, y, z).cast::<f64>().normalize();
        let angle = normal.angle(&expected).to_degrees();
        // A vertex at a pole has one corner, and nothing to take a mean of.
        let most = if z.abs() == 1.0 { 2.0 } else { 0.25 };
        assert!(angle < most, "at ({x}, {y}, {z}) off by {angle} degrees");
    }
}

#[test]
fn collapsed_faces_give_finite_normals() {
    let (document, part) = open("tests/data/hard_edges.obj", None);
    for collapse in
        [|_: [f32; 3]| [1.0; 3], |[x, _, _]: [f32; 3]| [x, 0.0, 0.0], |[x, y, _]: [f32; 3]| [x, y, 0.0]]
    {
        let positions: Vec<_> = rest(part.mesh()).into_iter().map(collapse).collect();
        for normal in written_normals(&obj_frame(&document, &part, &positions)) {
            assert!((normal.norm() - 1.0).abs() < 1e-6);
        }
    }
}

#[test]
fn libraries_resolve_from_the_output_directory() {
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
    assert_eq!(frame("in put"), head.clone() + triangle, "right as it is");
    assert!(
        frame("in put/new")
            .starts_with("mtllib ../a b.mtl  ../c.mtl\nmtllib ../sub/d.mtl ../../e.mtl # why\n")
    );
    let document = Document::read(at("out/deep/body_0003.obj")).unwrap();
    let found: Vec<_> = document.libraries().iter().map(|library| library.exists).collect();
    assert_eq!(found, [true, true, true, true, true, false, true]);
}

/// Reads what this PLY writer writes: vertices of six floats, polygons.
fn read_ply(bytes: &[u8]) -> (Vec<[f32; 6]>, Vec<Vec<u32>>) {
    let end = b"end_header\n";
    let header = bytes.windows(end.len()).position(|window| window == end).unwrap() + end.len();
    let text = std::str::from_utf8(&bytes[..header]).unwrap();
    let count = |what: &str| -> usize {
        let line = text.lines().find_map(|line| line.strip_prefix(&format!("element {what} "))).unwrap();
        line.parse().unwrap()
    };
    let wide = text.contains("property list int int vertex_indices");
    assert!(wide || text.contains("property list uchar int vertex_indices"));
    let mut at = header;
    let mut take = |length: usize| {
        at += length;
        &bytes[at - length..at]
    };
    let float = |bytes: &[u8]| f32::from_le_bytes(bytes.try_into().unwrap());
    let vertices = (0..count("vertex")).map(|_| std::array::from_fn(|_| float(take(4)))).collect();
    let mut faces = Vec::new();
    for _ in 0..count("face") {
        let corners =
            if wide { u32::from_le_bytes(take(4).try_into().unwrap()) } else { u32::from(take(1)[0]) };
        faces.push((0..corners).map(|_| u32::from_le_bytes(take(4).try_into().unwrap())).collect());
    }
    assert_eq!(at, bytes.len());
    (vertices, faces)
}

#[test]
fn ply_holds_positions_normals_and_polygons() {
    let (document, part) = open("examples/scenes/bust.obj", None);
    let directory = TempDir::new().unwrap();
    let source = Source::Document(&document, &part);
    let mut writer = FrameWriter::create(sequence(directory.path(), Format::Ply), source).unwrap();
    let positions = rest(part.mesh());
    let mut normals = vec![[0.0; 3]; positions.len()];
    VertexNormals::new(part.mesh()).compute(&positions, &mut normals);
    assert!(writer.needs_normals());
    writer.write(12, &positions, &normals).unwrap();
    let bytes = fs::read(directory.path().join("body_0012.ply")).unwrap();
    assert_eq!(bytes.len() as u64, source.frame_bytes(Format::Ply));
    let (vertices, faces) = read_ply(&bytes);
    for ((vertex, position), normal) in vertices.iter().zip(&positions).zip(&normals) {
        assert_eq!((&vertex[..3], &vertex[3..]), (&position[..], &normal[..]));
    }
    assert_eq!(faces, part.mesh().faces().collect::<Vec<_>>());
}

#[test]
fn ply_counts_corners_in_an_int_where_a_byte_is_too_small() {
    let corner = |k: u32| [f64::from(k).cos(), f64::from(k).sin(), 0.0];
    let mesh =
        Mesh::new((0..300).map(corner).collect(), &[(0..300).collect::<Vec<u32>>(), vec![0, 1]]).unwrap();
    let directory = TempDir::new().unwrap();
    let mut writer =
        FrameWriter::create(sequence(directory.path(), Format::Ply), Source::Mesh(&mesh)).unwrap();
    writer.write(0, &rest(&mesh), &vec![[0.0, 0.0, 1.0]; 300]).unwrap();
    let (_, faces) = read_ply(&fs::read(directory.path().join("body_0000.ply")).unwrap());
    assert_eq!(faces, [(0..300).collect::<Vec<u32>>()]);
}

#[test]
fn a_mesh_of_arrays_is_written_plainly() {
    let mesh =
        Mesh::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.5, 0.0]], &[vec![0, 1, 2], vec![0, 1]]).unwrap();
    let directory = TempDir::new().unwrap();
    let mut long = sequence(directory.path(), Format::Obj);
    long.last = 123_456;
    let mut writer = FrameWriter::create(long, Source::Mesh(&mesh)).unwrap();
    writer.write(7, &rest(&mesh), &[]).unwrap();
    let text = fs::read_to_string(directory.path().join("body_000007.obj")).unwrap();
    assert_eq!(text, "v 0 0 0\nv 1 0 0\nv 0 0.5 0\nf 1 2 3\n");
}

/// The header and the samples of a point cache.
fn read_pc2(path: &Path) -> ((u32, u32, f32, f32, u32), Vec<f32>) {
    let bytes = fs::read(path).unwrap();
    assert_eq!(&bytes[..12], b"POINTCACHE2\0");
    let word = |at: usize| <[u8; 4]>::try_from(&bytes[at..at + 4]).unwrap();
    let int = |at| u32::from_le_bytes(word(at));
    let float = |at| f32::from_le_bytes(word(at));
    let samples = (32..bytes.len()).step_by(4).map(float).collect();
    ((int(12), int(16), float(20), float(24), int(28)), samples)
}

#[test]
fn a_point_cache_has_the_published_layout_and_all_points() {
    let (document, part) = open("tests/data/odd.obj", Some("front"));
    let directory = TempDir::new().unwrap();
    let mut cached = sequence(directory.path(), Format::Pc2);
    (cached.first, cached.every) = (5, 2);
    let source = Source::Document(&document, &part);
    let mut writer = FrameWriter::create(cached, source).unwrap();
    for frame in 0..3 {
        writer.write(5 + 2 * frame, &[[frame as f32; 3]; 4], &[]).unwrap();
    }
    let part_file = directory.path().join("body.pc2.part");
    assert_eq!(read_pc2(&part_file).0.4, 3, "readable while it is written");
    writer.finish().unwrap();
    assert!(!part_file.exists());
    let (header, samples) = read_pc2(&directory.path().join("body.pc2"));
    assert_eq!(header, (1, 9, 5.0, 2.0, 3));
    assert_eq!(samples.len(), 3 * 9 * 3);
    let sample = &samples[27..54];
    assert_eq!(sample[..12], [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0]);
    assert_eq!(sample[12..24], [1.0; 12]);
    assert_eq!(sample[24..], [9.0; 3]);
}

#[test]
fn a_point_cache_goes_on_where_it_is_told() {
    let (document, part) = open("tests/data/ngon.obj", None);
    let source = Source::Document(&document, &part);
    let directory = TempDir::new().unwrap();
    let cached = sequence(directory.path(), Format::Pc2);
    let write = |writer: &mut FrameWriter, frames: std::ops::Range<u64>| {
        frames.for_each(|frame| writer.write(frame, &[[frame as f32; 3]; 6], &[]).unwrap());
    };
    let mut writer = FrameWriter::create(cached.clone(), source).unwrap();
    write(&mut writer, 0..5);
    drop(writer);
    // A kill in the middle of a sample.
    let part_file = directory.path().join("body.pc2.part");
    let mut bytes = fs::read(&part_file).unwrap();
    bytes.extend_from_slice(&[7; 30]);
    fs::write(&part_file, bytes).unwrap();

    let mut writer = FrameWriter::resume(cached.clone(), source, 3).unwrap();
    write(&mut writer, 3..7);
    writer.finish().unwrap();
    let done = directory.path().join("body.pc2");
    let (header, samples) = read_pc2(&done);
    assert_eq!(header.4, 7);
    assert_eq!(samples, (0..7).flat_map(|frame| [frame as f32; 18]).collect::<Vec<_>>());

    // A finished one, too.
    let mut writer = FrameWriter::resume(cached.clone(), source, 7).unwrap();
    write(&mut writer, 7..8);
    writer.finish().unwrap();
    assert_eq!(read_pc2(&done).0.4, 8);

    let error = FrameWriter::resume(cached.clone(), source, 12).unwrap_err().to_string();
    assert!(error.ends_with("it holds 8 of the 12 frames before"), "{error}");
    let (other, other_part) = open("tests/data/seams.obj", None);
    let error = FrameWriter::resume(cached, Source::Document(&other, &other_part), 2).unwrap_err();
    assert!(matches!(error, OutputError::Cache { .. }), "{error}");
}

#[test]
fn an_older_sequence_is_replaced_whole_and_nothing_else() {
    let directory = TempDir::new().unwrap();
    let own = ["body_0000.obj", "body_0017.obj", "body_123456.obj", "body_0003.obj.part"];
    let others = [
        "body.obj",
        "body_12.obj",
        "body_0000.ply",
        "body_2_0000.obj",
        "abody_0000.obj",
        "body_0000.obj.bak",
        "body_00a0.obj",
        "body.pc2",
        "Body_0000.obj",
    ];
    own.iter().chain(&others).for_each(|name| fs::write(directory.path().join(name), "x").unwrap());
    let mesh = Mesh::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.5, 0.0]], &[[0, 1, 2]]).unwrap();
    let frames = sequence(directory.path(), Format::Obj);
    assert_eq!(frames.existing().unwrap().len(), own.len());

    let writer = FrameWriter::resume(frames.clone(), Source::Mesh(&mesh), 1).unwrap();
    drop(writer);
    assert_eq!(frames.existing().unwrap().len(), own.len() - 1, "a half-written file does not stay");

    let mut writer = FrameWriter::create(frames.clone(), Source::Mesh(&mesh)).unwrap();
    writer.write(0, &rest(&mesh), &[]).unwrap();
    assert_eq!(frames.existing().unwrap(), [directory.path().join("body_0000.obj")]);
    assert!(others.iter().all(|name| directory.path().join(name).exists()));
}

#[test]
fn the_input_is_never_replaced() {
    let directory = TempDir::new().unwrap();
    let input = directory.path().join("body_0000.obj");
    fs::copy(file("tests/data/ngon.obj"), &input).unwrap();
    let document = Arc::new(Document::read(&input).unwrap());
    let part = document.part(None).unwrap();
    let create =
        |format| FrameWriter::create(sequence(directory.path(), format), Source::Document(&document, &part));
    let error = create(Format::Obj).unwrap_err();
    assert!(matches!(error, OutputError::OverwritesInput { .. }), "{error}");
    create(Format::Pc2).unwrap();
    assert_eq!(fs::read(&input).unwrap(), document.bytes());
}

#[test]
fn a_failed_frame_leaves_nothing_behind() {
    let root = TempDir::new().unwrap();
    let mesh = Mesh::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.5, 0.0]], &[[0, 1, 2]]).unwrap();
    let frames = sequence(root.path(), Format::Obj);
    let mut writer = FrameWriter::create(frames, Source::Mesh(&mesh)).unwrap();
    // A directory where the frame should be: the rename fails.
    let taken = root.path().join("body_0000.obj");
    fs::create_dir(&taken).unwrap();
    let error = writer.write(0, &rest(&mesh), &[]).unwrap_err();
    assert!(error.to_string().contains("body_0000.obj"), "{error}");
    assert_eq!(fs::read_dir(root.path()).unwrap().count(), 1);

    let error = writer.write(1, &[[0.0; 3], [0.0, f32::NAN, 0.0], [0.0; 3]], &[]).unwrap_err();
    assert_eq!(error.to_string(), "frame 1 is not written: vertex 1 (counted from 0) is not finite");

    let blocked = sequence(&taken.join("sub"), Format::Pc2);
    fs::remove_dir(&taken).unwrap();
    fs::write(&taken, "a file").unwrap();
    let error = FrameWriter::create(blocked, Source::Mesh(&mesh)).unwrap_err();
    assert!(error.to_string().starts_with("cannot create "), "{error}");
}

#[test]
fn formats_are_named() {
    for format in Format::ALL {
        assert_eq!(format.to_string().parse(), Ok(format));
    }
    assert_eq!(
        "stl".parse::<Format>().unwrap_err().to_string(),
        "unknown format `stl`: it must be obj, ply or pc2"
    );
    assert_eq!(Format::default(), Format::Obj);
}
