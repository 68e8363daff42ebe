//! Joins the holes of a polygon with it.

use crate::mesh::{Planar, distance_squared, planar_area, polygon_area};

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
            apart
                && planar_area(a, b, c) * planar_area(a, b, d) <= 0.0
                && planar_area(c, d, a) * planar_area(c, d, b) <= 0.0
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

    #[test]
    fn a_hole_is_joined_with_the_polygon_around_it() {
        let outer = vec![[0.0, 0.0], [3.0, 0.0], [3.0, 3.0], [0.0, 3.0]];
        let hole = vec![[1.0, 1.0], [1.0, 2.0], [2.0, 2.0], [2.0, 1.0]];
        let joined = join_holes(vec![outer, hole.clone()], |corner| corner);
        assert_eq!(joined.len(), 1);
        assert_eq!((joined[0].len(), polygon_area(&joined[0])), (10, 16.0));
        // Without a polygon around it, a hole is a polygon of its own.
        assert_eq!(join_holes(vec![hole.clone()], |corner| corner), [hole]);
    }
}
