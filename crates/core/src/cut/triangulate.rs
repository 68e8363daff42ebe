//! Triangles of polygons, by ear clipping.
//!
//! Published crates do not fit here: `earcut` leaves out corners on straight lines, `spade` merges corners at one
//! position, and `i_triangle` rounds to a grid. The triangles of a closed surface must use every corner of a polygon.

/// Number of corners up to which the best ear is clipped, and not the first one.
const BEST: usize = 40;

/// Area of a triangle below which it counts as empty, relative to the square of the extent of the polygon.
const EMPTY: f64 = 1e-12;

/// Position of a corner in the plane of a polygon.
pub(super) type Planar = [f64; 2];

/// Returns twice the signed area of a triangle.
fn area(a: Planar, b: Planar, c: Planar) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

fn distance_squared(a: Planar, b: Planar) -> f64 {
    (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2)
}

/// Returns twice the signed area of a polygon.
pub(super) fn polygon_area(corners: &[Planar]) -> f64 {
    let mut twice = 0.0;
    for n in 1..corners.len().saturating_sub(1) {
        twice += area(corners[0], corners[n], corners[n + 1]);
    }
    twice
}

/// Returns the triangles of a polygon as indices of its corners: always two less than corners. The polygon should be
/// simple and counter-clockwise; corners on a straight line, equal corners and bridges to holes are valid. Of any other
/// polygon the triangles overlap, but have the same boundary.
pub(super) fn triangulate(corners: &[Planar]) -> Vec<[usize; 3]> {
    let mut rest: Vec<usize> = (0..corners.len()).collect();
    let mut triangles = Vec::with_capacity(corners.len().saturating_sub(2));
    let extent = corners.iter().map(|&corner| distance_squared(corner, corners[0])).fold(0.0, f64::max);
    let empty = EMPTY * extent;
    while rest.len() > 3 {
        let count = rest.len();
        let at = |n: usize| corners[rest[n % count]];
        // Quality of the ear at a corner, or `None` if there is none: the area divided by the square of the longest
        // side.
        let quality = |n: usize| {
            let (a, b, c) = (at(n + count - 1), at(n), at(n + 1));
            let doubled = area(a, b, c);
            let longest = distance_squared(a, b).max(distance_squared(b, c)).max(distance_squared(c, a));
            (doubled > empty).then(|| doubled / longest)
        };
        let is_free = |n: usize| {
            let (a, b, c) = (at(n + count - 1), at(n), at(n + 1));
            (n + 2..n + count - 1).all(|other| {
                let p = at(other);
                let is_outside = area(a, b, p) < 0.0 || area(b, c, p) < 0.0 || area(c, a, p) < -empty;
                is_outside || p == a || p == b || p == c
            })
        };
        let mut ears = (0..count).filter_map(|n| Some((n, quality(n)?)));
        let better = |best: Option<(usize, f64)>, ear: (usize, f64)| match best {
            Some(best) if best.1 >= ear.1 => Some(best),
            _ => Some(ear),
        };
        let ear = if count > BEST {
            ears.find(|&(n, _)| is_free(n))
        } else {
            ears.filter(|&(n, _)| is_free(n)).fold(None, better)
        };
        // Without an ear: the corner of the largest triangle.
        let largest = || (0..count).filter_map(|n| Some((n, quality(n)?))).fold(None, better);
        let n = ear.or_else(largest).map_or(1, |(n, _)| n);
        triangles.push([rest[(n + count - 1) % count], rest[n], rest[(n + 1) % count]]);
        rest.remove(n);
    }
    if let [a, b, c] = rest[..] {
        triangles.push([a, b, c]);
    }
    triangles
}

/// Joins holes with the polygons that contain them, by bridges. Polygons are counter-clockwise, holes clockwise. A hole
/// outside of all polygons becomes a polygon.
///
/// * `loops`: the corners of each loop.
/// * `at`: returns the position of a corner.
pub(super) fn join_holes<T: Copy>(loops: Vec<Vec<T>>, at: impl Fn(T) -> Planar) -> Vec<Vec<T>> {
    let positions = |corners: &[T]| corners.iter().map(|&corner| at(corner)).collect::<Vec<_>>();
    let (mut polygons, holes): (Vec<_>, Vec<_>) =
        loops.into_iter().partition(|corners| polygon_area(&positions(corners)) >= 0.0);
    for hole in holes {
        let point = at(hole[0]);
        let outer =
            (0..polygons.len()).filter(|&n| contains(&positions(&polygons[n]), point)).min_by(|&a, &b| {
                polygon_area(&positions(&polygons[a])).total_cmp(&polygon_area(&positions(&polygons[b])))
            });
        let Some(outer) = outer else {
            polygons.push(hole);
            continue;
        };
        let polygon = &polygons[outer];
        let (from, to) = bridge(&positions(polygon), &positions(&hole));
        let mut joined = polygon[..=from].to_vec();
        joined.extend(hole[to..].iter().chain(&hole[..=to]));
        joined.extend(&polygon[from..]);
        polygons[outer] = joined;
    }
    polygons
}

