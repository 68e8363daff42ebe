//! Reference implementation of the method: explicit sums in f64, slow and readable. The tests and the error
//! report compare the fast implementation with it.
//!
//! Positions are in the length unit of the lattice's cell size. The cost per lattice vertex is of the order
//! of `(2 w + 1)^3`, where w is the half-width of the regions in cells. [`Naive`] stores the data that
//! repeated calls need.

mod energy;
mod fracture;
mod matching;
mod momenta;
mod naive;
mod plastic;
mod region_motion;
mod regions;
mod rotation;

pub use fracture::joint_strains;
pub use matching::{damped_velocities, goals, rotations};
pub use momenta::{Mass, Momenta};
pub use naive::Naive;
use plastic::flowed;
pub use region_motion::RegionMotion;
pub use regions::{Regions, Weights, region, weights};
pub use rotation::rotation;
