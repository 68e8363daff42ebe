//! The pieces of broken bodies in the frames: their data follow those of the frame.
//!
//! ```text
//! u64 mark, u64 size of what follows the frame
//! for each broken body  u64 index of the body, u64 hash of the topology, u64 1 if the topology follows or else 0
//!                       points; velocities, none if the other frames have none; normals, as in the other frames
//!                       if the topology follows: i32 number of corners of each face, i32 corners, i32 face of the
//!                       whole body or -1 for a cap, i32 index of the normal of each corner, f32 texture coordinates
//!                       of each corner
//! ```
//!
//! Each array is preceded by its number of elements as u64, and begins at a multiple of 8. The topology follows in the
//! first frame that has it. No frame begins with the mark, but with a number of points.

use std::io::{self, ErrorKind, Read, Seek, SeekFrom};

use super::kind::{FRAMES, Type};
use super::layout::{ARRAY_HEAD, push_vectors};

const MARK: u64 = u64::from_le_bytes(*b"\xffPIECES\xff");
/// Size of the mark and the size, in bytes.
const HEAD: u64 = 16;

/// The topology of the pieces of a body.
#[derive(Debug, Default)]
pub(crate) struct Topology {
    /// Number of corners of each face, and the corners.
    pub(crate) counts: Vec<i32>,
    pub(crate) corners: Vec<i32>,
    /// For each face, the face of the whole body, or -1 for a cap.
    pub(crate) sources: Vec<i32>,
    /// For each corner, the index of its normal; empty without normals.
    pub(crate) normals: Vec<i32>,
    /// For each corner, its texture coordinates; empty without any.
    pub(crate) textures: Vec<[f32; 2]>,
}

/// Bytes of the pieces of a frame.
#[derive(Debug, Default)]
pub(crate) struct PiecesBuilder {
    bytes: Vec<u8>,
}

impl PiecesBuilder {
    /// Appends a body, with its topology if the frame before has another one.
    pub(crate) fn push(
        &mut self,
        (body, identity): (usize, u64),
        [points, velocities, normals]: [&[[f32; 3]]; 3],
        topology: Option<&Topology>,
    ) {
        let Self { bytes } = self;
        if bytes.is_empty() {
            bytes.extend([MARK, 0].iter().flat_map(|word| word.to_le_bytes()));
        }
        let head = [body as u64, identity, topology.is_some().into()];
        bytes.extend(head.iter().flat_map(|word| word.to_le_bytes()));
        for vectors in [points, velocities, normals] {
            push_vectors(bytes, vectors.iter().copied());
        }
        if let Some(Topology { counts, corners, sources, normals, textures }) = topology {
            for integers in [counts, corners, sources, normals] {
                push_array(bytes, integers.iter().map(|integer| integer.to_le_bytes()), 1);
            }
            push_array(bytes, textures.as_flattened().iter().map(|number| number.to_le_bytes()), 2);
        }
    }

    /// Appends the bytes to a frame, and begins the next one.
    pub(crate) fn finish(&mut self, frame: &mut Vec<u8>) {
        let start = frame.len();
        frame.append(&mut self.bytes);
        let size = frame.len() - start;
        if size > 0 {
            frame[start + 8..start + 16].copy_from_slice(&(size as u64).to_le_bytes());
        }
    }

    /// Forgets the bodies of the frame.
    pub(crate) fn clear(&mut self) {
        self.bytes.clear();
    }
}

/// Appends an array of elements of `width` numbers.
fn push_array(bytes: &mut Vec<u8>, numbers: impl ExactSizeIterator<Item = [u8; 4]>, width: usize) {
    bytes.extend((numbers.len() as u64 / width as u64).to_le_bytes());
    bytes.extend(numbers.flatten());
    bytes.resize(bytes.len().next_multiple_of(8), 0);
}

/// Places of the frames in a file.
#[derive(Debug)]
pub(crate) struct Places {
    /// Offset of each frame.
    pub(super) starts: Vec<u64>,
    /// Offset of the end of the last frame.
    pub(crate) end: u64,
    /// The pieces of bodies in frames, in the order of the frames.
    pub(super) pieces: Vec<PiecesPlace>,
}

