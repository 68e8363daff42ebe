//! `[[body]]`: a mesh, how it is placed, and what it is made of.

use std::path::{Path, PathBuf};

use super::data::BodyData;
use super::error::SceneError;
use super::fields::{Field, Fields};
use super::motion;
use super::range::Range;
use supple::Resolution;
use supple::volume::{FieldKind, Preservation, VolumeOptions, VolumeScope};
use supple::{Damping, Material, Placement, RegionSize, Stiffness};

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

/// The widest region, in cells: wider than any lattice.
const MAX_HALF_WIDTH: u32 = 1_000_000;
/// The most lattice vertices that may be asked for: their indices fit in 32 bits.
const MAX_VERTICES: u32 = 2_000_000_000;
const NAME_RANGE: &str = "made of letters, digits, `-`, `_` and `.` only, because files are named after it";
impl BodyData {
    /// A body of this name and mesh, with every default.
    pub fn new(name: impl Into<String>, mesh: impl Into<PathBuf>) -> Self {
        Self {
            name: name.into(),
            mesh: mesh.into(),
            object: None,
            scale: 1.0,
            placement: Placement::default(),
            resolution: Resolution::Vertices(1000),
            join: true,
            material: Material::default(),
            volume: VolumeOptions::default(),
            pins: Vec::new(),
            handles: Vec::new(),
        }
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
    body.placement = read_placement(&fields)?;
    if let Some(resolution) = read_resolution(&fields)? {
        body.resolution = resolution;
    }
    body.join = fields.read_or("join", body.join, Field::boolean)?;
    body.volume = fields.read_or("volume", body.volume, read_volume)?;
    body.material = read_material(&fields)?;
    body.pins = fields.tables("pin")?.iter().map(motion::read_pin).collect::<Result<_, _>>()?;
    body.handles = fields.tables("handle")?.iter().map(motion::read_handle).collect::<Result<_, _>>()?;
    Ok(body)
}

fn read_placement(fields: &Fields<'_>) -> Result<Placement, SceneError> {
    let vector = |key| fields.read_or(key, [0.0; 3], Field::vector);
    Ok(Placement {
        rotate: vector("rotate")?,
        translate: vector("translate")?,
        velocity: vector("velocity")?,
        spin: vector("spin")?,
    })
}

fn read_resolution(fields: &Fields<'_>) -> Result<Option<Resolution>, SceneError> {
    Ok(match fields.one_of(&["lattice_vertices", "cell_size"])? {
        Some((0, field)) => Some(Resolution::Vertices(field.count(8, MAX_VERTICES)? as usize)),
        Some((_, field)) => Some(Resolution::CellSize(field.number(Range::Positive)?)),
        None => None,
    })
}

fn read_material(fields: &Fields<'_>) -> Result<Material, SceneError> {
    let mut material = Material::default();
    match fields.one_of(&["half_width", "stiffness_radius"])? {
        Some((0, field)) => {
            material.region_size = RegionSize::Cells(field.count(1, MAX_HALF_WIDTH)? as usize)
        }
        Some((_, field)) => material.region_size = RegionSize::Radius(field.number(Range::Positive)?),
        None => {}
    }
    match fields.one_of(&["stiffness", "frequency"])? {
        Some((0, field)) => material.stiffness = Stiffness::PerStep(field.number(Range::Share)?),
        Some((_, field)) => material.stiffness = Stiffness::Frequency(field.number(Range::Positive)?),
        None => {}
    }
    match fields.one_of(&["damping", "damping_rate"])? {
        Some((0, field)) => material.damping = Damping::PerStep(field.number(Range::Unit)?),
        Some((_, field)) => material.damping = Damping::Rate(field.number(Range::NotNegative)?),
        None => {}
    }
    material.density = fields.read_or("density", material.density, |field| field.number(Range::Positive))?;
    Ok(material)
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
    // A leading point would hide the frames.
    !name.is_empty() && !name.starts_with('.') && name.chars().all(is_name_character)
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

fn read_volume(field: &Field<'_>) -> Result<VolumeOptions, SceneError> {
    let mut volume = VolumeOptions::default();
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
        fields.read_or("max_correction", volume.max_correction, |field| field.number(Range::NotNegative))?;
    volume.scope = fields.read_or("scope", volume.scope, |field| named(field, &VolumeScope::NAMED))?;
    volume.field = fields.read_or("field", volume.field, |field| named(field, &FieldKind::NAMED))?;
    Ok(volume)
}

fn read_measure(field: &Field<'_>) -> Result<Preservation, SceneError> {
    named(field, &Preservation::NAMED)
}

/// What one of some names stands for.
fn named<T: Copy, const N: usize>(
    field: &Field<'_>,
    names: &[(&'static str, T); N],
) -> Result<T, SceneError> {
    Ok(names[field.choice(&names.map(|(name, _)| name))?].1)
}
