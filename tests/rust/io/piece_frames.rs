//! Frames of broken bodies: files with the mesh of the pieces.

use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::sync::{Arc, Mutex};

use nalgebra::Point3;
use supple::mesh::Mesh;
use supple::{Body, FaceSource, Material, Simulation, VolumeMeasure};
use supple_io::frames::{Format, FrameWriter, OutputError, Pieces, Source};
use supple_io::obj::{Document, Part};
use supple_io::run::{Flow, Input, Job, Observer, Outcome, Progress};
use supple_io::scene::Scene;
use tempfile::TempDir;

use crate::frames::sequence;

fn open(text: &str, object: Option<&str>) -> (Arc<Document>, Part) {
    let document = Arc::new(Document::from_bytes("body.obj", text.into()).unwrap());
    let part = document.part(object).unwrap();
    (document, part)
}

/// A box of 4 x 1 x 1 whose sides are quads with `vt` in units of length and a `vn` per side.
fn bar_text(indices: impl Fn(usize, usize, usize) -> String) -> String {
    let mut text = "# a bar\nmtllib bar.mtl\no bar\n".to_owned();
    let mut place = std::collections::HashMap::new();
    let (mut coordinates, mut faces) = (String::new(), String::new());
    let (mut vt, mut normals) = (0, String::new());
    let size = [4, 1, 1];
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        for side in 0..2 {
            let normal: [i32; 3] = std::array::from_fn(|a| if a == axis { 2 * side - 1 } else { 0 });
            writeln!(normals, "vn {} {} {}", normal[0], normal[1], normal[2]).unwrap();
            for i in 0..size[u] {
                for j in 0..size[v] {
                    let mut corners: Vec<String> = Vec::new();
                    for (di, dj) in [(0, 0), (1, 0), (1, 1), (0, 1)] {
                        let mut p = [0; 3];
                        (p[axis], p[u], p[v]) = (side * size[axis], i + di, j + dj);
                        let next = place.len() + 1;
                        let number = *place.entry(p).or_insert_with(|| {
                            writeln!(text, "v {} {} {}", p[0], p[1], p[2]).unwrap();
                            next
                        });
                        vt += 1;
                        writeln!(coordinates, "vt {} {}", p[u], p[v]).unwrap();
                        corners.push(indices(number, vt, 2 * axis + side as usize + 1));
                    }
                    if side == 0 {
                        corners.reverse();
                    }
                    writeln!(faces, "f {}", corners.join(" ")).unwrap();
                }
            }
        }
    }
    text + &coordinates + &normals + "s 1\nusemtl wood # dark\n" + &faces
}

pub(crate) fn bar() -> String {
    bar_text(|v, vt, vn| format!("{v}/{vt}/{vn}"))
}

/// Builds a body and cuts it.
fn cut(mesh: &Mesh, point: [f64; 3], normal: [f64; 3]) -> Body {
    let body = Body::builder(mesh.clone()).name("body").cell_size(0.25).material(Material::fast_lsm());
    let mut body = body.volume(VolumeMeasure::Mesh).build().unwrap();
    body.cut(point, normal).unwrap();
    assert!(body.pieces() > 1);
    body
}

/// Returns the positions of the mesh at rest, with each piece moved along `away` by one unit for each piece before it.
fn apart(mesh: &Mesh, away: [f32; 3]) -> Vec<[f32; 3]> {
    let mut piece: Vec<usize> = (0..mesh.vertices().len()).collect();
    for _ in 0..mesh.vertices().len() {
        let before = piece.clone();
        for face in mesh.faces() {
            let first = face.iter().map(|&corner| piece[corner as usize]).min().unwrap();
            face.iter().for_each(|&corner| piece[corner as usize] = first);
        }
        if piece == before {
            break;
        }
    }
    let mut names = piece.clone();
    names.sort_unstable();
    names.dedup();
    let number = |piece: &usize| names.binary_search(piece).unwrap() as f32;
    let moved = |(vertex, piece): (&Point3<f64>, &usize)| {
        let position: [f32; 3] = vertex.cast::<f32>().into();
        std::array::from_fn(|axis| position[axis] + away[axis] * number(piece))
    };
    mesh.vertices().iter().zip(&piece).map(moved).collect()
}

