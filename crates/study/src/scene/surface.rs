//! How far a surface is from another that has the same faces.

use nalgebra::{Point3, Vector3};

/// How far a surface is from another.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Distance {
    /// Sum of the squared distances of vertices with the same number.
    pub(super) squares: f64,
    /// The Hausdorff distance: the greatest of the distances of either's vertices from the other surface.
    pub(super) hausdorff: f64,
}

/// The distance of two surfaces with the same triangles.
pub(super) fn distance(a: &[Point3<f64>], b: &[Point3<f64>], triangles: &[[u32; 3]]) -> Distance {
    let squares: Vec<f64> = a.iter().zip(b).map(|(a, b)| (a - b).norm_squared()).collect();
    // No vertex is farther from the other surface than from the vertex of its own number: from the farthest on, once
    // these are nearer than the greatest distance found, no other can be greater.
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

/// Triangles in a block: those that follow each other in a mesh mostly lie together.
const BLOCK: usize = 24;

/// A surface in blocks of triangles, so that what is far away need not be looked at one by one.
struct Blocks<'a> {
    points: &'a [Point3<f64>],
    triangles: &'a [[u32; 3]],
    boxes: Vec<Bounds>,
}

/// The box around some points.
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

    /// The squared distance of a point; 0 inside.
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

    /// The squared distance of a point from the surface, which is at most `known` away; or any number below `enough` if
    /// the surface is nearer than that.
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

/// The point of a triangle that is closest to a point (Ericson: Real-Time Collision Detection, 2005, 5.1.5).
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

    /// A square of two triangles, `size` long, at a height.
    fn square(size: f64, height: f64) -> Vec<Point3<f64>> {
        [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
            .map(|[x, y]| Point3::new(size * x, size * y, height))
            .to_vec()
    }

    const TRIANGLES: [[u32; 3]; 2] = [[0, 1, 2], [0, 2, 3]];

    #[test]
    fn the_closest_point_is_found_from_all_sides() {
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
        // A triangle without area.
        let flat = closest(&Point3::new(1.0, 1.0, 0.0), &a, &b, &Point3::new(4.0, 0.0, 0.0));
        assert!((flat - Point3::new(1.0, 0.0, 0.0)).norm() < 1e-12 && a == closest(&c, &a, &a, &a));
    }

    #[test]
    fn the_hausdorff_distance_is_of_surfaces_and_not_of_vertices() {
        let distance = |a: &[Point3<f64>], b: &[Point3<f64>]| distance(a, b, &TRIANGLES);
        let (low, high) = (square(2.0, 0.0), square(2.0, 0.5));
        assert_eq!(distance(&low, &low), Distance::default());
        assert_eq!(distance(&low, &high), Distance { squares: 4.0 * 0.25, hausdorff: 0.5 });
        // A smaller square lies in the larger, whose far corner is the farthest; and the same the other way round.
        let inner = square(1.0, 0.0);
        assert_eq!(distance(&low, &inner).hausdorff, 2.0_f64.sqrt());
        assert_eq!(distance(&inner, &low).hausdorff, 2.0_f64.sqrt());
        // Vertices of other numbers, the same surface.
        let turned = [low[1], low[2], low[3], low[0]];
        assert!(distance(&low, &turned).squares > 1.0);
        assert_eq!(distance(&low, &turned).hausdorff, 0.0);
    }
}
