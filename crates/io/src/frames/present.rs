//! Compares the frames on disk with the records of an earlier run, and completes files with all frames.

use super::kinds::Found;
use super::listing::Listing;
use super::per_frame::Renames;
use super::record::{Compare, Record};
use super::{OutputError, Sequence};

/// Result of comparing the frames on disk with their records.
#[derive(Debug)]
pub(crate) enum Present {
    /// Every recorded frame exists, perhaps with more or fewer digits in its name.
    All(Renames),
    /// A recorded frame is missing or has changed. The text describes the problem.
    Not(String),
}

/// Compares the files of `sequences` with `records`: for each sequence, the record of each frame, in order
/// from the first frame of the sequence. `continues`: whether the run adds frames to them.
pub(crate) fn check(
    listing: &Listing,
    sequences: &[Sequence],
    records: &[&[Record]],
    (compare, continues): (Compare, bool),
) -> Result<Present, OutputError> {
    let mut renames = Renames::default();
    for (index, (sequence, records)) in sequences.iter().zip(records).enumerate() {
        let found = Found { files: listing.files(index), renames: &mut renames, continues };
        if let Some(problem) = (sequence.format.kind().check)(found, sequence, records, compare)? {
            return Ok(Present::Not(problem));
        }
    }
    Ok(Present::All(renames))
}

/// Gives the unfinished file of a sequence that has all frames its final form and name, without the frames after
/// `records`. Returns false if this needs the simulation.
pub(crate) fn finish(sequence: &Sequence, records: &[Record], compare: Compare) -> Result<bool, OutputError> {
    (sequence.format.kind().finish)(sequence, records, compare)
}

/// Returns an error if the existing file of a sequence is a link, which would have to be followed to continue it.
pub(crate) fn check_link(sequence: &Sequence) -> Result<(), OutputError> {
    (sequence.format.kind().check_link)(sequence)
}
