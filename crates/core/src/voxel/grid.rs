//! The grid of cells around a surface.

use nalgebra::Point3;

/// Largest magnitude of a grid index. The difference of two indices then fits in 32 bits.
pub(crate) const HIGHEST_INDEX: i32 = 1 << 30;

/// Returns the grid index that is some steps further along an axis.
pub(crate) fn step(mut index: [i32; 3], axis: usize, by: i32) -> [i32; 3] {
    index[axis] += by;
    index
}

/// Returns the next grid index on a side, 0 to 5 for -x, +x, -y, +y, -z, +z.
pub(crate) fn beside(index: [i32; 3], side: usize) -> [i32; 3] {
    step(index, side / 2, if side.is_multiple_of(2) { -1 } else { 1 })
}

/// Depth, in cells, up to which a surface that enters a cell counts as only touching it. Far greater than
/// rounding errors and far less than visible detail.
pub(super) const TOUCH_DEPTH: f64 = 1e-6;

/// Assumed precision of the mesh coordinates, as a fraction of the largest coordinate. Files often have six
/// digits.
const PRECISION: f64 = 2e-6;

/// Largest distance, in cells, by which a coordinate is snapped to a grid plane. Without this bound the
/// distance could be large for meshes far from their origin or with very small cells.
pub(super) const MAX_SNAP: f64 = 1e-3;

/// A grid of cells around a bounding box, centered on the box.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Grid {
    /// Edge length of a cell.
    pub cell_size: f64,
    /// Number of cells along each axis, at least 1.
    pub(super) size: [usize; 3],
    /// Center of the box and of the grid.
    center: Point3<f64>,
    /// Distance to a grid plane, in cells, up to which a coordinate is snapped to it.
    tolerance: f64,
}

impl Grid {
    /// Builds the smallest grid around a box. Returns `None` if an axis would have more than
    /// [`HIGHEST_INDEX`] cells.
    pub(crate) fn new((low, high): (Point3<f64>, Point3<f64>), cell_size: f64) -> Option<Self> {
        let counts = Self::counts(&(low, high), cell_size);
        if counts.iter().any(|&n| n > f64::from(HIGHEST_INDEX)) {
            return None;
        }
        Some(Self {
            cell_size,
            size: counts.map(|n| n as usize),
            center: nalgebra::center(&low, &high),
            tolerance: Self::tolerance(&(low, high), cell_size),
        })
    }

    /// Returns the number of cells along each axis of the smallest grid around a box, or infinity on
    /// overflow.
    pub(crate) fn counts((low, high): &(Point3<f64>, Point3<f64>), cell_size: f64) -> [f64; 3] {
        let tolerance = Self::tolerance(&(*low, *high), cell_size);
        std::array::from_fn(|a| ((high[a] - low[a]) / cell_size - tolerance).ceil().max(1.0))
    }

    /// Returns the distance to a grid plane, in cells, up to which a coordinate is snapped to it.
    pub(crate) fn tolerance((low, high): &(Point3<f64>, Point3<f64>), cell_size: f64) -> f64 {
        let farthest = low.coords.amax().max(high.coords.amax());
        (PRECISION * farthest / cell_size).clamp(TOUCH_DEPTH, MAX_SNAP)
    }

    /// Returns the number of cells along each axis.
    pub(crate) fn size(&self) -> [usize; 3] {
        self.size
    }

    /// Returns the lower corner of cell `[0, 0, 0]`.
    pub(crate) fn origin(&self) -> Point3<f64> {
        let at = |a: usize| self.center[a] - 0.5 * self.size[a] as f64 * self.cell_size;
        Point3::new(at(0), at(1), at(2))
    }

    /// Returns the center of a cell.
    pub(super) fn center_of(&self, cell: [i32; 3]) -> Point3<f64> {
        let at = |a: usize| {
            self.center[a] + (f64::from(cell[a]) + 0.5 - 0.5 * self.size[a] as f64) * self.cell_size
        };
        Point3::new(at(0), at(1), at(2))
    }

    /// Returns whether a cell is in the grid.
    pub(super) fn contains(&self, cell: [i32; 3]) -> bool {
        (0..3).all(|a| (0..self.size[a] as i32).contains(&cell[a]))
    }

    /// Returns the coordinates of a point relative to the origin of the grid, in cells, clamped to the grid.
    ///
    /// A coordinate near a grid plane is snapped to the plane.
    pub(crate) fn cell_space(&self, point: &Point3<f64>) -> [f64; 3] {
        std::array::from_fn(|a| {
            let size = self.size[a] as f64;
            // A point in the box is in the grid, except for rounding.
            let x = ((point[a] - self.center[a]) / self.cell_size + 0.5 * size).clamp(0.0, size);
            // The nearest integer, without a call of `round`.
            let plane = f64::from((x + 0.5) as i32);
            if (x - plane).abs() <= self.tolerance { plane } else { x }
        })
    }
}
