//! Reading OBJ files: variants of the format, errors, comparison with obj-rs.

#![allow(clippy::single_range_in_vec_init, reason = "groups are lists of ranges, often of one range")]

use std::path::PathBuf;

use proptest::prelude::*;
use supple::Mesh;
use supple_io::obj::{self, Document, ObjError};

fn file(name: &str) -> PathBuf {
    supple_tests::root().join(name)
}

fn data(name: &str) -> PathBuf {
    file("tests/data").join(name)
}

fn parse(text: impl AsRef<[u8]>) -> Result<Mesh, ObjError> {
    Document::from_bytes("x.obj", text.as_ref().to_vec())?.mesh(None)
}

fn refusal(text: impl AsRef<[u8]>) -> String {
    parse(text).expect_err("refused").to_string()
}

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

#[test]
fn the_bust_is_read_with_all_its_parts() {
    let bust = obj::read(file("examples/scenes/bust.obj")).unwrap();
    assert_eq!((bust.vertices().len(), bust.face_count()), (4717, 4794));
    assert!(bust.is_closed() && bust.signed_volume() > 0.0);
    let topology = bust.topology();
    assert_eq!((topology.components.len(), topology.degenerate_faces, topology.unused_vertices), (1, 0, 0));
    let (low, high) = bust.bounds();
    assert!((high - low - nalgebra::Vector3::new(5.0, 3.5, 2.5)).amax() < 0.1);
    assert_eq!(bust.vertices()[0].x, -0.33787);

    let parts = Document::read(file("examples/scenes/bust_parts.obj")).unwrap();
    assert_eq!(parts.mesh(None).unwrap().topology().components.len(), 6);
    let names: Vec<_> = parts.groups().map(|group| (group.name.as_str(), group.is_object)).collect();
    let expected = ["skin", "eye_left", "eye_right", "teeth_upper", "teeth_lower", "tongue"];
    let mut with_cap = expected.map(|name| (name, true)).to_vec();
    with_cap.insert(1, ("cap", false));
    assert_eq!(names, with_cap);
    let whole = parts.face_count();
    let faces = |name: &str| parts.mesh(Some(name)).unwrap().face_count();
    assert_eq!(expected.into_iter().map(faces).sum::<usize>(), whole);
    assert!(parts.libraries()[0].exists);
}

#[test]
fn a_file_with_every_oddity_is_read() {
    let odd = Document::read(data("odd.obj")).unwrap();
    assert_eq!((odd.vertex_count(), odd.normal_count(), odd.face_count()), (9, 3, 7));
    assert_eq!(odd.short_faces(), (2, Some(33)));
    let mesh = odd.mesh(None).unwrap();
    assert!(mesh.is_closed());
    assert_eq!(mesh.volume(), 1.0);
    assert_eq!((mesh.topology().unused_vertices, mesh.topology().degenerate_faces), (1, 1));
    assert_eq!(mesh.bounds().1, nalgebra::Point3::new(1.0, 1.0, 1.0));

    let bounds = |g: &supple_io::obj::Group| g.faces.iter().map(|faces| (faces.start, faces.end)).collect();
    let groups: Vec<(_, _, Vec<_>)> =
        odd.groups().map(|g| (g.name.as_str(), g.is_object, bounds(g))).collect();
    let expected = [
        ("First  Part", true, vec![(0, 2)]),
        ("back", false, vec![(0, 1)]),
        ("all", false, vec![(0, 1), (1, 2)]),
        ("front", false, vec![(1, 2)]),
        ("Secondß", true, vec![(2, 7)]),
    ];
    assert_eq!(groups, expected);
    assert_eq!(odd.mesh(Some("all")).unwrap().face_count(), 2);
    assert_eq!(
        odd.mesh(Some("back  all")).unwrap().face_count(),
        1,
        "the whole text of a `g` line is also a name"
    );
    assert_eq!(
        odd.mesh(Some("front")).unwrap().vertices().len(),
        4,
        "a part has only the vertices of its faces"
    );

    let libraries: Vec<_> =
        odd.libraries().into_iter().map(|library| (library.name, library.exists)).collect();
    assert_eq!(libraries, [("missing one.mtl".to_owned(), false), ("odd.mtl".to_owned(), true)]);
    let ignored: Vec<_> =
        odd.ignored_statements().iter().map(|entry| (entry.keyword.as_str(), entry.count)).collect();
    let expected = ["l", "p", "cstype", "deg", "curv2", "parm", "end"].map(|keyword| (keyword, 1));
    assert_eq!(ignored[..7], expected);
    assert_eq!(ignored[7..], [("vendor_statement", 2)]);
}

