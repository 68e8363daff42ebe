//! Writes the motion of a body as a vertex animation texture, in the layout of OpenVAT: a folder `NAME_vat` with
//!
//! ```text
//! NAME.glb               the mesh of the first frame; the second texture coordinates of a vertex are its texel there
//! NAME_vat.png           offsets of the vertices from the first frame, in PNG or as NAME_vat.exr in OpenEXR
//! NAME_vnrm.png          normals
//! NAME-remap_info.json   the smallest and the largest offset, and the number of frames
//! ```
//!
//! An image in PNG has 16 bits per number, and one in OpenEXR 32 bits with a floating point; the numbers are the same.
//! A vertex has a column, and the frames are its rows from the top down; if there are more vertices than columns,
//! further blocks of as many rows follow. Offsets and normals are in the axes of Blender, z up: a player turns (x, y,
//! z) to (x, z, -y). An offset is `Min + texel (Max - Min)`, a normal `2 texel - 1`.

mod encoding;
mod image;
mod layout;

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde_json::{Value, json};

use crate::file::{parent, remove_if_present, write_durably};
use crate::glb::{BodyPoints, Materials, Samples, write_still};

pub use encoding::VatEncoding;
pub(crate) use layout::{MAX_SIZE, TexelLayout};

/// Returns the paths of the files of the folder `NAME_vat` in a directory before the last one: the mesh, the offsets, the
/// normals.
fn files(folder: &Path, name: &str, encoding: VatEncoding) -> [PathBuf; 3] {
    let image = encoding.name();
    [".glb".to_owned(), format!("_vat.{image}"), format!("_vnrm.{image}")]
        .map(|suffix| folder.join(format!("{name}{suffix}")))
}

/// Returns the paths of the files of a folder, with the images that exist, or else those of the default encoding. The last
/// one, at `info`, says what the others are.
pub(crate) fn existing_files(info: &Path, name: &str) -> Vec<PathBuf> {
    let of = |encoding: &VatEncoding| files(parent(info), name, *encoding);
    let is_there = |encoding: &&VatEncoding| of(encoding)[1..].iter().any(|image| image.is_file());
    let encoding = VatEncoding::ALL.iter().find(is_there).copied().unwrap_or_default();
    of(&encoding).into_iter().chain([info.to_owned()]).collect()
}

/// Writes the folder of a body, and removes images of other encodings. Its last file, which says what the others are,
/// is at `info`. Returns the paths of images that glTF cannot have.
///
/// * `fps`, `extras`: the frames per second, and facts for later runs of this program.
pub(crate) fn write_textures(
    info: &Path,
    body: &BodyPoints<'_>,
    encoding: VatEncoding,
    (fps, extras): (f64, Value),
    materials: &Materials,
    samples: &mut dyn Samples,
) -> io::Result<Vec<PathBuf>> {
    let folder = parent(info);
    let (name, vertices, frames) = (body.name, body.surface.len(), samples.frames());
    let layout = TexelLayout::new(vertices, frames)
        .ok_or_else(|| io::Error::other(format!("{vertices} x {frames} texels do not fit into an image")))?;
    let [mesh, offsets, normals] = files(folder, name, encoding);
    let texels: Vec<[f32; 2]> = (0..vertices).map(|vertex| layout.coordinates(vertex)).collect();
    let mut left_out = Vec::new();
    write_durably(&mesh, |file| {
        left_out = write_still(file, body, &texels, materials, samples)?;
        Ok(())
    })?;
    let points = body.positions();
    let (low, high) = image::bounds(samples, &points)?;
    let mut write = |path: &Path, numbers: &image::Numbers<'_>| {
        write_durably(path, |file: &mut File| {
            let mut out = BufWriter::new(file);
            image::write(&mut out, encoding, layout, samples, numbers)?;
            out.flush()
        })
    };
    write(&offsets, &image::Numbers::Offsets { points: &points, low, high })?;
    write(&normals, &image::Numbers::Normals { points: &body.normals() })?;
    for other in VatEncoding::ALL.into_iter().filter(|other| *other != encoding) {
        // Those of an earlier run.
        files(folder, name, other)[1..].iter().try_for_each(|image| remove_if_present(image).map(drop))?;
    }
    let facts = json!({
        "os-remap": { "Min": low, "Max": high, "Frames": frames },
        "supple": { "name": name, "encoding": encoding, "fps": fps, "bytes": sizes(folder, name, encoding)?, "run": extras },
    });
    write_durably(info, |file| serde_json::to_writer_pretty(file, &facts).map_err(Into::into))?;
    Ok(left_out)
}

/// Returns the sizes of the files of a folder before the last one, in bytes.
fn sizes(folder: &Path, name: &str, encoding: VatEncoding) -> io::Result<Vec<u64>> {
    files(folder, name, encoding).iter().map(|path| Ok(fs::metadata(path)?.len())).collect()
}

/// Returns the facts for later runs of a folder, whose last file is at `info`; `None` if it is of another program, or the
/// other files have other sizes.
pub(crate) fn read_extras(info: &Path) -> io::Result<Option<Value>> {
    let text = fs::read(info)?;
    let Ok(facts) = serde_json::from_slice::<Value>(&text) else { return Ok(None) };
    let facts = &facts["supple"];
    let name = facts["name"].as_str().unwrap_or_default();
    let Ok(encoding) = VatEncoding::deserialize(&facts["encoding"]) else { return Ok(None) };
    let is_whole = sizes(parent(info), name, encoding).is_ok_and(|sizes| facts["bytes"] == json!(sizes));
    Ok(is_whole.then(|| facts["run"].clone()))
}