/// Writes frame 0 of a broken body and returns its bytes.
fn frame(body: &Body, source: Source<'_>, positions: &[[f32; 3]], format: Format) -> Vec<u8> {
    let directory = TempDir::new().unwrap();
    let sequence = sequence(directory.path(), format);
    let path = sequence.path(0);
    let mut writer = FrameWriter::create(sequence, source).unwrap();
    let normals = vec![[0.0, 0.0, 1.0]; positions.len()];
    writer.write_pieces(0, positions, &normals, &Pieces::of(body, source).unwrap()).unwrap();
    writer.finish().unwrap();
    fs::read(path).unwrap()
}

fn obj_frame(document: &Arc<Document>, part: &Part, body: &Body, away: [f32; 3]) -> String {
    let positions = apart(body.mesh().unwrap(), away);
    String::from_utf8(frame(body, Source::Document(document, part), &positions, Format::Obj)).unwrap()
}

/// Returns the numbers after a keyword, line by line.
pub(crate) fn numbers(text: &str, keyword: &str) -> Vec<Vec<f64>> {
    let lines = text.lines().filter(|line| line.split_whitespace().next() == Some(keyword));
    lines.map(|line| line.split_whitespace().skip(1).map(|word| word.parse().unwrap()).collect()).collect()
}

/// Returns `v`, `vt` and `vn` of each corner of each face, from 0, and the material of the face.
pub(crate) fn faces(text: &str) -> Vec<(Vec<[Option<usize>; 3]>, String)> {
    let mut material = String::new();
    let mut faces = Vec::new();
    for line in text.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("usemtl") => material = words.next().unwrap().to_owned(),
            Some("f") => {
                let corner = |word: &str| {
                    let mut indices = word.split('/').map(|index| index.parse::<usize>().ok().map(|i| i - 1));
                    [(); 3].map(|()| indices.next().flatten())
                };
                faces.push((words.map(corner).collect(), material.clone()));
            }
            _ => {}
        }
    }
    faces
}

/// Checks that a frame reads back as closed pieces with the volume of the body, and that its lines are in order.
fn check_closed(text: &str, body: &Body, object: Option<&str>) {
    let again = Document::from_bytes("again.obj", text.into()).unwrap().mesh(object).unwrap();
    let expected = body.mesh().unwrap().volume();
    assert!(again.is_closed());
    // Positions are rounded to f32, by 1e-7 of the extent.
    assert!((again.volume() - expected).abs() < 1e-5 * expected, "{} {expected}", again.volume());
    assert_eq!(again.face_count(), body.mesh().unwrap().face_count());
}

