//! Flattens the displayed surface of a body where it is pressed onto colliders.
//!
//! The regions of the lattice resist bending at wavelengths below twice their size, so that a pressed surface touches a plane
//! at few points only. The stage moves lattice vertices such that the mesh vertices near a collider come closer to it, the
//! more so the more the lattice is compressed there along the normal. Where it is not compressed, nothing moves. All is
//! continuous in the positions of the lattice, so that nothing jumps when a contact begins or ends.
//!
//! | file | content |
//! |---|---|
//! | `table` | the tables of a body: normals, stencils and weights |
//! | `approach` | by how much a point comes closer to a collider |
//! | `least_squares` | the displacements of lattice vertices that move mesh vertices by given displacements |
//! | `flattener` | the stage |

mod approach;
mod flattener;
mod least_squares;
mod table;

pub(crate) use flattener::Flattener;
pub(crate) use table::FlattenTable;
