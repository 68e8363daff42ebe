//! Bounds of the distance of points from a surface at rest. They save most searches for the closest point: most samples in
//! a cell of another body are outside of its surface.
//!
//! The bounds of a point follow from the signed distance of the center of its subcell, because the distances of two points
//! differ by at most the distance between them. The rest shape stays the same, so each center is searched once, when a
//! point is in its subcell for the first time.

use std::sync::atomic::{AtomicU32, Ordering};

use nalgebra::Point3;

use crate::mesh::SurfaceTree;

/// Number of subcells along each axis of a cell.
const SUBCELLS: usize = 4;

/// Bound of the rounding of a distance in f32, in cells.
const ROUNDING: f64 = 1e-5;

/// Signed distances of the centers of the subcells of some cells, in cells.
#[derive(Debug)]
pub(super) struct RestDistances {
    /// The bits of an f32 for each subcell, x fastest, cell by cell; NaN before the first use. Threads that compute a
    /// distance at the same time store the same bits.
    values: Vec<AtomicU32>,
}

impl RestDistances {
    /// Creates the distances for a number of cells.
    pub(super) fn new(cells: usize) -> Self {
        let values = std::iter::repeat_with(|| AtomicU32::new(f32::NAN.to_bits()));
        Self { values: values.take(cells * SUBCELLS.pow(3)).collect() }
    }

    /// Returns a lower and an upper bound of the signed distance of a point from the surface of `tree`, negative inside.
    /// The distance without its sign is at most the greater magnitude of the two, also if the surface is open. On which side
    /// a point is depends on the center of its subcell.
    ///
    /// * `cell`: number of the cell of the point, among those of [`new`](Self::new).
    /// * `index`: grid index of this cell.
    pub(super) fn bounds(
        &self,
        (cell, index): (usize, [i32; 3]),
        point: &Point3<f64>,
        tree: &SurfaceTree,
    ) -> [f64; 2] {
        let subcell = |a: usize| {
            let along = (point[a] - f64::from(index[a])) * SUBCELLS as f64;
            along.clamp(0.0, (SUBCELLS - 1) as f64) as usize
        };
        let subcell = [subcell(0), subcell(1), subcell(2)];
        let center = |a: usize| f64::from(index[a]) + (subcell[a] as f64 + 0.5) / SUBCELLS as f64;
        let center = Point3::new(center(0), center(1), center(2));
        let [x, y, z] = subcell;
        let value = &self.values[((cell * SUBCELLS + z) * SUBCELLS + y) * SUBCELLS + x];
        let mut distance = f32::from_bits(value.load(Ordering::Relaxed));
        if distance.is_nan() {
            distance = signed_distance(tree, &center) as f32;
            value.store(distance.to_bits(), Ordering::Relaxed);
        }
        let radius = (point - center).norm() + ROUNDING;
        [f64::from(distance) - radius, f64::from(distance) + radius]
    }

    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.values)
    }
}

/// Returns the signed distance of a point from a surface. A point is outside only if both the pseudonormal and a line from it
/// say so: where a surface meets itself they can differ.
fn signed_distance(tree: &SurfaceTree, point: &Point3<f64>) -> f64 {
    let Some(closest) = tree.closest(point, f64::MAX, |_| true) else { return f64::INFINITY };
    let is_inside = closest.is_inside(point) || tree.encloses(point);
    if is_inside { -closest.distance } else { closest.distance }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::testing::Random;

    /// A tetrahedron with corners at the origin and at 3 on the axes: outside of its slanted face, x + y + z > 3.
    #[test]
    fn bounds_enclose_the_signed_distance_and_are_near_it() {
        let vertices = [[0.0; 3], [3.0, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, 3.0]].map(Point3::from);
        let triangles = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        let tree = SurfaceTree::new(&vertices, triangles.into_iter()).unwrap();
        let distances = RestDistances::new(2);
        let mut random = Random(3);
        for k in 0..2000 {
            let (cell, index) = [(0, [0, 1, 1]), (1, [1, 1, 0])][k % 2];
            // Every fourth point is outside of its cell.
            let [scale, start] = if k % 8 < 2 { [3.0, -1.0] } else { [1.0, 0.0] };
            let point = Point3::from(index.map(|i| f64::from(i) + start + scale * random.next()));
            let closest = tree.closest(&point, f64::MAX, |_| true).unwrap();
            let signed = if closest.is_inside(&point) { -closest.distance } else { closest.distance };
            let [low, high] = distances.bounds((cell, index), &point, &tree);
            assert!(low <= signed && signed <= high, "{point}: {signed} is not in {low}..{high}");
            // In its cell, a point is at most half a diagonal of a subcell from the center.
            assert!(
                scale > 1.0 || high - low <= 3.0_f64.sqrt() / SUBCELLS as f64 + 3.0 * ROUNDING,
                "{low}..{high}"
            );
        }
    }
}
