//! Reads PLY files, text and binary, with ply-rs-bw.
//!
//! The parser of ply-rs-bw keeps all elements in memory, those that nobody needs too. So it reads one element at a time.

use std::path::Path;

use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{
    ElementDef, Encoding, Header, Property, PropertyAccess, PropertyAccessResult, PropertyType, ScalarType,
};

use super::error::{Fault, ModelError};
use super::surface::{NO_TEXTURE, Surface, checked, excerpt, finite, vertex};
use crate::count::counted;
use crate::obj::{Document, Image, MaterialColor};

/// Returns whether bytes start with the first line of a PLY file.
pub(super) fn is(bytes: &[u8]) -> bool {
    bytes.starts_with(b"ply") && bytes.get(3).is_none_or(u8::is_ascii_whitespace)
}

/// Reads a file from its bytes.
pub(super) fn read(path: &Path, bytes: Vec<u8>) -> Result<Document, ModelError> {
    parse(path, &bytes).map_err(|fault| ModelError::of(path, fault))?.into_document(path)
}

/// Parts of an element that a surface has. Numbers that are not in the file are absent.
#[derive(Debug, Default)]
struct Element {
    position: [f64; 3],
    texture: [f32; 2],
    corners: Vec<i64>,
    /// Texture coordinates u and v of each corner, one after another.
    coordinates: Vec<f32>,
    /// Values of the maps, in the order of the properties.
    maps: Vec<f32>,
}

/// Returns the part of [`Element`] that a property belongs to; `None` for one that is not read.
fn role(name: &str) -> Option<Role> {
    Some(match name {
        "x" => Role::Position(0),
        "y" => Role::Position(1),
        "z" => Role::Position(2),
        "s" | "u" | "texture_u" | "texture_s" => Role::Texture(0),
        "t" | "v" | "texture_v" | "texture_t" => Role::Texture(1),
        "vertex_indices" | "vertex_index" => Role::Corners,
        "texcoord" => Role::Coordinates,
        "nx" | "ny" | "nz" => return None,
        _ => Role::Map,
    })
}

/// A part of [`Element`].
#[derive(Clone, Copy, PartialEq)]
enum Role {
    Position(usize),
    Texture(usize),
    Corners,
    Coordinates,
    Map,
}

impl PropertyAccess for Element {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let greatest = greatest(&property);
        match (role(name), numbers(property)) {
            (Some(Role::Map), Numbers::One(number)) => self.maps.push((number / greatest) as f32),
            (None | Some(Role::Map), _) => return PropertyAccessResult::Ignored,
            (Some(Role::Position(axis)), Numbers::One(number)) => self.position[axis] = number,
            (Some(Role::Texture(axis)), Numbers::One(number)) => self.texture[axis] = number as f32,
            (Some(Role::Corners), Numbers::Whole(corners)) => self.corners = corners,
            (Some(Role::Coordinates), Numbers::Real(numbers)) => self.coordinates = numbers,
            _ => return PropertyAccessResult::UnsupportedType,
        }
        PropertyAccessResult::Set
    }
}

/// The value of a property.
enum Numbers {
    One(f64),
    Whole(Vec<i64>),
    Real(Vec<f32>),
}

fn numbers(property: Property) -> Numbers {
    fn whole<T: Into<i64>>(list: Vec<T>) -> Numbers {
        Numbers::Whole(list.into_iter().map(Into::into).collect())
    }
    match property {
        Property::Char(x) => Numbers::One(x.into()),
        Property::UChar(x) => Numbers::One(x.into()),
        Property::Short(x) => Numbers::One(x.into()),
        Property::UShort(x) => Numbers::One(x.into()),
        Property::Int(x) => Numbers::One(x.into()),
        Property::UInt(x) => Numbers::One(x.into()),
        Property::Float(x) => Numbers::One(x.into()),
        Property::Double(x) => Numbers::One(x),
        Property::ListChar(list) => whole(list),
        Property::ListUChar(list) => whole(list),
        Property::ListShort(list) => whole(list),
        Property::ListUShort(list) => whole(list),
        Property::ListInt(list) => whole(list),
        Property::ListUInt(list) => whole(list),
        Property::ListFloat(list) => Numbers::Real(list),
        Property::ListDouble(list) => Numbers::Real(list.into_iter().map(|x| x as f32).collect()),
    }
}

/// Returns the number that a map divides the values of a property by.
fn greatest(property: &Property) -> f64 {
    match property {
        Property::UChar(_) => u8::MAX.into(),
        Property::UShort(_) => u16::MAX.into(),
        _ => 1.0,
    }
}

