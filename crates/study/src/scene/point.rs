//! One measured point of a study, as the files have it, and the fronts that it may be on.

use serde::{Deserialize, Serialize};

use super::flight::Free;
use super::setting::Axis;
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
    pub region_factor: f64,
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

/// Distances of lattice vertices from where they should be.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Distances {
    /// Root mean square, in cells.
    pub rms_cells: f64,
    /// Greatest, in cells.
    pub max_cells: f64,
    /// Root mean square, in scene units.
    pub rms: f64,
    /// Greatest, in scene units.
    pub max: f64,
}

/// The errors that have a front.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Front {
    /// `surface_rms`.
    Surface,
    /// `mesh_volume`, or `cells_volume` where a mesh encloses none.
    Volume,
    /// `cell_volumes`.
    Cells,
    /// The root mean square of the path, in cells.
    Path,
}

impl Front {
    /// All of them, in the order of the table.
    pub const ALL: [Self; 4] = [Self::Surface, Self::Volume, Self::Cells, Self::Path];

    /// Its letter in the table.
    pub fn letter(self) -> char {
        match self {
            Self::Surface => 's',
            Self::Volume => 'v',
            Self::Cells => 'c',
            Self::Path => 'p',
        }
    }

    /// The error of a point. `None` where it is not known, and for the surface of the finest lattice, which the others are
    /// compared with. The path of the naive sums over staircase regions is the truth too, but takes part, with an error of
    /// 0: it is what being right costs.
    pub fn error(self, point: &Point) -> Option<f64> {
        let errors = &point.errors;
        match self {
            Self::Surface => errors.surface_rms.filter(|_| !point.finest),
            Self::Volume => errors.mesh_volume.or(errors.cells_volume),
            Self::Cells => errors.cell_volumes,
            Self::Path => errors.path.map(|path| path.distances.rms_cells),
        }
        .filter(|error| error.is_finite())
    }

    /// Whether the error of a point says something new where the scene itself keeps its volume by `method`: the path does
    /// not know of the correction.
    pub(super) fn tells(self, point: &Point, method: &str) -> bool {
        self != Self::Path || point.method == method
    }

    /// The cost of a point that may be on the front: what is another material answers another question.
    fn cost(self, point: &Point, method: &str) -> Option<[f64; 2]> {
        let takes_part = point.region_factor == 1.0 && !point.softened && self.tells(point, method);
        let error = self.error(point).filter(|_| takes_part)?;
        Some([point.timing.total.median, error])
    }
}

/// Marks the fronts of a scene that itself keeps its volume by `method`.
pub(super) fn mark(points: &mut [Point], method: &str) {
    for point in &mut *points {
        point.front.clear();
    }
    for front in Front::ALL {
        let costs: Vec<_> = points.iter().map(|point| front.cost(point, method)).collect();
        for (point, cost) in points.iter_mut().zip(&costs) {
            let Some(own) = cost else { continue };
            if !costs.iter().flatten().any(|other| dominates(other, own)) {
                point.front.push(front);
            }
        }
    }
}

/// Whether a point is nowhere worse than another, and somewhere better.
fn dominates(a: &[f64; 2], b: &[f64; 2]) -> bool {
    a[0] <= b[0] && a[1] <= b[1] && a != b
}
