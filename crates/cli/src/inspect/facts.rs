//! The facts about a scene before it runs, as `--json` prints them.

use serde::Serialize;
use supple::{Body, Lattice, Preservation};
use supple_io::frames::{Format, shared_normals};
use supple_io::run::{Input, Prepared};
use supple_io::scene::{BodyData, Scene, Substeps};

/// A scene.
#[derive(Debug, Serialize)]
pub(super) struct Facts {
    pub(super) input: String,
    pub(super) frames: u32,
    pub(super) fps: f64,
    pub(super) seconds: f64,
    pub(super) substeps: u32,
    /// Whether the number of steps was left to the program.
    pub(super) substeps_auto: bool,
    pub(super) threads: usize,
    pub(super) simd: String,
    pub(super) directory: String,
    pub(super) format: &'static str,
    /// Bytes of all frames.
    pub(super) bytes_on_disk: u64,
    pub(super) bodies: Vec<BodyFacts>,
    pub(super) colliders: usize,
    /// The stages that run, in order.
    pub(super) plan: String,
    pub(super) notes: Vec<String>,
}

/// A body.
#[derive(Debug, Serialize)]
pub(super) struct BodyFacts {
    pub(super) name: String,
    pub(super) mesh: MeshFacts,
    pub(super) lattice: LatticeFacts,
    pub(super) half_width: usize,
    /// Bytes of a frame.
    pub(super) frame_bytes: u64,
    /// What a reader of a point cache must know.
    pub(super) pc2: Vec<String>,
}

/// A mesh.
#[derive(Debug, Serialize)]
pub(super) struct MeshFacts {
    pub(super) file: String,
    pub(super) object: Option<String>,
    pub(super) vertices: usize,
    pub(super) faces: usize,
    pub(super) closed: bool,
    pub(super) flipped: bool,
    pub(super) components: usize,
    /// Magnitude, in the model's frame after `scale`.
    pub(super) volume: f64,
    pub(super) low: [f64; 3],
    pub(super) high: [f64; 3],
    pub(super) welded_seam_vertices: usize,
    pub(super) unused_vertices: usize,
    pub(super) boundary_edges: usize,
    pub(super) non_manifold_edges: usize,
    pub(super) misoriented_edges: usize,
    pub(super) degenerate_faces: usize,
    pub(super) duplicate_faces: usize,
    pub(super) two_sided_faces: usize,
    /// `vn` of the file whose corners have different normals, and therefore get their mean.
    pub(super) shared_normals: usize,
    pub(super) short_faces: usize,
    pub(super) ignored_statements: Vec<String>,
    pub(super) missing_libraries: Vec<String>,
    pub(super) groups: Vec<String>,
}

/// A lattice.
#[derive(Debug, Serialize)]
pub(super) struct LatticeFacts {
    pub(super) vertices: usize,
    pub(super) cells: usize,
    pub(super) cell_size: f64,
    pub(super) components: usize,
    /// The openings of the mesh let the outside in, so that only its skin is filled.
    pub(super) shell: bool,
    pub(super) surface_cells: usize,
    pub(super) filled_cells: usize,
    pub(super) bridge_cells: usize,
    pub(super) floating: Vec<FloatingFacts>,
    /// Groups of mesh components that cells hold together.
    pub(super) glued: Vec<Vec<u32>>,
    /// Bytes of the lattice.
    pub(super) bytes: usize,
    /// Volume at rest, by each measure that the body has.
    pub(super) volumes: Vec<(String, f64)>,
    /// The measure that is kept, if any is.
    pub(super) measure: Option<String>,
}

/// A part that floats apart from the largest.
#[derive(Debug, Serialize)]
pub(super) struct FloatingFacts {
    pub(super) cells: usize,
    pub(super) mesh_components: Vec<u32>,
    pub(super) joined: bool,
}

