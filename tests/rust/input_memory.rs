//! Memory of reading and of building lattices: the peak is at most a fixed multiple of the size of the file, or of the
//! number of lattice vertices.

use std::path::Path;

use supple::{Lattice, LatticeOptions, Mesh, Resolution};
use supple_io::obj::Document;
use supple_io::scene::Scene;
use supple_tests::counting_allocator::{CountingAllocator, thread_peak};

#[global_allocator]
static ALLOCATOR: CountingAllocator = CountingAllocator;

/// Asserts that `read` allocates at most `factor` times the size of `text` at any time.
fn assert_small(name: &str, text: &str, factor: f64, read: impl FnOnce(&str)) {
    let measured = thread_peak(|| read(text)) as f64 / text.len() as f64;
    assert!(measured <= factor, "{name}: {measured:.1} bytes per byte of the file, not {factor}");
}

fn each(count: usize, text: impl Fn(usize) -> String) -> String {
    (0..count).map(text).collect()
}

#[test]
fn reading_an_obj_file_takes_a_multiple_of_its_size() {
    // The factors are the sizes of the elements, doubled for growing arrays, for each byte of their text.
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    for (name, text, factor) in [
        ("blanks", format!("{triangle}f 1 2 {}3\n", " ".repeat(4_000_000)), 1.1),
        ("vertices", format!("{triangle}{}", "v 0 0 1\n".repeat(400_000)), 30.0),
        ("faces", format!("{triangle}{}", "f 1 2 3\n".repeat(400_000)), 30.0),
        ("corners", format!("{triangle}f{}", " 1".repeat(1_000_000)), 40.0),
        ("forward references", format!("f{}\n{triangle}", " 3".repeat(1_000_000)), 40.0),
        ("groups", format!("g{}\n{triangle}", each(500_000, |group| format!(" {group:x}"))), 60.0),
        (
            "objects",
            format!("{triangle}{}", each(200_000, |object| format!("o {object:x}\nf 1 2 3\n"))),
            30.0,
        ),
        ("keywords", format!("{triangle}{}", each(500_000, |keyword| format!("{keyword:x}\n"))), 2.0),
        ("libraries", format!("mtllib{}\n{triangle}", " a.mtl".repeat(200_000)), 40.0),
    ] {
        assert_small(name, &text, factor, |text| {
            let document = Document::from_bytes("x.obj", text.into()).unwrap();
            document.libraries();
            document.mesh(None).unwrap();
        });
    }
}

#[test]
fn reading_a_scene_takes_a_multiple_of_its_size() {
    let body = "[[body]]\nmesh = \"a.obj\"\n";
    for (name, text, factor) in [
        ("vertices", format!("{body}[[body.pin]]\nvertices = [{}]", "1,".repeat(500_000)), 200.0),
        ("unknown keys", format!("{body}{}", each(200_000, |key| format!("k{key}=1\n"))), 100.0),
        ("blanks", format!("{body}{}", " ".repeat(4_000_000)), 10.0),
    ] {
        assert_small(name, &text, factor, |text| {
            let _ = Scene::parse(text, "x.toml", Path::new(""), &[]);
        });
    }
}

#[test]
fn a_lattice_takes_a_multiple_of_its_vertices_for_any_bounding_box() {
    // Bytes per lattice vertex that the memory limit assumes for a lattice and its simulation.
    const BYTES: usize = 250;
    const END: f64 = 10_000.0;
    let needle = [[[0.0; 3], [END; 3], [END, END - 0.5, END - 0.7]]];
    let ends = [0.0, END].map(|x| [[x; 3], [x + 1.5, x, x], [x, x + 1.5, x + 1.5]]);
    for (name, triangles, least) in [
        ("a diagonal needle", needle.as_slice(), END),
        // A bridge has three steps for each cell of the diagonal.
        ("distant triangles", &ends, 3.0 * END),
    ] {
        let faces: Vec<[u32; 3]> =
            (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let mesh = Mesh::new(triangles.concat(), &faces).unwrap();
        let options = LatticeOptions { resolution: Resolution::CellSize(1.0), ..Default::default() };
        let mut lattice = None;
        let peak = thread_peak(|| lattice = Some(Lattice::from_mesh(&mesh, &options).unwrap()));
        let lattice = lattice.unwrap();
        assert!(lattice.cells().len() as f64 >= least, "{name}: {} cells", lattice.cells().len());
        assert!(
            peak <= (BYTES * lattice.len()) as isize,
            "{name}: {peak} bytes for {} vertices",
            lattice.len()
        );
    }
}
