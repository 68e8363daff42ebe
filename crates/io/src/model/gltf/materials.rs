//! The materials of a file as those of OBJ libraries, with the images that are files or in buffers.

use std::collections::{HashMap, HashSet};
use std::path::Path;
use std::sync::Arc;

use ::gltf::json::{self, Root};
use ::gltf::material::AlphaMode;
use ::gltf::{Material, Texture};

use super::super::surface::plain_name;
use super::buffers::{Buffers, data_of, file_of};
use crate::obj::{EmbeddedImage, Image, ImageKind, MaterialColor};

/// The materials that primitives use.
pub(super) struct Materials<'a> {
    /// Path of the file.
    path: &'a Path,
    /// The JSON of the file and its buffers.
    root: &'a Root,
    buffers: &'a Buffers,
    /// Images that were found, by their index in the file: the contents of each are kept once.
    found: HashMap<usize, Option<Image>>,
    /// Index of each material, by its index in the file.
    index: HashMap<usize, usize>,
    names: HashSet<String>,
    /// Names and colors.
    pub(super) all: Vec<(String, MaterialColor)>,
    /// Number of images of colors that are missing, or neither PNG nor JPEG.
    pub(super) images: usize,
}

impl<'a> Materials<'a> {
    pub(super) fn new(path: &'a Path, root: &'a Root, buffers: &'a Buffers) -> Self {
        let (index, found, names) = (HashMap::new(), HashMap::new(), HashSet::new());
        Self { path, root, buffers, found, index, names, all: Vec::new(), images: 0 }
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

    /// Returns the image of a texture. `Image::source` of the crate panics at an image with neither a `uri` nor a type.
    fn image(&mut self, texture: &Texture<'_>) -> Option<Image> {
        let &mut Self { path, root, buffers, .. } = self;
        let index = texture.source()?.index();
        let read = || {
            let image = root.images.get(index)?;
            let embedded = |bytes: Vec<u8>| {
                let kind = ImageKind::of(&bytes)?;
                Some(Image::Embedded(Arc::new(EmbeddedImage { index, kind, bytes })))
            };
            match image.uri.as_deref() {
                Some(uri) if uri.starts_with("data:") => embedded(data_of(uri)?),
                Some(uri) => file_of(path, uri).filter(|path| path.is_file()).map(Image::File),
                None => embedded(in_view(root, buffers, image)?.to_vec()),
            }
        };
        self.found.entry(index).or_insert_with(read).clone()
    }
}

/// Returns the contents of an image that is in a buffer view; `None` if the buffer does not contain the view.
fn in_view<'a>(root: &Root, buffers: &'a Buffers, image: &json::Image) -> Option<&'a [u8]> {
    let view = root.buffer_views.get(image.buffer_view?.value())?;
    let start = view.byte_offset.map_or(0, |offset| offset.0 as usize);
    let end = start.checked_add(view.byte_length.0 as usize)?;
    buffers.get(view.buffer.value())?.get(start..end)
}