/// Returns the corners of a polygon and of a hole that the shortest bridge joins that crosses no side, or the shortest
/// bridge.
fn bridge(polygon: &[Planar], hole: &[Planar]) -> (usize, usize) {
    let mut bridges: Vec<_> = (0..polygon.len()).flat_map(|p| (0..hole.len()).map(move |h| (p, h))).collect();
    let length = |&(p, h): &(usize, usize)| distance_squared(polygon[p], hole[h]);
    bridges.sort_by(|a, b| length(a).total_cmp(&length(b)).then(a.cmp(b)));
    let crosses = |corners: &[Planar], a: Planar, b: Planar| {
        (0..corners.len()).any(|n| {
            let (c, d) = (corners[n], corners[(n + 1) % corners.len()]);
            let apart = c != a && c != b && d != a && d != b;
            apart && area(a, b, c) * area(a, b, d) <= 0.0 && area(c, d, a) * area(c, d, b) <= 0.0
        })
    };
    let is_free = |&&(p, h): &&(usize, usize)| {
        !crosses(polygon, polygon[p], hole[h]) && !crosses(hole, polygon[p], hole[h])
    };
    bridges.iter().find(is_free).or(bridges.first()).copied().unwrap_or_default()
}

/// Returns whether a polygon contains a point: whether a ray along +x crosses its sides an odd number of times.
fn contains(corners: &[Planar], point: Planar) -> bool {
    let crossings = (0..corners.len()).filter(|&n| {
        let (a, b) = (corners[n], corners[(n + 1) % corners.len()]);
        (a[1] < point[1]) != (b[1] < point[1])
            && a[0] + (point[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0]) > point[0]
    });
    crossings.count() % 2 == 1
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks that the triangles have the area of a polygon, without overlap, and use every corner.
    fn check(corners: &[Planar]) -> Vec<[usize; 3]> {
        let triangles = triangulate(corners);
        assert_eq!(triangles.len(), corners.len() - 2);
        let areas = triangles.iter().map(|triangle| {
            let [a, b, c] = triangle.map(|corner| corners[corner]);
            area(a, b, c)
        });
        let areas: Vec<f64> = areas.collect();
        assert!((areas.iter().sum::<f64>() - polygon_area(corners)).abs() < 1e-12);
        assert!(areas.iter().all(|&area| area >= 0.0), "{areas:?}");
        assert!((0..corners.len()).all(|corner| triangles.iter().flatten().any(|&used| used == corner)));
        triangles
    }

    #[test]
    fn corners_on_straight_sides_give_no_empty_triangle() {
        let corners = [[0.0, 0.0], [0.3, 0.0], [0.6, 0.0], [1.0, 0.0], [1.0, 1.0], [0.5, 1.0], [0.0, 1.0]];
        for triangle in check(&corners) {
            let [a, b, c] = triangle.map(|corner| corners[corner]);
            assert!(area(a, b, c) > 0.1);
        }
    }

    #[test]
    fn notched_polygons_and_holes_are_covered_once() {
        check(&[[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [3.0, 1.0], [2.0, 3.0], [1.0, 1.0], [0.0, 4.0]]);
        let outer = vec![[0.0, 0.0], [3.0, 0.0], [3.0, 3.0], [0.0, 3.0]];
        let hole = vec![[1.0, 1.0], [1.0, 2.0], [2.0, 2.0], [2.0, 1.0]];
        let joined = join_holes(vec![outer.clone(), hole.clone()], |corner| corner);
        assert_eq!(joined.len(), 1);
        assert_eq!(polygon_area(&joined[0]), 16.0);
        check(&joined[0]);
        // Without a polygon around it, a hole is a polygon of its own.
        assert_eq!(join_holes(vec![hole.clone()], |corner| corner), [hole]);
    }

    #[test]
    fn polygons_without_area_are_triangulated() {
        assert_eq!(triangulate(&[[0.0; 2]; 5]).len(), 3);
        assert_eq!(triangulate(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [1.0, 0.0]]).len(), 2);
        assert!(triangulate(&[[0.0; 2]; 2]).is_empty());
    }
}
