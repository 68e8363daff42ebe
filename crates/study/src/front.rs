//! Pareto fronts: the points than which nothing is both faster and better.

use serde::{Deserialize, Serialize};

use crate::point::Point;

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
    pub(crate) fn tells(self, point: &Point, method: &str) -> bool {
        self != Self::Path || point.method == method
    }

    /// The cost of a point that may be on the front: what is another material answers another question.
    fn cost(self, point: &Point, method: &str) -> Option<[f64; 2]> {
        let takes_part = point.reach == 1.0 && !point.softened && self.tells(point, method);
        let error = self.error(point).filter(|_| takes_part)?;
        Some([point.timing.total.median, error])
    }
}

/// Marks the fronts of a scene that itself keeps its volume by `method`.
pub(crate) fn mark(points: &mut [Point], method: &str) {
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
