//! Defines the settings of single formats.

use crate::film::FilmOptions;
use crate::vat::VatEncoding;

/// Settings of single formats, which change nothing in files of other ones.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct FormatOptions {
    /// Meters per unit of length of the file, above 0, which USD stages state and GLB files have as lengths; default 1.
    pub meters_per_unit: f64,
    /// Largest distance of a vertex of a GLB file from its place, relative to the size of its body, in [0, 1]; default
    /// 0.001.
    pub glb_error: f64,
    /// Encoding of the images of vertex animation textures; default PNG.
    pub vat_encoding: VatEncoding,
    /// Whether a USD stage has the velocities of its points, for motion blur; default false.
    pub usd_velocities: bool,
    /// Look of a film.
    pub film: FilmOptions,
}

impl Default for FormatOptions {
    fn default() -> Self {
        Self {
            meters_per_unit: 1.0,
            glb_error: 1e-3,
            vat_encoding: VatEncoding::default(),
            usd_velocities: false,
            film: FilmOptions::default(),
        }
    }
}
