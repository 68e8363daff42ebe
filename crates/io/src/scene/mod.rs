//! Scenes: what a user describes, read from TOML or made for a model alone.
//!
//! ```text
//! scene.toml -> value (with its lines) -> overrides -> field, by the keys of data and keys -> Scene (plain data)
//! model.obj  -> Scene -> its TOML text -> the same way
//! ```
//!
//! [`Scene`] holds every default, so that what runs never asks again; [`Scene::to_toml`] writes it back.

mod data;
mod error;
mod field;
mod keys;
mod model;
mod overrides;
mod read;
mod value;
mod write;

pub use data::{BodyData, OutputData, Scene, SimulationData, Substeps, body_keys};
pub use error::{Place, SceneError};
pub use field::nearest;
pub use keys::ALTERNATIVES;
pub use model::Up;
