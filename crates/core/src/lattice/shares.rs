//! The share of each cell that the mesh fills.

use nalgebra::{Point3, Vector3};

use super::Lattice;
use crate::mesh::{Mesh, OpenSurface, WindingTree};
use crate::simd::vector::cross;
use crate::voxel::entered_cells;

/// Least share of an occupied cell. Cells that the surface only touches and cells of bridges have it, so that every
/// vertex has a mass.
const LEAST_SHARE: f64 = 0.05;

/// Numbers of sample lines along x per edge of a cell, the finest first. [`MAX_TESTS`] decides which one is used.
const LINES_PER_CELL: [i32; 4] = [8, 4, 2, 1];

/// Difference of the winding number at the center of a cell from 1/2 from which on the whole cell is on one side.
const CLEAR: f64 = 0.35;

/// Number of points along each axis in a cell at an opening.
const OPENING_POINTS: i32 = 4;

/// Greatest number of pairs of a triangle and a line in its bounding box for which a finer sampling is used.
const MAX_TESTS: f64 = 3e7;

/// Greatest number of solid angles for which a finer sampling of a mesh with openings is used: about two seconds.
const MAX_ANGLES: f64 = 1e8;

/// Number of cells after which the number of solid angles of a point is checked.
const COST_SAMPLES: usize = 16;

/// Returns the filled share of each cell, from [`LEAST_SHARE`] to 1; `None` if all are 1, of a bare lattice (`mesh` is
/// `None`) and of a [sheet](Interior::Sheet).
///
/// For a closed mesh the share is the mean over the cell of the winding number of the mesh. The mean is exact along x
/// and sampled along y and z. For a mesh with openings it is the share of the cell where the winding number exceeds
/// 1/2, and 1 in cells that sheets enter.
pub(super) fn shares(lattice: &Lattice, mesh: Option<&Mesh>) -> Option<Vec<f64>> {
    let mesh = mesh?;
    match mesh.open_surface() {
        None => Some(filled_shares(lattice, mesh)),
        Some(OpenSurface { solid: None, .. }) => None,
        Some(OpenSurface { solid: Some(solid), sheets }) => {
            let mut shares = enclosed_shares(lattice, mesh, solid);
            let entered = entered(lattice, mesh, sheets);
            shares
                .iter_mut()
                .zip(entered)
                .filter(|(_, is_entered)| *is_entered)
                .for_each(|(share, _)| *share = 1.0);
            Some(shares)
        }
    }
}

/// Returns the position of each vertex in cells from the origin of the lattice. Welded vertices have the same
/// position, so that no line passes between the triangles at a seam.
fn cell_positions(lattice: &Lattice, mesh: &Mesh) -> Vec<[f64; 3]> {
    let to_cells = |p: &Point3<f64>| <[f64; 3]>::from((p - lattice.origin) / lattice.cell_size);
    mesh.weld().iter().map(|&vertex| to_cells(&mesh.vertices()[vertex as usize])).collect()
}

/// Returns whether triangles enter each cell.
fn entered(lattice: &Lattice, mesh: &Mesh, triangles: &[[u32; 3]]) -> Vec<bool> {
    let positions = cell_positions(lattice, mesh);
    let corners = |triangle: &[u32; 3]| triangle.map(|v| positions[v as usize].map(|x| x.max(0.0)));
    let mut is_entered = vec![false; lattice.cells.len()];
    for cell in entered_cells(triangles.iter().map(corners)).positions() {
        lattice.cell_set.find(cell).into_iter().for_each(|cell| is_entered[cell as usize] = true);
    }
    is_entered
}

