//! The polygons of broken faces that are inside the mesh.
//!
//! In a broken face, the sides of the parts of triangles and the edges of the face form closed loops. The mesh winds
//! around each piece of an edge of the face a number of times, and so often the piece belongs to the boundary of a
//! polygon.

use super::clip::Clipped;
use super::faces::CutSurface;
use super::holes::join_holes;
use super::input::Input;
use super::map::Map;
use super::planes::{Cell, Face};
use super::space::Point;
use super::winding::Windings;
use crate::mesh::{Planar, triangulate};
use crate::voxel::step;

/// Number of rounds in which the planes of several cracks move a corner.
const ROUNDS: usize = 16;

/// Greatest displacement of a corner onto the planes of its cracks, in cells: the half diagonal of a cell, rounded up.
const FARTHEST: f64 = 0.87;

/// A polygon in a broken face.
pub(super) struct Cap {
    pub(super) face: Face,
    pub(super) crack: u32,
    /// Its corners, counter-clockwise seen from above the face: three, or the four corners of the face.
    pub(super) corners: Vec<u32>,
}

/// The caps of the broken faces.
pub(super) struct Caps {
    pub(super) caps: Vec<Cap>,
    /// Number of faces without a cap, because the mesh is open there.
    pub(super) unclosed: usize,
}

impl Caps {
    /// Finds the caps. Appends the corners of the grid inside the mesh to the points.
    pub(super) fn new(input: &Input<'_>, clipped: &mut Clipped) -> Self {
        let faces = input.faces;
        let base = |&((cell, axis), _): &(Face, u32)| step(cell, axis, 1);
        let windings = Windings::new(&clipped.points, &clipped.triangles, faces.sorted().iter().map(base));
        let mut caps = Self { caps: Vec::new(), unclosed: 0 };
        let mut corners = Map::default();
        for &(face, crack) in faces.sorted() {
            let segments = clipped.segments.get(&face).map_or(&[][..], Vec::as_slice);
            let winding = windings.at(step(face.0, face.1, 1));
            if segments.is_empty() && winding == 0 {
                continue;
            }
            let points = &mut clipped.points;
            let mut corner = |points: &mut Vec<Point>, index: Cell| {
                *corners.entry(index).or_insert_with(|| {
                    points.push(corner_point(input, index));
                    points.len() as u32 - 1
                })
            };
            let Some(edges) = boundary(points, face, segments, winding, &mut corner) else {
                caps.unclosed += 1;
                continue;
            };
            let (b, c) = ((face.1 + 1) % 3, (face.1 + 2) % 3);
            let at = |point: u32| -> Planar {
                let u = &points[point as usize].u;
                [u[b], u[c]]
            };
            let loops = loops(edges, at);
            if let ([quad], true) = (&loops[..], segments.is_empty())
                && quad.len() == 4
            {
                caps.caps.push(Cap { face, crack, corners: quad.clone() });
                continue;
            }
            for polygon in join_holes(loops, at) {
                let positions: Vec<Planar> = polygon.iter().map(|&point| at(point)).collect();
                for triangle in triangulate(&positions) {
                    let corners = triangle.map(|corner| polygon[corner]).to_vec();
                    caps.caps.push(Cap { face, crack, corners });
                }
            }
        }
        caps
    }
}

/// Returns the point at a corner of the grid. On a smooth cut it is moved onto the planes of the cracks.
fn corner_point(input: &Input<'_>, index: Cell) -> Point {
    let Input { lattice, planes, faces, surface, .. } = *input;
    let u = nalgebra::Vector3::from(index.map(f64::from));
    let mut moved = u;
    if surface == CutSurface::Smooth {
        let cracks = faces.cracks_at(index);
        for _ in 0..if cracks.len() > 1 { ROUNDS } else { 1 } {
            for &crack in &cracks {
                moved -= planes.normal(crack) * planes.distance(crack, &moved);
            }
        }
        let distance = (moved - u).norm();
        if distance > FARTHEST {
            moved = u + (moved - u) * (FARTHEST / distance);
        }
    }
    Point { position: lattice.origin() + moved * lattice.cell_size(), u, k: index, on: 7 }
}

