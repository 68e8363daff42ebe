//! Types of files that are read, and messages about input: no control characters, and a way out.

use std::path::Path;

use supple_io::obj::{self, Document};
use supple_io::scene::{Scene, Up};

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
const BODY: &str = "[[body]]\nname = \"a\"\nmesh = \"a.obj\"\n";

fn scene_error(text: &str, file: &str, overrides: &[&str]) -> String {
    let overrides: Vec<String> = overrides.iter().map(ToString::to_string).collect();
    Scene::parse(text, file, Path::new(""), &overrides).unwrap_err().to_string()
}

fn obj_error(text: &[u8], path: &str, object: Option<&str>) -> String {
    let mesh = Document::from_bytes(path, text.to_vec()).and_then(|document| document.mesh(object));
    mesh.unwrap_err().to_string()
}

#[cfg(unix)]
#[test]
fn only_regular_files_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    std::fs::create_dir(path("directory")).unwrap();
    assert!(std::process::Command::new("mkfifo").arg(path("pipe")).status().unwrap().success());
    let _socket = std::os::unix::net::UnixListener::bind(path("socket")).unwrap();
    std::os::unix::fs::symlink("/dev/zero", path("device")).unwrap();
    for (name, expected) in [
        ("directory", "it is a directory; give a file"),
        ("pipe", "it is a pipe; save its data as a regular file and give that"),
        ("socket", "it is a socket; save its data as a regular file and give that"),
        ("device", "it is a device; save its data as a regular file and give that"),
    ] {
        for (extension, verb) in [("obj", "cannot be read"), ("toml", "cannot read the scene")] {
            let link = path(&format!("{name}.{extension}"));
            std::os::unix::fs::symlink(name, &link).unwrap();
            let message = Scene::open(&link, Up::Y, &[]).unwrap_err().to_string();
            assert_eq!(message, format!("{}: {verb}: {expected}", link.display()));
        }
        let message = obj::read(path(name)).unwrap_err().to_string();
        assert!(message.ends_with(expected), "{message}");
        // A mesh of a scene.
        let text = format!("[[body]]\nname = \"a\"\nmesh = \"{name}\"\n");
        let scene = Scene::parse(&text, "x.toml", folder.path(), &[]).unwrap();
        let message = supple_io::run::prepare(&scene).unwrap_err().to_string();
        assert!(message.ends_with(expected), "{message}");
        // A material library is not read.
        let text = format!("mtllib {name}\n{TRIANGLE}");
        let document = Document::from_bytes(path("x.obj"), text.into()).unwrap();
        assert!(!document.libraries()[0].exists);
    }
    std::fs::File::create(path("large.toml")).unwrap().set_len((32 << 20) + 1).unwrap();
    let message = Scene::read(path("large.toml")).unwrap_err().to_string();
    assert!(message.ends_with("it has 33554433 bytes; the largest size is 33554432 bytes"), "{message}");
    std::fs::write(path("file"), TRIANGLE).unwrap();
    std::os::unix::fs::symlink("file", path("file.obj")).unwrap();
    assert_eq!(obj::read(path("file.obj")).unwrap().face_count(), 1);
}

#[test]
fn messages_contain_no_control_characters() {
    let esc = "\u{1b}[2J\u{9b}31m\u{202e}";
    let path = format!("x{esc}");
    let toml = esc.replace('\u{1b}', "\\u001b").replace('\u{9b}', "\\u009b").replace('\u{202e}', "\\u202e");
    let obj = |line: &str| obj_error(format!("{TRIANGLE}{line}\n").as_bytes(), &path, None);
    let mut messages = vec![
        obj(&format!("v 0 {esc} 0")),
        obj(&format!("f 1 2 {esc}")),
        obj_error(format!("{esc} 1\n").as_bytes(), &path, None),
        obj_error(format!("{TRIANGLE}g a{esc}\nf 1 2 3\n").as_bytes(), &path, Some(esc)),
        // In Latin-1, the byte 0x9b is a control character.
        obj_error(b"v 0 \x9b31m 0\n", "x.obj", None),
        obj::read(format!("none{esc}.obj")).unwrap_err().to_string(),
        Scene::open(format!("none{esc}.toml"), Up::Y, &[]).unwrap_err().to_string(),
        Scene::open(format!("none.{esc}"), Up::Y, &[]).unwrap_err().to_string(),
        Scene::parse(BODY, "x", Path::new(""), &[format!("{esc}=1")]).unwrap_err().to_string(),
        Scene::parse(BODY, "x", Path::new(""), &[format!("body.{esc}.x=1")]).unwrap_err().to_string(),
        Scene::parse(BODY, "x", Path::new(""), &[esc.to_owned()]).unwrap_err().to_string(),
        Scene::parse(BODY, "x", Path::new(""), &[format!("body.a.scale={esc}")]).unwrap_err().to_string(),
    ];
    for line in ["\"KEY\" = 1", "scale = \"KEY\"", "volume = \"KEY\"", "name = \"KEY\""] {
        let text = BODY.replace("name = \"a\"\n", "") + &line.replace("KEY", &toml) + "\n";
        messages.push(scene_error(&text, &path, &[]));
    }
    messages.push(scene_error(&format!("a = {esc}"), &path, &[]));
    for message in messages {
        let is_control = |c: char| c.is_control() || c == '\u{202e}';
        assert!(!message.contains(is_control), "{message:?}");
        assert!(message.contains("\\u{9b}"), "{message}");
    }
}

