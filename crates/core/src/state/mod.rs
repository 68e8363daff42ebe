//! What a step changes and a checkpoint holds.

mod frame;

pub use frame::{BodyFrame, BodyState, Interval};
