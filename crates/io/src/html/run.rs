//! The data of a run, as bytes: its description and its frames.
//!
//! ```text
//! u32   length of the description
//! JSON  the description, a `Header`
//! u8    the arrays of the surfaces, links and colliders
//! ...   the frames
//! ```
//!
//! The arrays are in the order in which bodies and then colliders use them. A body has its surface, unless an earlier
//! one has it, and the pairs of lattice vertices that are linked. A collider that is a mesh has its surface, unless an
//! earlier item has it, and its positions as `f32`, unless it is animated. A surface has the number of corners of each
//! face, the corners of all faces, and the first vertex at the position of each vertex. See `points::pack_words`.

use std::io::{self, Read, Write};

use flate2::Compression;
use flate2::read::GzDecoder;
use flate2::write::GzEncoder;

use super::frame::{Frames, Packer};
use super::header::Header;
use super::text::invalid;

/// A source of the frames of a run, by their index from 0.
pub(crate) trait FrameSource {
    /// Returns the size of a frame, in bytes.
    fn frame_bytes(&self, index: usize) -> u64;

    /// Writes the bytes of a frame to a buffer.
    fn read_frame(&mut self, index: usize, frame: &mut Vec<u8>) -> io::Result<()>;
}

/// Encodes a description and its arrays.
pub(crate) fn encode_header(header: &Header, arrays: &[u8]) -> io::Result<Vec<u8>> {
    let json = serde_json::to_vec(header)?;
    Ok([&(json.len() as u32).to_le_bytes(), &json[..], arrays].concat())
}

/// Decodes a description at the start of `bytes`. Returns it, its arrays, and the remaining bytes.
pub(crate) fn decode_header(bytes: &[u8]) -> io::Result<(Header, &[u8], &[u8])> {
    let split = || {
        let (length, rest) = bytes.split_first_chunk::<4>()?;
        let (json, rest) = rest.split_at_checked(u32::from_le_bytes(*length) as usize)?;
        let header: Header = serde_json::from_slice(json).ok()?;
        header.is_valid().then_some((header, rest))
    };
    let (header, rest) = split().ok_or_else(|| invalid("it has no data of a run that this version reads"))?;
    let arrays = rest.split_at_checked(header.arrays);
    let (arrays, rest) = arrays.ok_or_else(|| invalid("the data of a run are incomplete"))?;
    Ok((header, arrays, rest))
}

/// A run: its description, and where its frames are.
pub(crate) struct Run<'a> {
    pub(crate) header: Header,
    pub(crate) arrays: Vec<u8>,
    pub(crate) frames: Box<dyn FrameSource + 'a>,
}

impl Run<'_> {
    /// Writes the data of the run, compressed.
    pub(super) fn write(&mut self, out: impl Write) -> io::Result<()> {
        let mut encoder = GzEncoder::new(out, Compression::best());
        encoder.write_all(&encode_header(&self.header, &self.arrays)?)?;
        let mut packer = Packer::new(&self.header);
        let (mut frame, mut packed) = (Vec::new(), Vec::new());
        for index in 0..self.header.frames {
            self.frames.read_frame(index, &mut frame)?;
            packer.pack(&frame, &mut packed)?;
            encoder.write_all(&packed)?;
        }
        encoder.finish().map(drop)
    }

    /// Reads the compressed data of a run.
    pub(super) fn read(compressed: &[u8]) -> io::Result<Run<'static>> {
        let mut bytes = Vec::new();
        let unpacked = GzDecoder::new(compressed).read_to_end(&mut bytes);
        unpacked.map_err(|_| invalid("the page is incomplete, or its data were changed"))?;
        let (header, arrays, packed) = decode_header(&bytes)?;
        let frames = Frames::unpack(&header, packed)?;
        Ok(Run { arrays: arrays.to_vec(), header, frames: Box::new(frames) })
    }
}

impl FrameSource for Frames {
    fn frame_bytes(&self, index: usize) -> u64 {
        self.frame(index).len() as u64
    }

    fn read_frame(&mut self, index: usize, frame: &mut Vec<u8>) -> io::Result<()> {
        frame.clear();
        frame.extend_from_slice(self.frame(index));
        Ok(())
    }
}
