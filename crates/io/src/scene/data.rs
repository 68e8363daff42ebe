//! Defines the data of a scene: one field for each scene key, with defaults. serde reads and writes it.
//!
//! A field named `@...` stands for several keys of the table that contains the field: see [`super::keys`].

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::collider::ColliderData;
use super::handle::HandleData;
use super::keys::{self, MaterialKeys, PlacementKeys, ResolutionKeys, TouchingKeys, VolumeKeys};
use super::vertices_file::VertexFile;
use crate::film::{Coloring, FilmOptions};
use crate::frames::{FormatOptions, Formats, VatEncoding};
use crate::space::Up;
use supple::{
    BodyBuilder, Curve, Field, FractureOptions, KeyedMaterial, LatticeOptions, Link, Material, Pin,
    Placement, Refine, Resolution, Scale, Selection, SimulationBuilder, SkinKind, TouchingOptions,
    VolumeOptions, Zone,
};

/// Largest number of frames: almost four days at 30 frames per second.
const MAX_FRAMES: u32 = 10_000_000;
/// Largest number of steps per frame.
pub const MAX_SUBSTEPS: u32 = 100_000;
/// Largest number of threads. Most machines have fewer processors, and operating systems can start as many
/// threads.
const MAX_THREADS: u32 = 1024;

/// A scene: bodies and colliders, simulation settings and output settings.
///
/// Lengths are in the unit of the meshes, times in seconds, masses in kilograms.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scene {
    /// Directory of the scene file. `mesh` and `output.directory` are relative to it.
    #[serde(skip)]
    pub base: PathBuf,
    /// `[simulation]`: time, gravity and threads.
    #[serde(default)]
    pub simulation: SimulationData,
    /// `[output]`: directory and format of the frames.
    #[serde(default)]
    pub output: OutputData,
    /// `[[body]]`, in the order of the file; at least one.
    #[serde(default, rename = "body")]
    pub bodies: Vec<BodyData>,
    /// `[[collider]]`, in the order of the file.
    #[serde(default, rename = "collider")]
    pub colliders: Vec<ColliderData>,
    /// `[[field]]`, in the order of the file: wind, drag and other accelerations.
    #[serde(default, rename = "field", with = "keys::fields", skip_serializing_if = "Vec::is_empty")]
    pub fields: Vec<Field>,
    /// `[[link]]`, in the order of the file: glue and springs between bodies.
    #[serde(default, rename = "link", with = "keys::links", skip_serializing_if = "Vec::is_empty")]
    pub links: Vec<Link>,
    /// The files of `vertices_file` that the selections have read.
    #[serde(skip)]
    pub(crate) vertex_files: Vec<VertexFile>,
}

/// `[simulation]`: time, gravity and threads.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct SimulationData {
    /// Number of frames after frame 0; default 240.
    #[serde(deserialize_with = "keys::count::<_, _, 0, MAX_FRAMES>")]
    pub frames: u32,
    /// Frames per second, above 0; default 30.
    #[serde(deserialize_with = "keys::fps")]
    pub fps: f64,
    /// Number of steps per frame; default automatic.
    pub substeps: Substeps,
    /// Simulated seconds per second of the frames, in (0, 10]: a number, or keyframes over the time of the frames; default
    /// 1. Runs use it, and no live simulation.
    #[serde(with = "keys::time_scale")]
    pub time_scale: Curve,
    /// Time that is simulated before frame 0, in s, in [0, 1e6], rounded up to whole frames; default 0.
    #[serde(deserialize_with = "keys::preroll")]
    pub preroll: f64,
    /// Gravitational acceleration, length/s^2: a vector or keyframes; default `[0, -9.81, 0]`.
    #[serde(with = "keys::vector")]
    pub gravity: Curve<[f64; 3]>,
    /// Number of threads; 0, the default, uses all processors.
    #[serde(deserialize_with = "keys::count::<_, _, 0, MAX_THREADS>")]
    pub threads: usize,
    /// Whether bodies touch each other; default true.
    pub contact: bool,
    /// Whether bodies touch themselves, unless they have a `self_contact` of their own; default false.
    pub self_contact: bool,
    /// Whether bodies at rest fall asleep: they are not stepped until something moves them; default true.
    pub sleep: bool,
}

