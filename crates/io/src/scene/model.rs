//! The scene that a model alone means: dropped on a ground just below it.

use std::path::Path;

use super::data::{BodyData, OutputData, Scene, SimulationData, Substeps};
use super::error::SceneError;
use super::keys::name_from;
use supple::{Collider, RegionDamping};

/// Which axis of a model points up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Up {
    /// y, as most programs for characters have it.
    #[default]
    Y,
    /// z, as most programs for engineering have it.
    Z,
}

/// The ground lies this fraction of the height below the model.
const GAP: f64 = 0.1;
/// Seconds in which a model falls its own height.
const FALL: f64 = 0.5;

impl Scene {
    /// Opens an input: a scene file (`.toml`), or a model (`.obj`) as the scene that it means alone. Both are
    /// changed by overrides, as in [`Scene::read_with`].
    ///
    /// # Errors
    ///
    /// As [`Scene::read_with`]; a model that cannot be read; a file that is neither.
    pub fn open(path: impl AsRef<Path>, up: Up, overrides: &[String]) -> Result<Self, SceneError> {
        let path = path.as_ref();
        let extension = path.extension().and_then(|extension| extension.to_str()).unwrap_or_default();
        match extension.to_ascii_lowercase().as_str() {
            "toml" => Self::read_with(path, overrides),
            "obj" => {
                let (low, high) = crate::obj::read(path)?.bounds();
                let scene = Self::of_model(path, low.into(), high.into(), up);
                let name = format!("scene of {}", path.display());
                Self::parse(&scene.to_toml(), &name, &scene.base, overrides)
            }
            _ => Err(SceneError::Kind { path: path.to_owned() }),
        }
    }

    /// The scene of a model alone, whose bounds are `low` and `high` in the unit of the file: it is
    /// dropped on a ground a tenth of its height below it, under a gravity that makes it fall its own
    /// height in half a second (g = 2 h / t^2), and its volume is kept.
    ///
    /// Paths are relative to the current folder, so that the scene's text can be saved there.
    /// A model without height, a flat sheet, counts as high as it is wide.
    pub fn of_model(path: &Path, low: [f64; 3], high: [f64; 3], up: Up) -> Self {
        let axis = match up {
            Up::Y => 1,
            Up::Z => 2,
        };
        let extent = |axis: usize| high[axis] - low[axis];
        let widest = (0..3).map(extent).fold(0.0, f64::max);
        // Below a thousandth of its width a height says nothing about how large a model is.
        let height = if extent(axis) > 1e-3 * widest { extent(axis) } else { widest };
        let mut gravity = [0.0; 3];
        gravity[axis] = rounded(-2.0 * height / (FALL * FALL), height);
        let mut normal = [0.0; 3];
        normal[axis] = 1.0;
        let mut point = [0.0; 3];
        point[axis] = rounded(low[axis] - GAP * height, height);

        let mut body = BodyData::new(name_from(path), path);
        body.material.region_damping = RegionDamping::PerStep(0.3);
        Self {
            base: Default::default(),
            simulation: SimulationData {
                frames: 90,
                substeps: Substeps::Fixed(4),
                gravity,
                ..Default::default()
            },
            output: OutputData::default(),
            bodies: vec![body],
            colliders: vec![Collider::plane(point, normal)],
        }
    }
}

/// A number to six digits of a length that it is measured against, for a text that people read.
fn rounded(value: f64, against: f64) -> f64 {
    let digits = 5 - against.log10().floor() as i32;
    // Through decimal text: a product of powers of ten would bring back digits that nobody wrote.
    let decimals = digits.clamp(0, 300) as usize;
    format!("{value:.decimals$}").parse().unwrap_or(value)
}
