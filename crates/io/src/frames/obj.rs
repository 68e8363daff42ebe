//! Writes OBJ frames of a mesh that was read from a file: the bytes of the file, with new positions and
//! normals. After a break, also with the changes of [`PieceChanges`].
//!
//! The file is divided once into pieces: byte ranges, each with the statements in it that change (`v`, `vn`
//! and `mtllib`). For each frame, several threads fill the pieces with changes, and then all pieces are
//! written in order. A long byte range without changes is a piece that is written directly from the input.

use std::ops::Range;
use std::path::Path;
use std::sync::{Arc, OnceLock};

use super::normal_transform::NormalTransform;
use super::obj_pieces::{FaceFile, NewElements, PieceChanges, Replacements};
use super::pieces::Pieces;
use super::{Source, library_path, number};
use crate::obj::{Document, Part};
use supple::Executor;

/// Largest number of changes in a piece. Filling a piece of this size takes much longer than starting a task
/// or a write call.
const MAX_CHANGES: usize = 4096;

/// Largest number of consecutive unchanged bytes in a piece with changes. A longer unchanged range becomes a
/// separate piece.
const MAX_UNCHANGED: usize = 1 << 16;

/// Returns the size of a frame, in bytes; approximately, because the numbers differ in length.
pub(super) fn frame_bytes(source: &Source<'_>) -> u64 {
    match source {
        Source::Mesh(mesh) => {
            // Per vertex: `v`, a line end, and three numbers of nine digits, each with a point and a blank. Per corner:
            // an index and a blank. Per face: `f` and a line end.
            let corners: usize = mesh.faces().map(<[u32]>::len).sum();
            let digits = mesh.vertices().len().checked_ilog10().unwrap_or(0) as usize + 2;
            (34 * mesh.vertices().len() + digits * corners + 2 * mesh.face_count()) as u64
        }
        Source::Document(document, _) => document.bytes().len() as u64,
    }
}

/// An OBJ file divided into pieces, from which every frame is written.
#[derive(Debug)]
pub(super) struct ObjTemplate {
    shared: Shared,
    pieces: Vec<Piece>,
    executor: Executor,
    /// The faces of the file, read when the body breaks.
    file: OnceLock<FaceFile>,
}

/// Data that is needed to fill any piece.
#[derive(Debug)]
struct Shared {
    document: Arc<Document>,
    /// All changes, in the order of the file.
    changes: Vec<Change>,
    normals: NormalTransform,
    /// Byte ranges that are the same in all frames, such as the paths of material libraries, and their replacements.
    replaced: Replacements,
    /// New lines of the pieces of a broken body.
    elements: Option<NewElements>,
}

/// A change of one statement. All indices count from 0.
#[derive(Clone, Copy, Debug)]
enum Change {
    /// The numbers of `v` statement `v` become the position of mesh vertex `vertex`.
    Vertex { v: u32, vertex: u32 },
    /// The numbers of `vn` statement `vn` become a new direction.
    Normal { vn: u32 },
    /// The range at entry `index` of [`Shared::replaced`] is replaced.
    Replaced { index: u32 },
    /// The lines of [`Shared::elements`] are inserted.
    Elements,
}

/// A byte range of the file and the changes in it.
#[derive(Debug)]
struct Piece {
    /// Byte range of the file.
    raw: Range<usize>,
    /// Range in [`Shared::changes`].
    changes: Range<usize>,
    /// Range of `vn`, from the first to the last that changes in this piece.
    normals: Range<usize>,
    /// Direction of each `vn` in `normals` in the current frame.
    directions: Vec<[f32; 3]>,
    /// Scratch: normals of face corners.
    corners: Vec<[f32; 3]>,
    /// Bytes of the piece in the current frame; unused if the piece has no changes.
    text: Vec<u8>,
}

impl ObjTemplate {
    /// Divides a file into pieces, for frames of the body `name` in `directory`, which must exist.
    pub(super) fn new(document: &Arc<Document>, part: &Part, directory: &Path, name: &str) -> Self {
        let normals = NormalTransform::new(document, part);
        Self::with(document, part, directory, normals, (library_line(document, name), None))
    }

    /// Returns the template of the pieces of the body `name`, which has the part `part` of the file of this template.
    pub(super) fn of_pieces(&self, part: &Part, directory: &Path, pieces: &Pieces<'_>, name: &str) -> Self {
        let document = &self.shared.document;
        let file = self.file.get_or_init(|| FaceFile::new(document));
        let PieceChanges { replaced, elements, normals } =
            PieceChanges::new((document, part), file, pieces, name);
        let replaced = library_line(document, name).into_iter().chain(replaced).collect();
        let mut template = Self::with(document, part, directory, normals, (replaced, Some(elements)));
        template.executor = self.executor.clone();
        template
    }

