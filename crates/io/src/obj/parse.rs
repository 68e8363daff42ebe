//! Parses an OBJ file in one pass into the surface, its groups, and the byte ranges of its numbers.

use std::ops::Range;

use super::corner::{self, Corner};
use super::error::{Located, ObjProblem};
use super::groups::{Group, GroupBuilder};
use super::lines::{Statement, Statements, Words, decode, line_of};
use super::numbers::{Numbers, three_numbers};
use crate::escape::Excerpt;

/// A keyword whose statements are ignored.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct IgnoredStatement {
    /// First word of the statements.
    pub keyword: String,
    /// Number of statements.
    pub count: usize,
    /// Line of the first statement, from 1.
    pub first_line: usize,
}

/// Marks a corner without a normal in [`Parsed::corner_normals`].
pub(super) const NO_NORMAL: u32 = u32::MAX;

/// Contents of a parsed file.
#[derive(Debug, Default)]
pub(super) struct Parsed {
    /// Byte ranges of the numbers, one entry per `v`.
    pub(super) vertices: Vec<Numbers>,
    /// Positions, one per `v`.
    pub(super) positions: Vec<[f64; 3]>,
    /// Byte ranges of the numbers, one entry per `vn`.
    pub(super) normals: Vec<Numbers>,
    /// Vectors, one per `vn`.
    pub(super) directions: Vec<[f32; 3]>,
    /// Number of `vt` statements.
    textures: usize,
    /// The corners of face `f`, three or more, are `corners[offsets[f]..offsets[f + 1]]`.
    pub(super) offsets: Vec<u32>,
    /// `v` index of each corner, from 0.
    pub(super) corners: Vec<u32>,
    /// `vn` index of each corner, from 0, up to the last face that has normals. If one corner of a face has
    /// no `vn`, all corners of the face have [`NO_NORMAL`].
    pub(super) corner_normals: Vec<u32>,
    /// Number of faces with fewer than three corners.
    pub(super) short_faces: usize,
    /// Line of the first face with fewer than three corners.
    pub(super) first_short_face: Option<usize>,
    /// Whether there is a `usemtl` statement.
    pub(super) has_materials: bool,
    /// Byte ranges of the text after `mtllib`, one per statement.
    pub(super) libraries: Vec<Range<usize>>,
    pub(super) groups: Vec<Group>,
    pub(super) ignored: Vec<IgnoredStatement>,
    /// Number of lines in the file.
    pub(super) lines: usize,
}

impl Parsed {
    pub(super) fn face_count(&self) -> usize {
        self.offsets.len() - 1
    }

    /// Returns the number of elements of a type so far.
    #[inline]
    fn count(&self, element: Element) -> usize {
        match element {
            Element::Vertex => self.vertices.len(),
            Element::Texture => self.textures,
            Element::Normal => self.normals.len(),
        }
    }
}

/// A corner that refers to an element below its line. It is valid if the element exists at the end of the
/// file.
struct ForwardReference {
    line: usize,
    face: usize,
    element: Element,
    index: i64,
}

/// A type of element that the corners of faces refer to.
#[derive(Clone, Copy)]
enum Element {
    Vertex,
    Texture,
    Normal,
}

impl Element {
    fn name(self) -> &'static str {
        match self {
            Self::Vertex => "vertex",
            Self::Texture => "texture coordinate",
            Self::Normal => "normal",
        }
    }
}

struct Parser<'a> {
    raw: &'a [u8],
    parsed: Parsed,
    groups: GroupBuilder<'a>,
    /// The forward references whose index is greater than those of all earlier ones to the same type of
    /// element. If any forward reference is invalid, the first one is in this list.
    forward: Vec<ForwardReference>,
    /// Greatest index of a forward reference to each type of element.
    greatest_forward: [i64; 3],
    /// `v` and `vn` indices of the corners of the current face, from 1; 0 means that the corner has no `vn`.
    face: Vec<[u32; 2]>,
}

/// Returns the line with another statement that a statement of names continues on, because its last name ends in `\`.
fn swallowed(statement: &[u8]) -> Option<&[u8]> {
    let mut lines = statement.split(|byte| matches!(byte, b'\n' | b'\r')).skip(1);
    lines.find(|line| {
        let mut words = line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
        let (keyword, argument) = (words.next(), words.next());
        match (keyword, argument) {
            (Some(b"usemtl" | b"mtllib"), Some(_)) => true,
            (Some(b"v" | b"vn" | b"vt" | b"f" | b"l" | b"p"), Some([first, ..])) => {
                first.is_ascii_digit() || matches!(first, b'-' | b'+' | b'.')
            }
            _ => false,
        }
    })
}

