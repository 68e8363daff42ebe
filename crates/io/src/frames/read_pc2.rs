//! Reads Point Cache 2 files: see `pc2` for the format.

use std::io::{Error, ErrorKind};
use std::path::Path;

use crate::file;

/// The positions of a point cache.
#[derive(Clone, Debug, PartialEq)]
pub struct PointCacheData {
    /// Number of points in a sample.
    pub points: usize,
    /// Frame of the first sample.
    pub first_frame: f64,
    /// Number of frames from one sample to the next, > 0.
    pub frames_per_sample: f64,
    /// Positions of the points, sample by sample.
    pub positions: Vec<[f32; 3]>,
}

/// Reads a point cache.
///
/// # Errors
///
/// If the file cannot be read, or is not a point cache of version 1 with at least one whole sample.
pub fn read_pc2(path: impl AsRef<Path>) -> Result<PointCacheData, Error> {
    let bytes = file::read(path.as_ref(), u64::MAX)?;
    let invalid = |problem: String| Error::new(ErrorKind::InvalidData, problem);
    let Some((header, rest)) = bytes.split_first_chunk::<32>() else {
        return Err(invalid(format!("not a PC2 file: it has {} bytes, and the header has 32", bytes.len())));
    };
    if !header.starts_with(b"POINTCACHE2\0") {
        return Err(invalid("not a PC2 file: it does not begin with POINTCACHE2".to_owned()));
    }
    let word = |offset: usize| [0, 1, 2, 3].map(|k| header[offset + k]);
    let [version, points, samples] = [12, 16, 28].map(|offset| i32::from_le_bytes(word(offset)));
    let [first_frame, frames_per_sample] = [20, 24].map(|offset| f32::from_le_bytes(word(offset)));
    if version != 1 {
        return Err(invalid(format!("the PC2 file has version {version}; only version 1 is known")));
    }
    let (Ok(points), Ok(count)) = (usize::try_from(points), usize::try_from(samples)) else {
        return Err(invalid(format!("the PC2 file has {samples} samples of {points} points")));
    };
    if points == 0 || count == 0 {
        return Err(invalid(format!(
            "the PC2 file has {count} samples of {points} points; export at least one"
        )));
    }
    if !(first_frame.is_finite() && frames_per_sample.is_finite() && frames_per_sample > 0.0) {
        return Err(invalid(format!(
            "the PC2 file has a sample every {frames_per_sample} frames from frame {first_frame} on"
        )));
    }
    let size = count.checked_mul(points).and_then(|positions| positions.checked_mul(12));
    let Some(data) = size.and_then(|size| rest.get(..size)) else {
        let size = rest.len();
        return Err(invalid(format!(
            "the PC2 file is incomplete: it has {size} bytes of positions for {count} samples of {points} points"
        )));
    };
    let positions = data.as_chunks::<12>().0.iter().map(|point| {
        [0, 4, 8].map(|k| f32::from_le_bytes([point[k], point[k + 1], point[k + 2], point[k + 3]]))
    });
    Ok(PointCacheData {
        points,
        first_frame: first_frame.into(),
        frames_per_sample: frames_per_sample.into(),
        positions: positions.collect(),
    })
}