/// Returns the number of bytes of a number in a binary file.
fn size(kind: &ScalarType) -> usize {
    match kind {
        ScalarType::Char | ScalarType::UChar => 1,
        ScalarType::Short | ScalarType::UShort => 2,
        ScalarType::Int | ScalarType::UInt | ScalarType::Float => 4,
        ScalarType::Double => 8,
    }
}

/// Returns the smallest number of bytes of an element in a file.
fn smallest(element: &ElementDef, encoding: Encoding) -> usize {
    let sizes = element.properties.values().map(|property| match (encoding, &property.data_type) {
        // A digit and the space or line end after it.
        (Encoding::Ascii, _) => 2,
        (_, PropertyType::Scalar(kind) | PropertyType::List(kind, _)) => size(kind),
    });
    sizes.sum()
}

/// Splits a file after its header.
fn header(bytes: &[u8]) -> Result<(Header, &[u8]), Fault> {
    const END: &[u8] = b"end_header";
    let mut lines = bytes.split_inclusive(|&byte| byte == b'\n');
    let mut length = 0;
    let is_end = |line: &[u8]| {
        length += line.len();
        line.trim_ascii() == END
    };
    if !lines.any(is_end) {
        return Err(Fault("the PLY header has no line `end_header`; export it as PLY again".to_owned()));
    }
    let (text, rest) = bytes.split_at(length);
    let text = String::from_utf8_lossy(text);
    let header = Parser::<Element>::new().read_header(&mut Reader::new(text.as_bytes()));
    let header = header.map_err(|error| {
        let first = error.to_string().lines().next().unwrap_or_default().to_owned();
        Fault(format!("the PLY header is invalid: {}; export it as PLY again", excerpt(&first)))
    })?;
    for element in header.elements.values() {
        let (count, smallest) = (element.count, smallest(element, header.encoding));
        // The last line of a text may have no line end.
        if count.checked_mul(smallest).is_none_or(|needed| needed > rest.len() + 1) {
            return Err(Fault(format!(
                "the PLY header counts {count} elements `{}` of at least {}, and {} follow; export or copy the file again",
                excerpt(&element.name),
                counted(smallest, "byte"),
                counted(rest.len(), "byte")
            )));
        }
    }
    Ok((header, rest))
}

/// Reads the elements of a file one by one.
struct Elements<'a> {
    parser: Parser<Element>,
    encoding: Encoding,
    rest: &'a [u8],
}

impl Elements<'_> {
    /// Reads the next element. `number` is its number among those of its kind, from 0.
    fn next(&mut self, kind: &ElementDef, number: usize) -> Result<Element, Fault> {
        let read = match self.encoding {
            Encoding::BinaryLittleEndian => self.parser.read_little_endian_element(&mut self.rest, kind),
            Encoding::BinaryBigEndian => self.parser.read_big_endian_element(&mut self.rest, kind),
            Encoding::Ascii => {
                let end =
                    self.rest.iter().position(|&byte| byte == b'\n').map_or(self.rest.len(), |end| end + 1);
                let (line, rest) = self.rest.split_at(end);
                self.rest = rest;
                self.parser.read_ascii_element(&String::from_utf8_lossy(line), kind)
            }
        };
        read.map_err(|error| {
            let first = error.to_string().lines().next().unwrap_or_default().to_owned();
            let name = excerpt(&kind.name);
            Fault(format!("{name} {number}, counted from 0: {}; export it as PLY again", excerpt(&first)))
        })
    }
}

