//! Reads the colors of materials from the libraries (`.mtl`) of a file, with obj-rs.

use std::collections::BTreeMap;
use std::path::PathBuf;

use ::obj::raw::material::{Material, MtlColor, MtlTextureMap, RawMtl, parse_mtl};

use super::color::MaterialColor;
use super::lines::{self, Words, decode};
use super::{Document, Image};
use crate::file;

/// Largest size of a library that is read, in bytes.
const MAX_SIZE: u64 = 32 << 20;

impl Document {
    /// Returns the materials of the libraries, by name. The first definition of a name counts. Libraries that cannot
    /// be read have no materials: colors are not needed to run a scene. A file of another format has materials of its own.
    pub fn material_colors(&self) -> BTreeMap<String, MaterialColor> {
        let mut materials: BTreeMap<_, _> = self.own_materials().iter().cloned().collect();
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

/// The statements of a library that colors depend on, as a text that obj-rs reads.
///
/// obj-rs refuses a whole library for one statement that it does not know, for a name with spaces and for further
/// numbers at the end of a line, and it adds statements before the first `newmtl` to the first material. So the text has
/// only complete statements of materials, and each name in it is the index of the name in `names`.
#[derive(Default)]
struct Statements {
    text: String,
    /// Names of materials and of images, decoded.
    names: Vec<String>,
}

impl Statements {
    fn new(raw: &[u8]) -> Self {
        let mut found = Self::default();
        for statement in lines::Statements::new(raw) {
            let mut words = Words::new(raw, &statement.bytes);
            let Some(keyword) = words.next() else { continue };
            let rest = decode(&raw[words.rest()]);
            let numbers = rest.split_whitespace().take_while(|word| word.parse::<f32>().is_ok());
            let numbers: Vec<&str> = numbers.collect();
            match (&raw[keyword], &numbers[..]) {
                (b"newmtl", _) => found.push_name("newmtl", &rest),
                _ if found.names.is_empty() => {}
                (b"map_Kd", _) => found.push_name("map_Kd", &rest),
                (b"Kd", [gray]) => found.push("Kd", gray),
                (b"Kd", [r, g, b, ..]) => found.push("Kd", &format!("{r} {g} {b}")),
                (b"d", [opacity, ..]) => found.push("d", opacity),
                (b"Tr", [transparency, ..]) => found.push("Tr", transparency),
                _ => {}
            }
        }
        found
    }

    fn push(&mut self, keyword: &str, values: &str) {
        self.text.extend([keyword, " ", values, "\n"]);
    }

    fn push_name(&mut self, keyword: &str, name: &str) {
        self.push(keyword, &self.names.len().to_string());
        self.names.push(name.to_owned());
    }
}

/// Parses a library. `find` returns the path of an image if it exists.
fn parse(raw: &[u8], find: impl Fn(&str) -> Option<PathBuf>) -> Vec<(String, MaterialColor)> {
    let Statements { text, names } = Statements::new(raw);
    let Ok(RawMtl { materials }) = parse_mtl(text.as_bytes()) else { return Vec::new() };
    let image = |map: &MtlTextureMap| {
        let name = names.get(map.file.parse::<usize>().ok()?)?;
        // Options such as `-s 2 2 1` precede the name.
        find(name).or_else(|| find(name.split_whitespace().last()?))
    };
    let color = |material: &Material| {
        let default = MaterialColor::default();
        let diffuse = match material.diffuse {
            Some(MtlColor::Rgb(r, g, b)) => [r, g, b].map(|number| number.clamp(0.0, 1.0)),
            _ => default.diffuse,
        };
        let opacity = material.dissolve.map_or(default.opacity, |number| number.clamp(0.0, 1.0));
        let image = material.diffuse_map.as_ref().and_then(image).map(Image::File);
        if diffuse.iter().chain([&opacity]).any(|number| number.is_nan()) {
            return MaterialColor { image, ..default };
        }
        MaterialColor { diffuse, opacity, image }
    };
    let named =
        |(index, name): (usize, &String)| Some((name.clone(), color(materials.get(&index.to_string())?)));
    names.iter().enumerate().filter_map(named).collect()
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
            image: image.map(|name| Image::File(name.into())),
        };
        let expected = [
            ("red paint", color([0.5, 0.0, 1.0], 0.25, Some("red.png"))),
            ("gray", color([0.25; 3], 0.75, Some("my image.png"))),
            ("nan", MaterialColor::default()),
            ("none", MaterialColor::default()),
        ];
        assert_eq!(parse(text.as_bytes(), exists), expected.map(|(name, color)| (name.to_owned(), color)));
    }

    #[test]
    fn statements_that_obj_rs_refuses_change_nothing_else() {
        let text = b"d 0.1\nnewmtl a\r\nKd 1 0 0.5 0.25 x\nKd xyz 1 1 1\nKd 1 1\nd 0.5 % half\nd -halo 0.5\nKm 1\nrefl x\n\
                     disp x y\nillum two\nbump\nnewmtl\nKd 1 #\nnewmtl \xe9t\xe9\nTr -1 \nmap_Kd\nnewmtl a\nKd 0\n\\";
        let color = |diffuse, opacity| MaterialColor { diffuse, opacity, image: None };
        let expected = [
            ("a", color([1.0, 0.0, 0.5], 0.5)),
            ("", color([1.0; 3], 1.0)),
            ("\u{e9}t\u{e9}", MaterialColor::default()),
            ("a", color([0.0; 3], 1.0)),
        ];
        assert_eq!(parse(text, |_| None), expected.map(|(name, color)| (name.to_owned(), color)));
    }
}
