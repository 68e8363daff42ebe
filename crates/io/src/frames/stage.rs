//! Writes the USD stage of a run. Its frames go into the file `NAME.usd.part` one after another; when the run ends, the
//! structure of the stage follows them, and the file becomes `NAME.usd`. A later run continues it after any frame. The
//! stage of a package is `NAME.usdz.usd.part` until the run ends, and then goes into `NAME.usdz` with its images.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::PathBuf;

use nalgebra::Vector3;
use supple::{Body, Simulation};

use super::broken_surface::BrokenSurface;
use super::error::check_finite;
use super::library_path::write_images;
use super::normal_transform::NormalTransform;
use super::record::{Compare, Record};
use super::single_file::{check_frames, no_frames, too_short, without};
use super::sink::{BodyFrame, Ending, FrameRun, FrameSink};
use super::{OutputError, Sequence, Source};
use crate::file::{create_part, part_path, write_durably};
use crate::space::FileSpace;
use crate::usd::{
    BodyInput, CONTENTS, FRAMES, PACKAGED_STAGE, Packed, PiecesBuilder, Places, Stage, StageDescription, head,
};

/// Size of the beginning of a file that does not depend on its end, in bytes.
const SIGNATURE: usize = 16;

/// A stage that is being written.
#[derive(Debug)]
pub(super) struct StageWriter {
    path: PathBuf,
    /// Path of the package of the stage, if it has one.
    package: Option<PathBuf>,
    file: File,
    stage: Stage,
    /// For each body with normals, their computation.
    normals: Vec<Option<NormalTransform>>,
    /// Number of frames in the file, and the offset of their end.
    frames: u64,
    end: u64,
    /// The velocities, if the stage has them.
    velocities: Option<Velocities>,
    /// Bytes of the frame so far, and the number of its bodies.
    frame: Vec<u8>,
    bodies: usize,
    /// Bytes of the pieces of the bodies so far.
    pieces: PiecesBuilder,
    /// The pieces of bodies that were broken in this run of the program, by the index of the body.
    broken: BTreeMap<usize, BrokenSurface>,
    /// The bodies that are broken in the last frame of the file and in the frame that is built, with the identity of
    /// their pieces.
    written: BTreeMap<usize, u64>,
    added: BTreeMap<usize, u64>,
    /// Scratch: normals of corners, and all `vn`.
    corners: Vec<[f32; 3]>,
    directions: Vec<[f32; 3]>,
}

/// The velocities of the points of a body in a frame.
#[derive(Debug)]
struct Velocities {
    space: FileSpace,
    /// Seconds of the simulation in a second of the file.
    rate: f64,
    of_points: Vec<[f32; 3]>,
}

impl Velocities {
    /// Returns the velocities of the points of a body, in units of length of the file per second of the file. `pace`:
    /// simulated seconds per second of the frames.
    fn of_points(&mut self, body: &Body, pace: f64) -> &[[f32; 3]] {
        let scale = self.space.length(self.rate * pace);
        let of_file =
            |velocity: Vector3<f64>| self.space.direction((velocity * scale).into()).map(|x| x as f32);
        self.of_points.clear();
        self.of_points.extend(body.surface_velocities().into_iter().map(of_file));
        &self.of_points
    }
}

