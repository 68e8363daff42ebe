//! Splits triangles along the planes of broken faces.

use super::faces::BrokenFaces;
use super::faces::CutSurface;
use super::input::Input;
use super::map::Map;
use super::planes::{Cell, Face, Planes};
use super::points::{Cut, EdgePoints, Plane, moved_to_plane, on_line, position_at};
use super::refine::{Refined, Triangle};
use super::space::{Point, Space};
use crate::mesh::distinct;

/// A side of a polygon, from a corner to the next one.
#[derive(Clone, Copy, PartialEq)]
enum Side {
    /// On an edge of the triangle.
    Edge,
    /// In a plane of the grid.
    Plane(Plane),
}

/// A corner of a part of a triangle.
#[derive(Clone, Copy)]
pub(super) struct Corner {
    pub(super) point: u32,
    /// Weights of the corners of the triangle of the uncut mesh.
    pub(super) weights: [f64; 3],
    side: Side,
}

/// A convex part of a triangle.
pub(super) struct Fragment {
    /// Index of the triangle of the uncut mesh.
    pub(super) source: u32,
    pub(super) corners: Vec<Corner>,
    /// The lowest and the highest cell that the part enters.
    low: Cell,
    high: Cell,
}

impl Fragment {
    /// Returns a cell of the fragment at a point.
    pub(super) fn cell_at(&self, point: &Point) -> Cell {
        std::array::from_fn(|a| {
            let is_lower = point.on >> a & 1 != 0 && self.high[a] < point.k[a];
            point.k[a] - i32::from(is_lower)
        })
    }
}

/// The triangles of a mesh, split along the planes of broken faces.
pub(super) struct Clipped {
    pub(super) points: Vec<Point>,
    /// All triangles, for the winding numbers.
    pub(super) triangles: Vec<Triangle>,
    /// The parts of the triangles that are split, in the order of the triangles.
    pub(super) fragments: Vec<Fragment>,
    /// The sides of parts in each broken face, as pairs of points. The part on the lower side of the face is to the
    /// left, seen from above.
    pub(super) segments: Map<Face, Vec<(u32, u32)>>,
}

impl Clipped {
    /// Splits the triangles. The points of a smooth cut are moved onto the planes of the cracks.
    pub(super) fn new(input: &Input<'_>, space: Space) -> Self {
        let Input { mesh, planes: cracks, faces, .. } = *input;
        let straight = (input.surface == CutSurface::Smooth).then_some(cracks);
        let Space { mut points, refined } = space;
        let mut edges = EdgePoints::default();
        let mut planes_of = vec![0_u32; refined.triangles.len()];
        let mut planes: Vec<Vec<Plane>> = vec![Vec::new()];
        for (triangle, planes_of) in refined.triangles.iter().zip(&mut planes_of) {
            let (low, high) = cells(&points, triangle.corners);
            if low == high {
                continue;
            }
            let mut found = Vec::new();
            faces.visit_inside(low, high, |(cell, axis)| {
                found.push((axis, cell[axis] + 1));
                for side in (0..3).filter(|&side| side != axis) {
                    found.extend([(side, cell[side]), (side, cell[side] + 1)]);
                }
            });
            found.retain(|&(axis, index)| low[axis] < index && index <= high[axis]);
            let found = distinct(found);
            for &plane in &found {
                for e in 0..3 {
                    edges.cut(&mut points, [triangle.corners[e], triangle.corners[(e + 1) % 3]], plane);
                }
            }
            if !found.is_empty() {
                *planes_of = planes.len() as u32;
                planes.push(found);
            }
        }
        if let Some(planes) = straight {
            edges.straighten(&mut points, faces, planes);
        }
        let mut clipped =
            Self { points, triangles: Vec::new(), fragments: Vec::new(), segments: Map::default() };
        let mut is_split = vec![false; mesh.triangles().len()];
        for (triangle, &planes_of) in refined.triangles.iter().zip(&planes_of) {
            let is_cut = || {
                let [a, b, c] = triangle.corners;
                [[a, b], [b, c], [c, a]].into_iter().any(|edge| !edges.of_edge(edge).is_empty())
            };
            is_split[triangle.source as usize] |= planes_of != 0 || refined.is_part(triangle) || is_cut();
        }
        for (triangle, &planes_of) in refined.triangles.iter().zip(&planes_of) {
            if is_split[triangle.source as usize] {
                clipped.split(&refined, triangle, &edges, &planes[planes_of as usize], (faces, straight));
            }
        }
        clipped.triangles = refined.triangles;
        clipped
    }

