//! Jobs: resuming, shipped scenes and animations that are followed.

mod follow_scenes;
mod resume;
mod shipped;
