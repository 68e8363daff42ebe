//! Reads a scene: parses the text, applies overrides, deserializes the values, and checks values that depend
//! on each other.

use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::collider::ColliderData;
use super::data::{BodyData, Scene};
use super::error::{Place, SceneError};
use super::field::Field;
use super::keys::hint_for;
use super::name::name_from;
use super::value::PATHS;
use super::vertices_file::VertexFile;
use super::{overrides, value, vertices_file};
use crate::file;
use supple::{Key, Preservation, Selection, TimeWindow};

/// Largest size of a scene file in bytes. Parsing takes up to 130 bytes of memory for each byte of the file.
/// A list of a million vertices has 8 MB.
const MAX_SIZE: u64 = 32 << 20;

impl Scene {
    /// Reads a scene file.
    ///
    /// # Errors
    ///
    /// If the file cannot be read, is not a regular file of at most 32 MiB, is not TOML, or is not a valid scene; see
    /// [`SceneError`].
    pub fn read(path: impl AsRef<Path>) -> Result<Self, SceneError> {
        Self::read_with(path, &[])
    }

    /// Reads a scene file, and applies overrides of the form `KEY=VALUE` before the scene is checked.
    ///
    /// `KEY` is a path of keys, such as `simulation.frames`, `body.bust.half_width` or `collider.0.friction`.
    /// A list element is named by its name or by its index from 0. `VALUE` is TOML; text that is not TOML is
    /// read as a string. An override replaces the exclusive alternative of its key; see
    /// [`exclusive_keys`](super::exclusive_keys).
    ///
    /// # Errors
    ///
    /// As [`Scene::read`]. Also if an override is not of the form `KEY=VALUE`, or if its key does not exist.
    pub fn read_with(path: impl AsRef<Path>, overrides: &[String]) -> Result<Self, SceneError> {
        let path = path.as_ref();
        let read = |source| SceneError::Read { path: path.to_owned(), source };
        let bytes = file::read(path, MAX_SIZE).map_err(read)?;
        let file = path.to_string_lossy();
        if let [0xff, 0xfe, ..] | [0xfe, 0xff, ..] = bytes[..] {
            let place = Place::Line { file: file.as_ref().into(), line: 1 };
            let message = "the text is UTF-16, and TOML is UTF-8; save it as UTF-8".to_owned();
            return Err(SceneError::Syntax { place, message });
        }
        let text = String::from_utf8(bytes).map_err(|error| {
            let line = value::Lines::new(error.as_bytes()).line_of(error.utf8_error().valid_up_to());
            let place = Place::Line { file: file.as_ref().into(), line };
            SceneError::Syntax { place, message: "not valid TOML: the text is not UTF-8".to_owned() }
        })?;
        let base = path.parent().unwrap_or(Path::new(""));
        Self::parse(&text, &file, base, overrides)
    }

    /// Reads a scene from text, and the files of `vertices_file`. Error messages name the text `file`. Paths in the
    /// scene are relative to `base`. `overrides` are as in [`Scene::read_with`].
    ///
    /// # Errors
    ///
    /// As [`Scene::read_with`].
    pub fn parse(text: &str, file: &str, base: &Path, overrides: &[String]) -> Result<Self, SceneError> {
        let file: Arc<str> = file.into();
        let mut root = value::parse(text.trim_start_matches('\u{feff}'), &file)?;
        overrides::apply(&mut root, overrides)?;
        let vertex_files = vertices_file::read_all(&mut root, base)?;
        let root = Field::root(&root);
        let mut scene: Self = root.read()?;
        scene.base = base.to_owned();
        scene.vertex_files = vertex_files;
        if scene.bodies.is_empty() {
            return Err(root.missing("body", "a scene needs at least one [[body]] with a `mesh`"));
        }
        let mut names = HashSet::new();
        for (index, body) in scene.bodies.iter_mut().enumerate() {
            let field = root.at(&format!("body.{index}"));
            if body.mesh.as_os_str().is_empty() {
                return Err(field.missing("mesh", hint_for("mesh")));
            }
            if body.name.is_empty() {
                body.name = name_from(&body.mesh);
            }
            if !names.insert(body.name.clone()) {
                return Err(field.duplicate(&body.name));
            }
            if body.rigid && matches!(body.volume.measure, Preservation::By(_)) {
                return Err(field.exclusive("volume", "rigid"));
            }
            check_parts(body, &field)?;
            check_paths(body.files_mut().map(|(key, path)| (key, &*path)), &field)?;
        }
        check_ignored(&scene.bodies, &root)?;
        check_fields(&scene, &root)?;
        check_links(&scene, &root)?;
        check_paths([("output.directory".to_owned(), &scene.output.directory)], &root)?;
        for (index, collider) in scene.colliders.iter_mut().enumerate() {
            let field = root.at(&format!("collider.{index}"));
            check_paths(collider.files_mut().map(|(key, path)| (key.to_owned(), &*path)), &field)?;
            if let Some(key) = collider.key_of_mesh() {
                return Err(field.at(key).out_of_range("left out, because only `mesh` has it"));
            }
            check_times(&collider.keys, &field)?;
        }
        Ok(scene)
    }

    /// Returns [`Scene::base`] joined with a path of the scene. An absolute path is unchanged.
    pub fn resolve(&self, path: &Path) -> PathBuf {
        self.base.join(path)
    }

    /// Returns the line of a `vertices_file` with a vertex. `table`: key of the selection, with indices.
    pub(crate) fn line_of_vertex(&self, table: &str, vertex: u32) -> Option<Place> {
        VertexFile::place(&self.vertex_files, table, vertex)
    }

