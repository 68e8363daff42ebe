//! Scenes: what a user describes, read from TOML or made for a model alone.
//!
//! ```text
//! scene.toml -> document (values with their lines) -> overrides -> fields checked -> Scene (plain data)
//! model.obj  -> Scene -> its TOML text -> the same way
//! ```
//!
//! [`Scene`] holds every default, so that what runs never asks again; [`Scene::to_toml`] writes it back.

mod body;
mod data;
mod document;
mod error;
mod fields;
mod model;
mod motion;
mod overrides;
mod range;
mod read;
mod write;

pub use data::{BodyData, OutputData, Scene, SimulationData, Substeps};
pub use error::{Place, SceneError};
pub use fields::nearest;
pub use model::Up;
