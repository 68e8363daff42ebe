//! Reads images for files that contain them.

use std::path::Path;

use crate::file;

/// Largest size of an image, in bytes.
const MAX_IMAGE: u64 = 256 << 20;

/// Types of images that all formats with images take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ImageType {
    Png,
    Jpeg,
}

impl ImageType {
    /// Returns the extension of files.
    pub(crate) fn extension(self) -> &'static str {
        match self {
            Self::Png => "png",
            Self::Jpeg => "jpg",
        }
    }

    /// Returns the media type.
    pub(crate) fn mime(self) -> &'static str {
        match self {
            Self::Png => "image/png",
            Self::Jpeg => "image/jpeg",
        }
    }
}

/// Reads an image. Returns its bytes; `None` if it cannot be read, is neither PNG nor JPEG, or is larger than 256 MiB.
pub(crate) fn read_image(path: &Path) -> Option<(ImageType, Vec<u8>)> {
    let bytes = file::read(path, MAX_IMAGE).ok()?;
    let kind = match bytes[..] {
        [0x89, b'P', b'N', b'G', ..] => ImageType::Png,
        [0xff, 0xd8, 0xff, ..] => ImageType::Jpeg,
        _ => return None,
    };
    Some((kind, bytes))
}
