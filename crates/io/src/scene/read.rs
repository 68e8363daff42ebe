//! From a text to a scene: parsed, changed by overrides, read, and checked where keys depend on each other.

use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::data::{BodyData, Scene};
use super::error::{Place, SceneError};
use super::field::Field;
use super::keys::{meaning, name_from};
use super::{overrides, value};
use supple::{Key, Selection, TimeWindow};

impl Scene {
    /// Reads a scene file.
    ///
    /// # Errors
    ///
    /// If the file cannot be read, is not TOML, or says what no scene can say; see [`SceneError`].
    pub fn read(path: impl AsRef<Path>) -> Result<Self, SceneError> {
        Self::read_with(path, &[])
    }

    /// Reads a scene file and changes it by overrides, `KEY=VALUE`, before it is checked.
    ///
    /// `KEY` is a path of keys: `simulation.frames`, `body.bust.half_width`, `collider.0.friction`
    /// (bodies by name, all other lists by number from 0). `VALUE` is TOML; a word that is no TOML
    /// value is a text. An override takes the place of the other way to say the same thing.
    ///
    /// # Errors
    ///
    /// As [`Scene::read`], and if a key leads nowhere.
    pub fn read_with(path: impl AsRef<Path>, overrides: &[String]) -> Result<Self, SceneError> {
        let path = path.as_ref();
        let read = |source| SceneError::Read { path: path.to_owned(), source };
        let bytes = std::fs::read(path).map_err(read)?;
        let file = path.to_string_lossy();
        let text = String::from_utf8(bytes).map_err(|error| {
            let line = value::line_of(error.as_bytes(), error.utf8_error().valid_up_to());
            let place = Place::Line { file: file.as_ref().into(), line };
            SceneError::Syntax { place, message: "not valid TOML: the text is not UTF-8".to_owned() }
        })?;
        let base = path.parent().unwrap_or(Path::new(""));
        Self::parse(&text, &file, base, overrides)
    }

    /// Reads a scene from a text. `file` is the name that messages give it, `base` the folder that
    /// its paths are relative to; overrides as in [`Scene::read_with`].
    ///
    /// # Errors
    ///
    /// As [`Scene::read_with`].
    pub fn parse(text: &str, file: &str, base: &Path, overrides: &[String]) -> Result<Self, SceneError> {
        let file: Arc<str> = file.into();
        let mut root = value::parse(text.trim_start_matches('\u{feff}'), &file)?;
        overrides::apply(&mut root, overrides)?;
        let root = Field::root(&root);
        let mut scene: Self = root.read()?;
        scene.base = base.to_owned();
        if scene.bodies.is_empty() {
            return Err(root.missing("body", "a scene needs at least one [[body]] with a `mesh`"));
        }
        let mut names = HashSet::new();
        for (index, body) in scene.bodies.iter_mut().enumerate() {
            let field = root.at(&format!("body.{index}"));
            if body.mesh.as_os_str().is_empty() {
                return Err(field.missing("mesh", meaning("mesh")));
            }
            if body.name.is_empty() {
                body.name = name_from(&body.mesh);
            }
            if !names.insert(body.name.clone()) {
                return Err(field.duplicate(&body.name));
            }
            check_holds(body, &field)?;
        }
        for (index, collider) in scene.colliders.iter().enumerate() {
            check_times(&collider.keys, &root.at(&format!("collider.{index}")))?;
        }
        Ok(scene)
    }

    /// Where a path of the scene leads: absolute as it is, relative to the scene file otherwise.
    pub fn resolve(&self, path: &Path) -> PathBuf {
        self.base.join(path)
    }

    /// Where the frames go by `output.directory`.
    pub fn output_folder(&self) -> PathBuf {
        self.resolve(&self.output.directory)
    }
}

/// Checks boxes, windows and poses of pins and handles.
fn check_holds(body: &BodyData, field: &Field<'_>) -> Result<(), SceneError> {
    let pins = body.pins.iter().enumerate().map(|(index, pin)| {
        let none: &[Key] = &[];
        (format!("pin.{index}"), &pin.selection, pin.window, none)
    });
    let handles = body.handles.iter().enumerate().map(|(index, handle)| {
        (format!("handle.{index}"), &handle.selection, handle.window, &handle.keys[..])
    });
    for (path, selection, TimeWindow { start, end }, keys) in pins.chain(handles) {
        let hold = field.at(&path);
        if let Selection::Box { min, max } = selection
            && (0..3).any(|axis| min[axis] > max[axis])
        {
            return Err(hold.at("box.max").out_of_range("at least `min` on every axis"));
        }
        if end <= start {
            return Err(hold.at("end").out_of_range(&format!("a number above {start}")));
        }
        check_times(keys, &hold)?;
    }
    Ok(())
}

/// Two poses at one time would be a jump, which no speed can follow.
fn check_times(keys: &[Key], field: &Field<'_>) -> Result<(), SceneError> {
    match keys.windows(2).position(|pair| pair[1].time <= pair[0].time) {
        None => Ok(()),
        Some(index) => {
            let range = format!("a number above {}", keys[index].time);
            Err(field.at(&format!("keys.{}.time", index + 1)).out_of_range(&range))
        }
    }
}
