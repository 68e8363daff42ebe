//! Transforms the normals of an OBJ file (`vn` lines) as the surface deforms.
//!
//! A `vn` generally differs from the normal computed from the faces, for example at hard edges, on smoothed
//! bevels, or if normals are baked. To keep the difference, each face corner transforms its `vn` with the
//! deformation of the face at this corner. Let `e1` and `e2` be the edges from the corner to the next and to
//! the previous corner of the face, and `m = e1 × e2`. A prime marks values on the deformed surface, and `.`
//! is the dot product. The normal `n` becomes
//!
//! ```text
//! n' = (n . m/|m|) m'/|m'| / s  +  (n . e1) d1  +  (n . e2) d2        s = sqrt(|m'| / |m|)
//! ```
//!
//! up to its length. `d1` and `d2` are the dual basis of `e1'` and `e2'` in their plane: `d1 . e1'` and
//! `d2 . e2'` are 1, `d1 . e2'` and `d2 . e1'` are 0. This is the usual transformation of normals, the
//! inverse transpose of the local deformation gradient. The stretch along the face normal is unknown; it is
//! set to `s`, the mean stretch within the face. Rigid motions and uniform scales transform every normal
//! exactly. A face normal remains the face normal under any deformation.
//!
//! If several corners share a `vn`, it becomes the mean of their unit normals, normalized.

mod corner;

use std::ops::Range;

use nalgebra::Vector3;

use corner::Corner;

use crate::obj::{Document, Part};
use supple::mesh::Mesh;

type Vec3 = Vector3<f64>;

/// Smallest sine of the angle between `e1` and `e2` of a corner. Below it, the corner uses `e1` and `e2` of
/// the corner of the same face with the largest `|m|`.
const MIN_SINE: f64 = 1e-3;

/// The `vn` that the faces of a [`Part`] use, and the corners that transform them.
#[derive(Debug)]
pub(super) struct NormalTransform {
    /// The corners that use `vn` number `k` are `corners[offsets[k]..offsets[k + 1]]`.
    offsets: Vec<u32>,
    corners: Vec<Corner>,
    /// Vectors of the `vn` in the input, one per `vn`.
    input: Vec<[f32; 3]>,
    /// Positions in the input, one per mesh vertex.
    rest: Vec<[f32; 3]>,
}

impl NormalTransform {
    pub(super) fn new(document: &Document, part: &Part) -> Self {
        let normals = part.faces().map(|face| document.face_normals(face));
        Self::of_faces(document.normals().to_vec(), part.mesh(), part.mesh().faces().zip(normals))
    }

