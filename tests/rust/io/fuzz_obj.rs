//! Fuzzing of the OBJ reader: it returns a surface or an error, and a written frame reads back the same.

use std::sync::Arc;

use crate::fuzz::{Target, fuzz};
use supple_io::frames::{Format, FrameWriter, Sequence, Source};
use supple_io::obj::Document;

const WORDS: [&str; 34] = [
    "v", "vt", "vn", "vp", "f", "fo", "l", "p", "o", "g", "s", "mtllib", "usemtl", "curv", "curv2", "surf",
    "parm", "trim", "hole", "end", "cstype", "deg", "bmat", "step", "con", "call", "1/1/1", "1//1",
    "-1/-1/-1", "1/", "/1", "\\\n", "#", "\r\n",
];

const ODD: &[u8] = b"# all kinds\nmtllib a b.mtl\no one\nv 0 0 0 1 0 0\nv 1 0 0 0.5\nv 0 1 0\nv 0 0 1\nvt 0 0\nvn 0 0 1\n\
g a b\nusemtl x y\ns 1\nf 1/1/1 2/1/1 3/1/1\nf -1//1 -2//1 -3//1\no two\nf 1 3 4\nf 2 \\\n 4 3\nl 1 2\np 1\ncstype bezier\n\
deg 1\ncurv 0 1 1 2\nparm u 0 1\nend\ncall x.obj\n";

fn read(input: &[u8]) -> String {
    let document = match Document::from_bytes("model.obj", input.to_vec()) {
        Err(error) => return error.to_string(),
        Ok(document) => Arc::new(document),
    };
    assert_eq!(document.bytes(), input);
    let libraries = document.libraries().len();
    let groups: Vec<String> = document.groups().map(|group| group.name.to_string()).collect();
    for group in groups.iter().take(4) {
        if let Ok(mesh) = document.mesh(Some(group)) {
            assert!(mesh.face_count() <= document.face_count());
        }
    }
    let part = match document.part(None) {
        Err(error) => return error.to_string(),
        Ok(part) => part,
    };
    let mesh = part.mesh();
    assert_eq!(mesh.vertices().len(), document.vertex_count());
    assert!(mesh.vertices().iter().all(|p| p.coords.iter().all(|x| x.is_finite())));
    assert!(mesh.triangles().iter().flatten().all(|&v| (v as usize) < mesh.vertices().len()));
    let maps = document.maps();
    assert!(maps.iter().all(|(_, values)| values.len() == document.vertex_count()));
    assert!(maps.iter().flat_map(|(_, values)| values).all(|value| value.is_finite()));
    let answer = format!(
        "a surface, {} maps, {} libraries, groups {}",
        "map ".repeat(maps.len()),
        "library ".repeat(libraries.min(3)),
        "group ".repeat(groups.len().min(3))
    );
    let positions: Vec<[f32; 3]> = mesh.vertices().iter().map(|p| p.cast::<f32>().into()).collect();
    // Only some inputs are written: writing a file takes longer than everything else.
    if input.len().is_multiple_of(8) && positions.iter().flatten().all(|x| x.is_finite()) {
        let folder = tempfile::tempdir().expect("a folder");
        let sequence = Sequence {
            directory: folder.path().into(),
            name: "n".into(),
            format: Format::Obj,
            first: 0,
            every: 1,
            last: 0,
        };
        let path = sequence.path(0);
        let mut writer = FrameWriter::create(sequence, Source::Document(&document, &part)).expect("a folder");
        writer.write(0, &positions, &[]).expect("a frame");
        let frame = Document::read(path).expect("a frame is an OBJ file");
        let again = frame.mesh(None).expect("a frame has a surface");
        assert!(again.faces().eq(mesh.faces()));
        let read: Vec<[f32; 3]> = again.vertices().iter().map(|p| p.cast::<f32>().into()).collect();
        assert_eq!(read, positions);
    }
    answer
}

#[test]
fn mutated_obj_files_are_read_or_refused_without_panics() {
    let folder = supple_tests::data("");
    let names = ["forward", "hard_edges", "ngon", "odd", "old_mac", "seams"];
    let mut corpus: Vec<Vec<u8>> = names
        .iter()
        .map(|name| std::fs::read(folder.join(format!("{name}.obj"))).expect("a test file"))
        .collect();
    corpus.push(ODD.to_vec());
    fuzz(&Target { name: "obj", words: &WORDS, read }, corpus);
}
