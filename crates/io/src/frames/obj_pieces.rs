//! The changes that turn an OBJ file into frames of the pieces of its body.
//!
//! New `v`, `vt` and `vn` lines follow the last ones of the file, so that the numbers of the file stay valid. The parts
//! of a cut face take the place of its line. A face that precedes new lines which it needs is moved to the end, because
//! some readers accept no reference to a later line. The caps come last.

use std::collections::HashMap;
use std::ops::Range;

use supple::{FaceSource, Origin};

use super::normal_transform::NormalTransform;
use super::number;
use super::obj_context::{Tail, cap_contexts};
use super::piece_normals::PieceNormals;
use super::pieces::{Blend, Pieces, on_face};
use crate::obj::{Document, FaceStatements, NO_TEXTURE, Part, cap_material};

/// Byte ranges of a file, and their new bytes.
pub(super) type Replacements = Vec<(Range<usize>, Vec<u8>)>;

/// The changes of a file besides those of its numbers.
#[derive(Debug)]
pub(super) struct PieceChanges {
    /// Byte ranges that change, and their new bytes, in the order of the file.
    pub(super) replaced: Replacements,
    pub(super) elements: NewElements,
    pub(super) normals: NormalTransform,
}

/// New `v`, `vt` and `vn` lines.
#[derive(Debug, Default)]
pub(super) struct NewElements {
    /// Offset of the lines in the file.
    pub(super) at: usize,
    /// Text before the lines: the line end that the file lacks.
    before: Vec<u8>,
    /// Index of the first vertex of the mesh with a new line.
    first_vertex: usize,
    /// For each new `v`, the text after its numbers, such as a color; empty if no `v` has any.
    suffixes: Vec<Vec<u8>>,
    /// The `vt` lines.
    textures: Vec<u8>,
    line_end: &'static str,
}

impl NewElements {
    /// Appends the lines to `text`, with the vectors of the new `vn`.
    pub(super) fn fill(&self, text: &mut Vec<u8>, positions: &[[f32; 3]], normals: &[[f32; 3]]) {
        text.extend_from_slice(&self.before);
        for (index, position) in positions[self.first_vertex..].iter().enumerate() {
            self.line(text, "v", position, self.suffixes.get(index).map_or(&[], Vec::as_slice));
        }
        text.extend_from_slice(&self.textures);
        normals.iter().for_each(|normal| self.line(text, "vn", normal, &[]));
    }

    fn line(&self, text: &mut Vec<u8>, keyword: &str, numbers: &[f32], suffix: &[u8]) {
        text.extend_from_slice(keyword.as_bytes());
        for &number in numbers {
            text.push(b' ');
            number::append(text, number);
        }
        text.extend_from_slice(suffix);
        text.extend_from_slice(self.line_end.as_bytes());
    }
}

/// The faces and the texture coordinates of a file, which are read at the first break.
#[derive(Debug)]
pub(super) struct FaceFile {
    statements: FaceStatements,
    /// Coordinates of the `vt`.
    textures: Vec<[f32; 2]>,
}

impl FaceFile {
    /// Reads a file.
    pub(super) fn new(document: &Document) -> Self {
        let mut textures = document.texture_coordinates();
        // The first entry belongs to corners without a `vt`.
        textures.remove(0);
        Self { statements: document.face_statements(), textures }
    }

    /// Reads a file whose new lines come at its end, so that each changed face is moved behind them.
    pub(super) fn with_elements_at_end(document: &Document) -> Self {
        let mut file = Self::new(document);
        file.statements.elements_end = document.bytes().len();
        file
    }
}

/// The faces of a file that have a new text, in the order of the file.
struct ReplacedFaces<'a> {
    statements: &'a FaceStatements,
    line_end: &'static str,
    replaced: Vec<(Range<usize>, Vec<u8>)>,
    /// What comes behind the last line.
    tail: Tail<'a>,
}

impl<'a> ReplacedFaces<'a> {
    fn new(raw: &'a [u8], statements: &'a FaceStatements, line_end: &'static str) -> Self {
        Self { statements, line_end, replaced: Vec::new(), tail: Tail::new(raw, statements, line_end) }
    }

