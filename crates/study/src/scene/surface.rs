//! Computes the distance of two surfaces with the same faces.

use nalgebra::{Point3, Vector3};

/// Distance of two surfaces.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Distance {
    /// Sum of the squared distances of corresponding vertices.
    pub(super) squares: f64,
    /// Hausdorff distance: the maximum distance of a vertex of either surface from the other surface.
    pub(super) hausdorff: f64,
}

/// Computes the distance of two surfaces with the same triangles.
pub(super) fn distance(a: &[Point3<f64>], b: &[Point3<f64>], triangles: &[[u32; 3]]) -> Distance {
    let squares: Vec<f64> = a.iter().zip(b).map(|(a, b)| (a - b).norm_squared()).collect();
    // The distance to the corresponding vertex bounds the distance to the other surface. In descending order
    // of this bound, the search ends at the first bound that is not above the maximum found so far.
    let mut order: Vec<usize> = (0..squares.len()).collect();
    order.sort_by(|&i, &j| squares[j].total_cmp(&squares[i]));
    let mut maximum = 0.0_f64;
    for (points, other) in [(a, b), (b, a)] {
        let other = Blocks::new(other, triangles);
        for &vertex in &order {
            if squares[vertex] <= maximum {
                break;
            }
            maximum = maximum.max(other.nearest(&points[vertex], squares[vertex], maximum));
        }
    }
    Distance { squares: squares.iter().sum(), hausdorff: maximum.sqrt() }
}

/// Number of consecutive triangles in a block. They are mostly close together in space.
const BLOCK: usize = 24;

/// A surface whose triangles are divided into blocks with bounding boxes. The search skips distant blocks.
struct Blocks<'a> {
    points: &'a [Point3<f64>],
    triangles: &'a [[u32; 3]],
    boxes: Vec<Bounds>,
}

/// Axis-aligned bounding box.
#[derive(Clone, Copy)]
struct Bounds {
    low: Point3<f64>,
    high: Point3<f64>,
}

impl Bounds {
    fn of(points: impl Iterator<Item = Point3<f64>>) -> Self {
        let empty = Self { low: [f64::INFINITY; 3].into(), high: [f64::NEG_INFINITY; 3].into() };
        points
            .fold(empty, |bounds, point| Self { low: bounds.low.inf(&point), high: bounds.high.sup(&point) })
    }

    /// Returns the squared distance of a point from the box; 0 inside the box.
    fn distance_squared(&self, point: &Point3<f64>) -> f64 {
        (self.low - point).sup(&(point - self.high)).sup(&Vector3::zeros()).norm_squared()
    }
}

impl<'a> Blocks<'a> {
    fn new(points: &'a [Point3<f64>], triangles: &'a [[u32; 3]]) -> Self {
        let bounds =
            |block: &[[u32; 3]]| Bounds::of(block.iter().flatten().map(|&vertex| points[vertex as usize]));
        Self { points, triangles, boxes: triangles.chunks(BLOCK).map(bounds).collect() }
    }

    /// Returns the squared distance of a point from the surface. `upper_bound` is an upper bound of it. The
    /// search ends early if the squared distance is below `threshold`; the result is then only an upper bound
    /// that is below `threshold`.
    fn nearest(&self, point: &Point3<f64>, upper_bound: f64, threshold: f64) -> f64 {
        let mut minimum = upper_bound;
        for (block, bounds) in self.triangles.chunks(BLOCK).zip(&self.boxes) {
            if bounds.distance_squared(point) >= minimum {
                continue;
            }
            for corners in block {
                let [a, b, c] = corners.map(|vertex| self.points[vertex as usize]);
                minimum = minimum.min((closest(point, &a, &b, &c) - point).norm_squared());
            }
            if minimum < threshold {
                break;
            }
        }
        minimum
    }
}

