//! Defines the formats of frames.

use std::fmt;
use std::str::FromStr;

use serde::de::value::StrDeserializer;
use serde::de::{Deserializer, Error, SeqAccess, Visitor};
use serde::ser::Serializer;
use serde::{Deserialize, Serialize};

use crate::count::alternatives;

/// Format of frames. Displayed and parsed by its name: `obj`, `ply`, `pc2`, `usd`, `usdz`, `html`, `glb`, `vat`, `vtu`,
/// `lattice`, `film`, `gif`.
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
    /// A USDZ package, a USD stage with its images in one file per run. [`Job`](crate::run::Job) writes it;
    /// [`FrameWriter`](super::FrameWriter), which writes one body, does not.
    Usdz,
    /// A page for browsers with all bodies of a run, one file per run. [`Job`](crate::run::Job) writes it;
    /// [`FrameWriter`](super::FrameWriter), which writes one body, does not.
    Html,
    /// A GLB file with all bodies of a run as nodes with morph targets, one file per run. [`Job`](crate::run::Job) writes
    /// it; [`FrameWriter`](super::FrameWriter), which writes one body, does not.
    Glb,
    /// Vertex animation textures in the layout of OpenVAT, one folder per body, `NAME_vat`. [`Job`](crate::run::Job)
    /// writes them; [`FrameWriter`](super::FrameWriter), which writes frames without knowing their number, does not.
    Vat,
    /// VTU, an unstructured grid of VTK with the faces and normals of the surface, one file per frame, and `NAME.pvd` with
    /// their times.
    Vtu,
    /// VTU with the cells of the lattice as hexahedra, one file per frame, and `NAME.lattice.pvd` with their times. The
    /// cells have the greatest principal strain, the ratio of their volume to that at rest and Young's modulus, and the
    /// vertices their velocities.
    Lattice,
    /// A moving picture with all bodies and colliders of a run, animated WebP, one file per run. [`Job`](crate::run::Job)
    /// writes it; [`FrameWriter`](super::FrameWriter), which writes one body, does not.
    Film,
    /// As [`Format::Film`], an animated GIF.
    Gif,
}

/// What the files of a sequence contain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Contents {
    /// A file has one frame of one body.
    Frame,
    /// A file has all frames of one body.
    Body,
    /// A file has all frames of all bodies.
    Run,
}

/// What the names and the frames of a format are.
struct Facts {
    name: &'static str,
    /// The extension of the files, if it is not the name.
    extension: &'static str,
    /// A line about its files.
    about: &'static str,
    contents: Contents,
    /// Whether the faces can change from one frame to the next, when a body breaks.
    has_topology_per_frame: bool,
    /// What is appended to the name of a file with all frames while frames are added to it, before `.part`.
    data: &'static str,
}

impl Format {
    /// Returns the entry of the format in the table.
    const fn facts(self) -> &'static Facts {
        const FRAME: Facts = Facts {
            name: "",
            extension: "",
            about: "",
            contents: Contents::Frame,
            has_topology_per_frame: true,
            data: "",
        };
        const RUN: Facts = Facts { contents: Contents::Run, ..FRAME };
        match self {
            Self::Obj => &Facts { name: "obj", about: "One Wavefront OBJ file per frame and body", ..FRAME },
            Self::Ply => &Facts { name: "ply", about: "One binary PLY file per frame and body", ..FRAME },
            Self::Pc2 => &Facts {
                name: "pc2",
                about: "One PC2 point cache per body",
                contents: Contents::Body,
                has_topology_per_frame: false,
                ..FRAME
            },
            Self::Usd => &Facts { name: "usd", about: "A USD stage, supple.usd, with all bodies", ..RUN },
            Self::Usdz => &Facts {
                name: "usdz",
                about: "A USD stage with its images in one file, supple.usdz",
                data: ".usd",
                ..RUN
            },
            Self::Html => &Facts {
                name: "html",
                about: "A page for browsers, supple.html, with all bodies",
                data: ".data",
                ..RUN
            },
            Self::Glb => &Facts {
                name: "glb",
                about: "An animated GLB file, supple.glb, with all bodies",
                has_topology_per_frame: false,
                data: ".pc2",
                ..RUN
            },
            Self::Vat => &Facts {
                name: "vat",
                about: "Vertex animation textures, a folder per body",
                contents: Contents::Body,
                has_topology_per_frame: false,
                data: ".pc2",
                ..FRAME
            },
            Self::Vtu => {
                &Facts { name: "vtu", about: "One VTU file per frame and body, for ParaView", ..FRAME }
            }
            Self::Lattice => &Facts {
                name: "lattice",
                extension: "lattice.vtu",
                about: "One VTU file with the cells of the lattice per frame and body",
                ..FRAME
            },
            Self::Film => &Facts {
                name: "film",
                extension: "webp",
                about: "A moving picture, supple.webp, with all bodies",
                data: ".data",
                ..RUN
            },
            Self::Gif => &Facts {
                name: "gif",
                about: "A moving picture, supple.gif, with all bodies",
                data: ".data",
                ..RUN
            },
        }
    }

    /// All formats.
    pub const ALL: [Self; 12] = [
        Self::Obj,
        Self::Ply,
        Self::Pc2,
        Self::Usd,
        Self::Usdz,
        Self::Html,
        Self::Glb,
        Self::Vat,
        Self::Vtu,
        Self::Lattice,
        Self::Film,
        Self::Gif,
    ];

    /// Returns the name.
    pub const fn name(self) -> &'static str {
        self.facts().name
    }

    /// Returns the format of a file with all bodies of a run, by its extension.
    pub(crate) fn of_recording(extension: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|format| format.is_per_run() && format.extension() == extension)
    }

    /// Returns the extension of the files.
    pub(super) const fn extension(self) -> &'static str {
        let Facts { name, extension, .. } = self.facts();
        if extension.is_empty() { name } else { extension }
    }

    /// Returns a line about its files.
    pub const fn about(self) -> &'static str {
        self.facts().about
    }

    /// Returns whether a file contains all bodies of a run.
    pub const fn is_per_run(self) -> bool {
        matches!(self.facts().contents, Contents::Run)
    }

    /// Returns whether the faces can change from one frame to the next, when a body breaks.
    pub const fn has_topology_per_frame(self) -> bool {
        self.facts().has_topology_per_frame
    }

    /// Returns whether the files can only be written when all frames are known, and no frames can be added to them.
    pub(crate) const fn needs_all_frames(self) -> bool {
        matches!(self, Self::Usdz | Self::Glb | Self::Vat | Self::Film | Self::Gif)
    }

    /// Returns whether images inside of models are written beside the frames, which refer to them.
    pub(crate) const fn has_image_files(self) -> bool {
        matches!(self, Self::Obj | Self::Usd)
    }

    /// Returns what is appended to the name of a file with all frames while frames are added to it, before `.part`.
    pub(super) const fn data(self) -> &'static str {
        self.facts().data
    }

    /// Returns whether a file contains all frames.
    pub(crate) const fn is_per_sequence(self) -> bool {
        !matches!(self.facts().contents, Contents::Frame)
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// Returns the names of formats, as alternatives.
pub(crate) fn names(formats: impl IntoIterator<Item = Format>) -> String {
    alternatives(&formats.into_iter().map(Format::name).collect::<Vec<_>>())
}

/// Error: no [`Format`] has this name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown format `{0}`: it must be {names}", names = names(Format::ALL))]
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
