//! From a text to a scene: `[simulation]`, `[output]` and the lists of bodies and colliders.

use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::data::{OutputData, Scene, SimulationData, Substeps};
use super::error::{Place, SceneError};
use super::fields::{Field, Fields};
use super::range::Range;
use super::{body, document, motion, overrides};
use crate::frames::Format;

/// The most frames of a run: almost four days at 30 a second.
const MAX_FRAMES: u32 = 10_000_000;
/// The most steps of a frame.
const MAX_SUBSTEPS: u32 = 100_000;
/// The most threads: more than machines have, and less than systems refuse.
const MAX_THREADS: u32 = 1024;

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
            let valid = error.utf8_error().valid_up_to();
            let line = 1 + error.as_bytes()[..valid].iter().filter(|&&byte| byte == b'\n').count();
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
        let mut root = document::parse(text.trim_start_matches('\u{feff}'), &file)?;
        overrides::apply(&mut root, overrides)?;
        let root = Field::root(&root);
        let fields = Fields::new(&root, &["simulation", "output", "body", "collider"])?;

        let simulation = read_simulation(fields.get("simulation"))?;
        let output = read_output(fields.get("output"))?;
        let tables = fields.tables("body")?;
        if tables.is_empty() {
            return Err(fields.missing("body", "a scene needs at least one [[body]] with a `mesh`"));
        }
        let bodies = tables.iter().map(body::read).collect::<Result<Vec<_>, _>>()?;
        let mut names = HashSet::new();
        for (table, body) in tables.iter().zip(&bodies) {
            if !names.insert(body.name.as_str()) {
                let place = table.place().clone();
                return Err(SceneError::DuplicateName { place, name: body.name.clone() });
            }
        }
        let colliders =
            fields.tables("collider")?.iter().map(motion::read_collider).collect::<Result<_, _>>()?;
        Ok(Self { base: base.to_owned(), simulation, output, bodies, colliders })
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

fn read_simulation(field: Option<Field<'_>>) -> Result<SimulationData, SceneError> {
    let mut data = SimulationData::default();
    let Some(field) = field else { return Ok(data) };
    let fields = Fields::new(&field, &["frames", "fps", "substeps", "gravity", "threads"])?;
    data.frames = fields.read_or("frames", data.frames, |field| field.count(0, MAX_FRAMES))?;
    data.fps = fields.read_or("fps", data.fps, |field| field.number(Range::Positive))?;
    data.substeps = fields.read_or("substeps", data.substeps, read_substeps)?;
    data.gravity = fields.read_or("gravity", data.gravity, Field::vector)?;
    let threads = fields.read_or("threads", 0, |field| field.count(0, MAX_THREADS))?;
    data.threads = threads as usize;
    Ok(data)
}

fn read_substeps(field: &Field<'_>) -> Result<Substeps, SceneError> {
    if field.is_text() {
        return match field.text()? {
            "auto" => Ok(Substeps::Auto),
            _ => Err(field.out_of_range("\"auto\" or a whole number of at least 1")),
        };
    }
    field.count(1, MAX_SUBSTEPS).map(Substeps::Fixed)
}

fn read_output(field: Option<Field<'_>>) -> Result<OutputData, SceneError> {
    let mut data = OutputData::default();
    let Some(field) = field else { return Ok(data) };
    let fields = Fields::new(&field, &["directory", "format"])?;
    if let Some(directory) = fields.get("directory") {
        let text = directory.text()?;
        if text.is_empty() {
            return Err(directory.out_of_range("a folder; write \".\" for that of the scene"));
        }
        data.directory = text.into();
    }
    data.format = fields.read_or("format", data.format, |field| {
        Ok(Format::ALL[field.choice(&Format::ALL.map(Format::name))?])
    })?;
    Ok(data)
}

impl Default for SimulationData {
    fn default() -> Self {
        Self { frames: 240, fps: 30.0, substeps: Substeps::Fixed(2), gravity: [0.0, -9.81, 0.0], threads: 0 }
    }
}

impl Default for OutputData {
    fn default() -> Self {
        Self { directory: "frames".into(), format: Format::default() }
    }
}
