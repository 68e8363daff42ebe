//! Writes the page or the film of a run. Its frames are kept in the file `NAME.html.data` until the run ends, and then
//! become the page `NAME.html`, from which a later run can take them again.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};

use supple::Simulation;

use super::error::check_finite;
use super::film::{self, Film};
use super::page_data::{self, Data, DataFrames, data_path, run_of};
use super::pieces::Pieces;
use super::record::{Compare, Record, hash_of_frames};
use super::single_file::{changed, no_frames, other_frames, too_short};
use super::sink::{BodyFrame, Ending, FrameRun, FrameSink};
use super::{OutputError, Sequence};
use crate::collider;
use crate::file::{self, is_link, write_durably};
use crate::film::read_facts;
use crate::html::{
    BrokenBody, FrameBuilder, FrameSource, Header, Layout, Run, Topology, animated_positions, read_page,
    write_page,
};
use crate::space::FileSpace;

/// A page or a film that is being written, as `NAME.html.data` or the data of a film.
#[derive(Debug)]
pub(super) struct PageWriter {
    sequence: Sequence,
    /// The film; `None` for a page.
    film: Option<Film>,
    /// Coordinates of the page.
    space: FileSpace,
    /// Whether the frames have the volumes of the bodies; otherwise they are zero.
    has_volumes: bool,
    data: Data,
    frame: FrameBuilder,
    /// Number of the bodies that were added to the frame.
    bodies: usize,
    /// The bodies that are broken in the last frame of the file and in the frame that is built, with the identity of
    /// their pieces.
    written: BTreeMap<usize, u64>,
    broken: BTreeMap<usize, u64>,
}

impl PageWriter {
    /// Starts a page or a film, or continues a finished or unfinished page, or an unfinished film, after the frames that
    /// `run` keeps, and removes later frames.
    pub(super) fn open(sequence: Sequence, run: &FrameRun<'_>) -> Result<Self, OutputError> {
        let &FrameRun { simulation, ref name, fps, space, kept, .. } = run;
        let (mut header, arrays) = Header::new(simulation, name, fps, sequence.first, sequence.every, space);
        let film = Film::of(&sequence, run);
        if film.is_some() {
            header.set_colors(&run.sources.iter().map(film::colors).collect::<Vec<_>>());
        }
        let has_volumes = film.as_ref().is_none_or(Film::has_volumes);
        let path = data_path(&sequence);
        let (mut data, written) = match kept {
            None => (page_data::create(&path, &header, &arrays)?, BTreeMap::new()),
            Some(samples) => resume(&sequence, &header, samples)?,
        };
        data.truncate(kept.unwrap_or(0)).map_err(OutputError::io("write", &path))?;
        let (frame, bodies, broken) = (FrameBuilder::default(), 0, BTreeMap::new());
        Ok(Self { sequence, film, space, has_volumes, data, frame, bodies, written, broken })
    }
}

/// Opens the data of a finished or unfinished page that continues after its first `samples` frames. `header` describes
/// the run; the page keeps its own description. Changes nothing if the page cannot be continued. Also returns the bodies
/// that are broken in the last of the `samples` frames, with the identity of their pieces.
fn resume(
    sequence: &Sequence,
    header: &Header,
    samples: u64,
) -> Result<(Data, BTreeMap<usize, u64>), OutputError> {
    check_link(sequence)?;
    let path = data_path(sequence);
    let page = sequence.path(0);
    let invalid = |reason: String| OutputError::Cache { path: page.clone(), reason };
    if !path.exists() {
        page_data::create_from(&path, &mut read_run(&page)?)?;
    }
    let mut data = page_data::open(&path)?;
    if data.layout != Layout::new(header) {
        return Err(invalid("it has other bodies, lattices or colliders".to_owned()));
    }
    let complete = data.complete();
    if complete < samples {
        return Err(invalid(too_short(complete, samples)));
    }
    let mut written = BTreeMap::new();
    if samples > 0 {
        let last = data.read_frame(samples - 1).map_err(OutputError::io("read", &path))?;
        let broken = data.layout.broken(&last);
        let broken = broken.ok_or_else(|| invalid("the last frame to keep was changed".to_owned()))?;
        written.extend(broken.iter().map(|broken| (broken.body, broken.identity)));
    }
    Ok((data, written))
}

