//! The data of a run that are the same in all frames: names, surfaces, lattices and colliders.

use nalgebra::{Point3, Vector3};
use serde::{Deserialize, Serialize};
use supple::mesh::Mesh;
use supple::{Shape, Simulation, euler_degrees};

use super::pieces::{ears, links};
use super::points::{LATTICE_VALUES, MESH_VALUES, pack_words};
use crate::collider;
use crate::film::{Color, Tint};
use crate::space::FileSpace;

/// Version of the format of the data of a run in which no body is broken.
const WHOLE: u32 = 1;

/// Version of the format of the data of a run with broken bodies, whose frames have pieces.
const BROKEN: u32 = 2;

/// Description of a run, which begins its data as JSON.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Header {
    /// Version of the format of the data: 2 if a body is broken in a frame, 1 if not.
    version: u32,
    /// Name of the run.
    pub(crate) name: String,
    /// Frames per second of the simulation.
    pub(super) fps: f64,
    /// Number of the first frame.
    pub(super) first: u64,
    /// Interval between frames, at least 1.
    pub(super) every: u64,
    /// Number of frames.
    pub(crate) frames: usize,
    /// Direction against gravity, a unit vector; y without gravity.
    pub(super) up: [f64; 3],
    /// Surfaces of the bodies and of the colliders that are meshes. Equal surfaces are listed once.
    pub(super) surfaces: Vec<SurfaceSize>,
    pub(super) bodies: Vec<BodyHeader>,
    pub(super) colliders: Vec<ColliderHeader>,
    /// Size of the arrays that follow the header, in bytes.
    pub(super) arrays: usize,
    /// For films, the colors of the faces of each body: numbers of faces that follow each other, with the color of their
    /// material, linear. Empty in pages.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    colors: Vec<Vec<(u32, Option<Color>)>>,
}

/// Numbers of elements of the arrays of a surface.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct SurfaceSize {
    vertices: u32,
    faces: u32,
    /// Number of corners of all faces.
    corners: u32,
    /// Number of triangles, or 0 if each face is a fan from its first corner.
    triangles: u32,
}

/// A body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct BodyHeader {
    pub(super) name: String,
    /// Index of its surface.
    pub(super) surface: usize,
    /// Number of vertices of its lattice.
    lattice: u32,
    /// Number of links of its lattice.
    pub(super) links: u32,
}

/// A collider.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct ColliderHeader {
    /// Center of its rotation.
    pub(super) center: [f64; 3],
    #[serde(flatten)]
    pub(super) shape: ColliderShape,
}

/// Shape of a collider before it moves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "shape", rename_all = "snake_case")]
pub(super) enum ColliderShape {
    Plane {
        point: [f64; 3],
        normal: [f64; 3],
    },
    Sphere {
        radius: f64,
    },
    Box {
        half_extents: [f64; 3],
        rotate: [f64; 3],
    },
    Capsule {
        a: [f64; 3],
        b: [f64; 3],
        radius: f64,
    },
    /// A mesh, as the index of its surface. The positions of an animated mesh are those of the frames.
    Mesh {
        surface: usize,
        is_animated: bool,
        is_closed: bool,
    },
}

