//! Scenes, read from TOML or generated for a model without a scene.
//!
//! ```text
//! scene.toml -> value (with lines) -> overrides -> field (keys from data and keys) -> Scene (plain data)
//! model.obj  -> Scene -> its TOML text -> the same steps
//! ```
//!
//! [`Scene`] contains every default, so that a run needs no others. [`Scene::to_toml`] writes it back.

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
