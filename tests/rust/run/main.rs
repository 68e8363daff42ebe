//! Jobs: resuming, shipped scenes and animations that are followed.

mod bits;
mod cautions;
mod continuation;
mod cube;
mod follow_scenes;
mod pace;
mod resume;
mod shaped_inputs;
mod shipped;
