//! OBJ frames of a mesh that was read from a file: the bytes of the file, with new positions and normals.
//!
//! The file is divided into pieces once. For each frame the pieces that change are filled independently of
//! each other, on any thread, and all pieces are written in order. Long byte ranges that never change are
//! pieces of their own, written directly from the input.

use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use super::normal_transform::NormalTransform;
use super::{library_path, number};
use crate::obj::{Document, Part};
use supple::Executor;

/// Largest number of changes in a piece: enough to outweigh the cost of a task for a thread and of a write
/// call.
const MAX_CHANGES: usize = 4096;

/// Largest number of consecutive unchanged bytes in a piece that changes; a longer range becomes a piece of
/// its own.
const MAX_UNCHANGED: usize = 1 << 16;

/// Template of an OBJ file, divided into pieces, from which every frame is written.
#[derive(Debug)]
pub(super) struct ObjTemplate {
    shared: Shared,
    pieces: Vec<Piece>,
    executor: Executor,
}

/// Data that all pieces share.
#[derive(Debug)]
struct Shared {
    document: Arc<Document>,
    /// All changes, in the order of the file.
    changes: Vec<Change>,
    normals: NormalTransform,
    /// Byte ranges of the material library paths that change, and their replacements.
    libraries: Vec<(Range<usize>, Vec<u8>)>,
}

/// A change of one statement. All numbers count from 0.
#[derive(Clone, Copy, Debug)]
enum Change {
    /// `v` number `v` of the file gets the position of mesh vertex `vertex`.
    Vertex { v: u32, vertex: u32 },
    /// `vn` number `vn` of the file gets a new direction.
    Normal { vn: u32 },
    /// A path is replaced: entry `index` of [`Shared::libraries`].
    Library { index: u32 },
}

/// A byte range of the file and the changes in it.
#[derive(Debug)]
struct Piece {
    raw: Range<usize>,
    changes: Range<usize>,
    /// Numbers of the `vn` in this piece, from the first to the last that changes.
    normals: Range<usize>,
    /// Directions of these `vn` in the current frame.
    directions: Vec<[f32; 3]>,
    /// Scratch for the directions.
    corners: Vec<[f32; 3]>,
    /// Bytes of the piece in the current frame; unused if the piece has no changes.
    text: Vec<u8>,
}

impl ObjTemplate {
    /// Creates a template for frames in `directory`, which must exist.
    pub(super) fn new(document: &Arc<Document>, part: &Part, directory: &Path) -> Self {
        let rewritten = |library: crate::obj::Library| {
            Some((library.bytes.clone(), library_path::rewritten(&library, document.directory(), directory)?))
        };
        let mut shared = Shared {
            changes: Vec::new(),
            normals: NormalTransform::new(document, part),
            libraries: document.libraries().into_iter().filter_map(rewritten).collect(),
            document: document.clone(),
        };
        let vertices = (0..).zip(part.vertices()).map(|(vertex, v)| Change::Vertex { v, vertex });
        let normals = (0..document.normal_count() as u32).map(|vn| Change::Normal { vn });
        let libraries = (0..shared.libraries.len() as u32).map(|index| Change::Library { index });
        let used = normals.filter(|change| shared.is_used(change));
        let mut changes: Vec<_> = vertices.chain(used).chain(libraries).collect();
        changes.sort_by_key(|change| shared.span(change).start);
        shared.changes = changes;
        Self { pieces: shared.cut(), shared, executor: Executor::sequential() }
    }

    /// Sets the threads that fill the pieces.
    pub(super) fn set_executor(&mut self, executor: &Executor) {
        self.executor = executor.clone();
    }

    /// Fills the pieces for mesh vertices at `positions`.
    pub(super) fn fill(&mut self, positions: &[[f32; 3]]) {
        let Self { shared, pieces, executor } = self;
        if shared.changes.len() <= MAX_CHANGES {
            // Waking another thread takes longer than this.
            return pieces.iter_mut().for_each(|piece| shared.fill(piece, positions));
        }
        executor.for_each(pieces.iter_mut(), |piece| shared.fill(piece, positions));
    }

    /// Returns the bytes of the pieces of the frame, in order.
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

    /// Returns the byte range from the start of a change to its end, including the bytes between its numbers.
    fn span(&self, change: &Change) -> Range<usize> {
        match *change {
            Change::Vertex { v, .. } => self.document.vertex_numbers()[v as usize].span(),
            Change::Normal { vn } => self.document.normal_numbers()[vn as usize].span(),
            Change::Library { index } => self.libraries[index as usize].0.clone(),
        }
    }

    /// Divides the file into pieces.
    fn cut(&self) -> Vec<Piece> {
        let mut pieces: Vec<Piece> = Vec::new();
        let mut end = 0;
        for (index, change) in self.changes.iter().enumerate() {
            let span = self.span(change);
            let is_far = span.start - end > MAX_UNCHANGED;
            if is_far {
                pieces.push(Piece::new(end..span.start, index..index));
                end = span.start;
            }
            match pieces.last_mut() {
                Some(piece) if !is_far && (1..MAX_CHANGES).contains(&piece.changes.len()) => {
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
        let count = self.changes.len();
        pieces.push(Piece::new(end..self.document.bytes().len(), count..count));
        pieces
    }

    /// Fills one piece for mesh vertices at `positions`.
    fn fill(&self, piece: &mut Piece, positions: &[[f32; 3]]) {
        let Piece { raw: bytes, changes, normals, directions, corners, text } = piece;
        let raw = self.document.bytes();
        self.normals.transform(normals.clone(), positions, corners, directions);
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
            // The bytes between the numbers are copied unchanged.
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

/// Appends bytes, with a fast path for a single byte: the usual blank between numbers.
#[inline]
fn push_short(text: &mut Vec<u8>, bytes: &[u8]) {
    match *bytes {
        [byte] => text.push(byte),
        _ => text.extend_from_slice(bytes),
    }
}
