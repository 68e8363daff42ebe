//! The file: its JSON, and then the binary chunk.
//!
//! ```text
//! offset  0   "glTF", u32 version 2, u32 size of the file
//!        12   u32 size, "JSON", the JSON, padded with spaces
//!             u32 size, "BIN\0", the arrays
//! ```
//!
//! The arrays are written first, block by block, because the JSON states their bounds.

use std::fs::File;
use std::io::{self, BufReader, ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use super::arrays::{Binary, BodyArrays, animation};
use super::colliders::{ColliderNode, ColliderSurface, bounds_of};
use super::layout::{Element, Layout, Usage};
use super::motion::{Motion, Pose};
use super::shown::ShownSamples;
use super::{BodyPoints, Materials, Samples};
use crate::collider::COLLIDERS;
use crate::space::FileSpace;

/// Size of what precedes the JSON, in bytes.
const BEFORE_JSON: u64 = 20;
/// Size of the header of a chunk, in bytes.
const CHUNK: u64 = 8;

/// What the file says of the run.
pub(crate) struct SceneDescription<'a> {
    /// Name of the run.
    pub(crate) name: &'a str,
    /// Time between frames, in seconds.
    pub(crate) interval: f64,
    /// Largest distance of a vertex from its place, relative to the size of its body.
    pub(crate) tolerance: f64,
    /// Facts for later runs of this program.
    pub(crate) extras: Value,
}

/// What was written of a body.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct WrittenMotion {
    /// Number of morph targets.
    pub(crate) targets: usize,
    /// Largest distance of a vertex from its place, relative to the size of the body.
    pub(crate) error: f64,
}

/// Writes a file. `spaces`: see [`ColliderSurface::push`]. Returns what was written of each body, and the paths of
/// images that glTF cannot have.
pub(crate) fn write_scene(
    out: &mut (impl Write + Seek),
    description: &SceneDescription<'_>,
    bodies: &[BodyPoints<'_>],
    (colliders, spaces): (&[ColliderSurface], [FileSpace; 2]),
    materials: &Materials,
    samples: &mut dyn Samples,
) -> io::Result<(Vec<WrittenMotion>, Vec<PathBuf>)> {
    let (mut samples, colliders) = ShownSamples::new(samples, colliders)?;
    let samples: &mut dyn Samples = &mut samples;
    let frames = samples.frames();
    let moved = colliders.iter().filter(|collider| !collider.is_animated);
    let bounds = match colliders[..] {
        [] => Default::default(),
        _ => bounds_of(samples, bodies.iter().map(BodyPoints::positions))?,
    };
    let nodes =
        moved.map(|collider| collider.node(samples, spaces, bounds)).collect::<io::Result<Vec<_>>>()?;
    let animated = colliders.iter().filter(|collider| collider.is_animated).map(|collider| collider.points());
    let shown = bodies.len();
    let bodies: Vec<BodyPoints<'_>> = bodies.iter().copied().chain(animated).collect();
    let split = |body: &BodyPoints<'_>| Motion::new(samples, body.positions(), description.tolerance);
    let motions = bodies.iter().map(split).collect::<io::Result<Vec<Motion>>>()?;
    let mut layout = Layout::default();
    let times = (frames > 1).then(|| layout.add_bounded(Element::Scalar, frames as u64, Usage::Other));
    let of_body = |(body, motion): (&BodyPoints<'_>, &Motion)| {
        let mut arrays = BodyArrays::new(body.surface, motion.components(), &mut layout);
        arrays.add_motion(motion, &mut layout);
        arrays
    };
    let mut arrays: Vec<BodyArrays> = bodies.iter().zip(&motions).map(of_body).collect();
    arrays.extend(nodes.iter().map(|node| {
        let mut arrays = BodyArrays::new(node.surface, 0, &mut layout);
        arrays.add_poses(&node.poses, &mut layout);
        arrays
    }));
    let of_bodies = || bodies.iter().zip(&motions).zip(&arrays);
    let of_body = |(mesh, (body, motion)): (usize, (&BodyPoints<'_>, &Motion))| {
        node_json(body.name, mesh, &motion.poses[0])
    };
    let of_node = |(index, node): (usize, &ColliderNode<'_>)| {
        let mut json = node_json(node.name, bodies.len() + index, &node.poses[0]);
        json["rotation"] = json!(<[f32; 4]>::from(node.poses[0].rotation.coords.cast::<f32>()));
        json
    };
    let mut all: Vec<Value> = bodies.iter().zip(&motions).enumerate().map(of_body).collect();
    all.extend(nodes.iter().enumerate().map(of_node));
    let mut roots: Vec<usize> = (0..shown).collect();
    if !colliders.is_empty() {
        roots.push(all.len());
        all.push(json!({ "name": COLLIDERS, "children": (shown..all.len()).collect::<Vec<_>>() }));
    }
    let names = bodies.iter().map(|body| body.name).chain(nodes.iter().map(|node| node.name));
    let mut root = json!({
        "asset": { "extras": description.extras },
        "scenes": [{ "name": description.name, "nodes": roots }],
        "nodes": all,
        "meshes": arrays.iter().zip(names).map(|(arrays, name)| arrays.mesh(name)).collect::<Vec<_>>(),
    });
    if let Some(times) = times {
        root["animations"] = json!([animation(description.name, times, &arrays)]);
    }
    let left_out = write_file(out, root, layout, materials, |file| {
        if let Some(times) = times {
            let second = |frame: usize| (frame as f64 * description.interval) as f32;
            file.write(times, 0, &(0..frames).map(second).collect::<Vec<f32>>())?;
        }
        of_bodies().try_for_each(|((body, motion), arrays)| {
            arrays.write_surface(file, body.surface)?;
            arrays.write_motion(file, motion, samples)
        })?;
        let of_colliders = arrays[bodies.len()..].iter().zip(&nodes);
        of_colliders.into_iter().try_for_each(|(arrays, node)| arrays.write_collider(file, node))
    })?;
    let written = motions[..shown].iter().map(|motion| WrittenMotion {
        targets: motion.components(),
        error: if motion.size > 0.0 { motion.error / motion.size } else { 0.0 },
    });
    Ok((written.collect(), left_out))
}

/// Returns the node of a mesh without its rotation. `pose`: that of the first frame.
fn node_json(name: &str, mesh: usize, pose: &Pose) -> Value {
    let translation = <[f32; 3]>::from(pose.translation.cast::<f32>());
    let mut node = json!({ "name": name, "mesh": mesh, "translation": translation });
    if !pose.is_shown {
        node["scale"] = json!([0.0, 0.0, 0.0]);
    }
    node
}

/// Writes a file with a body as it is in the first frame. `texels`: second texture coordinates of each vertex, with the
/// origin at the upper left. Returns the paths of images that glTF cannot have.
pub(crate) fn write_still(
    out: &mut (impl Write + Seek),
    body: &BodyPoints<'_>,
    texels: &[[f32; 2]],
    materials: &Materials,
    samples: &mut dyn Samples,
) -> io::Result<Vec<PathBuf>> {
    let &BodyPoints { name, surface, .. } = body;
    let mut layout = Layout::default();
    let mut arrays = BodyArrays::new(surface, 0, &mut layout);
    arrays.add_texels(surface, &mut layout);
    let root = json!({
        "asset": {},
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "name": name, "mesh": 0 }],
        "meshes": [arrays.mesh(name)],
    });
    write_file(out, root, layout, materials, |file| {
        arrays.write_surface(file, surface)?;
        let mut vectors = Vec::new();
        samples.read(0, body.positions(), &mut vectors)?;
        file.write(arrays.positions, 0, vectors.as_flattened())?;
        samples.read(0, body.normals(), &mut vectors)?;
        file.write(arrays.normals, 0, vectors.as_flattened())?;
        arrays.texels.map_or(Ok(()), |array| file.write(array, 0, texels.as_flattened()))
    })
}

