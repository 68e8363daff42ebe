//! The points at which edges and triangles cross the planes of the grid.

use nalgebra::{Point3, Vector3};

use super::faces::BrokenFaces;
use super::map::Map;
use super::planes::{Cell, Planes};
use super::space::Point;

/// Share of the length of an edge by which a plane may pass beside it: whether a point within the tolerance of the grid of a
/// plane counts as above or below it is decided by the surface around the point, and not by its distance. Greater than the
/// tolerance, 1e-5 cells near the origin, relative to all but the shortest edges.
const EDGE_MARGIN: f64 = 1e-3;

/// A plane of the grid: the axis, and the index of the cells above the plane.
pub(super) type Plane = (usize, i32);

/// A cut of an edge: its place along the edge, the plane, and the new point.
pub(super) type Cut = (Crossing, Plane, u32);

/// The points at which edges are cut.
#[derive(Default)]
pub(super) struct EdgePoints {
    /// For each edge, from its lower to its higher point: the planes that cut it, with the new points, sorted along the
    /// edge.
    edges: Map<(u32, u32), Vec<Cut>>,
    /// Whether each point is an end of a cut edge, as far as the last such point.
    is_end: Vec<bool>,
}

/// The place of a crossing along an edge. Crossings at equal parameters are in the order of the axes.
#[derive(Clone, Copy, PartialEq, PartialOrd)]
pub(super) struct Crossing {
    pub(super) t: f64,
    axis: usize,
}

/// Returns the crossing of an edge and a plane.
fn crossing(a: &Point, b: &Point, (axis, index): Plane) -> Crossing {
    let t = (f64::from(index) - a.u[axis]) / (b.u[axis] - a.u[axis]);
    // Differences of coordinates that are not finite.
    Crossing { t: if t.is_nan() { 0.5 } else { t.clamp(0.0, 1.0) }, axis }
}

/// Returns the index on an axis of the cell in which an edge is at a crossing.
fn index_at(a: &Point, b: &Point, axis: usize, at: Crossing) -> i32 {
    let up = b.k[axis] > a.k[axis];
    let is_before = |index: i32| crossing(a, b, (axis, index)) < at;
    // Number of planes that are crossed before, by bisection: the crossings are in order.
    let planes = (i64::from(b.k[axis]) - i64::from(a.k[axis])).unsigned_abs();
    let (mut low, mut high) = (0, planes);
    while low < high {
        let middle = low + (high - low) / 2;
        let index = if up { a.k[axis] + 1 + middle as i32 } else { a.k[axis] - middle as i32 };
        if is_before(index) { low = middle + 1 } else { high = middle }
    }
    if up { a.k[axis] + low as i32 } else { a.k[axis] - low as i32 }
}

/// Returns whether an edge crosses a plane.
fn crosses(a: &Point, b: &Point, (axis, index): Plane) -> bool {
    (a.k[axis] < index) != (b.k[axis] < index)
}

impl EdgePoints {
    /// Cuts an edge by a plane, if the plane crosses it.
    pub(super) fn cut(&mut self, points: &mut Vec<Point>, ends: [u32; 2], plane: Plane) {
        let key = (ends[0].min(ends[1]), ends[0].max(ends[1]));
        let (a, b) = (points[key.0 as usize], points[key.1 as usize]);
        if !crosses(&a, &b, plane) {
            return;
        }
        if self.is_end.len() <= key.1 as usize {
            self.is_end.resize(key.1 as usize + 1, false);
        }
        (self.is_end[key.0 as usize], self.is_end[key.1 as usize]) = (true, true);
        let cuts = self.edges.entry(key).or_default();
        let at = crossing(&a, &b, plane);
        let place = |cut: &Cut| (cut.0, order(&a, cut.1)) < (at, order(&a, plane));
        let index = cuts.partition_point(place);
        if cuts.get(index).is_some_and(|cut| cut.1 == plane) {
            return;
        }
        cuts.insert(index, (at, plane, points.len() as u32));
        let mut u = a.u + (b.u - a.u) * at.t;
        u[plane.0] = f64::from(plane.1);
        let mut k: Cell = std::array::from_fn(|c| index_at(&a, &b, c, at));
        k[plane.0] = plane.1;
        let position = a.position + (b.position - a.position) * at.t;
        points.push(Point { position, u, k, on: 1 << plane.0 });
    }