impl SimulationData {
    /// Passes the settings to the builder of a simulation, except `frames`, `fps`, `substeps`, `time_scale`
    /// and `preroll`.
    pub fn apply(&self, builder: SimulationBuilder) -> SimulationBuilder {
        let builder = builder.gravity(self.gravity.clone()).threads(self.threads);
        builder.contact(self.contact).self_contact(self.self_contact).sleep(self.sleep)
    }
}

/// Number of steps per frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(into = "toml::Value", try_from = "toml::Value")]
pub enum Substeps {
    /// A fixed number of steps, at least 1.
    Fixed(u32),
    /// The number of steps that the stiffest body and the fastest motion need; see [`supple::Substeps`].
    Auto,
}

/// `[output]`: directory and formats of the frames, and the axes, units and rate of the files.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct OutputData {
    /// Directory of the frames, relative to the scene file; default `frames`.
    #[serde(deserialize_with = "keys::directory")]
    pub directory: PathBuf,
    /// File formats; default OBJ.
    pub format: Formats,
    /// Interval in frames between states that are kept beside the frames, from which a run can continue; by default none
    /// are kept.
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "keys::interval")]
    pub states: Option<u32>,
    /// Axis of the files that points up; by default that of the scene, by [`Up::of_gravity`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub up: Option<Up>,
    /// Length in the files of a length 1 of the scene, above 0; default 1.
    #[serde(deserialize_with = "keys::positive")]
    pub scale: f64,
    /// Frames per second at which the files are played, above 0; by default those of the simulation.
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "keys::positive")]
    pub fps: Option<f64>,
    /// Meters per unit of length of the files, above 0, which USD stages state and GLB files have as lengths; default 1.
    #[serde(deserialize_with = "keys::positive")]
    pub meters_per_unit: f64,
    /// Largest distance of a vertex of a GLB file from its place, relative to the size of its body, in [0, 1]; default
    /// 0.001.
    #[serde(deserialize_with = "keys::fraction")]
    pub glb_error: f64,
    /// Encoding of the images of vertex animation textures; default PNG.
    pub vat_encoding: VatEncoding,
    /// Whether USD stages have the velocities of their points, for motion blur; default false.
    pub usd_velocities: bool,
    /// Width and height of a film in pixels, in [16, 4096]; default `[800, 600]`.
    #[serde(deserialize_with = "keys::film_size")]
    pub film_size: [u32; 2],
    /// Direction from the bodies to the camera of a film, in the axes of the files, not zero; by default from the front,
    /// the right and above.
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "keys::view")]
    pub film_view: Option<[f64; 3]>,
    /// What the colors of the bodies of a film show; default `material`.
    pub film_color: Coloring,
}

impl OutputData {
    /// Returns the settings of single formats.
    pub fn format_options(&self) -> FormatOptions {
        FormatOptions {
            meters_per_unit: self.meters_per_unit,
            glb_error: self.glb_error,
            vat_encoding: self.vat_encoding,
            usd_velocities: self.usd_velocities,
            film: self.film(),
        }
    }

    /// Returns how films look.
    pub fn film(&self) -> FilmOptions {
        FilmOptions { size: self.film_size, view: self.film_view, coloring: self.film_color }
    }
}

