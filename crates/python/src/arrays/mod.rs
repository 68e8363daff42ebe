//! Numpy arrays: anything array-like in, checked by name; `float64` out, or into the caller's `out`.

mod out;
mod read;
mod write;

pub(crate) use out::{Out, fill};
pub(crate) use read::{Side, floats, integers, is_mask, matrices, matrix, truths, vector, vectors};
pub(crate) use write::{constant_integers, constant_vectors, of_matrices, of_numbers, of_points, of_vectors};
