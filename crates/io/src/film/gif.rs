//! Animated GIF. Each patch has a palette of its own, of 256 colors.

use std::io::{self, Write};

use gif::{Encoder, Frame, Repeat};

use super::patch::Patch;

/// How fast colors are chosen, from 1, the best ones, to 30.
const SPEED: i32 = 10;
/// Label of comments.
const COMMENT: u8 = 0xfe;

fn failed(error: gif::EncodingError) -> io::Error {
    match error {
        gif::EncodingError::Io(error) => error,
        error => io::Error::other(error),
    }
}

/// Returns the frame of a patch, compressed.
pub(super) fn encode(patch: &Patch) -> io::Result<Frame<'static>> {
    let side = |side: u32| u16::try_from(side).map_err(io::Error::other);
    let mut pixels = patch.pixels.as_flattened().to_vec();
    let mut frame = Frame::from_rgba_speed(side(patch.size[0])?, side(patch.size[1])?, &mut pixels, SPEED);
    (frame.left, frame.top) = (side(patch.start[0])?, side(patch.start[1])?);
    frame.make_lzw_pre_encoded();
    Ok(frame)
}

/// A file that is written.
pub(super) struct File<W: Write>(Encoder<W>);

impl<W: Write> File<W> {
    /// Starts a file.
    pub(super) fn start(out: W, size: [u32; 2]) -> io::Result<Self> {
        let [width, height] = size.map(|side| side as u16);
        let mut encoder = Encoder::new(out, width, height, &[]).map_err(failed)?;
        encoder.set_repeat(Repeat::Infinite).map_err(failed)?;
        Ok(Self(encoder))
    }

    /// Adds a frame. `duration`: in hundredths of a second.
    pub(super) fn add(&mut self, mut frame: Frame<'static>, duration: u32) -> io::Result<()> {
        frame.delay = duration.min(u16::MAX.into()) as u16;
        self.0.write_lzw_pre_encoded_frame(&frame).map_err(failed)
    }

    /// Completes the file.
    pub(super) fn finish(mut self, facts: &[u8]) -> io::Result<()> {
        self.0.write_raw_extension(gif::AnyExtension(COMMENT), &[facts]).map_err(failed)?;
        self.0.into_inner().map_err(io::Error::other).map(drop)
    }
}