    /// Splits a triangle along planes.
    fn split(
        &mut self,
        refined: &Refined,
        triangle: &Triangle,
        edges: &EdgePoints,
        planes: &[Plane],
        (faces, straight): (&BrokenFaces, Option<&Planes>),
    ) {
        let weights = refined.weights(triangle);
        let (low, high) = cells(&self.points, triangle.corners);
        let mut corners = Vec::with_capacity(6);
        for e in 0..3 {
            let (from, to) = (triangle.corners[e], triangle.corners[(e + 1) % 3]);
            corners.push(Corner { point: from, weights: weights[e], side: Side::Edge });
            let (mut start, mut end) = (weights[e], weights[(e + 1) % 3]);
            if from > to {
                std::mem::swap(&mut start, &mut end);
            }
            let corner = |cut: &Cut| Corner {
                point: cut.2,
                weights: std::array::from_fn(|c| start[c] + cut.0.t * (end[c] - start[c])),
                side: Side::Edge,
            };
            let cuts = edges.of_edge([from, to]).iter().map(corner);
            if from < to { corners.extend(cuts) } else { corners.extend(cuts.rev()) }
        }
        let mut fragments = vec![Fragment { source: triangle.source, corners, low, high }];
        let mut lines: Map<(Plane, Plane), Corner> = Map::default();
        for &plane in planes {
            let mut parts = Vec::with_capacity(fragments.len() + 2);
            for fragment in fragments {
                let points = &mut self.points;
                fragment.split(plane, points, &mut parts, |points, other| {
                    *lines.entry((plane.min(other), plane.max(other))).or_insert_with(|| {
                        let corners = triangle.corners.map(|corner| &points[corner as usize]);
                        let (mut point, mut shares) = on_line(corners, plane, other);
                        if let (Some(straight), Some(crack)) = (straight, faces.crack_at(point.k, point.on)) {
                            let distances =
                                corners.map(|corner| straight.distance_of(crack, &corner.position));
                            shares = moved_to_plane(corners, shares, distances);
                            point.position = position_at(corners, shares);
                        }
                        points.push(point);
                        let weight = |c: usize| (0..3).map(|i| shares[i] * weights[i][c]).sum();
                        let point = points.len() as u32 - 1;
                        Corner { point, weights: std::array::from_fn(weight), side: Side::Edge }
                    })
                });
            }
            fragments = parts;
        }
        for fragment in &fragments {
            self.list_segments(fragment, faces);
        }
        self.fragments.extend(fragments);
    }

    /// Lists the sides of a fragment that are in broken faces above it.
    fn list_segments(&mut self, fragment: &Fragment, faces: &BrokenFaces) {
        for (n, corner) in fragment.corners.iter().enumerate() {
            let Side::Plane((axis, index)) = corner.side else { continue };
            let next = fragment.corners[(n + 1) % fragment.corners.len()].point;
            let is_face = (0..3).all(|a| a == axis || fragment.low[a] == fragment.high[a]);
            let face = (fragment.high, axis);
            if is_face && fragment.high[axis] == index - 1 && faces.crack(face).is_some() {
                self.segments.entry(face).or_default().push((next, corner.point));
            }
        }
    }
}

