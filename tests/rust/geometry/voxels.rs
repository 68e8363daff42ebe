//! Voxelization: which cells a surface passes through or encloses.

use std::collections::BTreeSet;

use nalgebra::{Point3, Rotation3, Vector3};
use supple::Lattice;
use supple_tests::{grid_box, lattice_of, mesh_of};

type Faces = Vec<Vec<u32>>;
type Soup = (Vec<[f64; 3]>, Faces);

/// Returns the lattice of a mesh, without bridges between floating parts.
fn lattice(soup: &Soup, cell_size: f64) -> Lattice {
    lattice_of(&mesh_of(soup.clone()), cell_size, false)
}

fn joined((mut vertices, mut faces): Soup, (more_vertices, more_faces): Soup) -> Soup {
    let first = vertices.len() as u32;
    vertices.extend(more_vertices);
    faces.extend(more_faces.into_iter().map(|face| face.into_iter().map(|v| v + first).collect()));
    (vertices, faces)
}

fn cell_set(lattice: &Lattice) -> BTreeSet<[i32; 3]> {
    lattice.cells().iter().copied().collect()
}

/// Returns the faces unchanged, all reversed, every other one reversed, and each in both orientations.
fn orientations(faces: &Faces) -> [Faces; 4] {
    let reversed = |face: &Vec<u32>| face.iter().rev().copied().collect::<Vec<_>>();
    let all: Faces = faces.iter().map(reversed).collect();
    let some =
        faces.iter().enumerate().map(|(i, f)| if i % 2 == 0 { reversed(f) } else { f.clone() }).collect();
    let both = faces.iter().chain(&all).cloned().collect();
    [faces.clone(), all.clone(), some, both]
}

#[test]
fn a_cube_of_n_cells_is_filled_by_n_cubed_cells_at_any_offset_size_and_orientation() {
    for n in [1, 2, 3, 7, 10, 63, 64, 65] {
        for (cell_size, offset) in
            [(1.0, 0.0), (0.1, 0.0), (1.0 / 3.0, 0.7), (0.1, 12345.678), (1e-4, -3.3), (7e5, 1.0)]
        {
            let side = f64::from(n) * cell_size;
            let low = [offset, -2.0 * offset, 0.3 * offset];
            let (vertices, faces) = grid_box(low, low.map(|x| x + side), [3; 3]);
            for (i, faces) in orientations(&faces).into_iter().enumerate() {
                let lattice = lattice(&(vertices.clone(), faces), cell_size);
                assert_eq!(lattice.cells().len() as i32, n * n * n, "{n} cells of {cell_size} at {offset}");
                assert_eq!(lattice.len() as i32, (n + 1).pow(3));
                assert!(
                    !lattice.report().shell || i > 1,
                    "the seams may be open by rounding, but the cube is filled"
                );
                let corner = lattice.rest_position(0);
                assert!((0..3).all(|a| (corner[a] - low[a]).abs() < 1e-5 * cell_size));
            }
        }
    }
}

#[test]
fn repeated_faces_change_no_cell() {
    let (vertices, faces) = grid_box([0.1, 0.2, 0.3], [4.0, 5.5, 6.0], [2; 3]);
    let repeated: Faces = faces.iter().flat_map(|face| [face.clone(), face.clone()]).collect();
    let all_again: Faces = faces.iter().chain(&faces).cloned().collect();
    let expected = cell_set(&lattice(&(vertices.clone(), faces), 0.37));
    for faces in [repeated, all_again] {
        assert_eq!(cell_set(&lattice(&(vertices.clone(), faces), 0.37)), expected);
    }
}

#[test]
fn coordinates_rounded_to_six_decimals_lie_in_their_grid_planes() {
    let cell_size = 1.0 / 3.0;
    let high = [1.333333, 2.333333, 3.666667];
    let step =
        joined(grid_box([0.0; 3], high, [1; 3]), grid_box([0.0; 3], [4.666667, 0.666667, 0.333333], [1; 3]));
    assert_eq!(lattice(&step, cell_size).cells().len(), 4 * 7 * 11 + 10 * 2);
}

#[test]
fn the_grid_is_centered_on_a_box_of_fractional_size() {
    let lattice = lattice(&grid_box([0.0; 3], [2.5, 1.0, 0.2], [1; 3]), 1.0);
    assert_eq!(lattice.cells().len(), 3);
    assert!((lattice.origin() - Point3::new(-0.25, 0.0, -0.4)).norm() < 1e-15);
}

