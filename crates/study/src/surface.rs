//! How far a surface is from another that has the same faces.

use nalgebra::{Point3, Vector3};

/// How far a surface is from another.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Distance {
    /// Sum of the squared distances of vertices with the same number.
    pub(crate) squares: f64,
    /// The Hausdorff distance: the greatest of the distances of either's vertices from the other surface.
    pub(crate) hausdorff: f64,
}

/// The distance of two surfaces with the same triangles.
pub(crate) fn distance(a: &[Point3<f64>], b: &[Point3<f64>], triangles: &[[u32; 3]]) -> Distance {
    let squares: Vec<f64> = a.iter().zip(b).map(|(a, b)| (a - b).norm_squared()).collect();
    // No vertex is farther from the other surface than from the vertex of its own number: from the farthest on, once
    // these are nearer than the greatest distance found, no other can be greater.
    let mut order: Vec<usize> = (0..squares.len()).collect();
    order.sort_by(|&i, &j| squares[j].total_cmp(&squares[i]));
    let mut greatest = 0.0_f64;
    for (from, to) in [(a, b), (b, a)] {
        for &vertex in &order {
            if squares[vertex] <= greatest {
                break;
            }
            greatest = greatest.max(nearest(&from[vertex], to, triangles, squares[vertex], greatest));
        }
    }
    Distance { squares: squares.iter().sum(), hausdorff: greatest.sqrt() }
}

/// The squared distance of a point from a surface that is at most `known` away; or any number below `enough` if the
/// surface is nearer than that.
fn nearest(
    point: &Point3<f64>,
    surface: &[Point3<f64>],
    triangles: &[[u32; 3]],
    known: f64,
    enough: f64,
) -> f64 {
    let mut least = known;
    for corners in triangles {
        let [a, b, c] = corners.map(|vertex| surface[vertex as usize]);
        // What is farther by one axis alone is not looked at.
        let beyond = (0..3).any(|k| {
            let (low, high) = (a[k].min(b[k]).min(c[k]), a[k].max(b[k]).max(c[k]));
            let gap = (low - point[k]).max(point[k] - high);
            gap > 0.0 && gap * gap >= least
        });
        if beyond {
            continue;
        }
        least = least.min((closest(point, &a, &b, &c) - point).norm_squared());
        if least < enough {
            break;
        }
    }
    least
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
