//! Scales the document of a model along its axes, for frames of a body that is scaled so.

use std::collections::HashSet;

use nalgebra::Vector3;
use supple::Scale;

use super::lines::{Statements, Words};
use super::{Document, ObjError, Part};

impl Document {
    /// Returns the document with scaled positions and normals. If the scale mirrors the model, the corners of the faces of
    /// `part` are in reverse order after the first, as in [`Mesh::scaled`](supple::Mesh::scaled), in the bytes also.
    ///
    /// The numbers of `v` and `vn` statements are not changed in the bytes, because frames replace them.
    ///
    /// # Errors
    /// As [`Document::from_bytes`].
    pub(crate) fn scaled(&self, part: &Part, scale: Scale) -> Result<Self, ObjError> {
        let mut raw = self.bytes().to_vec();
        if scale.is_mirror() {
            reverse_faces(&mut raw, &part.faces().collect());
        }
        let mut document = self.with_bytes(raw)?;
        let parsed = document.parsed_mut();
        for position in &mut parsed.positions {
            *position = scale.apply(&(*position).into()).into();
        }
        for direction in &mut parsed.directions {
            let normal = scale.apply_to_normal(&Vector3::from(direction.map(f64::from)));
            *direction = normal.try_normalize(0.0).unwrap_or(normal).map(|x| x as f32).into();
        }
        Ok(document)
    }
}

/// Reverses the order of the corners after the first in the statements of some faces. The length of each statement, and
/// so the place of all others, stays.
fn reverse_faces(raw: &mut Vec<u8>, faces: &HashSet<u32>) {
    let mut reversed = Vec::with_capacity(raw.len());
    let mut face = 0;
    for statement in Statements::new(raw) {
        let mut words = Words::new(raw, &statement.bytes);
        let is_face = words.next().is_some_and(|keyword| matches!(&raw[keyword], b"f" | b"fo"));
        let corners: Vec<_> = if is_face { words.collect() } else { Vec::new() };
        // Faces with fewer corners are not counted in a document.
        if corners.len() < 3 {
            continue;
        }
        face += 1;
        if !faces.contains(&(face - 1)) {
            continue;
        }
        let order = std::iter::once(0).chain((1..corners.len()).rev());
        let mut read = reversed.len();
        for (place, corner) in corners.iter().zip(order) {
            reversed.extend_from_slice(&raw[read..place.start]);
            reversed.extend_from_slice(&raw[corners[corner].clone()]);
            read = place.end;
        }
        debug_assert_eq!(reversed.len(), read, "the statement has the same words");
    }
    reversed.extend_from_slice(&raw[reversed.len()..]);
    *raw = reversed;
}