#[test]
fn a_slightly_tilted_box_has_no_leak() {
    for exponent in [-15, -12, -10, -9, -8, -7, -6, -5, -4, -3] {
        for n in [4, 40] {
            let (mut vertices, faces) = grid_box([0.0; 3], [f64::from(n); 3], [1; 3]);
            let tilt = Rotation3::new(Vector3::new(1.0, -0.6, 0.3) * 10f64.powi(exponent));
            vertices.iter_mut().for_each(|p| *p = (tilt * Vector3::from(*p)).into());
            let lattice = lattice(&(vertices, faces), 1.0);
            assert!(lattice.cells().len() as i32 >= n * n * n, "1e{exponent}: {}", lattice.cells().len());
            let report = lattice.report();
            assert!(report.filled_cells >= (n as usize - 2).pow(3), "1e{exponent}: {report:?}");
        }
    }
}

#[test]
fn a_long_slightly_sheared_bar_has_no_leak() {
    for slope in [6e-7, 8e-7] {
        let (mut vertices, faces) = grid_box([0.0; 3], [2000.0, 6.0, 6.0], [1; 3]);
        vertices.iter_mut().for_each(|p| p[1] += slope * p[0]);
        // Cubes above and below, so that the grid does not follow the tilt.
        let cubes = joined(
            grid_box([0.0, -2.0, 0.0], [1.0, -1.0, 1.0], [1; 3]),
            grid_box([0.0, 8.0, 0.0], [1.0, 9.0, 1.0], [1; 3]),
        );
        let lattice = lattice(&joined((vertices, faces), cubes), 1.0);
        assert!(lattice.cells().len() >= 2000 * 36 + 2, "{}", lattice.cells().len());
    }
}

/// Returns a flat sheet of 4 by 4 in the plane y = `height`, facing up.
fn sheet(height: f64) -> Soup {
    let corners = [[0.0, 0.0], [0.0, 4.0], [4.0, 4.0], [4.0, 0.0]];
    (corners.map(|[x, z]| [x, height, z]).to_vec(), vec![vec![0, 1, 2, 3]])
}

#[test]
fn a_sheet_has_one_layer_of_cells_on_its_inner_side() {
    for (i, faces) in orientations(&sheet(0.0).1).into_iter().enumerate() {
        let alone = lattice(&(sheet(0.3).0, faces.clone()), 1.0);
        assert_eq!((alone.cells().len(), alone.len()), (16, 50));
        // With two boxes around it, so that the sheet lies in a grid plane.
        let boxes =
            joined(grid_box([0.0; 3], [1.0; 3], [1; 3]), grid_box([3.0, 9.0, 3.0], [4.0, 10.0, 4.0], [1; 3]));
        let cells = cell_set(&lattice(&joined((sheet(5.0).0, faces), boxes), 1.0));
        assert_eq!(cells.len(), 16 + 2);
        // The inner side of a sheet that faces up is below it, of a reversed one above, of a two-sided one
        // below.
        let y = if i == 1 { 5 } else { 4 };
        assert_eq!(
            cells.iter().filter(|c| c[1] == y).count(),
            if i == 2 { 0 } else { 16 },
            "orientation {i}"
        );
    }
}

#[test]
fn a_sheet_at_the_edge_of_the_bounding_box_stays_within_it() {
    for height in [0.0, 10.0] {
        for faces in orientations(&sheet(0.0).1) {
            let posts = grid_box([0.0, 0.0, 0.0], [1.0, 10.0, 1.0], [1; 3]);
            let cells = cell_set(&lattice(&joined((sheet(height).0, faces), posts), 1.0));
            assert_eq!(cells.len(), 10 + 15, "at {height}");
        }
    }
}

#[test]
fn rods_and_needles_are_one_cell_thick() {
    assert_eq!(lattice(&grid_box([0.0; 3], [9.7, 0.01, 0.02], [1; 3]), 1.0).cells().len(), 10);
    let needle = (vec![[0.0; 3], [5.0, 0.0, 0.0], [9.7, 0.0, 0.0]], vec![vec![0, 1, 2]]);
    assert_eq!(lattice(&needle, 1.0).cells().len(), 10);
}