#[test]
fn an_obj_frame_of_a_cut_bar_keeps_the_lines_of_the_input_and_adds_parts_and_caps() {
    let input = bar();
    let (document, part) = open(&input, None);
    let body = cut(part.mesh(), [1.6, 0.0, 0.0], [1.0, 0.2, 0.0]);
    let text = obj_frame(&document, &part, &body, [0.0, 3.0, 0.0]);
    check_closed(&text, &body, None);
    let mesh = body.mesh().unwrap();
    let sources = body.piece_mesh().unwrap().face_sources();
    let count = |test: fn(&FaceSource) -> bool| sources.iter().filter(|source| test(source)).count();
    let (parts, caps) = (
        count(|source| matches!(source, FaceSource::Part(_))),
        count(|source| matches!(source, FaceSource::Cap { .. })),
    );
    assert!(parts > 0 && caps > 0);

    // The input vertices keep their numbers.
    let (v, of_input) = (numbers(&text, "v"), numbers(&input, "v"));
    assert_eq!(v.len(), mesh.vertices().len());
    for (moved, rest) in v.iter().zip(&of_input) {
        assert!(moved[0] == rest[0] && (moved[1] - rest[1]).rem_euclid(3.0) == 0.0 && moved[2] == rest[2]);
    }
    // All other lines of the input but those of cut faces stay, in order; `vn` keep their numbers.
    let lines: Vec<&str> =
        input.lines().filter(|line| !line.starts_with("v ") && !line.starts_with('f')).collect();
    let mut rest = text.lines();
    assert!(lines[1..].iter().all(|line| line.starts_with("mtllib") || rest.any(|other| other == *line)));
    // All elements precede the first face.
    let first = text.find("\nf ").unwrap();
    assert!(["\nv ", "\nvt ", "\nvn "].iter().all(|keyword| text.rfind(keyword).unwrap() < first));
    // The caps come last, with their material, flat, in the only object.
    let (before, after) = text.split_once("s off\nusemtl body_cap\n").unwrap();
    assert_eq!(after.lines().count(), caps);
    assert!(after.lines().all(|line| line.starts_with("f ")));
    assert_eq!(before.matches("\no ").count(), 1);
    assert_eq!(before.lines().filter(|line| line.starts_with("f ")).count() + caps, mesh.face_count());

    // Texture coordinates and normals at all corners are those of the place on the bar: its vt are lengths.
    let (vt, vn) = (numbers(&text, "vt"), numbers(&text, "vn"));
    for (corners, material) in faces(&text) {
        let position = |corner: usize| &v[corners[corner][0].unwrap()];
        let normal = &vn[corners[0][2].unwrap()];
        let axis = (0..3).find(|&axis| normal[axis].abs() > 0.999);
        let uv = |corner: usize| &vt[corners[corner][1].unwrap()];
        for corner in 0..corners.len() {
            let rest = |axis: usize| {
                if axis == 1 { position(corner)[1].rem_euclid(3.0) } else { position(corner)[axis] }
            };
            assert_eq!(&vn[corners[corner][2].unwrap()], normal, "all faces are flat");
            if material == "wood" {
                let axis = axis.unwrap();
                let expected = [rest((axis + 1) % 3), rest((axis + 2) % 3)];
                assert!(
                    (0..2).all(|k| (uv(corner)[k] - expected[k]).abs() < 1e-5),
                    "{:?} {expected:?}",
                    uv(corner)
                );
            } else {
                assert_eq!(material, "body_cap");
                let next = (corner + 1) % corners.len();
                let length =
                    |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
                let (in_plane, in_space) =
                    (length(uv(corner), uv(next)), length(position(corner), position(next)));
                // The coordinates are lengths in the plane; the roughness of a cap is at most 0.2 cells of 0.25 per point.
                assert!(in_plane <= in_space + 1e-5 && in_space - in_plane <= 0.1_f64.powi(2) + 1e-5);
            }
        }
    }
}

#[test]
fn obj_frames_of_relative_indices_objects_colors_and_unended_lines_are_closed() {
    let absolute = bar();
    let counts = |text: &str| ["v", "vt", "vn"].map(|keyword| numbers(text, keyword).len());
    let [nv, nvt, nvn] = counts(&absolute);
    let relative = bar_text(|v, vt, vn| {
        format!("{}/{}/{}", v as i64 - nv as i64 - 1, vt as i64 - nvt as i64 - 1, vn as i64 - nvn as i64 - 1)
    });
    let colored: String =
        absolute
            .lines()
            .filter(|line| !line.starts_with("vt") && !line.starts_with("vn"))
            .map(|line| {
                if line.starts_with("v ") { format!("{line} 0.5 0.25 1\r\n") } else { format!("{line}\r\n") }
            })
            .collect();
    let colored = colored.replace("f ", "f\t");
    let without: String = colored
        .lines()
        .map(|line| {
            let words: Vec<&str> = line.split_whitespace().collect();
            if words.first() != Some(&"f") {
                return format!("{line}\r\n");
            }
            let corners: Vec<&str> = words[1..].iter().map(|word| word.split('/').next().unwrap()).collect();
            format!("f {}\r\n", corners.join(" "))
        })
        .collect();
    let second = "o other\nv 9 9 9\nv 10 9 9\nv 9 10 9\nvt 0 0\nusemtl glass\nf -3 -2 -1\n";
    let objects = format!("{absolute}{second}");
    let continued = format!("{} \\", absolute.trim_end());
    for (name, text, object) in [
        ("relative", &relative, None),
        ("colored", &without, None),
        ("objects", &objects, Some("bar")),
        ("continued", &continued, None),
    ] {
        let (document, part) = open(text, object);
        let body = cut(part.mesh(), [1.6, 0.0, 0.0], [1.0, 0.2, 0.1]);
        let frame = obj_frame(&document, &part, &body, [0.0, 3.0, 0.0]);
        check_closed(&frame, &body, object);
        let caps = faces(&frame).into_iter().filter(|(_, material)| material == "body_cap").count();
        let expected = body.piece_mesh().unwrap().face_sources();
        assert_eq!(caps, expected.iter().filter(|s| matches!(s, FaceSource::Cap { .. })).count(), "{name}");
        if name == "colored" {
            assert!(
                numbers(&frame, "v").iter().all(|v| v[3..] == [0.5, 0.25, 1.0])
                    && !frame.replace("\r\n", "").contains('\n')
            );
        }
        if name == "objects" {
            // No face refers to a later line; the parts and the caps are in their object.
            let (mut v, mut object) = (0, "");
            for line in frame.lines() {
                v += usize::from(line.starts_with("v "));
                object = line.strip_prefix("o ").unwrap_or(object);
                for corner in line.strip_prefix("f ").unwrap_or_default().split_whitespace() {
                    let index: i64 = corner.split('/').next().unwrap().parse().unwrap();
                    assert!(index <= v as i64, "{line}");
                }
            }
            assert_eq!(object, "bar");
            let other = Document::from_bytes("x.obj", frame.into()).unwrap().mesh(Some("other")).unwrap();
            assert_eq!(other.face_count(), 1);
        }
    }
}

