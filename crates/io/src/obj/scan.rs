//! One pass over the bytes of an OBJ file: where everything is, and clean statements for the parser.

use std::ops::Range;

use super::clean::CleanText;
use super::corner::{self, Corner};
use super::error::{At, ObjProblem};
use super::groups::{Group, GroupBuilder};
use super::lines::{Statement, Statements, Words, decode, line_of};

/// Where the three numbers of a `v` or `vn` statement stand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Numbers {
    start: usize,
    /// End of the first, start and end of the second, start and end of the third, from `start`.
    ends: [u32; 5],
}

impl Numbers {
    /// The bytes from the first number to the end of the third.
    #[inline]
    pub(crate) fn span(&self) -> Range<usize> {
        self.start..self.start + self.ends[4] as usize
    }

    /// The byte ranges of the three numbers.
    #[inline]
    pub(crate) fn ranges(&self) -> [Range<usize>; 3] {
        let [a, b, c, d, e] = self.ends.map(|end| self.start + end as usize);
        [self.start..a, b..c, d..e]
    }
}

/// A statement that is not used: its first word, how often it occurs, and where first.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct IgnoredStatement {
    /// The first word of the line.
    pub keyword: String,
    /// How many there are.
    pub count: usize,
    /// The line of the first, from 1.
    pub first_line: usize,
}

/// What one pass finds.
#[derive(Debug, Default)]
pub(super) struct Scan {
    pub(super) vertices: Vec<Numbers>,
    pub(super) normals: Vec<Numbers>,
    pub(super) textures: usize,
    /// Faces with three corners or more.
    pub(super) faces: usize,
    /// Faces with fewer, and the line of the first.
    pub(super) short_faces: usize,
    pub(super) first_short_face: Option<usize>,
    /// The names of `mtllib` statements: everything after the word.
    pub(super) libraries: Vec<Range<usize>>,
    pub(super) groups: Vec<Group>,
    pub(super) ignored: Vec<IgnoredStatement>,
    pub(super) lines: usize,
    pub(super) clean: CleanText,
}

/// A corner that refers to something further down: right iff the file has it.
struct Forward {
    line: usize,
    face: usize,
    what: &'static str,
    index: i64,
}

struct Scanner<'a> {
    raw: &'a [u8],
    scan: Scan,
    groups: GroupBuilder,
    forward: Vec<Forward>,
    corners: Vec<[u32; 2]>,
}

const VERTEX: &str = "vertex";
const TEXTURE: &str = "texture coordinate";
const NORMAL: &str = "normal";

/// Scans a whole file.
pub(super) fn scan(raw: &[u8]) -> Result<Scan, At<ObjProblem>> {
    // Eight bytes at a time, unlike a search for the place.
    if raw.contains(&0) {
        let at = raw.iter().take_while(|&&byte| byte != 0).count();
        let text = "it holds binary data (a zero byte on this line)".to_owned();
        return Err((Some(line_of(raw, at)), ObjProblem::NotObj(text)));
    }
    let mut scanner = Scanner {
        raw,
        scan: Scan::default(),
        groups: GroupBuilder::default(),
        forward: Vec::new(),
        corners: Vec::new(),
    };
    let mut statements = Statements::new(raw);
    for statement in statements.by_ref() {
        scanner.statement(&statement).map_err(|problem| scanner.blame(statement.line, problem))?;
    }
    let lines = statements.lines();
    scanner.finish(lines)
}