/// Writes a file from its JSON without arrays and materials. `write` writes the arrays. Returns the paths of images that
/// glTF cannot have.
fn write_file<W: Write + Seek>(
    out: &mut W,
    mut root: Value,
    mut layout: Layout,
    materials: &Materials,
    write: impl FnOnce(&mut Binary<'_, W>) -> io::Result<()>,
) -> io::Result<Vec<PathBuf>> {
    let images = materials.images();
    let views: Vec<(usize, u64)> =
        images.iter().map(|image| layout.add_bytes(image.bytes.len() as u64, Usage::Other)).collect();
    root["asset"]["version"] = json!("2.0");
    root["asset"]["generator"] = json!(concat!("supple ", env!("CARGO_PKG_VERSION")));
    root["scene"] = json!(0);
    root["materials"] = materials.json(&images);
    if !images.is_empty() {
        root["images"] = images.iter().zip(&views).map(|(image, (view, _))| image.json(*view)).collect();
        root["samplers"] = json!([{ "wrapS": 10497, "wrapT": 10497 }]);
        root["textures"] = (0..images.len()).map(|image| json!({ "source": image, "sampler": 0 })).collect();
    }
    let mut json = |layout: &Layout| {
        layout.add_to(&mut root);
        serde_json::to_vec(&root).map_err(io::Error::from)
    };
    let json_bytes = json(&layout)?.len().next_multiple_of(4) as u64;
    let start = BEFORE_JSON + json_bytes + CHUNK;
    let total = start + layout.bytes();
    let Ok(total) = u32::try_from(total) else {
        return Err(io::Error::other(format!(
            "it would have {total} bytes, and GLB files have at most 4294967295: raise `output.glb_error`, or write \
             fewer frames with --every"
        )));
    };

    let mut file = Binary { out, start, layout };
    write(&mut file)?;
    for (image, (_, at)) in images.iter().zip(&views) {
        file.write_bytes(*at, &image.bytes)?;
        file.write_bytes(at + image.bytes.len() as u64, &[0; 3][..image.bytes.len().wrapping_neg() % 4])?;
    }
    let Binary { out, layout, .. } = file;
    let mut json = json(&layout)?;
    json.resize(json_bytes as usize, b' ');
    out.seek(SeekFrom::Start(0))?;
    out.write_all(b"glTF")?;
    for number in [2, total, json_bytes as u32] {
        out.write_all(&number.to_le_bytes())?;
    }
    out.write_all(b"JSON")?;
    out.write_all(&json)?;
    out.write_all(&(layout.bytes() as u32).to_le_bytes())?;
    out.write_all(b"BIN\0")?;
    Ok(materials.left_out(&images))
}

/// Returns the facts for later runs of a file; `None` if it is no complete file of this program.
pub(crate) fn read_extras(path: &Path) -> io::Result<Option<Value>> {
    let mut file = BufReader::new(File::open(path)?);
    let size = file.get_ref().metadata()?.len();
    let mut head = [0; BEFORE_JSON as usize];
    match file.read_exact(&mut head) {
        Err(error) if error.kind() == ErrorKind::UnexpectedEof => return Ok(None),
        result => result?,
    }
    let word = |at: usize| u32::from_le_bytes(std::array::from_fn(|byte| head[at + byte]));
    if &head[..4] != b"glTF" || word(4) != 2 || u64::from(word(8)) != size || &head[16..] != b"JSON" {
        return Ok(None);
    }
    let root: Option<Value> = serde_json::from_reader(file.take(word(12).into())).ok();
    Ok(root.and_then(|root| root.pointer("/asset/extras").cloned()))
}
