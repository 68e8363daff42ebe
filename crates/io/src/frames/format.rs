//! The formats that frames are written in.

use std::fmt;
use std::str::FromStr;

/// A format of frames. Shown and read as `obj`, `ply`, `pc2`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Format {
    /// Wavefront OBJ, one file a frame: the input with new positions and normals. The default.
    #[default]
    Obj,
    /// PLY, binary little endian, one file a frame: polygons where all have the same number of corners, else their
    /// triangles, as many readers take lists of one length only.
    Ply,
    /// Point Cache 2, one file a body.
    ///
    /// A reader applies it to the *input* mesh: it must have the same number of points in the same order (all `v` of
    /// an OBJ file, those that no face uses included), loaded without reordering, merging or splitting vertices. The
    /// positions are in world space, in the axes of the scene: a program that turns the input on import (y up to z
    /// up) must turn the cache likewise.
    Pc2,
}

impl Format {
    /// All formats.
    pub const ALL: [Self; 3] = [Self::Obj, Self::Ply, Self::Pc2];

    /// The name, which is also the ending of the files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Obj => "obj",
            Self::Ply => "ply",
            Self::Pc2 => "pc2",
        }
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// A name that no [`Format`] has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown format `{0}`: it must be obj, ply or pc2")]
pub struct UnknownFormat(pub String);

impl FromStr for Format {
    type Err = UnknownFormat;

    fn from_str(name: &str) -> Result<Self, UnknownFormat> {
        Self::ALL
            .into_iter()
            .find(|format| format.name() == name)
            .ok_or_else(|| UnknownFormat(name.to_owned()))
    }
}
