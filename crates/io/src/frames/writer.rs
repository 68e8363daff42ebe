//! Writes the frames of one body.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use super::error::check_finite;
use super::library_path::write_own_library;
use super::listing::{Listing, check_inputs};
use super::obj::ObjTemplate;
use super::pc2::PointCache;
use super::pieces::Pieces;
use super::plain::PlainObj;
use super::ply::Ply;
use super::record::{Record, Recorder};
use super::sink::{BodyFrame, Ending, FrameRun, FrameSink};
use super::{Format, OutputError, Sequence, Source};
use crate::file::write_atomically;

/// Writes the frames of one body.
///
/// The buffers are reused for all frames.
#[derive(Debug)]
pub struct FrameWriter {
    sequence: Sequence,
    vertices: usize,
    kind: Kind,
    /// The texts of the pieces of a broken body, and the identity of the pieces.
    pieces: Option<(u64, Kind)>,
    buffer: Vec<u8>,
    /// Numbers of the frames whose files are not flushed to disk yet.
    unsynced: Vec<u64>,
}

#[derive(Debug)]
enum Kind {
    Plain(PlainObj),
    Obj(Box<ObjTemplate>),
    Ply(Ply),
    Cache(PointCache, CachedPoints),
}

impl Kind {
    /// Returns the texts of the pieces of a broken body; `None` if the format has the same faces in all frames.
    fn of_pieces(&self, sequence: &Sequence, pieces: &Pieces<'_>) -> Option<Self> {
        let Sequence { directory, name, .. } = sequence;
        match (self, pieces.source) {
            (Self::Obj(whole), Source::Document(_, part)) => {
                Some(Self::Obj(Box::new(whole.of_pieces(part, directory, pieces, name))))
            }
            (Self::Plain(_) | Self::Obj(_), _) => Some(Self::Plain(PlainObj::of_pieces(pieces, name))),
            (Self::Ply(_), _) => Some(Self::Ply(Ply::new(pieces.mesh))),
            (Self::Cache(..), _) => None,
        }
    }
}

/// Points of one frame of a point cache.
#[derive(Debug)]
struct CachedPoints {
    /// All points. Points that are not vertices of the mesh never change.
    points: Vec<[f32; 3]>,
    /// Index of the point of each mesh vertex; `None` if the indices are equal.
    map: Option<Vec<u32>>,
}

impl FrameWriter {
    /// Starts a sequence. Creates the directory, and removes all files of an older sequence with the same
    /// name and format.
    ///
    /// # Errors
    /// If the directory cannot be created or read, older frames cannot be removed, or a frame would replace
    /// the input of `source`. Also for a format with one file per run.
    pub fn create(sequence: Sequence, source: Source<'_>) -> Result<Self, OutputError> {
        let existing = Self::prepare(&sequence, source)?;
        existing.remove_all()?;
        Self::open(sequence, source, None)
    }

    /// Continues a sequence at frame `next`. Keeps earlier frames. The caller writes frame `next` and the
    /// following frames again.
    ///
    /// # Errors
    /// As [`FrameWriter::create`]. Also if a point cache is missing, is too short, or has another number of
    /// points, first frame or frame interval.
    pub fn resume(sequence: Sequence, source: Source<'_>, next: u64) -> Result<Self, OutputError> {
        let existing = Self::prepare(&sequence, source)?;
        existing.remove_parts()?;
        let kept = sequence.frames_before(next);
        Self::open(sequence, source, Some(kept))
    }

    /// Creates the directory, checks that no input is replaced, and lists the existing files of the sequence.
    fn prepare(sequence: &Sequence, source: Source<'_>) -> Result<Listing, OutputError> {
        sequence.check_length()?;
        let format = sequence.format;
        if !matches!(format, Format::Obj | Format::Ply | Format::Pc2) {
            return Err(OutputError::NotPerBody { format });
        }
        let directory = &sequence.directory;
        fs::create_dir_all(directory).map_err(OutputError::io("create", directory))?;
        let sequence = std::slice::from_ref(sequence);
        if let Source::Document(document, _) = source {
            check_inputs(sequence, &[], std::iter::once(document.path()))?;
        }
        Listing::read(sequence)
    }

