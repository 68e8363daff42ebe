//! Distance of two surfaces with the same faces.

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
    let mut greatest = 0.0_f64;
    for (from, to) in [(a, b), (b, a)] {
        let to = Blocks::new(to, triangles);
        for &vertex in &order {
            if squares[vertex] <= greatest {
                break;
            }
            greatest = greatest.max(to.nearest(&from[vertex], squares[vertex], greatest));
        }
    }
    Distance { squares: squares.iter().sum(), hausdorff: greatest.sqrt() }
}

/// Number of triangles in a block. Consecutive triangles of a mesh are mostly close together.
const BLOCK: usize = 24;

/// A surface in blocks of triangles with bounding boxes, so that distant triangles are skipped in blocks.
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
        let nothing = Self { low: [f64::INFINITY; 3].into(), high: [f64::NEG_INFINITY; 3].into() };
        points.fold(nothing, |bounds, point| Self {
            low: bounds.low.inf(&point),
            high: bounds.high.sup(&point),
        })
    }

    /// Returns the squared distance of a point; 0 inside the box.
    fn distance(&self, point: &Point3<f64>) -> f64 {
        (self.low - point).sup(&(point - self.high)).sup(&Vector3::zeros()).norm_squared()
    }
}

impl<'a> Blocks<'a> {
    fn new(points: &'a [Point3<f64>], triangles: &'a [[u32; 3]]) -> Self {
        let corners =
            |block: &[[u32; 3]]| Bounds::of(block.iter().flatten().map(|&vertex| points[vertex as usize]));
        Self { points, triangles, boxes: triangles.chunks(BLOCK).map(corners).collect() }
    }

    /// Returns the squared distance of a point from the surface. `known` is an upper bound. If the distance
    /// is below
    /// `enough`, the result is some number below `enough`.
    fn nearest(&self, point: &Point3<f64>, known: f64, enough: f64) -> f64 {
        let mut least = known;
        for (block, bounds) in self.triangles.chunks(BLOCK).zip(&self.boxes) {
            if bounds.distance(point) >= least {
                continue;
            }
            for corners in block {
                let [a, b, c] = corners.map(|vertex| self.points[vertex as usize]);
                least = least.min((closest(point, &a, &b, &c) - point).norm_squared());
            }
            if least < enough {
                break;
            }
        }
        least
    }
}

/// Returns the point of a triangle that is closest to `p` (Ericson 2005, Real-Time Collision Detection,
/// 5.1.5).
fn closest(p: &Point3<f64>, a: &Point3<f64>, b: &Point3<f64>, c: &Point3<f64>) -> Point3<f64> {
    let (ab, ac): (Vector3<f64>, Vector3<f64>) = (b - a, c - a);
    let along = |from: &Point3<f64>| (ab.dot(&(p - from)), ac.dot(&(p - from)));
    let (a1, a2) = along(a);
    if a1 <= 0.0 && a2 <= 0.0 {
        return *a;
    }
    let (b1, b2) = along(b);
    if b1 >= 0.0 && b2 <= b1 {
        return *b;
    }
    let (c1, c2) = along(c);
    if c2 >= 0.0 && c1 <= c2 {
        return *c;
    }
    let of_c = a1 * b2 - b1 * a2;
    if of_c <= 0.0 && a1 >= 0.0 && b1 <= 0.0 {
        return a + ab * (a1 / (a1 - b1));
    }
    let of_b = c1 * a2 - a1 * c2;
    if of_b <= 0.0 && a2 >= 0.0 && c2 <= 0.0 {
        return a + ac * (a2 / (a2 - c2));
    }
    let of_a = b1 * c2 - c1 * b2;
    let (to_b, to_c) = (b2 - b1, c1 - c2);
    if of_a <= 0.0 && to_b >= 0.0 && to_c >= 0.0 {
        return b + (c - b) * (to_b / (to_b + to_c));
    }
    let sum = of_a + of_b + of_c;
    if sum > 0.0 { a + ab * (of_b / sum) + ac * (of_c / sum) } else { *a }
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
