//! Writes the USD stage of a run. Its frames go into the file `NAME.usd.part` one after another; when the run ends, the
//! structure of the stage follows them, and the file becomes `NAME.usd`. A later run continues it after any frame.

use std::fs::{self, File};
use std::io::{ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::PathBuf;

use supple::Simulation;

use super::error::check_finite;
use super::normal_transform::NormalTransform;
use super::record::{Compare, Record};
use super::{OutputError, Sequence, Source};
use crate::count::counted;
use crate::file::{create_part, part_path};
use crate::usd::{BodyInput, CONTENTS, FRAMES, Stage, StageDescription, head};

/// Size of the beginning of a file that does not depend on its end, in bytes.
const SIGNATURE: usize = 16;

/// A stage that is being written.
#[derive(Debug)]
pub(crate) struct StageWriter {
    path: PathBuf,
    file: File,
    stage: Stage,
    /// For each body with normals, their computation.
    normals: Vec<Option<NormalTransform>>,
    /// Number of frames in the file.
    frames: u64,
    /// Bytes of the frame so far, and the number of its bodies.
    frame: Vec<u8>,
    bodies: usize,
    /// Scratch: normals of corners, and all `vn`.
    corners: Vec<[f32; 3]>,
    directions: Vec<[f32; 3]>,
}

impl StageWriter {
    /// Starts a stage, or continues a finished or unfinished one after its first `kept` frames. Changes nothing if it
    /// cannot be continued. `sources` has one entry per body.
    pub(crate) fn open<'a>(
        sequence: &Sequence,
        simulation: &Simulation,
        sources: impl Iterator<Item = Source<'a>>,
        description: StageDescription,
        kept: Option<u64>,
    ) -> Result<Self, OutputError> {
        let sources: Vec<Source<'a>> = sources.collect();
        let stage = Stage::new(simulation, sources.iter().copied().map(input), description);
        let path = sequence.path(0);
        let mut file = match kept {
            None => create_part(&path),
            Some(frames) => {
                sequence.check_continued_path()?;
                if let Some(reason) = problem(sequence, stage.frame_bytes(), frames)? {
                    return Err(OutputError::Cache { path, reason });
                }
                let (existing, part) = (sequence.continued_path(), part_path(&path));
                let rename = || if existing == part { Ok(()) } else { fs::rename(&existing, &part) };
                rename().and_then(|()| File::options().write(true).open(&part))
            }
        }
        .map_err(OutputError::io("write", &path))?;
        let kept = kept.unwrap_or(0);
        truncate(&mut file, stage.frame_bytes(), kept).map_err(OutputError::io("write", &path))?;
        let transform = |(source, surface): (&Source<'_>, &crate::usd::Surface)| match source {
            Source::Document(document, part) if surface.normals().is_some() => {
                Some(NormalTransform::new(document, part))
            }
            _ => None,
        };
        Ok(Self {
            normals: sources.iter().zip(stage.bodies()).map(transform).collect(),
            path,
            file,
            stage,
            frames: kept,
            frame: Vec::new(),
            bodies: 0,
            corners: Vec::new(),
            directions: Vec::new(),
        })
    }

    /// Adds the next body to frame `frame`: the positions of its mesh, in the coordinates of the file.
    ///
    /// # Panics
    /// If there is not one position per vertex of the mesh.
    pub(crate) fn push_body(&mut self, frame: u64, positions: &[[f32; 3]]) -> Result<(), OutputError> {
        let Self { stage, normals, bodies, corners, directions, .. } = self;
        let surface = &stage.bodies()[*bodies];
        assert_eq!(positions.len(), surface.points(), "there is one position per mesh vertex");
        check_finite(frame, positions)?;
        let vn = surface.normals().zip(normals[*bodies].as_ref()).map(|(vn, transform)| {
            transform.transform(0..transform.len(), positions, corners, directions);
            vn.iter().map(|&vn| directions[vn as usize])
        });
        stage.push_body(&mut self.frame, positions, vn);
        *bodies += 1;
        Ok(())
    }

    /// Writes the frame with the added bodies and the colliders, and returns its record. If this fails, truncates the
    /// file after the previous frame.
    pub(crate) fn write(&mut self, simulation: &Simulation) -> Result<Record, OutputError> {
        self.stage.push_colliders(&mut self.frame, simulation);
        debug_assert_eq!(
            self.frame.len() as u64,
            self.stage.frame_bytes(),
            "all frames have the size of the layout"
        );
        let record = Record::of(&self.frame);
        let written = self.file.write_all(&self.frame);
        self.discard();
        if let Err(error) = written {
            // The write error is returned; an error of the truncation would add nothing.
            let _ = truncate(&mut self.file, self.stage.frame_bytes(), self.frames);
            return Err(OutputError::io("write", &self.path)(error));
        }
        self.frames += 1;
        Ok(record)
    }

    /// Forgets the bodies that were added to the frame.
    pub(crate) fn discard(&mut self) {
        self.frame.clear();
        self.bodies = 0;
    }

    /// Returns the path of the file while frames are written.
    pub(crate) fn part_path(&self) -> PathBuf {
        part_path(&self.path)
    }

    /// Completes the stage, and gives the file its final name when it is on disk.
    pub(crate) fn finish(self) -> Result<(), OutputError> {
        let Self { path, file, stage, frames, .. } = self;
        drop(file);
        let part = part_path(&path);
        let complete = || {
            let mut file = File::options().read(true).write(true).open(&part)?;
            stage.complete(&mut file, frames)?;
            file.sync_all()
        };
        complete().map_err(OutputError::io("write", &path))?;
        fs::rename(&part, &path).map_err(OutputError::io("rename to", &path))
    }
}

