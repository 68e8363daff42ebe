//! Reads the buffers of a file: the binary chunk, files beside it, and data in its JSON.

use std::path::{Path, PathBuf};

use ::gltf::Document;
use ::gltf::buffer::{Source, View};
use base64::Engine;
use base64::engine::general_purpose::{GeneralPurpose, GeneralPurposeConfig};
use base64::{alphabet, engine::DecodePaddingMode};

use super::super::error::{Fault, ModelError};
use super::super::surface::excerpt;
use crate::file;

/// The bytes of all buffers.
pub(super) struct Buffers {
    bytes: Vec<Vec<u8>>,
}

/// Reads base64 with and without padding.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &alphabet::STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

impl Buffers {
    /// Reads the buffers of the file at `path`, whose binary chunk is `chunk`.
    pub(super) fn read(path: &Path, document: &Document, chunk: Option<Vec<u8>>) -> Result<Self, ModelError> {
        let fault = |problem: String| ModelError::of(path, Fault(problem));
        let mut chunk = chunk;
        let mut bytes = Vec::new();
        for buffer in document.buffers() {
            let index = buffer.index();
            let data = match buffer.source() {
                Source::Bin => chunk.take().filter(|_| index == 0).ok_or_else(|| {
                    fault(format!(
                        "buffer {index} has no `uri`, and the file no binary chunk for it; export it again"
                    ))
                })?,
                Source::Uri(uri) if uri.starts_with("data:") => data_of(uri).ok_or_else(|| {
                    fault(format!("buffer {index}: the data in its `uri` are not base64; export it again"))
                })?,
                Source::Uri(uri) => {
                    let file = file_of(path, uri).ok_or_else(|| {
                        fault(format!(
                            "buffer {index} is at `{}`; save it beside the file, and write its name there",
                            excerpt(uri)
                        ))
                    })?;
                    file::read(&file, u64::MAX).map_err(|error| {
                        fault(format!(
                            "buffer {index}, the file {}, cannot be read: {error}; copy it there, or export the model as GLB",
                            excerpt(&file.display().to_string())
                        ))
                    })?
                }
            };
            if data.len() < buffer.length() {
                return Err(fault(format!(
                    "buffer {index} has {} bytes in place of {}; export or copy it again",
                    data.len(),
                    buffer.length()
                )));
            }
            bytes.push(data);
        }
        Ok(Self { bytes })
    }

    /// Returns the number of bytes of all buffers.
    pub(super) fn size(&self) -> usize {
        self.bytes.iter().map(Vec::len).sum()
    }

    /// Returns the bytes of a buffer.
    pub(super) fn get(&self, index: usize) -> Option<&[u8]> {
        self.bytes.get(index).map(Vec::as_slice)
    }

    /// Checks that a buffer contains a view, and the view `count` numbers of `size` bytes from `offset` on. `element`
    /// describes them in messages.
    pub(super) fn check(
        &self,
        view: &View<'_>,
        (offset, count, size): (usize, usize, usize),
        element: &str,
    ) -> Result<(), Fault> {
        let buffer = self.get(view.buffer().index()).map_or(0, <[u8]>::len);
        let fault = |end: Option<usize>, of: &str, length: usize| {
            let end = end.map_or("more than 64 bits can count".to_owned(), |end| end.to_string());
            Err(Fault(format!(
                "{element}: bytes up to {end} of {of} with {length}; export or copy the file again"
            )))
        };
        let end = view.offset().checked_add(view.length());
        if end.is_none_or(|end| end > buffer) {
            return fault(end, &format!("buffer {}", view.buffer().index()), buffer);
        }
        let stride = view.stride().unwrap_or(size);
        if stride < size {
            return Err(Fault(format!(
                "{element}: a stride of {stride} bytes for elements of {size}; export the file again"
            )));
        }
        let last = count.saturating_sub(1).checked_mul(stride);
        let end = last.and_then(|last| last.checked_add(size)?.checked_add(offset));
        if end.is_none_or(|end| end > view.length()) {
            return fault(end, &format!("buffer view {}", view.index()), view.length());
        }
        Ok(())
    }
}

/// Returns the paths of the buffers that are files.
pub(super) fn files(path: &Path, document: &Document) -> Vec<PathBuf> {
    let file = |buffer: ::gltf::Buffer<'_>| match buffer.source() {
        Source::Uri(uri) if !uri.starts_with("data:") => file_of(path, uri),
        _ => None,
    };
    document.buffers().filter_map(file).collect()
}

/// Returns the data in an address that starts with `data:`; `None` if they are not base64.
pub(super) fn data_of(uri: &str) -> Option<Vec<u8>> {
    let (_, text) = uri.split_once(";base64,")?;
    BASE64.decode(text).ok()
}

/// Returns the path of a file that a file at `path` refers to; `None` for an address with a scheme, such as `https:`.
pub(super) fn file_of(path: &Path, uri: &str) -> Option<PathBuf> {
    let scheme = uri.split_once(':').filter(|(scheme, _)| scheme.len() > 1 && !scheme.contains('/'));
    scheme.is_none().then(|| path.with_file_name("").join(percent_decoded(uri)))
}

/// Replaces `%20` and the like by the bytes that they stand for.
fn percent_decoded(uri: &str) -> String {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let [first, tail @ ..] = rest {
        let digits = tail.get(..2).and_then(|digits| std::str::from_utf8(digits).ok());
        match digits.filter(|_| *first == b'%').and_then(|digits| u8::from_str_radix(digits, 16).ok()) {
            Some(byte) => {
                bytes.push(byte);
                rest = &tail[2..];
            }
            None => {
                bytes.push(*first);
                rest = tail;
            }
        }
    }
    String::from_utf8(bytes).unwrap_or_else(|_| uri.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn relative_addresses_are_files_beside_the_model() {
        let at = |uri| file_of(Path::new("a/b.gltf"), uri);
        assert_eq!(at("my%20mesh%.bin"), Some("a/my mesh%.bin".into()));
        assert_eq!(at("c/d:e.bin"), Some("a/c/d:e.bin".into()));
        assert_eq!(at("https://example.org/b.bin"), None);
        assert_eq!(file_of(Path::new("b.gltf"), "b.bin"), Some("b.bin".into()));
    }
}