/// Errors and notes of runs escape names themselves, so that Python and Rust programs show them escaped.
#[cfg(unix)]
#[test]
fn messages_of_runs_contain_no_control_characters() {
    use std::path::PathBuf;
    use supple_io::frames::OutputError;
    use supple_io::run::{Job, Note, RunError};

    let bad = "a\n\u{1b}[2J\u{202e}";
    let path = || PathBuf::from(bad);
    let folder = tempfile::tempdir().unwrap();
    let source = || std::io::Error::other("failed");
    // Errors of real runs: no permission is needed for a missing mesh, an output that is a file, and
    // statistics with another extension or in a missing folder.
    let text = "[simulation]\nframes = 1\n[[body]]\nname = \"x\"\nmesh = \"x.obj\"\n";
    let mut scene = Scene::parse(text, "x.toml", folder.path(), &[]).unwrap();
    scene.bodies[0].mesh = path();
    let mut job = Job::new(scene, folder.path().join("out"));
    let run = |job: &Job| job.run(&mut ()).unwrap_err().to_string();
    let mut messages = vec![run(&job)];
    let cube = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nf 1 2 3 4\nf 1 2 6 5\n";
    std::fs::write(folder.path().join(bad), cube).unwrap();
    job.stats = Some(folder.path().join(bad));
    messages.push(run(&job));
    job.stats = Some(folder.path().join(bad).join("s.csv"));
    messages.push(run(&job));
    job.stats = None;
    job.directory = folder.path().join(bad);
    messages.push(run(&job));
    job.directory = folder.path().join(bad).join("out");
    messages.push(run(&job));
    // The other errors.
    let no_faces = supple::MeshError::NoFaces { faces: 0, vertices: 0 }.into();
    messages.extend(
        [
            RunError::Body { key: bad.into(), source: no_faces },
            RunError::StatsIsInput { path: path(), input: path() },
            RunError::StatsLost { path: path(), problem: "lost".into(), first: 0, last: 1 },
            RunError::NotWritable { path: path(), source: source() },
            RunError::Locked { path: path() },
            RunError::Checkpoint { path: path(), what: bad.into() },
            RunError::Differs { path: path(), difference: bad.into() },
            RunError::Io { action: "write", path: path(), source: source() },
            OutputError::Io { action: "write", path: path(), source: source() }.into(),
            OutputError::OverwritesInput { path: path() }.into(),
            OutputError::NameTooLong { name: bad.into(), length: 300, max: 255 }.into(),
            OutputError::Link { path: path() }.into(),
            OutputError::Cache { path: path(), reason: bad.into() }.into(),
        ]
        .map(|error: RunError| error.to_string()),
    );
    messages.push(Note::Restarted { reason: bad.into() }.to_string());
    for message in messages {
        assert!(!message.contains(|c: char| c.is_control() || c == '\u{202e}'), "{message:?}");
        assert!(message.contains("a\\n\\u{1b}[2J\\u{202e}"), "{message}");
    }
}

