//! Reference implementation of the method: explicit sums in f64, slow and readable. The oracle of the tests
//! and of the error report.
//!
//! Positions are in the length unit of the lattice's cell size. The cost is of the order of `(2 w + 1)^3` per
//! lattice vertex. [`Naive`] keeps the data that repeated calls share.

mod matching;
mod momenta;
mod naive;
mod regions;
mod rotation;

pub use matching::{damped_velocities, goals, rotations};
pub use momenta::{Mass, Momenta};
pub use naive::{Naive, RegionMotion};
pub use regions::{Regions, Weights, region, weights};
pub use rotation::rotation;
