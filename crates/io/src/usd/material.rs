//! Prims of materials.

use std::collections::BTreeMap;
use std::path::Path;

use super::name::Names;
use super::prim::{Prim, Property, Value};
use crate::obj::MaterialColor;
use crate::path::{relative, resolve, resolve_directory};

/// The materials of a stage.
pub(super) struct Materials<'a> {
    /// Path of the prim that has them.
    path: &'a str,
    /// Directory of the stage.
    directory: &'a Path,
    names: Names,
    pub(super) prims: Vec<Prim>,
    /// Paths of the prims by file and name.
    known: BTreeMap<(&'a Path, String), String>,
}

impl<'a> Materials<'a> {
    pub(super) fn new(path: &'a str, directory: &'a Path) -> Self {
        Self { path, directory, names: Names::default(), prims: Vec::new(), known: BTreeMap::new() }
    }

    /// Returns the path of the prim of a material of an OBJ file, which a body uses.
    pub(super) fn path_of(
        &mut self,
        file: &'a Path,
        name: &str,
        color: &MaterialColor,
        body: &str,
    ) -> String {
        let Self { path, directory, names, prims, known } = self;
        let new_path = || {
            let prim = Prim::new("Material", name, names);
            let path = format!("{path}/{}", prim.name);
            prims.push(shaded(prim, &path, color, (directory, body)));
            path
        };
        known.entry((file, name.to_owned())).or_insert_with(new_path).clone()
    }
}

/// Adds the shaders of a material. `directory`, `body`: the directory of the stage, and the body with the material.
fn shaded(material: Prim, path: &str, color: &MaterialColor, (directory, body): (&Path, &str)) -> Prim {
    let connected = |type_name: &str, name: &str, source: &str| {
        let source = Value::Paths(vec![format!("{path}/{source}")]);
        Property::declared(type_name, name).with("connectionPaths", source)
    };
    let shader = |name: &str, id: &str| {
        let prim = Prim::new("Shader", name, &mut Names::default());
        prim.uniform("token", "info:id", Value::Token(id.to_owned()))
    };
    let image = color.image.as_ref().and_then(|image| {
        let image = relative(&resolve(&image.path(directory, body)), &resolve_directory(directory));
        // USD paths have slashes on all systems. A name alone would be searched in the paths of the program.
        let image = image.to_str()?.replace('\\', "/");
        Some(if image.starts_with(['.', '/']) { image } else { format!("./{image}") })
    });
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
