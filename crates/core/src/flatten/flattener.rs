//! Moves lattice vertices so that the mesh lies on the colliders that it is pressed onto.

use nalgebra::{Point3, Vector3};

use super::approach::{REACH, approach, touching};
use super::least_squares::LeastSquares;
use super::table::FlattenTable;
use crate::contact::{PosedShape, SignedDistance};
use crate::lattice::{Embedding, PointMap, Slopes, Trust, trilinear_weights};
use crate::simd::xyzx::{Xyzx, xyzx};

/// Displacement of a mesh vertex, in cells, from which the vertices of its cell are fully active.
const ACTIVE: f64 = 0.01;

/// Number of times that the remaining displacements are solved for, if the skin is smooth: the position of a mesh vertex then is not
/// a mean of the corners of its cell.
const SMOOTH_ROUNDS: usize = 2;

/// The mesh vertices of a cell that are near a collider.
#[derive(Clone, Copy, Debug)]
struct NearCell {
    /// Index of the cell among the cells with mesh vertices.
    cell: u32,
    /// Index in `Flattener::gaps`.
    contact: u32,
    /// First and end of the mesh vertices in `Flattener::near`.
    range: [u32; 2],
}

/// A mesh vertex near a collider.
#[derive(Clone, Copy, Debug)]
struct Near {
    point: u32,
    gap: f64,
    /// Normal of the collider.
    normal: Vector3<f64>,
}

/// A mesh vertex in a cell with one that moves, and the position to which it moves.
#[derive(Clone, Copy, Debug)]
struct Target {
    point: u32,
    cell: u32,
    position: [f32; 3],
}

/// Flattens surfaces, and owns the buffers.
#[derive(Debug, Default)]
pub(crate) struct Flattener {
    /// Positions before the flattening.
    start: Vec<[f32; 3]>,
    near: Vec<Near>,
    near_cells: Vec<NearCell>,
    /// Least gap of each component from each collider.
    gaps: Vec<f64>,
    /// The mesh vertices of the cells with one that moves.
    targets: Vec<Target>,
    least_squares: LeastSquares,
    lattice: Vec<Xyzx>,
    slopes: Vec<[Xyzx; 3]>,
    trust: Trust,
}

impl Flattener {
    /// Returns the memory in bytes.
    pub(crate) fn bytes(&self) -> usize {
        let near = size_of_val(&*self.near) + size_of_val(&*self.near_cells);
        let points = near + size_of_val(&*self.targets) + size_of_val(&*self.gaps);
        let lattice = size_of_val(&*self.lattice) + size_of_val(&*self.slopes) + self.trust.bytes();
        points + lattice + size_of_val(&*self.start) + self.least_squares.bytes()
    }