/// Returns the greatest number of lines per edge of a cell with which few enough solid angles are computed. Each line
/// has a point in each cell that the surface enters.
fn affordable_lines(lattice: &Lattice, solid: &WindingTree, is_entered: &[bool]) -> i32 {
    let entered: Vec<_> =
        lattice.cells.iter().zip(is_entered).filter(|(_, is_entered)| **is_entered).collect();
    let sample = |k: usize| {
        let cell = Vector3::from(entered[k * entered.len() / COST_SAMPLES].0.map(f64::from));
        solid.cost(&(lattice.origin + cell * lattice.cell_size)) as f64
    };
    if entered.is_empty() {
        return LINES_PER_CELL[0];
    }
    let cost = (0..COST_SAMPLES).map(sample).sum::<f64>() / COST_SAMPLES as f64 * entered.len() as f64;
    let is_affordable = |lines: &i32| cost * f64::from(lines * lines) <= MAX_ANGLES;
    LINES_PER_CELL.into_iter().find(is_affordable).unwrap_or(1)
}

/// Calls `visit` with each crossing of a sample line and the surface: the line, as indices along y and z, the x in
/// cells, and the change of the winding number along the line. Returns the number of lines per edge of a cell, at
/// most `most`.
fn visit_crossings(
    lattice: &Lattice,
    mesh: &Mesh,
    most: i32,
    mut visit: impl FnMut(i32, [i32; 2], f64, i32),
) -> i32 {
    let positions = cell_positions(lattice, mesh);
    let triangles = || mesh.surface().iter().map(|corners| corners.map(|corner| positions[corner as usize]));
    let tests = |lines: i32| triangles().map(|corners| Lines::of(&corners, lines).count()).sum::<f64>();
    let coarsest = LINES_PER_CELL[LINES_PER_CELL.len() - 1];
    let is_fast = |&lines: &i32| lines <= most && tests(lines) <= MAX_TESTS;
    let lines = LINES_PER_CELL.into_iter().find(is_fast).unwrap_or(coarsest);
    for corners in triangles() {
        let range = Lines::of(&corners, lines);
        for line_z in range.first[1]..=range.last[1] {
            for line_y in range.first[0]..=range.last[0] {
                let [y, z] = position_of_line([line_y, line_z], lines);
                let crossing = crossing(&corners, [y, z]);
                if crossing != 0 {
                    visit(lines, [line_y, line_z], x_at(&corners, [y, z]), crossing);
                }
            }
        }
    }
    lines
}

/// Returns the filled share of each cell of a closed mesh.
fn filled_shares(lattice: &Lattice, mesh: &Mesh) -> Vec<f64> {
    let mut sums = WindingSums::new(lattice);
    let lines = visit_crossings(lattice, mesh, LINES_PER_CELL[0], |lines, [y, z], x, crossing| {
        sums.add((z.div_euclid(lines), y.div_euclid(lines)), x, f64::from(crossing));
    });
    let lines_of_cell = f64::from(lines * lines);
    sums.finish(lattice).into_iter().map(|sum| (sum.abs() / lines_of_cell).clamp(LEAST_SHARE, 1.0)).collect()
}

