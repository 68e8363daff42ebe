//! Builds the simulation of a scene: reads meshes, builds lattices, adds pins, handles and colliders. Writes
//! no files.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::error::RunError;
use crate::frames::Source;
use crate::obj::{Document, Part};
use crate::scene::{BodyData, Scene};
use supple::{Body, Simulation};

/// A scene that is ready to run: the simulation at time 0, and the inputs of its bodies.
#[derive(Debug)]
pub struct Prepared {
    /// Simulation with all bodies and colliders, at time 0.
    pub simulation: Simulation,
    /// Steps per frame, at least 1.
    pub substeps: u32,
    /// Inputs, one per body.
    pub inputs: Vec<Input>,
}

/// Input of a body: an OBJ file, and the part of the file that is the body.
#[derive(Clone, Debug)]
pub struct Input {
    /// OBJ file. Bodies from the same file share one document.
    pub document: Arc<Document>,
    /// Part of the file that is the body.
    pub part: Part,
}

impl Input {
    /// Returns the source for a frame writer.
    pub fn source(&self) -> Source<'_> {
        Source::Document(&self.document, &self.part)
    }
}

/// Builds the simulation that a scene describes.
///
/// # Errors
///
/// If a mesh cannot be read or is invalid, a lattice does not fit in memory, a pin or a handle selects no
/// vertices, or the volume measure does not apply to a mesh.
pub fn prepare(scene: &Scene) -> Result<Prepared, RunError> {
    let mut documents = HashMap::new();
    let mut bodies = Vec::new();
    let mut inputs = Vec::new();
    for data in &scene.bodies {
        let document = read(&mut documents, &scene.resolve(&data.mesh))?;
        let part = document.part(data.object.as_deref())?;
        let body = build(data, &part)?;
        bodies.push(body);
        inputs.push(Input { document, part });
    }
    let mut builder = Simulation::builder()
        .gravity(scene.simulation.gravity)
        .fps(scene.simulation.fps)
        .substeps(scene.simulation.substeps.into())
        .threads(scene.simulation.threads)
        .sleep(scene.simulation.sleep);
    for body in bodies {
        builder = builder.body(body);
    }
    for collider in &scene.colliders {
        builder = builder.collider(collider.clone());
    }
    let simulation = builder.build().map_err(RunError::Simulation)?;
    let substeps = simulation.substeps() as u32;
    Ok(Prepared { simulation, substeps, inputs })
}

/// Returns the document of a file. Reads the file only if it is not in `documents`, and adds it there.
fn read(documents: &mut HashMap<PathBuf, Arc<Document>>, path: &Path) -> Result<Arc<Document>, RunError> {
    if let Some(document) = documents.get(path) {
        return Ok(document.clone());
    }
    let document = Arc::new(Document::read(path)?);
    documents.insert(path.to_owned(), document.clone());
    Ok(document)
}

/// Builds a body, and adds its zones, pins and handles.
fn build(data: &BodyData, part: &Part) -> Result<Body, RunError> {
    let key = format!("body.{}", data.name);
    let failed = |source| RunError::Body { key: key.clone(), source };
    let mut body = Body::builder(part.mesh().clone())
        .name(&data.name)
        .scale(data.scale)
        .resolution(data.resolution)
        .join(data.join)
        .material(data.material)
        .placement(data.placement)
        .volume(data.volume)
        .skin(data.skin)
        .build()
        .map_err(failed)?;
    for (index, zone) in data.zones.iter().enumerate() {
        let failed = |source| RunError::Body { key: format!("{key}.zone.{index}"), source };
        body.zone(zone).map_err(failed)?;
    }
    for (index, pin) in data.pins.iter().enumerate() {
        let failed = |source| RunError::Body { key: format!("{key}.pin.{index}"), source };
        body.pin(pin).map_err(failed)?;
    }
    for (index, handle) in data.handles.iter().enumerate() {
        let failed = |source| RunError::Body { key: format!("{key}.handle.{index}"), source };
        body.handle(handle).map_err(failed)?;
    }
    Ok(body)
}
