//! The grid of cells around a surface.

use nalgebra::Point3;

/// Highest magnitude of a grid index, so that differences of two are 32-bit numbers too.
pub(crate) const HIGHEST_INDEX: i32 = 1 << 30;

/// Depth in cells up to which a surface merely touches a cell: far above rounding and far below what can be seen.
pub(super) const TOUCHING: f64 = 1e-6;

/// Precision of coordinates as fraction of the largest: they are often written with six digits.
const PRECISION: f64 = 2e-6;

/// Most, in cells, that a coordinate is moved into a grid plane, for meshes that are far from their origin or very finely divided.
pub(super) const FARTHEST_MOVE: f64 = 1e-3;

/// Cells along each axis around a bounding box, which is centerd on them.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Grid {
    pub(crate) cell_size: f64,
    /// Number of cells along each axis, at least 1.
    pub(crate) size: [usize; 3],
    center: Point3<f64>,
    tolerance: f64,
}

impl Grid {
    /// The smallest grid around a box; none where it has more cells along an axis than can be numbered.
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

    /// Number of cells along each axis, as it would be; infinite where it overflows.
    pub(crate) fn counts((low, high): &(Point3<f64>, Point3<f64>), cell_size: f64) -> [f64; 3] {
        let tolerance = Self::tolerance(&(*low, *high), cell_size);
        std::array::from_fn(|a| ((high[a] - low[a]) / cell_size - tolerance).ceil().max(1.0))
    }

    /// What counts as lying in a grid plane, in cells.
    fn tolerance((low, high): &(Point3<f64>, Point3<f64>), cell_size: f64) -> f64 {
        let farthest = low.coords.amax().max(high.coords.amax());
        (PRECISION * farthest / cell_size).clamp(TOUCHING, FARTHEST_MOVE)
    }

    /// Where cell `[0, 0, 0]` begins.
    pub(crate) fn origin(&self) -> Point3<f64> {
        let at = |a: usize| self.center[a] - 0.5 * self.size[a] as f64 * self.cell_size;
        Point3::new(at(0), at(1), at(2))
    }

    /// A point in cells from the origin, within the grid; a coordinate that all but lies in a grid plane is put there.
    pub(crate) fn place(&self, point: &Point3<f64>) -> [f64; 3] {
        std::array::from_fn(|a| {
            let size = self.size[a] as f64;
            // What lies in the box lies in the grid, but for rounding.
            let x = ((point[a] - self.center[a]) / self.cell_size + 0.5 * size).clamp(0.0, size);
            // The nearest whole number, without a call of `round`.
            let plane = f64::from((x + 0.5) as i32);
            if (x - plane).abs() <= self.tolerance { plane } else { x }
        })
    }
}