impl Header {
    /// Describes a simulation whose bodies all have meshes, in the coordinates `space`. A broken body has the surface and
    /// the lattice of the whole body. Returns the description, with no frames, and its arrays.
    pub(crate) fn new(
        simulation: &Simulation,
        name: &str,
        fps: f64,
        first: u64,
        every: u64,
        space: FileSpace,
    ) -> (Self, Vec<u8>) {
        let gravity = Vector3::from(space.direction(simulation.gravity()));
        let up = (-gravity).try_normalize(0.0).unwrap_or_else(|| space.direction([0.0, 1.0, 0.0]).into());
        let mut surfaces = Surfaces::default();
        let mut arrays = Vec::new();
        let mut bodies = Vec::new();
        for body in simulation.bodies() {
            let lattice = body.lattice();
            let mut links = links(lattice);
            if body.topology_version() > 0 {
                links.iter_mut().flatten().for_each(|vertex| *vertex = lattice.source(*vertex));
                links.sort_unstable();
                links.dedup();
            }
            let surface = body.whole_mesh().map_or(0, |mesh| surfaces.index(mesh, &mut arrays));
            bodies.push(BodyHeader {
                name: body.name().to_owned(),
                surface,
                lattice: lattice.whole_len() as u32,
                links: links.len() as u32,
            });
            pack_words(links.as_flattened().iter().copied(), &mut arrays);
        }
        let mut colliders = Vec::new();
        for index in 0..simulation.collider_count() {
            let shape = &simulation.collider(index).description().shape;
            colliders.push(ColliderHeader {
                center: space.position(shape.center().into()),
                shape: ColliderShape::new(shape, space, &mut surfaces, &mut arrays),
            });
        }
        let sizes = surfaces.0.iter().map(|(_, size)| size.clone()).collect();
        let header = Self {
            version: WHOLE,
            name: name.to_owned(),
            fps,
            first,
            every,
            frames: 0,
            up: up.into(),
            surfaces: sizes,
            bodies,
            colliders,
            arrays: arrays.len(),
            colors: Vec::new(),
        };
        (header, arrays)
    }

    /// Sets the colors of the faces of each body; `None` for those without a material.
    pub(crate) fn set_colors(&mut self, bodies: &[Vec<Option<Color>>]) {
        let has_any = bodies.iter().flatten().any(Option::is_some);
        let runs = |faces: &Vec<Option<Color>>| {
            faces.chunk_by(|a, b| a == b).map(|equal| (equal.len() as u32, equal[0])).collect()
        };
        self.colors = if has_any { bodies.iter().map(runs).collect() } else { Vec::new() };
    }

    /// Returns the colors of the faces of a body; none if no body has materials.
    pub(super) fn tints(&self, body: usize) -> Vec<Tint> {
        let runs = self.colors.get(body).into_iter().flatten();
        let tint = |color: Option<Color>| color.map_or(Tint::Palette, Tint::Material);
        let tints = runs.flat_map(|&(faces, color)| std::iter::repeat_n(tint(color), faces as usize));
        // A changed page does not take more memory than its surfaces.
        tints.take(self.surfaces[self.bodies[body].surface].faces as usize).collect()
    }

    /// Returns whether the frames of the run in a page have pieces.
    pub(crate) fn has_pieces(&self) -> bool {
        self.version == BROKEN
    }

    /// Sets whether a body is broken in a frame.
    pub(crate) fn set_has_pieces(&mut self, has_pieces: bool) {
        self.version = if has_pieces { BROKEN } else { WHOLE };
    }

    /// Returns the point sets of a frame in which no body is broken, each as its number of points and the largest value
    /// of a coordinate: the mesh and the lattice of each body, then the mesh of each animated collider.
    pub(super) fn point_sets(&self) -> Vec<(usize, u16)> {
        let bodies = self.bodies.iter();
        let mesh = |surface: usize| (self.surfaces[surface].vertices as usize, MESH_VALUES);
        let mut sets: Vec<(usize, u16)> =
            bodies.flat_map(|body| [mesh(body.surface), (body.lattice as usize, LATTICE_VALUES)]).collect();
        sets.extend(self.colliders.iter().filter_map(|collider| match collider.shape {
            ColliderShape::Mesh { surface, is_animated: true, .. } => Some(mesh(surface)),
            _ => None,
        }));
        sets
    }

    /// Returns whether the indices and versions are valid.
    pub(super) fn is_valid(&self) -> bool {
        let surface = |collider: &ColliderHeader| match collider.shape {
            ColliderShape::Mesh { surface, .. } => Some(surface),
            _ => None,
        };
        let mut surfaces =
            self.bodies.iter().map(|body| body.surface).chain(self.colliders.iter().filter_map(surface));
        (WHOLE..=BROKEN).contains(&self.version)
            && self.every > 0
            && surfaces.all(|surface| surface < self.surfaces.len())
    }
}

