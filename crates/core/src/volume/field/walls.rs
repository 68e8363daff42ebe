//! Computes walls: pieces of the boundary, assigned to lattice vertices.

use nalgebra::{Point3, Vector3};

use crate::lattice::{Lattice, Locator, trilinear_weights};
use crate::mesh::Mesh;
use crate::volume::adjacency::{Adjacency, Corners};
use crate::volume::surface::Surface;

/// Greatest size, in cells, of the pieces into which the surface is divided: the width and the height of a piece,
/// or the edges of a triangle that is not divided. Each piece has one sample, its centroid.
const SPACING: f64 = 0.5;

/// Maximum number of samples per lattice vertex, beyond one sample per triangle of the surface.
///
/// A plane through a cell has at most about 16 samples there, so only surfaces that overlap themselves many
/// times reach this number. Their samples are farther apart.
const MAX_SAMPLES: usize = 64;

/// Greatest alignment of a sheet.
///
/// The alignment of a surface in a component of the lattice is the mean over the surface of the cosine between its
/// normal and the outward direction of the boundary vertices around it, as a magnitude. A surface that bounds solid
/// cells has these directions, up to the steps of the lattice and the edges of the surface: the mean is nearly 1. A
/// sheet lies within a layer of cells, on whose two sides the directions are opposite: the mean is nearly 0. On open
/// meshes it is above 0.7 or below 0.01.
pub(super) const SHEET_ALIGNMENT: f64 = 0.3;

/// Piece of the boundary near a lattice vertex.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wall {
    /// Lattice vertex.
    pub(super) vertex: u32,
    /// Outward unit normal.
    pub(super) normal: Vector3<f64>,
    /// Area, in units of the area of a cell's face.
    pub(super) area: f64,
}

/// Sums of area vectors (area times unit normal) at the vertices of the boundary.
///
/// A vertex has six sums. An area vector is added to the sum of its direction: the axis of its largest
/// component, and the sign of this component.
struct AreaSums {
    /// Index in `sums` of each vertex; `u32::MAX` before the first area vector.
    rows: Vec<u32>,
    /// Vertices with area vectors, and their sums.
    sums: Vec<(u32, [Vector3<f64>; 6])>,
}

impl AreaSums {
    fn new(vertices: usize) -> Self {
        Self { rows: vec![u32::MAX; vertices], sums: Vec::new() }
    }

    /// Adds `weight` times an area vector at a vertex.
    fn add(&mut self, vertex: u32, area: &Vector3<f64>, weight: f64) {
        let Self { rows, sums } = self;
        let row = &mut rows[vertex as usize];
        if *row == u32::MAX {
            *row = sums.len() as u32;
            sums.push((vertex, [Vector3::zeros(); 6]));
        }
        let axis = area.iamax();
        sums[*row as usize].1[2 * axis + usize::from(area[axis] > 0.0)] += area * weight;
    }

    /// Returns one wall for each sum that is not zero. The walls of a vertex are consecutive.
    fn walls(&self) -> impl Iterator<Item = Wall> + '_ {
        let sums = self.sums.iter().flat_map(|(vertex, sums)| sums.iter().map(move |sum| (*vertex, sum)));
        sums.filter(|(_, sum)| **sum != Vector3::zeros()).map(|(vertex, sum)| {
            let area = sum.norm();
            Wall { vertex, normal: sum / area, area }
        })
    }
}

/// Returns the walls of the boundary faces of the cells. A quarter of the area of a face is assigned to each
/// of its corners.
pub(super) fn of_cells(lattice: &Lattice) -> Vec<Wall> {
    let mut sums = AreaSums::new(lattice.len());
    for (side, corners) in lattice.boundary_faces() {
        let mut normal = Vector3::zeros();
        normal[side / 2] = if side % 2 == 0 { -1.0 } else { 1.0 };
        corners.iter().for_each(|&corner| sums.add(corner, &normal, 0.25));
    }
    sums.walls().collect()
}

