//! Defines the results of a measured point of a study, and finds the Pareto fronts.

use serde::{Deserialize, Serialize};
use supple::HalfWidth;

use super::flight::Free;
use super::setting::Axis;
use crate::timing::Timing;

/// A measured point of a study: the scene run with one setting. In a scene with several bodies, `half_width`,
/// `cell_size` and `alpha` are values of the first body; errors are maxima or means over all bodies.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// Name, unique in the study.
    pub name: String,
    /// The parameter in which the point differs from the scene.
    pub axis: Axis,
    /// Volume preservation, e.g. `off` or `mesh global`.
    pub method: String,
    /// Summation of the goal positions: `fast`, `naive` or `breadth-first`.
    pub sums: String,
    /// Number of lattice vertices of all bodies.
    pub lattice_vertices: usize,
    /// Edge of a cell, in scene units.
    pub cell_size: f64,
    /// Half-width of the regions, in cells.
    pub half_width: HalfWidth,
    /// Radius of the regions relative to the scene's; a value other than 1 is another material.
    pub region_factor: f64,
    /// Steps per frame.
    pub substeps: u32,
    /// Stiffness per step.
    pub alpha: f64,
    /// Whether a body is softer than specified because a step exceeds a sixth of its period.
    pub softened: bool,
    /// Whether this point has the finest lattice, whose surface is the reference.
    pub finest: bool,
    /// Run time of a frame.
    pub timing: Timing,
    /// Errors.
    pub errors: Errors,
    /// Conservation errors in free flight. `None` for naive sums.
    pub free: Option<Free>,
    /// Pareto fronts that contain this point. A point is on the front of an error if no other point of the
    /// study has both a shorter run time and a smaller error.
    pub front: Vec<Front>,
}

/// Errors of a point. An error is `None` if it is unknown, because the naive sums would take too long or
/// because a mesh encloses no volume. If naive sums cover only the first frames of the motion, the errors of
/// their volumes and surfaces are `None`, because bodies deform little in the first frames.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Errors {
    /// Distance of the goal positions from the naive sums over staircase regions, at the same positions.
    pub goals: Option<Distances>,
    /// Distance of the lattice vertices from a motion that is computed by naive sums over staircase regions.
    pub path: Option<Path>,
    /// Maximum relative error of the volume enclosed by the meshes, over all frames.
    pub mesh_volume: Option<f64>,
    /// Maximum relative error of the total volume of the cells, over all frames.
    pub cells_volume: Option<f64>,
    /// Root mean square of the relative errors of the volumes of the individual cells.
    pub cell_volumes: Option<f64>,
    /// Root mean square distance of the mesh vertices from their positions with the finest lattice, relative
    /// to the diagonal of the bounding box of the mesh.
    pub surface_rms: Option<f64>,
    /// Hausdorff distance of the surface from the surface with the finest lattice, relative to the diagonal
    /// of the bounding box of the mesh.
    pub surface_hausdorff: Option<f64>,
    /// Number of frames in which the correction of at least one body reached its cap.
    pub capped: u32,
}

/// Distance of the lattice vertices from a motion that is computed by naive sums.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Path {
    /// Number of compared frames from the start.
    pub frames: u32,
    /// Distances in all compared frames.
    #[serde(flatten)]
    pub distances: Distances,
}

/// Distances of lattice vertices from their reference positions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Distances {
    /// Root mean square, in cells.
    pub rms_cells: f64,
    /// Maximum, in cells.
    pub max_cells: f64,
    /// Root mean square, in scene units.
    pub rms: f64,
    /// Maximum, in scene units.
    pub max: f64,
}

/// The errors that have a Pareto front against run time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Front {
    /// `surface_rms`.
    Surface,
    /// `mesh_volume`, or `cells_volume` if a mesh encloses no volume.
    Volume,
    /// `cell_volumes`.
    Cells,
    /// `path`, root mean square in cells.
    Path,
}

impl Front {
    /// All fronts, in the order of the table.
    pub const ALL: [Self; 4] = [Self::Surface, Self::Volume, Self::Cells, Self::Path];

    /// Returns the letter of the front in the table.
    pub fn letter(self) -> char {
        match self {
            Self::Surface => 's',
            Self::Volume => 'v',
            Self::Cells => 'c',
            Self::Path => 'p',
        }
    }

    /// Returns the error of a point. Returns `None` if the error is unknown, and for the surface of the
    /// finest lattice, which is the reference of the surfaces. The reference of the paths, naive sums over
    /// staircase regions, is included with an error of 0, to show the run time of exact sums.
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

    /// Returns whether the error of a point is plotted. The path does not depend on the volume correction, so
    /// it is plotted only for points with `method`, the method of the scene.
    pub(super) fn applies_to(self, point: &Point, method: &str) -> bool {
        self != Self::Path || point.method == method
    }

    /// Returns run time and error of a point, or `None` if the point cannot be on the front. Points with
    /// another material are excluded. `method` is the method of the scene.
    fn cost(self, point: &Point, method: &str) -> Option<[f64; 2]> {
        let included = point.region_factor == 1.0 && !point.softened && self.applies_to(point, method);
        let error = self.error(point).filter(|_| included)?;
        Some([point.timing.total.median, error])
    }
}

/// Marks the points on the fronts. `method` is the method of the scene.
pub(super) fn mark(points: &mut [Point], method: &str) {
    for point in &mut *points {
        point.front.clear();
    }
    for front in Front::ALL {
        let costs: Vec<_> = points.iter().map(|point| front.cost(point, method)).collect();
        for (point, cost) in points.iter_mut().zip(&costs) {
            let Some(cost) = cost else { continue };
            if !costs.iter().flatten().any(|other| dominates(other, cost)) {
                point.front.push(front);
            }
        }
    }
}

/// Returns whether neither number of `a` is larger than in `b`, and at least one is smaller.
fn dominates(a: &[f64; 2], b: &[f64; 2]) -> bool {
    a[0] <= b[0] && a[1] <= b[1] && a != b
}
