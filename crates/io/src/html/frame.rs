//! The data of one frame.
//!
//! ```text
//! head    f64  volumes of each body: at rest, before the correction, after the correction
//!         f64  pose of each collider: displacement x, y, z, Euler angles x, y, z in degrees; NaN if it is disabled
//!         f32  bounds of each point set: smallest x, y, z, largest x, y, z
//! pieces       the broken bodies: see `pieces`
//! points  u16  x, y, z of each point of each set
//! ```
//!
//! All numbers are little endian. The sets of a broken body have the numbers of points of its pieces, and all others
//! those of the header. In a page, the points of each set are packed: see `points`. The pieces are left out of all
//! frames of a page if no body is broken in any of them: see `Header::has_pieces`.

use std::io;

use super::header::Header;
use super::pieces::{self, BrokenBody, Topology};
use super::points::{BOUNDS, LATTICE_VALUES, MESH_VALUES, POINT, Predictor, quantize};
use super::text::invalid;

/// Size of the volumes of a body, in bytes.
const VOLUMES: usize = 3 * 8;

/// Size of the pose of a collider, in bytes.
const POSE: usize = 6 * 8;

/// The pieces of a frame without broken bodies.
const NO_PIECES: [u8; 4] = [0; 4];

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

    /// Returns the size of a frame without broken bodies, in bytes.
    pub(crate) fn whole_bytes(&self) -> usize {
        self.head() + NO_PIECES.len() + POINT * self.sets.iter().map(|(points, _)| points).sum::<usize>()
    }

    /// Returns the broken bodies of a frame, or `None` if it is incomplete or was changed.
    pub(crate) fn broken(&self, frame: &[u8]) -> Option<Vec<BrokenBody>> {
        Some(pieces::read(frame.get(self.head()..)?)?.0)
    }

    /// Returns the number of points of each set of a frame, and the size of its pieces, with which `bytes` begin.
    /// `None` if they are incomplete or invalid.
    pub(super) fn points(&self, bytes: &[u8]) -> Option<(Vec<usize>, usize)> {
        let (broken, size) = pieces::read(bytes)?;
        let mut points: Vec<usize> = self.sets.iter().map(|(points, _)| *points).collect();
        for BrokenBody { body, points: of_body, .. } in broken {
            points[..2 * self.bodies].as_chunks_mut().0.get_mut(body).map(|sets| *sets = of_body)?;
        }
        Some((points, size))
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
    pub(super) fn head(&self) -> usize {
        VOLUMES * self.bodies + POSE * self.colliders + BOUNDS * self.sets.len()
    }

    /// Returns the offset of the bounds of a set in a frame, in bytes.
    pub(super) fn bounds(&self, set: usize) -> usize {
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

    /// Returns the pose of a collider in a frame: its displacement, and Euler angles in degrees. `None` if the collider is
    /// disabled, and not shown.
    pub(super) fn pose(&self, frame: &[u8], collider: usize) -> Option<[[f64; 3]; 2]> {
        let number = |k: usize| {
            let at = VOLUMES * self.bodies + POSE * collider + 8 * k;
            f64::from_le_bytes(std::array::from_fn(|byte| frame[at + byte]))
        };
        let pose = [[0, 1, 2].map(number), [3, 4, 5].map(number)];
        (!pose.as_flattened().iter().any(|number| number.is_nan())).then_some(pose)
    }
}

/// Builds the bytes of frames from their parts. The buffers are reused.
#[derive(Debug, Default)]
pub(crate) struct FrameBuilder {
    volumes: Vec<u8>,
    poses: Vec<u8>,
    bounds: Vec<u8>,
    /// Number of broken bodies, and their pieces.
    broken: u32,
    pieces: Vec<u8>,
    points: Vec<u8>,
    bytes: Vec<u8>,
}

impl FrameBuilder {
    /// Appends the volumes of the next body: at rest, before and after the correction.
    pub(crate) fn push_volumes(&mut self, volumes: [f64; 3]) {
        self.volumes.extend(volumes.into_iter().flat_map(f64::to_le_bytes));
    }

    /// Appends the pose of the next collider; `None` if it is disabled.
    pub(crate) fn push_pose(&mut self, pose: Option<([f64; 3], [f64; 3])>) {
        let (translate, rotate) = pose.unwrap_or(([f64::NAN; 3], [f64::NAN; 3]));
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

    /// Appends a broken body, with its topology if it is not that of the frame before.
    pub(crate) fn push_broken(&mut self, body: &BrokenBody, topology: Option<&Topology>) {
        self.broken += 1;
        body.write(topology, &mut self.pieces);
    }

    /// Returns the bytes of the frame, and begins the next one.
    pub(crate) fn finish(&mut self) -> &[u8] {
        let Self { volumes, poses, bounds, broken, pieces, points, bytes } = self;
        bytes.clear();
        let mut count = std::mem::take(broken).to_le_bytes().to_vec();
        for part in [volumes, poses, bounds, &mut count, pieces, points] {
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
    /// Whether packed frames have pieces.
    has_pieces: bool,
}

impl Packer {
    pub(super) fn new(header: &Header) -> Self {
        let layout = Layout::new(header);
        let predictors = layout.sets.iter().map(|&(_, largest)| Predictor::new(largest)).collect();
        Self { layout, predictors, has_pieces: header.has_pieces() }
    }

    /// Writes the packed bytes of the next frame to `packed`.
    pub(super) fn pack(&mut self, frame: &[u8], packed: &mut Vec<u8>) -> io::Result<()> {
        self.convert((frame, true), (packed, self.has_pieces), Predictor::pack).map(drop)
    }

    /// Writes the next frame, with the packed bytes of which `packed` begins, to `frame`. Returns their number.
    pub(super) fn unpack(&mut self, packed: &[u8], frame: &mut Vec<u8>) -> io::Result<usize> {
        self.convert((packed, self.has_pieces), (frame, true), Predictor::unpack)
    }

    /// Converts the frame at the start of `from`. Both sides say whether they have pieces. Returns the size of the
    /// frame.
    fn convert(
        &mut self,
        (from, from_pieces): (&[u8], bool),
        (to, to_pieces): (&mut Vec<u8>, bool),
        convert: impl Fn(&mut Predictor, &[u8], &[u8], &mut Vec<u8>),
    ) -> io::Result<usize> {
        let Self { layout, predictors, .. } = self;
        let incomplete = || invalid("the page is incomplete, or its data were changed");
        to.clear();
        let (head, mut rest) = from.split_at_checked(layout.head()).ok_or_else(incomplete)?;
        to.extend_from_slice(head);
        let pieces = if from_pieces { rest } else { &NO_PIECES };
        let (points, size) = layout.points(pieces).ok_or_else(incomplete)?;
        if to_pieces {
            to.extend_from_slice(&pieces[..size]);
        }
        if from_pieces {
            rest = &rest[size..];
        }
        for (set, (predictor, points)) in predictors.iter_mut().zip(points).enumerate() {
            let values;
            (values, rest) = rest.split_at_checked(POINT * points).ok_or_else(incomplete)?;
            convert(predictor, &head[layout.bounds(set)..][..BOUNDS], values, to);
        }
        Ok(from.len() - rest.len())
    }
}

/// Frames of a run in memory.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Frames {
    bytes: Vec<u8>,
    /// Offset of the end of each frame.
    ends: Vec<usize>,
}

impl Frames {
    /// Unpacks the frames of a run, of which `packed` are the packed bytes.
    pub(super) fn unpack(header: &Header, mut packed: &[u8]) -> io::Result<Self> {
        let mut packer = Packer::new(header);
        let (mut bytes, mut frame) = (Vec::with_capacity(packed.len()), Vec::new());
        let mut ends = Vec::new();
        for _ in 0..header.frames {
            let size = packer.unpack(packed, &mut frame)?;
            packed = &packed[size..];
            bytes.extend_from_slice(&frame);
            ends.push(bytes.len());
        }
        if !packed.is_empty() {
            return Err(invalid("the page is incomplete, or its data were changed"));
        }
        Ok(Self { bytes, ends })
    }

    pub(super) fn frame(&self, index: usize) -> &[u8] {
        let start = index.checked_sub(1).map_or(0, |before| self.ends[before]);
        &self.bytes[start..self.ends[index]]
    }
}

#[cfg(test)]
mod tests {
    use supple::{Body, Mesh, Simulation};

    use super::*;
    use crate::space::{FileSpace, Up};

    /// The header of a run with one body of four vertices, and its frames: whole, broken with five vertices, and whole.
    fn run(has_pieces: bool) -> (Header, Vec<Vec<u8>>) {
        let vertices = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let mesh = Mesh::new(vertices, &[[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]).unwrap();
        let body = Body::builder(mesh).cell_size(1.0).build().unwrap();
        let lattice = body.lattice().len();
        let simulation = Simulation::builder().body(body).build().unwrap();
        let space = FileSpace::new(Up::Y, Up::Y, 1.0);
        let (mut header, _) = Header::new(&simulation, "run", 30.0, 0, 1, space);
        header.set_has_pieces(has_pieces);
        header.frames = 3;
        let frame = |index: usize| {
            let points = if has_pieces && index == 1 { 5 } else { 4 };
            let positions = |count: usize| {
                let place = |k: usize| [k as f32, (index * k) as f32, 0.5];
                (0..count).map(place).collect::<Vec<_>>()
            };
            let mut builder = FrameBuilder::default();
            builder.push_volumes([1.0, 2.0, index as f64]);
            builder.push_mesh(&positions(points));
            builder.push_lattice(&positions(lattice));
            if points == 5 {
                builder.push_broken(&BrokenBody { body: 0, identity: 9, points: [5, lattice] }, None);
            }
            builder.finish().to_vec()
        };
        (header, (0..3).map(frame).collect())
    }

    /// Returns the packed bytes of a run.
    fn packed(header: &Header, frames: &[Vec<u8>]) -> Vec<u8> {
        let mut packer = Packer::new(header);
        let (mut all, mut packed) = (Vec::new(), Vec::new());
        for frame in frames {
            packer.pack(frame, &mut packed).unwrap();
            all.extend_from_slice(&packed);
        }
        all
    }

    #[test]
    fn frames_with_and_without_pieces_read_back() {
        for has_pieces in [false, true] {
            let (header, frames) = run(has_pieces);
            let packed = packed(&header, &frames);
            let size: usize = frames.iter().map(Vec::len).sum();
            // Without pieces, a packed frame has no word for them.
            assert_eq!(packed.len(), if has_pieces { size } else { size - 3 * NO_PIECES.len() });
            let read = Frames::unpack(&header, &packed).unwrap();
            for (index, frame) in frames.iter().enumerate() {
                assert_eq!(read.frame(index), frame);
            }
        }
    }

    #[test]
    fn incomplete_and_changed_frames_are_errors() {
        let (header, frames) = run(true);
        let packed = packed(&header, &frames);
        for length in 0..packed.len() {
            assert!(Frames::unpack(&header, &packed[..length]).is_err(), "{length} bytes");
        }
        assert!(Frames::unpack(&header, &[&packed[..], &[0]].concat()).is_err());
        // A body that does not exist.
        let layout = Layout::new(&header);
        let mut changed = packed.clone();
        changed[frames[0].len() + layout.head() + NO_PIECES.len()] = 1;
        assert!(Frames::unpack(&header, &changed).is_err());
        let broken = BrokenBody { body: 0, identity: 9, points: [5, layout.sets[1].0] };
        assert_eq!(layout.broken(&frames[1]), Some(vec![broken]));
        assert_eq!(layout.broken(&frames[1][..layout.head()]), None);
    }
}
