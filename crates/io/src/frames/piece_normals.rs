//! The `vn` of the faces of pieces.

use std::collections::HashMap;

use nalgebra::Vector3;
use supple::FaceSource;
use supple::mesh::Mesh;

use super::normal_transform::NormalTransform;
use super::pieces::{Pieces, on_face};
use crate::obj::{Document, Part};

/// The `vn` of the corners of all faces, from 0. New ones follow those of the file.
#[derive(Debug, Default)]
pub(super) struct PieceNormals {
    /// The `vn` of face `f` are `corners[starts[f]..starts[f + 1]]`; empty if it has none.
    starts: Vec<usize>,
    corners: Vec<u32>,
}

/// Marks an unused entry of a key.
const NONE: u32 = u32::MAX;

impl PieceNormals {
    /// Returns the `vn` of the faces, and the computation of all `vn` of the file and the new ones.
    ///
    /// A corner at a vertex of the file keeps its `vn`, unless another piece has it already: pieces turn differently.
    /// New points on the surface have interpolated normals at rest, and caps the normals of their faces.
    pub(super) fn new(document: &Document, part: &Part, pieces: &Pieces<'_>) -> (Self, NormalTransform) {
        let in_file: Vec<u32> = part.faces().collect();
        let has_normals = in_file.iter().any(|&face| document.face_normals(face).is_some());
        let (mesh, origin) = (pieces.mesh, pieces.origin);
        let piece_of = if has_normals { pieces.of_vertices() } else { Vec::new() };
        let mut vectors = document.normals().to_vec();
        // The piece to which each `vn` of the file belongs.
        let mut owners = vec![NONE; vectors.len()];
        let mut known: HashMap<(u32, [u32; 3]), u32> = HashMap::new();
        let whole: Vec<&[u32]> = origin.whole().faces().collect();
        let mut normals = Self { starts: vec![0], corners: Vec::new() };
        for (corners, source) in mesh.faces().zip(origin.face_sources()) {
            match *source {
                FaceSource::Cap { .. } if has_normals => {
                    normals.corners.extend(corners.iter().map(|_| vectors.len() as u32));
                    vectors.push(face_normal(mesh, corners));
                }
                FaceSource::Cap { .. } => {}
                FaceSource::Whole(face) | FaceSource::Part(face) => {
                    let Some(of_face) = document.face_normals(in_file[face as usize]) else {
                        normals.starts.push(normals.corners.len());
                        continue;
                    };
                    for &vertex in corners {
                        let place = on_face(&origin.origins()[vertex as usize], vertex, whole[face as usize]);
                        let used =
                            place.map(|(corner, weight)| if weight == 0.0 { NONE } else { of_face[corner] });
                        let piece = piece_of[vertex as usize];
                        let mut key = (vertex, used);
                        if let [only, NONE, NONE] = used {
                            let owner = &mut owners[only as usize];
                            if *owner == NONE || *owner == piece {
                                *owner = piece;
                                normals.corners.push(only);
                                continue;
                            }
                            key.0 = piece;
                        }
                        let next = vectors.len() as u32;
                        let index = *known.entry(key).or_insert(next);
                        if index == next {
                            let mut sum = Vector3::zeros();
                            let used = used.iter().zip(place).filter(|(normal, _)| **normal != NONE);
                            for (&normal, (_, weight)) in used {
                                sum += Vector3::from(vectors[normal as usize]).cast::<f64>() * weight;
                            }
                            // Opposite normals cancel each other.
                            let normal = sum.try_normalize(0.0).map(|sum| sum.cast::<f32>().into());
                            let vector = normal.unwrap_or_else(|| vectors[of_face[0] as usize]);
                            vectors.push(vector);
                        }
                        normals.corners.push(index);
                    }
                }
            }
            normals.starts.push(normals.corners.len());
        }
        let of_faces = mesh.faces().enumerate().map(|(face, corners)| (corners, normals.of_face(face)));
        let transform = NormalTransform::of_faces(vectors, mesh, of_faces);
        (normals, transform)
    }

    /// Returns the `vn` of the corners of a face; `None` if it has none.
    pub(super) fn of_face(&self, face: usize) -> Option<&[u32]> {
        let range = self.starts[face]..self.starts[face + 1];
        (!range.is_empty()).then(|| &self.corners[range])
    }
}

/// Returns the unit normal of a face; of a face without area, a vector of any direction.
fn face_normal(mesh: &Mesh, corners: &[u32]) -> [f32; 3] {
    let position = |corner: usize| mesh.vertices()[corners[corner] as usize];
    let fan = 2..corners.len();
    let area = fan
        .map(|corner| (position(corner - 1) - position(0)).cross(&(position(corner) - position(0))))
        .sum::<Vector3<f64>>();
    area.try_normalize(0.0).unwrap_or_else(Vector3::z).cast::<f32>().into()
}
