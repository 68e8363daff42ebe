//! Triangles of polygons, by ear clipping.
//!
//! Published crates do not fit here: `earcut` leaves out corners on straight lines, `spade` merges corners at one
//! position, and `i_triangle` rounds to a grid. The triangles of a closed surface must use every corner of a polygon.

/// Number of corners up to which the best ear is clipped, and not the first one.
const BEST: usize = 40;

/// Area of a triangle below which it counts as empty, relative to the square of the extent of the polygon.
const EMPTY: f64 = 1e-12;

/// Position of a corner in the plane of a polygon.
pub(crate) type Planar = [f64; 2];

/// Returns twice the signed area of a triangle.
pub(crate) fn planar_area(a: Planar, b: Planar, c: Planar) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

pub(crate) fn distance_squared(a: Planar, b: Planar) -> f64 {
    (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2)
}

/// Returns twice the signed area of a polygon.
pub(crate) fn polygon_area(corners: &[Planar]) -> f64 {
    let mut twice = 0.0;
    for n in 1..corners.len().saturating_sub(1) {
        twice += planar_area(corners[0], corners[n], corners[n + 1]);
    }
    twice
}

/// Returns the triangles of a polygon as indices of its corners: always two less than corners. The polygon should be
/// simple and counter-clockwise; corners on a straight line, equal corners and bridges to holes are valid. Of any other
/// polygon the triangles overlap, but have the same boundary.
pub(crate) fn triangulate(corners: &[Planar]) -> Vec<[usize; 3]> {
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
            let doubled = planar_area(a, b, c);
            let longest = distance_squared(a, b).max(distance_squared(b, c)).max(distance_squared(c, a));
            (doubled > empty).then(|| doubled / longest)
        };
        let is_free = |n: usize| {
            let (a, b, c) = (at(n + count - 1), at(n), at(n + 1));
            (n + 2..n + count - 1).all(|other| {
                let p = at(other);
                let is_outside =
                    planar_area(a, b, p) < 0.0 || planar_area(b, c, p) < 0.0 || planar_area(c, a, p) < -empty;
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks that the triangles have the area of a polygon, without overlap, and use every corner.
    fn check(corners: &[Planar]) -> Vec<[usize; 3]> {
        let triangles = triangulate(corners);
        assert_eq!(triangles.len(), corners.len() - 2);
        let areas = triangles.iter().map(|triangle| {
            let [a, b, c] = triangle.map(|corner| corners[corner]);
            planar_area(a, b, c)
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
            assert!(planar_area(a, b, c) > 0.1);
        }
    }

    #[test]
    fn notched_polygons_and_bridges_are_covered_once() {
        check(&[[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [3.0, 1.0], [2.0, 3.0], [1.0, 1.0], [0.0, 4.0]]);
        // A square with a hole, and a bridge between the two.
        let outer = [[0.0, 0.0], [3.0, 0.0], [3.0, 3.0], [0.0, 3.0], [0.0, 0.0]];
        let hole = [[1.0, 1.0], [1.0, 2.0], [2.0, 2.0], [2.0, 1.0], [1.0, 1.0]];
        check(&[outer, hole].concat());
    }

    #[test]
    fn polygons_without_area_are_triangulated() {
        assert_eq!(triangulate(&[[0.0; 2]; 5]).len(), 3);
        assert_eq!(triangulate(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [1.0, 0.0]]).len(), 2);
        assert!(triangulate(&[[0.0; 2]; 2]).is_empty());
    }
}