/// Returns the share of each cell that a mesh with openings encloses.
///
/// A line changes sides at its crossings with the surface. In cells that the surface does not enter the center
/// decides, and in those at an opening points in a grid, because there the side changes within the cell.
fn enclosed_shares(lattice: &Lattice, mesh: &Mesh, solid: &WindingTree) -> Vec<f64> {
    // The cell, the line in it, and the x from the cell.
    let mut crossings: Vec<(u32, [i32; 2], f64)> = Vec::new();
    let is_entered = entered(lattice, mesh, mesh.surface());
    let most = affordable_lines(lattice, solid, &is_entered);
    let lines = visit_crossings(lattice, mesh, most, |lines, [y, z], x, _| {
        let index = x.floor() as i32;
        if let Some(cell) = lattice.cell_set.find([index, y.div_euclid(lines), z.div_euclid(lines)]) {
            crossings.push((cell, [y.rem_euclid(lines), z.rem_euclid(lines)], x - f64::from(index)));
        }
    });
    crossings.sort_unstable_by(|a, b| (a.0, a.1).cmp(&(b.0, b.1)).then(a.2.total_cmp(&b.2)));
    let point = |cell: [i32; 3], local: [f64; 3]| {
        let offset: [f64; 3] = std::array::from_fn(|a| f64::from(cell[a]) + local[a]);
        lattice.origin + Vector3::from(offset) * lattice.cell_size
    };
    let mut groups = crossings.chunk_by(|a, b| a.0 == b.0).peekable();
    let share = |(number, &cell): (u32, &[i32; 3])| {
        let crossings = groups.next_if(|group| group[0].0 == number).unwrap_or_default();
        if !is_entered[number as usize] && crossings.is_empty() {
            let winding = solid.number(&point(cell, [0.5; 3]), None).abs();
            if (winding - 0.5).abs() > CLEAR {
                return f64::from(winding > 0.5);
            }
            let grid = (0..OPENING_POINTS.pow(3)).filter(|k| {
                let local = [1, OPENING_POINTS, OPENING_POINTS.pow(2)]
                    .map(|step| (f64::from(k / step % OPENING_POINTS) + 0.5) / f64::from(OPENING_POINTS));
                solid.encloses(&point(cell, local))
            });
            return grid.count() as f64 / f64::from(OPENING_POINTS.pow(3));
        }
        let mut sum = 0.0;
        for line_z in 0..lines {
            for line_y in 0..lines {
                let own = crossings.iter().filter(|crossing| crossing.1 == [line_y, line_z]);
                let [y, z] = position_of_line([line_y, line_z], lines);
                let mut start = 0.0;
                for end in own.map(|crossing| crossing.2).chain([1.0]) {
                    let middle = [0.5 * (start + end), y, z];
                    if end > start && solid.encloses(&point(cell, middle)) {
                        sum += end - start;
                    }
                    start = end;
                }
            }
        }
        sum / f64::from(lines * lines)
    };
    let shares: Vec<f64> = (0..).zip(&lattice.cells).map(share).collect();
    shares.into_iter().map(|share| share.clamp(LEAST_SHARE, 1.0)).collect()
}

/// The sample lines along x in the bounding box of a triangle: indices along y and along z, inclusive.
struct Lines {
    first: [i32; 2],
    last: [i32; 2],
}

impl Lines {
    fn of(corners: &[[f64; 3]; 3], lines: i32) -> Self {
        let [a, b, c] = corners;
        let index = |coordinate: f64| (coordinate * f64::from(lines)).floor() as i32;
        Self {
            first: [1, 2].map(|k| index(a[k].min(b[k]).min(c[k]))),
            last: [1, 2].map(|k| index(a[k].max(b[k]).max(c[k]))),
        }
    }

    fn count(&self) -> f64 {
        let [y, z] = [0, 1].map(|k| f64::from(self.last[k]) - f64::from(self.first[k]) + 1.0);
        y.max(0.0) * z.max(0.0)
    }
}

/// Returns the coordinates of a sample line along y and z, in cells. No line lies on a face between cells, where
/// meshes like to have faces.
///
/// Each line is in a square of its own, so that the n lines of a cell with the same index along z have n different y.
/// Their place in the square depends on the index along z: all lines of the cell together resolve n^2/2 levels of y,
/// and likewise of z. The lines of a cell are their own mirror images.
fn position_of_line(line: [i32; 2], lines: i32) -> [f64; 2] {
    let place = |own: i32, other: i32| {
        let distinct = (lines / 2).max(1);
        let step = (f64::from(other.min(lines - 1 - other)) + 0.5) / f64::from(distinct);
        if own < distinct { step } else { 1.0 - step }
    };
    let [y, z] = line.map(|line| line.rem_euclid(lines));
    let [place_y, place_z] = if lines == 1 { [0.5; 2] } else { [place(y, z), place(z, y)] };
    [(f64::from(line[0]) + place_y) / f64::from(lines), (f64::from(line[1]) + place_z) / f64::from(lines)]
}

