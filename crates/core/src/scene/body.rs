//! `[[body]]`: a mesh, how it is placed, and what it is made of.

use std::path::{Path, PathBuf};

use super::data::{BodyData, Damping, MeasureData, Reach, ResolutionData, Stiffness, VolumeData};
use super::error::SceneError;
use super::fields::{Field, Fields};
use super::motion;
use super::range::Range;

const KEYS: [&str; 21] = [
    "name",
    "mesh",
    "object",
    "scale",
    "rotate",
    "translate",
    "lattice_vertices",
    "cell_size",
    "join",
    "half_width",
    "stiffness_radius",
    "stiffness",
    "frequency",
    "damping",
    "damping_rate",
    "density",
    "volume",
    "velocity",
    "spin",
    "pin",
    "handle",
];

/// The widest region, in cells: beyond it a region spans any lattice that a user waits for.
const MAX_HALF_WIDTH: u32 = 64;
/// The most lattice vertices that may be asked for: their indices fit in 32 bits.
const MAX_VERTICES: u32 = 2_000_000_000;
const NAME_RANGE: &str = "made of letters, digits, `-`, `_` and `.` only, because files are named after it";
const MEASURES: [(&str, MeasureData); 4] = [
    ("auto", MeasureData::Auto),
    ("off", MeasureData::Off),
    ("lattice", MeasureData::Lattice),
    ("mesh", MeasureData::Mesh),
];

impl BodyData {
    /// A body of this name and mesh, with every default.
    pub fn new(name: impl Into<String>, mesh: impl Into<PathBuf>) -> Self {
        Self {
            name: name.into(),
            mesh: mesh.into(),
            object: None,
            scale: 1.0,
            rotate: [0.0; 3],
            translate: [0.0; 3],
            resolution: ResolutionData::LatticeVertices(1000),
            join: true,
            reach: Reach::HalfWidth(2),
            stiffness: Stiffness::Alpha(1.0),
            damping: Damping::Share(0.0),
            density: 1000.0,
            volume: VolumeData::default(),
            velocity: [0.0; 3],
            spin: [0.0; 3],
            pins: Vec::new(),
            handles: Vec::new(),
        }
    }
}

impl Default for VolumeData {
    fn default() -> Self {
        Self { measure: MeasureData::Auto, max_correction: 1.0 }
    }
}

impl MeasureData {
    /// The name in a scene.
    pub fn name(self) -> &'static str {
        MEASURES.iter().find(|(_, measure)| *measure == self).map_or("auto", |(name, _)| name)
    }
}

/// Reads one `[[body]]`.
pub(super) fn read(field: &Field<'_>) -> Result<BodyData, SceneError> {
    let field = match name_of(field) {
        Some(name) => &field.renamed(format!("body.{name}")),
        None => field,
    };
    let fields = Fields::new(field, &KEYS)?;
    let mesh = fields.require("mesh", "the path of an OBJ file, relative to the scene")?;
    let path = mesh.text()?;
    if path.is_empty() {
        return Err(mesh.out_of_range("the path of an OBJ file"));
    }
    let name = match fields.get("name") {
        Some(name) => read_name(&name)?,
        None => name_from(Path::new(path)),
    };
    let mut body = BodyData::new(name, path);
    body.object = fields.get("object").map(|field| field.text().map(str::to_owned)).transpose()?;
    body.scale = fields.read_or("scale", body.scale, |field| field.number(Range::Positive))?;
    body.rotate = fields.read_or("rotate", body.rotate, Field::vector)?;
    body.translate = fields.read_or("translate", body.translate, Field::vector)?;
    body.join = fields.read_or("join", body.join, Field::boolean)?;
    body.density = fields.read_or("density", body.density, |field| field.number(Range::Positive))?;
    body.volume = fields.read_or("volume", body.volume, read_volume)?;
    body.velocity = fields.read_or("velocity", body.velocity, Field::vector)?;
    body.spin = fields.read_or("spin", body.spin, Field::vector)?;
    read_material(&fields, &mut body)?;
    body.pins = fields.tables("pin")?.iter().map(motion::read_pin).collect::<Result<_, _>>()?;
    body.handles = fields.tables("handle")?.iter().map(motion::read_handle).collect::<Result<_, _>>()?;
    Ok(body)
}

