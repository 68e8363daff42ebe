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
use std::ops::Range;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use super::layout::{Array, Element, Layout, Usage};
use super::motion::{Motion, Vectors};
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
pub(crate) struct BodyPoints<'a> {
    pub(crate) name: &'a str,
    pub(crate) surface: &'a SplitSurface,
    /// The first position.
    pub(crate) first: usize,
}

impl BodyPoints<'_> {
    /// Returns the positions.
    pub(crate) fn positions(&self) -> Range<usize> {
        self.first..self.first + self.surface.len()
    }

    /// Returns the normals.
    pub(crate) fn normals(&self) -> Range<usize> {
        let first = self.positions().end;
        first..first + self.surface.len()
    }
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
    /// Second texture coordinates.
    texels: Option<Array>,
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
    bodies: &[BodyPoints<'_>],
    materials: &Materials,
    samples: &mut dyn Samples,
) -> io::Result<(Vec<WrittenMotion>, Vec<PathBuf>)> {
    let frames = samples.frames();
    let split = |body: &BodyPoints<'_>| Motion::new(samples, body.positions(), description.tolerance);
    let motions = bodies.iter().map(split).collect::<io::Result<Vec<Motion>>>()?;
    let mut layout = Layout::default();
    let times = (frames > 1).then(|| layout.add_bounded(Element::Scalar, frames as u64, Usage::Other));
    let of_body = |(body, motion): (&BodyPoints<'_>, &Motion)| {
        let mut arrays = BodyArrays::new(body.surface, motion.components(), &mut layout);
        arrays.add_motion(motion, &mut layout);
        arrays
    };
    let arrays: Vec<BodyArrays> = bodies.iter().zip(&motions).map(of_body).collect();
    let of_bodies = || bodies.iter().zip(&motions).zip(&arrays);
    let node = |(mesh, ((body, motion), _)): (usize, ((&BodyPoints<'_>, &Motion), &BodyArrays))| {
        let translation = <[f32; 3]>::from(motion.poses[0].translation.cast::<f32>());
        json!({ "name": body.name, "mesh": mesh, "translation": translation })
    };
    let mut root = json!({
        "asset": { "extras": description.extras },
        "scenes": [{ "name": description.name, "nodes": (0..bodies.len()).collect::<Vec<_>>() }],
        "nodes": of_bodies().enumerate().map(node).collect::<Vec<_>>(),
        "meshes": of_bodies().map(|((body, _), arrays)| arrays.mesh(body.name)).collect::<Vec<_>>(),
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
        })
    })?;
    let written = motions.iter().map(|motion| WrittenMotion {
        targets: motion.components(),
        error: if motion.size > 0.0 { motion.error / motion.size } else { 0.0 },
    });
    Ok((written.collect(), left_out))
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
    /// Adds the arrays of a surface with a number of morph targets.
    fn new(surface: &SplitSurface, targets: usize, layout: &mut Layout) -> Self {
        let count = surface.len() as u64;
        let mut vectors = |is_bounded: bool| {
            let add = if is_bounded { Layout::add_bounded } else { Layout::add };
            add(layout, Element::Vector(3), count, Usage::Vertices)
        };
        let (positions, normals) = (vectors(true), vectors(false));
        let targets = (0..targets).map(|_| [vectors(true), vectors(false)]).collect();
        let coordinates =
            (!surface.coordinates.is_empty()).then(|| layout.add(Element::Vector(2), count, Usage::Vertices));
        let corners = surface.primitives.iter().map(|(&material, corners)| {
            (material, layout.add(Element::Index, corners.len() as u64, Usage::Corners))
        });
        let corners = corners.collect();
        Self { positions, normals, coordinates, texels: None, corners, targets, motion: Vec::new() }
    }

    /// Adds the arrays of the frames.
    fn add_motion(&mut self, motion: &Motion, layout: &mut Layout) {
        let frames = motion.poses.len() as u64;
        let numbers = [
            ("translation", Element::Vector(3), frames),
            ("rotation", Element::Vector(4), frames),
            ("weights", Element::Scalar, frames * motion.components() as u64),
        ];
        let numbers = numbers.into_iter().filter(|&(_, _, count)| frames > 1 && count > 0);
        let add = |(path, element, count)| (path, layout.add(element, count, Usage::Other));
        self.motion = numbers.map(add).collect();
    }

    /// Adds second texture coordinates. The first ones are needed too, which are then zero.
    fn add_texels(&mut self, surface: &SplitSurface, layout: &mut Layout) {
        let mut pairs = || layout.add(Element::Vector(2), surface.len() as u64, Usage::Vertices);
        self.coordinates = self.coordinates.or_else(|| Some(pairs()));
        self.texels = Some(pairs());
    }

    /// Writes the texture coordinates and the triangles.
    fn write_surface<W: Write + Seek>(
        &self,
        file: &mut Binary<'_, W>,
        surface: &SplitSurface,
    ) -> io::Result<()> {
        if let Some(array) = self.coordinates {
            let zeros = vec![[0.0; 2]; surface.len()];
            let is_zero = surface.coordinates.is_empty();
            let coordinates = if is_zero { &zeros } else { &surface.coordinates };
            file.write(array, 0, coordinates.as_flattened())?;
        }
        for ((_, array), corners) in self.corners.iter().zip(surface.primitives.values()) {
            let bytes: Vec<u8> = corners.iter().flat_map(|corner| corner.to_le_bytes()).collect();
            file.write_bytes(array.at, &bytes)?;
        }
        Ok(())
    }

    /// Writes the positions, the normals, the morph targets and the frames.
    fn write_motion<W: Write + Seek>(
        &self,
        file: &mut Binary<'_, W>,
        motion: &Motion,
        samples: &mut dyn Samples,
    ) -> io::Result<()> {
        for block in motion.blocks() {
            let offset = 12 * block.start as u64;
            for (kind, (vectors, array)) in
                [(Vectors::Positions, self.positions), (Vectors::Normals, self.normals)]
                    .into_iter()
                    .enumerate()
            {
                let base = motion.base(samples, block.clone(), vectors)?;
                file.write(array, offset, base.as_flattened())?;
                let displacements = motion.displacements(samples, block.clone(), vectors)?;
                for (target, column) in self.targets.iter().zip(displacements.column_iter()) {
                    file.write(target[kind], offset, column.as_slice())?;
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
        if let Some(texels) = self.texels {
            attributes["TEXCOORD_1"] = json!(texels.accessor);
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
