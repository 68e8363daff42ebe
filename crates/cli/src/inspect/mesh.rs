//! Facts about the mesh of a body.

use serde::Serialize;
use supple::{Mesh, Refine};
use supple_io::frames::count_shared_normals;
use supple_io::model;
use supple_io::run::Input;
use supple_io::scene::{BodyData, Scene};

use super::placed::Placed;

/// Facts about a mesh.
#[derive(Debug, Serialize)]
pub(super) struct MeshFacts {
    pub(super) file: String,
    pub(super) object: Option<String>,
    pub(super) vertices: usize,
    pub(super) faces: usize,
    pub(super) closed: bool,
    /// Rule by which points are inside: `closed`, `winding_number` or `sheet`.
    pub(super) interior: &'static str,
    /// Mass of the body.
    pub(super) mass: f64,
    /// Whether the mesh is closed and its faces point inwards.
    pub(super) flipped: bool,
    pub(super) components: usize,
    /// Magnitude of the enclosed volume, after `scale`.
    pub(super) volume: f64,
    /// Smallest coordinates, after `scale` and before `rotate` and `translate`.
    pub(super) low: [f64; 3],
    /// Largest coordinates, after `scale` and before `rotate` and `translate`.
    pub(super) high: [f64; 3],
    /// Smallest coordinates in world space at frame 0, after `scale`, `rotate` and `translate`.
    pub(super) world_low: [f64; 3],
    /// Largest coordinates in world space at frame 0, after `scale`, `rotate` and `translate`.
    pub(super) world_high: [f64; 3],
    /// Number of used vertices at the position of an earlier vertex.
    pub(super) welded_seam_vertices: usize,
    /// Greatest distance of vertices that are welded, in units of length.
    pub(super) weld_distance: f64,
    /// Number of vertices on open edges that nearly meet another one.
    pub(super) near_misses: usize,
    /// Greatest distance of such vertices, in units of length.
    pub(super) near_miss_distance: f64,
    pub(super) unused_vertices: usize,
    pub(super) boundary_edges: usize,
    pub(super) non_manifold_edges: usize,
    pub(super) misoriented_edges: usize,
    pub(super) degenerate_faces: usize,
    pub(super) duplicate_faces: usize,
    pub(super) two_sided_faces: usize,
    /// Number of `vn` lines shared by corners at different positions. The normals of such corners differ once
    /// the surface bends; frames contain their mean.
    pub(super) shared_normals: usize,
    /// Number of `f` lines with fewer than three corners, which the mesh omits.
    pub(super) short_faces: usize,
    pub(super) ignored_statements: Vec<String>,
    /// Parts of a file of another format than OBJ that are not read.
    pub(super) ignored_parts: Vec<String>,
    pub(super) missing_libraries: Vec<String>,
    pub(super) groups: Vec<String>,
    /// One entry per map that selections can name, in the order of the names.
    pub(super) maps: Vec<MapFacts>,
}

/// Facts about a map: numbers of the vertices by the file.
#[derive(Debug, Serialize)]
pub(super) struct MapFacts {
    pub(super) name: String,
    /// Least number of a vertex of the body.
    pub(super) least: f32,
    /// Greatest number of a vertex of the body.
    pub(super) greatest: f32,
}

/// Returns the facts about the mesh of a body.
pub(super) fn mesh(scene: &Scene, data: &BodyData, input: &Input, placed: &Placed<'_>) -> MeshFacts {
    // The mesh of the body is scaled by `scale`; `part.mesh()` is as in the file.
    let mesh = placed.body().mesh().unwrap_or_else(|| input.part.mesh());
    let (world_low, world_high) = placed.bounds();
    let (topology, (low, high)) = (mesh.topology(), mesh.bounds());
    let document = &input.document;
    let libraries = document.libraries();
    let ignored = |statement: &supple_io::obj::IgnoredStatement| {
        let (keyword, line) = (&statement.keyword, statement.first_line);
        match statement.count {
            1 => format!("`{keyword}` in line {line}"),
            count => format!("`{keyword}` in {count} lines, first in line {line}"),
        }
    };
    MeshFacts {
        file: scene.resolve(&data.mesh).display().to_string(),
        object: data.object.clone(),
        vertices: mesh.vertices().len(),
        faces: mesh.face_count(),
        closed: mesh.is_closed(),
        interior: mesh.interior().name(),
        mass: placed.body().mass(),
        flipped: topology.is_flipped(),
        components: topology.components.len(),
        volume: mesh.volume(),
        low: low.into(),
        high: high.into(),
        world_low,
        world_high,
        welded_seam_vertices: topology.seam_vertices,
        weld_distance: weld_distance(mesh),
        near_misses: topology.near_misses,
        near_miss_distance: topology.near_miss_distance,
        unused_vertices: topology.unused_vertices,
        boundary_edges: topology.boundary_edges,
        non_manifold_edges: topology.non_manifold_edges,
        misoriented_edges: topology.misoriented_edges,
        degenerate_faces: topology.degenerate_faces,
        duplicate_faces: topology.duplicate_faces,
        two_sided_faces: topology.two_sided_faces,
        shared_normals: count_shared_normals(document, &input.part),
        short_faces: document.short_faces().0,
        ignored_statements: document.ignored_statements().iter().map(ignored).collect(),
        ignored_parts: document.ignored_parts().to_vec(),
        missing_libraries: libraries.into_iter().filter(|l| !l.exists).map(|l| l.name).collect(),
        groups: document.groups().map(|group| group.name.clone()).collect(),
        maps: maps(scene, data, input),
    }
}

/// Returns the greatest distance of vertices that are welded.
fn weld_distance(mesh: &Mesh) -> f64 {
    let vertices = mesh.vertices();
    let welded = vertices.iter().zip(mesh.weld());
    welded.map(|(vertex, &first)| (vertex - vertices[first as usize]).norm()).fold(0.0, f64::max)
}

/// Returns the facts about the maps of the file of a body.
fn maps(scene: &Scene, data: &BodyData, input: &Input) -> Vec<MapFacts> {
    let mesh = match data.refine {
        Refine::Off => Some(input.part.clone().with_maps(&input.document).into_mesh()),
        // The document of a refined mesh has more vertices than the file.
        _ => model::read(scene.resolve(&data.mesh), data.object.as_deref()).ok(),
    };
    let range = |values: &[f32]| {
        let each = |choose: fn(f32, f32) -> f32| values.iter().copied().reduce(choose).unwrap_or_default();
        (each(f32::min), each(f32::max))
    };
    let facts = |(name, values): &(String, Vec<f32>)| {
        let (least, greatest) = range(values);
        MapFacts { name: name.clone(), least, greatest }
    };
    mesh.iter().flat_map(|mesh| mesh.maps()).map(facts).collect()
}