#[cfg(unix)]
#[test]
fn paths_that_a_scene_cannot_contain_are_errors() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;

    let folder = tempfile::tempdir().unwrap();
    let directory = folder.path().join(OsStr::from_bytes(b"\xff"));
    std::fs::create_dir(&directory).unwrap();
    std::fs::write(directory.join("a.obj"), TRIANGLE).unwrap();
    let message = Scene::open(directory.join("a.obj"), Up::Y, &[]).unwrap_err().to_string();
    assert!(
        message.ends_with("a scene cannot contain this path, because it is not UTF-8; rename it"),
        "{message}"
    );
    // A relative path can be read, but not be made absolute.
    std::fs::write(directory.join("a.toml"), BODY).unwrap();
    let scene = Scene::open(directory.join("a.toml"), Up::Y, &[]).unwrap();
    assert!(scene.relocated(None).unwrap_err().to_string().contains("not UTF-8"));
    let moved = scene.relocated(Some(&directory)).unwrap();
    assert_eq!((moved.bodies[0].mesh.to_str(), moved.base), (Some("a.obj"), directory));
}

#[test]
fn body_names_have_letters_of_any_language() {
    for name in [
        "a.b-c_1",
        "K\u{f6}pfchen",
        "Ko\u{308}pfchen",
        "\u{5934}",
        "\u{928}\u{92e}\u{938}\u{94d}\u{924}\u{947}",
        "\u{663}",
    ] {
        let text = BODY.replace("\"a\"", &format!("\"{name}\""));
        let scene = Scene::parse(&text, "x.toml", Path::new(""), &[]).unwrap();
        assert_eq!(scene.bodies[0].name, name);
        assert_eq!(Scene::parse(&scene.to_toml(), "x.toml", Path::new(""), &[]).unwrap(), scene);
        // The name of the file is the default.
        let text = format!("[[body]]\nmesh = \"models/{name}.obj\"\n");
        assert_eq!(Scene::parse(&text, "x.toml", Path::new(""), &[]).unwrap().bodies[0].name, name);
    }
    for (name, default) in [(".hidden", "_hidden"), ("a b", "a_b"), ("\u{1f9b4}", "_"), ("a:b", "a_b")] {
        let text = BODY.replace("\"a\"", &format!("\"{name}\""));
        let message = scene_error(&text, "x.toml", &[]);
        assert!(message.contains("made of letters, digits, `-`, `_` and `.` only, without"), "{message}");
        let text = format!("[[body]]\nmesh = \"models/{name}.obj\"\n");
        assert_eq!(Scene::parse(&text, "x.toml", Path::new(""), &[]).unwrap().bodies[0].name, default);
    }
    let text = |length| BODY.replace("\"a\"", &format!("\"{}\"", "\u{e4}".repeat(length)));
    assert!(Scene::parse(&text(100), "x.toml", Path::new(""), &[]).is_ok());
    assert!(scene_error(&text(101), "x.toml", &[]).contains("of at most 200 bytes"));
    let long = format!("[[body]]\nmesh = \"{}.obj\"\n", "\u{e4}".repeat(101));
    let scene = Scene::parse(&long, "x.toml", Path::new(""), &[]).unwrap();
    assert_eq!(scene.bodies[0].name, "\u{e4}".repeat(100));
}

#[test]
fn unknown_shapes_and_extensions_are_errors_with_the_known_ones() {
    let message = scene_error(&format!("{BODY}[[collider]]\ntorus = 1\n"), "x.toml", &[]);
    let expected = "x.toml:5: unknown key `collider.0.torus`; give one of `plane`, `sphere`, `box`, `capsule`, \
         `mesh`";
    assert_eq!(message, expected);
    let message = scene_error(&format!("{BODY}[[body.pin]]\ncylinder = 1\n"), "x.toml", &[]);
    assert!(
        message.ends_with("give one of `box`, `sphere`, `plane`, `vertices`, `group`, `map`, `lattice`"),
        "{message}"
    );
    // Misspelled keys, and keys beside a shape.
    for (lines, nearest) in
        [("spere = 1", "sphere"), ("sphere = 1\ntorus = 1", "sphere"), ("fricton = 1", "friction")]
    {
        let message = scene_error(&format!("{BODY}[[collider]]\n{lines}\n"), "x.toml", &[]);
        let way_out = if lines.contains("torus") { "give one of `" } else { "the nearest one is `" };
        assert!(message.contains(way_out) && message.contains(&format!("`{nearest}`")), "{message}");
    }
    for (path, expected) in [
        ("a/b.fbx", "a/b.fbx: files with the extension .fbx are not read"),
        ("a/b", "a/b: files without an extension are not read"),
        ("Cargo.toml/b", "Cargo.toml/b: files without an extension are not read"),
    ] {
        let expected = format!(
            "{expected}; give a scene (.toml) or a model: OBJ (.obj), GLB (.glb), glTF (.gltf), STL (.stl) or PLY (.ply)"
        );
        assert_eq!(Scene::open(path, Up::Y, &[]).unwrap_err().to_string(), expected);
    }
    assert!(
        Scene::open("a/b.stl", Up::Y, &[]).unwrap_err().to_string().starts_with("a/b.stl: cannot be read: ")
    );
}

