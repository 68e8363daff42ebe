//! Compares a file that has all frames of a sequence with the records of the frames, and says what it does not have.

use std::path::Path;

use super::record::{Compare, Record};
use super::{OutputError, Sequence};
use crate::count::counted;

/// Returns the problem of a file with `complete` frames, of which `frames` are to be kept.
pub(super) fn too_short(complete: u64, frames: u64) -> String {
    format!("it has {complete} of {} to keep", counted(frames as usize, "frame"))
}

/// Returns the problem of a file whose frame with the number `index` in the file is not that of its record.
pub(super) fn changed(sequence: &Sequence, index: u64, path: &Path) -> String {
    let number = sequence.first + index * sequence.every;
    format!("frame {number} of {} has changed since it was written", path.display())
}

/// Returns the problem of a complete file that is to get more frames.
pub(super) fn no_frames(path: &Path) -> String {
    format!("the frames of {} are not kept any more, as it is complete, or were removed", path.display())
}

/// Returns the problem of a complete file that says of its frames what their records do not.
pub(super) fn other_frames(path: &Path) -> String {
    format!("{} has other frames, or was changed", path.display())
}

/// Returns lines about images that a file cannot have.
pub(super) fn without<'a>(
    file: &str,
    images: impl Iterator<Item = &'a Path>,
) -> impl Iterator<Item = String> {
    images.map(move |image| {
        let image = image.display();
        format!("{file}: without the image {image}: it cannot be read, or is neither PNG nor JPEG")
    })
}

/// Compares the contents of the frames of [`Sequence::continued_path`] with their records. `start`: offset of the first
/// frame. Returns the problem if they differ.
pub(super) fn check_frames(
    sequence: &Sequence,
    records: &[Record],
    compare: Compare,
    mut start: u64,
) -> Result<Option<String>, OutputError> {
    if compare == Compare::Sizes {
        return Ok(None);
    }
    let path = sequence.continued_path();
    for (record, index) in records.iter().zip(0..) {
        let found = Record::of_range(&path, start, record.bytes).map_err(OutputError::io("read", &path))?;
        if found != *record {
            return Ok(Some(changed(sequence, index, &path)));
        }
        start += record.bytes;
    }
    Ok(None)
}
