//! The file: its JSON, and then the binary chunk.
//!
//! ```text
//! offset  0   "glTF", u32 version 2, u32 size of the file
//!        12   u32 size, "JSON", the JSON, padded with spaces
//!             u32 size, "BIN\0", the arrays
//! ```
//!
//! The arrays are written first, block by block, because the JSON states their bounds.

use std::io::{self, Read, Seek, SeekFrom, Write};
use std::ops::Range;
use std::path::PathBuf;

use serde_json::{Value, json};

use super::layout::{Array, Element, Layout, Usage};
use super::motion::Motion;
use super::{Materials, Samples, SplitSurface};

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

/// A body, and its points among the samples: positions, then as many normals.
pub(crate) struct BodyMotion<'a> {
    pub(crate) name: &'a str,
    pub(crate) surface: &'a SplitSurface,
    /// The positions.
    pub(crate) points: Range<usize>,
}

/// What was written of a body.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct WrittenMotion {
    /// Number of morph targets.
    pub(crate) targets: usize,
    /// Largest distance of a vertex from its place, relative to the size of the body.
    pub(crate) error: f64,
}

/// The arrays of a body.
struct BodyArrays {
    positions: Array,
    normals: Array,
    coordinates: Option<Array>,
    /// The corners of the triangles of each material.
    corners: Vec<(usize, Array)>,
    /// The displacements of positions and of normals of each morph target.
    targets: Vec<[Array; 2]>,
    /// Translations, rotations and weights of the frames, those that change.
    motion: Vec<(&'static str, Array)>,
}

/// Writes a file. Returns what was written of each body, and the paths of images that glTF cannot have.
pub(crate) fn write_scene(
    out: &mut (impl Write + Seek),
    description: &SceneDescription<'_>,
    bodies: &[BodyMotion<'_>],
    materials: &Materials,
    samples: &mut dyn Samples,
) -> io::Result<(Vec<WrittenMotion>, Vec<PathBuf>)> {
    let frames = samples.frames();
    let split = |body: &BodyMotion<'_>| Motion::new(samples, body.points.clone(), description.tolerance);
    let motions = bodies.iter().map(split).collect::<io::Result<Vec<Motion>>>()?;
    let mut layout = Layout::default();
    let times = (frames > 1).then(|| layout.add_bounded(Element::Scalar, frames as u64, Usage::Other));
    let arrays: Vec<BodyArrays> = bodies
        .iter()
        .zip(&motions)
        .map(|(body, motion)| BodyArrays::new(body.surface, motion, frames, &mut layout))
        .collect();
    let images = materials.images();
    let views: Vec<(usize, u64)> =
        images.iter().map(|(_, image)| layout.add_bytes(image.bytes.len() as u64, Usage::Other)).collect();

    let json = |layout: &Layout| {
        let mut root = json!({
            "asset": { "version": "2.0", "generator": concat!("supple ", env!("CARGO_PKG_VERSION")),
                       "extras": description.extras },
            "scene": 0,
            "scenes": [{ "name": description.name, "nodes": (0..bodies.len()).collect::<Vec<_>>() }],
            "materials": materials.json(&images),
        });
        let of_bodies = || bodies.iter().zip(&motions).zip(&arrays);
        root["nodes"] =
            of_bodies().enumerate().map(|(index, ((body, motion), _))| node(body, motion, index)).collect();
        root["meshes"] = of_bodies().map(|((body, _), arrays)| arrays.mesh(body.name)).collect();
        if let Some(times) = times {
            root["animations"] = json!([animation(description.name, times, &arrays)]);
        }
        if !images.is_empty() {
            root["images"] =
                images.iter().zip(&views).map(|((_, image), (view, _))| image.json(*view)).collect();
            root["samplers"] = json!([{ "wrapS": 10497, "wrapT": 10497 }]);
            root["textures"] =
                (0..images.len()).map(|image| json!({ "source": image, "sampler": 0 })).collect();
        }
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
    if let Some(times) = times {
        let seconds: Vec<f32> =
            (0..frames).map(|frame| (frame as f64 * description.interval) as f32).collect();
        file.write(times, 0, &seconds)?;
    }
    for ((body, motion), arrays) in bodies.iter().zip(&motions).zip(&arrays) {
        arrays.write(&mut file, body.surface, motion, samples)?;
    }
    for ((_, image), (_, at)) in images.iter().zip(&views) {
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
    let written = motions.iter().map(|motion| WrittenMotion {
        targets: motion.components(),
        error: if motion.size > 0.0 { motion.error / motion.size } else { 0.0 },
    });
    Ok((written.collect(), materials.left_out(&images)))
}

/// Returns the facts for later runs of a file; `None` if it is no file of this program.
pub(crate) fn read_extras(file: &mut impl Read) -> Option<Value> {
    let mut head = [0; BEFORE_JSON as usize];
    file.read_exact(&mut head).ok()?;
    let word = |at: usize| u32::from_le_bytes(std::array::from_fn(|byte| head[at + byte]));
    if &head[..4] != b"glTF" || word(4) != 2 || &head[16..] != b"JSON" {
        return None;
    }
    let root: Value = serde_json::from_reader(file.take(word(12).into())).ok()?;
    root.pointer("/asset/extras").cloned()
}

/// A file whose arrays are written.
struct Binary<'a, W> {
    out: &'a mut W,
    /// Offset of the first array in the file.
    start: u64,
    layout: Layout,
}

impl<W: Write + Seek> Binary<'_, W> {
    /// Writes numbers of an array from an offset in it on, in bytes.
    fn write(&mut self, array: Array, offset: u64, numbers: &[f32]) -> io::Result<()> {
        self.layout.include(array, numbers);
        let bytes: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
        self.write_bytes(array.at + offset, &bytes)
    }

    fn write_bytes(&mut self, at: u64, bytes: &[u8]) -> io::Result<()> {
        self.out.seek(SeekFrom::Start(self.start + at))?;
        self.out.write_all(bytes)
    }
}

impl BodyArrays {
    fn new(surface: &SplitSurface, motion: &Motion, frames: usize, layout: &mut Layout) -> Self {
        let (count, frames) = (surface.len() as u64, frames as u64);
        let mut vectors = |is_bounded: bool| {
            let add = if is_bounded { Layout::add_bounded } else { Layout::add };
            add(layout, Element::Vector(3), count, Usage::Vertices)
        };
        let (positions, normals) = (vectors(true), vectors(false));
        let targets = (0..motion.components()).map(|_| [vectors(true), vectors(false)]).collect();
        let coordinates =
            (!surface.coordinates.is_empty()).then(|| layout.add(Element::Vector(2), count, Usage::Vertices));
        let corners = surface.primitives.iter().map(|(&material, corners)| {
            (material, layout.add(Element::Index, corners.len() as u64, Usage::Corners))
        });
        let corners = corners.collect();
        let numbers = [
            ("translation", Element::Vector(3), frames),
            ("rotation", Element::Vector(4), frames),
            ("weights", Element::Scalar, frames * motion.components() as u64),
        ];
        let numbers = numbers.into_iter().filter(|&(_, _, count)| frames > 1 && count > 0);
        let motion =
            numbers.map(|(path, element, count)| (path, layout.add(element, count, Usage::Other))).collect();
        Self { positions, normals, coordinates, corners, targets, motion }
    }

    /// Writes the arrays.
    fn write<W: Write + Seek>(
        &self,
        file: &mut Binary<'_, W>,
        surface: &SplitSurface,
        motion: &Motion,
        samples: &mut dyn Samples,
    ) -> io::Result<()> {
        if let Some(coordinates) = self.coordinates {
            file.write(coordinates, 0, surface.coordinates.as_flattened())?;
        }
        for ((_, array), corners) in self.corners.iter().zip(surface.primitives.values()) {
            let bytes: Vec<u8> = corners.iter().flat_map(|corner| corner.to_le_bytes()).collect();
            file.write_bytes(array.at, &bytes)?;
        }
        for block in motion.blocks() {
            let offset = 12 * block.start as u64;
            let [positions, normals] = motion.base(samples, block.clone())?;
            file.write(self.positions, offset, positions.as_flattened())?;
            file.write(self.normals, offset, normals.as_flattened())?;
            let displacements = motion.displacements(samples, block)?;
            for (component, target) in self.targets.iter().enumerate() {
                for (array, displacements) in target.iter().zip(&displacements) {
                    let numbers: Vec<f32> = displacements.row(component).iter().copied().collect();
                    file.write(*array, offset, &numbers)?;
                }
            }
        }
        let poses = motion.poses.iter();
        for &(path, array) in &self.motion {
            // One frame after another.
            let numbers: Vec<f32> = match path {
                "translation" => {
                    poses.clone().flat_map(|pose| <[f32; 3]>::from(pose.translation.cast::<f32>())).collect()
                }
                "rotation" => poses
                    .clone()
                    .flat_map(|pose| <[f32; 4]>::from(pose.rotation.coords.cast::<f32>()))
                    .collect(),
                _ => motion.weights.transpose().as_slice().to_vec(),
            };
            file.write(array, 0, &numbers)?;
        }
        Ok(())
    }

    fn mesh(&self, name: &str) -> Value {
        let mut attributes = json!({ "POSITION": self.positions.accessor, "NORMAL": self.normals.accessor });
        if let Some(coordinates) = self.coordinates {
            attributes["TEXCOORD_0"] = json!(coordinates.accessor);
        }
        let target = |[positions, normals]: &[Array; 2]| json!({ "POSITION": positions.accessor, "NORMAL": normals.accessor });
        let targets: Vec<Value> = self.targets.iter().map(target).collect();
        let primitive = |(material, corners): &(usize, Array)| {
            let mut primitive = json!({
                "attributes": attributes, "indices": corners.accessor, "material": material,
            });
            if !targets.is_empty() {
                primitive["targets"] = json!(targets);
            }
            primitive
        };
        let mut mesh =
            json!({ "name": name, "primitives": self.corners.iter().map(primitive).collect::<Vec<_>>() });
        if !targets.is_empty() {
            let names: Vec<String> = (1..=targets.len()).map(|number| format!("motion {number}")).collect();
            mesh["weights"] = json!(vec![0.0; targets.len()]);
            mesh["extras"] = json!({ "targetNames": names });
        }
        mesh
    }
}

fn node(body: &BodyMotion<'_>, motion: &Motion, mesh: usize) -> Value {
    let translation = <[f32; 3]>::from(motion.poses[0].translation.cast::<f32>());
    json!({ "name": body.name, "mesh": mesh, "translation": translation })
}

/// Returns the animation of all nodes.
fn animation(name: &str, times: Array, bodies: &[BodyArrays]) -> Value {
    let (mut samplers, mut channels) = (Vec::new(), Vec::new());
    for (node, arrays) in bodies.iter().enumerate() {
        for &(path, array) in &arrays.motion {
            channels.push(json!({ "sampler": samplers.len(), "target": { "node": node, "path": path } }));
            samplers.push(json!({ "input": times.accessor, "output": array.accessor }));
        }
    }
    json!({ "name": name, "samplers": samplers, "channels": channels })
}