/// Parses a whole file.
pub(super) fn parse(raw: &[u8]) -> Result<Parsed, Located<ObjProblem>> {
    // Most files have no zero byte. `contains` is a fast test because it compares eight bytes at a time.
    if raw.contains(&0) {
        let at = raw.iter().take_while(|&&byte| byte != 0).count();
        if raw.starts_with(b"\xff\xfe") || raw.starts_with(b"\xfe\xff") {
            return Err((None, ObjProblem::Utf16));
        }
        let text = "it contains binary data (a zero byte on this line)".to_owned();
        return Err((Some(line_of(raw, at)), ObjProblem::NotObj(text)));
    }
    let parsed = Parsed { offsets: vec![0], ..Parsed::default() };
    let mut parser = Parser {
        raw,
        parsed,
        groups: GroupBuilder::default(),
        forward: Vec::new(),
        greatest_forward: [0; 3],
        face: Vec::new(),
    };
    let mut statements = Statements::new(raw);
    for statement in statements.by_ref() {
        parser.statement(&statement).map_err(|problem| parser.locate(statement.line, problem))?;
    }
    let lines = statements.lines();
    parser.finish(lines)
}

impl<'a> Parser<'a> {
    /// Parses one statement.
    fn statement(&mut self, statement: &Statement) -> Result<(), ObjProblem> {
        let raw = self.raw;
        let mut words = Words::new(raw, &statement.bytes);
        let Some(keyword) = words.next() else { return Ok(()) };
        if matches!(&raw[keyword.clone()], b"o" | b"g" | b"usemtl" | b"mtllib")
            && let Some(next) = swallowed(&raw[statement.bytes.clone()])
        {
            let (statement, next) = (decode(&raw[keyword]).into_owned(), decode(next).into_owned());
            return Err(ObjProblem::NameContinues { statement, next });
        }
        let faces = self.parsed.face_count() as u32;
        match &raw[keyword.clone()] {
            b"v" => {
                let (numbers, position) = three_numbers("v", raw, words)?;
                self.parsed.vertices.push(numbers);
                self.parsed.positions.push(position);
            }
            b"vn" => {
                let (numbers, direction) = three_numbers("vn", raw, words)?;
                self.parsed.normals.push(numbers);
                self.parsed.directions.push(direction.map(|x| x as f32));
            }
            b"vt" => self.parsed.textures += 1,
            b"f" | b"fo" => self.face(statement.line, words)?,
            b"o" => self.groups.start_object(decode(&raw[words.rest()]), faces),
            b"g" => {
                let text = decode(&raw[words.clone().rest()]);
                let names = words.map(|word| decode(&raw[word]));
                self.groups.start_groups(names, text, faces);
            }
            b"mtllib" => self.parsed.libraries.push(words.rest()),
            // Materials and smoothing groups change the appearance of faces, not their geometry.
            b"usemtl" => self.parsed.has_materials = true,
            b"s" => {}
            _ => self.ignore(&raw[keyword], statement.line),
        }
        Ok(())
    }

    /// Parses the corners of an `f` statement.
    fn face(&mut self, line: usize, words: Words<'_>) -> Result<(), ObjProblem> {
        let face = self.parsed.face_count() + self.parsed.short_faces + 1;
        self.face.clear();
        let mut with_normals = true;
        for word in words {
            let text = &self.raw[word];
            let Some(Corner { vertex, texture, normal }) = corner::parse(text) else {
                return Err(ObjProblem::Corner { face, text: decode(text).into_owned() });
            };
            let vertex = self.resolve(line, face, Element::Vertex, vertex)?;
            if let Some(texture) = texture {
                self.resolve(line, face, Element::Texture, texture)?;
            }
            let normal = match normal {
                Some(normal) => self.resolve(line, face, Element::Normal, normal)?,
                None => 0,
            };
            with_normals &= normal != 0;
            self.face.push([vertex, normal]);
        }
        let Parsed { offsets, corners, corner_normals, .. } = &mut self.parsed;
        if self.face.len() < 3 {
            self.parsed.short_faces += 1;
            self.parsed.first_short_face.get_or_insert(line);
            return Ok(());
        }
        if with_normals {
            corner_normals.resize(corners.len(), NO_NORMAL);
            corner_normals.extend(self.face.iter().map(|&[_, normal]| normal - 1));
        }
        corners.extend(self.face.iter().map(|&[vertex, _]| vertex - 1));
        offsets.push(corners.len() as u32);
        Ok(())
    }

