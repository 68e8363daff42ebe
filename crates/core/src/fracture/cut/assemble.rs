//! The mesh of the pieces: its vertices with their cells and origins, and its faces.

use nalgebra::{Point3, Vector3};

use super::cap::{Cap, Caps};
use super::clip::{Clipped, Corner, Fragment};
use super::faces::CutSurface;
use super::input::Input;
use super::map::Map;
use super::planes::Cell;
use crate::lattice::Locator;
use crate::mesh::{Csr, Mesh, MeshError, Planar, triangulate};
use crate::voxel::step;

/// The point of the uncut mesh at which a vertex of a cut mesh is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Origin {
    /// A vertex of the uncut mesh.
    Vertex(u32),
    /// A point on an edge, or on a diagonal of a face: `(1 - t) a + t b`.
    Edge {
        /// The vertices a and b.
        vertices: [u32; 2],
        /// Position along the edge, between 0 and 1.
        t: f64,
    },
    /// A point in a triangle of a face.
    Face {
        /// The corners of the triangle.
        vertices: [u32; 3],
        /// Weights of the corners; their sum is 1.
        weights: [f64; 3],
    },
    /// A point inside the mesh, on the cap of a crack.
    Cap {
        /// Index of the crack.
        crack: u32,
    },
}

/// The origin of a face of a cut mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaceSource {
    /// A face of the uncut mesh, with its corners.
    Whole(u32),
    /// A part of a face of the uncut mesh.
    Part(u32),
    /// A part of the surface of a crack.
    Cap {
        /// Index of the crack.
        crack: u32,
    },
}

/// A mesh that is cut along cracks.
#[derive(Clone, Debug)]
pub struct CutMesh {
    /// The pieces. The vertices of the uncut mesh come first and keep their numbers. The faces are in the order of the
    /// uncut mesh, and caps come last. Copies of a vertex at a seam are welded, vertices on the two sides of a crack
    /// are not.
    pub mesh: Mesh,
    /// The cell that each vertex follows, shape `(n,)`.
    pub hosts: Vec<u32>,
    /// The origin of each vertex, shape `(n,)`.
    pub origins: Vec<Origin>,
    /// The origin of each face.
    pub face_sources: Vec<FaceSource>,
    /// Coordinates in the plane of the crack, in the length unit of the mesh: one pair for each corner of each cap, in
    /// the order of the faces.
    pub cap_uvs: Vec<[f64; 2]>,
    /// Number of broken cell faces without a cap, because the mesh is open there.
    pub unclosed_faces: usize,
}

/// Vertices of the uncut mesh between which a point is: one, two or three, then `u32::MAX`. Copies of a point at a seam
/// differ.
type Between = [u32; 3];

/// Builds the mesh of the pieces.
pub(super) fn assemble(input: &Input<'_>, clipped: &Clipped, caps: &Caps) -> Result<CutMesh, MeshError> {
    let mesh = input.mesh;
    let mut vertices = Vertices::new(input, clipped);
    let mut polygons = Csr::with_capacity(mesh.face_count(), 0);
    let mut face_sources = Vec::with_capacity(mesh.face_count());
    let mut push = |corners: &[u32], source: FaceSource| {
        polygons.push(corners.iter().copied());
        face_sources.push(source);
    };
    let mut fragments = clipped.fragments.iter().peekable();
    let mut first = 0;
    for (face, corners) in mesh.faces().enumerate() {
        let end = first + corners.len().saturating_sub(2) as u32;
        if fragments.peek().is_none_or(|fragment| fragment.source >= end) {
            push(corners, FaceSource::Whole(face as u32));
            first = end;
            continue;
        }
        for triangle in first..end {
            if fragments.peek().is_none_or(|fragment| fragment.source != triangle) {
                push(&mesh.triangles()[triangle as usize], FaceSource::Part(face as u32));
            }
            while let Some(fragment) = fragments.next_if(|fragment| fragment.source == triangle) {
                let corners: Vec<u32> =
                    fragment.corners.iter().map(|corner| vertices.of_corner(fragment, corner)).collect();
                for part in triangulate(&planar(input, fragment)) {
                    push(&part.map(|n| corners[n]), FaceSource::Part(face as u32));
                }
            }
        }
        first = end;
    }
    let mut cap_uvs = Vec::new();
    for upper in [false, true] {
        for cap in &caps.caps {
            let cell = step(cap.face.0, cap.face.1, i32::from(upper));
            let corner = |&point: &u32| vertices.of_cap(point, cell, cap.crack);
            let mut corners: Vec<u32> = cap.corners.iter().map(corner).collect();
            if upper {
                // Both sides have the same first corner, so that they are split into the same triangles.
                corners[1..].reverse();
            }
            cap_uvs
                .extend(corners.iter().map(|&corner| uv(input, cap, &vertices.positions[corner as usize])));
            push(&corners, FaceSource::Cap { crack: cap.crack });
        }
    }
    let Vertices { positions, weld, hosts, origins, .. } = vertices;
    Ok(CutMesh {
        mesh: Mesh::from_welded(positions, polygons, weld)?,
        hosts,
        origins,
        face_sources,
        cap_uvs,
        unclosed_faces: caps.unclosed,
    })
}