impl Scanner<'_> {
    fn statement(&mut self, statement: &Statement) -> Result<(), ObjProblem> {
        let raw = self.raw;
        let mut words = Words::new(raw, &statement.bytes);
        let Some(keyword) = words.next() else { return Ok(()) };
        let faces = self.scan.faces as u32;
        match &raw[keyword.clone()] {
            b"v" => {
                let numbers = three_numbers("v", words)?;
                self.scan.clean.vertex(raw, &numbers);
                self.scan.vertices.push(numbers);
            }
            b"vn" => {
                let numbers = three_numbers("vn", words)?;
                self.scan.clean.normal(raw, &numbers);
                self.scan.normals.push(numbers);
            }
            b"vt" => self.scan.textures += 1,
            b"f" | b"fo" => self.face(statement.line, words)?,
            b"o" => self.groups.start_object(decode(&raw[words.rest()]), faces),
            b"g" => {
                let text = decode(&raw[words.clone().rest()]);
                let names = words.map(|word| decode(&raw[word])).collect();
                self.groups.start_groups(names, text, faces);
            }
            b"mtllib" => self.scan.libraries.push(words.rest()),
            // How surfaces look, not where they are.
            b"usemtl" | b"s" => {}
            _ => self.ignore(&raw[keyword], statement.line),
        }
        Ok(())
    }

    fn face(&mut self, line: usize, words: Words<'_>) -> Result<(), ObjProblem> {
        let face = self.scan.faces + self.scan.short_faces + 1;
        self.corners.clear();
        let mut with_normals = true;
        for word in words {
            let text = &self.raw[word];
            let Some(Corner { vertex, texture, normal }) = corner::parse(text) else {
                return Err(ObjProblem::Corner { face, text: decode(text) });
            };
            let vertex = self.resolve(line, face, VERTEX, self.scan.vertices.len(), vertex)?;
            if let Some(texture) = texture {
                self.resolve(line, face, TEXTURE, self.scan.textures, texture)?;
            }
            let normal = match normal {
                Some(normal) => self.resolve(line, face, NORMAL, self.scan.normals.len(), normal)?,
                None => 0,
            };
            with_normals &= normal != 0;
            self.corners.push([vertex, normal]);
        }
        if self.corners.len() < 3 {
            self.scan.short_faces += 1;
            self.scan.first_short_face.get_or_insert(line);
        } else {
            self.scan.faces += 1;
            self.scan.clean.face(&self.corners, with_normals);
        }
        Ok(())
    }

    /// An index as a position from 1. `count` elements came before this line; more may follow.
    #[inline]
    fn resolve(
        &mut self,
        line: usize,
        face: usize,
        what: &'static str,
        count: usize,
        index: i64,
    ) -> Result<u32, ObjProblem> {
        let position = if index < 0 { count as i64 + 1 + index } else { index };
        if position > count as i64 {
            self.forward.push(Forward { line, face, what, index });
        } else if position < 1 {
            return Err(ObjProblem::IndexOutOfRange { face, what, index, count });
        }
        // One that does not fit is too large for any file, and found out at the end.
        Ok(u32::try_from(position).unwrap_or(u32::MAX))
    }

    fn ignore(&mut self, keyword: &[u8], line: usize) {
        /// More different words than this are not told apart.
        const MOST: usize = 64;
        let ignored = &mut self.scan.ignored;
        let full = ignored.len() >= MOST;
        let known = ignored.iter().position(|entry| entry.keyword.as_bytes() == keyword);
        match known.or(full.then_some(MOST - 1)) {
            Some(at) => ignored[at].count += 1,
            None => {
                ignored.push(IgnoredStatement { keyword: decode(keyword), count: 1, first_line: line });
            }
        }
    }

    /// Names the line of a problem; in a file that had no vertex before, but something else, says that it is no OBJ.
    fn blame(&self, line: usize, problem: ObjProblem) -> At<ObjProblem> {
        let maybe_foreign =
            self.scan.vertices.is_empty() && !matches!(problem, ObjProblem::IndexOutOfRange { .. });
        maybe_foreign.then(|| self.foreign()).flatten().unwrap_or((Some(line), problem))
    }

    /// The first statement that the format does not know.
    fn foreign(&self) -> Option<At<ObjProblem>> {
        let first = self.scan.ignored.iter().find(|entry| !FORMAT.contains(&entry.keyword.as_str()))?;
        let text =
            format!("line starts with `{}`, and no vertices or faces come before or after", first.keyword);
        Some((Some(first.first_line), ObjProblem::NotObj(text)))
    }

    fn finish(mut self, lines: usize) -> Result<Scan, At<ObjProblem>> {
        let empty = self.scan.vertices.is_empty() && self.scan.faces == 0;
        if let Some(foreign) = empty.then(|| self.foreign()).flatten() {
            return Err(foreign);
        }
        for &Forward { line, face, what, index } in &self.forward {
            let count = match what {
                VERTEX => self.scan.vertices.len(),
                TEXTURE => self.scan.textures,
                _ => self.scan.normals.len(),
            };
            if index > count as i64 {
                return Err((Some(line), ObjProblem::IndexOutOfRange { face, what, index, count }));
            }
        }
        if self.scan.faces == 0 {
            let (vertices, faces) = (self.scan.vertices.len(), self.scan.short_faces);
            return Err((self.scan.first_short_face, ObjProblem::NoFaces { vertices, faces }));
        }
        self.scan.groups = self.groups.finish(self.scan.faces as u32);
        self.scan.lines = lines;
        Ok(self.scan)
    }
}

/// Words of the format that are not used here: their presence does not speak against an OBJ file.
#[rustfmt::skip]
const FORMAT: &[&str] = &[
    "vp", "p", "l", "cstype", "deg", "bmat", "step", "curv", "curv2", "surf", "parm", "trim", "hole", "scrv", "sp",
    "end", "con", "mg", "bevel", "c_interp", "d_interp", "lod", "shadow_obj", "trace_obj", "ctech", "stech",
    "maplib", "usemap", "call", "csh",
];

fn three_numbers(statement: &'static str, mut words: Words<'_>) -> Result<Numbers, ObjProblem> {
    let mut ranges: [Range<usize>; 3] = [0..0, 0..0, 0..0];
    for (found, range) in ranges.iter_mut().enumerate() {
        *range = words.next().ok_or(ObjProblem::TooFewNumbers { statement, needed: 3, found })?;
    }
    let [x, y, z] = ranges;
    let start = x.start;
    // A statement longer than 4 GiB is made of blanks; such a file does not fit the 32-bit indices elsewhere either.
    let ends = [x.end, y.start, y.end, z.start, z.end].map(|end| u32::try_from(end - start));
    let [Ok(a), Ok(b), Ok(c), Ok(d), Ok(e)] = ends else {
        return Err(ObjProblem::TooFewNumbers { statement, needed: 3, found: 0 });
    };
    Ok(Numbers { start, ends: [a, b, c, d, e] })
}