/// Returns the change of the winding number where a line along x crosses a triangle: 1 if the line enters the mesh, -1
/// if it leaves the mesh, 0 if it does not cross the triangle.
///
/// It is the winding number of the edges of the triangle around the line, seen along x: each edge counts that passes
/// above the line. An edge gives the same number with the opposite sign to the other triangle at this edge, so that the
/// changes along a line add up to exactly 0.
fn crossing(corners: &[[f64; 3]; 3], line: [f64; 2]) -> i32 {
    (0..3).map(|k| passes_above(corners[k], corners[(k + 1) % 3], line)).sum()
}

/// Returns 1 if an edge passes above the line towards larger y, -1 towards smaller y, and 0 if it does not.
fn passes_above(from: [f64; 3], to: [f64; 3], [y, z]: [f64; 2]) -> i32 {
    if (from[1] <= y) == (to[1] <= y) {
        return 0;
    }
    let (low, high, sign) = if from[1] <= y { (from, to, 1) } else { (to, from, -1) };
    let is_above = (high[1] - low[1]) * (z - low[2]) < (high[2] - low[2]) * (y - low[1]);
    if is_above { sign } else { 0 }
}

/// Returns the x at which a line along x crosses the plane of a triangle, within the range of the triangle.
fn x_at([a, b, c]: &[[f64; 3]; 3], [y, z]: [f64; 2]) -> f64 {
    let [u, v] = [b, c].map(|corner| [0, 1, 2].map(|k| corner[k] - a[k]));
    let normal = cross(u, v);
    let x = a[0] - (normal[1] * (y - a[1]) + normal[2] * (z - a[2])) / normal[0];
    let (low, high) = (a[0].min(b[0]).min(c[0]), a[0].max(b[0]).max(c[0]));
    if x.is_finite() { x.clamp(low, high) } else { 0.5 * (low + high) }
}

/// Integrals of the winding number over the cells, summed over the sample lines.
struct WindingSums<'a> {
    lattice: &'a Lattice,
    /// For each cell, the part of the crossings inside the cell.
    inside: Vec<f64>,
    /// For each cell, the change of the winding number for all later cells of the row.
    after: Vec<f64>,
}

impl<'a> WindingSums<'a> {
    fn new(lattice: &'a Lattice) -> Self {
        let cells = lattice.cells.len();
        Self { lattice, inside: vec![0.0; cells], after: vec![0.0; cells] }
    }

    /// Adds a change of the winding number at `x` on a line in the row (z, y) of cells.
    fn add(&mut self, row: (i32, i32), x: f64, change: f64) {
        let index = x.floor() as i32;
        let Some((cell, first)) = self.lattice.cell_set.find_from(row, index) else { return };
        let share = if first == index { f64::from(index) + 1.0 - x } else { 1.0 };
        self.inside[cell as usize] += change * share;
        self.after[cell as usize] += change;
    }