impl Fragment {
    /// Splits the fragment by a plane and appends the parts to `parts`.
    ///
    /// * `on_line`: returns the corner at which the triangle crosses the line of the plane and another plane.
    fn split(
        self,
        plane: Plane,
        points: &mut Vec<Point>,
        parts: &mut Vec<Self>,
        mut on_line: impl FnMut(&mut Vec<Point>, Plane) -> Corner,
    ) {
        let (axis, index) = plane;
        let side = |points: &[Point], corner: &Corner| {
            let point = &points[corner.point as usize];
            let is_on = point.on >> axis & 1 != 0 && point.k[axis] == index;
            if is_on { 0 } else { i32::from(point.k[axis] >= index) * 2 - 1 }
        };
        // The corners with their sides of the plane, and new corners where the plane crosses a side of the fragment.
        let mut corners: Vec<(Corner, i32)> = Vec::with_capacity(self.corners.len() + 2);
        for (n, &corner) in self.corners.iter().enumerate() {
            let next = &self.corners[(n + 1) % self.corners.len()];
            let (here, there) = (side(points, &corner), side(points, next));
            corners.push((corner, here));
            if let (-1, Side::Plane(other)) = (here * there, corner.side) {
                corners.push((Corner { side: corner.side, ..on_line(points, other) }, 0));
            }
        }
        // A corner in the plane is a crossing if the fragment is on different sides before and after it.
        let count = corners.len();
        let Some(first) = corners.iter().position(|&(_, side)| side != 0) else { return parts.push(self) };
        corners.rotate_left(first);
        let mut before = corners[0].1;
        for n in 1..count {
            if corners[n].1 == 0 {
                let after =
                    corners[n..].iter().chain(&corners[..1]).map(|&(_, side)| side).find(|&side| side != 0);
                let after = after.unwrap_or(before);
                corners[n].1 = if after == before { before } else { 0 };
                before = after;
            } else {
                before = corners[n].1;
            }
        }
        if corners.iter().all(|&(_, side)| side >= 0) || corners.iter().all(|&(_, side)| side <= 0) {
            let mut part = self;
            if corners[0].1 > 0 {
                part.low[axis] = part.low[axis].max(index);
            } else {
                part.high[axis] = part.high[axis].min(index - 1);
            }
            return parts.push(part);
        }
        // Begins at a crossing to the upper side.
        let is_up = |n: usize| corners[n].1 == 0 && corners[(n + 1) % count].1 > 0;
        let Some(first) = (0..count).find(|&n| is_up(n)) else { return parts.push(self) };
        corners.rotate_left(first);
        let in_plane = |corner: Corner| Corner { side: Side::Plane(plane), ..corner };
        let Self { source, mut low, mut high, .. } = self;
        (low[axis], high[axis]) = (self.low[axis].min(index - 1), index - 1);
        let mut lower = Self { source, corners: Vec::new(), low, high };
        (low[axis], high[axis]) = (index, self.high[axis].max(index));
        let mut upper: Option<Self> = None;
        for (corner, side) in corners {
            match (side, upper.take()) {
                (0, None) => {
                    lower.corners.push(in_plane(corner));
                    upper = Some(Self { source, corners: vec![corner], low, high });
                }
                (0, Some(mut part)) => {
                    part.corners.push(in_plane(corner));
                    parts.push(part);
                    lower.corners.push(corner);
                }
                (_, Some(mut part)) => {
                    part.corners.push(corner);
                    upper = Some(part);
                }
                (_, None) => lower.corners.push(corner),
            }
        }
        parts.push(lower);
    }
}

/// Returns the lowest and the highest cell of the corners of a triangle, on each axis.
fn cells(points: &[Point], corners: [u32; 3]) -> (Cell, Cell) {
    let [p, q, r] = corners.map(|corner| points[corner as usize].k);
    (std::array::from_fn(|a| p[a].min(q[a]).min(r[a])), std::array::from_fn(|a| p[a].max(q[a]).max(r[a])))
}
