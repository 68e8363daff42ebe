//! The materials and images of a file.

use std::borrow::Cow;
use std::collections::HashMap;
use std::path::PathBuf;

use serde_json::{Value, json};
use supple::mesh::Mesh;

use crate::obj::{Appearance, Document, Image, ImageKind, MaterialColor, Part};

/// What tells materials apart.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Key {
    /// The file that has it; `None` for the default material.
    file: Option<PathBuf>,
    /// Its name in the file.
    name: String,
    /// Whether it shows both sides.
    is_open: bool,
    /// Whether its faces have texture coordinates, without which it has no image.
    has_textures: bool,
}

/// The materials that bodies use.
#[derive(Debug, Default)]
pub(crate) struct Materials {
    index: HashMap<Key, usize>,
    all: Vec<(Key, MaterialColor)>,
}

/// The contents of an image.
pub(super) struct ImageContents<'a> {
    /// The image of materials.
    image: &'a Image,
    pub(super) bytes: Cow<'a, [u8]>,
    kind: ImageKind,
    name: String,
}

impl Materials {
    /// Returns the indices of the materials of a body, with their faces.
    pub(super) fn of_body<'a>(
        &mut self,
        mesh: &Mesh,
        file: Option<(&Document, &Part)>,
        appearance: &'a Appearance,
    ) -> Vec<(usize, &'a [u32])> {
        let Some((document, _)) = file.filter(|_| !appearance.materials.is_empty()) else {
            return Vec::new();
        };
        let mut colors = document.material_colors();
        let has_textures = !appearance.corners.is_empty();
        let mut index = |(name, faces): &'a (String, Vec<u32>)| {
            let (file, is_open) = (Some(document.path().to_owned()), !mesh.is_closed());
            let mut color = colors.remove(name).unwrap_or_default();
            color.image.take_if(|_| !has_textures);
            (self.add(Key { file, name: name.clone(), is_open, has_textures }, color), &faces[..])
        };
        appearance.materials.iter().map(&mut index).collect()
    }

    /// Returns the index of the material of faces without one.
    pub(super) fn default_of(&mut self, mesh: &Mesh) -> usize {
        let name = "default".to_owned();
        let key = Key { file: None, name, is_open: !mesh.is_closed(), has_textures: false };
        self.add(key, MaterialColor::default())
    }

    fn add(&mut self, key: Key, color: MaterialColor) -> usize {
        let Self { index, all } = self;
        *index.entry(key).or_insert_with_key(|key| {
            all.push((key.clone(), color));
            all.len() - 1
        })
    }

    /// Returns the images of materials, each once.
    fn used_images(&self) -> Vec<&Image> {
        let mut images = Vec::new();
        for image in self.all.iter().filter_map(|(_, color)| color.image.as_ref()) {
            if !images.contains(&image) {
                images.push(image);
            }
        }
        images
    }

    /// Reads the images. Returns those that can be read and that glTF can have, PNG and JPEG.
    pub(super) fn images(&self) -> Vec<ImageContents<'_>> {
        self.used_images().into_iter().filter_map(ImageContents::read).collect()
    }

    /// Returns the paths of images that [`Materials::images`] leaves out.
    pub(super) fn left_out(&self, images: &[ImageContents<'_>]) -> Vec<PathBuf> {
        let path = |image: &Image| match image {
            Image::File(path) if !images.iter().any(|known| known.image == image) => Some(path.clone()),
            _ => None,
        };
        self.used_images().into_iter().filter_map(path).collect()
    }

    /// Returns the JSON of the materials. The texture of an image has its index.
    pub(super) fn json(&self, images: &[ImageContents<'_>]) -> Value {
        let material = |(Key { name, is_open, .. }, color): &(Key, MaterialColor)| {
            let MaterialColor { diffuse: [r, g, b], opacity, ref image } = *color;
            let texture =
                image.as_ref().and_then(|image| images.iter().position(|known| known.image == image));
            let mut base = json!({ "metallicFactor": 0.0, "roughnessFactor": 0.6 });
            match texture {
                Some(index) => {
                    base["baseColorFactor"] = json!([1.0, 1.0, 1.0, opacity]);
                    base["baseColorTexture"] = json!({ "index": index });
                }
                None => base["baseColorFactor"] = json!([r, g, b, opacity]),
            }
            let mut material = json!({ "name": name, "pbrMetallicRoughness": base });
            if opacity < 1.0 {
                material["alphaMode"] = json!("BLEND");
            }
            if *is_open {
                material["doubleSided"] = json!(true);
            }
            material
        };
        self.all.iter().map(material).collect()
    }
}

impl<'a> ImageContents<'a> {
    /// Reads an image; `None` if it cannot be read, or is neither PNG nor JPEG.
    fn read(image: &'a Image) -> Option<Self> {
        let (kind, bytes) = image.read()?;
        Some(Self { image, kind, bytes, name: image.stem() })
    }

    /// Returns the JSON of the image in a buffer view.
    pub(super) fn json(&self, view: usize) -> Value {
        json!({ "name": self.name, "mimeType": self.kind.mime(), "bufferView": view })
    }
}
