//! Whether a triangle passes through a box: the separating axis test.

use nalgebra::Vector3;

use super::grid::TOUCHING;

/// A depth of contact in cells that rounding may have made.
const ROUNDING: f64 = 1e-12;

/// The triangle's normal, and the products of its three edges with the three axes.
const AXES: usize = 10;

/// A triangle, prepared to be tested against many boxes (Akenine-Möller 2001).
///
/// A convex body and an open box are disjoint iff they do not overlap along one of the axes of the box, the normal of the triangle,
/// or the products of their edges. The axes of the box are left to the caller, who looks only at boxes that overlap along them.
pub(super) struct TriangleAxes {
    x: [f64; AXES],
    y: [f64; AXES],
    z: [f64; AXES],
    /// Reach of the triangle along each axis, less what counts as touching.
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
            // An axis of no length separates nothing.
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

    fn set(&mut self, i: usize, axis: Vector3<f64>, corners: &[Vector3<f64>; 3]) {
        let longest = axis.amax();
        if longest == 0.0 {
            return;
        }
        let axis = axis / longest;
        let touching = touching(&axis);
        let reach = corners.map(|corner| axis.dot(&corner));
        self.x[i] = axis.x;
        self.y[i] = axis.y;
        self.z[i] = axis.z;
        self.low[i] = reach[0].min(reach[1]).min(reach[2]) + touching;
        self.high[i] = reach[0].max(reach[1]).max(reach[2]) - touching;
    }

    /// Whether the triangle passes through the inside of a box that it overlaps along each axis of the box.
    pub(super) fn enter(&self, low: [f64; 3], high: [f64; 3]) -> bool {
        let center: [f64; 3] = std::array::from_fn(|a| 0.5 * (low[a] + high[a]));
        let half: [f64; 3] = std::array::from_fn(|a| 0.5 * (high[a] - low[a]));
        let mut separated = false;
        for i in 0..AXES {
            let middle = self.x[i] * center[0] + self.y[i] * center[1] + self.z[i] * center[2];
            let reach = self.x[i].abs() * half[0] + self.y[i].abs() * half[1] + self.z[i].abs() * half[2];
            separated |= (self.low[i] >= middle + reach) | (self.high[i] <= middle - reach);
        }
        !separated
    }
}

/// The depth along an axis, whose longest coordinate is 1, up to which a contact counts as touching.
///
/// Where the surface crosses the line between the centers of two neighbouring cells, it lies at least half the sum of the two
/// shorter coordinates deep in one of them. Less than that is allowed for, so that no closed surface springs a leak.
fn touching(axis: &Vector3<f64>) -> f64 {
    let shorter = axis.abs().sum() - 1.0;
    (0.25 * shorter).clamp(ROUNDING, TOUCHING)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn enters(corners: [[f64; 3]; 3]) -> bool {
        TriangleAxes::new(&corners).enter([0.0; 3], [1.0; 3])
    }

    #[test]
    fn a_plane_through_the_box_enters_and_one_past_its_corner_does_not() {
        for (sum, expected) in
            [(0.1, true), (1.5, true), (2.9, true), (3.1, false), (3.0, false), (0.0, false), (-0.1, false)]
        {
            let corners = [[sum + 8.0, -4.0, -4.0], [-4.0, sum + 8.0, -4.0], [-4.0, -4.0, sum + 8.0]];
            assert_eq!(enters(corners), expected, "{sum}");
        }
    }

    #[test]
    fn an_edge_past_the_edge_of_the_box_does_not_enter() {
        for (sum, expected) in
            [(1.9, true), (2.0, false), (2.0 + 1e-9, false), (2.0 - 1e-9, false), (2.0 - 1e-4, true)]
        {
            assert_eq!(
                enters([[sum - 0.5, 0.5, 0.5], [0.5, sum - 0.5, 0.5], [3.0, 3.0, 0.5]]),
                expected,
                "{sum}"
            );
        }
    }

    #[test]
    fn a_face_all_but_in_the_plane_of_the_box_is_not_taken_for_touching() {
        // Over a hundred cells it rises by 2e-6 of a cell.
        assert!(enters([[0.0, 0.0, 0.0], [2e-6, 100.0, 0.0], [0.0, 0.0, 100.0]]));
    }

    #[test]
    fn degenerate_triangles_enter_where_they_lie() {
        assert!(enters([[0.5; 3]; 3]));
        assert!(enters([[-1.0, 0.5, 0.5], [0.5, 0.5, 0.5], [2.0, 0.5, 0.5]]));
        assert!(!enters([[-1.0, 0.5, 0.5], [0.5, 2.5, 0.5], [2.0, 4.5, 0.5]]));
    }
}