    /// Converts an index as written in the file to an index from 1. More elements may follow below the line.
    #[inline]
    fn resolve(&mut self, line: usize, face: usize, element: Element, index: i64) -> Result<u32, ObjProblem> {
        let count = self.parsed.count(element);
        let absolute = if index < 0 { count as i64 + 1 + index } else { index };
        if absolute > count as i64 {
            let greatest = &mut self.greatest_forward[element as usize];
            if index > *greatest {
                *greatest = index;
                self.forward.push(ForwardReference { line, face, element, index });
            }
        } else if absolute < 1 {
            return Err(ObjProblem::IndexOutOfRange { face, what: element.name(), index, count });
        }
        // An index beyond 32 bits is a forward reference, which `finish` rejects.
        Ok(u32::try_from(absolute).unwrap_or(u32::MAX))
    }

    /// Counts an ignored statement.
    fn ignore(&mut self, keyword: &[u8], line: usize) {
        /// Largest number of entries. The last entry counts all further keywords.
        const MAX_KEYWORDS: usize = 64;
        let ignored = &mut self.parsed.ignored;
        let full = ignored.len() >= MAX_KEYWORDS;
        let known = ignored.iter().position(|entry| entry.keyword.as_bytes() == keyword);
        match known.or(full.then_some(MAX_KEYWORDS - 1)) {
            Some(at) => ignored[at].count += 1,
            None => {
                ignored.push(IgnoredStatement {
                    keyword: decode(keyword).into_owned(),
                    count: 1,
                    first_line: line,
                });
            }
        }
    }

    /// Returns a problem with its line. If the file has a foreign statement and no `v` so far, returns
    /// instead the problem that the file is not an OBJ file.
    fn locate(&self, line: usize, problem: ObjProblem) -> Located<ObjProblem> {
        let maybe_foreign =
            self.parsed.vertices.is_empty() && !matches!(problem, ObjProblem::IndexOutOfRange { .. });
        maybe_foreign.then(|| self.foreign()).flatten().unwrap_or((Some(line), problem))
    }

    /// Returns the problem of the first foreign statement, whose keyword is not part of the format.
    fn foreign(&self) -> Option<Located<ObjProblem>> {
        let first = self.parsed.ignored.iter().find(|entry| !KEYWORDS.contains(&entry.keyword.as_str()))?;
        let text = format!("line starts with `{}`, which is not an OBJ keyword", Excerpt(&first.keyword));
        Some((Some(first.first_line), ObjProblem::NotObj(text)))
    }

    /// Checks the file as a whole and returns its contents.
    fn finish(mut self, lines: usize) -> Result<Parsed, Located<ObjProblem>> {
        let faces = self.parsed.face_count();
        let empty = self.parsed.vertices.is_empty() && faces == 0;
        if let Some(foreign) = empty.then(|| self.foreign()).flatten() {
            return Err(foreign);
        }
        for &ForwardReference { line, face, element, index } in &self.forward {
            let count = self.parsed.count(element);
            if index > count as i64 {
                let what = element.name();
                return Err((Some(line), ObjProblem::IndexOutOfRange { face, what, index, count }));
            }
        }
        if faces == 0 {
            let (vertices, faces) = (self.parsed.vertices.len(), self.parsed.short_faces);
            return Err((self.parsed.first_short_face, ObjProblem::NoFaces { vertices, faces }));
        }
        let counts = [self.parsed.vertices.len(), self.parsed.normals.len(), self.parsed.corners.len()];
        if counts.iter().any(|&count| count >= u32::MAX as usize) {
            return Err((None, ObjProblem::TooLarge));
        }
        self.parsed.groups = self.groups.finish(faces as u32);
        self.parsed.lines = lines;
        Ok(self.parsed)
    }
}

/// Keywords of the format that this parser ignores. Other keywords can indicate a file of another format.
#[rustfmt::skip]
const KEYWORDS: &[&str] = &[
    "vp", "p", "l", "cstype", "deg", "bmat", "step", "curv", "curv2", "surf", "parm", "trim", "hole", "scrv",
    "sp", "end", "con", "mg", "bevel", "c_interp", "d_interp", "lod", "shadow_obj", "trace_obj", "ctech",
    "stech", "maplib", "usemap", "call", "csh",
];
