//! The sampler: points of the surface of a body, part by part, on which contacts act.

use std::borrow::Cow;
use std::cell::OnceCell;

use nalgebra::Point3;

use super::parts::Parts;
use super::surface_points::{MAX_SAMPLES, surface_points};
use crate::lattice::{Embedding, Lattice, Locator};
use crate::mesh::{Mesh, distinct, flip_needles};

/// 1 / the distance in cells up to which vertices are at the same place, and up to which triangles are needles.
const SCALE: f64 = 1048576.0;

/// The surface of a body at rest: the triangles of its mesh, or the faces of a bare lattice.
pub(crate) struct RestSurface<'a> {
    pub(super) parts: Parts<'a>,
    vertices: Cow<'a, [Point3<f64>]>,
    /// Vertices at the same place on the same side of a crack are one.
    triangles: Vec<[u32; 3]>,
    /// The cell that each vertex follows.
    hosts: Vec<u32>,
    /// Whether it encloses a volume.
    pub(super) is_closed: bool,
    /// The point of the model's frame that is the origin of the coordinates, and their unit there.
    place: (Point3<f64>, f64),
}

/// The surface of one part. Vertices at the same place are one, and there are no needles, so that the pseudonormals of
/// [`SurfaceTree`](crate::mesh::SurfaceTree) are right.
pub(super) struct PartSurface {
    pub(super) vertices: Vec<Point3<f64>>,
    pub(super) triangles: Vec<[u32; 3]>,
    /// The cell that each vertex follows.
    hosts: Vec<u32>,
    /// The vertices, sorted by x; computed at the first search.
    by_x: OnceCell<Vec<u32>>,
}

/// A sample of the surface.
pub(super) struct SurfaceSample {
    /// Its position at rest.
    pub(super) point: Point3<f64>,
    /// A cell of its own part.
    pub(super) cell: u32,
    /// Local coordinates in the cell.
    pub(super) local: [f32; 3],
}

impl<'a> RestSurface<'a> {
    /// Returns the surface of a mesh in its lattice, in the coordinates of the model's frame. `embedding`: of the
    /// vertices of the mesh.
    pub(crate) fn of_mesh(mesh: &'a Mesh, lattice: &'a Lattice, embedding: &Embedding) -> Self {
        let weld = mesh.weld();
        let welded = |triangle: &[u32; 3]| triangle.map(|vertex| weld[vertex as usize]);
        Self {
            parts: Parts::new(lattice),
            vertices: Cow::Borrowed(mesh.vertices()),
            triangles: mesh.surface().iter().map(welded).collect(),
            hosts: (0..embedding.len()).map(|vertex| embedding.cell(vertex)).collect(),
            is_closed: mesh.is_closed(),
            place: (Point3::origin(), 1.0),
        }
    }

    /// Returns the surface of a bare lattice, in rest coordinates: the faces of its cells that no other cell shares.
    pub(crate) fn of_lattice(lattice: &'a Lattice) -> Self {
        let mut hosts = vec![0; lattice.len()];
        for cell in 0..lattice.cells().len() as u32 {
            lattice.cell_corners(cell).iter().for_each(|&corner| hosts[corner as usize] = cell);
        }
        let faces = lattice.boundary_faces();
        Self {
            parts: Parts::new(lattice),
            vertices: lattice.indices().iter().map(|index| index.map(f64::from).into()).collect(),
            triangles: faces.flat_map(|(_, [a, b, c, d])| [[a, b, c], [a, c, d]]).collect(),
            hosts,
            is_closed: true,
            place: (lattice.origin(), lattice.cell_size()),
        }
    }

    /// Converts the surface to rest coordinates: positions in the model's frame, in cells from the origin of the
    /// lattice. A point of the cell with the index i and the local coordinates u has the rest coordinates i + u,
    /// however the body is deformed.
    #[must_use]
    pub(super) fn at_rest(mut self) -> Self {
        let (origin, size) = (self.parts.lattice.origin(), self.parts.lattice.cell_size());
        if self.place != (origin, size) {
            let scale = 1.0 / size;
            self.vertices = self.vertices.iter().map(|p| Point3::from((p - origin) * scale)).collect();
            self.place = (origin, size);
        }
        self
    }

    /// Returns the surface of each part.
    pub(super) fn of_parts(&self) -> Vec<PartSurface> {
        let mut of_parts = vec![Vec::new(); self.parts.count];
        for triangle in &self.triangles {
            of_parts[self.parts.of_cell(self.hosts[triangle[0] as usize]) as usize].push(*triangle);
        }
        let mut first = vec![0; self.vertices.len()];
        of_parts.iter().map(|triangles| self.part(triangles, &mut first)).collect()
    }