    /// Moves the points at broken faces along their edges onto the planes of the cracks, where these cross the edges. Only
    /// the positions change: the order of the points and the cells stay.
    pub(super) fn straighten(&mut self, points: &mut [Point], faces: &BrokenFaces, planes: &Planes) {
        // Each edge changes its own points only, so that the order of the edges does not matter.
        for (&(a, b), cuts) in &mut self.edges {
            let (a, b) = (points[a as usize], points[b as usize]);
            let on_plane = |cut: &Cut| {
                let point = &points[cut.2 as usize];
                let crack = faces.crack_at(point.k, point.on)?;
                let (a, b) = (planes.distance_of(crack, &a.position), planes.distance_of(crack, &b.position));
                let t = a / (a - b);
                (-EDGE_MARGIN..=1.0 + EDGE_MARGIN).contains(&t).then(|| t.clamp(0.0, 1.0))
            };
            let moved: Vec<Option<f64>> = cuts.iter().map(on_plane).collect();
            if !moved.iter().flatten().is_sorted() {
                continue;
            }
            let mut low: f64 = 0.0;
            for (n, cut) in cuts.iter_mut().enumerate() {
                let high = moved[n..].iter().flatten().next().copied().unwrap_or(1.0);
                cut.0.t = moved[n].unwrap_or_else(|| cut.0.t.clamp(low, high.max(low)));
                low = cut.0.t;
                points[cut.2 as usize].position = a.position + (b.position - a.position) * cut.0.t;
            }
        }
    }

    /// Returns the cuts of an edge in the order from its lower to its higher point.
    pub(super) fn of_edge(&self, [a, b]: [u32; 2]) -> &[Cut] {
        if ![a, b].iter().all(|&end| self.is_end.get(end as usize) == Some(&true)) {
            return &[];
        }
        self.edges.get(&(a.min(b), a.max(b))).map_or(&[], Vec::as_slice)
    }
}

/// Returns the rank of a plane among the planes of its axis that an edge from `a` crosses at one parameter.
fn order(a: &Point, (axis, index): Plane) -> i64 {
    if a.k[axis] < index { i64::from(index) } else { -i64::from(index) }
}

/// Returns how often a triangle winds around the line of two planes, seen against the direction of the third axis: +1
/// if it is counter-clockwise there, -1 if it is clockwise, 0 if it does not cross the line.
pub(super) fn winding(corners: [(u32, &Point); 3], axis: usize, j: i32, k: i32) -> i32 {
    let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut sum = 0;
    for e in 0..3 {
        let ((from, start), (to, end)) = (corners[e], corners[(e + 1) % 3]);
        if !crosses(start, end, (b, j)) {
            continue;
        }
        let (low, high) = if from < to { (start, end) } else { (end, start) };
        if index_at(low, high, c, crossing(low, high, (b, j))) >= k {
            sum += if start.k[b] < j { -1 } else { 1 };
        }
    }
    sum
}

/// Returns the point at which a triangle crosses the line of two planes, and its barycentric coordinates in the
/// triangle.
pub(super) fn on_line(corners: [&Point; 3], first: Plane, second: Plane) -> (Point, [f64; 3]) {
    // Both orders of the planes give the same bits.
    let ((a, i), (b, j)) = (first.min(second), first.max(second));
    let axis = 3 - a - b;
    let [p, q, r] = corners;
    let (e, f) = (q.u - p.u, r.u - p.u);
    let (x, y) = (f64::from(i) - p.u[a], f64::from(j) - p.u[b]);
    let area = e[a] * f[b] - e[b] * f[a];
    let share =
        |value: f64| if (value / area).is_finite() { (value / area).clamp(0.0, 1.0) } else { 1.0 / 3.0 };
    let (s, t) = (share(x * f[b] - y * f[a]), share(e[a] * y - e[b] * x));
    let total = (s + t).max(1.0);
    let (s, t) = (s / total, t / total);
    let weights = [1.0 - s - t, s, t];
    let mut u = p.u + e * s + f * t;
    (u[a], u[b]) = (f64::from(i), f64::from(j));
    // The side of each corner of the grid on the line, seen from the triangle, decides in which cell the point is.
    let normal = e.cross(&f);
    let is_above = |index: i32| {
        let mut corner = u;
        corner[axis] = f64::from(index);
        (normal.dot(&(corner - p.u)) >= 0.0) == (normal[axis] < 0.0)
    };
    let indices = corners.map(|corner| corner.k[axis]);
    let (mut low, mut high) =
        (indices[0].min(indices[1]).min(indices[2]), indices[0].max(indices[1]).max(indices[2]));
    while low < high {
        let middle = low + (high - low + 1) / 2;
        if is_above(middle) { low = middle } else { high = middle - 1 }
    }
    let mut k = [0; 3];
    (k[a], k[b], k[axis]) = (i, j, low);
    (Point { position: position_at(corners, weights), u, k, on: 1 << a | 1 << b }, weights)
}

