//! The arrays of the nodes of a file.

use std::io::{self, Seek, SeekFrom, Write};

use serde_json::{Value, json};

use super::colliders::ColliderNode;
use super::layout::{Array, Element, Layout, Usage};
use super::motion::{Motion, Pose, Vectors};
use super::{Samples, SplitSurface};

/// The scale of a node: 1, or 0 in frames in which it is not shown.
const SCALE: (&str, Element) = ("scale", Element::Vector(3));

/// The arrays of a body or a collider.
pub(super) struct BodyArrays {
    pub(super) positions: Array,
    pub(super) normals: Array,
    coordinates: Option<Array>,
    /// Second texture coordinates.
    pub(super) texels: Option<Array>,
    /// The corners of the triangles of each material.
    corners: Vec<(usize, Array)>,
    /// The displacements of positions and of normals of each morph target.
    targets: Vec<[Array; 2]>,
    /// Translations, rotations, scales and weights of the frames, those that change.
    motion: Vec<(&'static str, Array)>,
}

/// A file whose arrays are written.
pub(super) struct Binary<'a, W> {
    pub(super) out: &'a mut W,
    /// Offset of the first array in the file.
    pub(super) start: u64,
    pub(super) layout: Layout,
}

impl<W: Write + Seek> Binary<'_, W> {
    /// Writes numbers of an array from an offset in it on, in bytes.
    pub(super) fn write(&mut self, array: Array, offset: u64, numbers: &[f32]) -> io::Result<()> {
        self.layout.include(array, numbers);
        let bytes: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
        self.write_bytes(array.at + offset, &bytes)
    }

    pub(super) fn write_bytes(&mut self, at: u64, bytes: &[u8]) -> io::Result<()> {
        self.out.seek(SeekFrom::Start(self.start + at))?;
        self.out.write_all(bytes)
    }
}

impl BodyArrays {
    /// Adds the arrays of a surface with a number of morph targets.
    pub(super) fn new(surface: &SplitSurface, targets: usize, layout: &mut Layout) -> Self {
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
    pub(super) fn add_motion(&mut self, motion: &Motion, layout: &mut Layout) {
        let frames = motion.poses.len() as u64;
        let numbers = [
            ("translation", Element::Vector(3), frames),
            ("rotation", Element::Vector(4), frames),
            ("weights", Element::Scalar, frames * motion.components() as u64),
        ];
        let numbers = numbers.into_iter().filter(|&(_, _, count)| frames > 1 && count > 0);
        let add = |(path, element, count)| (path, layout.add(element, count, Usage::Other));
        self.motion = numbers.map(add).collect();
        self.add_changing([SCALE], &motion.poses, layout);
    }

    /// Adds second texture coordinates. The first ones are needed too, which are then zero.
    pub(super) fn add_texels(&mut self, surface: &SplitSurface, layout: &mut Layout) {
        let mut pairs = || layout.add(Element::Vector(2), surface.len() as u64, Usage::Vertices);
        self.coordinates = self.coordinates.or_else(|| Some(pairs()));
        self.texels = Some(pairs());
    }

    /// Writes the texture coordinates and the triangles.
    pub(super) fn write_surface<W: Write + Seek>(
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
    pub(super) fn write_motion<W: Write + Seek>(
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
        for &(path, array) in &self.motion {
            // One frame after another.
            let numbers = numbers_of(path, &motion.poses);
            file.write(array, 0, &numbers.unwrap_or_else(|| motion.weights.transpose().as_slice().to_vec()))?;
        }
        Ok(())
    }

    /// Adds the arrays of the frames of a collider, if it moves.
    pub(super) fn add_poses(&mut self, poses: &[Pose], layout: &mut Layout) {
        let paths = [("translation", Element::Vector(3)), ("rotation", Element::Vector(4)), SCALE];
        self.add_changing(paths, poses, layout);
    }

    /// Adds the arrays of those paths along which poses change.
    fn add_changing<const N: usize>(
        &mut self,
        paths: [(&'static str, Element); N],
        poses: &[Pose],
        layout: &mut Layout,
    ) {
        let first = [poses[0]];
        for (path, element) in paths {
            let start = numbers_of(path, &first);
            if poses.iter().any(|pose| numbers_of(path, &[*pose]) != start) {
                self.motion.push((path, layout.add(element, poses.len() as u64, Usage::Other)));
            }
        }
    }

    /// Writes the surface and the frames of a collider.
    pub(super) fn write_collider<W: Write + Seek>(
        &self,
        file: &mut Binary<'_, W>,
        node: &ColliderNode<'_>,
    ) -> io::Result<()> {
        self.write_surface(file, node.surface)?;
        file.write(self.positions, 0, node.positions.as_flattened())?;
        file.write(self.normals, 0, node.normals.as_flattened())?;
        for &(path, array) in &self.motion {
            file.write(array, 0, &numbers_of(path, &node.poses).unwrap_or_default())?;
        }
        Ok(())
    }

    pub(super) fn mesh(&self, name: &str) -> Value {
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

/// Returns the translations, the rotations or the scales of poses; `None` for weights.
fn numbers_of(path: &str, poses: &[Pose]) -> Option<Vec<f32>> {
    let poses = poses.iter();
    match path {
        "translation" => {
            Some(poses.flat_map(|pose| <[f32; 3]>::from(pose.translation.cast::<f32>())).collect())
        }
        "rotation" => {
            Some(poses.flat_map(|pose| <[f32; 4]>::from(pose.rotation.coords.cast::<f32>())).collect())
        }
        "scale" => Some(poses.flat_map(|pose| [f32::from(u8::from(pose.is_shown)); 3]).collect()),
        _ => None,
    }
}

/// Returns the animation of all nodes.
pub(super) fn animation(name: &str, times: Array, bodies: &[BodyArrays]) -> Value {
    let (mut samplers, mut channels) = (Vec::new(), Vec::new());
    for (node, arrays) in bodies.iter().enumerate() {
        for &(path, array) in &arrays.motion {
            channels.push(json!({ "sampler": samplers.len(), "target": { "node": node, "path": path } }));
            let mut sampler = json!({ "input": times.accessor, "output": array.accessor });
            if path == SCALE.0 {
                sampler["interpolation"] = json!("STEP");
            }
            samplers.push(sampler);
        }
    }
    json!({ "name": name, "samplers": samplers, "channels": channels })
}
