//! Random triangles: voxelization compared with clipping and flood fill, and triangles on grid planes.

use std::collections::BTreeSet;

use nalgebra::Point3;
use proptest::prelude::*;
use supple::internals::Embedding;
use supple::{Interior, Mesh};
use supple_tests::lattice_of;

/// Clips a polygon to a box.
fn clip(polygon: &[[f64; 3]], low: [f64; 3], high: [f64; 3]) -> Vec<[f64; 3]> {
    let mut polygon = polygon.to_vec();
    for (axis, sign) in (0..3).flat_map(|axis| [(axis, 1.0), (axis, -1.0)]) {
        let depth = |p: &[f64; 3]| if sign > 0.0 { p[axis] - low[axis] } else { high[axis] - p[axis] };
        let mut kept = Vec::new();
        for (i, a) in polygon.iter().enumerate() {
            let b = &polygon[(i + 1) % polygon.len()];
            let (da, db) = (depth(a), depth(b));
            if da >= 0.0 {
                kept.push(*a);
            }
            if da * db < 0.0 {
                kept.push(std::array::from_fn(|k| a[k] + (b[k] - a[k]) * da / (da - db)));
            }
        }
        polygon = kept;
    }
    polygon
}

/// Returns the cells that intersect a triangle after they are grown by a margin, or shrunk by a negative one.
fn cut_cells(triangles: &[[[f64; 3]; 3]], size: [i32; 3], margin: f64) -> BTreeSet<[i32; 3]> {
    let all =
        (0..size[0] * size[1] * size[2]).map(|i| [i % size[0], i / size[0] % size[1], i / size[0] / size[1]]);
    let cut = |cell: &[i32; 3]| {
        let (low, high) = (cell.map(|i| f64::from(i) - margin), cell.map(|i| f64::from(i + 1) + margin));
        triangles.iter().any(|triangle| !clip(triangle, low, high).is_empty())
    };
    all.filter(cut).collect()
}

/// Returns the cells that a flood fill from outside does not enter.
fn enclosed(walls: &BTreeSet<[i32; 3]>, size: [i32; 3]) -> BTreeSet<[i32; 3]> {
    let mut reached = BTreeSet::new();
    let mut stack = vec![[-1; 3]];
    while let Some(cell) = stack.pop() {
        let inside = (0..3).all(|a| (-1..=size[a]).contains(&cell[a]));
        if inside && !walls.contains(&cell) && reached.insert(cell) {
            for (axis, step) in (0..3).flat_map(|axis| [(axis, 1), (axis, -1)]) {
                let mut next = cell;
                next[axis] += step;
                stack.push(next);
            }
        }
    }
    let all =
        (0..size[0] * size[1] * size[2]).map(|i| [i % size[0], i / size[0] % size[1], i / size[0] / size[1]]);
    all.filter(|cell| !reached.contains(cell)).collect()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 128, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn the_cells_of_random_triangles_equal_those_of_clipping_and_flood_fill(
        corners in prop::collection::vec(prop::array::uniform3(-1.0..1.0f64), 3..40),
        stretch in prop::array::uniform3(0.05..1.0f64),
        fineness in 2.0..14.0f64,
    ) {
        let vertices: Vec<[f64; 3]> = corners.iter().map(|p| std::array::from_fn(|a| p[a] * stretch[a])).collect();
        let faces: Vec<Vec<u32>> = (0..vertices.len() as u32 / 3).map(|t| vec![3 * t, 3 * t + 1, 3 * t + 2]).collect();
        let cell_size = 1.0 / fineness;
        let mesh = Mesh::new(vertices, &faces).expect("a mesh");
        let lattice = lattice_of(&mesh, cell_size, false);
        let (low, high) = mesh.bounds();
        let size = std::array::from_fn(|a| ((high[a] - low[a]) / cell_size).ceil().max(1.0) as i32);
        let triangles: Vec<[[f64; 3]; 3]> = mesh.triangles().iter().map(|t| {
            t.map(|v| ((mesh.vertices()[v as usize] - lattice.origin()) / cell_size).into())
        }).collect();
        let walls = cut_cells(&triangles, size, 1e-5);
        prop_assume!(walls == cut_cells(&triangles, size, -1e-5));
        let cells: BTreeSet<[i32; 3]> = lattice.cells().iter().copied().collect();
        let report = lattice.report();
        prop_assert_eq!(cells.len(), report.surface_cells + report.filled_cells);
        let enclosed = enclosed(&walls, size);
        match mesh.interior() {
            // Triangles that stand around a space by chance: the winding number fills it too.
            Interior::WindingNumber => prop_assert!(cells.is_superset(&enclosed)),
            _ => prop_assert_eq!(cells, enclosed),
        }
    }

    #[test]
    fn triangles_near_grid_planes_lie_within_their_cells(
        corners in prop::collection::vec(prop::array::uniform3(0..5i32), 3..40),
        jitter in prop::array::uniform3(-3e-6..3e-6f64),
    ) {
        let vertices: Vec<[f64; 3]> = corners.iter().enumerate()
            .map(|(i, p)| std::array::from_fn(|a| f64::from(p[a]) + if (i + a) % 4 == 0 { jitter[a] } else { 0.0 }))
            .collect();
        let faces: Vec<Vec<u32>> = (0..vertices.len() as u32 / 3).map(|t| vec![3 * t, 3 * t + 1, 3 * t + 2]).collect();
        let Ok(mesh) = Mesh::new(vertices, &faces) else { return Ok(()) };
        let lattice = lattice_of(&mesh, 1.0, true);
        prop_assert_eq!(lattice.components().count, 1);
        let used: Vec<Point3<f64>> = mesh.triangles().iter().flatten().map(|&v| mesh.vertices()[v as usize]).collect();
        let embedding = Embedding::new(&lattice, &used);
        for (i, point) in used.iter().enumerate() {
            let corner = lattice.rest_position(embedding.corners(i)[0]);
            let local = point - corner;
            prop_assert!(local.iter().all(|x| (-1e-5..=1.0 + 1e-5).contains(x)), "{} is not in its cell: {}", point, local);
        }
    }
}