/// Returns the input of a body.
fn input(source: Source<'_>) -> BodyInput {
    match source {
        Source::Mesh(mesh) => (mesh.clone(), None),
        Source::Document(document, part) => (part.mesh().clone(), Some((document.clone(), part.clone()))),
    }
}

/// Removes all but the first `frames` frames from a file, and seeks to its end.
fn truncate(file: &mut File, frame_bytes: u64, frames: u64) -> std::io::Result<()> {
    file.set_len(FRAMES + frames * frame_bytes)?;
    file.seek(SeekFrom::Start(0))?;
    file.write_all(&head(0, 0))?;
    file.seek(SeekFrom::End(0)).map(drop)
}

/// Returns whether a stage with the frames of `records` has its final name and its structure.
pub(crate) fn is_complete(
    sequence: &Sequence,
    records: &[Record],
    compare: Compare,
) -> Result<bool, OutputError> {
    let path = sequence.path(0);
    if sequence.continued_path() != path {
        return Ok(false);
    }
    let mut found = [0; FRAMES as usize];
    let mut read = || {
        let mut file = File::open(&path)?;
        let length = file.metadata()?.len();
        // A file that is shorter keeps zeros.
        match file.read_exact(&mut found) {
            Err(error) if error.kind() != ErrorKind::UnexpectedEof => Err(error),
            _ => Ok(length),
        }
    };
    let length = read().map_err(OutputError::io("read", &path))?;
    let contents = u64::from_le_bytes(std::array::from_fn(|byte| found[16 + byte]));
    let start = FRAMES + records.iter().map(|record| record.bytes).sum::<u64>();
    if length < start || contents.checked_add(CONTENTS) != Some(length) {
        return Ok(false);
    }
    if compare == Compare::Sizes {
        return Ok(true);
    }
    let after = Record::of_range(&path, start, length - start).map_err(OutputError::io("read", &path))?;
    Ok(found == head(contents, after.hash))
}

/// Returns why an existing stage cannot be continued after `frames` frames of `frame_bytes` bytes; `None` if it can.
fn problem(sequence: &Sequence, frame_bytes: u64, frames: u64) -> Result<Option<String>, OutputError> {
    let path = sequence.continued_path();
    let failed = |error| OutputError::io("read", &path)(error);
    let mut file = match File::open(&path) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Some("it is missing".to_owned())),
        file => file.map_err(failed)?,
    };
    let mut found = [0; SIGNATURE];
    let length = file.metadata().map_err(failed)?.len();
    match file.read_exact(&mut found) {
        Err(error) if error.kind() == ErrorKind::UnexpectedEof => {}
        result => result.map_err(failed)?,
    }
    if found != head(0, 0)[..SIGNATURE] {
        return Ok(Some("its beginning is incomplete or was changed".to_owned()));
    }
    let complete = length.saturating_sub(FRAMES) / frame_bytes.max(1);
    let kept = counted(frames as usize, "frame");
    Ok((complete < frames).then(|| format!("it has {complete} of {kept} to keep")))
}

/// Compares a stage with the records of its frames. Returns the problem if they differ.
pub(super) fn check(
    sequence: &Sequence,
    records: &[Record],
    compare: Compare,
) -> Result<Option<String>, OutputError> {
    let Some(first) = records.first() else { return Ok(None) };
    let path = sequence.continued_path();
    let text = path.display();
    if let Some(reason) = problem(sequence, first.bytes, records.len() as u64)? {
        return Ok(Some(format!("cannot continue {text}: {reason}")));
    }
    if compare == Compare::Sizes {
        return Ok(None);
    }
    let mut start = FRAMES;
    for (record, index) in records.iter().zip(0..) {
        let found = Record::of_range(&path, start, record.bytes).map_err(OutputError::io("read", &path))?;
        if found != *record {
            let number = sequence.first + index * sequence.every;
            return Ok(Some(format!("frame {number} of {text} has changed since it was written")));
        }
        start += record.bytes;
    }
    Ok(None)
}
