//! The choices that the page offers, and the simulation that they give.

use supple::{Collider, Field, FieldLaw, Goal, Preservation, Preset, Simulation, SkinKind, Substeps, Wind};
#[cfg(target_family = "wasm")]
use wasm_bindgen::prelude::wasm_bindgen;

use crate::error::PlaygroundError;
use crate::model::{Model, Up};

/// Frames per second of the simulation. A frame has as many steps as the body needs.
pub(crate) const FRAMES_PER_SECOND: f64 = 60.0;

/// Height above the floor from which a body falls that is not held, in m.
const DROP_HEIGHT: f64 = 0.2;

/// Height above the floor of a body that is held, in m. Vertices that are held at the floor would be pushed by it
/// without end, and the body would not come to rest.
const HELD_HEIGHT: f64 = 0.01;

/// Strength of the gusts of the wind.
const GUST: f64 = 0.5;

/// Frequency in Hz of the springs of a grip of 0.5: high enough that the small part that a pointer grabs pulls the body.
const GRIP_FREQUENCY: f64 = 40.0;

/// Memory limit of a body in bytes: browsers give a page 2 to 4 GB.
const MEMORY_LIMIT: u64 = 1 << 30;

/// The choices of the page.
#[cfg_attr(target_family = "wasm", wasm_bindgen)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Target number of lattice vertices, at least 8; default 1,000.
    pub lattice_vertices: u32,
    /// Whether the volume is preserved; default true.
    pub volume: bool,
    /// Acceleration downwards, in m/s²; default 9.81.
    pub gravity: f64,
    /// Whether there is a floor; default true.
    pub floor: bool,
    /// Whether the lowest part of the body is held where it is; default true.
    pub base: bool,
    /// Poisson's ratio, in [0, 0.47]; default that of the material, which [`Settings::set_material`] sets.
    pub poisson_ratio: f64,
    /// Ratio of the rest volume of the body to that of the model, in [0.1, 10]; default 1.
    pub inflate: f64,
    /// Speed of a wind with gusts along +x, in m/s, at least 0; default 0: none.
    pub wind: f64,
    /// Weight of the parts that pointers grab from now on, in (0, 1]; default 1: they are where the pointers are. With
    /// less, springs pull them there.
    pub grip: f64,
    pub(crate) material: Preset,
    pub(crate) up: Up,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            lattice_vertices: 1000,
            volume: true,
            gravity: 9.81,
            floor: true,
            base: true,
            poisson_ratio: Preset::Flesh.poisson_ratio(),
            inflate: 1.0,
            wind: 0.0,
            grip: 1.0,
            material: Preset::Flesh,
            up: Up::default(),
        }
    }
}

#[cfg_attr(target_family = "wasm", wasm_bindgen)]
impl Settings {
    /// Returns the defaults.
    pub fn new() -> Self {
        Self::default()
    }

    /// Sets the material, the name of a preset, and its Poisson's ratio; default `flesh`.
    ///
    /// # Errors
    ///
    /// An unknown name.
    pub fn set_material(&mut self, name: &str) -> Result<(), PlaygroundError> {
        self.material = named("material", name, &Preset::NAMED)?;
        self.poisson_ratio = self.material.poisson_ratio();
        Ok(())
    }

    /// Sets the axis of the model that is up: `y`, the default, or `z`.
    ///
    /// # Errors
    ///
    /// An unknown name.
    pub fn set_up(&mut self, name: &str) -> Result<(), PlaygroundError> {
        self.up = named("axis", name, &Up::NAMED)?;
        Ok(())
    }
}

impl Settings {
    /// Builds the simulation of a model in its start pose.
    pub(crate) fn simulation(&self, model: &Model) -> Result<Simulation, supple::Error> {
        let body = model
            .body(self.up, if self.base { HELD_HEIGHT } else { DROP_HEIGHT })
            .lattice_vertices(self.lattice_vertices as usize)
            .preset(self.material)
            .poisson_ratio(self.poisson_ratio)
            .inflate(self.inflate)
            .volume(self.preservation())
            .skin(SkinKind::Smooth)
            .memory_limit(MEMORY_LIMIT)
            .build()?;
        let builder = Simulation::builder().body(body).contact(false).gravity(self.acceleration());
        let builder = self.fields().into_iter().fold(builder, |builder, field| builder.field(field));
        let builder = builder.fps(FRAMES_PER_SECOND).substeps(Substeps::Auto);
        self.colliders().into_iter().fold(builder, |builder, collider| builder.collider(collider)).build()
    }

    pub(crate) fn preservation(&self) -> Preservation {
        if self.volume { Preservation::Auto } else { Preservation::Off }
    }

    pub(crate) fn acceleration(&self) -> [f64; 3] {
        [0.0, -self.gravity, 0.0]
    }

    /// Returns the wind, if there is any.
    pub(crate) fn fields(&self) -> Vec<Field> {
        let wind = || {
            let wind = Wind { velocity: [self.wind, 0.0, 0.0], gust: GUST, ..Wind::default() };
            Field::new(FieldLaw::Wind(wind))
        };
        (self.wind != 0.0).then(wind).into_iter().collect()
    }

    /// Returns how the parts that pointers grab follow them; `None`: they are there.
    pub(crate) fn goal(&self) -> Option<Goal> {
        (self.grip != 1.0).then(|| Goal { frequency: GRIP_FREQUENCY, ..self.grip.into() })
    }

    pub(crate) fn colliders(&self) -> Vec<Collider> {
        let floor = || Collider::plane([0.0; 3], [0.0, 1.0, 0.0]);
        self.floor.then(floor).into_iter().collect()
    }
}

/// Returns the value with a name.
fn named<T: Copy>(
    setting: &'static str,
    name: &str,
    values: &[(&'static str, T)],
) -> Result<T, PlaygroundError> {
    let found = values.iter().find(|(known, _)| *known == name).map(|(_, value)| *value);
    found.ok_or_else(|| {
        let known = values.iter().map(|(known, _)| *known).collect::<Vec<_>>().join(", ");
        PlaygroundError::Name { setting, name: name.to_owned(), known }
    })
}
