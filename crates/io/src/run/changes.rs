//! Compares the scene of a kept state with the present one: which changes a run from the state can make, and what they
//! replace in it.
//!
//! | keys | after a change |
//! |---|---|
//! | gravity, substeps, contact, sleep, time scale; colliders, but not their number; fields | the simulation is built with them |
//! | material, zones, `inflate`, volume options, pins, handles of a body | replace those of the state |
//! | friction, restitution, rolling resistance, `ignore`, `self_contact` of a body | the body is built with them |
//! | all others | cannot change: the state has positions that were computed with them |

use supple::AdoptedSettings;
use toml::{Table, Value};

use crate::scene::{material_keys, touching_keys};

/// Keys of `[simulation]` that can change.
const SIMULATION: [&str; 6] = ["gravity", "substeps", "contact", "self_contact", "sleep", "time_scale"];

/// The changes of a scene since a state was kept.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Changes {
    /// Whether any key has changed.
    pub(super) any: bool,
    /// Whether the colliders have changed.
    pub(super) colliders: bool,
    /// The settings of each body that have changed.
    pub(super) bodies: Vec<AdoptedSettings>,
}

impl Changes {
    /// Returns the changes between two [fingerprints](super::fingerprint()).
    ///
    /// # Errors
    ///
    /// A change that a run from a state cannot make, as a part of a message.
    pub(super) fn between(before: &str, now: &str) -> Result<Self, String> {
        let parse =
            |text: &str| text.parse::<Table>().map_err(|error| format!("its scene is invalid: {error}"));
        let (before, now) = (parse(before)?, parse(now)?);
        let list = |scene: &Table, key: &str| -> Vec<Value> {
            scene.get(key).and_then(Value::as_array).cloned().unwrap_or_default()
        };
        let bodies = [&before, &now].map(|scene| list(scene, "body"));
        if let [before, now] = bodies.each_ref().map(Vec::len)
            && before != now
        {
            return Err(format!("the number of `[[body]]` changed from {before} to {now}"));
        }
        let colliders = [&before, &now].map(|scene| list(scene, "collider").len());
        if let [before, now] = colliders
            && before != now
        {
            return Err(format!("the number of `[[collider]]` changed from {before} to {now}"));
        }
        let mut changes = Self::default();
        for key in keys(&before, &now) {
            match key {
                "body" => {}
                "simulation" => {
                    let tables = [&before, &now].map(|scene| table(scene.get(key)));
                    for (key, before, now) in differences(tables.each_ref()) {
                        if !SIMULATION.contains(&key) {
                            return Err(changed(&format!("simulation.{key}"), before, now));
                        }
                        changes.any = true;
                    }
                }
                "collider" => changes.colliders = before.get(key) != now.get(key),
                "field" => changes.any |= before.get(key) != now.get(key),
                _ if before.get(key) != now.get(key) => {
                    return Err(changed(key, before.get(key), now.get(key)));
                }
                _ => {}
            }
        }
        let [before, now] = bodies;
        for (index, tables) in before.iter().zip(&now).map(|(before, now)| [before, now]).enumerate() {
            let tables = tables.map(|body| table(Some(body)));
            changes.any |= tables[0] != tables[1];
            changes.bodies.push(body_changes(index, &tables)?);
        }
        changes.any |= changes.colliders;
        Ok(changes)
    }
}

/// Returns the settings of a body that have changed from its first table to its second.
fn body_changes(index: usize, tables: &[Table; 2]) -> Result<AdoptedSettings, String> {
    let [before, now] = tables.each_ref().map(|body| body.get("name"));
    if before != now {
        return Err(changed(&format!("body.{index}.name"), before, now));
    }
    let full = |key: &str| format!("body.{}.{key}", now.and_then(Value::as_str).unwrap_or_default());
    let mut settings = AdoptedSettings::default();
    for (key, before, now) in differences(tables.each_ref()) {
        match key {
            "volume" => settings.volume = true,
            "inflate" => settings.inflation = true,
            "zone" => (settings.material, settings.inflation) = (true, true),
            "pin" | "handle" => settings.constraints = true,
            // Both states have plastic shapes, or both have none, unless one material is plastic.
            key if material_keys().contains(&key) => settings.material = true,
            // The keyframes of the friction are those of the material.
            "friction" => {
                let is_keyed = |value: &&Value| value.is_array() || value.is_table();
                settings.material |= [before, now].into_iter().flatten().any(|value| is_keyed(&value));
            }
            key if touching_keys().contains(&key) => {}
            "mesh" => return Err(format!("`{}`: the mesh file has changed", full(key))),
            key => return Err(changed(&full(key), before, now)),
        }
    }
    Ok(settings)
}

