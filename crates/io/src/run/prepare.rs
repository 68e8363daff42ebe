//! Builds the simulation of a scene: reads meshes, builds lattices, adds pins, handles and colliders. Writes
//! no files.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::animations::Animations;
use super::caution::Caution;
use super::error::RunError;
use super::preroll::with_early_starts;
use crate::frames::{self, Formats, OutputError, Source};
use crate::memory::memory_limit;
use crate::model;
use crate::obj::{Document, Part};
use crate::scene::{BodyData, ColliderData, Scene};
use supple::{
    Body, Collider, CollisionMesh, Map, RefinedMesh, Scale, Selection, SelectionError, Simulation,
    SimulationBuilder,
};

/// A scene that is ready to run: the simulation at time 0, and the inputs of its bodies.
#[derive(Debug)]
pub struct Prepared {
    /// Simulation with all bodies and colliders, at time 0.
    pub simulation: Simulation,
    /// Steps per frame, at least 1.
    pub substeps: u32,
    /// Inputs, one per body.
    pub inputs: Vec<Input>,
    /// What the author of the scene probably does not expect.
    pub cautions: Vec<Caution>,
}

impl Prepared {
    /// Checks that frames of all formats can have the faces of the bodies.
    ///
    /// # Errors
    ///
    /// If a body can break, and a format has the same faces in all frames.
    pub fn check_topologies(&self, formats: &Formats) -> Result<(), OutputError> {
        let fixed = formats.iter().find(|format| !format.has_topology_per_frame());
        match (fixed, self.simulation.bodies().iter().find(|body| body.fracture().is_some())) {
            (Some(format), Some(body)) => Err(OutputError::CanBreak { body: body.name().to_owned(), format }),
            _ => Ok(()),
        }
    }
}

/// Input of a body: a model file, and the part of the file that is the body.
#[derive(Clone, Debug)]
pub struct Input {
    /// Model file. Bodies from the same file share one document.
    pub document: Arc<Document>,
    /// Part of the file that is the body.
    pub part: Part,
}

impl Input {
    /// Returns the input of frames. Factors that differ by axis change the normals of the file, and a mirror the order
    /// of the corners of its faces.
    fn scaled(self, scale: Scale) -> Result<Self, RunError> {
        match scale {
            Scale::Uniform(_) => Ok(self),
            Scale::PerAxis(_) => {
                let document = Arc::new(self.document.scaled(&self.part, scale)?);
                let part = document.part(self.part.object())?;
                Ok(Self { document, part })
            }
        }
    }

    /// Returns the input of frames of a refined mesh.
    fn refined(self, body: &Body, refined: &RefinedMesh) -> Result<Self, RunError> {
        let document = Arc::new(frames::refined(&self.document, &self.part, (body, refined))?);
        let part = document.part(self.part.object())?;
        debug_assert!(part.mesh().faces().eq(refined.mesh.faces()), "the file has the faces of the body");
        Ok(Self { document, part })
    }

    /// Returns the source for a frame writer.
    pub fn source(&self) -> Source<'_> {
        Source::Document(&self.document, &self.part)
    }
}

/// Builds the simulation that a scene describes, at time 0. A pre-roll of the scene is not simulated: see
/// [`preroll`](super::preroll()).
///
/// # Errors
///
/// If a mesh cannot be read or is invalid, a lattice does not fit in memory, a pin or a handle selects no
/// vertices, or the volume measure does not apply to a mesh.
pub fn prepare(scene: &Scene) -> Result<Prepared, RunError> {
    let scene = &*with_early_starts(scene);
    let (mut documents, mut animations) = (HashMap::new(), Animations::new(scene));
    let mut bodies = Vec::new();
    let mut inputs = Vec::new();
    for (index, data) in scene.bodies.iter().enumerate() {
        let document = read(&mut documents, &scene.resolve(&data.mesh))?;
        let part = document.part(data.object.as_deref())?;
        let part = with_selected(part, &document, (scene, data));
        let input = Input { document, part };
        let (body, input) =
            build(data, input, &mut animations).map_err(|error| placed(scene, index, error))?;
        bodies.push(body);
        inputs.push(input);
    }
    let mut builder = scene
        .simulation
        .apply(Simulation::builder())
        .fps(scene.simulation.fps)
        .substeps(scene.simulation.substeps.into());
    for body in bodies {
        builder = builder.body(body);
    }
    for collider in read_colliders(scene, (&mut documents, &mut animations))? {
        builder = builder.collider(collider);
    }
    let builder = scene.fields.iter().cloned().fold(builder, SimulationBuilder::field);
    let builder = scene.links.iter().cloned().fold(builder, SimulationBuilder::link);
    let mut simulation = builder.build().map_err(|error| in_scene(scene, error))?;
    let substeps = simulation.substeps() as u32;
    let cautions = Caution::all(&mut simulation);
    Ok(Prepared { simulation, substeps, inputs, cautions })
}

