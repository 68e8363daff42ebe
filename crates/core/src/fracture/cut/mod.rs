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
//! * `input`: the mesh, the lattice, the cracks and the broken faces.
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
mod input;
mod map;
mod planes;
mod points;
mod refine;
mod space;
mod winding;

pub use assemble::{CutMesh, FaceSource, Origin};
pub use faces::{BrokenJoint, CutSurface};
pub use planes::CrackPlane;

use input::Input;

use crate::lattice::Lattice;
use crate::mesh::{Mesh, MeshError};

/// Cuts a mesh along the broken joints of its lattice.
///
/// Each broken joint is a face between two cells. The mesh is cut along these faces, or the planes of their
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
