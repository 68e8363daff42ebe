//! Flattens the displayed surface of a body where it is pressed onto planes.
//!
//! The regions of the lattice resist bending at wavelengths below twice their size, so that a pressed surface touches a
//! plane at few points only. The stage moves the mesh vertices near a plane towards it, the more so the more the
//! lattice is compressed there towards the plane. Where it is not compressed, nothing moves. The displacements are
//! continuous functions of the positions of the lattice, so that nothing jumps when a contact begins or ends.
//!
//! The *rank* of a mesh vertex is its index in the order of [`Embedding::by_cell`](crate::lattice::Embedding::by_cell).
//!
//! | file | content |
//! |---|---|
//! | `table` | the tables of a body: ranks, normals, stencils, triangles |
//! | `surroundings` | distances from a plane and their derivatives at the lattice vertices |
//! | `unflattened` | positions and gaps of the mesh vertices before they move |
//! | `approach` | the gap that remains of a gap |
//! | `displacements` | the displacements of the mesh vertices |
//! | `flattener` | the stage |

mod approach;
mod displacements;
mod flattener;
mod surroundings;
mod table;
mod unflattened;

pub(crate) use displacements::{Displacements, FlattenedSurface};
pub(crate) use flattener::Flattener;
pub(crate) use table::FlattenTable;
pub(crate) use unflattened::Unflattened;