fn parse(path: &Path, bytes: &[u8]) -> Result<Surface, Fault> {
    let (header, rest) = header(bytes)?;
    let mut surface = Surface::default();
    let faces = header.elements.get("face");
    let vertices = header.elements.get("vertex");
    check(vertices, faces)?;
    if let Some(image) = texture_image(path, &header) {
        surface.materials.push(("texture".to_owned(), image));
        surface.start("", Some(0));
    }
    let mut elements = Elements { parser: Parser::new(), encoding: header.encoding, rest };
    let count = vertices.map_or(0, |vertices| vertices.count);
    let of_vertices = vertices.is_some_and(|kind| has(kind, Role::Texture(0)) && has(kind, Role::Texture(1)));
    let (mut textures, mut short) = (Vec::new(), 0);
    surface.maps = vertices.map_or(Vec::new(), maps);
    for kind in header.elements.values() {
        // Elements without properties have no data.
        let number = if kind.properties.is_empty() { 0 } else { kind.count };
        for number in 0..number {
            let element = elements.next(kind, number)?;
            match &*kind.name {
                "vertex" => {
                    surface.positions.push(checked(element.position, || format!("vertex {number}"))?);
                    if of_vertices {
                        textures.push(finite(element.texture));
                    }
                    for ((_, map), value) in surface.maps.iter_mut().zip(element.maps) {
                        map.extend(finite([value]));
                    }
                }
                "face" if element.corners.len() < 3 => short += 1,
                "face" => push_face(&mut surface, &element, (number, count), of_vertices)?,
                _ => {}
            }
        }
        if kind.count > 0 && !["vertex", "face"].contains(&&*kind.name) {
            surface.ignored.push(format!("{} `{}`", counted(kind.count, "element"), excerpt(&kind.name)));
        }
    }
    textures.append(&mut surface.coordinates);
    surface.coordinates = textures;
    surface.is_double = vertices.is_some_and(|kind| {
        let is_double = |name: &str| {
            let property = kind.properties.get(name);
            property.is_some_and(|property| property.data_type == PropertyType::Scalar(ScalarType::Double))
        };
        ["x", "y", "z"].into_iter().any(is_double)
    });
    if short > 0 {
        surface.ignored.push(format!("{} of fewer than three corners", counted(short, "face")));
    }
    match surface.face_count() {
        0 => Err(Fault("no faces with three corners or more; export polygons".to_owned())),
        _ => Ok(surface),
    }
}

/// Returns whether an element has a property.
fn has(kind: &ElementDef, wanted: Role) -> bool {
    kind.properties.keys().any(|name| role(name) == Some(wanted))
}

/// Returns the maps of vertices, without values: the properties that are numbers and have no other role.
fn maps(vertices: &ElementDef) -> Vec<(String, Vec<f32>)> {
    let properties = vertices.properties.values();
    let maps = properties.filter(|property| {
        matches!(property.data_type, PropertyType::Scalar(_)) && role(&property.name) == Some(Role::Map)
    });
    maps.map(|property| (property.name.clone(), Vec::with_capacity(vertices.count))).collect()
}

/// Checks that a file has vertices with positions, and faces.
fn check(vertices: Option<&ElementDef>, faces: Option<&ElementDef>) -> Result<(), Fault> {
    let has_positions = vertices.is_some_and(|kind| (0..3).all(|axis| has(kind, Role::Position(axis))));
    let fault = |text: &str| Err(Fault(text.to_owned()));
    match faces.filter(|faces| faces.count > 0) {
        _ if !has_positions => fault("the PLY header has no element `vertex` with x, y and z; export a mesh"),
        None => fault(
            "a PLY file without faces is a point cloud, which has no surface; reconstruct one, for example with Poisson \
             reconstruction in MeshLab or Open3D, or export triangles in place of triangle strips",
        ),
        Some(faces) if !has(faces, Role::Corners) => {
            fault("the faces of the PLY file have no `vertex_indices` or `vertex_index`; export polygons")
        }
        Some(_) => Ok(()),
    }
}

/// Appends a face. `number` is its number from 0. `of_vertices` is whether vertices have texture coordinates, whose indices
/// are then those of the vertices.
fn push_face(
    surface: &mut Surface,
    element: &Element,
    (number, vertices): (usize, usize),
    of_vertices: bool,
) -> Result<(), Fault> {
    let name = || format!("face {number}");
    let corners: Result<Vec<u32>, Fault> =
        element.corners.iter().map(|&corner| vertex(corner, vertices, name)).collect();
    let corners = corners?;
    let own = element.coordinates.len() == 2 * corners.len();
    let start = surface.coordinates.len() as u32 + if of_vertices { vertices as u32 } else { 0 };
    if own {
        let pairs = element.coordinates.as_chunks().0;
        surface.coordinates.extend(pairs.iter().copied().map(finite));
    }
    let texture = |(corner, index): (u32, u32)| match (own, of_vertices) {
        (true, _) => (corner, start + index),
        (false, true) => (corner, corner),
        (false, false) => (corner, NO_TEXTURE),
    };
    surface.push_face(corners.into_iter().zip(0..).map(texture));
    Ok(())
}

/// Returns a material with the image that a comment of the header names, as MeshLab writes it, if the file exists.
fn texture_image(path: &Path, header: &Header) -> Option<MaterialColor> {
    let name = header.comments.iter().find_map(|comment| comment.trim().strip_prefix("TextureFile "))?;
    let image = path.parent()?.join(name.trim());
    image.is_file().then(|| MaterialColor {
        diffuse: [1.0; 3],
        image: Some(Image::File(image)),
        ..MaterialColor::default()
    })
}
