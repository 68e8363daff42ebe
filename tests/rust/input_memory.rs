//! Memory of reading and of building lattices: the peak is at most a fixed multiple of the size of the file, or of the
//! number of lattice vertices.

use std::path::Path;

use supple::{Lattice, LatticeOptions, Mesh, Resolution};
use supple_io::model;
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
fn reading_maps_takes_a_multiple_of_the_size_of_the_file() {
    let triangle = "v 0 0 0 0 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\n";
    let ply = |properties: usize, vertices: usize| {
        let names = each(properties, |name| format!("property uchar p{name}\n"));
        format!(
            "ply\nformat ascii 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\nproperty float z\n\
             {names}element face 1\nproperty list uchar int vertex_index\nend_header\n{}3 0 1 2\n",
            each(vertices, |vertex| format!("{vertex} {} 0{}\n", vertex % 2, " 1".repeat(properties)))
        )
    };
    // Colors of a text have 32 bytes for each `v`, doubled for growing arrays, and their maps 16, twice for the mesh.
    for (name, text, factor) in [
        ("colors", format!("{triangle}{}", "v 0 0 1 0 0 0 0\n".repeat(400_000)), 30.0),
        ("one color", format!("{}{triangle}", "v 0 0 1\n".repeat(400_000)), 30.0),
        ("properties", ply(1000, 400), 30.0),
    ] {
        assert_small(name, &text, factor, |text| {
            let document = model::from_bytes("x.obj", text.into()).unwrap();
            assert!(!document.grouped_mesh(None).unwrap().maps().is_empty());
        });
    }
}

#[test]
fn reading_other_models_takes_a_multiple_of_their_size() {
    let ply = |vertices: usize, faces: usize, lines: String| {
        let floats = "property float x\nproperty float y\nproperty float z\n";
        format!(
            "ply\nformat ascii 1.0\nelement vertex {vertices}\n{floats}element face {faces}\n\
             property list uchar int vertex_index\nend_header\n0 0 0\n1 0 0\n0 1 0\n{lines}"
        )
    };
    let facet =
        "facet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";
    let node = "{\"mesh\":0},";
    let gltf = format!(
        "{{\"asset\":{{\"version\":\"2.0\"}},\"nodes\":[{}{{}}],\"meshes\":[{{\"primitives\":[]}}]}}",
        node.repeat(100_000)
    );
    for (name, text, factor) in [
        ("vertices", ply(200_003, 1, format!("{}3 0 1 2\n", "0 0 1\n".repeat(200_000))), 60.0),
        ("faces", ply(3, 200_000, "3 0 1 2\n".repeat(200_000)), 60.0),
        ("corners", ply(3, 1, format!("1000000{}\n", " 1".repeat(1_000_000))), 60.0),
        ("triangles", format!("solid a\n{}endsolid a\n", facet.repeat(20_000)), 10.0),
        ("solids", format!("solid a\n{facet}endsolid a\n").repeat(20_000), 10.0),
        ("nodes", gltf, 100.0),
    ] {
        assert_small(name, &text, factor, |text| {
            let _ = model::from_bytes("model", text.into()).map(|document| document.mesh(None));
        });
    }
}

#[test]
fn numbers_in_the_headers_of_models_take_no_memory() {
    let ply = |count: u64| {
        format!(
            "ply\nformat binary_little_endian 1.0\nelement vertex {count}\nproperty float x\nproperty float y\n\
             property float z\nelement face {count}\nproperty list uint int vertex_index\nend_header\n"
        )
    };
    let list = ply(1).into_bytes();
    let list = [&list[..], &[0; 12], &u32::MAX.to_le_bytes(), &[0; 12]].concat();
    let stl = [&[0; 80][..], &u32::MAX.to_le_bytes()].concat();
    let gltf = |accessor: &str| {
        let primitive = "{\"attributes\":{\"POSITION\":0}}";
        format!(
            "{{\"asset\":{{\"version\":\"2.0\"}},\"buffers\":[{{\"byteLength\":4000000000,\"uri\":\"data:;base64,AAAA\"}}],\
             \"bufferViews\":[{{\"buffer\":0,\"byteLength\":3}}],\"accessors\":[{{{accessor},\"type\":\"VEC3\",\
             \"componentType\":5126}}],\"meshes\":[{{\"primitives\":[{primitive}]}}],\"nodes\":[{{\"mesh\":0}}]}}"
        )
    };
    let sparse = "\"sparse\":{\"count\":1,\"indices\":{\"bufferView\":0,\"componentType\":5121},\"values\":{\"bufferView\":0}}";
    let long = gltf("\"bufferView\":0,\"count\":4000000000");
    let files = [
        ply(4_000_000_000).into_bytes(),
        ply(u64::MAX).into_bytes(),
        list,
        stl,
        long.clone().into_bytes(),
        long.replace("\"byteLength\":4000000000", "\"byteLength\":3").into_bytes(),
        gltf(&format!("\"count\":4000000000,{sparse}"))
            .replace("\"byteLength\":4000000000", "\"byteLength\":3")
            .into_bytes(),
    ];
    for bytes in files {
        let name = String::from_utf8_lossy(&bytes).into_owned();
        let mut result = None;
        let peak = thread_peak(|| result = Some(model::from_bytes("x.stl", bytes)));
        assert!(result.unwrap().is_err(), "{name}");
        // The parser of PLY files begins lists with room for 65,536 numbers.
        assert!(peak < 1 << 20, "{peak} bytes for {name}");
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
