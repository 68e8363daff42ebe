//! What is known about a scene before it runs, in the shape of the JSON that `--json` prints.

use serde::Serialize;
use supple_io::run::Prepared;
use supple_io::scene::{Scene, Substeps};

use super::body;

/// A scene.
#[derive(Debug, Serialize)]
pub(crate) struct Facts {
    pub(crate) input: String,
    pub(crate) frames: u32,
    pub(crate) fps: f64,
    pub(crate) seconds: f64,
    pub(crate) substeps: u32,
    /// Whether the number of steps was left to the program.
    pub(crate) substeps_auto: bool,
    pub(crate) threads: usize,
    pub(crate) simd: String,
    pub(crate) directory: String,
    pub(crate) format: &'static str,
    /// Bytes of all frames.
    pub(crate) bytes_on_disk: u64,
    pub(crate) bodies: Vec<BodyFacts>,
    pub(crate) colliders: usize,
    /// The stages that run, in order.
    pub(crate) plan: String,
    pub(crate) notes: Vec<String>,
}

/// A body.
#[derive(Debug, Serialize)]
pub(crate) struct BodyFacts {
    pub(crate) name: String,
    pub(crate) mesh: MeshFacts,
    pub(crate) lattice: LatticeFacts,
    pub(crate) half_width: usize,
    /// Bytes of a frame.
    pub(crate) frame_bytes: u64,
    /// What a reader of a point cache must know.
    pub(crate) pc2: Vec<String>,
}

/// A mesh.
#[derive(Debug, Serialize)]
pub(crate) struct MeshFacts {
    pub(crate) file: String,
    pub(crate) object: Option<String>,
    pub(crate) vertices: usize,
    pub(crate) faces: usize,
    pub(crate) closed: bool,
    pub(crate) flipped: bool,
    pub(crate) components: usize,
    /// Magnitude, in the model's frame after `scale`.
    pub(crate) volume: f64,
    pub(crate) low: [f64; 3],
    pub(crate) high: [f64; 3],
    pub(crate) welded_seam_vertices: usize,
    pub(crate) unused_vertices: usize,
    pub(crate) boundary_edges: usize,
    pub(crate) non_manifold_edges: usize,
    pub(crate) misoriented_edges: usize,
    pub(crate) degenerate_faces: usize,
    pub(crate) duplicate_faces: usize,
    pub(crate) two_sided_faces: usize,
    /// `vn` of the file whose corners have different normals, and therefore get their mean.
    pub(crate) shared_normals: usize,
    pub(crate) short_faces: usize,
    pub(crate) ignored_statements: Vec<String>,
    pub(crate) missing_libraries: Vec<String>,
    pub(crate) groups: Vec<String>,
}

/// A lattice.
#[derive(Debug, Serialize)]
pub(crate) struct LatticeFacts {
    pub(crate) vertices: usize,
    pub(crate) cells: usize,
    pub(crate) cell_size: f64,
    pub(crate) components: usize,
    /// The openings of the mesh let the outside in, so that only its skin is filled.
    pub(crate) shell: bool,
    pub(crate) surface_cells: usize,
    pub(crate) filled_cells: usize,
    pub(crate) bridge_cells: usize,
    pub(crate) floating: Vec<FloatingFacts>,
    /// Groups of mesh components that cells hold together.
    pub(crate) glued: Vec<Vec<u32>>,
    /// Bytes of the lattice.
    pub(crate) bytes: usize,
    /// Volume at rest, by each measure that the body has.
    pub(crate) volumes: Vec<(String, f64)>,
    /// The measure that is kept, if any is.
    pub(crate) measure: Option<String>,
}

/// A part that floats apart from the largest.
#[derive(Debug, Serialize)]
pub(crate) struct FloatingFacts {
    pub(crate) cells: usize,
    pub(crate) mesh_components: Vec<u32>,
    pub(crate) joined: bool,
}

impl Facts {
    /// What is known about a prepared scene.
    pub(crate) fn of(input: &str, scene: &Scene, prepared: &Prepared) -> Self {
        let bodies: Vec<BodyFacts> =
            (0..scene.bodies.len()).map(|index| body::of(scene, prepared, index)).collect();
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