impl StageWriter {
    /// Starts a stage, or continues a finished or unfinished one after the frames that `run` keeps. Changes nothing if
    /// it cannot be continued. `package`: path of the package of the stage, if it has one.
    pub(super) fn open(
        sequence: &Sequence,
        run: &FrameRun<'_>,
        package: Option<PathBuf>,
    ) -> Result<Self, OutputError> {
        let &FrameRun { simulation, ref sources, fps, space, ref options, kept, .. } = run;
        let &Sequence { first, every, .. } = sequence;
        let directory = sequence.directory.clone();
        let has_velocities = options.usd_velocities;
        let description = StageDescription {
            directory,
            space,
            meters_per_unit: options.meters_per_unit,
            fps,
            first,
            every,
            is_packed: package.is_some(),
            has_velocities,
        };
        // A frame of the simulation is one of the file, which may be played at another rate.
        let rate = fps / simulation.fps().unwrap_or(1.0 / simulation.dt());
        let velocities = has_velocities.then(|| Velocities { space, rate, of_points: Vec::new() });
        let stage = Stage::new(simulation, sources.iter().copied().map(input), description);
        for (source, body) in sources.iter().zip(simulation.bodies()) {
            if let Some((document, _)) = source.file() {
                write_images(document, &sequence.directory, body.name())?;
            }
        }
        let path = sequence.path(0);
        let mut places = Places::none();
        let mut file = match kept {
            None => create_part(&path),
            Some(frames) => {
                sequence.check_continued_path()?;
                if let Some(reason) = problem(sequence, &[])? {
                    return Err(OutputError::Cache { path, reason });
                }
                let existing = sequence.continued_path();
                let find = File::open(&existing)
                    .and_then(|mut file| Places::find(&mut file, stage.frame_bytes(), frames));
                match find.map_err(OutputError::io("read", &existing))? {
                    Ok(found) => places = found,
                    Err(complete) => {
                        return Err(OutputError::Cache { path, reason: too_short(complete, frames) });
                    }
                }
                let (existing, part) = (sequence.continued_path(), part_path(&path));
                let rename = || if existing == part { Ok(()) } else { fs::rename(&existing, &part) };
                rename().and_then(|()| File::options().write(true).open(&part))
            }
        }
        .map_err(OutputError::io("write", &path))?;
        truncate(&mut file, places.end).map_err(OutputError::io("write", &path))?;
        let transform = |(source, surface): (&Source<'_>, &crate::usd::Surface)| match source {
            Source::Document(document, part) if surface.normals().is_some() => {
                Some(NormalTransform::new(document, part))
            }
            _ => None,
        };
        Ok(Self {
            normals: sources.iter().zip(stage.bodies()).map(transform).collect(),
            path,
            package,
            file,
            stage,
            velocities,
            frames: kept.unwrap_or(0),
            end: places.end,
            frame: Vec::new(),
            bodies: 0,
            pieces: PiecesBuilder::default(),
            broken: BTreeMap::new(),
            written: places.last_broken().collect(),
            added: BTreeMap::new(),
            corners: Vec::new(),
            directions: Vec::new(),
        })
    }

    /// Completes the stage in the file, whose path it returns, with the images of its package.
    fn complete(self) -> Result<(PathBuf, Packed), OutputError> {
        let Self { path, file, stage, frames, .. } = self;
        drop(file);
        let part = part_path(&path);
        let complete = || {
            let mut file = File::options().read(true).write(true).open(&part)?;
            let packed = stage.complete(&mut file, frames)?;
            file.sync_all()?;
            Ok(packed)
        };
        let packed = complete().map_err(OutputError::io("write", &path))?;
        Ok((part, packed))
    }
}

impl FrameSink for StageWriter {
    /// Adds the positions of the mesh and its pieces.
    ///
    /// # Panics
    /// If there is not one position per vertex of the mesh.
    fn push_body(&mut self, body: &BodyFrame<'_>) -> Result<Option<Record>, OutputError> {
        let &BodyFrame { number, positions, ref pieces, pace, body, .. } = body;
        let Self { stage, normals, velocities, bodies, corners, directions, broken, written, added, .. } =
            self;
        let surface = &stage.bodies()[*bodies];
        let vertices = pieces.as_ref().map_or(surface.points(), |pieces| pieces.mesh.vertices().len());
        assert_eq!(positions.len(), vertices, "there is one position per mesh vertex");
        check_finite(number, positions)?;
        let velocities = velocities.as_mut().map(|velocities| velocities.of_points(body, pace));
        let mut transform = normals[*bodies].as_ref();
        if let Some(pieces) = pieces {
            if broken.get(bodies).is_none_or(|broken| broken.identity != pieces.identity) {
                broken.insert(*bodies, BrokenSurface::new(pieces, transform.is_some()));
            }
            let BrokenSurface { identity, topology, normals } = &broken[bodies];
            transform = normals.as_ref();
            directions.clear();
            if let Some(transform) = transform {
                transform.transform(0..transform.len(), positions, corners, directions);
            }
            let is_new = written.get(bodies) != Some(identity);
            added.insert(*bodies, *identity);
            let vectors = [positions, velocities.unwrap_or_default(), directions];
            self.pieces.push((*bodies, *identity), vectors, is_new.then_some(topology));
        }
        // The first vertices of the pieces, and the first `vn`, are those of the whole body.
        let whole = &positions[..surface.points()];
        let vn = surface.normals().zip(transform).map(|(vn, transform)| {
            transform.transform(0..transform.len(), positions, corners, directions);
            vn.iter().map(|&vn| directions[vn as usize])
        });
        let velocities = velocities.map(|velocities| &velocities[..surface.points()]);
        stage.push_body(&mut self.frame, whole, positions, velocities, vn);
        *bodies += 1;
        Ok(None)
    }

