//! Resolution of a lattice: cell sizes, requested vertex counts, memory limits, reports of floating and glued
//! parts.

use supple::{Lattice, LatticeError, LatticeOptions, Mesh, Resolution};
use supple_tests::{example, mesh_of, plain_box};

fn read(name: &str) -> Mesh {
    supple_io::obj::read(example(name)).expect("an example mesh")
}

/// Returns a box with corners at the origin and at `high`.
fn corner_box(high: [f64; 3]) -> Mesh {
    mesh_of(plain_box([0.0; 3], high))
}

fn build(mesh: &Mesh, resolution: Resolution, memory_limit: Option<u64>) -> Result<Lattice, LatticeError> {
    Lattice::from_mesh(mesh, &LatticeOptions { resolution, join: true, memory_limit })
}

#[test]
fn the_requested_vertex_count_is_met_within_five_percent() {
    for name in ["bust.obj", "bust_parts.obj"] {
        let mesh = read(name);
        for requested in [200, 300, 500, 700, 1000, 1500, 2000, 3000, 5000, 10000, 20000, 100000] {
            let lattice = build(&mesh, Resolution::Vertices(requested), None).expect("a lattice");
            let ratio = lattice.len() as f64 / requested as f64;
            assert!((ratio - 1.0).abs() <= 0.05, "{name}: {} of {requested}", lattice.len());
        }
    }
}

#[test]
fn the_cell_size_found_for_a_vertex_count_gives_the_same_lattice() {
    let mesh = read("bust.obj");
    let found = build(&mesh, Resolution::Vertices(1000), None).expect("a lattice");
    assert_eq!(build(&mesh, Resolution::Vertices(1000), None).as_ref(), Ok(&found));
    assert_eq!(build(&mesh, Resolution::CellSize(found.cell_size()), None), Ok(found));
}

#[test]
fn the_nearest_possible_vertex_count_is_used_for_a_cube() {
    let cube = corner_box([1.0; 3]);
    for (requested, expected) in [(8, 8), (30, 27), (100, 125), (1000, 1000), (1030, 1000)] {
        assert_eq!(build(&cube, Resolution::Vertices(requested), None).expect("a lattice").len(), expected);
    }
    for (high, requested) in
        [([1.0, 1e-9, 1e-9], 4000), ([1e-3, 1e-3, 1e-12], 5000), ([1e9, 3e8, 2e8], 30000)]
    {
        let lattice = build(&corner_box(high), Resolution::Vertices(requested), None).expect("a lattice");
        assert!(
            (lattice.len() as f64 / requested as f64 - 1.0).abs() <= 0.05,
            "{high:?}: {} of {requested}",
            lattice.len()
        );
    }
}

/// Cells that reach out of a box would make its sides stiffer than their material.
#[test]
fn the_cells_fill_a_box_along_one_axis_at_least() {
    for (high, requested) in
        [([1.0; 3], 1000), ([1.0; 3], 4000), ([0.25, 0.25, 1.0], 2000), ([3.0, 2.0, 0.7], 1500)]
    {
        let mesh = corner_box(high);
        let lattice = build(&mesh, Resolution::Vertices(requested), None).expect("a lattice");
        let cells = high.map(|extent| extent / lattice.cell_size());
        let full = cells.map(|cells| (cells - cells.round()).abs() < 1e-9);
        assert!(full.contains(&true), "{high:?}: {cells:?} cells");
        assert!(high != [1.0; 3] || full == [true; 3], "{cells:?} cells");
        assert_eq!(
            lattice.len(),
            cells.map(|cells| (cells - 1e-9).ceil() as usize + 1).iter().product::<usize>()
        );
    }
}

