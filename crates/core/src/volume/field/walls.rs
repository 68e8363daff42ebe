//! Walls: pieces of the boundary, assigned to lattice vertices.

use nalgebra::{Point3, Vector3};

use crate::lattice::{Embedding, Lattice};
use crate::volume::adjacency::{Adjacency, boundary_faces};
use crate::volume::surface::Surface;

/// Greatest distance between samples of a surface, in cells.
const SPACING: f64 = 0.5;

/// Piece of the boundary near a lattice vertex.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wall {
    pub(super) vertex: u32,
    /// Outward unit normal.
    pub(super) normal: Vector3<f64>,
    /// Area, in faces of a cell.
    pub(super) area: f64,
}

/// Sums of area vectors (area times normal) per vertex, in six parts by the dominant axis and its sign.
struct Parts(Vec<[Vector3<f64>; 6]>);

impl Parts {
    fn new(vertices: usize) -> Self {
        Self(vec![[Vector3::zeros(); 6]; vertices])
    }

    /// Adds `share` times an area vector.
    fn add(&mut self, vertex: u32, area: &Vector3<f64>, share: f64) {
        let axis = area.iamax();
        self.0[vertex as usize][2 * axis + usize::from(area[axis] > 0.0)] += area * share;
    }

    /// Returns one wall per part that is not zero.
    fn walls(&self) -> impl Iterator<Item = Wall> + '_ {
        let parts =
            (0..).zip(&self.0).flat_map(|(vertex, parts)| parts.iter().map(move |part| (vertex, part)));
        parts.filter(|(_, part)| **part != Vector3::zeros()).map(|(vertex, part)| {
            let area = part.norm();
            Wall { vertex, normal: part / area, area }
        })
    }
}

/// Returns the walls of the boundary faces of the cells, with a quarter of each face at each of its corners.
pub(super) fn of_cells(lattice: &Lattice) -> Vec<Wall> {
    let mut parts = Parts::new(lattice.len());
    for (side, corners) in boundary_faces(lattice) {
        let mut normal = Vector3::zeros();
        normal[side / 2] = if side % 2 == 0 { -1.0 } else { 1.0 };
        corners.iter().for_each(|&corner| parts.add(corner, &normal, 0.25));
    }
    parts.walls().collect()
}

/// Returns the walls of a surface, assigned to the boundary vertices of the cells that contain it.
///
/// A component of the lattice without a surface gets the walls of its boundary faces.
///
/// * `outwards`: outward direction of each vertex, zero for interior vertices. A component's surface that is
///   oriented against these directions is flipped.
pub(super) fn of_surface(
    lattice: &Lattice,
    surface: Surface<'_>,
    adjacency: &Adjacency,
    outwards: &[Vector3<f64>],
) -> Vec<Wall> {
    let mut parts = Parts::new(lattice.len());
    let (points, areas) = samples(surface, SPACING * lattice.cell_size());
    let embedding = Embedding::new(lattice, &points);
    let face = lattice.cell_size().powi(2);
    for (sample, area) in areas.iter().enumerate() {
        let corners = embedding.corners(sample).into_iter().zip(embedding.weights(sample));
        for (corner, weight) in corners.filter(|(corner, _)| outwards[*corner as usize] != Vector3::zeros()) {
            parts.add(corner, area, f64::from(weight.max(0.0)) / face);
        }
    }
    let mut alignments = vec![0.0; adjacency.components];
    for wall in parts.walls() {
        let vertex = wall.vertex as usize;
        alignments[adjacency.component(vertex)] += wall.area * wall.normal.dot(&outwards[vertex]);
    }
    let alignment = |wall: &Wall| alignments[adjacency.component(wall.vertex as usize)];
    let oriented = parts.walls().filter(|wall| alignment(wall) != 0.0);
    let oriented = oriented.map(|wall| Wall { normal: wall.normal * alignment(&wall).signum(), ..wall });
    let mut walls: Vec<Wall> = oriented.collect();
    if alignments.contains(&0.0) {
        walls.extend(of_cells(lattice).into_iter().filter(|wall| alignment(wall) == 0.0));
    }
    walls
}

/// Returns points on the triangles of a surface, at most `spacing` apart, and the area vector of each point.
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
        // Splits the triangle into congruent smaller ones, upright and rotated by half a turn, and samples
        // their centroids.
        let parts = (u.norm().max(v.norm()).max((c - b).norm()) / spacing).ceil().max(1.0);
        let mut add = |i: f64, j: f64| {
            points.push(a + u * (i / parts) + v * (j / parts));
            areas.push(area / (parts * parts));
        };
        for i in 0..parts as usize {
            for j in 0..parts as usize - i {
                let (i, j) = (i as f64, j as f64);
                add(i + 1.0 / 3.0, j + 1.0 / 3.0);
                if i + j + 1.0 < parts {
                    add(i + 2.0 / 3.0, j + 2.0 / 3.0);
                }
            }
        }
    }
    (points, areas)
}
