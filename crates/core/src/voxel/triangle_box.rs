//! Tests whether a triangle enters a box, by the separating axis theorem.

use nalgebra::Vector3;

use super::grid::TOUCH_DEPTH;

/// Penetration depth, in cells, up to which an intersection is attributed to rounding.
const ROUNDING: f64 = 1e-12;

/// Number of axes tested: the triangle's normal, and the cross products of the three edges of the triangle
/// with the three coordinate axes.
const AXES: usize = 10;

/// A triangle, prepared for tests against many boxes (Akenine-Möller 2001).
///
/// A triangle and an open box are disjoint iff their projections onto at least one of these axes are
/// disjoint: the three coordinate axes (the directions of the box's edges), the normal of the triangle, and
/// the cross products of an edge of the triangle with a coordinate axis. The coordinate axes are not tested
/// here, because the caller only passes boxes that overlap the triangle along all of them.
pub(super) struct TriangleAxes {
    /// Components of the axes.
    x: [f64; AXES],
    y: [f64; AXES],
    z: [f64; AXES],
    /// Interval of the triangle's projection onto each axis, shrunk at both ends by [`touch_depth`].
    low: [f64; AXES],
    high: [f64; AXES],
}

impl TriangleAxes {
    pub(super) fn new(corners: &[[f64; 3]; 3]) -> Self {
        let corners = corners.map(Vector3::from);
        let edges = [corners[1] - corners[0], corners[2] - corners[1], corners[0] - corners[2]];
        let mut axes = Self {
            x: [0.0; AXES],
            y: [0.0; AXES],
            z: [0.0; AXES],
            // An unbounded interval, so that an axis of zero length never separates.
            low: [f64::NEG_INFINITY; AXES],
            high: [f64::INFINITY; AXES],
        };
        axes.set(0, edges[0].cross(&edges[1]), &corners);
        for (e, edge) in edges.iter().enumerate() {
            axes.set(3 * e + 1, Vector3::new(0.0, -edge.z, edge.y), &corners);
            axes.set(3 * e + 2, Vector3::new(edge.z, 0.0, -edge.x), &corners);
            axes.set(3 * e + 3, Vector3::new(-edge.y, edge.x, 0.0), &corners);
        }
        axes
    }

    /// Sets axis `i`, unless it has zero length.
    fn set(&mut self, i: usize, axis: Vector3<f64>, corners: &[Vector3<f64>; 3]) {
        let longest = axis.amax();
        if longest == 0.0 {
            return;
        }
        let axis = axis / longest;
        let depth = touch_depth(&axis);
        let projections = corners.map(|corner| axis.dot(&corner));
        self.x[i] = axis.x;
        self.y[i] = axis.y;
        self.z[i] = axis.z;
        self.low[i] = projections[0].min(projections[1]).min(projections[2]) + depth;
        self.high[i] = projections[0].max(projections[1]).max(projections[2]) - depth;
    }

    /// Returns whether the triangle enters the interior of a box between the corners `low` and `high`.
    ///
    /// The triangle must overlap the box along each coordinate axis.
    pub(super) fn enters(&self, low: [f64; 3], high: [f64; 3]) -> bool {
        let center: [f64; 3] = std::array::from_fn(|a| 0.5 * (low[a] + high[a]));
        let half: [f64; 3] = std::array::from_fn(|a| 0.5 * (high[a] - low[a]));
        let mut separated = false;
        for i in 0..AXES {
            let middle = self.x[i] * center[0] + self.y[i] * center[1] + self.z[i] * center[2];
            let radius = self.x[i].abs() * half[0] + self.y[i].abs() * half[1] + self.z[i].abs() * half[2];
            separated |= (self.low[i] >= middle + radius) | (self.high[i] <= middle - radius);
        }
        !separated
    }

    /// Returns whether the triangle certainly enters each box of a range.
    ///
    /// `low` and `high` are the corners of the range. `size` is the size of each box.
    pub(super) fn enters_all(&self, low: [f64; 3], high: [f64; 3], size: [f64; 3]) -> bool {
        let center: [f64; 3] = std::array::from_fn(|a| 0.5 * (low[a] + high[a]));
        (0..AXES).all(|i| {
            let axis = [self.x[i], self.y[i], self.z[i]];
            let middle: f64 = (0..3).map(|a| axis[a] * center[a]).sum();
            // The projection of each box contains an interval of this radius around the center of the box. The centers
            // are at most `spread` from the middle.
            let radius: f64 = (0..3).map(|a| 0.5 * axis[a].abs() * size[a]).sum();
            let spread: f64 = (0..3).map(|a| 0.5 * axis[a].abs() * (high[a] - low[a] - size[a])).sum();
            let reach = radius - spread - SAFE_DEPTH;
            self.low[i] < middle + reach && self.high[i] > middle - reach
        })
    }
}

/// Depth, in cells, by which all boxes of a range must be entered for [`TriangleAxes::enters_all`]. Far greater than
/// rounding errors, so that [`TriangleAxes::enters`] gives the same result for each box.
const SAFE_DEPTH: f64 = 1e-3;

/// Returns the depth along an axis up to which an intersection counts as touching.
///
/// `axis`: a vector whose largest component has the magnitude 1. Consider a surface that crosses the line
/// between the centers of two neighboring cells. In one of these cells its depth is at least half the sum of
/// the magnitudes of the two smaller components. The result is a quarter of this sum, so that the trace of a
/// closed surface has no gaps.
fn touch_depth(axis: &Vector3<f64>) -> f64 {
    let shorter = axis.abs().sum() - 1.0;
    (0.25 * shorter).clamp(ROUNDING, TOUCH_DEPTH)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn enters_unit_box(corners: [[f64; 3]; 3]) -> bool {
        TriangleAxes::new(&corners).enters([0.0; 3], [1.0; 3])
    }

    #[test]
    fn plane_enters_iff_it_cuts_the_inside_of_the_box() {
        for (sum, expected) in
            [(0.1, true), (1.5, true), (2.9, true), (3.1, false), (3.0, false), (0.0, false), (-0.1, false)]
        {
            let corners = [[sum + 8.0, -4.0, -4.0], [-4.0, sum + 8.0, -4.0], [-4.0, -4.0, sum + 8.0]];
            assert_eq!(enters_unit_box(corners), expected, "{sum}");
        }
    }

    #[test]
    fn triangle_beyond_an_edge_of_the_box_does_not_enter() {
        for (sum, expected) in
            [(1.9, true), (2.0, false), (2.0 + 1e-9, false), (2.0 - 1e-9, false), (2.0 - 1e-4, true)]
        {
            assert_eq!(
                enters_unit_box([[sum - 0.5, 0.5, 0.5], [0.5, sum - 0.5, 0.5], [3.0, 3.0, 0.5]]),
                expected,
                "{sum}"
            );
        }
    }

    #[test]
    fn triangle_nearly_in_a_face_plane_still_enters() {
        // The triangle rises by 2e-6 cells over 100 cells.
        assert!(enters_unit_box([[0.0, 0.0, 0.0], [2e-6, 100.0, 0.0], [0.0, 0.0, 100.0]]));
    }

    #[test]
    fn degenerate_triangles_enter_boxes_that_contain_them() {
        assert!(enters_unit_box([[0.5; 3]; 3]));
        assert!(enters_unit_box([[-1.0, 0.5, 0.5], [0.5, 0.5, 0.5], [2.0, 0.5, 0.5]]));
        assert!(!enters_unit_box([[-1.0, 0.5, 0.5], [0.5, 2.5, 0.5], [2.0, 4.5, 0.5]]));
    }
}