#[test]
fn a_box_without_two_opposite_faces_is_a_shell_and_one_without_a_face_is_filled() {
    let n: usize = 8;
    let (vertices, faces) = grid_box([0.0; 3], [n as f64; 3], [1; 3]);
    for faces in orientations(&faces[2..].to_vec()).into_iter().take(2) {
        let open = lattice(&(vertices.clone(), faces), 1.0);
        assert_eq!(open.cells().len(), n.pow(3) - (n - 2).pow(2) * n);
        assert!(open.report().shell && open.report().filled_cells == 0);
    }
    for faces in orientations(&faces[1..].to_vec()).into_iter().take(2) {
        let open = lattice(&(vertices.clone(), faces), 1.0);
        assert_eq!(open.cells().len(), n.pow(3));
        assert!(!open.report().shell);
    }
    let closed = lattice(&(vertices, faces), 1.0);
    assert!(!closed.report().shell);
    assert_eq!(
        (closed.report().surface_cells, closed.report().filled_cells),
        (n.pow(3) - (n - 2).pow(3), (n - 2).pow(3))
    );
}

#[test]
fn an_open_box_turned_inside_out_has_the_same_cells() {
    let (vertices, mut faces) = grid_box([2.0; 3], [8.0; 3], [1; 3]);
    faces.remove(0);
    // Other boxes beyond it on all sides, so that the grid does not end with the open box.
    let needle = grid_box([0.0, 0.0, 0.0], [10.0, 10.0, 0.5], [1; 3]);
    let far = grid_box([0.0, 0.0, 9.5], [0.5, 0.5, 10.0], [1; 3]);
    let (vertices, faces) = joined(joined((vertices, faces), needle), far);
    let [outwards, inwards, ..] =
        orientations(&faces).map(|faces| cell_set(&lattice(&(vertices.clone(), faces), 1.0)));
    assert_eq!(outwards, inwards);
    assert_eq!(outwards.len(), 100 + 1 + 6 * 6 * 6);
}

#[test]
fn two_arms_with_a_gap_of_one_cell_are_linked_only_through_their_foot() {
    let arms = joined(
        grid_box([0.0; 3], [2.0, 6.0, 2.0], [1; 3]),
        grid_box([3.0, 0.0, 0.0], [5.0, 6.0, 2.0], [1; 3]),
    );
    let u = joined(arms, grid_box([-1.0, -1.0, 0.0], [6.0, 0.0, 2.0], [1; 3]));
    let lattice = lattice(&u, 1.0);
    assert_eq!((lattice.cells().len(), lattice.components().count), (24 + 24 + 14, 1));
    assert_eq!(lattice.report().glued, [[0, 1, 2]]);
    let tip = lattice.vertex_at([3, 7, 0]).expect("the inner edge of the left arm");
    assert!(lattice.vertex_at([4, 7, 0]).is_some() && lattice.neighbors(tip)[1].is_none());
}

#[test]
fn a_cube_far_from_the_origin_is_filled_where_f64_is_coarser_than_the_cells() {
    // One ulp is 0.125 at 1e15 and 2 at 1e16. The corners of the cube are exact; the grid is relative to
    // them.
    for offset in [1e12, 1e15, -1e15, 1e16] {
        let (vertices, faces) = grid_box([offset; 3], [offset + 8.0; 3], [3; 3]);
        for (cell_size, n) in [(0.1, 80), (0.37, 22)] {
            let lattice = lattice(&(vertices.clone(), faces.clone()), cell_size);
            assert_eq!(lattice.cells().len(), n * n * n, "cells of {cell_size} at {offset}");
            assert_eq!(lattice.report().filled_cells, (n - 2).pow(3));
            let margin = (n as f64 * cell_size - 8.0) / 2.0;
            let error = lattice.origin().coords.add_scalar(margin - offset).amax();
            assert!(
                error <= offset.abs() * f64::EPSILON,
                "origin of cells of {cell_size} at {offset}: {error}"
            );
        }
    }
}

#[test]
fn the_space_between_nested_surfaces_and_the_inner_one_are_filled() {
    let hollow = joined(grid_box([0.0; 3], [9.0; 3], [1; 3]), grid_box([3.0; 3], [6.0; 3], [1; 3]));
    assert_eq!(lattice(&hollow, 1.0).cells().len(), 729);
}
