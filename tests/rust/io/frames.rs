//! Frames: the layouts of PLY and PC2, resuming, and files that are complete or absent.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use supple::{Mesh, VertexNormals};
use supple_io::frames::{Format, FrameWriter, OutputError, Sequence, Source};
use supple_io::obj::{Document, Part};
use tempfile::TempDir;

fn file(name: &str) -> PathBuf {
    supple_tests::root().join(name)
}

pub(crate) fn sequence(directory: &Path, format: Format) -> Sequence {
    Sequence { directory: directory.into(), name: "body".into(), format, first: 0, every: 1, last: 20 }
}

pub(crate) fn open(name: &str, object: Option<&str>) -> (Arc<Document>, Part) {
    let document = Arc::new(Document::read(file(name)).unwrap());
    let part = document.part(object).unwrap();
    (document, part)
}

pub(crate) fn rest(mesh: &Mesh) -> Vec<[f32; 3]> {
    mesh.vertices().iter().map(|vertex| vertex.cast::<f32>().into()).collect()
}

/// Reads the PLY files of the writer: vertices of six floats, then polygons.
fn read_ply(bytes: &[u8]) -> (Vec<[f32; 6]>, Vec<Vec<u32>>) {
    let end = b"end_header\n";
    let header = bytes.windows(end.len()).position(|window| window == end).unwrap() + end.len();
    let text = std::str::from_utf8(&bytes[..header]).unwrap();
    let count = |element: &str| -> usize {
        let line = text.lines().find_map(|line| line.strip_prefix(&format!("element {element} "))).unwrap();
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
fn ply_holds_positions_normals_and_faces() {
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
    assert_eq!(faces, part.mesh().triangles(), "mixed quads and triangles are written as triangles");
}

#[test]
fn ply_keeps_polygons_of_equal_size() {
    let (document, part) = open("tests/data/seams.obj", None);
    let directory = TempDir::new().unwrap();
    let source = Source::Document(&document, &part);
    let mut writer = FrameWriter::create(sequence(directory.path(), Format::Ply), source).unwrap();
    writer.write(0, &rest(part.mesh()), &[[0.0; 3]; 24]).unwrap();
    let (_, faces) = read_ply(&fs::read(directory.path().join("body_0000.ply")).unwrap());
    assert_eq!(faces, part.mesh().faces().collect::<Vec<_>>());
}

#[test]
fn ply_counts_more_than_255_corners_in_an_int() {
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
fn a_mesh_without_a_document_is_written_as_positions_and_faces() {
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

/// Returns the header and the samples of a point cache.
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
fn a_point_cache_has_the_pc2_layout_and_all_points_of_the_file() {
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
    assert_eq!(read_pc2(&part_file).0.4, 3, "the part file is valid while it is written");
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
fn a_point_cache_resumes_at_the_given_frame() {
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
    // As after a kill in the middle of a sample.
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

    // A finished cache can be extended as well.
    let mut writer = FrameWriter::resume(cached.clone(), source, 7).unwrap();
    write(&mut writer, 7..8);
    writer.finish().unwrap();
    assert_eq!(read_pc2(&done).0.4, 8);

    let error = FrameWriter::resume(cached.clone(), source, 12).unwrap_err().to_string();
    assert!(error.contains(": it has 8 of 12 frames to keep; "), "{error}");
    let (other, other_part) = open("tests/data/seams.obj", None);
    let error = FrameWriter::resume(cached, Source::Document(&other, &other_part), 2).unwrap_err();
    let OutputError::Cache { path, .. } = &error else { panic!("{error}") };
    assert_eq!(*path, done);
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
    assert!(error.to_string().starts_with(&format!("cannot write {}: ", taken.display())), "{error}");
    assert_eq!(fs::read_dir(root.path()).unwrap().count(), 1);

    let error = writer.write(1, &[[0.0; 3], [0.0, f32::NAN, 0.0], [0.0; 3]], &[]).unwrap_err();
    let expected = "frame 1 is not written: the position of vertex 1 (counted from 0) is not finite; ";
    assert!(error.to_string().starts_with(expected), "{error}");

    let blocked = sequence(&taken.join("sub"), Format::Pc2);
    fs::remove_dir(&taken).unwrap();
    fs::write(&taken, "a file").unwrap();
    let error = FrameWriter::create(blocked, Source::Mesh(&mesh)).unwrap_err();
    let expected = format!("cannot create {}: ", taken.join("sub").display());
    assert!(error.to_string().starts_with(&expected), "{error}");
}

#[test]
fn formats_are_named() {
    for format in Format::ALL {
        assert_eq!(format.to_string().parse(), Ok(format));
    }
    assert_eq!(
        "stl".parse::<Format>().unwrap_err().to_string(),
        "unknown format `stl`: it must be obj, ply, pc2, usd, usdz, html, glb, vat, vtu, lattice, film or gif"
    );
    assert_eq!(Format::default(), Format::Obj);
}
