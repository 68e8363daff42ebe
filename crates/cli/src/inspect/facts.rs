//! Collects facts about a scene that has not run. `--json` prints them; the field names are the JSON keys.

use serde::Serialize;
use supple::{Body, HalfWidth, Lattice, Plan, Preservation, Shape, StepReason};
use supple_io::counted;
use supple_io::frames::{Format, lattice_frame_bytes};
use supple_io::run::{Input, Prepared};
use supple_io::scene::{ColliderData, Scene, Substeps};

use super::contact::{ContactFacts, TouchingFacts, contact, touching};
use super::estimate::Estimate;
use super::material::MaterialFacts;
use super::mesh::{MeshFacts, mesh};
use super::placed::{Placed, SelectionFacts, ZoneFacts};
use super::warnings::warnings;

/// Facts about a scene.
#[derive(Debug, Serialize)]
pub(super) struct Facts {
    pub(super) input: String,
    pub(super) frames: u32,
    pub(super) fps: f64,
    pub(super) seconds: f64,
    pub(super) substeps: u32,
    /// Whether the program chose the number of steps per frame.
    pub(super) substeps_auto: bool,
    /// What determined the number of steps; `None` if the scene states it.
    pub(super) substeps_reason: Option<String>,
    pub(super) threads: usize,
    pub(super) simd: String,
    pub(super) directory: String,
    pub(super) format: String,
    /// Size of all frames on disk, in bytes.
    pub(super) bytes_on_disk: u64,
    /// What a run needs; `None` if it is not measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) estimate: Option<Estimate>,
    pub(super) bodies: Vec<BodyFacts>,
    pub(super) colliders: usize,
    /// The colliders that are meshes.
    pub(super) collider_meshes: Vec<ColliderMeshFacts>,
    pub(super) contact: ContactFacts,
    /// The stages of a step and of an evaluation, in order, with the memory of each.
    pub(super) plan: String,
    /// Probable mistakes in the scene.
    pub(super) warnings: Vec<String>,
}

/// Facts about a collider that is a mesh.
#[derive(Debug, Serialize)]
pub(super) struct ColliderMeshFacts {
    /// Index of the collider, from 0.
    pub(super) collider: usize,
    /// Model file, as in the scene.
    pub(super) file: String,
    pub(super) triangles: usize,
    /// Whether the mesh is a solid; otherwise it is a shell.
    pub(super) closed: bool,
}

/// Facts about a body.
#[derive(Debug, Serialize)]
pub(super) struct BodyFacts {
    pub(super) name: String,
    pub(super) mesh: MeshFacts,
    pub(super) lattice: LatticeFacts,
    /// One entry per zone, in the order of the scene.
    pub(super) zones: Vec<ZoneFacts>,
    /// One entry per pin, in the order of the scene.
    pub(super) pins: Vec<SelectionFacts>,
    /// One entry per handle, in the order of the scene.
    pub(super) handles: Vec<SelectionFacts>,
    #[serde(flatten)]
    pub(super) material: Option<MaterialFacts>,
    /// How the body touches other bodies and itself; `None` if it can touch neither.
    pub(super) touching: Option<TouchingFacts>,
    /// Half-width of the regions, in cells; `None` for a rigid body.
    pub(super) half_width: Option<HalfWidth>,
    pub(super) rigid: bool,
    /// Size of a frame on disk, in bytes.
    pub(super) frame_bytes: u64,
    /// Memory of the lattice, the state and the stages of the simulation, in bytes.
    pub(super) memory_bytes: usize,
    /// Notes for loading a PC2 point cache.
    pub(super) pc2: Vec<String>,
}

