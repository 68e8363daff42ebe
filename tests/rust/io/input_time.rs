//! Time of reading: a file of a few megabytes is read or refused within two seconds, whatever it contains.

use std::fmt::Write;
use std::path::Path;
use std::time::{Duration, Instant};

use supple_io::obj::Document;
use supple_io::scene::Scene;

/// Largest processor time for an input. All inputs have at most 10 MB, and the readers take less than a second
/// for each of them.
const LIMIT: Duration = Duration::from_secs(2);

/// Asserts that `read` takes at most [`LIMIT`].
fn assert_fast<T>(name: &str, read: impl FnOnce() -> T) -> T {
    let (start, processor_start) = (Instant::now(), processor_time());
    let result = read();
    let time = match (processor_start, processor_time()) {
        (Some(start), Some(end)) => end - start,
        _ => start.elapsed(),
    };
    assert!(time <= LIMIT, "{name}: {time:?}");
    result
}

/// Returns the processor time of this thread, which other processes do not delay, on systems with `/proc`.
fn processor_time() -> Option<Duration> {
    let times = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    Some(Duration::from_nanos(times.split(' ').next()?.parse().ok()?))
}

/// Reads an OBJ file and describes its surface. Returns the number of faces, or the error.
fn read_obj(name: &str, text: &str) -> Result<usize, String> {
    assert_fast(name, || {
        let document = Document::from_bytes("x.obj", text.into()).map_err(|error| error.to_string())?;
        document.libraries();
        let mesh = document.mesh(None).map_err(|error| error.to_string())?;
        mesh.topology();
        Ok(mesh.face_count())
    })
}

/// Reads a scene. Returns the number of bodies, or the error.
fn read_scene(name: &str, text: &str) -> Result<usize, String> {
    assert_fast(name, || {
        let scene = Scene::parse(text, "x.toml", Path::new(""), &[]);
        scene.map(|scene| scene.bodies.len()).map_err(|error| error.to_string())
    })
}

/// Returns the texts of the numbers from 0 to `count - 1`.
fn each(count: usize, text: impl Fn(usize) -> String) -> String {
    (0..count).map(text).collect()
}

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
const BODY: &str = "[[body]]\nname = \"a\"\nmesh = \"a.obj\"\n";

#[test]
fn obj_statements_of_megabytes_are_read_in_linear_time() {
    let continued = format!("{TRIANGLE}f 1 2 3{}", " \\\n 1".repeat(500_000));
    assert_eq!(read_obj("a continued line", &continued), Ok(2));
    let blank_lines = format!("{TRIANGLE}f 1 2 \\{}3\n", "\n ".repeat(1_000_000));
    assert_eq!(read_obj("blank lines in a continued line", &blank_lines), Ok(2));
    let blanks = format!("{TRIANGLE}f 1 2 {}3\n", " ".repeat(8_000_000));
    assert_eq!(read_obj("a line of blanks", &blanks), Ok(2));
    let backslashes = format!("{TRIANGLE}o {}\n", "\\ \t ".repeat(1_000_000));
    assert_eq!(read_obj("backslashes in a name", &backslashes), Ok(1));
    let groups = format!("g{}\n{TRIANGLE}", each(1_000_000, |group| format!(" {group:x}")));
    assert_eq!(read_obj("groups in one line", &groups), Ok(1));
    let libraries = format!("{TRIANGLE}mtllib{}\n", " a\\b.mtl".repeat(200_000));
    assert_eq!(read_obj("libraries in one line", &libraries), Ok(1));
}

#[test]
fn polygons_of_any_size_become_a_mesh_in_linear_time() {
    let count = 100_000;
    let circle = each(count, |vertex| {
        let (y, x) = (vertex as f64 * std::f64::consts::TAU / count as f64).sin_cos();
        format!("v {x} {y} 0\n")
    });
    let corners = each(count, |vertex| format!(" {}", vertex + 1));
    assert_eq!(read_obj("a polygon", &format!("{circle}f{corners}\n")), Ok(1));
    let pinched = " 1 2 3".repeat(count);
    assert_eq!(read_obj("a polygon that repeats its corners", &format!("{TRIANGLE}f{pinched}\n")), Ok(2));
    let fan = each(count, |vertex| format!("f 1 {} {}\n", vertex % count + 1, (vertex + 1) % count + 1));
    assert_eq!(read_obj("faces at one vertex", &format!("{circle}{fan}")), Ok(count));
    let above = format!("f{corners}\n{circle}");
    assert_eq!(read_obj("a polygon above its vertices", &above), Ok(1));
}