/// Place of the pieces of a body in a frame.
#[derive(Debug)]
pub(super) struct PiecesPlace {
    pub(super) frame: usize,
    pub(super) body: usize,
    identity: u64,
    /// The field values of the points, the velocities and the normals.
    pub(super) points: u64,
    pub(super) velocities: u64,
    pub(super) normals: u64,
    /// Those of the topology if it is in this frame.
    pub(super) topology: Option<TopologyPlace>,
}

/// The field values of a topology, and its sources.
#[derive(Debug)]
pub(super) struct TopologyPlace {
    pub(super) counts: u64,
    pub(super) corners: u64,
    pub(super) normals: u64,
    pub(super) textures: u64,
    pub(super) sources: Vec<i32>,
}

impl Places {
    /// No frames.
    pub(crate) fn none() -> Self {
        Self { starts: Vec::new(), end: FRAMES, pieces: Vec::new() }
    }

    /// Finds `count` frames of a file, of `frame_bytes` bytes without pieces. Returns the number of complete frames if
    /// they are fewer.
    pub(crate) fn find(
        file: &mut (impl Read + Seek),
        frame_bytes: u64,
        count: u64,
    ) -> io::Result<Result<Self, u64>> {
        let length = file.seek(SeekFrom::End(0))?;
        let mut places = Self::none();
        for frame in 0..count {
            let start = places.end;
            let mut end = start + frame_bytes;
            if frame_bytes > 0 && end + HEAD <= length && read_word(file, end)? == MARK {
                let pieces = end;
                end = end.saturating_add(read_word(file, pieces + 8)?);
                if end <= length {
                    places.read_pieces(file, frame as usize, pieces + HEAD..end)?;
                }
            }
            if end > length {
                return Ok(Err(frame));
            }
            places.starts.push(start);
            places.end = end;
        }
        Ok(Ok(places))
    }

    /// Returns the hash of the topology of each body that is broken in the last frame.
    pub(crate) fn last_broken(&self) -> impl Iterator<Item = (usize, u64)> + '_ {
        let last = self.starts.len().wrapping_sub(1);
        self.pieces.iter().filter(move |place| place.frame == last).map(|place| (place.body, place.identity))
    }

    fn read_pieces(
        &mut self,
        file: &mut (impl Read + Seek),
        frame: usize,
        mut range: std::ops::Range<u64>,
    ) -> io::Result<()> {
        // Returns the offset and the number of elements of the next array.
        let array = |file: &mut _, at: &mut u64, size: u64| {
            let (start, count) = (*at, read_word(file, *at)?);
            let bytes = count.checked_mul(size).filter(|bytes| *bytes <= range.end - start);
            let bytes = bytes.ok_or(ErrorKind::InvalidData)?;
            *at = start + ARRAY_HEAD + bytes.next_multiple_of(8);
            io::Result::Ok((start, count))
        };
        while range.start < range.end {
            let [body, identity, has_topology] = [0, 8, 16].map(|at| read_word(file, range.start + at));
            let (body, identity, has_topology) = (body? as usize, identity?, has_topology? != 0);
            let mut at = range.start + 24;
            let points = Type::Vec3f.array(array(file, &mut at, 12)?.0);
            let velocities = Type::Vec3f.array(array(file, &mut at, 12)?.0);
            let normals = Type::Vec3f.array(array(file, &mut at, 12)?.0);
            let topology = if has_topology {
                let counts = Type::Int.array(array(file, &mut at, 4)?.0);
                let corners = Type::Int.array(array(file, &mut at, 4)?.0);
                let (start, count) = array(file, &mut at, 4)?;
                let mut sources = vec![0; 4 * count as usize];
                file.seek(SeekFrom::Start(start + ARRAY_HEAD))?;
                file.read_exact(&mut sources)?;
                let sources =
                    sources.as_chunks::<4>().0.iter().map(|bytes| i32::from_le_bytes(*bytes)).collect();
                let normals = Type::Int.array(array(file, &mut at, 4)?.0);
                let textures = Type::Vec2f.array(array(file, &mut at, 8)?.0);
                Some(TopologyPlace { counts, corners, normals, textures, sources })
            } else {
                None
            };
            self.pieces.push(PiecesPlace { frame, body, identity, points, velocities, normals, topology });
            range.start = at;
        }
        Ok(())
    }
}

fn read_word(file: &mut (impl Read + Seek), at: u64) -> io::Result<u64> {
    let mut word = [0; 8];
    file.seek(SeekFrom::Start(at))?;
    file.read_exact(&mut word)?;
    Ok(u64::from_le_bytes(word))
}
