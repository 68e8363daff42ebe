//! The masses of the lattice vertices, by the share of each cell that the mesh fills.

use nalgebra::Point3;

use super::Lattice;
use crate::mesh::Mesh;

/// Least share of an occupied cell. Cells that the surface only touches and cells of bridges have it, so that every
/// vertex has a mass.
const LEAST_SHARE: f64 = 0.05;

/// Numbers of sample lines along x per edge of a cell, the finest first. [`MAX_TESTS`] decides which one is used.
const LINES_PER_CELL: [i32; 3] = [4, 2, 1];

/// Greatest number of pairs of a triangle and a line in its bounding box for which a finer sampling is used.
const MAX_TESTS: f64 = 3e7;

/// Computes the mass of each vertex in units of a full cell's mass, shape `(n,)`: an eighth of the filled shares of its
/// cells.
///
/// The share is 1 for a bare lattice (`mesh` is `None`) and for an open mesh. For a closed mesh it is the mean over the
/// cell of the winding number of the mesh, limited to the range from [`LEAST_SHARE`] to 1. The mean is exact along x
/// and sampled along y and z.
pub(crate) fn vertex_masses(lattice: &Lattice, mesh: Option<&Mesh>) -> Vec<f32> {
    let Some(mesh) = mesh.filter(|mesh| mesh.is_closed()) else {
        return lattice.occupied_cells.iter().map(|&cells| f32::from(cells) / 8.0).collect();
    };
    masses_of_shares(lattice, &filled_shares(lattice, mesh))
}

/// Returns the filled share of each cell, shape `(m,)`, rounded to multiples of [`SHARE_UNIT`]: see [`vertex_masses`].
/// The masses of vertices that break apart then have exactly the mass of the vertex before, in f32.
pub(crate) fn cell_shares(lattice: &Lattice, mesh: Option<&Mesh>) -> Vec<f64> {
    match mesh.filter(|mesh| mesh.is_closed()) {
        None => vec![1.0; lattice.cells.len()],
        Some(mesh) => filled_shares(lattice, mesh)
            .into_iter()
            .map(|share| (share / SHARE_UNIT).round() * SHARE_UNIT)
            .collect(),
    }
}

/// The unit of shares that break apart: an eighth of it is 2^-23, so that sums up to 1 are exact in f32.
const SHARE_UNIT: f64 = 1.0 / (1 << 20) as f64;

/// Computes the mass of each vertex from the filled share of each cell: see [`vertex_masses`].
pub(crate) fn masses_of_shares(lattice: &Lattice, shares: &[f64]) -> Vec<f32> {
    let mut masses = vec![0.0; lattice.len()];
    for (corners, share) in lattice.corner_table().iter().zip(shares) {
        for &corner in corners {
            masses[corner as usize] += share / 8.0;
        }
    }
    masses.into_iter().map(|mass| mass as f32).collect()
}

/// Returns the filled share of each cell.
fn filled_shares(lattice: &Lattice, mesh: &Mesh) -> Vec<f64> {
    let to_cells = |p: &Point3<f64>| <[f64; 3]>::from((p - lattice.origin) / lattice.cell_size);
    let positions: Vec<[f64; 3]> = mesh.vertices().iter().map(to_cells).collect();
    let triangles =
        || mesh.triangles().iter().map(|corners| corners.map(|corner| positions[corner as usize]));
    let tests = |lines: i32| triangles().map(|corners| Lines::of(&corners, lines).count()).sum::<f64>();
    let coarsest = LINES_PER_CELL[LINES_PER_CELL.len() - 1];
    let lines = LINES_PER_CELL.into_iter().find(|&lines| tests(lines) <= MAX_TESTS).unwrap_or(coarsest);

    let mut sums = WindingSums::new(lattice);
    for corners in triangles() {
        let range = Lines::of(&corners, lines);
        for line_z in range.first[1]..=range.last[1] {
            for line_y in range.first[0]..=range.last[0] {
                let [y, z] = [line_y, line_z].map(|line| position_of_line(line, lines));
                let crossing = crossing(&corners, [y, z]);
                if crossing != 0 {
                    let row = (line_z.div_euclid(lines), line_y.div_euclid(lines));
                    sums.add(row, x_at(&corners, [y, z]), f64::from(crossing));
                }
            }
        }
    }
    let lines_of_cell = f64::from(lines * lines);
    sums.finish(lattice).into_iter().map(|sum| (sum.abs() / lines_of_cell).clamp(LEAST_SHARE, 1.0)).collect()
}

/// The sample lines along x in the bounding box of a triangle: indices along y and along z, inclusive.
struct Lines {
    first: [i32; 2],
    last: [i32; 2],
}

impl Lines {
    fn of(corners: &[[f64; 3]; 3], lines: i32) -> Self {
        let [a, b, c] = corners;
        let index = |coordinate: f64| coordinate * f64::from(lines) - 0.5;
        Self {
            first: [1, 2].map(|k| index(a[k].min(b[k]).min(c[k])).ceil() as i32),
            last: [1, 2].map(|k| index(a[k].max(b[k]).max(c[k])).floor() as i32),
        }
    }

    fn count(&self) -> f64 {
        let [y, z] = [0, 1].map(|k| f64::from(self.last[k]) - f64::from(self.first[k]) + 1.0);
        y.max(0.0) * z.max(0.0)
    }
}

/// Returns the coordinate of a sample line, in cells. No line lies on a face between cells, where meshes like to have
/// faces.
fn position_of_line(line: i32, lines: i32) -> f64 {
    (f64::from(line) + 0.5) / f64::from(lines)
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
    let normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
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
    use crate::lattice::{LatticeOptions, Resolution};

    /// Returns a box with corners at `low` and `high`, with outward normals.
    fn cuboid(low: [f64; 3], high: [f64; 3]) -> Mesh {
        let corner = |k: usize| [0, 1, 2].map(|c| if k >> c & 1 == 0 { low[c] } else { high[c] });
        let faces = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        Mesh::new((0..8).map(corner).collect(), &faces).unwrap()
    }

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
            // Along x the share is exact. Along y and z the sampled overlap is within half a distance of two lines.
            let sampled = |c: usize| (overlap(c, cell[c]) - 0.125, overlap(c, cell[c]) + 0.125);
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
    fn aligned_boxes_are_full_and_the_orientation_of_the_mesh_does_not_matter() {
        let mesh = cuboid([0.0; 3], [3.0, 2.0, 4.0]);
        let lattice = lattice_of(&mesh, 1.0);
        let occupied = vertex_masses(&lattice, None);
        assert_eq!(vertex_masses(&lattice, Some(&mesh)), occupied);
        let faces: Vec<Vec<u32>> = mesh.faces().map(|face| face.iter().rev().copied().collect()).collect();
        let flipped = Mesh::new(mesh.vertices().iter().map(|&v| v.into()).collect(), &faces).unwrap();
        assert_eq!(vertex_masses(&lattice, Some(&flipped)), occupied);
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
