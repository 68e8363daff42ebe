//! Cuts a mesh along the broken joints of a lattice.
//!
//! The cut is found in a space of its own: there the cracks are staircases of cell faces, and the mesh beside a crack
//! is moved clear of them. Whether two points of the mesh are on the same side of a face is decided by integers only,
//! the cells of the points. The pieces are therefore closed whatever the rounding.
//!
//! The files, in the order of the data flow:
//!
//! * `planes`: the planes of the cracks, and their staircases of faces.
//! * `faces`: the broken faces of the cells, and their continuation through empty cells to the surface of the mesh.
//! * `space`: the points of the mesh in the space of the cut.
//! * `refine`: splits the long edges beside a crack.
//! * `points`: the points at which edges and triangles cross the planes of the grid.
//! * `clip`: splits triangles along the planes of broken faces.
//! * `winding`: how often the mesh winds around the corners of broken faces.
//! * `cap`: the polygons of a broken face that are inside the mesh.
//! * `holes`: joins the holes of polygons with them.
//! * `assemble`: the mesh of the pieces.
//! * `map`: hash maps.

mod assemble;
mod cap;
mod clip;
mod faces;
mod holes;
mod map;
mod planes;
mod points;
mod refine;
mod space;
mod winding;

use nalgebra::{Point3, Vector3};

use crate::lattice::Lattice;
use crate::mesh::{Mesh, MeshError};

/// The plane of a crack, in the model frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CrackPlane {
    /// A point of the plane.
    pub point: Point3<f64>,
    /// A normal of the plane, of any length. A plane whose normal is zero or not finite does not attract the cut.
    pub normal: Vector3<f64>,
}

impl CrackPlane {
    /// Returns whether the center of a cell is on the positive side of the plane. The joints that a crack breaks are
    /// joints between cells on opposite sides.
    ///
    /// * `cell`: grid index `[x, y, z]` of the cell.
    pub fn is_positive(&self, lattice: &Lattice, cell: [i32; 3]) -> bool {
        planes::Planes::new(lattice, std::slice::from_ref(self)).is_positive(0, cell)
    }
}

/// A broken joint of a lattice: the face between a cell and the next cell along an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct BrokenJoint {
    /// Index of the cell, in [`Lattice::cells`].
    pub cell: u32,
    /// Axis, 0 to 2.
    pub axis: u8,
    /// Index of the crack that broke the joint. The cells should be on opposite sides of its plane, by
    /// [`CrackPlane::is_positive`]; otherwise the pieces are still closed, but the cut is not smooth there.
    pub crack: u32,
}

/// Shape of the surface of a cut.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CutSurface {
    /// The plane of the crack, nearly.
    #[default]
    Smooth,
    /// The faces of the cells.
    Cells,
}

impl CutSurface {
    /// All values with their names, as in a scene file.
    pub const NAMED: [(&'static str, Self); 2] = [("smooth", Self::Smooth), ("cells", Self::Cells)];

    /// Returns the name of the value in [`CutSurface::NAMED`].
    pub fn name(self) -> &'static str {
        Self::NAMED[self as usize].0
    }
}

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

/// Cuts a mesh along the broken joints of its lattice.
///
/// Each broken joint is a face between two cells. The mesh is cut along these faces, or near the planes of their
/// cracks, and both sides of the cut get a cap. Faces away from the cut keep their corners. The pieces of a closed mesh
/// are closed, and the sum of their volumes is the volume of the mesh. Where only a part of a plane is broken, the two
/// sides share the vertices at the front of the crack.
///
/// * `joints`: broken joints in ascending order.
/// * `cracks`: the plane of each crack.
///
/// # Errors
/// If the result has more vertices or corners than a mesh can have.
///
/// # Panics
/// If a joint refers to a cell, an axis or a crack that does not exist.
pub fn cut(
    mesh: &Mesh,
    lattice: &Lattice,
    joints: &[BrokenJoint],
    cracks: &[CrackPlane],
    surface: CutSurface,
) -> Result<CutMesh, MeshError> {
    let planes = planes::Planes::new(lattice, cracks);
    let faces = faces::BrokenFaces::new(lattice, joints, &planes, surface);
    let input = Input { mesh, lattice, cracks, planes: &planes, faces: &faces, surface };
    let mut clipped = clip::Clipped::new(&input, space::Space::new(&input));
    let caps = cap::Caps::new(&input, &mut clipped);
    assemble::assemble(&input, &clipped, &caps)
}

/// The mesh, the lattice and the cracks.
struct Input<'a> {
    mesh: &'a Mesh,
    lattice: &'a Lattice,
    cracks: &'a [CrackPlane],
    planes: &'a planes::Planes,
    faces: &'a faces::BrokenFaces,
    surface: CutSurface,
}