/// `[[body]]`: mesh, placement, lattice, material and constraints of a body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct BodyData {
    /// Unique name: letters and digits of any language, `-`, `_` and `.`, at most 200 bytes.
    #[serde(deserialize_with = "keys::name")]
    pub name: String,
    /// Model file, relative to the scene file.
    #[serde(deserialize_with = "keys::mesh")]
    pub mesh: PathBuf,
    /// Name of the `o` or `g` of the file that is the body; `None` for the whole file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub object: Option<String>,
    /// Scale of the mesh, applied before the placement: a factor above 0, or one for each axis, not 0, of which negative
    /// ones mirror the mesh; default 1.
    #[serde(with = "keys::scale")]
    pub scale: Scale,
    /// Whether faces that are larger than cells are divided, so that the surface bends between the vertices of the mesh:
    /// `"off"`, the default, or `"auto"`. Frames then have more vertices.
    #[serde(with = "keys::refine")]
    pub refine: Refine,
    /// Keys `rotate` and `translate`, applied in this order, and initial `velocity` and `spin`.
    #[serde(rename = "@placement", with = "PlacementKeys")]
    pub placement: Placement,
    /// Whether the body is rigid; default false.
    pub rigid: bool,
    /// Keys `lattice_vertices` or `cell_size`: resolution of the lattice; default 1,000 lattice vertices, and 300 of a
    /// rigid body.
    #[serde(rename = "@resolution", with = "ResolutionKeys")]
    pub resolution: Resolution,
    /// Whether bridges of cells join separate parts of the lattice to the largest part; default true.
    pub join: bool,
    /// Keys `material`, or `youngs_modulus`, or any of `half_width` or `stiffness_radius` and `stiffness` or
    /// `frequency`; `damping_ratio` or `damping_rate`, `region_damping` or `region_damping_rate`, `density`, and the
    /// table `plastic`.
    #[serde(rename = "@material", with = "MaterialKeys")]
    pub material: Material,
    /// Ratio of the rest volume to that of the mesh, in [0.1, 10]: a number or keyframes; default 1.
    #[serde(with = "keys::inflate")]
    pub inflate: Curve,
    /// The table `fracture`: when and how the body breaks; `None` if it does not break.
    #[serde(with = "keys::optional_fracture", skip_serializing_if = "Option::is_none")]
    pub fracture: Option<FractureOptions>,
    /// Volume preservation; by default the measure is chosen automatically.
    #[serde(with = "VolumeKeys")]
    pub volume: VolumeOptions,
    /// How the mesh follows the lattice; default `"linear"`.
    #[serde(with = "keys::skin")]
    pub skin: SkinKind,
    /// Keys `friction`, `restitution`, `rolling_resistance`, `thickness`, `ignore` and `self_contact`: how the body
    /// touches colliders, other bodies and itself.
    #[serde(rename = "@touching", with = "TouchingKeys")]
    pub touching: TouchingOptions,
    /// The keyframes of the keys `youngs_modulus`, `poisson_ratio`, `damping_ratio` and `friction`, whose greatest values
    /// are those of `material` and `touching`.
    #[serde(rename = "@keyed", with = "keys::KeyedKeys")]
    pub keyed: KeyedMaterial,
    /// `[[body.zone]]`, in the order of the file.
    #[serde(rename = "zone", with = "keys::zones")]
    pub zones: Vec<Zone>,
    /// `[[body.pin]]`, in the order of the file.
    #[serde(rename = "pin", with = "keys::pins")]
    pub pins: Vec<Pin>,
    /// `[[body.handle]]`, in the order of the file.
    #[serde(rename = "handle")]
    pub handles: Vec<HandleData>,
}

impl BodyData {
    /// Returns the keys and the paths of the files, to change them.
    pub(crate) fn files_mut(&mut self) -> impl Iterator<Item = (String, &mut PathBuf)> {
        let follow = self.handles.iter_mut().enumerate().filter_map(|(index, handle)| {
            handle.follow.as_mut().map(|path| (format!("handle.{index}.follow"), path))
        });
        std::iter::once(("mesh".to_owned(), &mut self.mesh)).chain(follow)
    }