impl FrameSink for PageWriter {
    /// Adds the positions of the mesh and its lattice, its volumes at rest, before and after the correction, and its
    /// pieces.
    fn push_body(&mut self, body: &BodyFrame<'_>) -> Result<Option<Record>, OutputError> {
        let &BodyFrame { number, positions, pieces, displayed, .. } = body;
        let space = self.space;
        check_finite(number, positions)?;
        let lattice = displayed.positions().map(|point| space.position(point.into()));
        let lattice: Vec<[f32; 3]> = lattice.map(|point| point.map(|number| number as f32)).collect();
        check_finite(number, &lattice)?;
        let volumes = self.has_volumes.then(|| {
            let volumes = body.volumes();
            [volumes.rest, volumes.before, volumes.after].map(|v| space.volume(v))
        });
        self.frame.push_volumes(volumes.unwrap_or_default());
        self.frame.push_mesh(positions);
        self.frame.push_lattice(&lattice);
        if let Some(Pieces { identity, mesh, origin, lattice: of_body, .. }) = pieces {
            let broken = BrokenBody { body: self.bodies, identity, points: [positions.len(), lattice.len()] };
            let is_new = self.written.get(&broken.body) != Some(&broken.identity);
            let topology = is_new.then(|| Topology::new(mesh, origin.face_sources(), of_body));
            self.frame.push_broken(&broken, topology.as_ref());
            self.broken.insert(broken.body, broken.identity);
        }
        self.bodies += 1;
        Ok(None)
    }

    /// Writes the frame with the added bodies and the colliders. If this fails, truncates the file after the previous
    /// frame.
    fn finish_frame(&mut self, simulation: &Simulation) -> Result<Option<Record>, OutputError> {
        let space = self.space;
        // An observer can replace the colliders of the simulation. The page shows those of the first frame.
        for index in 0..self.data.layout.colliders() {
            let pose = collider::pose(simulation, index);
            self.frame
                .push_pose(pose.map(|(translate, rotate)| (space.position(translate), space.angles(rotate))));
        }
        let mut animated = animated_positions(simulation, space);
        for points in self.data.layout.animated() {
            let positions = animated.next().filter(|positions| positions.len() == points);
            self.frame.push_mesh(&positions.unwrap_or_else(|| vec![[0.0; 3]; points]));
        }
        drop(animated);
        let frame = self.frame.finish();
        self.data.append(frame).map_err(OutputError::io("write", &data_path(&self.sequence)))?;
        self.written = std::mem::take(&mut self.broken);
        self.bodies = 0;
        Ok(Some(Record::of(frame)))
    }

    fn discard(&mut self) {
        self.frame = FrameBuilder::default();
        self.broken.clear();
        self.bodies = 0;
    }

    fn take_unsynced(&mut self) -> Vec<PathBuf> {
        vec![data_path(&self.sequence)]
    }

    fn finish(self: Box<Self>, ending: Ending) -> Result<Vec<String>, OutputError> {
        let Self { sequence, film, data, .. } = *self;
        match film {
            Some(film) => film.write(&sequence, data, ending)?,
            None => complete(&sequence, data)?,
        }
        Ok(Vec::new())
    }
}

/// Writes the page of its data, and removes the data.
fn complete(sequence: &Sequence, data: Data) -> Result<(), OutputError> {
    let (path, data_path) = (sequence.path(0), data_path(sequence));
    let mut runs = [run_of(&data_path, &data)?];
    let write = |file: &mut File| {
        let mut out = BufWriter::new(file);
        write_page(&mut out, &mut runs)?;
        out.flush()
    };
    write_durably(&path, write).map_err(OutputError::io("write", &path))?;
    drop((runs, data));
    fs::remove_file(&data_path).map_err(OutputError::io("remove", &data_path))
}

