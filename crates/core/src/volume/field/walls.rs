//! Computes walls: pieces of the boundary, assigned to lattice vertices.

use nalgebra::{Point3, Vector3};

use crate::lattice::{Embedding, Lattice};
use crate::volume::adjacency::{Adjacency, boundary_faces};
use crate::volume::surface::Surface;

/// Greatest distance between neighboring samples of a surface, in cells.
const SPACING: f64 = 0.5;

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

/// Sums of area vectors (area times unit normal) at each vertex.
///
/// A vertex has six sums. An area vector is added to the sum of its direction: the axis of its largest
/// component, and the sign of this component.
struct AreaSums(Vec<[Vector3<f64>; 6]>);

impl AreaSums {
    fn new(vertices: usize) -> Self {
        Self(vec![[Vector3::zeros(); 6]; vertices])
    }

    /// Adds `weight` times an area vector at a vertex.
    fn add(&mut self, vertex: u32, area: &Vector3<f64>, weight: f64) {
        let axis = area.iamax();
        self.0[vertex as usize][2 * axis + usize::from(area[axis] > 0.0)] += area * weight;
    }

    /// Returns one wall for each sum that is not zero.
    fn walls(&self) -> impl Iterator<Item = Wall> + '_ {
        let sums = (0..).zip(&self.0).flat_map(|(vertex, sums)| sums.iter().map(move |sum| (vertex, sum)));
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
    for (side, corners) in boundary_faces(lattice) {
        let mut normal = Vector3::zeros();
        normal[side / 2] = if side % 2 == 0 { -1.0 } else { 1.0 };
        corners.iter().for_each(|&corner| sums.add(corner, &normal, 0.25));
    }
    sums.walls().collect()
}

/// Returns the walls of a surface, assigned to the boundary vertices of the cells that contain it.
///
/// A component of the lattice that contains no part of the surface gets the walls of its boundary faces.
///
/// * `outwards`: outward direction of each boundary vertex, zero for interior vertices. If the surface in a
///   component is oriented against these directions, its normals are reversed.
pub(super) fn of_surface(
    lattice: &Lattice,
    surface: Surface<'_>,
    adjacency: &Adjacency,
    outwards: &[Vector3<f64>],
) -> Vec<Wall> {
    let mut sums = AreaSums::new(lattice.len());
    let (points, areas) = samples(surface, SPACING * lattice.cell_size());
    let embedding = Embedding::new(lattice, &points);
    let face = lattice.cell_size().powi(2);
    for (sample, area) in areas.iter().enumerate() {
        let corners = embedding.corners(sample).into_iter().zip(embedding.weights(sample));
        for (corner, weight) in corners.filter(|(corner, _)| outwards[*corner as usize] != Vector3::zeros()) {
            sums.add(corner, area, f64::from(weight.max(0.0)) / face);
        }
    }
    // Sum over the walls of each component: positive if the surface is oriented outwards.
    let mut alignments = vec![0.0; adjacency.component_count];
    for wall in sums.walls() {
        let vertex = wall.vertex as usize;
        alignments[adjacency.component(vertex)] += wall.area * wall.normal.dot(&outwards[vertex]);
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

/// Returns sample points on the triangles of a surface, at most `spacing` apart, and the area vector of each
/// point.
fn samples(surface: Surface<'_>, spacing: f64) -> (Vec<Point3<f64>>, Vec<Vector3<f64>>) {
    let vertices = surface.mesh.vertices();
    let (mut points, mut areas) = (Vec::new(), Vec::new());
    for triangle in surface.mesh.triangles() {
        let [a, b, c] = triangle.map(|corner| vertices[corner as usize]);
        let (u, v) = (b - a, c - a);
        let area = u.cross(&v) * 0.5;
        if area == Vector3::zeros() {
            continue;
        }
        // Splits each side of the triangle into equal parts, which divides the triangle into congruent
        // smaller triangles. The samples are their centroids. Every second triangle is rotated by half a
        // turn.
        let subdivisions = (u.norm().max(v.norm()).max((c - b).norm()) / spacing).ceil().max(1.0);
        let mut add = |i: f64, j: f64| {
            points.push(a + u * (i / subdivisions) + v * (j / subdivisions));
            areas.push(area / (subdivisions * subdivisions));
        };
        for i in 0..subdivisions as usize {
            for j in 0..subdivisions as usize - i {
                let (i, j) = (i as f64, j as f64);
                add(i + 1.0 / 3.0, j + 1.0 / 3.0);
                if i + j + 1.0 < subdivisions {
                    add(i + 2.0 / 3.0, j + 2.0 / 3.0);
                }
            }
        }
    }
    (points, areas)
}
