//! The materials of a file as those of OBJ libraries.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

use ::gltf::json::Image;
use ::gltf::material::AlphaMode;
use ::gltf::{Material, Texture};

use super::super::surface::plain_name;
use super::buffers::file_of;
use crate::obj::MaterialColor;

/// The materials that primitives use.
pub(super) struct Materials<'a> {
    /// Path of the file.
    path: &'a Path,
    /// The images of the file.
    in_file: &'a [Image],
    /// Index of each material, by its index in the file.
    index: HashMap<usize, usize>,
    names: HashSet<String>,
    /// Names and colors.
    pub(super) all: Vec<(String, MaterialColor)>,
    /// Number of images of colors that are in buffers or missing.
    pub(super) images: usize,
}

impl<'a> Materials<'a> {
    pub(super) fn new(path: &'a Path, in_file: &'a [Image]) -> Self {
        Self { path, in_file, index: HashMap::new(), names: HashSet::new(), all: Vec::new(), images: 0 }
    }

    /// Returns the index of a material; `None` for the default material.
    pub(super) fn index(&mut self, material: &Material<'_>) -> Option<usize> {
        let in_file = material.index()?;
        let next = self.all.len();
        let index = *self.index.entry(in_file).or_insert(next);
        if index == next {
            let name = plain_name(material.name().unwrap_or_default());
            let name = if name.is_empty() { format!("material {in_file}") } else { name };
            let name = if self.names.contains(&name) { format!("{name} {in_file}") } else { name };
            self.names.insert(name.clone());
            let color = self.color(material);
            self.all.push((name, color));
        }
        Some(index)
    }

    fn color(&mut self, material: &Material<'_>) -> MaterialColor {
        let base = material.pbr_metallic_roughness();
        let [r, g, b, alpha] =
            base.base_color_factor().map(|x| if x.is_finite() { x.clamp(0.0, 1.0) } else { 1.0 });
        let opacity = if material.alpha_mode() == AlphaMode::Opaque { 1.0 } else { alpha };
        let texture = base.base_color_texture().map(|texture| texture.texture());
        let image = texture.as_ref().and_then(|texture| self.image(texture));
        self.images += usize::from(texture.is_some() && image.is_none());
        MaterialColor { diffuse: [r, g, b], opacity, image }
    }

    /// Returns the path of the image of a texture if it is a file. `Image::source` of the crate panics at an image with
    /// neither a `uri` nor a type.
    fn image(&self, texture: &Texture<'_>) -> Option<PathBuf> {
        let uri = self.in_file.get(texture.source()?.index())?.uri.as_deref()?;
        file_of(self.path, uri).filter(|path| path.is_file())
    }
}