/// Returns the position of a point of a triangle. It is exactly in a plane of the axes that contains the triangle.
///
/// * `weights`: barycentric coordinates of the point.
pub(super) fn position_at(corners: [&Point; 3], weights: [f64; 3]) -> Point3<f64> {
    let [p, q, r] = corners.map(|corner| corner.position);
    p + (q - p) * weights[1] + (r - p) * weights[2]
}

/// Returns barycentric coordinates of a point moved within its triangle onto a plane: to the nearest point of the line where
/// the plane crosses the triangle; if it passes beside the triangle, of the corners in it; otherwise the point stays.
///
/// * `weights`: barycentric coordinates of the point.
/// * `distances`: distances of the corners from the plane.
pub(super) fn moved_to_plane(corners: [&Point; 3], weights: [f64; 3], distances: [f64; 3]) -> [f64; 3] {
    let crossing = |(a, b): (usize, usize)| {
        let [from, to] = [distances[a], distances[b]];
        let mut shares = [0.0; 3];
        shares[b] = from / (from - to);
        shares[a] = 1.0 - shares[b];
        ((from < 0.0) != (to < 0.0)).then_some(shares)
    };
    let mut ends: Vec<[f64; 3]> = [(0, 1), (1, 2), (2, 0)].into_iter().filter_map(crossing).collect();
    if ends.is_empty() {
        let greatest = Vector3::from(distances).amax();
        let is_in_plane = |&c: &usize| distances[c].abs() <= EDGE_MARGIN * greatest;
        // A plane without a normal has the distance 0 everywhere.
        let corners = (0..3).filter(|c| greatest > 0.0 && is_in_plane(c));
        ends.extend(corners.map(|c| <[f64; 3]>::from(Vector3::ith(c, 1.0))));
    }
    let [first, second] = match ends[..] {
        [first, second] => [first, second],
        [only] => return only,
        _ => return weights,
    };
    let [start, end, point] = [first, second, weights].map(|shares| position_at(corners, shares));
    let along = end - start;
    let t = (point - start).dot(&along) / along.norm_squared();
    let t = if t.is_nan() { 0.5 } else { t.clamp(0.0, 1.0) };
    std::array::from_fn(|c| first[c] + (second[c] - first[c]) * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Moves the centroid of the triangle (0, 0), (1, 0), (0, 1).
    fn moved(distances: [f64; 3]) -> [f64; 3] {
        let corner = |x: f64, y: f64| {
            let position = Point3::new(x, y, 0.0);
            Point { position, u: position.coords, k: [0; 3], on: 0 }
        };
        let corners = [corner(0.0, 0.0), corner(1.0, 0.0), corner(0.0, 1.0)];
        moved_to_plane(corners.each_ref(), [1.0 / 3.0; 3], distances)
    }

    #[track_caller]
    fn assert_near(found: [f64; 3], expected: [f64; 3]) {
        assert!((Vector3::from(found) - Vector3::from(expected)).amax() < 1e-12, "{found:?} {expected:?}");
    }

    #[test]
    fn points_move_onto_planes_that_cross_or_touch_their_triangle() {
        // The plane x = 1/2 crosses two edges.
        assert_near(moved([-0.5, 0.5, -0.5]), [1.0 / 6.0, 0.5, 1.0 / 3.0]);
        for side in [1.0, -1.0] {
            // An edge in the plane, up to rounding, and a corner in it.
            assert_near(moved([0.0, 0.0, side]), [2.0 / 3.0, 1.0 / 3.0, 0.0]);
            assert_near(moved([1e-9 * side, 1e-9 * side, side]), [2.0 / 3.0, 1.0 / 3.0, 0.0]);
            assert_near(moved([1e-9 * side, 0.5 * side, side]), [1.0, 0.0, 0.0]);
            // A plane that is far away, and one without a normal.
            assert_near(moved([side, 2.0 * side, 2.0 * side]), [1.0 / 3.0; 3]);
        }
        assert_near(moved([0.0; 3]), [1.0 / 3.0; 3]);
    }
}