/// Returns the walls of a surface, assigned to the boundary vertices of the cells that contain it.
///
/// A component of the lattice gets the walls of its boundary faces if it contains no part of the surface, or if the
/// [alignment](SHEET_ALIGNMENT) of the surface in it is at most `least_alignment`.
///
/// * `outwards`: outward direction of each boundary vertex, zero for interior vertices. If the surface in a
///   component is oriented against these directions, its normals are reversed.
/// * `corners`: of the cells of the lattice.
pub(super) fn of_surface(
    (lattice, corners): (&Lattice, &Corners),
    surface: Surface<'_>,
    adjacency: &Adjacency,
    outwards: &[Vector3<f64>],
    least_alignment: f64,
) -> Vec<Wall> {
    let mut sums = AreaSums::new(lattice.len());
    let mut locator = Locator::new(lattice);
    let face = lattice.cell_size().powi(2);
    let sides =
        (!lattice.broken_joints().is_empty()).then_some(Sides { lattice, surface, adjacency, corners });
    let pieces = Pieces { mesh: surface.mesh, spacing: spacing(lattice, surface.mesh) };
    pieces.for_each(|triangle, centroid, area| {
        let (mut cell, mut local) = locator.locate(&centroid);
        if let Some(sides) = &sides {
            (cell, local) = sides.cell_of(triangle, &centroid, (cell, local));
        }
        let corners = corners.of_cell(cell);
        let corners = corners.into_iter().zip(trilinear_weights(local));
        for (corner, weight) in corners.filter(|(corner, _)| outwards[*corner as usize] != Vector3::zeros()) {
            sums.add(corner, &area, f64::from(weight.max(0.0)) / face);
        }
        true
    });
    // Sums over the walls of each component: positive if the surface is oriented outwards, and the area.
    let mut alignments = vec![0.0; adjacency.component_count];
    let mut areas = vec![0.0; adjacency.component_count];
    for wall in sums.walls() {
        let vertex = wall.vertex as usize;
        alignments[adjacency.component(vertex)] += wall.area * wall.normal.dot(&outwards[vertex]);
        areas[adjacency.component(vertex)] += wall.area;
    }
    for (alignment, area) in alignments.iter_mut().zip(areas) {
        if alignment.abs() <= least_alignment * area {
            *alignment = 0.0;
        }
    }
    let alignment = |wall: &Wall| alignments[adjacency.component(wall.vertex as usize)];
    let oriented = sums.walls().filter(|wall| alignment(wall) != 0.0);
    let oriented = oriented.map(|wall| Wall { normal: wall.normal * alignment(&wall).signum(), ..wall });
    let mut walls: Vec<Wall> = oriented.collect();
    if alignments.contains(&0.0) {
        walls.extend(of_cells(lattice).into_iter().filter(|wall| alignment(wall) == 0.0));
    }
    walls
}

/// The sides of the cracks of a lattice. Beside a crack, the surface of one side lies in cells of the other side.
struct Sides<'a> {
    lattice: &'a Lattice,
    surface: Surface<'a>,
    adjacency: &'a Adjacency,
    corners: &'a Corners<'a>,
}

