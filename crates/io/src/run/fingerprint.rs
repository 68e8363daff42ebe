//! Computes the fingerprint of a scene: a text with all settings that affect the motion. A run resumes only
//! from a checkpoint with the same fingerprint.

use std::collections::BTreeMap;
use std::path::PathBuf;

use super::error::RunError;
use crate::file;
use crate::frames::Recorder;
use crate::model;
use crate::scene::{OutputData, Scene};

/// Returns the fingerprint of a scene: its TOML text, in which a hash of the bytes of each mesh, with its buffers, and
/// animation replaces its path, and the settings that do not affect the motion (frames, threads, output) have fixed values.
///
/// # Errors
///
/// If a file cannot be read.
pub fn fingerprint(scene: &Scene) -> Result<String, RunError> {
    let mut scene = scene.clone();
    let base = scene.clone();
    // Bodies and colliders can share a file, which is read once.
    let mut hashes: BTreeMap<PathBuf, PathBuf> = BTreeMap::new();
    let mut replace = |file: &mut PathBuf, key: String| {
        let path = base.resolve(file);
        if !hashes.contains_key(&path) {
            let mut recorder = Recorder::default();
            let mut append = |path: PathBuf| {
                let bytes = file::read(&path, u64::MAX);
                let failed = |source| RunError::MeshFile { key: key.clone(), path, source };
                let bytes = bytes.map_err(failed)?;
                recorder.append(&bytes);
                Ok::<_, RunError>(bytes)
            };
            let bytes = append(path.clone())?;
            for buffer in model::buffer_files(&path, &bytes) {
                append(buffer)?;
            }
            hashes.insert(path.clone(), format!("{:016x}", recorder.record().hash).into());
        }
        file.clone_from(&hashes[&path]);
        Ok::<_, RunError>(())
    };
    for body in &mut scene.bodies {
        let name = body.name.clone();
        for (key, file) in body.files_mut() {
            replace(file, format!("body.{name}.{key}"))?;
        }
    }
    for (index, collider) in scene.colliders.iter_mut().enumerate() {
        for (key, file) in collider.files_mut() {
            replace(file, format!("collider.{index}.{key}"))?;
        }
    }
    scene.simulation.frames = 0;
    scene.simulation.threads = 0;
    scene.output = OutputData::default();
    Ok(scene.to_toml())
}

/// Describes the first difference between two fingerprints in a message for the user. Returns `None` if they
/// are equal.
pub fn difference(before: &str, now: &str) -> Option<String> {
    if before == now {
        return None;
    }
    let (mut before, mut now) = (before.lines(), now.lines());
    let mut table = String::new();
    loop {
        let (old, new) = (before.next().unwrap_or_default(), now.next().unwrap_or_default());
        if old != new {
            return Some(match (key(old), key(new)) {
                (Some("mesh"), Some("mesh")) => format!("{table}: the mesh file has changed"),
                (Some("animation"), Some("animation")) | (Some("follow"), Some("follow")) => {
                    format!("{table}: the animation file has changed")
                }
                (None, Some(_)) if old.is_empty() => format!("{table}: `{new}` was added"),
                (Some(_), None) if new.is_empty() => format!("{table}: `{old}` was removed"),
                (Some(_), Some(_)) => format!("{table}: `{old}` changed to `{new}`"),
                _ => format!("{table}: the bodies, pins, handles or colliders differ"),
            });
        }
        if let Some(name) = new.strip_prefix("name = ") {
            table = format!("[[body]] {name}");
        } else if new.starts_with('[') && !new.starts_with("[[body]]") {
            table = new.to_owned();
        }
    }
}

/// Returns the key of a line `key = value`.
fn key(line: &str) -> Option<&str> {
    line.split_once(" = ").map(|(key, _)| key)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "[simulation]\nfps = 30.0\n\n[[body]]\nname = \"a\"\nmesh = \"00\"\nhalf_width = 2\n";

    #[test]
    fn difference_names_the_table_and_the_values() {
        assert_eq!(difference(TEXT, TEXT), None);
        for (from, to, words) in [
            ("fps = 30.0", "fps = 25.0", "[simulation]: `fps = 30.0` changed to `fps = 25.0`"),
            ("\"00\"", "\"01\"", "[[body]] \"a\": the mesh file has changed"),
            ("half_width = 2", "half_width = 3", "\"a\": `half_width = 2` changed to `half_width = 3`"),
            ("half_width = 2\n", "half_width = 2\n\n[[collider]]\n", "colliders differ"),
            (
                "half_width = 2\n",
                "half_width = 2\nself_contact = true\n",
                "\"a\": `self_contact = true` was added",
            ),
            ("half_width = 2\n", "", "\"a\": `half_width = 2` was removed"),
        ] {
            let difference = difference(TEXT, &TEXT.replace(from, to)).unwrap();
            assert!(difference.contains(words), "{difference}");
        }
        assert!(difference(TEXT, "").is_some() && difference("", TEXT).is_some());
    }
}