#[test]
fn faces_without_an_object_or_a_material_get_named_ones_at_the_end_of_the_file() {
    let text = bar().replace("o bar\n", "").replace("s 1\nusemtl wood # dark\n", "");
    // Faces with further vertices after them move to the end, after the object that follows them in the file.
    let second = "o default\ng lid\nusemtl glass\nv 4.2 0 0\nv 4.7 0 0\nv 4.2 0.5 0\nv 4.2 0 0.5\n\
                  f -4 -2 -3\nf -4 -3 -1\nf -3 -2 -1\nf -2 -4 -1\n";
    let (document, part) = open(&format!("{text}{second}"), None);
    let body = cut(part.mesh(), [1.6, 0.0, 0.0], [1.0, 0.2, 0.1]);
    let frame = obj_frame(&document, &part, &body, [0.0; 3]);
    assert!(
        frame.lines().all(|line| !["o", "g", "s", "usemtl"].contains(&line.trim())),
        "a statement has a name"
    );
    check_closed(&frame, &body, None);
    let tail = &frame[frame.rfind("v 4.2").unwrap()..];
    let (_, tail) = tail.split_once("\no default_\ng default_\nusemtl default_\nf ").unwrap();
    let (_, caps) = tail.split_once("\nusemtl body_cap\nf ").unwrap();
    assert!(caps.lines().skip(1).all(|line| line.starts_with("f ")));
    // The object of the file keeps its faces, and no others.
    let document = Document::from_bytes("again.obj", frame.into()).unwrap();
    assert_eq!(document.mesh(Some("default")).unwrap().face_count(), 4);
}

/// A body that is scaled by 2, with cells twice as large, has the same pieces, and textures that are scaled with it.
#[test]
fn texture_coordinates_of_caps_are_in_the_unit_of_the_input() {
    let (document, part) = open(&bar(), None);
    let small = cut(part.mesh(), [1.6, 0.0, 0.0], [1.0, 0.2, 0.0]);
    let body = Body::builder(part.mesh().clone()).name("body").scale(2.0).cell_size(0.5);
    let mut large = body.material(Material::fast_lsm()).volume(VolumeMeasure::Mesh).build().unwrap();
    large.cut([3.2, 0.0, 0.0], [1.0, 0.2, 0.0]).unwrap();
    assert_eq!(
        large.piece_mesh().unwrap().cap_uvs()[0],
        small.piece_mesh().unwrap().cap_uvs()[0].map(|x| 2.0 * x)
    );
    let lines = |body: &Body| numbers(&obj_frame(&document, &part, body, [0.0; 3]), "vt");
    assert_eq!(lines(&large), lines(&small));
    let of_arrays = |body: &Body| {
        let mesh = body.whole_mesh().unwrap();
        let positions = vec![[0.0; 3]; body.mesh().unwrap().vertices().len()];
        numbers(&String::from_utf8(frame(body, Source::Mesh(mesh), &positions, Format::Obj)).unwrap(), "vt")
    };
    assert_eq!(of_arrays(&large), of_arrays(&small));
}

