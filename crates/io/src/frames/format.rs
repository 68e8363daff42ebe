//! Defines the formats of frames.

use std::fmt;
use std::str::FromStr;

use serde::de::value::StrDeserializer;
use serde::de::{Deserializer, Error, SeqAccess, Visitor};
use serde::ser::Serializer;
use serde::{Deserialize, Serialize};

/// Format of frames. Displayed and parsed as `obj`, `ply`, `pc2`, `usd`, `html`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Format {
    /// Wavefront OBJ, one file per frame: the input with new positions and normals. The default.
    #[default]
    Obj,
    /// PLY, binary little endian, one file per frame. Faces are polygons if all have the same number of
    /// corners, otherwise triangles, because many readers require lists of equal length.
    Ply,
    /// Point Cache 2, one file per body.
    ///
    /// The program that loads the cache applies it to the *input* mesh. The points of the cache are all `v`
    /// of the OBJ file in file order, including unused ones. Load the input without reordering, merging or
    /// splitting vertices. The positions are in world space, in the axes of the scene. A program that rotates
    /// the input on import (y up to z up) must rotate the cache in the same way.
    Pc2,
    /// A USD stage with all bodies of a run, one binary file per run. [`Job`](crate::run::Job) writes it;
    /// [`FrameWriter`](super::FrameWriter), which writes one body, does not.
    Usd,
    /// A page for browsers with all bodies of a run, one file per run. [`Job`](crate::run::Job) writes it;
    /// [`FrameWriter`](super::FrameWriter), which writes one body, does not.
    Html,
}

impl Format {
    /// All formats.
    pub const ALL: [Self; 5] = [Self::Obj, Self::Ply, Self::Pc2, Self::Usd, Self::Html];

    /// Returns the name, which is also the file extension.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Obj => "obj",
            Self::Ply => "ply",
            Self::Pc2 => "pc2",
            Self::Usd => "usd",
            Self::Html => "html",
        }
    }

    /// Returns whether a file contains all bodies of a run.
    pub const fn is_per_run(self) -> bool {
        matches!(self, Self::Usd | Self::Html)
    }

    /// Returns whether the faces can change from one frame to the next, when a body breaks.
    pub const fn has_topology_per_frame(self) -> bool {
        !matches!(self, Self::Pc2)
    }

    /// Returns whether a file contains all frames.
    pub(crate) const fn is_per_sequence(self) -> bool {
        matches!(self, Self::Pc2 | Self::Usd | Self::Html)
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// Error: no [`Format`] has this name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown format `{0}`: it must be obj, ply, pc2, usd or html")]
pub struct UnknownFormat(pub String);

/// The formats of a run: at least one, each once. Displayed as `obj,html`; a scene has one name or a list of names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Formats(Vec<Format>);

impl Formats {
    /// Returns the formats without repetitions, or `None` if there is none.
    pub fn new(formats: impl IntoIterator<Item = Format>) -> Option<Self> {
        let mut unique = Vec::new();
        for format in formats {
            if !unique.contains(&format) {
                unique.push(format);
            }
        }
        (!unique.is_empty()).then_some(Self(unique))
    }

    /// Returns the formats in the order in which they were given.
    pub fn iter(&self) -> impl Iterator<Item = Format> + '_ {
        self.0.iter().copied()
    }

    /// Returns whether a format is one of these.
    pub fn contains(&self, format: Format) -> bool {
        self.0.contains(&format)
    }
}

impl From<Format> for Formats {
    fn from(format: Format) -> Self {
        Self(vec![format])
    }
}

impl Default for Formats {
    fn default() -> Self {
        Format::default().into()
    }
}

impl fmt::Display for Formats {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names: Vec<&str> = self.iter().map(Format::name).collect();
        f.pad(&names.join(","))
    }
}

impl Serialize for Formats {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match &self.0[..] {
            [format] => format.serialize(serializer),
            formats => formats.serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for Formats {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(FormatsVisitor)
    }
}

struct FormatsVisitor;

impl<'de> Visitor<'de> for FormatsVisitor {
    type Value = Formats;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a format like \"obj\", or a list like [\"obj\", \"html\"]")
    }

    fn visit_str<E: Error>(self, name: &str) -> Result<Formats, E> {
        Format::deserialize(StrDeserializer::new(name)).map(Formats::from)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Formats, A::Error> {
        let mut formats = Vec::new();
        while let Some(format) = list.next_element::<Format>()? {
            formats.push(format);
        }
        Formats::new(formats).ok_or_else(|| A::Error::custom("a list with at least one format"))
    }
}

impl FromStr for Format {
    type Err = UnknownFormat;

    fn from_str(name: &str) -> Result<Self, UnknownFormat> {
        Self::ALL
            .into_iter()
            .find(|format| format.name() == name)
            .ok_or_else(|| UnknownFormat(name.to_owned()))
    }
}
