//! Writes the images, row by row.

use std::io::{self, Seek, Write};
use std::ops::Range;

use exr::block::writer::ChunksWriter;
use exr::block::{UncompressedBlock, enumerate_ordered_header_block_indices};
use exr::meta::BlockDescription;
use exr::meta::attribute::{ChannelDescription, LineOrder, SampleType};
use exr::meta::header::Header;
use png::{BitDepth, ColorType, Compression, Encoder};

use super::{TexelLayout, VatEncoding};
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

/// The texels of an image, which are read row by row from the top down. Each number is in [0, 1].
struct Rows<'a> {
    layout: TexelLayout,
    samples: &'a mut dyn Samples,
    numbers: &'a Numbers<'a>,
    /// Scratch: the vectors of a block in the first frame and in that of the row.
    first: Vec<[f32; 3]>,
    now: Vec<[f32; 3]>,
}

impl Rows<'_> {
    /// Reads the texels of a row that are used, from its left end on.
    fn read(&mut self, row: usize, texels: &mut Vec<[f32; 3]>) -> io::Result<()> {
        let Self { layout, samples, numbers, first, now } = self;
        let TexelLayout { width, vertices, frames, .. } = *layout;
        texels.clear();
        let (block, frame) = (row / frames, row % frames);
        if block * width >= vertices {
            return Ok(());
        }
        let of_block = |points: &Range<usize>| {
            points.start + block * width..points.start + vertices.min((block + 1) * width)
        };
        match numbers {
            Numbers::Offsets { points, low, high } => {
                if frame == 0 {
                    samples.read(0, of_block(points), first)?;
                }
                samples.read(frame, of_block(points), now)?;
                let extent: [f32; 3] =
                    std::array::from_fn(|axis| (high[axis] - low[axis]).max(f32::MIN_POSITIVE));
                texels.extend(now.iter().zip(&*first).map(|(now, first)| {
                    let offset = offset(*now, *first);
                    std::array::from_fn(|axis| (offset[axis] - low[axis]) / extent[axis])
                }));
            }
            Numbers::Normals { points } => {
                samples.read(frame, of_block(points), now)?;
                texels.extend(now.iter().map(|normal| turned(*normal).map(|number| 0.5 * number + 0.5)));
            }
        }
        Ok(())
    }
}

/// Writes an image.
pub(super) fn write(
    out: &mut (impl Write + Seek),
    encoding: VatEncoding,
    layout: TexelLayout,
    samples: &mut dyn Samples,
    numbers: &Numbers<'_>,
) -> io::Result<()> {
    let rows = Rows { layout, samples, numbers, first: Vec::new(), now: Vec::new() };
    match encoding {
        VatEncoding::Png => write_png(out, rows),
        VatEncoding::Exr => write_exr(out, rows).map_err(|error| match error {
            exr::error::Error::Io(error) => error,
            error => io::Error::other(error),
        }),
    }
}

/// Writes an image as PNG: red, green, blue and alpha, 16 bits each.
fn write_png(out: &mut impl Write, mut rows: Rows<'_>) -> io::Result<()> {
    let TexelLayout { width, height, .. } = rows.layout;
    let mut encoder = Encoder::new(out, width as u32, height as u32);
    encoder.set_color(ColorType::Rgba);
    encoder.set_depth(BitDepth::Sixteen);
    encoder.set_compression(Compression::Balanced);
    let mut writer = encoder.write_header()?;
    let mut stream = writer.stream_writer()?;
    let quantized = |number: f32| (number.clamp(0.0, 1.0) * f32::from(u16::MAX)).round() as u16;
    let (mut texels, mut row) = (Vec::new(), Vec::new());
    for number in 0..height {
        rows.read(number, &mut texels)?;
        row.clear();
        row.extend(texels.iter().flat_map(|texel| {
            let [r, g, b] = texel.map(quantized);
            [r, g, b, u16::MAX].map(u16::to_be_bytes)
        }));
        row.resize(4 * width, [0; 2]);
        stream.write_all(row.as_flattened())?;
    }
    stream.finish()?;
    writer.finish().map_err(Into::into)
}

/// Writes an image as OpenEXR: alpha, blue, green and red, 32 bits each, in compressed lines.
fn write_exr(out: &mut (impl Write + Seek), mut rows: Rows<'_>) -> exr::error::UnitResult {
    let TexelLayout { width, height, .. } = rows.layout;
    let channel = |name: &str| ChannelDescription::new(name, SampleType::F32, true);
    let channels = ["A", "B", "G", "R"].map(channel).into_iter().collect();
    let header = Header::new("vat".into(), (width, height), channels).with_encoding(
        exr::compression::Compression::ZIP16,
        BlockDescription::ScanLines,
        LineOrder::Increasing,
    );
    exr::block::write(out, [header].into_iter().collect(), true, |meta, chunks| {
        let mut compressor = chunks.sequential_blocks_compressor(&meta);
        let mut texels = Vec::new();
        for (number, index) in enumerate_ordered_header_block_indices(&meta.headers) {
            let mut data = Vec::new();
            for row in 0..index.pixel_size.height() {
                rows.read(index.pixel_position.y() + row, &mut texels)?;
                let is_used = |texel: usize| texel < texels.len();
                data.extend((0..width).flat_map(|texel| f32::from(u8::from(is_used(texel))).to_ne_bytes()));
                for channel in [2, 1, 0] {
                    let number = |texel: usize| texels.get(texel).map_or(0.0, |texel| texel[channel]);
                    data.extend((0..width).flat_map(|texel| number(texel).to_ne_bytes()));
                }
            }
            compressor.compress_block(number, UncompressedBlock { index, data })?;
        }
        Ok(())
    })
}