    /// Divides a file that changes into pieces. `file`: the contents of `document`. `pieces`: the mesh in place of that of
    /// `part`, and the name of its body.
    pub(super) fn changed(
        (document, part): (&Arc<Document>, &Part),
        directory: &Path,
        file: &FaceFile,
        (pieces, name): (&Pieces<'_>, &str),
    ) -> Self {
        let PieceChanges { replaced, elements, normals } =
            PieceChanges::new((document, part), file, pieces, name);
        Self::with(document, part, directory, normals, (replaced, Some(elements)))
    }

    fn with(
        document: &Arc<Document>,
        part: &Part,
        directory: &Path,
        normals: NormalTransform,
        (replaced, elements): (Replacements, Option<NewElements>),
    ) -> Self {
        let rewritten = |library: crate::obj::Library| {
            Some((library.bytes.clone(), library_path::rewritten(&library, document.directory(), directory)?))
        };
        let libraries = document.libraries().into_iter().filter_map(rewritten);
        let mut shared = Shared {
            changes: Vec::new(),
            normals,
            replaced: libraries.chain(replaced).collect(),
            elements,
            document: document.clone(),
        };
        let vertices = (0..).zip(part.vertices()).map(|(vertex, v)| Change::Vertex { v, vertex });
        let normals = (0..document.normal_count() as u32).map(|vn| Change::Normal { vn });
        let replaced = (0..shared.replaced.len() as u32).map(|index| Change::Replaced { index });
        let used = normals.filter(|change| shared.is_used(change));
        let elements = shared.elements.iter().map(|_| Change::Elements);
        let mut changes: Vec<_> = elements.chain(vertices).chain(used).chain(replaced).collect();
        // The sort is stable: the new lines precede a change at the same offset.
        changes.sort_by_key(|change| shared.span(change).start);
        shared.changes = changes;
        Self { pieces: shared.divide(), shared, executor: Executor::sequential(), file: OnceLock::new() }
    }

    /// Sets the threads that fill the pieces.
    pub(super) fn set_executor(&mut self, executor: &Executor) {
        self.executor = executor.clone();
    }

    /// Fills the pieces for mesh vertices at `positions`.
    pub(super) fn fill(&mut self, positions: &[[f32; 3]]) {
        let Self { shared, pieces, executor, .. } = self;
        if shared.changes.len() <= MAX_CHANGES {
            // Filling so few changes takes less time than waking another thread.
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

/// Returns the line, at the start of a file, that names the library which is written beside the frames of the body `name`.
fn library_line(document: &Document, name: &str) -> Replacements {
    let library = library_path::own_library(document, name);
    library.map(|library| (0..0, format!("mtllib {library}\n").into_bytes())).into_iter().collect()
}

impl Shared {
    /// Returns false for a `vn` that no corner uses.
    fn is_used(&self, change: &Change) -> bool {
        match *change {
            Change::Normal { vn } => self.normals.is_used(vn as usize),
            _ => true,
        }
    }

    /// Returns the byte range of a change: from its first to its third number, or the replaced range.
    fn span(&self, change: &Change) -> Range<usize> {
        match *change {
            Change::Vertex { v, .. } => self.document.vertex_numbers()[v as usize].span(),
            Change::Normal { vn } => self.document.normal_numbers()[vn as usize].span(),
            Change::Replaced { index } => self.replaced[index as usize].0.clone(),
            Change::Elements => {
                let at = self.elements.as_ref().map_or(0, |elements| elements.at);
                at..at
            }
        }
    }

    /// Divides the file into pieces.
    fn divide(&self) -> Vec<Piece> {
        let mut pieces: Vec<Piece> = Vec::new();
        let mut end = 0;
        // Whether the last piece takes no more changes.
        let mut is_separate = false;
        for (index, change) in self.changes.iter().enumerate() {
            let span = self.span(change);
            let is_far = span.start - end > MAX_UNCHANGED;
            if is_far {
                pieces.push(Piece::new(end..span.start, index..index));
                end = span.start;
            }
            if matches!(change, Change::Elements) {
                // A piece of its own, so that its `vn` are one range.
                let mut piece = Piece::new(end..span.end, index..index + 1);
                piece.normals = self.document.normal_count()..self.normals.len();
                pieces.push(piece);
                is_separate = true;
                end = span.end;
                continue;
            }
            let is_far = is_far || std::mem::take(&mut is_separate);
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
        let Piece { raw: range, changes, normals, directions, corners, text } = piece;
        let raw = self.document.bytes();
        self.normals.transform(normals.clone(), positions, corners, directions);
        // End of the bytes of the file that `text` contains, with changes, so far.
        let mut copied = range.start;
        text.clear();
        for change in &self.changes[changes.clone()] {
            let (numbers, values) = match *change {
                Change::Vertex { v, vertex } => {
                    (&self.document.vertex_numbers()[v as usize], positions[vertex as usize])
                }
                Change::Normal { vn } => {
                    (&self.document.normal_numbers()[vn as usize], directions[vn as usize - normals.start])
                }
                Change::Replaced { index } => {
                    let (old, new) = &self.replaced[index as usize];
                    text.extend_from_slice(&raw[copied..old.start]);
                    text.extend_from_slice(new);
                    copied = old.end;
                    continue;
                }
                Change::Elements => {
                    if let Some(elements) = &self.elements {
                        text.extend_from_slice(&raw[copied..elements.at]);
                        elements.fill(text, positions, directions);
                        copied = elements.at;
                    }
                    continue;
                }
            };
            // The bytes between the numbers are copied unchanged.
            for (number, value) in numbers.ranges().into_iter().zip(values) {
                append_bytes(text, &raw[copied..number.start]);
                number::append(text, value);
                copied = number.end;
            }
        }
        if changes.start < changes.end {
            text.extend_from_slice(&raw[copied..range.end]);
        }
    }
}

impl Piece {
    fn new(raw: Range<usize>, changes: Range<usize>) -> Self {
        Self { raw, changes, normals: 0..0, directions: Vec::new(), corners: Vec::new(), text: Vec::new() }
    }
}

/// Appends bytes to `text`. A single byte, the usual blank between two numbers, has a fast path.
#[inline]
fn append_bytes(text: &mut Vec<u8>, bytes: &[u8]) {
    match *bytes {
        [byte] => text.push(byte),
        _ => text.extend_from_slice(bytes),
    }
}
