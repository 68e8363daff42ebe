//! The `vn` of an OBJ file, turned as the surface deforms.
//!
//! A `vn` is in general not the normal that follows from the faces: hard edges, smoothed bevels and baked normals
//! keep their difference from it. So each corner takes its input normal along. With `e1`, `e2` the edges from the
//! corner to its neighbours in the face, `m = e1 x e2`, and a prime for the deformed surface, the normal `n` goes to
//!
//! ```text
//! n' = (n . m/|m|) m'/|m'| / s  +  (n . e1) d1  +  (n . e2) d2        s = sqrt(|m'| / |m|)
//! ```
//!
//! with `d1`, `d2` the dual basis of `e1'`, `e2'` in the plane of the corner. That is the inverse transpose of the
//! local deformation gradient, which normals are transformed by, if the unknown stretch along the face's normal is
//! taken to be the mean stretch `s` within the face. A rigid motion or a uniform scale turns every normal exactly,
//! whatever it is; a face normal stays the face's normal under any deformation.
//!
//! A `vn` that several corners share gets the mean of their unit normals, at length 1.

mod corner;

use std::ops::Range;

use nalgebra::Vector3;

use corner::Corner;

use crate::obj::{Document, Part};

type Vec3 = Vector3<f64>;

/// A corner's own frame spans too small an angle below this sine; it borrows the one of a better corner of its face.
const THIN: f64 = 1e-3;

/// All `vn` that the faces of a part use.
#[derive(Debug)]
pub(super) struct TurnedNormals {
    /// Corners that use `vn` number `k`: `corners[offsets[k]..offsets[k + 1]]`.
    offsets: Vec<u32>,
    corners: Vec<Corner>,
    /// The numbers of the input: one per `vn`.
    input: Vec<[f32; 3]>,
    /// The positions of the input: one per vertex of the mesh.
    rest: Vec<[f32; 3]>,
}

impl TurnedNormals {
    pub(super) fn new(document: &Document, part: &Part) -> Self {
        let mesh = part.mesh();
        let input = document.normals().to_vec();
        let mut found = Vec::new();
        for (face, of_file) in mesh.faces().zip(part.faces()) {
            let Some(normals) = document.face_normals(of_file) else { continue };
            let position = |corner: usize| mesh.vertices()[face[corner] as usize];
            let frame = |corner: usize| {
                let triple = [corner, (corner + 1) % face.len(), (corner + face.len() - 1) % face.len()];
                let [e1, e2] = [1, 2].map(|other| position(triple[other]) - position(corner));
                (triple, e1, e2, e1.cross(&e2))
            };
            let widest =
                (0..face.len()).map(frame).max_by(|a, b| a.3.norm_squared().total_cmp(&b.3.norm_squared()));
            for (corner, &normal) in normals.iter().enumerate() {
                let own = frame(corner);
                let thin = own.3.norm() <= THIN * own.1.norm() * own.2.norm();
                let (triple, e1, e2, m) = widest.filter(|_| thin).unwrap_or(own);
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
        // Stable: the corners of a `vn` keep the order of the faces.
        found.sort_by_key(|&(normal, _)| normal);
        let first_of = |normal: usize| found.partition_point(|&(other, _)| (other as usize) < normal) as u32;
        Self {
            offsets: (0..=input.len()).map(first_of).collect(),
            corners: found.into_iter().map(|(_, corner)| corner).collect(),
            rest: mesh.vertices().iter().map(|vertex| vertex.cast::<f32>().into()).collect(),
            input,
        }
    }

    /// Whether a corner of the part uses `vn` number `normal`; its line is kept otherwise.
    #[inline]
    pub(super) fn is_used(&self, normal: usize) -> bool {
        self.offsets[normal] < self.offsets[normal + 1]
    }

    /// Writes the `vn` of `numbers` at `positions` (one per vertex of the mesh) to `directions`: unit vectors; the very
    /// numbers of the input where nothing around them has moved, or where their faces have collapsed. `corners` is
    /// scratch.
    pub(super) fn turn(
        &self,
        numbers: Range<usize>,
        positions: &[[f32; 3]],
        corners: &mut Vec<[f32; 3]>,
        directions: &mut Vec<[f32; 3]>,
    ) {
        let first = self.offsets[numbers.start] as usize;
        let own = &self.corners[first..self.offsets[numbers.end] as usize];
        corners.resize(own.len(), [0.0; 3]);
        corner::turn(own, positions, corners);
        directions.clear();
        directions.extend(numbers.map(|normal| {
            let input = self.input[normal];
            let mut sum = [0.0_f32; 3];
            let mut moved = false;
            for k in self.offsets[normal] as usize..self.offsets[normal + 1] as usize {
                let [here, there] = [positions, &self.rest]
                    .map(|places| self.corners[k].vertices.map(|vertex| &places[vertex as usize]));
                let turned = if here == there { unit(input) } else { corners[k - first] };
                moved |= here != there;
                sum = std::array::from_fn(|axis| sum[axis] + turned[axis]);
            }
            let mean = unit(sum);
            if moved && mean != [0.0; 3] { mean } else { input }
        }));
    }
}

/// How many `vn` of a file are shared by corners at different places, whose normals differ once the surface bends:
/// frames hold the mean of them.
pub fn shared_normals(document: &Document, part: &Part) -> usize {
    const NOWHERE: u32 = u32::MAX;
    let mesh = part.mesh();
    let mut place = vec![NOWHERE; document.normal_count()];
    let mut shared = vec![false; place.len()];
    for (face, of_file) in mesh.faces().zip(part.faces()) {
        for (&corner, &normal) in face.iter().zip(document.face_normals(of_file).unwrap_or_default()) {
            let (normal, here) = (normal as usize, mesh.weld()[corner as usize]);
            shared[normal] |= place[normal] != NOWHERE && place[normal] != here;
            place[normal] = here;
        }
    }
    shared.into_iter().filter(|&shared| shared).count()
}

/// `vector` at length 1; zero if it has none.
#[inline]
fn unit(vector: [f32; 3]) -> [f32; 3] {
    let squared = vector[0] * vector[0] + vector[1] * vector[1] + vector[2] * vector[2];
    if squared >= f32::MIN_POSITIVE {
        let inverse = 1.0 / squared.sqrt();
        return vector.map(|component| component * inverse);
    }
    // The square of a short vector is lost in f32 long before the vector is.
    let wide = vector.map(f64::from);
    let length = (wide[0] * wide[0] + wide[1] * wide[1] + wide[2] * wide[2]).sqrt();
    if length > 0.0 { wide.map(|component| (component / length) as f32) } else { [0.0; 3] }
}