    /// Welds the vertices of the triangles of a part, and removes needles. `first`: a buffer, with a number for each
    /// vertex.
    fn part(&self, triangles: &[[u32; 3]], first: &mut [u32]) -> PartSurface {
        let scale = SCALE / (self.parts.lattice.cell_size() / self.place.1);
        let used = distinct(triangles.as_flattened().iter().copied());
        let position = |vertex: u32| self.vertices[vertex as usize];
        let place = |&vertex: &u32| {
            let place = (position(vertex).coords * scale).map(|x| x.round() as i64);
            (<[i64; 3]>::from(place), vertex)
        };
        let mut places: Vec<([i64; 3], u32)> = used.iter().map(place).collect();
        places.sort_unstable();
        // The lowest vertex at each place stands for the others.
        for same in places.chunk_by(|a, b| a.0 == b.0) {
            same.iter().for_each(|(_, vertex)| first[*vertex as usize] = same[0].1);
        }
        let kept: Vec<u32> = used.into_iter().filter(|&vertex| first[vertex as usize] == vertex).collect();
        let number = |vertex: u32| kept.partition_point(|&other| other < first[vertex as usize]) as u32;
        let vertices: Vec<_> = kept.iter().map(|&vertex| position(vertex)).collect();
        let mut triangles: Vec<[u32; 3]> = triangles
            .iter()
            .map(|triangle| triangle.map(number))
            .filter(|&[a, b, c]| a != b && b != c && c != a)
            .collect();
        flip_needles(&vertices, &mut triangles, 1.0 / scale);
        PartSurface {
            hosts: kept.iter().map(|&vertex| self.hosts[vertex as usize]).collect(),
            vertices,
            triangles,
            by_x: OnceCell::new(),
        }
    }

    /// Returns samples of the parts, part by part: see [`surface_points`]. They are at most `spacing` cells apart, or
    /// farther if a part has more than [`MAX_SAMPLES`].
    ///
    /// The surface of a crack is smooth, so that a part of it lies in cells of the other side. Such samples follow a
    /// cell of their own part.
    pub(super) fn sample(&self, surfaces: &[PartSurface], spacing: f64) -> Vec<SurfaceSample> {
        let &Self { parts, place: (origin, unit), .. } = self;
        let (lattice, limit) = (parts.lattice, MAX_SAMPLES * parts.lattice.len());
        let spacing = spacing * (lattice.cell_size() / unit);
        let mut locator = Locator::new(lattice);
        let mut samples = Vec::new();
        for (part, surface) in (0..).zip(surfaces) {
            let points = surface_points(&surface.vertices, &surface.triangles, spacing, limit);
            samples.extend(points.into_iter().map(|point| {
                let in_model = origin + point.coords * unit;
                let (cell, local) = locator.locate(&in_model);
                if parts.of_cell(cell) == part {
                    return SurfaceSample { point, cell, local };
                }
                let position = (in_model - lattice.origin()) / lattice.cell_size();
                let cell = parts
                    .nearest_cell((cell, part), position.into())
                    .unwrap_or_else(|| surface.nearest_host(&point));
                let corner = lattice.cells()[cell as usize];
                let local = std::array::from_fn(|a| (position[a] - f64::from(corner[a])) as f32);
                SurfaceSample { point, cell, local }
            }));
        }
        samples
    }
}

impl PartSurface {
    /// Returns the cell of the vertex that is nearest to a point, of the lowest one if several are equally near.
    fn nearest_host(&self, point: &Point3<f64>) -> u32 {
        let x = |vertex: u32| self.vertices[vertex as usize].x;
        let by_x = self.by_x.get_or_init(|| {
            let mut vertices: Vec<u32> = (0..self.vertices.len() as u32).collect();
            vertices.sort_unstable_by(|&a, &b| x(a).total_cmp(&x(b)));
            vertices
        });
        let (lower, upper) = by_x.split_at(by_x.partition_point(|&vertex| x(vertex) < point.x));
        let mut nearest = (f64::INFINITY, 0);
        let mut search = |vertices: &mut dyn Iterator<Item = &u32>| {
            for &vertex in vertices {
                if (x(vertex) - point.x).powi(2) > nearest.0 {
                    break;
                }
                let distance = (self.vertices[vertex as usize] - point).norm_squared();
                if (distance, vertex) < nearest {
                    nearest = (distance, vertex);
                }
            }
        };
        search(&mut upper.iter());
        search(&mut lower.iter().rev());
        self.hosts.get(nearest.1 as usize).copied().unwrap_or(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::testing::Random;

    /// On a grid many vertices have the same x, and many are equally near.
    #[test]
    fn the_nearest_host_is_that_of_a_search_of_all_vertices() {
        let mut random = Random(11);
        let mut coordinate = |n: usize| random.below(n) as f64;
        let vertices: Vec<Point3<f64>> =
            (0..200).map(|_| [coordinate(5), coordinate(5), coordinate(5)].into()).collect();
        let hosts = (0..200).map(|vertex| 7 * vertex).collect();
        let surface = PartSurface { vertices, triangles: Vec::new(), hosts, by_x: OnceCell::new() };
        for _ in 0..500 {
            let point = Point3::from([coordinate(13), coordinate(13), coordinate(13)].map(|x| 0.5 * x - 1.0));
            let distance = |vertex: &Point3<f64>| (vertex - point).norm_squared();
            let all = surface.vertices.iter().zip(&surface.hosts);
            let (_, &expected) = all.min_by(|a, b| distance(a.0).total_cmp(&distance(b.0))).unwrap();
            assert_eq!(surface.nearest_host(&point), expected, "{point}");
        }
    }
}
