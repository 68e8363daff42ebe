//! The materials and images of a file.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};
use supple::mesh::Mesh;

use crate::image::read_image;
use crate::obj::{Appearance, Document, MaterialColor, Part};

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

/// An image: its bytes and their type.
pub(super) struct Image {
    pub(super) bytes: Vec<u8>,
    pub(super) mime: &'static str,
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

    /// Returns the paths of the images, each once.
    fn image_paths(&self) -> Vec<&Path> {
        let mut paths = Vec::new();
        for (_, color) in &self.all {
            if let Some(path) = color.image.as_deref()
                && !paths.contains(&path)
            {
                paths.push(path);
            }
        }
        paths
    }

    /// Reads the images. Returns those that can be read and that glTF can have, PNG and JPEG, by their paths.
    pub(super) fn images(&self) -> Vec<(&Path, Image)> {
        let read = |path: &'_ Path| {
            let (kind, bytes) = read_image(path)?;
            let mime = kind.mime();
            let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            Some(Image { bytes, mime, name })
        };
        self.image_paths().into_iter().filter_map(|path| Some((path, read(path)?))).collect()
    }

    /// Returns the paths of images that [`Materials::images`] leaves out.
    pub(super) fn left_out(&self, images: &[(&Path, Image)]) -> Vec<PathBuf> {
        let is_left = |path: &&Path| !images.iter().any(|(known, _)| known == path);
        self.image_paths().into_iter().filter(is_left).map(Path::to_owned).collect()
    }

    /// Returns the JSON of the materials. The texture of an image has its index.
    pub(super) fn json(&self, images: &[(&Path, Image)]) -> Value {
        let material = |(Key { name, is_open, .. }, color): &(Key, MaterialColor)| {
            let MaterialColor { diffuse: [r, g, b], opacity, ref image } = *color;
            let texture =
                image.as_deref().and_then(|image| images.iter().position(|(path, _)| *path == image));
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

impl Image {
    /// Returns the JSON of the image in a buffer view.
    pub(super) fn json(&self, view: usize) -> Value {
        json!({ "name": self.name, "mimeType": self.mime, "bufferView": view })
    }
}