/// The keys that come in pairs, of which one may be given.
fn read_material(fields: &Fields<'_>, body: &mut BodyData) -> Result<(), SceneError> {
    match fields.one_of(&["lattice_vertices", "cell_size"])? {
        Some((0, field)) => {
            body.resolution = ResolutionData::LatticeVertices(field.count(8, MAX_VERTICES)? as usize);
        }
        Some((_, field)) => body.resolution = ResolutionData::CellSize(field.number(Range::Positive)?),
        None => {}
    }
    match fields.one_of(&["half_width", "stiffness_radius"])? {
        Some((0, field)) => body.reach = Reach::HalfWidth(field.count(1, MAX_HALF_WIDTH)? as usize),
        Some((_, field)) => body.reach = Reach::StiffnessRadius(field.number(Range::Positive)?),
        None => {}
    }
    match fields.one_of(&["stiffness", "frequency"])? {
        Some((0, field)) => body.stiffness = Stiffness::Alpha(field.number(Range::Share)?),
        Some((_, field)) => body.stiffness = Stiffness::Frequency(field.number(Range::Positive)?),
        None => {}
    }
    match fields.one_of(&["damping", "damping_rate"])? {
        Some((0, field)) => body.damping = Damping::Share(field.number(Range::Unit)?),
        Some((_, field)) => body.damping = Damping::Rate(field.number(Range::NotNegative)?),
        None => {}
    }
    Ok(())
}

/// The name of a body for messages, if it has a usable one.
fn name_of(field: &Field<'_>) -> Option<String> {
    field.entry("name")?.text().ok().filter(|name| is_name(name)).map(str::to_owned)
}

fn read_name(field: &Field<'_>) -> Result<String, SceneError> {
    let name = field.text()?;
    if is_name(name) { Ok(name.to_owned()) } else { Err(field.out_of_range(NAME_RANGE)) }
}

fn is_name(name: &str) -> bool {
    !name.is_empty() && name.chars().all(is_name_character)
}

fn is_name_character(character: char) -> bool {
    character.is_ascii_alphanumeric() || matches!(character, '-' | '_' | '.')
}

/// The name of a body that has none: its file's, with `_` for what a name cannot hold.
pub(super) fn name_from(mesh: &Path) -> String {
    let stem = mesh.file_stem().unwrap_or_default().to_string_lossy();
    let name: String =
        stem.chars().map(|character| if is_name_character(character) { character } else { '_' }).collect();
    if name.is_empty() { "body".to_owned() } else { name }
}

fn read_volume(field: &Field<'_>) -> Result<VolumeData, SceneError> {
    let mut volume = VolumeData::default();
    if !field.is_table() {
        if !field.is_text() {
            return Err(field.wrong_type("a text, as \"auto\", or a table, as { measure = \"mesh\" }"));
        }
        volume.measure = read_measure(field)?;
        return Ok(volume);
    }
    let fields = Fields::new(field, &["measure", "scope", "field", "max_correction"])?;
    volume.measure = fields.read_or("measure", volume.measure, read_measure)?;
    volume.max_correction =
        fields.read_or("max_correction", volume.max_correction, |field| field.number(Range::Positive))?;
    // The only scope and the only field: named, so that a scene can say which it relies on.
    fields.read_or("scope", 0, |field| field.choice(&["global"]))?;
    fields.read_or("field", 0, |field| field.choice(&["paper"]))?;
    Ok(volume)
}

fn read_measure(field: &Field<'_>) -> Result<MeasureData, SceneError> {
    Ok(MEASURES[field.choice(&MEASURES.map(|(name, _)| name))?].1)
}