#[test]
fn the_requested_vertex_count_is_met_for_surfaces_without_area_or_with_distant_parts() {
    // All triangles are lines, so that the estimate from volume and area is for a single line. The coordinates are
    // multiples of an irrational number, which have no order.
    let coordinate = |i: usize| (i as f64 * 0.618_033_988_749_894_8).fract();
    let point = |i: usize| [3 * i, 3 * i + 1, 3 * i + 2].map(coordinate);
    let lines: Vec<[[f64; 3]; 3]> =
        (0..300).map(|i| [point(2 * i), point(2 * i + 1), point(2 * i + 1)]).collect();
    let distant = [[0.0; 3], [1e6, 3e5, 7e5]].map(|corner| {
        let [x, y, z] = corner;
        [[x, y, z], [x + 1.0, y, z], [x, y + 1.0, z + 1.0]]
    });
    for (name, triangles, requested) in [
        ("lines", lines.clone(), 20_000),
        ("lines", lines, 300_000),
        ("distant triangles", distant.to_vec(), 20_000),
        ("distant triangles", distant.to_vec(), 300_000),
    ] {
        // A small offset, because a mesh needs a face with three distinct corners.
        let vertices = triangles.iter().flatten().enumerate();
        let vertices: Vec<[f64; 3]> = vertices.map(|(i, [x, y, z])| [x + 1e-12 * i as f64, *y, *z]).collect();
        let faces: Vec<[u32; 3]> =
            (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let mesh = Mesh::new(vertices, &faces).expect("a mesh");
        let lattice = build(&mesh, Resolution::Vertices(requested), None).expect("a lattice");
        let ratio = lattice.len() as f64 / requested as f64;
        assert!((ratio - 1.0).abs() <= 0.05, "{name}: {} of {requested}", lattice.len());
    }
}

#[test]
fn invalid_resolutions_are_errors_with_their_value() {
    let cube = corner_box([1.0; 3]);
    for size in [0.0, -0.5, f64::INFINITY] {
        assert_eq!(build(&cube, Resolution::CellSize(size), None), Err(LatticeError::CellSize(size)));
    }
    assert!(matches!(build(&cube, Resolution::CellSize(f64::NAN), None), Err(LatticeError::CellSize(_))));
    for requested in [0, 7] {
        assert_eq!(
            build(&cube, Resolution::Vertices(requested), None),
            Err(LatticeError::TooFewVertices(requested))
        );
    }
}

#[test]
fn too_much_memory_is_an_error_with_a_cell_size_that_fits() {
    let meshes =
        [read("bust.obj"), corner_box([1.0; 3]), corner_box([1.0, 0.0, 0.7]), corner_box([1e12, 1.0, 1.0])];
    for mesh in &meshes {
        for limit in [1 << 20, 64 << 20] {
            for resolution in [1e-300, 1e-30, 1e-5, 1e-3]
                .map(Resolution::CellSize)
                .into_iter()
                .chain([1_000_000, usize::MAX].map(Resolution::Vertices))
            {
                let error = build(mesh, resolution, Some(limit)).expect_err("too much");
                let LatticeError::TooMuchMemory { needed, limit: reported, fitting, .. } = &error else {
                    panic!("{error}")
                };
                assert!(*needed > limit && *reported == limit);
                let fitting = fitting.expect("a cell size that fits");
                assert!(error.to_string().contains(&format!("{fitting:.4e}")));
                let printed: f64 = format!("{fitting:.4e}").parse().expect("a number");
                let lattice = build(mesh, Resolution::CellSize(printed), Some(limit)).expect("it fits");
                // Regression bound: the suggested cell size is not needlessly coarse.
                assert!(
                    lattice.len() as u64 * 250 > limit / 64,
                    "{} vertices in {limit} bytes",
                    lattice.len()
                );
            }
        }
    }
    let error = build(&meshes[1], Resolution::CellSize(1.0), Some(1000)).expect_err("one cell does not fit");
    assert!(matches!(error, LatticeError::TooMuchMemory { fitting: None, .. }), "{error}");
    let default = build(&meshes[1], Resolution::CellSize(1e-30), None).expect_err("too much");
    assert!(matches!(default, LatticeError::TooMuchMemory { fitting: Some(_), .. }));
}

#[test]
fn floating_and_touching_parts_are_reported() {
    // A block, a cube that floats beside it, a box that touches the block one cell from the cube, a cube
    // inside the block.
    let boxes = [
        ([0.0, 0.0, 0.0], [6.0, 6.0, 6.0]),
        ([8.0, 2.0, 2.0], [9.0, 3.0, 3.0]),
        ([6.0, 2.0, 2.0], [6.5, 4.0, 4.0]),
        ([2.0, 2.0, 2.0], [4.0, 4.0, 4.0]),
    ];
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for (low, high) in boxes {
        let first = vertices.len() as u32;
        let span: [f64; 3] = std::array::from_fn(|a| high[a] - low[a]);
        vertices.extend(corner_box(span).vertices().iter().map(|p| std::array::from_fn(|a| p[a] + low[a])));
        faces.extend(corner_box(span).faces().map(|face| face.iter().map(|v| v + first).collect::<Vec<_>>()));
    }
    let mesh = Mesh::new(vertices, &faces).expect("four boxes");
    for join in [true, false] {
        let options = LatticeOptions { resolution: Resolution::CellSize(1.0), join, memory_limit: None };
        let lattice = Lattice::from_mesh(&mesh, &options).expect("a lattice");
        let bridge = if join { 1 } else { 0 };
        let [part] = &lattice.report().floating[..] else { panic!("one part floats") };
        assert_eq!((part.cells, part.joined, part.bridge_cells), (1, join, bridge));
        assert_eq!(part.mesh_components, [1]);
        assert_eq!(lattice.report().glued, [[0, 2, 3]]);
        assert_eq!(lattice.report().bridge_cells, bridge);
        assert_eq!(lattice.components().count, if join { 1 } else { 2 });
        assert_eq!(lattice.cells().len(), 216 + 4 + 1 + bridge);
    }
}

#[test]
fn all_parts_of_the_bust_are_in_one_lattice_component() {
    let mesh = read("bust_parts.obj");
    for requested in [200, 1000, 20000, 200000] {
        let lattice = build(&mesh, Resolution::Vertices(requested), None).expect("a lattice");
        assert_eq!(lattice.components().count, 1);
        let report = lattice.report();
        assert!(!report.shell);
        // Eyes, teeth and tongue touch the skin or lie inside it, where all cells are filled.
        assert_eq!(report.glued, [[0, 1, 2, 3, 4, 5]]);
        assert!(report.floating.is_empty() && report.bridge_cells == 0, "{report:?}");
    }
}
