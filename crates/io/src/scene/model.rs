//! Generates the scene of a model without a scene: the model falls onto a ground just below it.

use std::path::{Path, PathBuf};

use super::collider::ColliderData;
use super::data::{BodyData, OutputData, Scene, SimulationData};
use super::error::SceneError;
use super::name::name_from;
use super::write::check_utf8;
use crate::model::{self, ModelError};
use crate::space::Up;

/// Distance from the ground to the model, as a fraction of its height.
const GAP: f64 = 0.1;
/// Time in which a model falls its own height, s.
const FALL_TIME: f64 = 0.5;

impl Scene {
    /// Reads a scene file (`.toml`), or generates the scene of a [`model`] by [`Scene::of_model`]. Then applies
    /// overrides as in [`Scene::read_with`]. `up` applies only to models.
    ///
    /// # Errors
    ///
    /// As [`Scene::read_with`]. Also if a model cannot be read, or if the file is neither a scene nor a model. Only
    /// regular files are read.
    pub fn open(path: impl AsRef<Path>, up: Up, overrides: &[String]) -> Result<Self, SceneError> {
        let path = path.as_ref();
        if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml")) {
            return Self::read_with(path, overrides);
        }
        let other = || SceneError::Kind { path: path.to_owned() };
        if !model::is_model(path) && !path.is_file() {
            return Err(other());
        }
        let mesh = model::read(path, None).map_err(|error| match error {
            ModelError::Unknown { .. } => other(),
            error => error.into(),
        })?;
        let (low, high) = mesh.bounds();
        check_utf8(path)?;
        let scene = Self::of_model(path, low.into(), high.into(), up);
        let name = format!("scene of {}", path.display());
        Self::parse(&scene.to_toml(), &name, &scene.base, overrides)
    }

    /// Returns the scene of a model with the smallest coordinates `low` and the largest coordinates `high`,
    /// in the unit of the file. The model falls onto a ground that is a tenth of its height below it. Gravity
    /// g is chosen so that the model falls its own height h in half a second, the time t: g = 2 h / t^2. Its
    /// volume is preserved.
    ///
    /// Paths are relative to the current directory, so that the scene can be saved there as text. If a model
    /// has no height, such as a flat sheet, its largest extent is used as its height.
    pub fn of_model(path: &Path, low: [f64; 3], high: [f64; 3], up: Up) -> Self {
        let axis = match up {
            Up::Y => 1,
            Up::Z => 2,
        };
        let extent = |axis: usize| high[axis] - low[axis];
        let widest = (0..3).map(extent).fold(0.0, f64::max);
        // A height below a thousandth of the width does not represent the size of the model.
        let height = if extent(axis) > 1e-3 * widest { extent(axis) } else { widest };
        let mut gravity = [0.0; 3];
        gravity[axis] = rounded(-2.0 * height / (FALL_TIME * FALL_TIME), height);
        let mut normal = [0.0; 3];
        normal[axis] = 1.0;
        let mut point = [0.0; 3];
        point[axis] = rounded(low[axis] - GAP * height, height);

        Self {
            base: PathBuf::new(),
            simulation: SimulationData { frames: 90, gravity: gravity.into(), ..SimulationData::default() },
            output: OutputData::default(),
            bodies: vec![BodyData::new(name_from(path), path)],
            colliders: vec![ColliderData::plane(point, normal)],
            fields: Vec::new(),
            links: Vec::new(),
            vertex_files: Vec::new(),
        }
    }
}

/// Rounds `value` to the sixth significant digit of the length `scale`, for readable text.
fn rounded(value: f64, scale: f64) -> f64 {
    let digits = 5 - scale.log10().floor() as i32;
    // Rounds through decimal text, because multiplying by powers of ten would add digits from rounding
    // errors.
    let decimals = digits.clamp(0, 300) as usize;
    format!("{value:.decimals$}").parse().unwrap_or(value)
}