    /// As [`NormalTransform::new`], for `faces` with the vertices of `mesh`, each with the `vn` of its corners if it
    /// has any. `input`: the vectors of the `vn`.
    pub(super) fn of_faces<'a>(
        input: Vec<[f32; 3]>,
        mesh: &Mesh,
        faces: impl Iterator<Item = (&'a [u32], Option<&'a [u32]>)>,
    ) -> Self {
        let mut found = Vec::new();
        for (face, normals) in faces {
            let Some(normals) = normals else { continue };
            let position = |corner: usize| mesh.vertices()[face[corner] as usize];
            // The vertex of a corner and its two neighbors, as corners of the face; then `e1`, `e2` and `m`.
            let edges = |corner: usize| {
                let triple = [corner, (corner + 1) % face.len(), (corner + face.len() - 1) % face.len()];
                let [e1, e2] = [1, 2].map(|other| position(triple[other]) - position(corner));
                (triple, e1, e2, e1.cross(&e2))
            };
            let widest =
                (0..face.len()).map(edges).max_by(|a, b| a.3.norm_squared().total_cmp(&b.3.norm_squared()));
            for (corner, &normal) in normals.iter().enumerate() {
                let this = edges(corner);
                let is_thin = this.3.norm() <= MIN_SINE * this.1.norm() * this.2.norm();
                let (triple, e1, e2, m) = widest.filter(|_| is_thin).unwrap_or(this);
                let area = m.norm();
                if area == 0.0 {
                    continue;
                }
                let n = Vec3::from(input[normal as usize].map(f64::from));
                let covariant = [n.dot(&m) / area, n.dot(&e1), n.dot(&e2)].map(|number| number as f32);
                let vertices = triple.map(|corner| face[corner]);
                found.push((normal, Corner { vertices, covariant, root_area: area.sqrt() as f32 }));
            }
        }
        // The sort is stable, so the corners of a `vn` keep the order of the faces.
        found.sort_by_key(|&(normal, _)| normal);
        let first_of = |normal: usize| found.partition_point(|&(other, _)| (other as usize) < normal) as u32;
        Self {
            offsets: (0..=input.len()).map(first_of).collect(),
            corners: found.into_iter().map(|(_, corner)| corner).collect(),
            rest: mesh.vertices().iter().map(|vertex| vertex.cast::<f32>().into()).collect(),
            input,
        }
    }

    /// Returns the number of `vn` in the file.
    pub(super) fn len(&self) -> usize {
        self.input.len()
    }

    /// Returns whether a corner of the part uses `vn` number `normal`, counted from 0. Frames keep the lines
    /// of unused `vn` unchanged.
    #[inline]
    pub(super) fn is_used(&self, normal: usize) -> bool {
        self.offsets[normal] < self.offsets[normal + 1]
    }

    /// Computes the `vn` in the range `indices`, counted from 0, for mesh vertices at `positions`. Overwrites
    /// `directions` with one unit vector per `vn`. A `vn` whose corners have not moved, or whose faces have
    /// collapsed, keeps its input vector exactly. `corners` is scratch.
    pub(super) fn transform(
        &self,
        indices: Range<usize>,
        positions: &[[f32; 3]],
        corners: &mut Vec<[f32; 3]>,
        directions: &mut Vec<[f32; 3]>,
    ) {
        let first = self.offsets[indices.start] as usize;
        let used = &self.corners[first..self.offsets[indices.end] as usize];
        corners.resize(used.len(), [0.0; 3]);
        corner::transform(used, positions, corners);
        directions.clear();
        directions.extend(indices.map(|normal| {
            let input = self.input[normal];
            let mut sum = [0.0_f32; 3];
            let mut moved = false;
            for k in self.offsets[normal] as usize..self.offsets[normal + 1] as usize {
                let [now, rest] = [positions, &self.rest]
                    .map(|points| self.corners[k].vertices.map(|vertex| &points[vertex as usize]));
                let direction = if now == rest { unit(input) } else { corners[k - first] };
                moved |= now != rest;
                sum = std::array::from_fn(|axis| sum[axis] + direction[axis]);
            }
            let mean = unit(sum);
            if moved && mean != [0.0; 3] { mean } else { input }
        }));
    }
}

/// Counts the `vn` of a file that are shared by corners of `part` at different positions. The normals of such
/// corners differ once the surface bends; frames contain their mean.
pub fn count_shared_normals(document: &Document, part: &Part) -> usize {
    const UNUSED: u32 = u32::MAX;
    let mesh = part.mesh();
    // For each `vn`, the vertex of the last corner that used it.
    let mut vertex = vec![UNUSED; document.normal_count()];
    let mut shared = vec![false; vertex.len()];
    for (face, file_face) in mesh.faces().zip(part.faces()) {
        for (&corner, &normal) in face.iter().zip(document.face_normals(file_face).unwrap_or_default()) {
            let (normal, welded) = (normal as usize, mesh.weld()[corner as usize]);
            shared[normal] |= vertex[normal] != UNUSED && vertex[normal] != welded;
            vertex[normal] = welded;
        }
    }
    shared.into_iter().filter(|&shared| shared).count()
}

/// Returns `vector` normalized, or zero if its length is zero.
#[inline]
fn unit(vector: [f32; 3]) -> [f32; 3] {
    let length_squared = vector[0] * vector[0] + vector[1] * vector[1] + vector[2] * vector[2];
    if length_squared >= f32::MIN_POSITIVE {
        let inverse = 1.0 / length_squared.sqrt();
        return vector.map(|component| component * inverse);
    }
    // The squared length underflows in f32, although the vector does not.
    let wide = vector.map(f64::from);
    let length = (wide[0] * wide[0] + wide[1] * wide[1] + wide[2] * wide[2]).sqrt();
    if length > 0.0 { wide.map(|component| (component / length) as f32) } else { [0.0; 3] }
}
