//! Parts of a scene as tables of keys: which keys they have, and the values that are written.

use serde::Serialize;
use serde_json::{Map, Value};
use supple::{BreakLimit, FractureOptions, Plasticity};

use super::data::BodyData;
use super::keys::{self, FieldTable, LinkTable};

/// The values of a table, in the order of the fields. A table of `toml` that keeps this order takes linear time
/// to remove a key, so that reading many tables would take quadratic time.
pub(super) type Fields = Map<String, Value>;

/// Returns the fields of a part of a scene. The value of a missing option is null.
pub(super) fn fields(part: &impl Serialize) -> Fields {
    // This cannot fail, because every key of a scene is a string.
    let Ok(Value::Object(fields)) = serde_json::to_value(part) else { return Fields::new() };
    fields
}

impl BodyData {
    /// Returns the keys that have a value, in the order of the fields.
    pub fn to_keys(&self) -> Map<String, Value> {
        let mut fields = fields(self);
        leave_out_soft_keys(&mut fields);
        keys_of(fields)
    }
}

impl FieldTable {
    /// Returns the keys that have a value.
    pub fn to_keys(&self) -> Map<String, Value> {
        keys_of(fields(self))
    }
}

impl LinkTable {
    /// Returns the keys that have a value.
    pub fn to_keys(&self) -> Map<String, Value> {
        keys_of(fields(self))
    }
}

/// Leaves out the keys that a rigid body does not have.
pub(super) fn leave_out_soft_keys(body: &mut Fields) {
    if body.get("rigid") == Some(&Value::Bool(true)) {
        let soft = keys::keys_of_soft_bodies();
        body.retain(|key, _| !soft.contains(&key.as_str()));
        if let Some(Value::Object(material)) = body.get_mut("@material") {
            material.retain(|key, _| key == "density");
        }
    }
}

/// Returns the keys of the fields of a part of a scene that have a value, in their order.
fn keys_of(fields: Fields) -> Map<String, Value> {
    flattened(fields).into_iter().filter(|(_, value)| !value.is_null()).collect()
}

/// Replaces each field `@...` by the keys for which it stands. Of two fields with a key, the later one counts.
pub(super) fn flattened(fields: Fields) -> Fields {
    let entries = |(key, value): (String, Value)| match value {
        Value::Object(table) if key.starts_with('@') => flattened(table),
        Value::Object(table) => Fields::from_iter([(key, Value::Object(flattened(table)))]),
        value => Fields::from_iter([(key, value)]),
    };
    fields.into_iter().flat_map(entries).collect()
}

/// Returns the keys of `[[body]]`.
pub fn body_keys() -> Vec<String> {
    expanded(&body_fields())
}

/// Returns the keys of a table of `[[body]]`: of `fracture` or `plastic`. Returns no keys for another name.
pub fn table_keys(table: &str) -> Vec<String> {
    let body = body_fields();
    let of_material = || body.get("@material").and_then(|material| material.get(table));
    match body.get(table).or_else(of_material) {
        Some(Value::Object(fields)) => expanded(fields),
        _ => Vec::new(),
    }
}

/// Returns the fields of a body that has a value for each.
fn body_fields() -> Fields {
    let mut body = BodyData { object: Some(String::new()), ..BodyData::default() };
    let fracture = FractureOptions::new(BreakLimit::Strain(1.0));
    body.fracture = Some(FractureOptions { rotation: Some(90.0), ..fracture });
    body.material.damping = Some(body.material.damping());
    body.material.plastic = Some(Plasticity::default());
    fields(&body)
}

/// Returns the scene keys of some fields.
fn expanded(fields: &Fields) -> Vec<String> {
    let fields: Vec<&str> = fields.keys().map(String::as_str).collect();
    let mut keys = Vec::<String>::new();
    for key in keys::expand(&fields) {
        // Two fields may read a key.
        if !keys.iter().any(|known| known == key) {
            keys.push(key.to_owned());
        }
    }
    keys
}