impl Sides<'_> {
    /// Returns the cell that moves a point of a triangle, and the local coordinates of the point, or those of the
    /// point of the cell next to it. `located`: the same of the cell that contains the point.
    ///
    /// The located cell is on the other side of a crack if no corner of the triangle is in its component, or if it is
    /// beside the cell of the next corner and shares no vertex with it. Then the point moves with the cell of this
    /// corner.
    fn cell_of(&self, triangle: usize, point: &Point3<f64>, located: (u32, [f32; 3])) -> (u32, [f32; 3]) {
        let Self { lattice, surface, adjacency, corners } = self;
        let positions = surface.mesh.vertices();
        let triangle = surface.mesh.triangles()[triangle];
        let distance = |corner: u32| (positions[corner as usize] - point).norm_squared();
        let [a, b, c] = triangle;
        let nearest = [b, c].into_iter().fold(a, |a, b| if distance(b) < distance(a) { b } else { a });
        let host_of = |corner: u32| surface.embedding.cell(corner as usize);
        let component = |cell: u32| adjacency.component(corners.of_cell(cell)[0] as usize);
        let (cell, host) = (located.0, host_of(nearest));
        let [index, host_index] = [cell, host].map(|cell| lattice.cells()[cell as usize]);
        let is_beside = (0..3).all(|axis| index[axis].abs_diff(host_index[axis]) <= 1);
        let shares_vertex = || {
            let vertices = corners.of_cell(host);
            corners.of_cell(cell).iter().any(|vertex| vertices.contains(vertex))
        };
        let is_of_triangle = triangle.iter().any(|&corner| component(host_of(corner)) == component(cell));
        if is_of_triangle && (!is_beside || shares_vertex()) {
            return located;
        }
        let position = (point - lattice.origin()) / lattice.cell_size();
        let local = |axis: usize| (position[axis] - f64::from(host_index[axis])).clamp(0.0, 1.0) as f32;
        (host, std::array::from_fn(local))
    }
}

/// Returns the greatest size of the pieces of the surface: [`SPACING`], doubled until the number of pieces is
/// within [`MAX_SAMPLES`].
fn spacing(lattice: &Lattice, mesh: &Mesh) -> f64 {
    let limit = MAX_SAMPLES * lattice.len() + mesh.triangles().len();
    let mut spacing = SPACING * lattice.cell_size();
    loop {
        let mut count = 0;
        Pieces { mesh, spacing }.for_each(|_, _, _| {
            count += 1;
            count <= limit
        });
        if count <= limit {
            return spacing;
        }
        spacing *= 2.0;
    }
}

/// The triangles of a mesh, divided into pieces of a size of at most `spacing`.
struct Pieces<'a> {
    mesh: &'a Mesh,
    spacing: f64,
}

