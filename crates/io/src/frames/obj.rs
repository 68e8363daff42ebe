//! OBJ frames of a mesh that was read from a file: the file again, with new positions and normals.
//!
//! The text is cut into pieces once; a frame fills those that change, each by itself and so on any thread, and writes
//! one after another. Long stretches that never change are pieces of their own, written from the input as they are.

use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use super::turned_normals::TurnedNormals;
use super::{library_path, number};
use crate::obj::{Document, Part};
use supple::Executor;

/// Statements that change in a piece: enough that a thread has something to do, and that a write is worth its call.
const CHANGES: usize = 4096;

/// Bytes that stay as they are and are more than this are no part of a piece that changes.
const STRETCH: usize = 1 << 16;

/// A file that is written again and again, cut into pieces.
#[derive(Debug)]
pub(super) struct ObjTemplate {
    shared: Shared,
    pieces: Vec<Piece>,
    executor: Executor,
}

/// What all pieces look at.
#[derive(Debug)]
struct Shared {
    document: Arc<Document>,
    /// What changes, in the order of the file.
    changes: Vec<Change>,
    normals: TurnedNormals,
    /// The names of material libraries that change, and what they change to.
    libraries: Vec<(Range<usize>, Vec<u8>)>,
}

/// A statement that changes.
#[derive(Clone, Copy, Debug)]
enum Change {
    /// Number `v` of the file is number `vertex` of the mesh.
    Vertex { v: u32, vertex: u32 },
    /// Number `vn` of the file.
    Normal { vn: u32 },
    /// One of the libraries.
    Library { index: u32 },
}

/// Bytes of the file, and what changes in them.
#[derive(Debug)]
struct Piece {
    raw: Range<usize>,
    changes: Range<usize>,
    /// The `vn` among the changes, from the first to the last.
    normals: Range<usize>,
    /// What these are in a frame, and scratch for it.
    directions: Vec<[f32; 3]>,
    corners: Vec<[f32; 3]>,
    /// What the bytes are in a frame; not used where nothing changes.
    text: Vec<u8>,
}

impl ObjTemplate {
    /// A template for frames that lie in `directory`, which must exist.
    pub(super) fn new(document: &Arc<Document>, part: &Part, directory: &Path) -> Self {
        let rewritten = |library: crate::obj::Library| {
            Some((library.bytes.clone(), library_path::rewritten(&library, document.directory(), directory)?))
        };
        let mut shared = Shared {
            changes: Vec::new(),
            normals: TurnedNormals::new(document, part),
            libraries: document.libraries().into_iter().filter_map(rewritten).collect(),
            document: document.clone(),
        };
        let vertices =
            (0..).zip(part.vertices()).map(|(vertex, of_file)| Change::Vertex { v: of_file, vertex });
        let normals = (0..document.normal_count() as u32).map(|vn| Change::Normal { vn });
        let libraries = (0..shared.libraries.len() as u32).map(|index| Change::Library { index });
        let used = normals.filter(|change| shared.is_used(change));
        let mut changes: Vec<_> = vertices.chain(used).chain(libraries).collect();
        changes.sort_by_key(|change| shared.span(change).start);
        shared.changes = changes;
        Self { pieces: shared.cut(), shared, executor: Executor::sequential() }
    }

    /// Fills the pieces on these threads from now on.
    pub(super) fn share(&mut self, executor: &Executor) {
        self.executor = executor.clone();
    }

    /// Fills the pieces with the vertices of the mesh at `positions`.
    pub(super) fn fill(&mut self, positions: &[[f32; 3]]) {
        let Self { shared, pieces, executor } = self;
        if shared.changes.len() <= CHANGES {
            // To wake another thread takes longer.
            return pieces.iter_mut().for_each(|piece| shared.fill(piece, positions));
        }
        executor.share(pieces.iter_mut(), |piece| shared.fill(piece, positions));
    }

    /// The pieces of the frame, in order.
    pub(super) fn texts(&self) -> impl Iterator<Item = &[u8]> {
        let raw = self.shared.document.bytes();
        self.pieces.iter().map(|piece| match piece.changes.is_empty() {
            true => &raw[piece.raw.clone()],
            false => &piece.text[..],
        })
    }
}

impl Shared {
    fn is_used(&self, change: &Change) -> bool {
        match *change {
            Change::Normal { vn } => self.normals.is_used(vn as usize),
            _ => true,
        }
    }

    /// The bytes that a change replaces, and those between them.
    fn span(&self, change: &Change) -> Range<usize> {
        match *change {
            Change::Vertex { v, .. } => self.document.vertex_numbers()[v as usize].span(),
            Change::Normal { vn } => self.document.normal_numbers()[vn as usize].span(),
            Change::Library { index } => self.libraries[index as usize].0.clone(),
        }
    }

    fn cut(&self) -> Vec<Piece> {
        let mut pieces: Vec<Piece> = Vec::new();
        let mut end = 0;
        for (index, change) in self.changes.iter().enumerate() {
            let span = self.span(change);
            let is_far = span.start - end > STRETCH;
            if is_far {
                pieces.push(Piece::new(end..span.start, index..index));
                end = span.start;
            }
            match pieces.last_mut() {
                Some(piece) if !is_far && (1..CHANGES).contains(&piece.changes.len()) => {
                    piece.raw.end = span.end;
                    piece.changes.end = index + 1;
                }
                _ => pieces.push(Piece::new(end..span.end, index..index + 1)),
            }
            if let (Change::Normal { vn }, Some(piece)) = (*change, pieces.last_mut()) {
                let first = if piece.normals.is_empty() { vn as usize } else { piece.normals.start };
                piece.normals = first..vn as usize + 1;
            }
            end = span.end;
        }
        let none = self.changes.len();
        pieces.push(Piece::new(end..self.document.bytes().len(), none..none));
        pieces
    }

    fn fill(&self, piece: &mut Piece, positions: &[[f32; 3]]) {
        let Piece { raw: bytes, changes, normals, directions, corners, text } = piece;
        let raw = self.document.bytes();
        self.normals.turn(normals.clone(), positions, corners, directions);
        let mut copied = bytes.start;
        text.clear();
        for change in &self.changes[changes.clone()] {
            let (numbers, values) = match *change {
                Change::Vertex { v, vertex } => {
                    (&self.document.vertex_numbers()[v as usize], positions[vertex as usize])
                }
                Change::Normal { vn } => {
                    (&self.document.normal_numbers()[vn as usize], directions[vn as usize - normals.start])
                }
                Change::Library { index } => {
                    let (range, name) = &self.libraries[index as usize];
                    text.extend_from_slice(&raw[copied..range.start]);
                    text.extend_from_slice(name);
                    copied = range.end;
                    continue;
                }
            };
            // What separates the numbers is kept.
            for (range, value) in numbers.ranges().into_iter().zip(values) {
                push_short(text, &raw[copied..range.start]);
                number::push(text, value);
                copied = range.end;
            }
        }
        if changes.start < changes.end {
            text.extend_from_slice(&raw[copied..bytes.end]);
        }
    }
}

impl Piece {
    fn new(raw: Range<usize>, changes: Range<usize>) -> Self {
        Self { raw, changes, normals: 0..0, directions: Vec::new(), corners: Vec::new(), text: Vec::new() }
    }
}

/// Appends bytes that are one blank as a rule.
#[inline]
fn push_short(text: &mut Vec<u8>, bytes: &[u8]) {
    match *bytes {
        [byte] => text.push(byte),
        _ => text.extend_from_slice(bytes),
    }
}