/// Returns the positions of the corners of a fragment in the plane of its triangle.
fn planar(input: &Input<'_>, fragment: &Fragment) -> Vec<Planar> {
    let vertices = input.mesh.vertices();
    let [a, b, c] = input.mesh.triangles()[fragment.source as usize].map(|corner| vertices[corner as usize]);
    let (along, other) = (b - a, c - a);
    let length = along.norm();
    let x = along / length;
    let height = (other - x * other.dot(&x)).norm();
    let [bx, cx, cy] = if length > 0.0 { [length, other.dot(&x), height] } else { [0.0, 0.0, other.norm()] };
    let position =
        |corner: &Corner| [corner.weights[1] * bx + corner.weights[2] * cx, corner.weights[2] * cy];
    fragment.corners.iter().map(position).collect()
}

/// Returns the coordinates of a point in the plane of a cap.
fn uv(input: &Input<'_>, cap: &Cap, position: &Point3<f64>) -> [f64; 2] {
    let mut normal = input.planes.normal(cap.crack);
    if normal == Vector3::zeros() {
        normal[cap.face.1] = 1.0;
    }
    let u = normal.cross(&Vector3::ith(normal.iamin(), 1.0)).normalize();
    let offset = position - input.cracks[cap.crack as usize].point;
    [u.dot(&offset), normal.cross(&u).dot(&offset)]
}

/// The vertices of the pieces.
struct Vertices<'a> {
    input: &'a Input<'a>,
    clipped: &'a Clipped,
    positions: Vec<Point3<f64>>,
    weld: Vec<u32>,
    hosts: Vec<u32>,
    origins: Vec<Origin>,
    locator: Locator<'a>,
    /// Vertices that are not in the uncut mesh, by point, class and place in the uncut mesh.
    numbers: Map<(u32, u8, Between), u32>,
    /// The first vertex of each point and class.
    first: Map<(u32, u8), u32>,
}

impl<'a> Vertices<'a> {
    /// Begins with the vertices of the uncut mesh.
    fn new(input: &'a Input<'a>, clipped: &'a Clipped) -> Self {
        let mesh = input.mesh;
        let mut vertices = Self {
            input,
            clipped,
            positions: mesh.vertices().to_vec(),
            weld: mesh.weld().to_vec(),
            hosts: Vec::with_capacity(mesh.vertices().len()),
            origins: (0..mesh.vertices().len() as u32).map(Origin::Vertex).collect(),
            locator: Locator::new(input.lattice),
            numbers: Map::default(),
            first: Map::default(),
        };
        for (vertex, &welded) in mesh.weld().iter().enumerate() {
            let cell = clipped.points[welded as usize].k;
            let host = vertices.host(&mesh.vertices()[vertex], cell);
            vertices.hosts.push(host);
        }
        vertices
    }