#[test]
fn frames_of_cut_balls_and_busts_are_closed() {
    for (name, size) in [("ball", 0.2), ("bust", 0.1), ("ring", 0.1)] {
        let path = supple_tests::example(&format!("{name}.obj"));
        let document = Arc::new(Document::read(path).unwrap());
        let part = document.part(None).unwrap();
        let (low, high) = part.mesh().bounds();
        let extent = (high - low).max();
        let body = Body::builder(part.mesh().clone()).cell_size(size * extent).material(Material::fast_lsm());
        let mut body = body.build().unwrap();
        let center = nalgebra::center(&low, &high);
        body.cut(center.into(), [0.3, 1.0, 0.2]).unwrap();
        let away = [0.0, 2.0 * extent as f32, 0.0];
        let text = obj_frame(&document, &part, &body, away);
        check_closed(&text, &body, None);
        // A body without a file.
        let mesh = part.mesh();
        let positions = apart(body.mesh().unwrap(), away);
        let text = frame(&body, Source::Mesh(mesh), &positions, Format::Obj);
        check_closed(&String::from_utf8(text).unwrap(), &body, None);
    }
}

#[test]
fn ply_frames_have_the_vertices_and_faces_of_the_pieces() {
    let text = bar();
    let (document, part) = open(&text, None);
    let body = cut(part.mesh(), [1.6, 0.0, 0.0], [1.0, 0.2, 0.0]);
    let mesh = body.mesh().unwrap();
    let positions = apart(mesh, [0.0, 3.0, 0.0]);
    let bytes = frame(&body, Source::Document(&document, &part), &positions, Format::Ply);
    let end = bytes.windows(11).position(|text| text == b"end_header\n").unwrap() + 11;
    let header = std::str::from_utf8(&bytes[..end]).unwrap();
    let count = |element: &str| -> usize {
        header.lines().find_map(|line| line.strip_prefix(element)).unwrap().parse().unwrap()
    };
    let (vertices, triangles) = (count("element vertex "), count("element face "));
    assert_eq!((vertices, triangles), (mesh.vertices().len(), mesh.triangles().len()));
    assert_eq!(bytes.len(), end + 24 * vertices + 13 * triangles);
    let word = |at: usize| -> [u8; 4] { std::array::from_fn(|k| bytes[at + k]) };
    let points: Vec<[f64; 3]> = (0..vertices)
        .map(|vertex| std::array::from_fn(|k| f64::from(f32::from_le_bytes(word(end + 24 * vertex + 4 * k)))))
        .collect();
    let start = end + 24 * vertices;
    let faces: Vec<[u32; 3]> = (0..triangles)
        .map(|face| std::array::from_fn(|k| u32::from_le_bytes(word(start + 13 * face + 1 + 4 * k))))
        .collect();
    let again = Mesh::new(points, &faces).unwrap();
    assert!(again.is_closed() && (again.volume() - mesh.volume()).abs() < 1e-5 * mesh.volume());
}

#[test]
fn pieces_of_another_cut_with_the_same_number_of_events_have_frames_of_their_own() {
    let (document, part) = open(&bar(), None);
    let source = Source::Document(&document, &part);
    let bodies = [1.6, 2.4].map(|x| cut(part.mesh(), [x, 0.0, 0.0], [1.0, 0.2, 0.0]));
    assert_eq!(bodies[0].topology_version(), bodies[1].topology_version());
    let directory = TempDir::new().unwrap();
    let sequence = sequence(directory.path(), Format::Obj);
    let mut writer = FrameWriter::create(sequence.clone(), source).unwrap();
    for (number, body) in [(0, 0), (1, 1), (2, 0)] {
        let body = &bodies[body];
        let positions = apart(body.mesh().unwrap(), [0.0, 3.0, 0.0]);
        writer.write_pieces(number, &positions, &[], &Pieces::of(body, source).unwrap()).unwrap();
        let expected = frame(body, source, &positions, Format::Obj);
        assert!(fs::read(sequence.path(number)).unwrap() == expected, "frame {number}");
    }
}

#[test]
fn a_point_cache_of_a_broken_body_is_an_error() {
    let (document, part) = open(&bar(), None);
    let body = cut(part.mesh(), [1.6, 0.0, 0.0], [1.0, 0.2, 0.0]);
    let source = Source::Document(&document, &part);
    let directory = TempDir::new().unwrap();
    let mut writer = FrameWriter::create(sequence(directory.path(), Format::Pc2), source).unwrap();
    let positions = apart(body.mesh().unwrap(), [0.0; 3]);
    let error = writer.write_pieces(3, &positions, &[], &Pieces::of(&body, source).unwrap()).unwrap_err();
    assert!(matches!(error, OutputError::Broken { frame: 3, .. }), "{error}");
    assert_eq!(
        error.to_string(),
        "frame 3 is not written: body `body` is broken, and pc2 has the same faces in all frames; write obj, ply, usd, usdz, html, vtu, lattice, film or gif"
    );
}