    /// Returns the integral over each cell.
    fn finish(mut self, lattice: &Lattice) -> Vec<f64> {
        let (mut row, mut winding) = (None, 0.0);
        for (cell, &[_, y, z]) in lattice.cells.iter().enumerate() {
            if row != Some((z, y)) {
                (row, winding) = (Some((z, y)), 0.0);
            }
            self.inside[cell] += winding;
            winding += self.after[cell];
        }
        self.inside
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::{LatticeOptions, Masses, Resolution};
    use crate::mesh::testing::cuboid;

    fn lattice_of(mesh: &Mesh, cell_size: f64) -> Lattice {
        let options =
            LatticeOptions { resolution: Resolution::CellSize(cell_size), ..LatticeOptions::default() };
        Lattice::from_mesh(mesh, &options).unwrap()
    }

    #[test]
    fn shares_of_a_box_are_the_products_of_its_overlaps_with_the_cells() {
        let mesh = cuboid([0.0; 3], [2.4, 1.7, 3.1]);
        let lattice = lattice_of(&mesh, 1.0);
        let shares = filled_shares(&lattice, &mesh);
        let overlap = |c: usize, index: i32| {
            let low = lattice.origin[c] + f64::from(index);
            (low + 1.0).min([2.4, 1.7, 3.1][c]) - low.max(0.0)
        };
        for (cell, share) in lattice.cells().iter().zip(&shares) {
            // Along x the share is exact. Along y and z the overlap is sampled at 32 levels, or 8 in cells that end
            // along both.
            let is_edge = (1..3).all(|c| overlap(c, cell[c]) < 1.0);
            let half = if is_edge { 1.0 / 16.0 } else { 1.0 / 64.0 };
            let sampled = |c: usize| (overlap(c, cell[c]) - half, overlap(c, cell[c]) + half);
            let ((y_low, y_high), (z_low, z_high)) = (sampled(1), sampled(2));
            let x = overlap(0, cell[0]);
            let (low, high) = (x * y_low * z_low, x * y_high * z_high);
            assert!(
                (low.max(LEAST_SHARE) - 1e-9..=high.clamp(LEAST_SHARE, 1.0) + 1e-9).contains(share),
                "{cell:?}: {share}"
            );
        }
    }

    #[test]
    fn lines_of_a_cell_are_their_own_mirror_images_and_resolve_many_levels() {
        for lines in LINES_PER_CELL {
            let all = (0..lines).flat_map(|y| (0..lines).map(move |z| [y, z]));
            let positions: Vec<[f64; 2]> = all.map(|line| position_of_line(line, lines)).collect();
            let has =
                |p: [f64; 2]| positions.iter().any(|q| (q[0] - p[0]).abs() + (q[1] - p[1]).abs() < 1e-12);
            assert!(positions.iter().all(|&[y, z]| has([1.0 - y, z]) && has([y, 1.0 - z]) && has([z, y])));
            let mut levels: Vec<f64> = positions.iter().map(|p| p[0]).collect();
            levels.sort_by(f64::total_cmp);
            levels.dedup_by(|a, b| (*a - *b).abs() < 1e-12);
            let expected = (lines * lines / 2).max(1);
            assert_eq!(levels.len(), expected as usize);
            let at = |k: usize| (k as f64 + 0.5) / f64::from(expected);
            assert!(levels.iter().enumerate().all(|(k, level)| (level - at(k)).abs() < 1e-12), "{levels:?}");
        }
    }

    #[test]
    fn aligned_boxes_are_full_and_the_orientation_of_the_mesh_does_not_matter() {
        let mesh = cuboid([0.0; 3], [3.0, 2.0, 4.0]);
        let lattice = lattice_of(&mesh, 1.0);
        let occupied = Masses::new(&lattice, None);
        assert_eq!(Masses::new(&lattice, Some(&mesh)), occupied);
        let faces: Vec<Vec<u32>> = mesh.faces().map(|face| face.iter().rev().copied().collect()).collect();
        let flipped = Mesh::new(mesh.vertices().iter().map(|&v| v.into()).collect(), &faces).unwrap();
        assert_eq!(Masses::new(&lattice, Some(&flipped)), occupied);
    }

    #[test]
    fn a_cavity_has_the_least_share() {
        let (outer, inner) = (cuboid([0.0; 3], [5.0; 3]), cuboid([1.0; 3], [4.0; 3]));
        let mut vertices: Vec<[f64; 3]> = outer.vertices().iter().map(|&v| v.into()).collect();
        vertices.extend(inner.vertices().iter().map(|&v| <[f64; 3]>::from(v)));
        let mut faces: Vec<Vec<u32>> = outer.faces().map(<[u32]>::to_vec).collect();
        faces.extend(inner.faces().map(|face| face.iter().rev().map(|v| v + 8).collect::<Vec<_>>()));
        let mesh = Mesh::new(vertices, &faces).unwrap();
        let lattice = lattice_of(&mesh, 1.0);
        for (cell, share) in lattice.cells().iter().zip(filled_shares(&lattice, &mesh)) {
            let center = lattice.origin + nalgebra::Vector3::from(cell.map(|i| f64::from(i) + 0.5));
            let is_cavity = center.iter().all(|&x| (1.0..4.0).contains(&x));
            assert_eq!(share, if is_cavity { LEAST_SHARE } else { 1.0 }, "{cell:?}");
        }
    }
}
