//! Animated WebP (Google, "WebP Container Specification", RFC 9649). The pictures are lossless ones of `image-webp`, which
//! writes no animations; the container is written here.
//!
//! ```text
//! "RIFF" size "WEBP"
//! VP8X   size of the pictures
//! ANIM   background, repetitions: 0 is without end
//! ANMF   place, size and duration of a patch, and a chunk VP8L with its pixels; for each patch
//! SUPL   facts for later runs of this program, which others skip
//! ```

use std::io::{self, Seek, SeekFrom, Write};

use image_webp::{ColorType, WebPEncoder};

use super::patch::Patch;

/// Flags of the header: animation, transparent pixels.
const FLAGS: u8 = 0b0001_0010;
/// Flag of a patch that replaces what is below it also where it is transparent.
const REPLACE: u8 = 0b10;
/// Size of what precedes the pixels of a still picture: "RIFF", size, "WEBP".
const STILL: usize = 12;
/// Size of "RIFF" and the size of the file.
const RIFF: u64 = 8;

/// Returns the chunk with the pixels of a patch, and whether it has transparent pixels.
pub(super) fn encode(patch: &Patch) -> io::Result<(Vec<u8>, bool)> {
    let whole = still(
        patch.size,
        patch.pixels.iter().flat_map(|&[r, g, b, _]| [r, g, b]).collect(),
        ColorType::Rgb8,
    )?;
    if patch.pixels.iter().all(|pixel| pixel[3] == 255) {
        return Ok((whole, false));
    }
    // A transparent pixel has the color of the pixel above it, from which the encoder takes the difference.
    let width = patch.size[0] as usize;
    let mut pixels: Vec<[u8; 4]> = patch.pixels.clone();
    for at in 0..pixels.len() {
        if pixels[at][3] == 0 {
            let [r, g, b, _] = at.checked_sub(width).map_or([0; 4], |above| pixels[above]);
            pixels[at] = [r, g, b, 0];
        }
    }
    let part = still(patch.size, pixels.into_flattened(), ColorType::Rgba8)?;
    Ok(if part.len() < whole.len() { (part, true) } else { (whole, false) })
}

/// Returns the chunk with the pixels of a picture.
fn still([width, height]: [u32; 2], pixels: Vec<u8>, color: ColorType) -> io::Result<Vec<u8>> {
    let mut file = Vec::new();
    WebPEncoder::new(&mut file).encode(&pixels, width, height, color).map_err(io::Error::other)?;
    Ok(file.split_off(STILL))
}

/// Returns the lower three bytes of a number.
fn three(number: u32) -> [u8; 3] {
    let [a, b, c, _] = number.to_le_bytes();
    [a, b, c]
}

fn write_chunk(out: &mut impl Write, name: &[u8; 4], parts: &[&[u8]]) -> io::Result<()> {
    let size: usize = parts.iter().map(|part| part.len()).sum();
    let too_long = |_| io::Error::other("a picture has more than 4 GB");
    out.write_all(name)?;
    out.write_all(&u32::try_from(size).map_err(too_long)?.to_le_bytes())?;
    parts.iter().try_for_each(|part| out.write_all(part))?;
    out.write_all(&[0][..size % 2])
}

/// Starts a file.
pub(super) fn start(out: &mut impl Write, [width, height]: [u32; 2]) -> io::Result<()> {
    out.write_all(b"RIFF\0\0\0\0WEBP")?;
    write_chunk(out, b"VP8X", &[&[FLAGS, 0, 0, 0], &three(width - 1), &three(height - 1)])?;
    write_chunk(out, b"ANIM", &[&[255; 4], &[0; 2]])
}

/// Adds a patch with its chunk. `duration`: in ms.
pub(super) fn add(
    out: &mut impl Write,
    patch: &Patch,
    (pixels, is_transparent): &(Vec<u8>, bool),
    duration: u32,
) -> io::Result<()> {
    let [x, y] = patch.start.map(|side| three(side / 2));
    let [width, height] = patch.size.map(|side| three(side - 1));
    let flags = if *is_transparent { 0 } else { REPLACE };
    write_chunk(out, b"ANMF", &[&x, &y, &width, &height, &three(duration), &[flags], pixels])
}

/// Completes a file.
pub(super) fn finish(out: &mut (impl Write + Seek), facts: &[u8]) -> io::Result<()> {
    write_chunk(out, b"SUPL", &[facts])?;
    let size = out.stream_position()? - RIFF;
    let too_long = |_| {
        io::Error::other("the film has more than 4 GB: write fewer frames with --every, or a smaller picture")
    };
    let size = u32::try_from(size).map_err(too_long)?;
    out.seek(SeekFrom::Start(4))?;
    out.write_all(&size.to_le_bytes())
}