    /// Returns false only if no collider is near a lattice.
    pub(crate) fn is_near<'a>(shapes: impl Iterator<Item = PosedShape<'a>>, positions: &[[f32; 3]]) -> bool {
        let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for position in positions {
            low = std::array::from_fn(|k| low[k].min(position[k]));
            high = std::array::from_fn(|k| high[k].max(position[k]));
        }
        let [low, high] = [low, high].map(|point| Vector3::from(point.map(f64::from)));
        let (center, half) = (Point3::from((low + high) / 2.0), (high - low) / 2.0);
        shapes.into_iter().any(|shape| shape.may_touch(&center, &half, REACH))
    }

    /// Returns the positions before the flattening.
    pub(crate) fn start(&self) -> &[[f32; 3]] {
        &self.start
    }

    /// Moves the lattice vertices of a body. Returns whether any has moved.
    ///
    /// * `shapes`: the colliders, in the frame of the body.
    /// * `fixed`: vertices that do not move.
    /// * `positions`: in cells, one per lattice vertex.
    pub(crate) fn flatten<'a>(
        &mut self,
        (table, embedding): (&FlattenTable, &Embedding),
        shapes: impl Iterator<Item = PosedShape<'a>>,
        fixed: impl Iterator<Item = u32>,
        positions: &mut [[f32; 3]],
    ) -> bool {
        self.start.clear();
        self.start.extend_from_slice(positions);
        self.set_lattice(embedding, positions);
        self.find_near((table, embedding), shapes);
        if !self.find_targets((table, embedding), positions) {
            return false;
        }
        self.least_squares.prepare(table, fixed, positions);
        let rounds = if embedding.smoothing().is_some() { SMOOTH_ROUNDS } else { 1 };
        for round in 0..rounds {
            if round > 0 {
                self.set_lattice(embedding, positions);
            }
            self.add_displacements((table, embedding));
            self.least_squares.displace(table, positions);
        }
        true
    }

    /// Sets the positions of the lattice, and their slopes if the skin is smooth.
    fn set_lattice(&mut self, embedding: &Embedding, positions: &[[f32; 3]]) {
        self.lattice.clear();
        self.lattice.extend(positions.iter().copied().map(xyzx));
        if let Some(smoothing) = embedding.smoothing() {
            smoothing.update_slopes(&self.lattice, &mut self.slopes);
            smoothing.update_trust(positions, &mut self.trust);
        }
    }

    /// Lists the mesh vertices near each collider, by cell.
    fn find_near<'a>(
        &mut self,
        (table, embedding): (&FlattenTable, &Embedding),
        shapes: impl Iterator<Item = PosedShape<'a>>,
    ) {
        let Self { near, near_cells, gaps, lattice, slopes, trust, .. } = self;
        let slopes = embedding.smoothing().map(|_| Slopes { slopes, trust: trust.values() });
        near.clear();
        near_cells.clear();
        gaps.clear();
        for shape in shapes {
            let first = gaps.len();
            gaps.resize(first + table.count, f64::INFINITY);
            for (cell, corners) in (0..).zip(&table.corners) {
                let (center, half) = bounds(corners, lattice);
                if !shape.may_touch(&center, &half, REACH) {
                    continue;
                }
                let contact = first + table.components[corners[0] as usize] as usize;
                let start = near.len() as u32;
                let map = PointMap::new(corners, lattice, slopes);
                for &point in table.points(cell) {
                    let position = map.at(embedding.local(point as usize)).map(f64::from);
                    let SignedDistance { distance: gap, normal } = shape.signed_distance(&position.into());
                    if gap < REACH {
                        gaps[contact] = gaps[contact].min(gap);
                        near.push(Near { point, gap, normal });
                    }
                }
                if near.len() as u32 > start {
                    let range = [start, near.len() as u32];
                    near_cells.push(NearCell { cell, contact: contact as u32, range });
                }
            }
        }
        near_cells.sort_unstable_by_key(|near| (near.cell, near.contact));
    }

    /// Finds the positions to which mesh vertices move, and activates the corners of their cells. Returns whether any moves.
    fn find_targets(
        &mut self,
        (table, embedding): (&FlattenTable, &Embedding),
        positions: &[[f32; 3]],
    ) -> bool {
        let Self { near, near_cells, gaps, targets, least_squares, lattice, slopes, trust, .. } = self;
        let slopes = embedding.smoothing().map(|_| Slopes { slopes, trust: trust.values() });
        least_squares.clear(positions.len());
        targets.clear();
        for in_cell in near_cells.chunk_by(|a, b| a.cell == b.cell) {
            let cell = in_cell[0].cell;
            let (corners, points) = (&table.corners[cell as usize], table.points(cell));
            let derivatives = corners.map(|corner| table.derivatives(corner, positions));
            let map = PointMap::new(corners, lattice, slopes);
            let (first, mut greatest) = (targets.len(), 0.0_f64);
            targets.extend(points.iter().map(|&point| {
                let position = map.at(embedding.local(point as usize));
                Target { point, cell, position }
            }));
            for &NearCell { contact, range: [start, end], .. } in in_cell {
                let contact = touching(gaps[contact as usize]);
                for near in near[start as usize..end as usize].iter().filter(|_| contact > 0.0) {
                    let weights = trilinear_weights(embedding.local(near.point as usize));
                    let mut frame = [Vector3::zeros(); 3];
                    for (weight, derivatives) in weights.into_iter().zip(&derivatives) {
                        (0..3).for_each(|axis| frame[axis] += derivatives[axis] * weight);
                    }
                    let at_rest = &table.normals[near.point as usize];
                    let (compression, cosine) = compression(&frame, at_rest, &near.normal);
                    let length = contact * approach(near.gap, compression, cosine);
                    greatest = greatest.max(length);
                    let index = first + points.partition_point(|&point| point < near.point);
                    let position = &mut targets[index].position;
                    (0..3).for_each(|k| position[k] -= (near.normal[k] * length) as f32);
                }
            }
            if greatest > 0.0 {
                least_squares.activate(corners, (greatest / ACTIVE).min(1.0) as f32);
            } else {
                targets.truncate(first);
            }
        }
        !targets.is_empty()
    }

    /// Adds the displacements of the mesh vertices from their present positions to their targets.
    fn add_displacements(&mut self, (table, embedding): (&FlattenTable, &Embedding)) {
        let Self { targets, least_squares, lattice, slopes, trust, .. } = self;
        let slopes = embedding.smoothing().map(|_| Slopes { slopes, trust: trust.values() });
        for in_cell in targets.chunk_by(|a, b| a.cell == b.cell) {
            let corners = &table.corners[in_cell[0].cell as usize];
            let map = PointMap::new(corners, lattice, slopes);
            for target in in_cell {
                let local = embedding.local(target.point as usize);
                let present = map.at(local);
                let weights = trilinear_weights(local).map(|weight| weight / in_cell.len() as f32);
                let displacement = std::array::from_fn(|k| target.position[k] - present[k]);
                least_squares.add(corners, &weights, displacement);
            }
        }
    }
}

