//! Films: moving pictures of a motion, rendered on the processor.
//!
//! ```text
//! footage -> moments, frame by frame -> camera: where all of them are
//!                                    -> pictures -> patches: what changes -> WebP or GIF
//! ```
//!
//! * `moment`: what a picture shows, and where it comes from;
//! * `camera`: direction and place of the camera;
//! * `raster`: fills triangles into a grid;
//! * `light`: shadows, and the light of the sky;
//! * `shade`: colors;
//! * `render`: renders a frame;
//! * `patch`: the part of a picture that changes;
//! * `webp`, `gif`: the files.
//!
//! A picture does not depend on the number of threads: a thread renders whole pictures.

mod camera;
mod gif;
mod light;
mod moment;
mod patch;
mod raster;
mod render;
mod shade;
mod webp;
mod write;

use serde::{Deserialize, Serialize};

pub(crate) use moment::{Color, Footage, Moment, PlaneAt, Solid, Surface, Tint};
pub(crate) use write::{read_facts, write_film};

/// Smallest and largest side of a picture, in pixels.
pub(crate) const SIDES: [u32; 2] = [16, 4096];

/// What the colors of bodies show. In scenes `material` or `volume`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Coloring {
    /// The `Kd` of the materials of a model, and for faces without one a color per body. The default.
    #[default]
    Material,
    /// The volume: blue as at rest, red from an error of 20 % on.
    Volume,
}

impl Coloring {
    /// Returns the name.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Material => "material",
            Self::Volume => "volume",
        }
    }
}

/// How a film looks.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct FilmOptions {
    /// Width and height in pixels, in [16, 4096]; default 800 x 600.
    pub size: [u32; 2],
    /// Direction from the bodies to the camera, in the axes of the files, not zero; `None`, the default, is from the front,
    /// the right and above.
    pub view: Option<[f64; 3]>,
    /// What the colors of bodies show.
    pub coloring: Coloring,
}

impl Default for FilmOptions {
    fn default() -> Self {
        Self { size: [800, 600], view: None, coloring: Coloring::default() }
    }
}

/// The file format of a film.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FilmFile {
    Webp,
    Gif,
}

/// A picture: red, green and blue, sRGB, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
struct Picture {
    /// Width and height in pixels.
    size: [u32; 2],
    pixels: Vec<[u8; 3]>,
}
