//! Builds the simulation of a scene: reads meshes, builds lattices, checks pins and handles. Writes no files.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use nalgebra::{Point3, Rotation3, Vector3};

use super::error::RunError;
use super::substeps::{Placed, substeps};
use crate::frames::Source;
use crate::obj::{Document, Part};
use crate::scene::{BodyData, Scene, Substeps};
use supple::euler_degrees;
use supple::{Body, Placement, Simulation};

/// A scene that is ready to run: the simulation at time 0, and the files of its bodies.
#[derive(Debug)]
pub struct Prepared {
    /// Simulation with all bodies and colliders, at time 0.
    pub simulation: Simulation,
    /// Steps per frame, at least 1.
    pub substeps: u32,
    /// Input of each body.
    pub inputs: Vec<Input>,
}

/// Input of a body.
#[derive(Clone, Debug)]
pub struct Input {
    /// OBJ file; bodies from the same file share it.
    pub document: Arc<Document>,
    /// Part of the file that makes up the body.
    pub part: Part,
}

impl Input {
    /// Returns the input as the source for a frame writer.
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
    let mut documents: Vec<(PathBuf, Arc<Document>)> = Vec::new();
    let mut bodies = Vec::new();
    let mut inputs = Vec::new();
    let mut placed = Vec::new();
    for data in &scene.bodies {
        let document = read(&mut documents, &scene.resolve(&data.mesh))?;
        let part = document.part(data.object.as_deref())?;
        let body = build(data, &part)?;
        placed.push(place(data, &body));
        bodies.push(body);
        inputs.push(Input { document, part });
    }
    let substeps = match scene.simulation.substeps {
        Substeps::Fixed(steps) => steps,
        Substeps::Auto => substeps(scene, &placed),
    };
    let mut builder = Simulation::builder()
        .gravity(scene.simulation.gravity)
        .dt(1.0 / (scene.simulation.fps * f64::from(substeps)))
        .substeps(u64::from(substeps))
        .threads(scene.simulation.threads);
    for body in bodies {
        builder = builder.body(body);
    }
    for collider in &scene.colliders {
        builder = builder.collider(collider.clone());
    }
    let simulation = builder.build().map_err(RunError::Simulation)?;
    Ok(Prepared { simulation, substeps, inputs })
}

/// Reads a file, or returns it from `documents` if it was read before.
fn read(documents: &mut Vec<(PathBuf, Arc<Document>)>, path: &Path) -> Result<Arc<Document>, RunError> {
    if let Some((_, document)) = documents.iter().find(|(known, _)| known == path) {
        return Ok(document.clone());
    }
    let document = Arc::new(Document::read(path)?);
    documents.push((path.to_owned(), document.clone()));
    Ok(document)
}

/// Builds a body with its pins and handles.
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
        .build()
        .map_err(failed)?;
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

/// Returns the bounding box of a placed body, which encloses the rotated bounding box of its mesh, and the
/// cell size.
fn place(data: &BodyData, body: &Body) -> Placed {
    let Placement { rotate, translate, .. } = data.placement;
    let rotation = Rotation3::from_matrix_unchecked(euler_degrees(rotate));
    let (low, high) = body.mesh().map_or_else(Default::default, |mesh| mesh.bounds());
    let half = (high - low) / 2.0;
    let extent: Vector3<f64> = rotation.matrix().abs() * half;
    let center: Point3<f64> = rotation * nalgebra::center(&low, &high) + Vector3::from(translate);
    Placed { low: center - extent, high: center + extent, cell_size: body.lattice().cell_size() }
}