    /// Returns the vertex at a corner of a fragment.
    fn of_corner(&mut self, fragment: &Fragment, corner: &Corner) -> u32 {
        let mesh = self.input.mesh;
        let triangle = self.input.mesh.triangles()[fragment.source as usize];
        if (corner.point as usize) < mesh.vertices().len() {
            let heaviest = (0..3).max_by(|&a, &b| corner.weights[a].total_cmp(&corner.weights[b]));
            return triangle[heaviest.unwrap_or(0)];
        }
        let mut used: Vec<(u32, f64)> =
            triangle.into_iter().zip(corner.weights).filter(|&(_, weight)| weight != 0.0).collect();
        let origin = match used[..] {
            [(a, _), (b, t)] if a < b => Origin::Edge { vertices: [a, b], t },
            [(a, t), (b, _)] => Origin::Edge { vertices: [b, a], t },
            [(a, _)] => Origin::Vertex(a),
            _ => Origin::Face { vertices: triangle, weights: corner.weights },
        };
        used.sort_unstable_by_key(|&(vertex, _)| vertex);
        let mut between = [u32::MAX; 3];
        between.iter_mut().zip(&used).for_each(|(between, &(vertex, _))| *between = vertex);
        let point = &self.clipped.points[corner.point as usize];
        self.number(corner.point, fragment.cell_at(point), between, origin)
    }

    /// Returns the vertex at a corner of a cap on the side of a cell.
    fn of_cap(&mut self, point: u32, cell: Cell, crack: u32) -> u32 {
        let place = &self.clipped.points[point as usize];
        let class = self.input.faces.class(place.k, place.on, cell);
        match self.first.get(&(point, class)) {
            Some(&vertex) => vertex,
            None => self.number(point, cell, [u32::MAX; 3], Origin::Cap { crack }),
        }
    }

    /// Returns the vertex of a point in a cell.
    fn number(&mut self, point: u32, cell: Cell, between: Between, origin: Origin) -> u32 {
        let place = self.clipped.points[point as usize];
        let class = self.input.faces.class(place.k, place.on, cell);
        if let Some(&vertex) = self.numbers.get(&(point, class, between)) {
            return vertex;
        }
        let vertex = self.positions.len() as u32;
        let cell = std::array::from_fn(|a| if place.on >> a & 1 != 0 { cell[a] } else { place.k[a] });
        let host = self.host(&place.position, cell);
        self.numbers.insert((point, class, between), vertex);
        self.weld.push(*self.first.entry((point, class)).or_insert(vertex));
        self.positions.push(place.position);
        self.hosts.push(host);
        self.origins.push(origin);
        vertex
    }

    /// Returns the cell that a point follows: the nearest occupied cell on its side of all cracks near it.
    ///
    /// * `cell`: the cell of the point in the space of the cut.
    fn host(&mut self, position: &Point3<f64>, cell: Cell) -> u32 {
        let Input { lattice, planes, faces, surface, .. } = *self.input;
        let point = (position - lattice.origin()) / lattice.cell_size();
        let index: Cell = point.map(|x| x.floor() as i32).into();
        let near = faces.near(index);
        let own = || lattice.cell_at(cell);
        if surface == CutSurface::Cells
            && !near.is_empty()
            && let Some(own) = own()
        {
            return own;
        }
        let (located, _) = self.locator.locate(position);
        let is_beside = |other: Cell| {
            let is_beside =
                |&crack: &u32| planes.is_positive(crack, other) == planes.is_positive(crack, cell);
            near.iter().all(is_beside)
        };
        if near.is_empty() || is_beside(lattice.cells()[located as usize]) {
            return located;
        }
        let mut best = (f64::INFINITY, None);
        for k in 0..125 {
            let other: Cell = [index[0] + k % 5 - 2, index[1] + k / 5 % 5 - 2, index[2] + k / 25 - 2];
            let outside = |a: usize| {
                let low = f64::from(other[a]);
                (low - point[a]).max(point[a] - low - 1.0).max(0.0)
            };
            let distance = (0..3).map(|a| outside(a).powi(2)).sum::<f64>();
            if distance < best.0
                && is_beside(other)
                && let Some(number) = lattice.cell_at(other)
            {
                best = (distance, Some(number));
            }
        }
        best.1.or_else(own).unwrap_or(located)
    }
}
