//! Prims of materials.

use std::collections::BTreeMap;
use std::path::Path;

use super::name::Names;
use super::package::Packed;
use super::prim::{Prim, Property, Value};
use crate::obj::{Image, MaterialColor};
use crate::path::{relative, resolve, resolve_directory};

/// Where the images of a stage are.
pub(super) enum Images<'a> {
    /// In their files. The stage is in this directory.
    Beside(&'a Path),
    /// In the package of the stage.
    Packed(Packed),
}

impl Images<'_> {
    /// Returns the path from the stage of an image of a body; `None` if the stage cannot have it.
    fn asset(&mut self, image: &Image, body: &str) -> Option<String> {
        let path = match self {
            Self::Beside(directory) => {
                let path = resolve(&image.path(directory, body));
                relative(&path, &resolve_directory(directory)).to_str()?.replace('\\', "/")
            }
            Self::Packed(packed) => packed.name_of(image)?,
        };
        // USD paths have slashes on all systems. A name alone would be searched in the paths of the program.
        Some(if path.starts_with(['.', '/']) { path } else { format!("./{path}") })
    }

    /// Returns the images of the package.
    pub(super) fn into_packed(self) -> Packed {
        match self {
            Self::Beside(_) => Packed::default(),
            Self::Packed(packed) => packed,
        }
    }
}

/// The materials of a stage.
pub(super) struct Materials<'a> {
    /// Path of the prim that has them.
    path: &'a str,
    pub(super) images: Images<'a>,
    names: Names,
    pub(super) prims: Vec<Prim>,
    /// Paths of the prims by file and name.
    known: BTreeMap<(&'a Path, String), String>,
}

impl<'a> Materials<'a> {
    pub(super) fn new(path: &'a str, images: Images<'a>) -> Self {
        Self { path, images, names: Names::default(), prims: Vec::new(), known: BTreeMap::new() }
    }

    /// Returns the path of the prim of a material of an OBJ file, which a body uses.
    pub(super) fn path_of(
        &mut self,
        file: &'a Path,
        name: &str,
        color: &MaterialColor,
        body: &str,
    ) -> String {
        let Self { path, images, names, prims, known } = self;
        let new_path = || {
            let prim = Prim::new("Material", name, names);
            let path = format!("{path}/{}", prim.name);
            let image = color.image.as_ref().and_then(|image| images.asset(image, body));
            prims.push(shaded(prim, &path, color, image));
            path
        };
        known.entry((file, name.to_owned())).or_insert_with(new_path).clone()
    }
}

/// Adds the shaders of a material. `image`: path of its image from the stage.
fn shaded(material: Prim, path: &str, color: &MaterialColor, image: Option<String>) -> Prim {
    let connected = |type_name: &str, name: &str, source: &str| {
        let source = Value::Paths(vec![format!("{path}/{source}")]);
        Property::declared(type_name, name).with("connectionPaths", source)
    };
    let shader = |name: &str, id: &str| {
        let prim = Prim::new("Shader", name, &mut Names::default());
        prim.uniform("token", "info:id", Value::Token(id.to_owned()))
    };
    let diffuse = match &image {
        Some(_) => connected("color3f", "inputs:diffuseColor", "Image.outputs:rgb"),
        None => Property::attribute("color3f", "inputs:diffuseColor", Value::Vector(color.diffuse)),
    };
    let surface = shader("Surface", "UsdPreviewSurface")
        .property(diffuse)
        .constant("float", "inputs:opacity", Value::Float(color.opacity))
        .property(Property::declared("token", "outputs:surface"));
    let mut material = material.property(connected("token", "outputs:surface", "Surface.outputs:surface"));
    material.children.push(surface);
    if let Some(image) = image {
        let wrap = |prim: Prim, name: &str| prim.constant("token", name, Value::Token("repeat".to_owned()));
        let texture = shader("Image", "UsdUVTexture")
            .constant("asset", "inputs:file", Value::Asset(image))
            .property(connected("float2", "inputs:st", "Coordinates.outputs:result"));
        let texture = wrap(wrap(texture, "inputs:wrapS"), "inputs:wrapT")
            .property(Property::declared("float3", "outputs:rgb"));
        let coordinates = shader("Coordinates", "UsdPrimvarReader_float2")
            .constant("string", "inputs:varname", Value::String("st".to_owned()))
            .property(Property::declared("float2", "outputs:result"));
        material.children.extend([texture, coordinates]);
    }
    material
}
