//! Lattices of given cells: corners, links, components, bridges.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::Point3;
use proptest::prelude::*;
use supple::{Lattice, LatticeError};
use supple_tests::{block, block_at};

fn lattice(cells: &[[i32; 3]], join: bool) -> Lattice {
    Lattice::from_cells(cells, 1.0, Point3::origin(), join).expect("cells make a lattice")
}

fn zyx(&[x, y, z]: &[i32; 3]) -> (i32, i32, i32) {
    (z, y, x)
}

/// Asserts that a lattice agrees with the definitions of vertices, links, corners and components.
fn check(lattice: &Lattice) {
    let cells: BTreeSet<[i32; 3]> = lattice.cells().iter().copied().collect();
    assert!(lattice.cells().is_sorted_by_key(zyx) && cells.len() == lattice.cells().len());
    let corner = |[x, y, z]: [i32; 3], k: i32| [x + (k & 1), y + (k >> 1 & 1), z + (k >> 2 & 1)];
    let mut occupied: BTreeMap<(i32, i32, i32), u8> = BTreeMap::new();
    let mut links = BTreeSet::new();
    for &cell in &cells {
        for k in 0..8 {
            *occupied.entry(zyx(&corner(cell, k))).or_default() += 1;
            for axis in 0..3 {
                let (a, b) = (corner(cell, k), corner(cell, k ^ 1 << axis));
                links.insert((a, 2 * axis + usize::from(b[axis] > a[axis])));
            }
        }
    }
    assert_eq!(lattice.len(), occupied.len());
    assert!(lattice.indices().iter().map(zyx).eq(occupied.keys().copied()));
    assert!(lattice.occupied_cells().iter().eq(occupied.values()));
    for (v, &index) in lattice.indices().iter().enumerate() {
        assert_eq!(lattice.vertex_at(index), Some(v as u32));
        let neighbors = lattice.neighbors(v as u32);
        for (n, neighbor) in neighbors.iter().enumerate() {
            assert_eq!(links.contains(&(index, n)), lattice.links()[v] >> n & 1 == 1);
            let mut expected = index;
            expected[n / 2] += if n % 2 == 0 { -1 } else { 1 };
            assert_eq!(*neighbor, lattice.vertex_at(expected).filter(|_| links.contains(&(index, n))));
            if let Some(other) = neighbor {
                let of = &lattice.components().of_vertex;
                assert_eq!(of[v], of[*other as usize]);
            }
        }
    }
    for (c, &cell) in lattice.cells().iter().enumerate() {
        assert_eq!(lattice.cell_at(cell), Some(c as u32));
        let corners = lattice.cell_corners(c as u32);
        for (k, &v) in corners.iter().enumerate() {
            assert_eq!(lattice.indices()[v as usize], corner(cell, k as i32));
        }
    }
    assert_eq!(lattice.components().count, count_components(lattice));
}

/// Counts the connected components of the links by depth-first search.
fn count_components(lattice: &Lattice) -> usize {
    let mut seen = vec![false; lattice.len()];
    let mut count = 0;
    for start in 0..lattice.len() as u32 {
        let mut stack = vec![start];
        count += usize::from(!seen[start as usize]);
        while let Some(v) = stack.pop() {
            if !std::mem::replace(&mut seen[v as usize], true) {
                stack.extend(lattice.neighbors(v).into_iter().flatten());
            }
        }
    }
    count
}

#[test]
fn a_box_has_all_corners_links_and_occupied_cells() {
    for size in [[1, 1, 1], [3, 1, 2], [4, 5, 6]] {
        let lattice = lattice(&block_at([-2, 7, 0], size), true);
        check(&lattice);
        assert_eq!(lattice.len(), size.iter().map(|n| *n as usize + 1).product::<usize>());
        let mass: u32 = lattice.occupied_cells().iter().map(|&c| u32::from(c)).sum();
        assert_eq!(mass as i32, 8 * size.iter().product::<i32>());
    }
}

#[test]
fn rest_positions_follow_origin_and_cell_size() {
    let lattice =
        Lattice::from_cells(&[[3, 0, -1]], 0.25, Point3::new(1.0, 2.0, 3.0), true).expect("one cell");
    assert_eq!(lattice.rest_position(0), Point3::new(1.75, 2.0, 2.75));
    assert_eq!(lattice.rest_position(7), Point3::new(2.0, 2.25, 3.0));
    assert_eq!(
        (lattice.cell_size(), lattice.origin(), lattice.is_empty()),
        (0.25, Point3::new(1.0, 2.0, 3.0), false)
    );
}

#[test]
fn the_sides_of_a_gap_are_not_linked() {
    // A U: the arms are one empty cell apart, at y >= 1.
    let mut cells = block([3, 4, 1]);
    cells.retain(|c| c[0] != 1 || c[1] == 0);
    let u = lattice(&cells, true);
    check(&u);
    assert_eq!(u.components().count, 1);
    let [left, right] = [[1, 3, 0], [2, 3, 0]].map(|index| u.vertex_at(index).expect("on an arm"));
    assert_eq!(right, left + 1);
    assert_eq!((u.neighbors(left)[1], u.neighbors(right)[0]), (None, None));
}

