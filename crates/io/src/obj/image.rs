//! Defines the images of materials.

use std::borrow::Cow;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::file;

/// Largest size of an image file, in bytes.
const MAX_IMAGE: u64 = 256 << 20;

/// Image of the color of a material.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Image {
    /// A file.
    File(PathBuf),
    /// The contents of an image inside of a model file.
    Embedded(Arc<EmbeddedImage>),
}

/// An image inside of a model file.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub struct EmbeddedImage {
    /// Index of the image in the model file.
    pub index: usize,
    /// Type of the contents.
    pub kind: ImageKind,
    /// Contents: those of a PNG or JPEG file.
    pub bytes: Vec<u8>,
}

/// Type of an image that glTF files can have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ImageKind {
    /// PNG.
    Png,
    /// JPEG.
    Jpeg,
}

impl ImageKind {
    /// Returns the type of the contents of a file; `None` for other types.
    pub fn of(bytes: &[u8]) -> Option<Self> {
        match bytes {
            [0x89, b'P', b'N', b'G', ..] => Some(Self::Png),
            [0xff, 0xd8, 0xff, ..] => Some(Self::Jpeg),
            _ => None,
        }
    }

    /// Returns the media type.
    pub const fn mime(self) -> &'static str {
        match self {
            Self::Png => "image/png",
            Self::Jpeg => "image/jpeg",
        }
    }

    /// Returns the extension of files.
    pub(crate) const fn extension(self) -> &'static str {
        match self {
            Self::Png => "png",
            Self::Jpeg => "jpg",
        }
    }
}

impl EmbeddedImage {
    /// Returns the name of the file with the image beside the frames of a body.
    pub(crate) fn file_name(&self, body: &str) -> String {
        format!("{body}_image{}.{}", self.index, self.kind.extension())
    }
}

/// Returns whether a file name can be that of an image of a model, beside the frames of a body.
pub(crate) fn is_image_name(name: &str, body: &str) -> bool {
    let rest = name.strip_prefix(body).and_then(|rest| rest.strip_prefix("_image"));
    let digits = rest.and_then(|rest| rest.strip_suffix(".png").or(rest.strip_suffix(".jpg")));
    digits.is_some_and(|digits| !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit()))
}

impl Image {
    /// Returns the path of the file with the image, for the frames of a body in a directory.
    pub(crate) fn path(&self, directory: &Path, body: &str) -> PathBuf {
        match self {
            Self::File(path) => path.clone(),
            Self::Embedded(image) => directory.join(image.file_name(body)),
        }
    }

    /// Reads the image. Returns its type and contents; `None` if it cannot be read, is neither PNG nor JPEG, or is
    /// larger than 256 MiB.
    pub(crate) fn read(&self) -> Option<(ImageKind, Cow<'_, [u8]>)> {
        match self {
            Self::File(path) => {
                let bytes = file::read(path, MAX_IMAGE).ok()?;
                Some((ImageKind::of(&bytes)?, bytes.into()))
            }
            Self::Embedded(image) => Some((image.kind, (&image.bytes[..]).into())),
        }
    }

    /// Returns the name of the image, without an extension.
    pub(crate) fn stem(&self) -> String {
        match self {
            Self::File(path) => path.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
            Self::Embedded(image) => format!("image{}", image.index),
        }
    }
}