impl SurfaceSize {
    /// Returns the numbers of vertices, faces, corners and listed triangles.
    pub(super) fn counts(&self) -> [usize; 4] {
        [self.vertices, self.faces, self.corners, self.triangles].map(|count| count as usize)
    }
}

impl ColliderShape {
    fn new<'a>(
        shape: &'a Shape,
        space: FileSpace,
        surfaces: &mut Surfaces<'a>,
        arrays: &mut Vec<u8>,
    ) -> Self {
        match *shape {
            Shape::Plane { point, normal } => {
                Self::Plane { point: space.position(point), normal: space.direction(normal) }
            }
            Shape::Sphere { radius, .. } => Self::Sphere { radius: space.length(radius) },
            Shape::Box { half_extents, rotate, .. } => Self::Box {
                half_extents: space.position(half_extents).map(f64::abs),
                rotate: space.angles(rotate),
            },
            Shape::Capsule { a, b, radius } => {
                Self::Capsule { a: space.position(a), b: space.position(b), radius: space.length(radius) }
            }
            Shape::Mesh { ref mesh, .. } => {
                let surface = surfaces.index(mesh.mesh(), arrays);
                let is_animated = mesh.animation().is_some();
                if !is_animated {
                    let placed = placed(shape, space, mesh.mesh().vertices().iter().copied());
                    pack_words(placed.iter().flatten().map(|number| number.to_bits()), arrays);
                }
                Self::Mesh { surface, is_animated, is_closed: mesh.is_closed() }
            }
        }
    }
}

/// Returns the positions of the vertices of a collider that is a mesh, before it moves. They are finite.
fn placed(shape: &Shape, space: FileSpace, vertices: impl Iterator<Item = Point3<f64>>) -> Vec<[f32; 3]> {
    let &Shape::Mesh { scale, rotate, translate, .. } = shape else { return Vec::new() };
    let rotation = euler_degrees(rotate);
    let place = |vertex: Point3<f64>| {
        let place = rotation * (vertex.coords * scale) + Vector3::from(translate);
        collider::finite(space.position(place.into()).into())
    };
    vertices.map(place).collect()
}

/// Returns the present positions of the vertices of each animated collider, before it moves as a whole.
pub(crate) fn animated_positions(
    simulation: &Simulation,
    space: FileSpace,
) -> impl Iterator<Item = Vec<[f32; 3]>> {
    let time = simulation.time();
    (0..simulation.collider_count()).filter_map(move |index| {
        let shape = &simulation.collider(index).description().shape;
        let Shape::Mesh { mesh, .. } = shape else { return None };
        let mut vertices = Vec::new();
        mesh.animation()?.positions_at_time(time, &mut vertices);
        Some(placed(shape, space, vertices.into_iter()))
    })
}

/// The surfaces so far, with their meshes.
#[derive(Default)]
struct Surfaces<'a>(Vec<(&'a Mesh, SurfaceSize)>);

impl<'a> Surfaces<'a> {
    /// Returns the index of the surface of a mesh. A new surface is added, with the numbers of corners of its faces,
    /// its corners, for each vertex the first vertex at the same position, and the triangles if they are no fans.
    fn index(&mut self, mesh: &'a Mesh, arrays: &mut Vec<u8>) -> usize {
        let size = SurfaceSize {
            vertices: mesh.vertices().len() as u32,
            faces: mesh.face_count() as u32,
            corners: mesh.faces().map(|face| face.len() as u32).sum(),
            triangles: ears(mesh).len() as u32,
        };
        let is_equal = |(other, other_size): &(&Mesh, SurfaceSize)| {
            *other_size == size && other.faces().eq(mesh.faces()) && other.weld() == mesh.weld()
        };
        if let Some(index) = self.0.iter().position(is_equal) {
            return index;
        }
        pack_words(mesh.faces().map(|face| face.len() as u32), arrays);
        pack_words(mesh.faces().flatten().copied(), arrays);
        pack_words(mesh.weld().iter().copied(), arrays);
        pack_words(ears(mesh).as_flattened().iter().copied(), arrays);
        self.0.push((mesh, size));
        self.0.len() - 1
    }
}