/// Cuts the body of a job after a frame, and stops the job after another.
#[derive(Default)]
struct Cutter {
    simulation: Option<Arc<Mutex<Simulation>>>,
    cut_after: Option<u32>,
    stop_after: Option<u32>,
}

impl Observer for Cutter {
    fn built(&mut self, simulation: &Arc<Mutex<Simulation>>, _inputs: &[Input]) {
        self.simulation = Some(simulation.clone());
    }

    fn frame(&mut self, progress: &Progress) -> Flow {
        if self.cut_after == Some(progress.frame) {
            let mut simulation = self.simulation.as_ref().unwrap().lock().unwrap();
            let center = simulation.body(0).center_of_mass();
            simulation.body_mut(0).cut(center.into(), [1.0, 0.2, 0.1]).unwrap();
        }
        if self.stop_after == Some(progress.frame) { Flow::Stop } else { Flow::Continue }
    }
}

const SCENE: &str = r#"
[simulation]
frames = 8

[[body]]
name = "bar"
mesh = "bar.obj"
translate = [0, 0.2, 0]
rotate = [0, 0, 20]
lattice_vertices = 300

[[collider]]
plane = { point = [0, 0, 0], normal = [0, 1, 0] }
"#;

fn job(folder: &Path, formats: &str, directory: &str) -> Job {
    fs::write(folder.join("bar.obj"), bar()).unwrap();
    let overrides = [format!("output.format={formats}")];
    let scene = Scene::parse(SCENE, "scene.toml", folder, &overrides).unwrap();
    let mut job = Job::new(scene, folder.join(directory));
    job.stats = Some(folder.join(format!("{directory}.csv")));
    job
}

/// Returns the frame files of a directory and their bytes, in order.
fn files(directory: &Path) -> Vec<(String, Vec<u8>)> {
    let mut files: Vec<_> = fs::read_dir(directory)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| {
            path.file_name().is_some_and(|name| {
                name.to_string_lossy().starts_with("bar") || name.to_string_lossy().starts_with("supple.")
            })
        })
        .map(|path| (path.file_name().unwrap().to_string_lossy().into_owned(), fs::read(&path).unwrap()))
        .filter(|(name, _)| !name.ends_with(".toml"))
        .collect();
    files.sort();
    files
}

const FORMATS: &str = r#"["obj", "ply", "usd"]"#;

#[test]
fn a_job_writes_the_same_frames_before_a_cut_and_resumes_after_it() {
    let folder = TempDir::new().unwrap();
    let whole = job(folder.path(), FORMATS, "whole");
    whole.run(&mut ()).unwrap();
    let broken = job(folder.path(), FORMATS, "broken");
    let report = broken.run(&mut Cutter { cut_after: Some(3), ..Cutter::default() }).unwrap();
    assert_eq!((report.outcome, report.written), (Outcome::Finished, 9));
    let (before, after) = (files(&whole.directory), files(&broken.directory));
    assert_eq!(before.len(), after.len());
    let numbered = before.iter().filter(|(name, _)| name.contains('_')).count();
    assert_eq!(numbered, 18);
    assert!(after.iter().any(|(name, _)| name == "supple.usd"));
    for ((name, a), (_, b)) in before.iter().zip(&after).filter(|((name, _), _)| name.contains('_')) {
        let number: u32 = name.split(['_', '.']).nth(1).unwrap().parse().unwrap();
        assert_eq!(a == b, number <= 3, "{name}");
    }
    // One row of statistics per frame, after a header.
    let rows = fs::read_to_string(folder.path().join("broken.csv")).unwrap();
    assert_eq!(rows.lines().count(), 1 + 9);

    let mut resumed = job(folder.path(), FORMATS, "resumed");
    resumed.run(&mut Cutter { cut_after: Some(3), stop_after: Some(5), ..Cutter::default() }).unwrap();
    resumed.resume = true.into();
    let report = resumed.run(&mut ()).unwrap();
    assert_eq!((report.outcome, report.resumed_after), (Outcome::Finished, Some(5)));
    for ((name, a), (_, b)) in
        after.iter().zip(&files(&resumed.directory)).filter(|((name, _), _)| !name.ends_with("checkpoint"))
    {
        assert!(a == b, "{name}");
    }
}
