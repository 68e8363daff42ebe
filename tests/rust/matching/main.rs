//! Regions, window sums, rotations and goal positions, against the naive reference.

mod goals;
mod reference;
mod rotations;