#[test]
fn cells_that_share_a_corner_are_one_component() {
    assert_eq!(lattice(&[[0, 0, 0], [1, 1, 1]], false).components().count, 1);
    assert_eq!(lattice(&[[0, 0, 0], [1, -1, 1]], false).components().count, 1);
    assert_eq!(lattice(&[[0, 0, 0], [2, 0, 0]], false).components().count, 2);
}

#[test]
fn floating_parts_are_bridged_by_a_shortest_path() {
    let mut cells = block([4, 4, 4]);
    cells.extend([[6, 1, 1], [7, 1, 1], [1, 9, 2], [1, 9, 3]]);
    let apart = lattice(&cells, false);
    check(&apart);
    assert_eq!((apart.components().count, apart.report().bridge_cells), (3, 0));
    assert!(apart.report().floating.iter().all(|part| !part.joined && part.bridge_cells == 0));
    let joined = lattice(&cells, true);
    check(&joined);
    assert_eq!(joined.components().count, 1);
    assert_eq!((joined.report().surface_cells, joined.report().bridge_cells), (68, 2 + 5));
    for bridge in [[4, 1, 1], [5, 1, 1], [1, 4, 2], [1, 8, 2]] {
        assert!(joined.cell_at(bridge).is_some(), "{bridge:?}");
    }
    let floating: Vec<_> =
        joined.report().floating.iter().map(|p| (p.cells, p.joined, p.bridge_cells)).collect();
    assert_eq!(floating, [(2, true, 2), (2, true, 5)]);
}

#[test]
fn a_chain_of_parts_is_bridged_between_adjacent_parts() {
    let cells: Vec<_> = (0..20).map(|i| [3 * i, 0, 0]).collect();
    let joined = lattice(&cells, true);
    check(&joined);
    assert_eq!((joined.cells().len(), joined.components().count), (58, 1));
}

#[test]
fn a_lattice_is_independent_of_cell_order_and_repeated_cells() {
    let mut cells = block([3, 3, 3]);
    cells.extend(block_at([9, 5, -7], [2, 1, 1]));
    let expected = lattice(&cells, true);
    cells.reverse();
    cells.push([0, 0, 0]);
    assert_eq!(lattice(&cells, true), expected);
}

#[test]
fn invalid_arguments_are_errors_with_their_values() {
    let from = |cells: &[[i32; 3]], size, origin| Lattice::from_cells(cells, size, origin, true).map(|_| ());
    let origin = Point3::origin();
    for size in [0.0, -1.0, f64::INFINITY] {
        assert_eq!(from(&[[0; 3]], size, origin), Err(LatticeError::CellSize(size)));
    }
    assert!(matches!(from(&[[0; 3]], f64::NAN, origin), Err(LatticeError::CellSize(size)) if size.is_nan()));
    assert_eq!(from(&[], 1.0, origin), Err(LatticeError::NoCells));
    let nan_origin = from(&[[0; 3]], 1.0, Point3::new(0.0, f64::NAN, 2.0));
    assert!(matches!(nan_origin, Err(LatticeError::Origin(0.0, y, 2.0)) if y.is_nan()));
    let cells = [[0, 0, 0], [0, i32::MIN, 0]];
    assert_eq!(from(&cells, 1.0, origin), Err(LatticeError::IndexRange { cell: 1, index: i32::MIN }));
    // A bridge of six thousand million cells is an error before it is built. Without the bridge the lattice
    // is small.
    let far = [[-(1 << 30); 3], [1 << 30; 3]];
    assert!(matches!(from(&far, 1.0, origin), Err(LatticeError::TooMuchMemory { .. })));
    check(&lattice(&far, false));
}

#[test]
fn a_lattice_holds_at_most_forty_bytes_per_vertex() {
    let solid = lattice(&block([40, 40, 40]), true);
    assert!(solid.memory() <= 32 * solid.len(), "{}", solid.memory());
    let sheet = lattice(&block([60, 60, 1]), true);
    assert!(sheet.memory() <= 40 * sheet.len(), "{}", sheet.memory());
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn lattices_of_random_cells_agree_with_the_definitions(cells in prop::collection::vec([-4..5, -4..5, -4..5], 1..60)) {
        let apart = lattice(&cells, false);
        check(&apart);
        let joined = lattice(&cells, true);
        check(&joined);
        prop_assert_eq!(joined.components().count, 1);
        prop_assert_eq!(apart.components().count, apart.report().floating.len() + 1);
        prop_assert_eq!(joined.cells().len(), joined.report().surface_cells + joined.report().bridge_cells);
    }
}