/// Adds the key of the scene to an error of its links.
fn in_scene(scene: &Scene, error: supple::Error) -> RunError {
    match error {
        supple::Error::InLink { index, source } => {
            let key = format!("link.{index}");
            with_line(scene, &key.clone(), key, *source)
        }
        error => RunError::Simulation(error),
    }
}

/// Adds the line of a `vertices_file` to an error of the body with an index.
fn placed(scene: &Scene, index: usize, error: RunError) -> RunError {
    let RunError::Body { key, source } = error else { return error };
    let table = key.replacen(&format!("body.{}", scene.bodies[index].name), &format!("body.{index}"), 1);
    with_line(scene, &table, key, source)
}

/// Returns the error of a selection, with the line of its `vertices_file` if a vertex of that does not exist. `table`:
/// key of the selection, with indices.
fn with_line(scene: &Scene, table: &str, key: String, source: supple::Error) -> RunError {
    let place = match &source {
        &supple::Error::Selection(SelectionError::MeshVertexOutOfRange { vertex, .. }) => {
            scene.line_of_vertex(table, vertex)
        }
        _ => None,
    };
    let key = place.map_or_else(|| key.clone(), |place| format!("{place}: {key}"));
    RunError::Body { key, source }
}

/// Returns the part of a body with the groups, or the maps, of its file if a pin, a handle, a zone or a link selects one.
fn with_selected(part: Part, document: &Document, (scene, data): (&Scene, &BodyData)) -> Part {
    let links = scene.links.iter().filter(|link| link.body == data.name);
    let mut selections = data.selections().chain(links.map(|link| &link.selection));
    let has_group = selections.clone().any(|selection| matches!(selection, Selection::Group(_)));
    let has_map = selections.any(|selection| matches!(selection, Selection::Map(Map::Name(_))));
    let part = if has_group { part.with_groups(document) } else { part };
    if has_map { part.with_maps(document) } else { part }
}

/// Returns the colliders of a scene. Reads the meshes of colliders.
///
/// # Errors
///
/// If a mesh cannot be read, is invalid or has no surface.
pub fn colliders(scene: &Scene) -> Result<Vec<Collider>, RunError> {
    read_colliders(scene, (&mut HashMap::new(), &mut Animations::new(scene)))
}

