//! Reads scenes from TOML, and generates the scene of a model without a scene.
//!
//! ```text
//! scene.toml -> value: TOML with line numbers -> overrides -> field: deserializes data and keys -> Scene
//! model.obj  -> Scene -> TOML text -> same steps as for scene.toml
//! ```
//!
//! A [`Scene`] is plain data. It contains the default of every key that the file omits. [`Scene::to_toml`]
//! writes it as TOML.

mod collider;
mod data;
mod error;
mod fault;
mod field;
mod handle;
mod keys;
mod model;
mod name;
mod overrides;
mod read;
mod table;
mod value;
mod vertices_file;
mod way_out;
mod write;

pub use crate::space::Up;
pub use collider::{ColliderData, ColliderShape};
pub use data::{BodyData, MAX_SUBSTEPS, OutputData, Scene, SimulationData, Substeps};
pub use error::{Place, SceneError};
pub use field::read_table;
pub use handle::HandleData;
pub use keys::{EnabledTable, FieldTable, GoalTable, LinkTable, exclusive_keys, optional_keys};
pub(crate) use keys::{material_keys, touching_keys};
pub use table::{body_keys, table_keys};
pub use value::{Data, Table, Value};
pub use way_out::{nearest, way_out};