    /// Opens the writer of a body of a run, which formats OBJ frames of an OBJ file with the threads of the simulation.
    /// The bytes do not depend on the threads.
    pub(super) fn of_run(sequence: Sequence, body: usize, run: &FrameRun<'_>) -> Result<Self, OutputError> {
        let mut writer = Self::open(sequence, run.sources[body], run.kept)?;
        if let Kind::Obj(template) = &mut writer.kind {
            template.set_executor(run.simulation.executor());
        }
        Ok(writer)
    }

    /// Opens a writer in a directory that exists and in which no files are in the way. Continues the sequence
    /// after its first `kept` frames, or starts a sequence if `kept` is `None`.
    fn open(sequence: Sequence, source: Source<'_>, kept: Option<u64>) -> Result<Self, OutputError> {
        let directory = &sequence.directory;
        let kind = match (sequence.format, source) {
            (Format::Obj, Source::Mesh(mesh)) => Kind::Plain(PlainObj::new(mesh)),
            (Format::Obj, Source::Document(document, part)) => {
                write_own_library(document, &sequence)?;
                Kind::Obj(Box::new(ObjTemplate::new(document, part, directory, &sequence.name)))
            }
            (Format::Ply, source) => Kind::Ply(Ply::new(source.mesh())),
            (Format::Pc2, source) => {
                let points = CachedPoints::new(source);
                let count = points.points.len() as u32;
                let cache = match kept {
                    None => PointCache::create(&sequence, count)?,
                    Some(kept) => PointCache::resume(&sequence, count, kept)?,
                };
                Kind::Cache(cache, points)
            }
            (format, _) => return Err(OutputError::NotPerBody { format }),
        };
        Ok(Self {
            sequence,
            vertices: source.mesh().vertices().len(),
            kind,
            pieces: None,
            buffer: Vec::new(),
            unsynced: Vec::new(),
        })
    }

    /// Returns whether [`FrameWriter::write`] uses the normals. If it does not, they may be empty.
    pub fn needs_normals(&self) -> bool {
        matches!(self.kind, Kind::Ply(_))
    }

    /// Writes a frame from `positions` in world space and unit `normals`, one of each per mesh vertex.
    ///
    /// The frames of a point cache must be written in order, each one once.
    ///
    /// # Errors
    /// If the file cannot be written, or a position is not finite. Earlier frames stay valid, and no
    /// incomplete frame remains.
    ///
    /// # Panics
    /// If the length of `positions` is not the number of mesh vertices. If [`FrameWriter::needs_normals`]
    /// returns true, also if the length of `normals` is not the number of mesh vertices.
    pub fn write(
        &mut self,
        frame: u64,
        positions: &[[f32; 3]],
        normals: &[[f32; 3]],
    ) -> Result<(), OutputError> {
        self.write_recorded(frame, positions, normals, None).map(drop)
    }

    /// As [`FrameWriter::write`], for a broken body: `positions` and `normals` have one entry per vertex of the mesh of
    /// its pieces.
    ///
    /// # Errors
    /// As [`FrameWriter::write`]. Also for a point cache, whose points are those of the whole mesh.
    ///
    /// # Panics
    /// As [`FrameWriter::write`], for the vertices of the pieces.
    pub fn write_pieces(
        &mut self,
        frame: u64,
        positions: &[[f32; 3]],
        normals: &[[f32; 3]],
        pieces: &Pieces<'_>,
    ) -> Result<(), OutputError> {
        self.write_recorded(frame, positions, normals, Some(pieces)).map(drop)
    }