/// Returns the colliders of a scene. Colliders of one file share their mesh.
fn read_colliders(
    scene: &Scene,
    (documents, animations): (&mut Documents, &mut Animations<'_>),
) -> Result<Vec<Collider>, RunError> {
    let mut meshes: HashMap<PathBuf, CollisionMesh> = HashMap::new();
    let mut mesh = |index: usize, path: &PathBuf| {
        let path = scene.resolve(path);
        let key = || format!("collider.{index}.mesh");
        if let Some(mesh) = meshes.get(&path) {
            return Ok::<_, RunError>(mesh.clone());
        }
        let file = |source| RunError::ColliderFile { key: key(), source: Box::new(source) };
        let document = match documents.get(&path) {
            Some(document) => document.clone(),
            None => Arc::new(model::read_document(&path).map_err(file)?),
        };
        let mesh = CollisionMesh::new(document.mesh(None).map_err(|error| file(error.into()))?)
            .map_err(|source| RunError::ColliderMesh { key: key(), path: path.clone(), source })?;
        meshes.insert(path, mesh.clone());
        Ok(mesh)
    };
    let mut read = |(index, data): (usize, &ColliderData)| {
        let failed = |path: &PathBuf, source| {
            let (key, path) = (format!("collider.{index}.scale"), scene.resolve(path));
            RunError::ColliderMesh { key, path, source }
        };
        let read = |path: &PathBuf| {
            let rigid = mesh(index, path)?;
            let mesh = match &data.animation {
                None => rigid,
                Some(path) => animations.collider(&rigid, path, format!("collider.{index}.animation"))?,
            };
            if !data.inside {
                return Ok(mesh);
            }
            let (key, path) = (format!("collider.{index}.inside"), scene.resolve(path));
            mesh.inverted().map_err(|source| RunError::ColliderMesh { key, path, source })
        };
        data.collider(read, failed)
    };
    scene.colliders.iter().enumerate().map(&mut read).collect()
}

/// Documents by their paths.
type Documents = HashMap<PathBuf, Arc<Document>>;

/// Returns the document of a file. Reads the file only if it is not in `documents`, and adds it there.
fn read(documents: &mut Documents, path: &Path) -> Result<Arc<Document>, RunError> {
    if let Some(document) = documents.get(path) {
        return Ok(document.clone());
    }
    let document = Arc::new(model::read_document(path)?);
    documents.insert(path.to_owned(), document.clone());
    Ok(document)
}

/// Builds a body, and adds its zones, pins and handles. Returns it with the input of its frames.
fn build(data: &BodyData, input: Input, animations: &mut Animations<'_>) -> Result<(Body, Input), RunError> {
    let key = format!("body.{}", data.name);
    let failed = |source| RunError::Body { key: key.clone(), source };
    let builder = Body::builder(input.part.mesh().clone()).name(&data.name).memory_limit(memory_limit());
    let (mut body, refined) = data.apply(builder).build_refined().map_err(failed)?;
    let written = input.clone().scaled(data.scale)?;
    // Weights are those of the file.
    let refine = |selection: &mut Selection| refined.iter().for_each(|refined| selection.refine(refined));
    for (index, mut zone) in data.zones.iter().cloned().enumerate() {
        let failed = |source| RunError::Body { key: format!("{key}.zone.{index}"), source };
        refine(&mut zone.selection);
        body.zone(&zone).map_err(failed)?;
    }
    for (index, mut pin) in data.pins.iter().cloned().enumerate() {
        let failed = |source| RunError::Body { key: format!("{key}.pin.{index}"), source };
        refine(&mut pin.selection);
        body.pin(&pin).map_err(failed)?;
    }
    for (index, handle) in data.handles.iter().enumerate() {
        let key = format!("{key}.handle.{index}");
        let file = (&*input.document, &input.part);
        let mut follow = |path: &PathBuf| {
            let follow_key = format!("{key}.follow");
            let animation = animations.handle((data, handle), file, (path, follow_key.clone()))?;
            let Some(refined) = &refined else { return Ok(animation) };
            animation.refined(refined).map_err(|source| {
                let (key, path) = (follow_key, path.clone());
                RunError::HandleAnimation { key, path, source }
            })
        };
        let mut handle = handle.handle(&mut follow)?;
        refine(&mut handle.selection);
        body.handle(&handle).map_err(|source| RunError::Body { key, source })?;
    }
    let written = match &refined {
        None => written,
        Some(refined) => written.refined(&body, refined)?,
    };
    Ok((body, written))
}

#[cfg(test)]
mod tests {
    use supple::{BreakLimit, FractureOptions, Mesh};

    use super::*;

    /// Returns the error of a job with a body that can break.
    fn checked(format: &str) -> Result<(), OutputError> {
        let text = "[simulation]\nframes = 1\n[[body]]\nname = \"bar\"\nmesh = \"bar.obj\"\n";
        let overrides = [format!("output.format={format}")];
        let scene = Scene::parse(text, "scene.toml", Path::new("."), &overrides).unwrap();
        let vertices = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let mesh = Mesh::new(vertices, &[[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]).unwrap();
        let limit = FractureOptions::new(BreakLimit::Strain(0.1));
        let body = Body::builder(mesh).name("bar").cell_size(0.5).fracture(limit).build().unwrap();
        let simulation = Simulation::builder().body(body).build().unwrap();
        let prepared = Prepared { simulation, substeps: 1, inputs: Vec::new(), cautions: Vec::new() };
        prepared.check_topologies(&scene.output.format)
    }

    #[test]
    fn a_body_that_can_break_needs_a_format_with_faces_of_each_frame() {
        for format in ["obj", "ply", "usd", "html", r#"["obj", "usd"]"#] {
            checked(format).unwrap();
        }
        let error = checked(r#"["obj", "pc2"]"#).unwrap_err();
        assert!(error.is_input());
        assert_eq!(
            error.to_string(),
            "body `bar` can break (`body.bar.fracture`), and pc2 has the same faces in all frames: write obj, ply, \
             usd, usdz, html, vtu, lattice, film or gif, or remove the key"
        );
    }
}