    /// Replaces a face of the file by a text, after those that have replaced it before. A face before `elements`, the place
    /// of the new vertices, goes behind the last line.
    fn replace(&mut self, face: usize, text: Vec<u8>, elements: usize) {
        let statements = self.statements;
        let bytes = statements.bytes[face].clone();
        if bytes.start < elements {
            self.tail.face(&statements.contexts[statements.context_of[face] as usize], &text);
            let range = bytes.start..statements.next[face];
            if self.replaced.last().is_none_or(|(last, _)| *last != range) {
                self.replaced.push((range, Vec::new()));
            }
            return;
        }
        match self.replaced.last_mut() {
            Some((last, before)) if *last == bytes => {
                before.extend_from_slice(self.line_end.as_bytes());
                before.extend_from_slice(&text);
            }
            _ => self.replaced.push((bytes, text)),
        }
    }
}

impl PieceChanges {
    /// `file`: the contents of `document`. `name`: name of the body.
    pub(super) fn new(
        (document, part): (&Document, &Part),
        file: &FaceFile,
        pieces: &Pieces<'_>,
        name: &str,
    ) -> Self {
        let statements = &file.statements;
        let raw = document.bytes();
        let line_end = line_end(raw);
        let (normals, transform) = PieceNormals::new(document, part, pieces);
        let mut elements = NewElements {
            at: statements.elements_end,
            before: if statements.elements_end == raw.len() { ending(raw, line_end) } else { Vec::new() },
            first_vertex: part.mesh().vertices().len(),
            suffixes: suffixes(document, part, pieces),
            textures: Vec::new(),
            line_end,
        };
        let mut textures = Textures::new(file);
        let v_of: Vec<u32> = part.vertices().collect();
        let v = |vertex: u32| match v_of.get(vertex as usize) {
            Some(&v) => v as usize,
            None => document.vertex_count() + vertex as usize - v_of.len(),
        };
        let mut faces = ReplacedFaces::new(raw, statements, line_end);
        let mut caps = Vec::new();
        let mut uvs = pieces.cap_uvs();
        let in_file: Vec<u32> = part.faces().collect();
        let whole: Vec<&[u32]> = pieces.origin.whole().faces().collect();
        let cap_contexts = cap_contexts(pieces, statements, &in_file);
        for (index, (corners, source)) in pieces.mesh.faces().zip(pieces.origin.face_sources()).enumerate() {
            let normals = normals.of_face(index);
            let (face, text) = match *source {
                FaceSource::Cap { .. } => {
                    let first = textures.count;
                    for uv in uvs.by_ref().take(corners.len()) {
                        textures.push(uv, &mut elements);
                    }
                    let vt = |corner: usize| Some(first + corner);
                    caps.push((cap_contexts[index], face_text(corners, v, vt, normals)));
                    continue;
                }
                FaceSource::Whole(face)
                    if normals.is_none_or(|normals| {
                        document.face_normals(in_file[face as usize]) == Some(normals)
                    }) =>
                {
                    continue;
                }
                FaceSource::Whole(face) | FaceSource::Part(face) => {
                    let whole = whole[face as usize];
                    let file_face = in_file[face as usize];
                    let range = document.corners_of(file_face);
                    let of_file = &statements.textures[range];
                    let has_textures = !of_file.contains(&NO_TEXTURE);
                    let vt: Vec<usize> = corners
                        .iter()
                        .take_while(|_| has_textures)
                        .map(|&vertex| {
                            let origin = &pieces.origin.origins()[vertex as usize];
                            textures.at(vertex, &on_face(origin, vertex, whole), of_file, &mut elements)
                        })
                        .collect();
                    (file_face as usize, face_text(corners, v, |corner| vt.get(corner).copied(), normals))
                }
            };
            faces.replace(face, text, elements.at);
        }
        let ReplacedFaces { mut replaced, mut tail, .. } = faces;
        // Caps of one object follow each other.
        caps.sort_by_key(|&(context, _)| context);
        for (context, text) in caps {
            tail.cap(&statements.contexts[context as usize], &cap_material(name), &text);
        }
        let before = if elements.at == raw.len() { Vec::new() } else { ending(raw, line_end) };
        replaced.push((raw.len()..raw.len(), [before, tail.finish()].concat()));
        Self { replaced, elements, normals: transform }
    }
}