/// Returns the directed edges of the polygons of a face, counter-clockwise seen from above, or `None` if they are not
/// closed.
///
/// * `winding`: winding number of the mesh around the lowest corner of the face.
fn boundary(
    points: &mut Vec<Point>,
    (cell, axis): Face,
    segments: &[(u32, u32)],
    winding: i32,
    corner: &mut impl FnMut(&mut Vec<Point>, Cell) -> u32,
) -> Option<Vec<(u32, u32)>> {
    let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
    // Each end of a segment, and whether the segment begins there.
    let mut ends: Vec<(u32, i32)> = segments.iter().flat_map(|&(from, to)| [(from, 1), (to, -1)]).collect();
    ends.sort_unstable();
    // The ends on the edges of the face, in the order around the face: edge, position, point, excess of beginnings.
    let mut nodes: Vec<(usize, f64, i64, u32, i32)> = Vec::new();
    for node in ends.chunk_by(|x, y| x.0 == y.0) {
        let (number, excess) = (node[0].0, node.iter().map(|end| end.1).sum::<i32>());
        if excess == 0 {
            continue;
        }
        let point = &points[number as usize];
        let on = |a: usize, index: i32| point.on >> a & 1 != 0 && point.k[a] == index;
        let edge = [on(c, cell[c]), on(b, cell[b] + 1), on(c, cell[c] + 1), on(b, cell[b])];
        let edge = edge.iter().position(|&on| on)?;
        let along = if edge % 2 == 0 { point.u[b] } else { point.u[c] };
        let sign = if edge < 2 { 1 } else { -1 };
        nodes.push((edge, along * f64::from(sign), i64::from(number) * i64::from(sign), number, excess));
    }
    nodes.sort_by(|x, y| x.0.cmp(&y.0).then(x.1.total_cmp(&y.1)).then(x.2.cmp(&y.2)));
    let mut edges = segments.to_vec();
    let mut around = winding;
    let mut nodes = nodes.into_iter().peekable();
    for edge in 0..4 {
        let offsets = [[0, 0], [1, 0], [1, 1], [0, 1]];
        let mut corner_of = |points: &mut Vec<Point>, [x, y]: [i32; 2]| {
            let mut index = step(cell, axis, 1);
            (index[b], index[c]) = (cell[b] + x, cell[c] + y);
            corner(points, index)
        };
        // A corner is a point only where a piece of an edge ends at it.
        let mut from = None;
        let mut next = nodes.next_if(|node| node.0 == edge);
        loop {
            if around != 0 {
                let start = from.unwrap_or_else(|| corner_of(points, offsets[edge]));
                let end = next.map_or_else(|| corner_of(points, offsets[(edge + 1) % 4]), |node| node.3);
                let piece = if around > 0 { (start, end) } else { (end, start) };
                edges.extend(std::iter::repeat_n(piece, around.unsigned_abs() as usize));
            }
            let Some(node) = next else { break };
            around -= node.4;
            from = Some(node.3);
            next = nodes.next_if(|node| node.0 == edge);
        }
    }
    (around == winding).then_some(edges)
}

/// Returns the loops of directed edges. At a point of several loops, the inside stays on the left.
fn loops(mut edges: Vec<(u32, u32)>, at: impl Fn(u32) -> Planar) -> Vec<Vec<u32>> {
    edges.sort_unstable();
    let mut used = vec![false; edges.len()];
    let mut loops = Vec::new();
    for first in 0..edges.len() {
        if used[first] {
            continue;
        }
        let (mut corners, mut edge) = (Vec::new(), first);
        loop {
            used[edge] = true;
            let (from, here) = edges[edge];
            corners.push(from);
            let start = edges.partition_point(|edge| edge.0 < here);
            let leaving = (start..edges.len()).take_while(|&next| edges[next].0 == here);
            let angle = |next: usize| {
                let direction =
                    |point: u32| libm::atan2(at(point)[1] - at(here)[1], at(point)[0] - at(here)[0]);
                let clockwise = direction(from) - direction(edges[next].1);
                if clockwise <= 0.0 { clockwise + std::f64::consts::TAU } else { clockwise }
            };
            let Some(next) = leaving
                .filter(|&next| !used[next] || next == first)
                .min_by(|&x, &y| angle(x).total_cmp(&angle(y)))
            else {
                break;
            };
            if next == first {
                break;
            }
            edge = next;
        }
        if corners.len() > 2 {
            loops.push(corners);
        }
    }
    loops
}
