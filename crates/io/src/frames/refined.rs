//! The OBJ file of a refined mesh: the file of the model, with the new vertices and the parts of the divided faces at its
//! end.

use std::sync::Arc;

use supple::{Body, PieceMesh, RefinedMesh};

use super::Source;
use super::obj::ObjTemplate;
use super::obj_pieces::FaceFile;
use super::pieces::Pieces;
use crate::obj::{Document, ObjError, Part};

/// Returns the document of the refined mesh of a body, which has the same vertices and faces in the same order. New
/// corners have the interpolated texture coordinates and normals of their faces.
///
/// # Errors
/// As [`Document::from_bytes`].
pub(crate) fn refined(
    document: &Arc<Document>,
    part: &Part,
    (body, refined): (&Body, &RefinedMesh),
) -> Result<Document, ObjError> {
    let origin = PieceMesh::of_refined(part.mesh(), refined);
    let source = Source::Document(document, part);
    let pieces = Pieces::refined(body, source, (&refined.mesh, &origin));
    // Divided faces, which need the new vertices, are moved behind them in their order.
    let file = FaceFile::with_elements_at_end(document);
    let changes = (&pieces, body.name());
    let mut template = ObjTemplate::changed((document, part), document.directory(), &file, changes);
    let vertices = refined.mesh.vertices();
    let positions: Vec<[f32; 3]> = vertices.iter().map(|vertex| vertex.cast::<f32>().into()).collect();
    template.fill(&positions);
    let bytes = template.texts().collect::<Vec<_>>().concat();
    let mut refined = document.with_bytes(bytes)?;
    let part = refined.part(part.object())?;
    // The text has rounded numbers.
    refined.set_positions(part.vertices().zip(vertices));
    Ok(refined)
}