/// Returns the point of a triangle that is closest to `p` (Ericson 2005, Real-Time Collision Detection,
/// 5.1.5).
fn closest(p: &Point3<f64>, a: &Point3<f64>, b: &Point3<f64>, c: &Point3<f64>) -> Point3<f64> {
    let (ab, ac): (Vector3<f64>, Vector3<f64>) = (b - a, c - a);
    // Dot products of the edges ab and ac with the vector from a corner to p.
    let products = |corner: &Point3<f64>| (ab.dot(&(p - corner)), ac.dot(&(p - corner)));
    let (a1, a2) = products(a);
    if a1 <= 0.0 && a2 <= 0.0 {
        return *a;
    }
    let (b1, b2) = products(b);
    if b1 >= 0.0 && b2 <= b1 {
        return *b;
    }
    let (c1, c2) = products(c);
    if c2 >= 0.0 && c1 <= c2 {
        return *c;
    }
    // The barycentric coordinates of the projection of p on the plane of the triangle, up to a common factor.
    let coordinate_c = a1 * b2 - b1 * a2;
    if coordinate_c <= 0.0 && a1 >= 0.0 && b1 <= 0.0 {
        return a + ab * (a1 / (a1 - b1));
    }
    let coordinate_b = c1 * a2 - a1 * c2;
    if coordinate_b <= 0.0 && a2 >= 0.0 && c2 <= 0.0 {
        return a + ac * (a2 / (a2 - c2));
    }
    let coordinate_a = b1 * c2 - c1 * b2;
    let (to_b, to_c) = (b2 - b1, c1 - c2);
    if coordinate_a <= 0.0 && to_b >= 0.0 && to_c >= 0.0 {
        return b + (c - b) * (to_b / (to_b + to_c));
    }
    let sum = coordinate_a + coordinate_b + coordinate_c;
    if sum > 0.0 { a + ab * (coordinate_b / sum) + ac * (coordinate_c / sum) } else { *a }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the corners of a square of edge `size` at a height.
    fn square(size: f64, height: f64) -> Vec<Point3<f64>> {
        [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
            .map(|[x, y]| Point3::new(size * x, size * y, height))
            .to_vec()
    }

    const TRIANGLES: [[u32; 3]; 2] = [[0, 1, 2], [0, 2, 3]];

    #[test]
    fn the_closest_point_of_a_triangle_is_correct_in_all_voronoi_regions() {
        let [a, b, c] = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]].map(Point3::from);
        for (point, expected) in [
            ([0.5, 0.5, 3.0], [0.5, 0.5, 0.0]),
            ([-1.0, -1.0, 1.0], [0.0, 0.0, 0.0]),
            ([5.0, -1.0, 0.0], [2.0, 0.0, 0.0]),
            ([-1.0, 5.0, 0.0], [0.0, 2.0, 0.0]),
            ([1.0, -2.0, 0.0], [1.0, 0.0, 0.0]),
            ([-2.0, 1.0, 0.0], [0.0, 1.0, 0.0]),
            ([2.0, 2.0, 0.0], [1.0, 1.0, 0.0]),
        ] {
            assert_eq!(closest(&point.into(), &a, &b, &c), expected.into(), "{point:?}");
        }
        // A degenerate triangle.
        let flat = closest(&Point3::new(1.0, 1.0, 0.0), &a, &b, &Point3::new(4.0, 0.0, 0.0));
        assert!((flat - Point3::new(1.0, 0.0, 0.0)).norm() < 1e-12 && a == closest(&c, &a, &a, &a));
    }

    #[test]
    fn the_hausdorff_distance_is_between_surfaces_not_vertices() {
        let distance = |a: &[Point3<f64>], b: &[Point3<f64>]| distance(a, b, &TRIANGLES);
        let (low, high) = (square(2.0, 0.0), square(2.0, 0.5));
        assert_eq!(distance(&low, &low), Distance::default());
        assert_eq!(distance(&low, &high), Distance { squares: 4.0 * 0.25, hausdorff: 0.5 });
        // The smaller square is inside the larger one, whose far corner has the maximum distance, in both
        // orders.
        let inner = square(1.0, 0.0);
        assert_eq!(distance(&low, &inner).hausdorff, 2.0_f64.sqrt());
        assert_eq!(distance(&inner, &low).hausdorff, 2.0_f64.sqrt());
        // The same surface with permuted vertices.
        let turned = [low[1], low[2], low[3], low[0]];
        assert!(distance(&low, &turned).squares > 1.0);
        assert_eq!(distance(&low, &turned).hausdorff, 0.0);
    }
}
