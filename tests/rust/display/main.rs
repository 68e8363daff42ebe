//! The visible surface: evaluation, untangling, flattening and the smooth skin.

mod evaluate;
mod flatten;
mod smooth_skin;
mod untangle;