#[test]
fn line_ends_statement_order_seams_and_polygons_are_read() {
    for name in ["old_mac.obj", "forward.obj", "seams.obj", "hard_edges.obj"] {
        let mesh = obj::read(data(name)).unwrap();
        assert!(mesh.is_closed(), "{name}");
        assert_eq!(mesh.signed_volume(), 1.0, "{name}");
    }
    assert_eq!(obj::read(data("seams.obj")).unwrap().topology().seam_vertices, 16);
    let pentagon = obj::read(data("ngon.obj")).unwrap();
    assert_eq!((pentagon.face_count(), pentagon.triangles().len()), (6, 8));
    assert!(pentagon.is_closed() && pentagon.signed_volume() > 0.0);
    assert_eq!(Document::read(data("old_mac.obj")).unwrap().line_count(), 14);
}

#[test]
fn errors_name_the_line_the_value_and_the_reason() {
    for (text, expected) in [
        (
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n# c\nf 1 2 \\\n 4\n",
            "x.obj:6: face 2 refers to vertex 4 of 3",
        ),
        ("v 0 0 0\nf 1 2 3\nv 1 0 0\n", "x.obj:2: face 1 refers to vertex 3 of 2"),
        ("v 0 0 0\nv 1 0 0\nf -1 -2 -3\nv 0 1 0", "x.obj:3: face 1 refers to vertex -3 of 2"),
        ("v 0 0 0\nf 0 1 1", "x.obj:2: face 1 refers to vertex 0 of 1"),
        ("v 0 0 0\nf 99999999999999999999 1 1", "x.obj:2: face 1 refers to vertex 9223372036854775807 of 1"),
        (
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/2 2/1 3/1\nvt 0 0",
            "x.obj:4: face 1 refers to texture coordinate 2 of 1",
        ),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1//1 2//1 3//1", "x.obj:4: face 1 refers to normal 1 of 0"),
        (
            "v 0 0 0\rv 1 0 0\r\rf 1 2 x",
            "x.obj:4: face 1 has a corner `x`; a corner must be v, v/vt, v//vn or v/vt/vn",
        ),
        ("v 0 0 0\nv 1 0 0\nf 1 2 1/1/1/1", "x.obj:3: face 1 has a corner `1/1/1/1`; a corner must be"),
        ("v 0 0 0\n\nv 1 0\nf 1 2 1", "x.obj:3: `v` needs 3 numbers, 2 found"),
        ("v 0 0 0\nvn 1 #0 0\nf 1 1 1", "x.obj:2: `vn` needs 3 numbers, 1 found"),
        ("v 0 0 0\r\nv 1 0 0\r\nv 0 1,5 0\r\nf 1 2 3", "x.obj:3: `1,5` in `v` is not a number"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nvn 0 0 up", "x.obj:5: `up` in `vn` is not a number"),
        ("v 0 0 0\nv 1 0 nan\nv 0 1 x\nf 1 2 3", "x.obj:2: `nan` in `v`: numbers must be finite"),
        ("v 0 0 0\nv 1 0 -inf\nv 0 1 0\nf 1 2 3", "x.obj:2: `-inf` in `v`: numbers must be finite"),
        ("v 0 0 0\nv 1 0 0\nv 0 1e39 0\nf 1 2 3", "x.obj:3: `1e39` in `v`: numbers must be finite"),
        ("vn 0 NaN 1\nv 1 0 0\nv 0 1 0\nv 0 0 0\nf 1 2 3", "x.obj:1: `NaN` in `vn`: numbers must be finite"),
        ("v 0 0 0\nv 1 0 0\nl 1 2\n", "x.obj: no faces: no `f` with three corners among 0 `f` and 2 `v`"),
        ("v 0 0 0\nv 1 0 0\nf 1 2\n", "x.obj:3: no faces: no `f` with three corners among 1 `f` and 2 `v`"),
        ("v 0 0 0\nv 1 0 0\nf 1 2 1\n", "x.obj: no faces: 1 given, none with three distinct corners"),
        ("", "x.obj: no faces: no `f` with three corners among 0 `f` and 0 `v`"),
        ("# only a comment", "x.obj: no faces: "),
        (
            "v 1 2 3\nv 1 2 3\nv 1 2 3.0\nf 1 2 3",
            "x.obj: no extent: all 3 vertices of the faces lie at (1, 2, 3)",
        ),
        ("\n\nDear reader,\nthis is a letter.\n", "x.obj:3: is not an OBJ file: line starts with `Dear`"),
        ("ply\nformat ascii 1.0\nend_header\n0 0 0\n", "x.obj:1: is not an OBJ file: line starts with `ply`"),
        ("def f(x):\n  f (x)\n", "x.obj:1: is not an OBJ file: line starts with `def`"),
        ("v 0 0 0\nv 1 0 0\n\0", "x.obj:3: is not an OBJ file: it contains binary data"),
    ] {
        let message = refusal(text);
        assert!(message.starts_with(expected), "{text:?}\n  gives    {message}\n  expected {expected}");
    }
    let latin = refusal(b"v 0 0 0\nv 1 \xb5 0\nv 0 1 0\nf 1 2 3");
    assert!(latin.starts_with("x.obj:2: `µ` in `v` is not a number"), "{latin}");
}

#[test]
fn missing_files_and_unknown_objects_are_errors_with_path_and_known_names() {
    let error = obj::read("no/such/file.obj").unwrap_err();
    assert!(error.to_string().starts_with("no/such/file.obj: cannot be read: "), "{error}");
    assert!(matches!(&error.problem, obj::ObjProblem::Read(e) if e.kind() == std::io::ErrorKind::NotFound));

    let error = obj::read_object(data("odd.obj"), Some("Head")).unwrap_err().to_string();
    let expected = "no object or group `Head` with faces; the file has: \
                    `First  Part`, `back`, `all`, `front`, `Secondß`";
    assert!(error.ends_with(expected), "{error}");
    let nameless = Document::from_bytes("x.obj", TRIANGLE.into()).unwrap();
    assert!(nameless.mesh(Some("a")).unwrap_err().to_string().ends_with("the file has: none"));
}

#[test]
fn group_names_may_repeat_and_be_ended() {
    let text = format!("{TRIANGLE}g a a\nf 1 2 3\ng b\nf 1 2 3\ng a\nf 1 2 3\ng\nf 1 2 3\no\nf 3 2 1\ng c\n");
    let document = Document::from_bytes("x.obj", text.into()).unwrap();
    let groups: Vec<_> = document.groups().map(|g| (g.name.as_str(), g.faces.clone())).collect();
    assert_eq!(groups, [("a", vec![1..2, 3..4]), ("b", std::iter::once(2..3).collect())]);
    assert_eq!(document.mesh(Some("a")).unwrap().face_count(), 2);
}

#[test]
fn a_part_keeps_the_vertex_order_of_the_file() {
    let part = Document::read(data("odd.obj")).unwrap().part(Some("front")).unwrap();
    assert_eq!(part.vertices().collect::<Vec<_>>(), [4, 5, 6, 7]);
    assert_eq!(part.faces().collect::<Vec<_>>(), [1]);
    assert_eq!(part.mesh().faces().collect::<Vec<_>>(), [[0, 1, 3, 2]]);
}

/// Generates bytes that resemble an OBJ file closely enough to reach most of the reader.
fn obj_like() -> impl Strategy<Value = Vec<u8>> {
    let words = prop::sample::select(vec![
        "v",
        "vt",
        "vn",
        "f",
        "o",
        "g",
        "usemtl",
        "mtllib",
        "#",
        "\\",
        "\\\n",
        "\n",
        "\r\n",
        "\r",
        " ",
        "\t",
        "0",
        "1",
        "2",
        "3",
        "-1",
        "-2",
        "1//1",
        "1/1/1",
        "1/",
        "/",
        "nan",
        "1e39",
        "-1e-40",
        "0.5",
        "a.mtl",
        "\u{e9}",
        "cstype",
        "deg",
        "end",
        "\n v 0 0 0\n",
        "\nv 1 0 0\n",
        "\nvn 0 1 0\n",
        "\nf 1 2 3\n",
        "\nf -1 -2 -3\n",
    ]);
    let piece = prop_oneof![
        20 => words.prop_map(|word| format!("{word} ").into_bytes()),
        20 => prop::sample::select(vec!["\nv 1 2 3\n", "\nv 0 1 0.5\n", "\nf 1 2 3 4\n", "\nf 3 2 1\n"])
            .prop_map(|line| line.as_bytes().to_vec()),
        1 => prop::collection::vec(any::<u8>(), 0..8),
    ];
    prop::collection::vec(piece, 0..60).prop_map(|pieces| pieces.concat())
}

/// Reads bytes and calls every query of the document.
fn exercise(bytes: Vec<u8>) {
    let Ok(document) = Document::from_bytes("x.obj", bytes) else { return };
    let names: Vec<_> = document.groups().map(|group| group.name.clone()).collect();
    document.libraries();
    for object in std::iter::once(None).chain(names.iter().map(|name| Some(name.as_str()))) {
        if let Ok(mesh) = document.mesh(object) {
            assert!(mesh.volume().is_finite() && mesh.topology().edges > 0);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn arbitrary_bytes_do_not_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        exercise(bytes);
    }

    #[test]
    fn obj_like_bytes_do_not_panic(bytes in obj_like()) {
        exercise(bytes);
    }

    #[test]
    fn mutated_files_do_not_panic(changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
                          cut in any::<prop::sample::Index>()) {
        let mut bytes = include_bytes!("../../data/odd.obj").to_vec();
        for (at, byte) in changes {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        let cut = cut.index(2 * bytes.len());
        bytes.truncate(cut.max(1));
        exercise(bytes);
    }
}

/// Returns the surface that obj-rs reads, or `None` if it cannot read the file.
fn by_obj_rs(bytes: &[u8]) -> Option<Mesh> {
    let raw = std::panic::catch_unwind(|| ::obj::raw::parse_obj(bytes)).ok()?.ok()?;
    Some(obj::from_raw(&raw).unwrap())
}

#[test]
fn positions_and_faces_equal_those_of_obj_rs() {
    let mut compared = Vec::new();
    // obj-rs reads numbers as f32.
    let mut compare = |name: String, bytes: Vec<u8>| {
        let Some(theirs) = by_obj_rs(&bytes) else { return };
        let ours = parse(&bytes).unwrap();
        let bits = |mesh: &Mesh| -> Vec<_> {
            mesh.vertices()
                .iter()
                .flat_map(|point| <[f64; 3]>::from(point.coords).map(|x| (x as f32).to_bits()))
                .collect()
        };
        assert!(bits(&ours) == bits(&theirs), "{name}");
        assert!(ours.faces().eq(theirs.faces()), "{name}");
        compared.push(name);
    };
    for folder in ["examples/scenes", "tests/data"] {
        for entry in std::fs::read_dir(file(folder)).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_some_and(|extension| extension == "obj") {
                compare(path.display().to_string(), std::fs::read(&path).unwrap());
            }
        }
    }
    let mut random = fastrand::Rng::with_seed(7);
    let mut text = String::new();
    for _ in 0..3000 {
        let mut number = || match random.u32(0..4) {
            0 => format!("{:e}", f32::from_bits(random.u32(0..0x7f80_0000))),
            1 => format!("-{}", random.u64(..)),
            2 => format!("{:.9}", random.f64() - 0.5),
            _ => format!("+.{}e{}", random.u64(..), random.i32(-40..20)),
        };
        text += &format!("v {} {}\t {}\n", number(), number(), number());
    }
    for _ in 0..500 {
        let corners: Vec<_> = (0..random.usize(3..6)).map(|_| random.u32(1..3001).to_string()).collect();
        text += &format!("f {}\n", corners.join(" "));
    }
    compare("random".to_owned(), text.into_bytes());
    let cube = std::fs::read_to_string(data("hard_edges.obj")).unwrap();
    for corners in ["f 1 2 4 3", "f 1/1 2/1 4/1 3/1", "f 1//1 2//1 4//1 3//1", "f 1/1/1 2/1/1 4/1/1 3/1/1"] {
        compare(corners.to_owned(), format!("{cube}\nvt 0 0\n{corners}\n").into_bytes());
    }
    for name in ["random", "f 1 2 4 3", "f 1/1", "f 1//1", "f 1/1/1", "bust.obj"] {
        assert!(compared.iter().any(|compared| compared.contains(name)), "{name} is not in {compared:?}");
    }
}

#[test]
fn indices_of_obj_rs_out_of_range_are_errors() {
    let mut raw = ::obj::raw::parse_obj(TRIANGLE.as_bytes()).unwrap();
    for vertex in [3, usize::MAX] {
        raw.polygons[0] = ::obj::raw::object::Polygon::PN(vec![(0, 9), (1, 9), (vertex, 0)]);
        let error = obj::from_raw(&raw).unwrap_err();
        assert!(matches!(error, supple::MeshError::IndexOutOfRange { face: 0, count: 3, .. }), "{error}");
    }
    raw.polygons.clear();
    assert!(matches!(obj::from_raw(&raw), Err(supple::MeshError::NoFaces { .. })));
}
