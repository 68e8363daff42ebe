//! One measured point of a study, as the files have it.

use serde::{Deserialize, Serialize};

use crate::distance::Distances;
use crate::free::Free;
use crate::front::Front;
use crate::setting::Axis;
use crate::timing::Timing;

/// One measured point of a study. Where a scene has several bodies, `half_width`, `cell_size` and `alpha` are those of the
/// first; errors are those of all.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// Its name, one of a kind in the study.
    pub name: String,
    /// The axis of the matrix that it is on.
    pub axis: Axis,
    /// How the volume is kept: `off`, `mesh global`.
    pub method: String,
    /// How the goal positions are summed: `fast`, `naive`, `breadth-first`.
    pub sums: String,
    /// Lattice vertices of all bodies.
    pub lattice_vertices: usize,
    /// Edge of a cell, in scene units.
    pub cell_size: f64,
    /// Half-width of the regions, in cells.
    pub half_width: usize,
    /// Radius of the regions over that of the scene; another one than 1 is another material.
    pub reach: f64,
    /// Steps a frame.
    pub substeps: u32,
    /// Stiffness in a step.
    pub alpha: f64,
    /// Whether a body is softer than asked, because steps are longer than a sixth of its period.
    pub softened: bool,
    /// Whether this is the finest lattice, whose surface the others are compared with.
    pub finest: bool,
    /// What a frame takes.
    pub timing: Timing,
    /// How wrong it is.
    pub errors: Errors,
    /// What free flight keeps; of the fast sums.
    pub free: Option<Free>,
    /// The errors by which nothing in the study is both faster and better.
    pub front: Vec<Front>,
}

/// How wrong a point is. What is not known is `None`: its naive sums take too long, a mesh encloses no volume. So are volumes
/// and surfaces of naive sums that are not followed through the whole motion: its first frames deform a body little.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Errors {
    /// Goal positions from those of the naive sums over staircase regions, at the same positions.
    pub goals: Option<Distances>,
    /// Lattice vertices from where these sums take them.
    pub path: Option<Path>,
    /// Greatest relative error of the volume that the meshes enclose, over all frames.
    pub mesh_volume: Option<f64>,
    /// Greatest relative error of the volume of the cells together, over all frames.
    pub cells_volume: Option<f64>,
    /// Root mean square of the relative errors of the volumes of single cells.
    pub cell_volumes: Option<f64>,
    /// Root mean square distance of mesh vertices from those of the finest lattice, over the diagonal.
    pub surface_rms: Option<f64>,
    /// Hausdorff distance of the surfaces, over the diagonal.
    pub surface_hausdorff: Option<f64>,
    /// Frames in which the correction of any body met its cap, each once.
    pub capped: u32,
}

/// How far vertices are from a path.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Path {
    /// Through so many frames from the start.
    pub frames: u32,
    /// The distances, over all of them.
    #[serde(flatten)]
    pub distances: Distances,
}