#[test]
fn paths_of_windows_and_text_in_utf_16_are_errors_that_say_what_to_write() {
    let way_out = "write / in a path, or quote it with ' in place of \"";
    for mesh in [r"C:\models\cube.obj", r"C:\Users\me\cube.obj", r"C:\temp\new.obj", r"C:\bust.obj"] {
        let message = scene_error(&format!("[[body]]\nmesh = \"{mesh}\"\n"), "x.toml", &[]);
        assert!(message.starts_with("x.toml:2: ") && message.ends_with(way_out), "{message}");
    }
    let quoted = "[[body]]\nmesh = 'C:\\temp\\new.obj'\n[output]\ndirectory = 'C:\\temp'\n";
    assert!(Scene::parse(quoted, "x.toml", Path::new(""), &[]).is_ok());
    let message = scene_error(&format!("{BODY}[output]\ndirectory = \"C:\\temp\"\n"), "x.toml", &[]);
    assert!(message.contains("`output.directory`") && message.ends_with(way_out), "{message}");
    // An error on a line without `\` has nothing to do with paths.
    assert!(!scene_error("[[body]]\nmesh = \"\n", "x.toml", &[]).contains(way_out));

    let folder = tempfile::tempdir().unwrap();
    let utf_16 = |text: &str| -> Vec<u8> {
        [0xfeff].into_iter().chain(text.encode_utf16()).flat_map(u16::to_le_bytes).collect()
    };
    let path = folder.path().join("x.toml");
    std::fs::write(&path, utf_16(BODY)).unwrap();
    let message = Scene::read(&path).unwrap_err().to_string();
    assert!(
        message.ends_with("x.toml:1: the text is UTF-16, and TOML is UTF-8; save it as UTF-8"),
        "{message}"
    );
    let message = obj_error(&utf_16(TRIANGLE), "x.obj", None);
    assert_eq!(message, "x.obj: is UTF-16 text; save it as UTF-8 or ASCII");
}

#[test]
fn quoted_libraries_are_found_and_names_that_end_in_a_backslash_are_errors() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("my file.mtl"), "").unwrap();
    for (line, names, exists) in [
        ("mtllib \"my file.mtl\"", vec!["my file.mtl"], true),
        ("mtllib \"your file.mtl\"", vec!["your file.mtl"], false),
        ("mtllib \"my file.mtl\" \"my file.mtl\"", vec!["my file.mtl"; 2], true),
        ("mtllib \"a.mtl", vec!["\"a.mtl"], false),
    ] {
        let text = format!("{line}\n{TRIANGLE}");
        let document = Document::from_bytes(folder.path().join("x.obj"), text.into()).unwrap();
        let found = document.libraries();
        assert_eq!(found.iter().map(|library| library.name.as_str()).collect::<Vec<_>>(), names, "{line}");
        assert!(found.iter().all(|library| library.exists == exists), "{line}");
    }
    for name in ["o C:\\models\\", "g a \\", "usemtl wood\\  ", "mtllib a.mtl\\"] {
        let message = obj_error(format!("{name}\n{TRIANGLE}").as_bytes(), "x.obj", None);
        let expected = format!(
            "x.obj:1: the name in `{}` ends in `\\`, which continues the line, here with `v 0 0 0`; remove the `\\` at \
             the end of the line",
            name.split_once(' ').unwrap().0
        );
        assert_eq!(message, expected);
    }
    // Lines of names and of numbers may continue.
    let text = "g a \\\n b c\nv 0 0 \\\n0\nv 1 0 0\nv 0 1 0\nf 1 2 \\\n 3\n";
    assert!(Document::from_bytes("x.obj", text.into()).is_ok());
}
