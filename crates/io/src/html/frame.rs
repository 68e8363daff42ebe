//! The data of one frame.
//!
//! ```text
//! head    f64  volumes of each body: at rest, before the correction, after the correction
//!         f64  pose of each collider: displacement x, y, z, Euler angles x, y, z in degrees
//!         f32  bounds of each point set: smallest x, y, z, largest x, y, z
//! points  u16  x, y, z of each point of each set
//! ```
//!
//! All numbers are little endian. In a page, the points of each set are packed: see `points`.

use std::io;

use super::header::Header;
use super::points::{BOUNDS, LATTICE_VALUES, MESH_VALUES, POINT, Predictor, quantize};
use super::text::invalid;

/// Size of the volumes of a body, in bytes.
const VOLUMES: usize = 3 * 8;

/// Size of the pose of a collider, in bytes.
const POSE: usize = 6 * 8;

/// Places of the data in the bytes of a frame.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Layout {
    bodies: usize,
    colliders: usize,
    /// Number of points of each set, and the largest value of a coordinate.
    sets: Vec<(usize, u16)>,
}

impl Layout {
    pub(crate) fn new(header: &Header) -> Self {
        Self { bodies: header.bodies.len(), colliders: header.colliders.len(), sets: header.point_sets() }
    }

    /// Returns the size of a frame, in bytes.
    pub(crate) fn bytes(&self) -> usize {
        self.head() + POINT * self.sets.iter().map(|(points, _)| points).sum::<usize>()
    }

    /// Returns the number of colliders.
    pub(crate) fn colliders(&self) -> usize {
        self.colliders
    }

    /// Returns the number of points of each animated collider.
    pub(crate) fn animated(&self) -> impl Iterator<Item = usize> + '_ {
        self.sets[2 * self.bodies..].iter().map(|(points, _)| *points)
    }

    /// Returns the size of the head, in bytes.
    fn head(&self) -> usize {
        VOLUMES * self.bodies + POSE * self.colliders + BOUNDS * self.sets.len()
    }

    /// Returns the offset of the bounds of a set in a frame, in bytes.
    fn bounds(&self, set: usize) -> usize {
        VOLUMES * self.bodies + POSE * self.colliders + BOUNDS * set
    }

    /// Returns the volumes of a body in a frame: at rest, before and after the correction.
    pub(super) fn volumes(&self, frame: &[u8], body: usize) -> [f64; 3] {
        let number = |k: usize| {
            let at = VOLUMES * body + 8 * k;
            f64::from_le_bytes(std::array::from_fn(|byte| frame[at + byte]))
        };
        [0, 1, 2].map(number)
    }
}

/// Builds the bytes of frames from their parts. The buffers are reused.
#[derive(Debug, Default)]
pub(crate) struct FrameBuilder {
    volumes: Vec<u8>,
    poses: Vec<u8>,
    bounds: Vec<u8>,
    points: Vec<u8>,
    bytes: Vec<u8>,
}

impl FrameBuilder {
    /// Appends the volumes of the next body: at rest, before and after the correction.
    pub(crate) fn push_volumes(&mut self, volumes: [f64; 3]) {
        self.volumes.extend(volumes.into_iter().flat_map(f64::to_le_bytes));
    }

    /// Appends the pose of the next collider.
    pub(crate) fn push_pose(&mut self, translate: [f64; 3], rotate: [f64; 3]) {
        self.poses.extend(translate.into_iter().chain(rotate).flat_map(f64::to_le_bytes));
    }

    /// Appends the next point set, a mesh. The positions are finite.
    pub(crate) fn push_mesh(&mut self, positions: &[[f32; 3]]) {
        quantize(positions, MESH_VALUES, &mut self.bounds, &mut self.points);
    }

    /// Appends the next point set, a lattice. The positions are finite.
    pub(crate) fn push_lattice(&mut self, positions: &[[f32; 3]]) {
        quantize(positions, LATTICE_VALUES, &mut self.bounds, &mut self.points);
    }

    /// Returns the bytes of the frame, and begins the next one.
    pub(crate) fn finish(&mut self) -> &[u8] {
        let Self { volumes, poses, bounds, points, bytes } = self;
        bytes.clear();
        for part in [volumes, poses, bounds, points] {
            bytes.append(part);
        }
        bytes
    }
}

/// Packs or unpacks frames in their order.
#[derive(Clone, Debug)]
pub(super) struct Packer {
    layout: Layout,
    predictors: Vec<Predictor>,
}

impl Packer {
    pub(super) fn new(layout: Layout) -> Self {
        Self { predictors: layout.sets.iter().map(|&(_, largest)| Predictor::new(largest)).collect(), layout }
    }

    /// Writes the packed bytes of the next frame to `packed`. They are as many as those of the frame.
    pub(super) fn pack(&mut self, frame: &[u8], packed: &mut Vec<u8>) {
        self.convert(frame, packed, Predictor::pack);
    }

    /// Writes the next frame, of which `packed` are the packed bytes, to `frame`.
    pub(super) fn unpack(&mut self, packed: &[u8], frame: &mut Vec<u8>) {
        self.convert(packed, frame, Predictor::unpack);
    }

    fn convert(
        &mut self,
        from: &[u8],
        to: &mut Vec<u8>,
        convert: impl Fn(&mut Predictor, &[u8], &[u8], &mut Vec<u8>),
    ) {
        let Self { layout, predictors } = self;
        to.clear();
        let mut start = layout.head();
        to.extend_from_slice(&from[..start]);
        for (set, predictor) in predictors.iter_mut().enumerate() {
            let end = start + POINT * layout.sets[set].0;
            let bounds = &from[layout.bounds(set)..][..BOUNDS];
            convert(predictor, bounds, &from[start..end], to);
            start = end;
        }
    }
}

/// Frames of a run in memory.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Frames {
    bytes: Vec<u8>,
    size: usize,
}

impl Frames {
    /// Unpacks `count` frames, of which `packed` are the packed bytes.
    pub(super) fn unpack(layout: Layout, count: usize, packed: &[u8]) -> io::Result<Self> {
        let size = layout.bytes();
        if size.checked_mul(count) != Some(packed.len()) {
            return Err(invalid("the page is incomplete, or its data were changed"));
        }
        let mut packer = Packer::new(layout);
        let (mut bytes, mut frame) = (Vec::with_capacity(packed.len()), Vec::new());
        for packed in packed.chunks_exact(size.max(1)) {
            packer.unpack(packed, &mut frame);
            bytes.extend_from_slice(&frame);
        }
        Ok(Self { bytes, size })
    }

    pub(super) fn frame(&self, index: usize) -> &[u8] {
        &self.bytes[self.size * index..self.size * (index + 1)]
    }
}