/// Returns a table, which is empty if the value is missing.
fn table(value: Option<&Value>) -> Table {
    value.and_then(Value::as_table).cloned().unwrap_or_default()
}

/// Returns the keys of two tables, each once.
fn keys<'a>(before: &'a Table, now: &'a Table) -> impl Iterator<Item = &'a str> {
    let added = now.keys().filter(|key| !before.contains_key(*key));
    before.keys().chain(added).map(String::as_str)
}

/// Returns the keys of two tables whose values differ, with the values.
fn differences([before, now]: [&Table; 2]) -> impl Iterator<Item = (&str, Option<&Value>, Option<&Value>)> {
    let entries = keys(before, now).map(|key| (key, before.get(key), now.get(key)));
    entries.filter(|(_, before, now)| before != now)
}

/// Describes the change of a key that cannot change.
fn changed(key: &str, before: Option<&Value>, now: Option<&Value>) -> String {
    match (before, now) {
        (Some(before), Some(now)) => format!("`{key}` changed from {before} to {now}"),
        (Some(before), None) => format!("`{key} = {before}` was removed"),
        (None, Some(now)) => format!("`{key} = {now}` was added"),
        (None, None) => format!("`{key}` changed"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCENE: &str = r#"
        [simulation]
        fps = 30.0
        gravity = [0.0, -9.81, 0.0]
        [[body]]
        name = "a"
        mesh = "00"
        half_width = 2
        friction = 0.5
        volume = { measure = "auto" }
        [[body.handle]]
        keys = [{ time = 0.0 }]
        [[collider]]
        friction = 0.5
    "#;

    fn between(from: &str, to: &str) -> Result<Changes, String> {
        assert!(SCENE.contains(from));
        Changes::between(SCENE, &SCENE.replace(from, to))
    }

    #[test]
    fn a_change_is_of_the_settings_that_a_state_contains() {
        assert_eq!(
            between("", "").unwrap(),
            Changes { bodies: vec![AdoptedSettings::default()], ..Changes::default() }
        );
        let adopted = |from, to| {
            let Changes { any, bodies, .. } = between(from, to).unwrap();
            let AdoptedSettings { material, volume, inflation, constraints, .. } = bodies[0];
            assert!(any, "{to}");
            [material, volume, inflation, constraints]
        };
        assert_eq!(adopted("-9.81", "-1.0"), [false; 4]);
        assert_eq!(
            adopted("[[collider]]\n        friction = 0.5", "[[collider]]\n        friction = 0.1"),
            [false; 4]
        );
        assert_eq!(adopted("friction = 0.5\n        volume", "friction = 0.1\n        volume"), [false; 4]);
        let keyed = "friction = [{ time = 0, value = 0.5 }, { time = 1, value = 0 }]\n        volume";
        assert_eq!(adopted("friction = 0.5\n        volume", keyed), [true, false, false, false]);
        assert_eq!(adopted("half_width = 2", "half_width = 3"), [true, false, false, false]);
        assert_eq!(adopted("half_width = 2", "youngs_modulus = 1e5"), [true, false, false, false]);
        assert_eq!(adopted("\"auto\"", "\"mesh\""), [false, true, false, false]);
        assert_eq!(
            adopted("friction = 0.5\n        volume", "inflate = 2\n        volume"),
            [false, false, true, false]
        );
        assert_eq!(adopted("time = 0.0", "time = 1.0"), [false, false, false, true]);
        assert_eq!(
            adopted("[[body.handle]]", "[[body.zone]]\nfactor = 2\n[[body.handle]]"),
            [true, false, true, false]
        );
    }

    #[test]
    fn a_change_of_the_shape_of_a_body_or_of_the_frames_is_refused_with_its_key() {
        for (from, to, words) in [
            ("fps = 30.0", "fps = 25.0", "`simulation.fps` changed from 30.0 to 25.0"),
            ("\"a\"", "\"b\"", "`body.0.name` changed from \"a\" to \"b\""),
            ("\"00\"", "\"01\"", "`body.a.mesh`: the mesh file has changed"),
            ("half_width = 2", "half_width = 2\ncell_size = 0.1", "`body.a.cell_size = 0.1` was added"),
            ("half_width = 2", "half_width = 2\n[body.fracture]\nstrain = 0.1", "`body.a.fracture = "),
            ("[[collider]]\n        friction = 0.5", "", "the number of `[[collider]]` changed from 1 to 0"),
            ("[[collider]]", "[[body]]\n[[collider]]", "the number of `[[body]]` changed from 1 to 2"),
            ("[[collider]]", "[[link]]\n[[collider]]", "`link = "),
        ] {
            let refusal = between(from, to).unwrap_err();
            assert!(refusal.contains(words), "{refusal}");
        }
    }
}
