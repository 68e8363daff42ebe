//! Reads the colors of materials from the libraries (`.mtl`) of a file.

use std::collections::BTreeMap;
use std::path::PathBuf;

use super::Document;
use super::lines::{Statements, Words, decode};
use crate::file;

/// Color of a material.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct MaterialColor {
    /// Diffuse color (`Kd`), linear, each component in [0, 1].
    pub diffuse: [f32; 3],
    /// Opacity (`d`, or 1 - `Tr`), in [0, 1].
    pub opacity: f32,
    /// Image of the diffuse color (`map_Kd`), if the file exists.
    pub image: Option<PathBuf>,
}

impl Default for MaterialColor {
    /// The color of a material of which no library tells one: gray.
    fn default() -> Self {
        Self { diffuse: [0.5; 3], opacity: 1.0, image: None }
    }
}

/// Returns the name of the material of the caps of a body: of the surfaces of its cracks.
pub(crate) fn cap_material(body: &str) -> String {
    format!("{body}_cap")
}

/// Largest size of a library that is read, in bytes.
const MAX_SIZE: u64 = 32 << 20;

impl Document {
    /// Returns the materials of the libraries, by name. The first definition of a name counts. Libraries that cannot
    /// be read have no materials: colors are not needed to run a scene.
    pub fn material_colors(&self) -> BTreeMap<String, MaterialColor> {
        let mut materials = BTreeMap::new();
        for library in self.libraries().into_iter().filter(|library| library.exists) {
            let Ok(bytes) = file::read(&library.path, MAX_SIZE) else { continue };
            let directory = library.path.parent().map(PathBuf::from).unwrap_or_default();
            for (name, color) in parse(&bytes, |image| {
                let path = directory.join(image);
                path.is_file().then_some(path)
            }) {
                materials.entry(name).or_insert(color);
            }
        }
        materials
    }
}

/// Parses a library. `find` returns the path of an image if it exists.
fn parse(raw: &[u8], find: impl Fn(&str) -> Option<PathBuf>) -> Vec<(String, MaterialColor)> {
    let mut materials: Vec<(String, MaterialColor)> = Vec::new();
    for statement in Statements::new(raw) {
        let mut words = Words::new(raw, &statement.bytes);
        let Some(keyword) = words.next() else { continue };
        let text = decode(&raw[words.clone().rest()]).into_owned();
        let numbers: Vec<f32> = text.split_whitespace().map_while(|word| word.parse().ok()).collect();
        let fraction = |number: &f32| number.clamp(0.0, 1.0);
        if &raw[keyword.clone()] == b"newmtl" {
            materials.push((text, MaterialColor::default()));
            continue;
        }
        let Some((_, material)) = materials.last_mut() else { continue };
        match (&raw[keyword], &numbers[..]) {
            // One number is a gray.
            (b"Kd", [gray]) => material.diffuse = [fraction(gray); 3],
            (b"Kd", [r, g, b, ..]) => material.diffuse = [r, g, b].map(fraction),
            (b"d", [opacity, ..]) => material.opacity = fraction(opacity),
            (b"Tr", [transparency, ..]) => material.opacity = 1.0 - fraction(transparency),
            // Options such as `-s 2 2 1` precede the name.
            (b"map_Kd", _) => {
                material.image = find(&text).or_else(|| find(text.split_whitespace().last()?));
            }
            _ => {}
        }
        if material.diffuse.iter().any(|number| number.is_nan()) || material.opacity.is_nan() {
            let image = material.image.take();
            *material = MaterialColor { image, ..MaterialColor::default() };
        }
    }
    materials
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colors_opacities_and_images_are_read() {
        let text = "Kd 1 1 1\nnewmtl red paint\nNs 3\nKd 0.5 0 2\nd 0.25\nmap_Kd -s 2 2 1 red.png\n\
                    newmtl gray\nKd 0.25\nTr 0.25\nmap_Kd my image.png\nnewmtl nan\nKd nan 0 0\nnewmtl none\nKd a\n";
        let exists = |name: &str| ["red.png", "my image.png"].contains(&name).then(|| name.into());
        let color = |diffuse, opacity, image: Option<&str>| MaterialColor {
            diffuse,
            opacity,
            image: image.map(PathBuf::from),
        };
        let expected = [
            ("red paint", color([0.5, 0.0, 1.0], 0.25, Some("red.png"))),
            ("gray", color([0.25; 3], 0.75, Some("my image.png"))),
            ("nan", MaterialColor::default()),
            ("none", MaterialColor::default()),
        ];
        assert_eq!(parse(text.as_bytes(), exists), expected.map(|(name, color)| (name.to_owned(), color)));
    }
}