    /// As [`FrameWriter::write`], or as [`FrameWriter::write_pieces`] if `pieces` is given. Returns the record of the
    /// frame.
    fn write_recorded(
        &mut self,
        frame: u64,
        positions: &[[f32; 3]],
        normals: &[[f32; 3]],
        pieces: Option<&Pieces<'_>>,
    ) -> Result<Record, OutputError> {
        let vertices = pieces.map_or(self.vertices, |pieces| pieces.mesh.vertices().len());
        assert_eq!(positions.len(), vertices, "there is one position per mesh vertex");
        check_finite(frame, positions)?;
        self.buffer.clear();
        let path = self.sequence.path(frame);
        if let Some(pieces) = pieces
            && self.pieces.as_ref().is_none_or(|(identity, _)| *identity != pieces.identity)
        {
            let kind = self.kind.of_pieces(&self.sequence, pieces);
            let Some(kind) = kind else {
                let Sequence { name, format, .. } = &self.sequence;
                return Err(OutputError::Broken { frame, body: name.clone(), format: *format });
            };
            self.pieces = Some((pieces.identity, kind));
        }
        let kind = match &mut self.pieces {
            Some((_, kind)) if pieces.is_some() => kind,
            _ => &mut self.kind,
        };
        let record = match kind {
            Kind::Plain(plain) => {
                plain.fill(positions, &mut self.buffer);
                write_texts(&path, std::iter::once(&self.buffer[..]))?
            }
            Kind::Obj(template) => {
                template.fill(positions);
                write_texts(&path, template.texts())?
            }
            Kind::Ply(ply) => {
                assert_eq!(normals.len(), vertices, "there is one normal per mesh vertex");
                ply.fill(positions, normals, &mut self.buffer);
                write_texts(&path, std::iter::once(&self.buffer[..]))?
            }
            Kind::Cache(cache, points) => {
                return cache.write(points.placed(positions));
            }
        };
        self.unsynced.push(frame);
        Ok(record)
    }

    /// Ends the sequence: renames a point cache to its final name. Without this call the cache stays a
    /// `.part` file, which can be resumed.
    ///
    /// # Errors
    /// If the file cannot be renamed.
    pub fn finish(self) -> Result<(), OutputError> {
        match self.kind {
            Kind::Cache(cache, _) => cache.finish(),
            _ => Ok(()),
        }
    }
}

impl FrameSink for FrameWriter {
    fn needs_normals(&self) -> bool {
        self.needs_normals()
    }

    fn push_body(&mut self, body: &BodyFrame<'_>) -> Result<Option<Record>, OutputError> {
        let &BodyFrame { number, positions, normals, ref pieces, .. } = body;
        self.write_recorded(number, positions, normals, pieces.as_ref()).map(Some)
    }

    fn take_unsynced(&mut self) -> Vec<PathBuf> {
        match &self.kind {
            Kind::Cache(cache, _) => vec![cache.part_path()],
            _ => self.unsynced.drain(..).map(|frame| self.sequence.path(frame)).collect(),
        }
    }

    fn finish(self: Box<Self>, _: Ending) -> Result<Vec<String>, OutputError> {
        (*self).finish().map(|()| Vec::new())
    }
}

/// Writes `texts` in order to the file at `path`, atomically, and returns the record of the file.
fn write_texts<'a>(path: &Path, mut texts: impl Iterator<Item = &'a [u8]>) -> Result<Record, OutputError> {
    let mut recorder = Recorder::default();
    let write = |file: &mut fs::File| {
        texts.try_for_each(|text| {
            recorder.append(text);
            file.write_all(text)
        })
    };
    write_atomically(path, write).map_err(OutputError::io("write", path))?;
    Ok(recorder.record())
}

impl CachedPoints {
    fn new(source: Source<'_>) -> Self {
        match source {
            Source::Mesh(mesh) => Self { points: vec![[0.0; 3]; mesh.vertices().len()], map: None },
            Source::Document(document, part) => {
                let points = document.positions().iter().map(|position| position.map(|x| x as f32)).collect();
                Self { points, map: Some(part.vertices().collect()) }
            }
        }
    }

    /// Returns all points, with the mesh vertices at `positions`.
    fn placed(&mut self, positions: &[[f32; 3]]) -> &[[f32; 3]] {
        match &self.map {
            None => self.points.copy_from_slice(positions),
            Some(map) => map.iter().zip(positions).for_each(|(&point, &to)| self.points[point as usize] = to),
        }
        &self.points
    }
}
