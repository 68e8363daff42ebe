//! Defines the encodings of images.

use serde::{Deserialize, Serialize};

/// Encoding of the images of vertex animation textures: `output.vat_encoding` of a scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum VatEncoding {
    /// PNG with 16 bits per number. The default.
    #[default]
    Png,
    /// OpenEXR with numbers of 32 bits with a floating point.
    Exr,
}

impl VatEncoding {
    /// All encodings.
    pub const ALL: [Self; 2] = [Self::Png, Self::Exr];

    /// Returns the name, which is also the extension of the images.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Png => "png",
            Self::Exr => "exr",
        }
    }

    /// Returns a line about the images.
    pub const fn about(self) -> &'static str {
        match self {
            Self::Png => "PNG with 16 bits per number",
            Self::Exr => "OpenEXR with floating-point numbers of 32 bits",
        }
    }
}
