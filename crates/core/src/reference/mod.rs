//! The method in its naive form: plain sums in f64, slow and readable. The oracle of the tests and of the error report.
//!
//! Everything here is a function of the lattice and of positions in the units of its cell size, and costs of the order of
//! `(2 w + 1)^3` for each lattice vertex. [`Naive`] keeps what does not change from one call to the next.

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
