//! The border to obj-rs: clean `v`, `vn` and `f` statements in, positions, normals and polygons out.
//!
//! Which normals the corners have is known from the scan, and not asked for again.

use std::io::Read;

use obj::raw::object::{Polygon, RawObj, parse_obj};

use super::error::{At, ObjProblem};
use super::lines::{decode, line_of};
use super::scan::{Numbers, Scan};

/// Statements that obj-rs reads: UTF-8 (or it is found out), three numbers, indices from 1 that exist, faces after
/// the vertices that they refer to.
#[derive(Debug, Default)]
pub(super) struct CleanText {
    elements: Vec<u8>,
    faces: Vec<u8>,
    /// As in [`Parsed`], but that a tail of faces without normals is missing.
    corner_normals: Vec<u32>,
    corners: usize,
}

impl CleanText {
    pub(super) fn vertex(&mut self, raw: &[u8], numbers: &Numbers) {
        self.numbers(b"v", raw, numbers);
    }

    pub(super) fn normal(&mut self, raw: &[u8], numbers: &Numbers) {
        self.numbers(b"vn", raw, numbers);
    }

    fn numbers(&mut self, statement: &[u8], raw: &[u8], numbers: &Numbers) {
        self.elements.extend_from_slice(statement);
        for range in numbers.ranges() {
            self.elements.push(b' ');
            self.elements.extend_from_slice(&raw[range]);
        }
        self.elements.push(b'\n');
    }

    /// A face from its corners, each `[vertex, normal]` from 1. A face of which a corner lacks its normal has none.
    pub(super) fn face(&mut self, corners: &[[u32; 2]], with_normals: bool) {
        self.faces.push(b'f');
        for &[vertex, _] in corners {
            self.faces.push(b' ');
            push_integer(&mut self.faces, vertex);
        }
        self.faces.push(b'\n');
        if with_normals {
            self.corner_normals.resize(self.corners, NO_NORMAL);
            self.corner_normals.extend(corners.iter().map(|&[_, normal]| normal - 1));
        }
        self.corners += corners.len();
    }
}

/// Stands for "no normal" in [`Parsed::corner_normals`].
pub(super) const NO_NORMAL: u32 = u32::MAX;

/// What obj-rs makes of a file.
#[derive(Debug, Default)]
pub(super) struct Parsed {
    pub(super) positions: Vec<[f32; 3]>,
    pub(super) normals: Vec<[f32; 3]>,
    /// Corners of face `f` are `offsets[f]..offsets[f + 1]`.
    pub(super) offsets: Vec<u32>,
    pub(super) corners: Vec<u32>,
    /// One per corner; empty if no face has normals.
    pub(super) corner_normals: Vec<u32>,
}

/// Hands the clean statements of `scan` to obj-rs.
pub(super) fn parse(raw: &[u8], scan: &mut Scan) -> Result<Parsed, At<ObjProblem>> {
    let CleanText { elements, faces, mut corner_normals, corners } = std::mem::take(&mut scan.clean);
    let too_many = scan.vertices.len().max(scan.normals.len()).max(corners);
    if too_many >= u32::MAX as usize {
        let problem = "more vertices, normals or corners than 32-bit indices can count".to_owned();
        return Err((None, ObjProblem::Parser(problem)));
    }
    let parsed = parse_obj(elements.as_slice().chain(faces.as_slice()));
    let RawObj { positions, normals, polygons, .. } = parsed.map_err(|error| {
        first_bad_number(raw, scan).unwrap_or((None, ObjProblem::Parser(error.to_string())))
    })?;
    drop((elements, faces));
    if !corner_normals.is_empty() {
        corner_normals.resize(corners, NO_NORMAL);
    }
    let positions: Vec<_> = positions.into_iter().map(|(x, y, z, _)| [x, y, z]).collect();
    let normals: Vec<_> = normals.into_iter().map(|(x, y, z)| [x, y, z]).collect();
    let finite = |numbers: &[[f32; 3]]| numbers.iter().flatten().all(|number| number.is_finite());
    if !finite(&positions) || !finite(&normals) {
        let unknown = || (None, ObjProblem::Parser("a number is not finite".to_owned()));
        return Err(first_bad_number(raw, scan).unwrap_or_else(unknown));
    }
    let mut parsed = Parsed { positions, normals, corner_normals, ..Parsed::default() };
    parsed.take_polygons(&polygons);
    Ok(parsed)
}

impl Parsed {
    fn take_polygons(&mut self, polygons: &[Polygon]) {
        self.offsets.reserve_exact(polygons.len() + 1);
        self.offsets.push(0);
        for polygon in polygons {
            match polygon {
                Polygon::P(corners) => self.corners.extend(corners.iter().map(|&vertex| vertex as u32)),
                // Forms that it was not given.
                Polygon::PT(corners) | Polygon::PN(corners) => {
                    self.corners.extend(corners.iter().map(|&(vertex, _)| vertex as u32));
                }
                Polygon::PTN(corners) => {
                    self.corners.extend(corners.iter().map(|&(vertex, ..)| vertex as u32));
                }
            }
            self.offsets.push(self.corners.len() as u32);
        }
    }
}

/// The first number, in the order of lines, that is none or not finite: obj-rs says neither line nor text.
fn first_bad_number(raw: &[u8], scan: &Scan) -> Option<At<ObjProblem>> {
    let bad = |statement: &'static str, list: &[Numbers]| {
        let words = list.iter().flat_map(Numbers::ranges);
        words.filter_map(|word| Some((word.start, problem(statement, &raw[word])?))).next()
    };
    let both = [bad("v", &scan.vertices), bad("vn", &scan.normals)];
    let (offset, problem) = both.into_iter().flatten().min_by_key(|&(offset, _)| offset)?;
    Some((Some(line_of(raw, offset)), problem))
}

fn problem(statement: &'static str, bytes: &[u8]) -> Option<ObjProblem> {
    let text = decode(bytes);
    match std::str::from_utf8(bytes).ok().and_then(|text| text.parse::<f32>().ok()) {
        None => Some(ObjProblem::NotANumber { statement, text }),
        Some(number) if !number.is_finite() => Some(ObjProblem::NotFinite { statement, text }),
        Some(_) => None,
    }
}

fn push_integer(text: &mut Vec<u8>, mut value: u32) {
    let mut digits = [0; 10];
    let mut at = digits.len();
    loop {
        at -= 1;
        digits[at] = b'0' + (value % 10) as u8;
        value /= 10;
        if value == 0 {
            break;
        }
    }
    text.extend_from_slice(&digits[at..]);
}
