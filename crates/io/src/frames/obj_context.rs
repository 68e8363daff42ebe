//! Writes faces at the end of an OBJ file, with the objects, groups and materials that they belong to.

use supple::FaceSource;

use super::pieces::Pieces;
use crate::obj::{CONTEXT, FaceStatements};
use std::ops::Range;

/// The statements in force: `o`, `g`, `s` and `usemtl`.
type Lines = [Option<Vec<u8>>; 4];

/// Text after the end of a file.
pub(super) struct Tail<'a> {
    raw: &'a [u8],
    line_end: &'static str,
    text: Vec<u8>,
    current: Lines,
    /// The statements that end those in force, for faces that have none.
    ends: [Vec<u8>; 4],
}

impl<'a> Tail<'a> {
    /// `statements`: those of the file.
    pub(super) fn new(raw: &'a [u8], statements: &FaceStatements, line_end: &'static str) -> Self {
        let line = |range: &Range<usize>| raw[range.clone()].to_vec();
        let current = statements.last.each_ref().map(|range| range.as_ref().map(line));
        // Statements without a name are not valid. `default` is the name of a group in the format; programs that select
        // faces by a name do so in objects and groups.
        let mut name = "default".to_owned();
        let is_used = |name: &str| {
            let mut lines = statements.contexts.iter().flatten().flatten().map(|range| &raw[range.clone()]);
            lines
                .any(|line| line.split(|byte| byte.is_ascii_whitespace()).any(|word| word == name.as_bytes()))
        };
        while is_used(&name) {
            name.push('_');
        }
        let end = |keyword| match keyword {
            "s" => b"s off".to_vec(),
            _ => format!("{keyword} {name}").into_bytes(),
        };
        Self { raw, line_end, text: Vec::new(), current, ends: CONTEXT.map(end) }
    }

    /// Appends a face.
    pub(super) fn face(&mut self, context: &[Option<Range<usize>>; 4], text: &[u8]) {
        let lines = self.lines(context);
        self.append(lines, text);
    }

    /// Appends a cap: a face with a material of its own, which is not smooth.
    pub(super) fn cap(&mut self, context: &[Option<Range<usize>>; 4], material: &str, text: &[u8]) {
        let [object, group, smooth, _] = self.lines(context);
        let material = format!("usemtl {material}").into_bytes();
        let flat = smooth.is_some().then(|| b"s off".to_vec());
        self.append([object, group, flat, Some(material)], text);
    }

    /// Returns the text.
    pub(super) fn finish(self) -> Vec<u8> {
        self.text
    }

    fn lines(&self, context: &[Option<Range<usize>>; 4]) -> Lines {
        std::array::from_fn(|index| context[index].clone().map(|range| self.raw[range].to_vec()))
    }

    /// Appends the statements that differ from the current ones, and a face.
    fn append(&mut self, lines: Lines, text: &[u8]) {
        // Some readers reset the group and the material at a new object.
        let is_new = lines[0] != self.current[0];
        for index in 0..CONTEXT.len() {
            let is_off = lines[index].is_none() && self.current[index].is_none();
            if (is_new && !is_off) || lines[index] != self.current[index] {
                self.text.extend_from_slice(lines[index].as_deref().unwrap_or(&self.ends[index]));
                self.text.extend_from_slice(self.line_end.as_bytes());
            }
        }
        self.current = lines;
        self.text.extend_from_slice(text);
        self.text.extend_from_slice(self.line_end.as_bytes());
    }
}

/// Returns for each face of the pieces the context of the file that it belongs to. Caps belong to that of the faces
/// with which they share vertices. `in_file`: the index in the file of each face of the body.
pub(super) fn cap_contexts(pieces: &Pieces<'_>, statements: &FaceStatements, in_file: &[u32]) -> Vec<u32> {
    const UNKNOWN: u32 = u32::MAX;
    let faces = || pieces.mesh.faces().zip(pieces.origin.face_sources());
    let mut of_vertex = vec![UNKNOWN; pieces.mesh.vertices().len()];
    let mut of_face = vec![UNKNOWN; pieces.mesh.face_count()];
    for ((corners, source), context) in faces().zip(&mut of_face) {
        if let FaceSource::Whole(face) | FaceSource::Part(face) = *source {
            *context = statements.context_of[in_file[face as usize] as usize];
            corners.iter().for_each(|&corner| {
                let of_vertex = &mut of_vertex[corner as usize];
                *of_vertex = (*of_vertex).min(*context);
            });
        }
    }
    // From the rim of a cap inward.
    loop {
        let mut changed = false;
        for ((corners, _), context) in faces().zip(&mut of_face).filter(|(_, context)| **context == UNKNOWN) {
            let known = corners.iter().map(|&corner| of_vertex[corner as usize]).min().unwrap_or(UNKNOWN);
            if known != UNKNOWN {
                *context = known;
                for &corner in corners {
                    of_vertex[corner as usize] = of_vertex[corner as usize].min(known);
                }
                changed = true;
            }
        }
        if !changed {
            break;
        }
    }
    of_face.iter_mut().for_each(|context| *context = if *context == UNKNOWN { 0 } else { *context });
    of_face
}