/// Returns the center and half the size of the box around the corners of a cell. [`REACH`] is a margin for mesh vertices
/// that a smooth skin moves out of it.
fn bounds(corners: &[u32; 8], lattice: &[Xyzx]) -> (Point3<f64>, Vector3<f64>) {
    let corners = corners.map(|corner| {
        let [x, y, z, _] = lattice[corner as usize].map(f64::from);
        Vector3::new(x, y, z)
    });
    let (mut low, mut high) = (corners[0], corners[0]);
    for corner in &corners[1..] {
        (low, high) = (low.inf(corner), high.sup(corner));
    }
    (Point3::from((low + high) / 2.0), (high - low) / 2.0)
}

/// Returns the compression of a deformed frame along the normal of a collider, and the cosine between the normal of the surface and
/// the opposite of the collider's.
///
/// The frame F has the derivatives of the positions as columns. The stretch along the unit vector n is 1/|F⁻¹ n|, which is
/// det F / |cof Fᵀ n|, and a surface with the normal m at rest has the direction cof F m.
fn compression(frame: &[Vector3<f32>; 3], at_rest: &[f32; 3], normal: &Vector3<f64>) -> (f64, f64) {
    let [x, y, z] = frame.map(|axis| axis.map(f64::from));
    let faces = [y.cross(&z), z.cross(&x), x.cross(&y)];
    let spread = Vector3::from(faces.each_ref().map(|face| face.dot(normal))).norm();
    let outward: Vector3<f64> =
        faces.iter().zip(at_rest).map(|(face, &component)| face * f64::from(component)).sum();
    let length = outward.norm();
    if !(spread > 0.0 && length > 0.0) {
        return (0.0, 0.0);
    }
    (1.0 - (x.dot(&faces[0]) / spread).max(0.0), -outward.dot(normal) / length)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn compression_of_a_turned_and_squeezed_frame() {
        let (sin, cos) = 0.6_f32.sin_cos();
        // Squeezed to 0.7 along y, then turned about z.
        let frame =
            [Vector3::new(cos, sin, 0.0), Vector3::new(-sin, cos, 0.0) * 0.7, Vector3::new(0.0, 0.0, 1.2)];
        let normal = Vector3::new(-sin, cos, 0.0).map(f64::from);
        let (compression, cosine) = super::compression(&frame, &[0.0, -1.0, 0.0], &normal);
        assert!((compression - 0.3).abs() < 1e-6 && (cosine - 1.0).abs() < 1e-6, "{compression} {cosine}");
        let flat = [frame[0], Vector3::zeros(), frame[2]];
        let (compression, _) = super::compression(&flat, &[0.0, -1.0, 0.0], &normal);
        assert_eq!(compression, 1.0);
        assert_eq!(super::compression(&[Vector3::zeros(); 3], &[0.0, -1.0, 0.0], &normal), (0.0, 0.0));
    }
}