/// Facts about a lattice.
#[derive(Debug, Serialize)]
pub(super) struct LatticeFacts {
    pub(super) vertices: usize,
    pub(super) cells: usize,
    pub(super) cell_size: f64,
    pub(super) components: usize,
    /// Whether the mesh has openings wider than a cell, so that only the cells on its surface are occupied.
    pub(super) shell: bool,
    pub(super) surface_cells: usize,
    pub(super) filled_cells: usize,
    pub(super) bridge_cells: usize,
    /// Connected parts of the cells that are separate from the largest part before joining.
    pub(super) floating: Vec<FloatingFacts>,
    /// Number of entries of `floating` that a bridge of cells joins to another part.
    pub(super) joined_parts: usize,
    /// Number of entries of `floating` that are not joined.
    pub(super) separate_parts: usize,
    /// Groups of mesh components (indices from 0) that are connected in the lattice without a bridge: they
    /// share cells, their cells touch, or one encloses another.
    pub(super) glued: Vec<Vec<u32>>,
    /// Number of mesh components in all groups of `glued`.
    pub(super) glued_components: usize,
    /// Memory of the lattice, in bytes.
    pub(super) bytes: usize,
    /// Each available volume measure, and the rest volume by this measure.
    pub(super) volumes: Vec<(String, f64)>,
    /// Measure of the preserved volume; `None` if the volume is not preserved.
    pub(super) measure: Option<String>,
}

/// Facts about a connected part of the cells that is separate from the largest part before joining.
#[derive(Debug, Serialize)]
pub(super) struct FloatingFacts {
    pub(super) cells: usize,
    /// Indices, from 0, of the mesh components in this part.
    pub(super) mesh_components: Vec<u32>,
    /// Whether a bridge of cells joins this part to another one.
    pub(super) joined: bool,
}

impl Facts {
    /// Collects the facts about a prepared scene.
    pub(super) fn new(input: &str, scene: &Scene, prepared: &Prepared) -> Self {
        let plan = prepared.simulation.plan();
        let bodies: Vec<BodyFacts> =
            (0..scene.bodies.len()).map(|index| body(scene, prepared, &plan, index)).collect();
        let simulation = &scene.simulation;
        let frames = u64::from(simulation.frames) + 1;
        Self {
            input: input.to_owned(),
            frames: simulation.frames,
            fps: simulation.fps,
            seconds: f64::from(simulation.frames) / simulation.fps,
            substeps: prepared.substeps,
            substeps_auto: simulation.substeps == Substeps::Auto,
            substeps_reason: substeps_reason(prepared),
            threads: prepared.simulation.threads(),
            simd: supple::simd_level().to_string(),
            directory: scene.output_directory().display().to_string(),
            format: scene.output.format.to_string(),
            bytes_on_disk: bodies.iter().map(|body| body.frame_bytes * frames).sum(),
            estimate: None,
            bodies,
            colliders: scene.colliders.len(),
            collider_meshes: collider_meshes(scene, prepared),
            contact: contact(scene, prepared),
            plan: plan.to_string(),
            warnings: warnings(scene, prepared),
        }
    }
}

/// Returns the facts about the colliders that are meshes.
fn collider_meshes(scene: &Scene, prepared: &Prepared) -> Vec<ColliderMeshFacts> {
    let facts = |(collider, data): (usize, &ColliderData)| {
        let Shape::Mesh { mesh, .. } = &prepared.simulation.collider(collider).description().shape else {
            return None;
        };
        let file = data.mesh()?.display().to_string();
        Some(ColliderMeshFacts {
            collider,
            file,
            triangles: mesh.mesh().triangles().len(),
            closed: mesh.is_closed(),
        })
    };
    scene.colliders.iter().enumerate().filter_map(facts).collect()
}

/// Returns what determined the automatic number of steps per frame.
fn substeps_reason(prepared: &Prepared) -> Option<String> {
    let chosen = prepared.simulation.chosen_substeps()?;
    let description = chosen.reason.description();
    Some(match chosen.reason {
        StepReason::One => description.to_owned(),
        _ => format!("{description} {}", prepared.simulation.bodies()[chosen.body].name()),
    })
}