/// Returns the text of a face. All indices count from 0.
fn face_text(
    corners: &[u32],
    v: impl Fn(u32) -> usize,
    vt: impl Fn(usize) -> Option<usize>,
    vn: Option<&[u32]>,
) -> Vec<u8> {
    let mut text = "f".to_owned();
    for (corner, &vertex) in corners.iter().enumerate() {
        text += &format!(" {}", v(vertex) + 1);
        match (vt(corner), vn) {
            (Some(vt), Some(vn)) => text += &format!("/{}/{}", vt + 1, vn[corner] + 1),
            (Some(vt), None) => text += &format!("/{}", vt + 1),
            (None, Some(vn)) => text += &format!("//{}", vn[corner] + 1),
            (None, None) => {}
        }
    }
    text.into_bytes()
}

/// The `vt` of a file, and new ones.
struct Textures<'a> {
    /// Coordinates of the `vt` of the file.
    input: &'a [[f32; 2]],
    /// Number of `vt` so far.
    count: usize,
    /// New `vt` of vertices of the pieces, by the vertex and the `vt` between which it lies.
    known: HashMap<(u32, [u32; 3]), usize>,
}

impl<'a> Textures<'a> {
    fn new(file: &'a FaceFile) -> Self {
        Self { input: &file.textures, count: file.statements.texture_count, known: HashMap::new() }
    }

    /// Appends a `vt` and returns its index.
    fn push(&mut self, numbers: [f32; 2], elements: &mut NewElements) -> usize {
        let mut lines = std::mem::take(&mut elements.textures);
        elements.line(&mut lines, "vt", &numbers, &[]);
        elements.textures = lines;
        self.count += 1;
        self.count - 1
    }

    /// Returns the `vt` of a vertex at a place of a face with the `vt` `face`.
    fn at(&mut self, vertex: u32, place: &Blend, face: &[u32], elements: &mut NewElements) -> usize {
        let used = place.map(|(corner, weight)| if weight == 0.0 { NO_TEXTURE } else { face[corner] });
        if let [only, NO_TEXTURE, NO_TEXTURE] = used {
            return only as usize;
        }
        if let Some(&known) = self.known.get(&(vertex, used)) {
            return known;
        }
        let numbers = std::array::from_fn(|axis| {
            let number = |&(corner, weight): &(usize, f64)| match weight {
                0.0 => 0.0,
                _ => weight * f64::from(self.input[face[corner] as usize][axis]),
            };
            place.iter().map(number).sum::<f64>() as f32
        });
        let index = self.push(numbers, elements);
        self.known.insert((vertex, used), index);
        index
    }
}

/// Returns the line end of a file: that of its first line.
fn line_end(raw: &[u8]) -> &'static str {
    let end = raw.iter().position(|&byte| byte == b'\n' || byte == b'\r').map_or(&[][..], |at| &raw[at..]);
    match end {
        [b'\r', b'\n', ..] => "\r\n",
        [b'\r', ..] => "\r",
        _ => "\n",
    }
}

/// Returns the text that ends the last line of a file, so that another one can follow.
fn ending(raw: &[u8], line_end: &str) -> Vec<u8> {
    let mut text = Vec::new();
    if !raw.ends_with(b"\n") && !raw.ends_with(b"\r") {
        text.extend_from_slice(line_end.as_bytes());
    }
    if raw.trim_ascii_end().ends_with(b"\\") {
        // A comment ends a statement that the next line would continue.
        text.push(b'#');
        text.extend_from_slice(line_end.as_bytes());
    }
    text
}

/// Returns for each new vertex the text after the numbers of the nearest `v` of the file; empty if no `v` has any.
fn suffixes(document: &Document, part: &Part, pieces: &Pieces<'_>) -> Vec<Vec<u8>> {
    let suffixes: Vec<Vec<u8>> = part.vertices().map(|v| document.vertex_suffix(v)).collect();
    if suffixes.iter().all(Vec::is_empty) {
        return Vec::new();
    }
    let nearest = |origin: &Origin| match *origin {
        Origin::Vertex(vertex) => vertex,
        Origin::Edge { vertices, t } => vertices[usize::from(t > 0.5)],
        Origin::Face { vertices, weights } => {
            vertices[(0..3).max_by(|&a, &b| weights[a].total_cmp(&weights[b])).unwrap_or(0)]
        }
        Origin::Cap { .. } => 0,
    };
    let new = pieces.origin.origins()[suffixes.len()..].iter();
    new.map(|origin| suffixes[nearest(origin) as usize].clone()).collect()
}