    /// Writes the frame with the added bodies and the colliders. If this fails, truncates the file after the previous
    /// frame.
    fn finish_frame(&mut self, simulation: &Simulation) -> Result<Option<Record>, OutputError> {
        self.stage.push_colliders(&mut self.frame, simulation);
        debug_assert_eq!(
            self.frame.len() as u64,
            self.stage.frame_bytes(),
            "all frames have the size of the layout"
        );
        self.pieces.finish(&mut self.frame);
        let record = Record::of(&self.frame);
        let written = self.file.write_all(&self.frame);
        let bytes = self.frame.len() as u64;
        let added = std::mem::take(&mut self.added);
        self.discard();
        if let Err(error) = written {
            // The write error is returned; an error of the truncation would add nothing.
            let _ = truncate(&mut self.file, self.end);
            return Err(OutputError::io("write", &self.path)(error));
        }
        self.written = added;
        self.frames += 1;
        self.end += bytes;
        Ok(Some(record))
    }

    fn discard(&mut self) {
        self.frame.clear();
        self.pieces.clear();
        self.added.clear();
        self.bodies = 0;
    }

    fn take_unsynced(&mut self) -> Vec<PathBuf> {
        vec![part_path(&self.path)]
    }

    /// Completes the stage, and gives the file its final name when it is on disk. Or writes the package of the stage,
    /// and removes the stage if the run is complete.
    fn finish(mut self: Box<Self>, ending: Ending) -> Result<Vec<String>, OutputError> {
        let (path, package) = (self.path.clone(), self.package.take());
        let (part, packed) = self.complete()?;
        let Some(package) = package else {
            fs::rename(&part, &path).map_err(OutputError::io("rename to", &path))?;
            return Ok(Vec::new());
        };
        let mut stage = File::open(&part).map_err(OutputError::io("read", &part))?;
        write_durably(&package, |file| packed.write(file, &mut stage))
            .map_err(OutputError::io("write", &package))?;
        if ending == Ending::Complete {
            drop(stage);
            fs::remove_file(&part).map_err(OutputError::io("remove", &part))?;
        }
        let file = package.file_name().unwrap_or_default().to_string_lossy();
        Ok(without(&file, packed.left_out()).collect())
    }
}

/// Returns the input of a body.
fn input(source: Source<'_>) -> BodyInput {
    match source {
        Source::Mesh(mesh) => (mesh.clone(), None),
        Source::Document(document, part) => (part.mesh().clone(), Some((document.clone(), part.clone()))),
    }
}

/// Truncates a file at `end`, the end of a frame, and seeks there.
fn truncate(file: &mut File, end: u64) -> std::io::Result<()> {
    file.set_len(end)?;
    file.seek(SeekFrom::Start(0))?;
    file.write_all(&head(0, 0))?;
    file.seek(SeekFrom::End(0)).map(drop)
}

/// Returns whether a stage with the frames of `records` has its final name and its structure.
pub(super) fn is_complete(
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

/// Returns why an existing stage cannot be continued after the frames of `records`; `None` if it can.
fn problem(sequence: &Sequence, records: &[Record]) -> Result<Option<String>, OutputError> {
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
    let mut end = FRAMES;
    let mut is_complete = |record: &Record| {
        end += record.bytes;
        end <= length
    };
    let (complete, frames) =
        (records.iter().take_while(|record| is_complete(record)).count() as u64, records.len() as u64);
    Ok((complete < frames).then(|| too_short(complete, frames)))
}

/// Compares a stage with the records of its frames. Returns the problem if they differ.
pub(super) fn check(
    sequence: &Sequence,
    records: &[Record],
    compare: Compare,
) -> Result<Option<String>, OutputError> {
    if records.is_empty() {
        return Ok(None);
    }
    if let Some(reason) = problem(sequence, records)? {
        return Ok(Some(format!("cannot continue {}: {reason}", sequence.continued_path().display())));
    }
    check_frames(sequence, records, compare, FRAMES)
}

/// Compares the frames of an unfinished package, or a finished one, with the records of the frames. Returns the problem
/// if they differ. `continues`: whether frames are added.
pub(super) fn check_package(
    sequence: &Sequence,
    records: &[Record],
    compare: Compare,
    continues: bool,
) -> Result<Option<String>, OutputError> {
    let stage = sequence.frames();
    if records.is_empty() || part_path(&stage.path(0)).exists() {
        return check(&stage, records, compare);
    }
    let path = sequence.path(0);
    if continues {
        return Ok(Some(no_frames(&path)));
    }
    let length = match fs::metadata(&path) {
        Ok(found) if found.is_file() => found.len(),
        _ => return Ok(Some(format!("{} is missing", path.display()))),
    };
    let start = PACKAGED_STAGE + FRAMES;
    if length < start + records.iter().map(|record| record.bytes).sum::<u64>() {
        return Ok(Some(format!("{} is incomplete or was changed", path.display())));
    }
    check_frames(sequence, records, compare, start)
}
