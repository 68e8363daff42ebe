//! The surface that the readers of all formats produce, and its text as OBJ.

use std::io::Write;
use std::path::Path;

use super::error::{Fault, ModelError};
use crate::escape::Excerpt;
use crate::obj::{Document, MaterialColor, Origin};

/// Marks a corner without texture coordinates.
pub(super) const NO_TEXTURE: u32 = u32::MAX;

/// Surface of a file.
#[derive(Debug, Default)]
pub(super) struct Surface {
    /// Finite positions within the range of `f32`.
    pub(super) positions: Vec<[f64; 3]>,
    /// Whether the file has positions of 64 bits.
    pub(super) is_double: bool,
    /// Texture coordinates; the origin is at the lower left of the image.
    pub(super) coordinates: Vec<[f32; 2]>,
    /// Number of corners of each face, at least 3.
    sizes: Vec<u32>,
    /// Vertex of each corner, from 0.
    corners: Vec<u32>,
    /// Index of the texture coordinates of each corner, or [`NO_TEXTURE`].
    textures: Vec<u32>,
    /// The first face, the name and the material of each section, in order.
    sections: Vec<Section>,
    /// Materials with different names.
    pub(super) materials: Vec<(String, MaterialColor)>,
    /// Maps with different names: a finite number for each position.
    pub(super) maps: Vec<(String, Vec<f32>)>,
    /// Descriptions of what was not read.
    pub(super) ignored: Vec<String>,
}

/// The faces from `first` to the next section.
#[derive(Debug)]
struct Section {
    first: usize,
    object: String,
    material: Option<usize>,
}

impl Surface {
    /// Starts a section: the next faces belong to an object, which has no name if `object` is empty, and have a material.
    pub(super) fn start(&mut self, object: &str, material: Option<usize>) {
        let object = plain_name(object);
        self.sections.push(Section { first: self.sizes.len(), object, material });
    }

    /// Appends a face. `corners` are the vertices and the indices of texture coordinates of its corners.
    pub(super) fn push_face(&mut self, corners: impl Iterator<Item = (u32, u32)>) {
        let before = self.corners.len();
        for (vertex, texture) in corners {
            self.corners.push(vertex);
            self.textures.push(texture);
        }
        self.sizes.push((self.corners.len() - before) as u32);
    }

    /// Returns the number of faces.
    pub(super) fn face_count(&self) -> usize {
        self.sizes.len()
    }

    /// Returns the document with the text of the surface as OBJ.
    pub(super) fn into_document(self, path: &Path) -> Result<Document, ModelError> {
        let text = self.text();
        let Self { materials, maps, ignored, .. } = self;
        Ok(Document::of_origin(path, text, Origin { materials, maps, ignored })?)
    }

    /// Returns the text as OBJ. Numbers are the shortest texts that read back as the same number of 32 or 64 bits.
    fn text(&self) -> Vec<u8> {
        let mut text = Vec::new();
        let mut number = zmij::Buffer::new();
        for position in &self.positions {
            text.push(b'v');
            for &x in position {
                text.push(b' ');
                let digits =
                    if self.is_double { number.format_finite(x) } else { number.format_finite(x as f32) };
                text.extend_from_slice(digits.strip_suffix(".0").unwrap_or(digits).as_bytes());
            }
            text.push(b'\n');
        }
        let mut line = |arguments: std::fmt::Arguments<'_>| {
            // Writing to a vector does not fail.
            let _ = text.write_fmt(arguments);
        };
        for &[u, v] in &self.coordinates {
            line(format_args!("vt {u} {v}\n"));
        }
        let mut sections = self.sections.iter().peekable();
        let (mut object, mut material) = ("", None);
        let mut corner = 0;
        for (face, &size) in self.sizes.iter().enumerate() {
            while let Some(section) = sections.next_if(|section| section.first <= face) {
                if section.object != object {
                    object = &section.object;
                    line(format_args!("o {object}\n"));
                }
                if section.material != material {
                    material = section.material;
                    let name = material.map_or("default", |material| &self.materials[material].0);
                    line(format_args!("usemtl {name}\n"));
                }
            }
            line(format_args!("f"));
            for (vertex, texture) in
                self.corners[corner..].iter().zip(&self.textures[corner..]).take(size as usize)
            {
                match *texture {
                    NO_TEXTURE => line(format_args!(" {}", vertex + 1)),
                    texture => line(format_args!(" {}/{}", vertex + 1, texture + 1)),
                }
            }
            line(format_args!("\n"));
            corner += size as usize;
        }
        text
    }
}

/// Largest number of characters of a name.
const MAX_NAME: usize = 200;

/// Returns a name as OBJ statements can have it: without control characters, a `#`, or a `\` at the end, with one space
/// between words, and cut after [`MAX_NAME`] characters.
pub(super) fn plain_name(name: &str) -> String {
    let plain = |letter: char| if letter.is_control() || letter == '#' { ' ' } else { letter };
    let name: String = name.chars().take(MAX_NAME).map(plain).collect();
    let name = name.split_whitespace().collect::<Vec<_>>().join(" ");
    name.trim_end_matches(['\\', ' ']).to_owned()
}

/// Returns a position if it is finite and within the range of `f32`. `element` describes the vertex in messages.
pub(super) fn checked(position: [f64; 3], element: impl FnOnce() -> String) -> Result<[f64; 3], Fault> {
    match position.iter().find(|&&x| !(x as f32).is_finite()) {
        None => Ok(position),
        Some(x) => Err(Fault(format!(
            "{} has the coordinate {x}; numbers must be finite and within the range of f32",
            element()
        ))),
    }
}

/// Returns numbers that are finite: 0 in place of others.
pub(super) fn finite<const N: usize>(numbers: [f32; N]) -> [f32; N] {
    numbers.map(|x| if x.is_finite() { x } else { 0.0 })
}

/// Returns the index of a vertex if it is below `count`. `element` describes the face in messages.
pub(super) fn vertex(index: i64, count: usize, element: impl FnOnce() -> String) -> Result<u32, Fault> {
    match u32::try_from(index).ok().filter(|&index| (index as usize) < count) {
        Some(index) => Ok(index),
        None => Err(Fault(format!(
            "{} refers to vertex {index} of {count}, counted from 0; export the file again",
            element()
        ))),
    }
}

/// Returns the start of a text of a file, for messages.
pub(super) fn excerpt(text: &str) -> String {
    Excerpt(text).to_string()
}
