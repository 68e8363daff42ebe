//! Reads STL files, binary and text, with stl_io.
//!
//! stl_io takes each file that starts with `solid ` for text, and reads only the first solid of a text, with keywords in
//! lower case. So a binary header is blanked, and the solids of a text are passed to it one by one.

use std::io::Cursor;
use std::path::Path;

use stl_io::{Triangle, create_stl_reader};

use super::error::{Fault, ModelError};
use super::surface::{NO_TEXTURE, Surface, checked, excerpt};
use super::weld::Weld;
use crate::obj::Document;

/// Bytes of a binary file before its triangles: a header and their number.
const HEADER: usize = 84;
/// Bytes of a triangle in a binary file.
const TRIANGLE: u64 = 50;
/// Bytes at the start of a file in which a keyword of text files is searched.
const SEARCHED: usize = 4096;

/// Returns whether bytes have the size that the header of a binary file tells, or are the text of a solid.
pub(super) fn is(bytes: &[u8]) -> bool {
    binary_size(bytes) == Some(bytes.len() as u64) || is_text(bytes)
}

/// Returns the size of a binary file according to its number of triangles.
fn binary_size(bytes: &[u8]) -> Option<u64> {
    Some(HEADER as u64 + TRIANGLE * count(bytes)?)
}

/// Returns the number of triangles in the header of a binary file.
fn count(bytes: &[u8]) -> Option<u64> {
    let count = bytes.get(HEADER - 4..HEADER)?;
    Some(u64::from(u32::from_le_bytes(count.try_into().ok()?)))
}

fn is_text(bytes: &[u8]) -> bool {
    let start = bytes[..bytes.len().min(SEARCHED)].to_ascii_lowercase();
    let start = start.trim_ascii_start();
    let has = |word: &[u8]| start.windows(word.len()).any(|part| part == word);
    start.starts_with(b"solid") && (has(b"facet") || has(b"endsolid"))
}

/// Reads a file from its bytes.
pub(super) fn read(path: &Path, bytes: Vec<u8>) -> Result<Document, ModelError> {
    let is_binary = binary_size(&bytes) == Some(bytes.len() as u64) || !is_text(&bytes);
    let surface = if is_binary { read_binary(bytes) } else { read_text(&bytes) };
    let checked = surface.and_then(|surface| match surface.face_count() {
        0 => Err(Fault("no triangles; export a surface".to_owned())),
        _ => Ok(surface),
    });
    checked.map_err(|fault| ModelError::of(path, fault))?.into_document(path)
}

fn read_binary(mut bytes: Vec<u8>) -> Result<Surface, Fault> {
    let size = bytes.len();
    let Some(count) = count(&bytes) else {
        return Err(Fault(format!(
            "is neither a text that begins with `solid` nor a binary STL file, which has at least {HEADER} bytes, not \
             {size}; export it as STL again"
        )));
    };
    let needed = HEADER as u64 + TRIANGLE * count;
    if needed > size as u64 {
        return Err(Fault(format!(
            "is no text that begins with `solid`, and as a binary STL file with the {count} triangles of its header it has \
             {needed} bytes, not {size}; export or copy it again"
        )));
    }
    bytes[..HEADER - 4].fill(b' ');
    let mut surface = Surface::default();
    append(&mut surface, &mut Weld::default(), bytes, |triangle| format!("triangle {triangle}"))?;
    Ok(surface)
}

fn read_text(bytes: &[u8]) -> Result<Surface, Fault> {
    let (mut surface, mut weld, mut solids) = (Surface::default(), Weld::default(), 0);
    let mut lines = bytes.split_inclusive(|&byte| byte == b'\n').peekable();
    while let Some(first) = lines.next() {
        let name = String::from_utf8_lossy(first);
        let Some((keyword, name)) = split_word(&name) else { continue };
        if !keyword.eq_ignore_ascii_case("solid") {
            return Err(Fault(format!("`{}` in place of `solid` or the end of the file", excerpt(keyword))));
        }
        let mut solid = b"solid \n".to_vec();
        for line in lines.by_ref() {
            solid.extend(
                line.iter().map(|byte| if byte.is_ascii() { byte.to_ascii_lowercase() } else { b'?' }),
            );
            if solid[solid.len() - line.len()..].trim_ascii_start().starts_with(b"endsolid") {
                break;
            }
        }
        solids += 1;
        let name = if name.is_empty() { format!("solid {solids}") } else { name.to_owned() };
        surface.start(&name, None);
        let element = |triangle| format!("solid `{}`, triangle {triangle}", excerpt(&name));
        append(&mut surface, &mut weld, solid, element)?;
    }
    Ok(surface)
}

/// Splits the first word off a line; `None` if the line is empty.
fn split_word(line: &str) -> Option<(&str, &str)> {
    let line = line.trim();
    let end = line.find(char::is_whitespace).unwrap_or(line.len());
    (end > 0).then(|| (&line[..end], line[end..].trim()))
}

/// Appends the triangles of a file. `element` describes the triangle of a number from 1 in messages.
fn append(
    surface: &mut Surface,
    weld: &mut Weld,
    bytes: Vec<u8>,
    element: impl Fn(usize) -> String,
) -> Result<(), Fault> {
    let mut file = Cursor::new(bytes);
    let failed = |number, error: std::io::Error| {
        Fault(format!("{}: {}; export it as STL again", element(number), excerpt(&error.to_string())))
    };
    let triangles = create_stl_reader(&mut file).map_err(|error| failed(1, error))?;
    for (number, triangle) in (1..).zip(triangles) {
        let Triangle { vertices, .. } = triangle.map_err(|error| failed(number, error))?;
        let mut corners = [(0, NO_TEXTURE); 3];
        for (corner, vertex) in corners.iter_mut().zip(vertices) {
            let position = checked(vertex.0.map(f64::from), || element(number))?;
            corner.0 = weld.vertex(position, &mut surface.positions);
        }
        surface.push_face(corners.into_iter());
    }
    Ok(())
}
