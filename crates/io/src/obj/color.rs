//! Colors of materials, and their text as a library (`.mtl`).

use std::fmt::Write;
use std::path::Path;

use super::Image;
use crate::path::{relative, resolve, resolve_directory};

/// Color of a material.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct MaterialColor {
    /// Diffuse color (`Kd`), linear, each component in [0, 1].
    pub diffuse: [f32; 3],
    /// Opacity (`d`, or 1 - `Tr`), in [0, 1].
    pub opacity: f32,
    /// Image of the diffuse color (`map_Kd`), if there is one that can be read.
    pub image: Option<Image>,
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

/// Returns the text of a library in `directory` with the materials of a body.
pub(crate) fn library_text(materials: &[(String, MaterialColor)], directory: &Path, body: &str) -> String {
    let mut text = String::new();
    for (name, MaterialColor { diffuse: [r, g, b], opacity, image }) in materials {
        // Writing to a string does not fail.
        let _ = write!(text, "newmtl {name}\nKd {r} {g} {b}\nd {opacity}\n");
        if let Some(image) = image {
            let image = relative(&resolve(&image.path(directory, body)), &resolve_directory(directory));
            let _ = writeln!(text, "map_Kd {}", image.display());
        }
    }
    text
}