    /// Returns the selections of pins, handles and zones.
    pub(crate) fn selections(&self) -> impl Iterator<Item = &Selection> + Clone {
        let pins = self.pins.iter().map(|pin| &pin.selection);
        let handles = self.handles.iter().map(|handle| &handle.selection);
        pins.chain(handles).chain(self.zones.iter().map(|zone| &zone.selection))
    }

    /// Passes the settings to the builder of a body: all keys but its name, mesh, object, zones, pins and handles.
    pub fn apply(&self, builder: BodyBuilder) -> BodyBuilder {
        let builder = builder
            .scale(self.scale)
            .rigid(self.rigid)
            .resolution(self.resolution)
            .join(self.join)
            .material(self.material)
            .inflate(self.inflate.clone())
            .placement(self.placement)
            .volume(self.volume)
            .refine(self.refine)
            .skin(self.skin)
            .touching(self.touching.clone())
            .keyed(self.keyed.clone());
        match self.fracture {
            Some(fracture) => builder.fracture(fracture),
            None => builder,
        }
    }

    /// Creates a body with a name and a mesh, and defaults for all other keys.
    pub fn new(name: impl Into<String>, mesh: impl Into<PathBuf>) -> Self {
        let LatticeOptions { resolution, join, .. } = LatticeOptions::default();
        Self {
            name: name.into(),
            mesh: mesh.into(),
            object: None,
            scale: Scale::default(),
            refine: Refine::default(),
            placement: Placement::default(),
            rigid: false,
            resolution,
            join,
            material: Material::default(),
            keyed: KeyedMaterial::default(),
            inflate: 1.0.into(),
            fracture: None,
            volume: VolumeOptions::default(),
            skin: SkinKind::default(),
            touching: TouchingOptions::default(),
            zones: Vec::new(),
            pins: Vec::new(),
            handles: Vec::new(),
        }
    }
}

/// Defaults of the keys that a scene file omits. `mesh` and `name` are empty. Reading a scene requires
/// `mesh`, and derives `name` from `mesh`.
impl Default for BodyData {
    fn default() -> Self {
        Self::new("", "")
    }
}

impl Default for SimulationData {
    fn default() -> Self {
        Self {
            frames: 240,
            fps: 30.0,
            substeps: Substeps::Auto,
            time_scale: 1.0.into(),
            preroll: 0.0,
            gravity: [0.0, -9.81, 0.0].into(),
            threads: 0,
            contact: true,
            self_contact: false,
            sleep: true,
        }
    }
}

impl Default for OutputData {
    fn default() -> Self {
        let FormatOptions { meters_per_unit, glb_error, vat_encoding, usd_velocities, film } =
            FormatOptions::default();
        Self {
            directory: "frames".into(),
            format: Formats::default(),
            states: None,
            up: None,
            scale: 1.0,
            fps: None,
            meters_per_unit,
            glb_error,
            vat_encoding,
            usd_velocities,
            film_size: film.size,
            film_view: film.view,
            film_color: film.coloring,
        }
    }
}

impl From<Substeps> for supple::Substeps {
    fn from(substeps: Substeps) -> Self {
        match substeps {
            Substeps::Fixed(steps) => Self::Fixed(steps),
            Substeps::Auto => Self::Auto,
        }
    }
}

impl From<Substeps> for toml::Value {
    fn from(substeps: Substeps) -> Self {
        match substeps {
            Substeps::Fixed(steps) => steps.into(),
            Substeps::Auto => "auto".into(),
        }
    }
}

impl TryFrom<toml::Value> for Substeps {
    type Error = String;

    fn try_from(value: toml::Value) -> Result<Self, String> {
        let steps = value.as_integer().and_then(|steps| u32::try_from(steps).ok());
        match (value.as_str(), steps) {
            (Some("auto"), _) => Ok(Self::Auto),
            (_, Some(steps @ 1..=MAX_SUBSTEPS)) => Ok(Self::Fixed(steps)),
            _ => Err(format!("\"auto\" or a whole number from 1 to {MAX_SUBSTEPS}")),
        }
    }
}