impl Facts {
    /// What is known about a prepared scene.
    pub(super) fn of(input: &str, scene: &Scene, prepared: &Prepared) -> Self {
        let bodies: Vec<BodyFacts> =
            (0..scene.bodies.len()).map(|index| body(scene, prepared, index)).collect();
        let simulation = &scene.simulation;
        let frames = u64::from(simulation.frames) + 1;
        Self {
            input: input.to_owned(),
            frames: simulation.frames,
            fps: simulation.fps,
            seconds: f64::from(simulation.frames) / simulation.fps,
            substeps: prepared.substeps,
            substeps_auto: simulation.substeps == Substeps::Auto,
            threads: prepared.simulation.threads(),
            simd: supple::simd_level().to_string(),
            directory: scene.output_folder().display().to_string(),
            format: scene.output.format.name(),
            bytes_on_disk: bodies.iter().map(|body| body.frame_bytes * frames).sum(),
            bodies,
            colliders: scene.colliders.len(),
            plan: prepared.simulation.plan().to_string(),
            notes: notes(scene),
        }
    }
}

/// What a user may not expect.
fn notes(scene: &Scene) -> Vec<String> {
    let mut notes = Vec::new();
    if scene.bodies.len() > 1 {
        notes.push("contact between bodies is not simulated: they pass through each other".to_owned());
    }
    notes
}

/// The facts about a body, by its number in the scene.
fn body(scene: &Scene, prepared: &Prepared, index: usize) -> BodyFacts {
    let (data, input) = (&scene.bodies[index], &prepared.inputs[index]);
    let body = prepared.simulation.body(index);
    let source = input.source();
    BodyFacts {
        name: data.name.clone(),
        mesh: mesh(scene, data, input, &body),
        lattice: lattice(body.lattice(), &body),
        half_width: body.half_width(),
        frame_bytes: source.frame_bytes(scene.output.format),
        pc2: pc2(source.points(), scene, input),
    }
}

fn mesh(scene: &Scene, data: &BodyData, input: &Input, body: &Body) -> MeshFacts {
    // As it lies in the lattice: after `scale`.
    let mesh = body.mesh().unwrap_or_else(|| input.part.mesh());
    let (topology, (low, high)) = (mesh.topology(), mesh.bounds());
    let document = &input.document;
    let libraries = document.libraries();
    let ignored = |statement: &supple_io::obj::IgnoredStatement| {
        let times =
            if statement.count == 1 { String::new() } else { format!(" ({} times)", statement.count) };
        format!("`{}` in line {}{times}", statement.keyword, statement.first_line)
    };
    MeshFacts {
        file: scene.resolve(&data.mesh).display().to_string(),
        object: data.object.clone(),
        vertices: mesh.vertices().len(),
        faces: mesh.face_count(),
        closed: mesh.is_closed(),
        flipped: topology.is_flipped(),
        components: topology.components.len(),
        volume: mesh.volume(),
        low: low.into(),
        high: high.into(),
        welded_seam_vertices: topology.seam_vertices,
        unused_vertices: topology.unused_vertices,
        boundary_edges: topology.boundary_edges,
        non_manifold_edges: topology.non_manifold_edges,
        misoriented_edges: topology.misoriented_edges,
        degenerate_faces: topology.degenerate_faces,
        duplicate_faces: topology.duplicate_faces,
        two_sided_faces: topology.two_sided_faces,
        shared_normals: shared_normals(document, &input.part),
        short_faces: document.short_faces().0,
        ignored_statements: document.ignored_statements().iter().map(ignored).collect(),
        missing_libraries: libraries.into_iter().filter(|l| !l.exists).map(|l| l.name).collect(),
        groups: document.groups().map(|group| group.name.clone()).collect(),
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
        glued: report.glued.clone(),
        bytes: lattice.memory(),
        volumes: volumes.volumes.iter().map(|(measure, v)| (measure.to_string(), v.rest)).collect(),
        measure: (body.volume_options().measure != Preservation::Off).then(|| volumes.measure.to_string()),
    }
}

/// What a reader of a point cache must know: the format holds neither faces nor names.
fn pc2(points: usize, scene: &Scene, input: &Input) -> Vec<String> {
    let mut facts = vec![
        format!(
            "{points} points, all `v` lines of {} in their order: load it without merging, splitting or \
             reordering vertices",
            input.document.path().display()
        ),
        "positions are in world space, in the axes of the scene; do not turn or place the mesh again"
            .to_owned(),
    ];
    if input.part.mesh().vertices().len() < points {
        facts.push("points of other objects of the file stay where they are".to_owned());
    }
    let samples = u64::from(scene.simulation.frames) + 1;
    facts.push(format!(
        "{samples} samples at {} a second, {} bytes",
        scene.simulation.fps,
        32 + samples * input.source().frame_bytes(Format::Pc2)
    ));
    facts
}
