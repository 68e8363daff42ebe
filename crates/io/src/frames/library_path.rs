//! Rewrites the paths of material libraries (`mtllib`) so that they are correct relative to the directory of
//! the frames. Writes the library of a model whose materials are not in OBJ libraries, and the images inside of a model.

use std::ffi::OsString;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use super::{OutputError, Sequence};
use crate::file::{self, write_atomically, write_durably};
use crate::obj::{Document, Image, Library, is_image_name, library_text};
use crate::path::{relative, resolve, resolve_directory};

/// Returns the bytes that replace the path of `library` in a frame. The input file is in the directory
/// `input`, and the frames are in the directory `output`. Returns `None` if the path stays correct: it is
/// absolute, or relative to `output` it leads to the same file.
pub(super) fn rewritten(library: &Library, input: &Path, output: &Path) -> Option<Vec<u8>> {
    if Path::new(&library.name).is_absolute() || has_drive(&library.name) {
        return None;
    }
    let target = resolve(&library.path);
    let from_output = output.join(library.path.strip_prefix(input).unwrap_or(&library.path));
    if resolve(&from_output) == target {
        return None;
    }
    Some(bytes(&relative(&target, &resolve_directory(output))))
}

/// Returns the name of the library that is written beside the frames of a body; `None` if the model has no materials
/// besides those of OBJ libraries.
pub(super) fn own_library(document: &Document, body: &str) -> Option<String> {
    (!document.own_materials().is_empty()).then(|| format!("{body}_frames.mtl"))
}

/// Writes the library of [`own_library`] to the directory of a sequence.
pub(super) fn write_own_library(document: &Document, sequence: &Sequence) -> Result<(), OutputError> {
    let Some(name) = own_library(document, &sequence.name) else { return Ok(()) };
    let path = sequence.directory.join(name);
    let text = library_text(document.own_materials(), &sequence.directory, &sequence.name);
    write_images(document, &sequence.directory, &sequence.name)?;
    write_atomically(&path, |file| file.write_all(text.as_bytes())).map_err(OutputError::io("write", &path))
}

/// Writes the images inside of a model beside the frames of a body, which refer to them.
pub(super) fn write_images(document: &Document, directory: &Path, body: &str) -> Result<(), OutputError> {
    for (_, color) in document.own_materials() {
        let Some(Image::Embedded(image)) = &color.image else { continue };
        let path = directory.join(image.file_name(body));
        // Several materials can have an image, and several formats write it.
        if file::read(&path, image.bytes.len() as u64).is_ok_and(|found| found == image.bytes) {
            continue;
        }
        write_durably(&path, |file| file.write_all(&image.bytes)).map_err(OutputError::io("write", &path))?;
    }
    Ok(())
}

/// Returns the paths of the images in a directory that [`write_images`] writes, by body and sorted.
pub(crate) fn written_images(directory: &Path, bodies: &[&str]) -> Vec<Vec<PathBuf>> {
    let entries = fs::read_dir(directory).into_iter().flatten().flatten();
    let mut names: Vec<String> = entries.filter_map(|entry| entry.file_name().into_string().ok()).collect();
    names.retain(|name| name.contains("_image") && bodies.iter().any(|body| is_image_name(name, body)));
    names.sort();
    let of_body = |body: &&str| {
        names.iter().filter(|name| is_image_name(name, body)).map(|name| directory.join(name)).collect()
    };
    bodies.iter().map(of_body).collect()
}

/// Returns whether `name` starts with a drive (`C:\...`). `Path` recognizes drives on Windows only.
fn has_drive(name: &str) -> bool {
    matches!(name.as_bytes(), [letter, b':', ..] if letter.is_ascii_alphabetic())
}

/// Returns the bytes of a path in a text file: the same bytes on Unix, UTF-8 elsewhere.
fn bytes(path: &OsString) -> Vec<u8> {
    #[cfg(unix)]
    {
        use std::os::unix::ffi::OsStrExt;
        path.as_bytes().to_vec()
    }
    #[cfg(not(unix))]
    {
        path.to_string_lossy().into_owned().into_bytes()
    }
}
