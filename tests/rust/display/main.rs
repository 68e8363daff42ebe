//! The visible surface: evaluation, untangling and the smooth skin.

mod evaluate;
mod pressed;
mod smooth_skin;
mod untangle;
