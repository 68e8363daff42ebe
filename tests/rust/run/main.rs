//! Jobs: resuming, shipped scenes and animations that are followed.

mod cautions;
mod follow_scenes;
mod resume;
mod shaped_inputs;
mod shipped;
