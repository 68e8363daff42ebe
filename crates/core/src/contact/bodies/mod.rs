//! Contact between bodies, and of a body with itself.
//!
//! A step runs these parts after the integration of the positions:
//!
//! 1. The bodies whose boxes overlap are paired. Their pins and handles are applied, and their
//!    contacts with colliders found.
//! 2. The samples of each body of a pair are searched in the other one, several times in a step if they move fast.
//! 3. Bodies that touch form islands. The impulses of an island are computed together, including its contacts with
//!    colliders.
//! 4. Each body applies its part of the result.
//!
//! | file | content |
//! |---|---|
//! | `surface` | the surface of a body at rest: its triangles and samples |
//! | `view` | the data of a body that are read |
//! | `bounds`, `grid`, `deformed_cell` | axis-aligned boxes, a grid of them, and the geometry of one deformed cell |
//! | `motion` | boxes of the motion of the parts of a body |
//! | `posed` | the deformed lattice at one time; the cell that contains a point |
//! | `rest_distance` | bounds of the distance of points from a surface at rest |
//! | `touched_point` | the point of a surface at rest that a sample touches |
//! | `joined_cells` | the cells of a body that a cell of it can touch |
//! | `near_cells` | the cells of a body that may touch other cells of the body |
//! | `search` | the samples of a body that touch another one |
//! | `island` | the contact problem of bodies that touch each other |
//! | `pair_contacts` | adds the contacts between bodies to it |
//! | `filter` | which bodies touch each other |
//! | `pairing` | finds the bodies that may touch in a step |
//! | `contacts` | [`BodyContacts`]: runs the parts of a step |
//! | `patch` | a lower bound of the gaps between groups of samples |
//! | `gaps` | the gaps between a body and those around it, which limit the displayed surface |

mod bounds;
mod contacts;
mod deformed_cell;
mod filter;
mod gaps;
mod grid;
mod island;
mod joined_cells;
mod motion;
mod near_cells;
mod pair_contacts;
mod pairing;
mod patch;
mod posed;
mod rest_distance;
mod search;
mod surface;
mod touched_point;
mod view;

pub(crate) use self::bounds::Bounds;
pub(crate) use self::contacts::{BodyContactPart, BodyContacts, TouchingBody};
pub(crate) use self::filter::{ContactFilter, ContactKind};
pub(crate) use self::gaps::{Gap, GapSearch};
pub(crate) use self::island::Island;
pub(crate) use self::motion::PartVertices;
pub(crate) use self::pair_contacts::mean_friction;
pub(crate) use self::pairing::SEARCH_DISTANCE;
pub(crate) use self::surface::{ContactSurface, SIDES, side};
pub(crate) use self::view::{BodyContact, BodyView, ContactStep, MomentumChange, SurfaceProperties};
