//! Writes the images, row by row.

use std::io::{self, Write};
use std::ops::Range;

use png::{BitDepth, ColorType, Compression, Encoder};

use super::TexelLayout;
use crate::glb::Samples;

/// What the texels of an image hold, and the points that have it.
pub(super) enum Numbers<'a> {
    /// Offsets of positions from the first frame, between the smallest and the largest one.
    Offsets { points: &'a Range<usize>, low: [f32; 3], high: [f32; 3] },
    /// Normals.
    Normals { points: &'a Range<usize> },
}

/// Turns a vector whose y axis points up to Blender's axes.
fn turned([x, y, z]: [f32; 3]) -> [f32; 3] {
    [x, -z, y]
}

/// Returns the offset of a position from the first frame.
fn offset(now: [f32; 3], first: [f32; 3]) -> [f32; 3] {
    turned(std::array::from_fn(|axis| now[axis] - first[axis]))
}

/// Returns the smallest and the largest offset of points from the first frame, per axis.
pub(super) fn bounds(samples: &mut dyn Samples, points: &Range<usize>) -> io::Result<([f32; 3], [f32; 3])> {
    let (mut first, mut now) = (Vec::new(), Vec::new());
    samples.read(0, points.clone(), &mut first)?;
    let (mut low, mut high) = ([0.0_f32; 3], [0.0_f32; 3]);
    for frame in 0..samples.frames() {
        samples.read(frame, points.clone(), &mut now)?;
        for (now, first) in now.iter().zip(&first) {
            let offset = offset(*now, *first);
            low = std::array::from_fn(|axis| low[axis].min(offset[axis]));
            high = std::array::from_fn(|axis| high[axis].max(offset[axis]));
        }
    }
    Ok((low, high))
}

/// Returns a number of [0, 1] in 16 bits.
fn quantized(number: f32) -> u16 {
    (number.clamp(0.0, 1.0) * f32::from(u16::MAX)).round() as u16
}

/// Writes an image as PNG.
pub(super) fn write(
    out: &mut impl Write,
    layout: TexelLayout,
    samples: &mut dyn Samples,
    numbers: &Numbers<'_>,
) -> io::Result<()> {
    let TexelLayout { width, height, vertices, frames } = layout;
    let mut encoder = Encoder::new(out, width as u32, height as u32);
    encoder.set_color(ColorType::Rgba);
    encoder.set_depth(BitDepth::Sixteen);
    encoder.set_compression(Compression::Balanced);
    let mut writer = encoder.write_header()?;
    let mut rows = writer.stream_writer()?;
    let (mut first, mut now, mut row) = (Vec::new(), Vec::new(), Vec::new());
    let block = |points: &Range<usize>, block: usize| {
        points.start + block * width..points.start + vertices.min((block + 1) * width)
    };
    for number in 0..height {
        row.clear();
        let (of_block, frame) = (number / frames, number % frames);
        if of_block * width < vertices {
            let texel = |vector: [f32; 3]| {
                let [r, g, b] = vector.map(quantized);
                [r, g, b, u16::MAX].map(u16::to_be_bytes)
            };
            match numbers {
                Numbers::Offsets { points, low, high } => {
                    let points = block(points, of_block);
                    if frame == 0 {
                        samples.read(0, points.clone(), &mut first)?;
                    }
                    samples.read(frame, points, &mut now)?;
                    let extent: [f32; 3] =
                        std::array::from_fn(|axis| (high[axis] - low[axis]).max(f32::MIN_POSITIVE));
                    row.extend(now.iter().zip(&first).flat_map(|(now, first)| {
                        let offset = offset(*now, *first);
                        texel(std::array::from_fn(|axis| (offset[axis] - low[axis]) / extent[axis]))
                    }));
                }
                Numbers::Normals { points } => {
                    samples.read(frame, block(points, of_block), &mut now)?;
                    let unsigned =
                        |normal: &[f32; 3]| texel(turned(*normal).map(|number| 0.5 * number + 0.5));
                    row.extend(now.iter().flat_map(unsigned));
                }
            }
        }
        row.resize(4 * width, [0; 2]);
        rows.write_all(row.as_flattened())?;
    }
    rows.finish()?;
    writer.finish().map_err(Into::into)
}