#[test]
fn obj_errors_take_linear_time() {
    let objects = each(200_000, |object| format!("o {object}\nf 1 2 3\n"));
    let document = Document::from_bytes("x.obj", format!("{TRIANGLE}{objects}").into()).unwrap();
    let error = assert_fast("an unknown object", || document.mesh(Some("head")).unwrap_err().to_string());
    assert!(error.ends_with("`18`, `19`, and 199980 more"), "{error}");

    let word = "x".repeat(4_000_000);
    for text in [word.clone(), format!("v {word} 0 0"), format!("v 0 0 0\nf {word}")] {
        let error = read_obj("a long word", &text).unwrap_err();
        assert!(error.contains("... (4000000 bytes)") && error.len() < 300, "{error}");
    }
}

#[test]
fn scenes_of_megabytes_are_read_or_refused_in_linear_time() {
    let unknown = format!("{BODY}{}", each(200_000, |key| format!("key{key} = 1\n")));
    let error = read_scene("unknown keys", &unknown).unwrap_err();
    assert!(error.starts_with("x.toml:4: unknown key `body.a.key0`"), "{error}");

    let numbers = each(400_000, |vertex| format!("{vertex},\n"));
    let vertices = format!("{BODY}[[body.pin]]\nvertices = [{numbers}]\n");
    assert_eq!(read_scene("vertices", &vertices), Ok(1));
    // Every key below a body contains the name of the body.
    let long_name = vertices.replace("\"a\"", &format!("\"{}\"", "n".repeat(1_000_000)));
    let error = read_scene("a long name", &long_name).unwrap_err();
    assert!(error.contains("`body.0.name` is the string") && error.len() < 300, "{error}");
    let error = read_scene("a long key", &format!("{BODY}{} = 1\n", "k".repeat(4_000_000))).unwrap_err();
    // The message also lists the known keys.
    assert!(error.contains("... (4000007 bytes)") && error.len() < 1000, "{error}");

    let bodies = each(20_000, |body| format!("[[body]]\nname = \"b{body}\"\nmesh = \"a.obj\"\n"));
    assert_eq!(read_scene("bodies", &bodies), Ok(20_000));
    let mut keyframes = String::new();
    for time in 0..50_000 {
        writeln!(keyframes, "{{ time = {time}, translate = [0, 1, 0] }},").unwrap();
    }
    let sphere = "sphere = { center = [0, 0, 0], radius = 1 }";
    let handle = format!("{BODY}[[body.handle]]\n{sphere}\nkeys = [\n{keyframes}]\n");
    assert_eq!(read_scene("keyframes", &handle), Ok(1));

    for (name, text) in [
        ("brackets", format!("a = {}", "[".repeat(1_000_000))),
        ("braces", format!("a = {}", "{a=".repeat(500_000))),
        ("a dotted key", format!("a{} = 1", ".a".repeat(1_000_000))),
        ("a dotted header", format!("[a{}]", ".a".repeat(1_000_000))),
        ("headers", each(100_000, |table| format!("[t{table}]\n"))),
        (
            "headers below and above",
            each(50_000, |t| format!("[t{t}.a]\n")) + &each(50_000, |t| format!("[t{t}]\n")),
        ),
        ("repeated headers", "[t]\n".repeat(500_000)),
        ("invalid lines", "a b\n".repeat(1_000_000)),
        ("quotes", "\"".repeat(4_000_000)),
        ("blanks", " ".repeat(8_000_000)),
        ("a comment", format!("#{}", "x".repeat(8_000_000))),
        ("carriage returns", "\r".repeat(4_000_000)),
    ] {
        assert!(read_scene(name, &text).unwrap_err().len() < 500, "{name}");
    }
}