/// Collects the facts about the body with the given index.
fn body(scene: &Scene, prepared: &Prepared, plan: &Plan, index: usize) -> BodyFacts {
    let (data, input) = (&scene.bodies[index], &prepared.inputs[index]);
    let body = prepared.simulation.body(index);
    let source = input.source();
    let placed = Placed::new(data, &body);
    let frame_bytes = |format| match format {
        Format::Lattice => lattice_frame_bytes(body.lattice()),
        _ => source.frame_bytes(format),
    };
    BodyFacts {
        name: data.name.clone(),
        mesh: mesh(scene, data, input, &placed),
        zones: data.zones.iter().map(|zone| placed.zone(zone)).collect(),
        pins: (0..).zip(&data.pins).map(|(index, pin)| placed.selection(index, &pin.selection)).collect(),
        handles: (data.pins.len()..)
            .zip(&data.handles)
            .map(|(index, handle)| placed.handle(index, scene, (data, handle)))
            .collect(),
        lattice: lattice(body.lattice(), &body),
        material: MaterialFacts::new(body),
        touching: touching(scene, &body, &plan.bodies[index]),
        half_width: (!body.is_rigid()).then(|| body.half_width()),
        rigid: body.is_rigid(),
        frame_bytes: scene.output.format.iter().map(frame_bytes).sum(),
        memory_bytes: plan.bodies[index].bytes(),
        // A point cache cannot contain a body that breaks.
        pc2: if body.fracture().is_some() { Vec::new() } else { pc2(source.points(), scene, input) },
    }
}

fn lattice(lattice: &Lattice, body: &Body) -> LatticeFacts {
    let report = lattice.report();
    let volumes = body.alone().volume_report();
    let floating = |part: &supple::FloatingPart| FloatingFacts {
        cells: part.cells,
        mesh_components: part.mesh_components.clone(),
        joined: part.joined,
    };
    LatticeFacts {
        vertices: lattice.len(),
        cells: lattice.cells().len(),
        cell_size: lattice.cell_size(),
        components: lattice.components().count,
        shell: report.shell,
        surface_cells: report.surface_cells,
        filled_cells: report.filled_cells,
        bridge_cells: report.bridge_cells,
        floating: report.floating.iter().map(floating).collect(),
        joined_parts: report.floating.iter().filter(|part| part.joined).count(),
        separate_parts: report.floating.iter().filter(|part| !part.joined).count(),
        glued: report.glued.clone(),
        glued_components: report.glued.iter().map(Vec::len).sum(),
        bytes: lattice.memory(),
        volumes: volumes.volumes.iter().map(|(measure, v)| (measure.to_string(), v.rest)).collect(),
        measure: (body.volume_options().measure != Preservation::Off).then(|| volumes.measure.to_string()),
    }
}

/// Returns notes for loading a point cache with `points` points per sample. A PC2 file contains neither faces
/// nor names.
fn pc2(points: usize, scene: &Scene, input: &Input) -> Vec<String> {
    let file = input.document.path().display();
    let order = match input.document.is_obj() {
        true => format!("all `v` lines of {file} in file order: import that file"),
        false => {
            format!("the vertices of {file} as in OBJ frames (--format obj,pc2): import the first of them")
        }
    };
    let mut facts = vec![
        format!("{}, {order} without merging, splitting or reordering vertices", counted(points, "point")),
        "positions are in world space, in the axes of the scene; do not transform the mesh".to_owned(),
    ];
    if input.part.mesh().vertices().len() < points {
        facts.push("points of other objects in the file do not move".to_owned());
    }
    let samples = u64::from(scene.simulation.frames) + 1;
    facts.push(format!(
        "samples in the file: {samples}, at {} per second; file size: {} bytes",
        scene.simulation.fps,
        32 + samples * input.source().frame_bytes(Format::Pc2)
    ));
    facts
}
