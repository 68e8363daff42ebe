//! Pieces of a boundary, and which lattice vertices they go with.

use nalgebra::{Point3, Vector3};

use crate::lattice::{Embedding, Lattice};
use crate::volume::adjacency::{Adjacency, boundary_faces};
use crate::volume::surface::Surface;

/// The largest distance between samples of a surface, in cells.
const SPACING: f64 = 0.5;

/// A piece of a boundary near a lattice vertex.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wall {
    pub(super) vertex: u32,
    /// Outwards.
    pub(super) normal: Vector3<f64>,
    /// In faces of a cell.
    pub(super) area: f64,
}

/// Areas along the normals, of each vertex in six parts: one for each axis and way that they may look.
struct Parts(Vec<[Vector3<f64>; 6]>);

impl Parts {
    fn new(vertices: usize) -> Self {
        Self(vec![[Vector3::zeros(); 6]; vertices])
    }

    fn add(&mut self, vertex: u32, area: &Vector3<f64>, share: f64) {
        let axis = area.iamax();
        self.0[vertex as usize][2 * axis + usize::from(area[axis] > 0.0)] += area * share;
    }

    fn walls(&self) -> impl Iterator<Item = Wall> + '_ {
        let parts =
            (0..).zip(&self.0).flat_map(|(vertex, parts)| parts.iter().map(move |part| (vertex, part)));
        parts.filter(|(_, part)| **part != Vector3::zeros()).map(|(vertex, part)| {
            let area = part.norm();
            Wall { vertex, normal: part / area, area }
        })
    }
}

/// The faces of cells that no other cell shares, a quarter of each to each of its corners.
pub(super) fn of_cells(lattice: &Lattice) -> Vec<Wall> {
    let mut parts = Parts::new(lattice.len());
    for (side, corners) in boundary_faces(lattice) {
        let mut normal = Vector3::zeros();
        normal[side / 2] = if side % 2 == 0 { -1.0 } else { 1.0 };
        corners.iter().for_each(|&corner| parts.add(corner, &normal, 0.25));
    }
    parts.walls().collect()
}

/// A surface, with the boundary vertices of the cells in which it lies; of a component of the lattice that has none of
/// it the faces of the cells.
///
/// * `outwards`: a direction for each vertex, zero at inner ones; where a component's surface looks the other way, it is
///   turned.
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
    let mut looks = vec![0.0; adjacency.components];
    for wall in parts.walls() {
        let vertex = wall.vertex as usize;
        looks[adjacency.component(vertex)] += wall.area * wall.normal.dot(&outwards[vertex]);
    }
    let look = |wall: &Wall| looks[adjacency.component(wall.vertex as usize)];
    let turned = parts.walls().filter(|wall| look(wall) != 0.0);
    let turned = turned.map(|wall| Wall { normal: wall.normal * look(&wall).signum(), ..wall });
    let mut walls: Vec<Wall> = turned.collect();
    if looks.contains(&0.0) {
        walls.extend(of_cells(lattice).into_iter().filter(|wall| look(wall) == 0.0));
    }
    walls
}

/// Points on the triangles of a surface, no farther apart than `spacing`, each with the area that it stands for,
/// along the normal.
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
        // The middles of smaller triangles: those that lie like the large one, and those turned by half a turn.
        let parts = (u.norm().max(v.norm()).max((c - b).norm()) / spacing).ceil().max(1.0);
        let mut put = |i: f64, j: f64| {
            points.push(a + u * (i / parts) + v * (j / parts));
            areas.push(area / (parts * parts));
        };
        for i in 0..parts as usize {
            for j in 0..parts as usize - i {
                let (i, j) = (i as f64, j as f64);
                put(i + 1.0 / 3.0, j + 1.0 / 3.0);
                if i + j + 1.0 < parts {
                    put(i + 2.0 / 3.0, j + 2.0 / 3.0);
                }
            }
        }
    }
    (points, areas)
}