/// Reads the only run of a page.
fn read_run(path: &Path) -> Result<Run<'static>, OutputError> {
    let invalid = |reason: &str| OutputError::Cache { path: path.to_owned(), reason: reason.to_owned() };
    let bytes = match file::read(path, u64::MAX) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Err(invalid("it is missing")),
        bytes => bytes.map_err(OutputError::io("read", path))?,
    };
    let runs = read_page(&bytes).map_err(|error| invalid(&error.to_string()))?;
    match <[Run<'static>; 1]>::try_from(runs) {
        Ok([run]) => Ok(run),
        Err(_) => Err(invalid("it has several runs")),
    }
}

/// Returns an error if an existing page or its data are a link, which would have to be followed to continue them.
pub(super) fn check_link(sequence: &Sequence) -> Result<(), OutputError> {
    for path in [data_path(sequence), sequence.path(0)] {
        if is_link(&path) {
            return Err(OutputError::Link { path });
        }
        if path.exists() {
            break;
        }
    }
    Ok(())
}

/// Compares a page or its data with the records of the frames. Returns the problem if they differ.
pub(super) fn check(
    sequence: &Sequence,
    records: &[Record],
    compare: Compare,
) -> Result<Option<String>, OutputError> {
    match check_frames(sequence, records, compare) {
        Err(OutputError::Cache { path, reason }) => {
            Ok(Some(format!("cannot continue {}: {reason}", path.display())))
        }
        checked => checked,
    }
}

fn check_frames(
    sequence: &Sequence,
    records: &[Record],
    compare: Compare,
) -> Result<Option<String>, OutputError> {
    if records.is_empty() {
        return Ok(None);
    }
    let (data_path, page) = (data_path(sequence), sequence.path(0));
    let (path, found, mut frames): (_, _, Box<dyn FrameSource>) = if data_path.exists() {
        let data = page_data::open(&data_path)?;
        let frames = DataFrames::open(&data_path, &data)?;
        (&data_path, data.complete(), Box::new(frames))
    } else {
        let run = read_run(&page)?;
        (&page, run.header.frames as u64, run.frames)
    };
    let invalid = |reason: String| Err(OutputError::Cache { path: path.clone(), reason });
    if found < records.len() as u64 {
        return invalid(too_short(found, records.len() as u64));
    }
    for (index, record) in records.iter().enumerate() {
        let size = frames.frame_bytes(index);
        if size != record.bytes {
            let number = sequence.first + index as u64 * sequence.every;
            return invalid(format!("its frame {number} has {size} instead of {} bytes", record.bytes));
        }
    }
    if compare == Compare::Sizes {
        return Ok(None);
    }
    let mut frame = Vec::new();
    for (index, record) in records.iter().enumerate() {
        frames.read_frame(index, &mut frame).map_err(OutputError::io("read", path))?;
        if Record::of(&frame) != *record {
            return Ok(Some(changed(sequence, index as u64, path)));
        }
    }
    Ok(None)
}

/// Compares the frames of an unfinished film, or a finished one, with the records of the frames. Returns the problem if
/// they differ. `continues`: whether frames are added.
pub(super) fn check_film(
    sequence: &Sequence,
    records: &[Record],
    compare: Compare,
    continues: bool,
) -> Result<Option<String>, OutputError> {
    let path = sequence.path(0);
    if records.is_empty() || data_path(sequence).exists() {
        return check(sequence, records, compare);
    }
    if continues {
        return Ok(Some(no_frames(&path)));
    }
    if !path.is_file() {
        return Ok(Some(format!("{} is missing", path.display())));
    }
    let found = read_facts(&path).map_err(OutputError::io("read", &path))?;
    let is_same = found == Some(film::facts(records.len(), hash_of_frames(records)));
    Ok((!is_same).then(|| other_frames(&path)))
}

/// Writes the page of unfinished data that have all frames, without the frames after `records`.
pub(super) fn finish(sequence: &Sequence, records: &[Record]) -> Result<(), OutputError> {
    let data_path = data_path(sequence);
    if !data_path.exists() {
        return Ok(());
    }
    check_link(sequence)?;
    let mut data = page_data::open(&data_path)?;
    data.truncate(records.len() as u64).map_err(OutputError::io("write", &data_path))?;
    complete(sequence, data)
}
