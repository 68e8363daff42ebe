//! The topology of the pieces of a body, as the frames of a stage contain it.

use supple::FaceSource;

use super::Source;
use super::normal_transform::NormalTransform;
use super::piece_normals::PieceNormals;
use super::pieces::{Pieces, on_face};
use crate::obj::Appearance;
use crate::usd::Topology;

/// The surface of the pieces of a body.
#[derive(Debug)]
pub(super) struct BrokenSurface {
    /// Identity of the pieces.
    pub(super) identity: u64,
    pub(super) topology: Topology,
    /// The computation of its normals, if it has any.
    pub(super) normals: Option<NormalTransform>,
}

impl BrokenSurface {
    /// `has_normals`: whether the surface of the whole body has normals.
    pub(super) fn new(pieces: &Pieces<'_>, has_normals: bool) -> Self {
        let mesh = pieces.mesh;
        let integer = |index: u32| index as i32;
        let source = |source: &FaceSource| match *source {
            FaceSource::Whole(face) | FaceSource::Part(face) => integer(face),
            FaceSource::Cap { .. } => -1,
        };
        let mut topology = Topology {
            counts: mesh.faces().map(|face| face.len() as i32).collect(),
            corners: mesh.faces().flatten().map(|&corner| integer(corner)).collect(),
            sources: pieces.origin.face_sources().iter().map(source).collect(),
            ..Topology::default()
        };
        topology.textures = textures(pieces);
        let mut transform = None;
        if let (Source::Document(document, part), true) = (pieces.source, has_normals) {
            let (normals, computed) = PieceNormals::new(document, part, pieces);
            let of_faces = (0..mesh.face_count()).filter_map(|face| normals.of_face(face));
            topology.normals = of_faces.flatten().map(|&normal| integer(normal)).collect();
            transform = Some(computed);
        }
        Self { identity: pieces.identity, topology, normals: transform }
    }
}

/// Returns the texture coordinates of all corners of the pieces. Caps have coordinates of their own; the others are zero
/// if the input has none.
fn textures(pieces: &Pieces<'_>) -> Vec<[f32; 2]> {
    let appearance = match pieces.source {
        Source::Document(document, part) => document.appearance(part),
        Source::Mesh(_) => Appearance::default(),
    };
    let mut first = 0;
    let mut whole: Vec<(usize, &[u32])> = Vec::new();
    for face in pieces.origin.whole().faces() {
        whole.push((first, face));
        first += face.len();
    }
    let mut uvs = pieces.cap_uvs();
    let mut textures = Vec::new();
    for (corners, source) in pieces.mesh.faces().zip(pieces.origin.face_sources()) {
        let (FaceSource::Whole(face) | FaceSource::Part(face)) = *source else {
            textures.extend(uvs.by_ref().take(corners.len()));
            continue;
        };
        if appearance.corners.is_empty() {
            textures.extend(corners.iter().map(|_| [0.0; 2]));
            continue;
        }
        let (first, face) = whole[face as usize];
        for &vertex in corners {
            let place = on_face(&pieces.origin.origins()[vertex as usize], vertex, face);
            textures.push(std::array::from_fn(|axis| {
                let number = |&(corner, weight): &(usize, f64)| {
                    let index = appearance.corners[first + corner] as usize;
                    weight * f64::from(appearance.coordinates[index][axis])
                };
                place.iter().map(number).sum::<f64>() as f32
            }));
        }
    }
    textures
}