impl Pieces<'_> {
    /// Calls `visit` for each piece, with the index of its triangle, its centroid and its area vector, until `visit`
    /// returns false.
    fn for_each(&self, mut visit: impl FnMut(usize, Point3<f64>, Vector3<f64>) -> bool) {
        let vertices = self.mesh.vertices();
        for (triangle, corners) in self.mesh.triangles().iter().enumerate() {
            let corners = corners.map(|corner| vertices[corner as usize]);
            if !self.divide(corners, &mut |centroid, area| visit(triangle, centroid, area)) {
                return;
            }
        }
    }

    /// Calls `visit` for each piece of a triangle. Returns false if `visit` does.
    ///
    /// ```text
    ///            c
    ///         /|..|\ |         The triangle is cut into slabs perpendicular to its longest edge ab, and
    ///       /|..|..|.\|        each slab into layers of equal height. The number of pieces of a thin
    ///     /|..|..|..|..\       triangle is proportional to its length.
    ///   a --------------- b
    /// ```
    fn divide(
        &self,
        corners: [Point3<f64>; 3],
        visit: &mut impl FnMut(Point3<f64>, Vector3<f64>) -> bool,
    ) -> bool {
        let (u, v) = (corners[1] - corners[0], corners[2] - corners[0]);
        let area = u.cross(&v) * 0.5;
        if area == Vector3::zeros() {
            return true;
        }
        let lengths = [0, 1, 2].map(|k| (corners[(k + 1) % 3] - corners[k]).norm());
        let longest = (1..3).fold(0, |longest, k| if lengths[k] > lengths[longest] { k } else { longest });
        let length = lengths[longest];
        if length <= self.spacing {
            return visit(corners[0] + u / 3.0 + v / 3.0, area);
        }
        let [a, b, c] = [0, 1, 2].map(|k| corners[(longest + k) % 3]);
        let along = (b - a) / length;
        // The foot of the altitude of c divides ab in two. The altitude from it to c has the length `height`.
        let foot = (c - a).dot(&along).clamp(0.0, length);
        let altitude = (c - a) - along * foot;
        let height = altitude.norm();
        for (start, end, height_start, height_end) in [(0.0, foot, 0.0, 1.0), (foot, length, 1.0, 0.0)] {
            let slabs = ((end - start) / self.spacing).ceil();
            for slab in 0..slabs as usize {
                // Heights of both sides of the slab, in units of the altitude.
                let at = |k: usize| height_start + (height_end - height_start) * (k as f64 / slabs);
                let (h0, h1) = (at(slab), at(slab + 1));
                let width = (end - start) / slabs;
                // Integrals over the slab of h and h², and of the position times h.
                let (sum, squares) = (0.5 * (h0 + h1), (h0 * h0 + h0 * h1 + h1 * h1) / 3.0);
                let x = start + width * (slab as f64 + (h0 + 2.0 * h1) / (3.0 * (h0 + h1)));
                let layers = (h0.max(h1) * height / self.spacing).ceil().max(1.0);
                for layer in 0..layers as usize {
                    let y = squares / sum * (layer as f64 + 0.5) / layers;
                    // The area of the triangle is length / 2 in these units.
                    let piece = area * (sum * width / (0.5 * length * layers));
                    if !visit(a + along * x + altitude * y, piece) {
                        return false;
                    }
                }
            }
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Number of pieces of a triangle, the sum of their areas, and the mean of their centroids.
    fn pieces(corners: [[f64; 3]; 3], spacing: f64) -> (usize, f64, Vector3<f64>) {
        let mesh = Mesh::new(corners.to_vec(), &[vec![0, 1, 2]]).unwrap();
        let (mut count, mut area, mut mean) = (0, 0.0, Vector3::zeros());
        Pieces { mesh: &mesh, spacing }.for_each(|_, centroid, piece| {
            (count, area, mean) = (count + 1, area + piece.norm(), mean + centroid.coords * piece.norm());
            true
        });
        (count, area, mean / area)
    }

    #[test]
    fn pieces_have_the_area_and_the_centroid_of_the_triangle() {
        for corners in [
            [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            [[0.0; 3], [3.0, 0.1, 0.0], [2.0, 0.5, 1.0]],
            [[5.0, 0.0, 0.0], [5.0, 4.0, 0.0], [5.0, 1.0, 1e-3]],
        ] {
            let (whole, expected_area, expected_mean) = pieces(corners, 10.0);
            let (count, area, mean) = pieces(corners, 0.1);
            assert!(whole == 1 && count > 10, "{count}");
            assert!((area / expected_area - 1.0).abs() < 1e-12 && (mean - expected_mean).norm() < 1e-12);
        }
    }

    #[test]
    fn number_of_pieces_of_a_thin_triangle_is_proportional_to_its_length() {
        let sliver = |length: f64| pieces([[0.0; 3], [length, 0.0, 0.0], [0.5 * length, 1e-3, 0.0]], 0.5).0;
        assert_eq!(sliver(1024.0), 2048);
        assert_eq!(sliver(2048.0), 4096);
    }

    #[test]
    fn surface_that_overlaps_itself_has_a_limited_number_of_samples() {
        let cells: Vec<[i32; 3]> = (0..1000).map(|i| [i % 10, i / 10 % 10, i / 100]).collect();
        let lattice = Lattice::from_cells(&cells, 1.0, Point3::origin(), false).unwrap();
        let corners = [[0.0, 0.0, 5.0], [10.0, 0.0, 5.0], [0.0, 10.0, 5.0]];
        let mesh = |copies: u32| {
            let faces: Vec<Vec<u32>> = (0..copies).map(|_| vec![0, 1, 2]).collect();
            Mesh::new(corners.to_vec(), &faces).unwrap()
        };
        assert_eq!(spacing(&lattice, &mesh(1)), SPACING);
        let many = mesh(100_000);
        let coarse = spacing(&lattice, &many);
        let mut count = 0;
        Pieces { mesh: &many, spacing: coarse }.for_each(|_, _, _| {
            count += 1;
            true
        });
        assert!(coarse > SPACING && count <= MAX_SAMPLES * lattice.len() + 100_000, "{coarse} {count}");
    }
}