    /// Returns the input files of the scene: meshes, animations and lists of vertices. An absolute path is unchanged,
    /// and others are resolved.
    pub(crate) fn files(&self) -> Vec<PathBuf> {
        let mut scene = self.clone();
        let bodies = scene.bodies.iter_mut().flat_map(BodyData::files_mut).map(|(_, path)| path);
        let colliders = scene.colliders.iter_mut().flat_map(ColliderData::files_mut).map(|(_, path)| path);
        let vertices = self.vertex_files.iter().map(|file| file.path.clone());
        bodies.chain(colliders).map(|path| self.resolve(path)).chain(vertices).collect()
    }

    /// Returns the directory of the frames: the resolved `output.directory`.
    pub fn output_directory(&self) -> PathBuf {
        self.resolve(&self.output.directory)
    }
}

/// Checks that no path has a control character: in double quotes, TOML reads `C:\temp` as `C:`, a tab, `emp`.
fn check_paths<'a>(
    paths: impl IntoIterator<Item = (String, &'a PathBuf)>,
    table: &Field<'_>,
) -> Result<(), SceneError> {
    let has_control = |path: &Path| path.to_string_lossy().chars().any(char::is_control);
    match paths.into_iter().find(|(_, path)| has_control(path)) {
        Some((key, _)) => {
            Err(table.at(&key).out_of_range(&format!("a path without control characters; {PATHS}")))
        }
        None => Ok(()),
    }
}

/// Checks that `bodies` has a body with this name, which is not `own`.
fn check_other(name: &str, own: Option<&str>, bodies: &[BodyData], at: &Field<'_>) -> Result<(), SceneError> {
    if own != Some(name) && bodies.iter().any(|body| body.name == name) {
        return Ok(());
    }
    let names: Vec<&str> = bodies.iter().map(|body| body.name.as_str()).collect();
    Err(at.no_other_body(name, own.unwrap_or_default(), &names))
}

/// Checks that the bodies that a body does not touch are other bodies of the scene.
fn check_ignored(bodies: &[BodyData], root: &Field<'_>) -> Result<(), SceneError> {
    for (index, body) in bodies.iter().enumerate() {
        for (entry, name) in body.touching.ignored.iter().enumerate() {
            check_other(name, Some(&body.name), bodies, &root.at(&format!("body.{index}.ignore.{entry}")))?;
        }
    }
    Ok(())
}

/// Checks the shapes of fields, and that the bodies on which they act exist.
fn check_fields(scene: &Scene, root: &Field<'_>) -> Result<(), SceneError> {
    for (index, field) in scene.fields.iter().enumerate() {
        let place = root.at(&format!("field.{index}"));
        for (entry, name) in field.bodies.iter().enumerate() {
            check_other(name, None, &scene.bodies, &place.at(&format!("bodies.{entry}")))?;
        }
        if let Some(shape) = &field.within {
            check_box(shape, &place)?;
        }
    }
    Ok(())
}

/// Checks the shapes of links, and that the bodies that they join exist and differ.
fn check_links(scene: &Scene, root: &Field<'_>) -> Result<(), SceneError> {
    for (index, link) in scene.links.iter().enumerate() {
        let place = root.at(&format!("link.{index}"));
        check_other(&link.body, None, &scene.bodies, &place.at("body"))?;
        if let Some(other) = &link.other {
            check_other(other, Some(&link.body), &scene.bodies, &place.at("other"))?;
        }
        check_box(&link.selection, &place)?;
    }
    Ok(())
}

/// Checks the boxes of zones, the boxes, time windows and keyframe times of pins and handles, and the motions of
/// handles.
fn check_parts(body: &BodyData, field: &Field<'_>) -> Result<(), SceneError> {
    for (index, zone) in body.zones.iter().enumerate() {
        let field = field.at(&format!("zone.{index}"));
        check_box(&zone.selection, &field)?;
        if zone.factor == 0.0 {
            return Err(field.missing("factor", hint_for("factor")));
        }
    }
    let pins = body.pins.iter().enumerate().map(|(index, pin)| {
        let no_keys: &[Key] = &[];
        (format!("pin.{index}"), &pin.selection, pin.window, no_keys)
    });
    for (index, handle) in body.handles.iter().enumerate() {
        handle.check(&field.at(&format!("handle.{index}")))?;
    }
    let handles = body.handles.iter().enumerate().map(|(index, handle)| {
        (format!("handle.{index}"), &handle.selection, handle.window, &handle.keys[..])
    });
    for (path, selection, TimeWindow { start, end }, keys) in pins.chain(handles) {
        let constraint = field.at(&path);
        check_box(selection, &constraint)?;
        if end <= start {
            return Err(constraint.at("end").out_of_range(&format!("a number above {start}")));
        }
        check_times(keys, &constraint)?;
    }
    Ok(())
}

/// Checks that a selected box is not empty.
fn check_box(selection: &Selection, field: &Field<'_>) -> Result<(), SceneError> {
    match selection {
        Selection::Box { min, max } if (0..3).any(|axis| min[axis] > max[axis]) => {
            let [x, y, z] = min;
            let range = format!("at least `min`, which is [{x}, {y}, {z}], on every axis");
            Err(field.at("box.max").out_of_range(&range))
        }
        _ => Ok(()),
    }
}

/// Checks that the times of keyframes increase, because two keyframes at the same time would mean infinite
/// speed.
fn check_times(keys: &[Key], field: &Field<'_>) -> Result<(), SceneError> {
    match keys.windows(2).position(|pair| pair[1].time <= pair[0].time) {
        None => Ok(()),
        Some(index) => {
            let range = format!("a number above {}", keys[index].time);
            Err(field.at(&format!("keys.{}.time", index + 1)).out_of_range(&range))
        }
    }
}
