//! Frames of one body, written one after another.

use std::borrow::Cow;
use std::fs;
use std::io::Write;
use std::path::Path;
use std::sync::Arc;

use super::obj::ObjTemplate;
use super::pc2::PointCache;
use super::plain::PlainObj;
use super::ply::Ply;
use super::{Format, OutputError, Sequence};
use crate::file::write_whole;
use crate::obj::{Document, Part};
use supple::Executor;
use supple::mesh::Mesh;

/// Where a body's surface came from.
#[derive(Clone, Copy, Debug)]
pub enum Source<'a> {
    /// Arrays: OBJ frames hold vertices and faces, and nothing else.
    Mesh(&'a Mesh),
    /// An OBJ file: OBJ frames and point caches hold all of its vertices, also where the body is one object of it;
    /// those of other objects stay as they are. PLY frames hold the body alone.
    Document(&'a Arc<Document>, &'a Part),
}

impl Source<'_> {
    fn mesh(&self) -> &Mesh {
        match self {
            Self::Mesh(mesh) => mesh,
            Self::Document(_, part) => part.mesh(),
        }
    }

    /// How many points a reader of a point cache must find in the input, which it is applied to: all `v` of an OBJ
    /// file, all vertices of other meshes.
    pub fn points(&self) -> usize {
        match self {
            Self::Mesh(mesh) => mesh.vertices().len(),
            Self::Document(document, _) => document.vertex_count(),
        }
    }

    /// About how many bytes a frame takes on disk; exactly, but for OBJ.
    pub fn frame_bytes(&self, format: Format) -> u64 {
        match (format, self) {
            (Format::Pc2, _) => 12 * self.points() as u64,
            (Format::Ply, _) => Ply::new(self.mesh()).len(self.mesh().vertices().len()),
            (Format::Obj, Self::Mesh(mesh)) => {
                // Nine digits and a point, thrice; and the indices with their blanks.
                let corners: usize = mesh.faces().map(<[u32]>::len).sum();
                let digits = mesh.vertices().len().checked_ilog10().unwrap_or(0) as usize + 2;
                (34 * mesh.vertices().len() + digits * corners + 2 * mesh.face_count()) as u64
            }
            (Format::Obj, Self::Document(document, _)) => document.bytes().len() as u64,
        }
    }
}

/// Writes the frames of one body.
///
/// Nothing is allocated per frame: the same buffers are filled again and again.
#[derive(Debug)]
pub struct FrameWriter {
    sequence: Sequence,
    vertices: usize,
    kind: Kind,
    buffer: Vec<u8>,
}

#[derive(Debug)]
enum Kind {
    Plain(PlainObj),
    Obj(Box<ObjTemplate>),
    Ply(Ply),
    Cache(PointCache, CachedPoints),
}

/// The points of a sample.
#[derive(Debug)]
struct CachedPoints {
    /// All points; those that the mesh does not have never change.
    points: Vec<[f32; 3]>,
    /// For each vertex of the mesh its point; none if they are the same.
    map: Option<Vec<u32>>,
}

impl FrameWriter {
    /// Starts a sequence: an older one of the same name and format is removed whole, the directory created.
    ///
    /// # Errors
    /// If the directory cannot be created or read, older frames cannot be removed, or the input of `source` has the
    /// name of a frame.
    pub fn create(sequence: Sequence, source: Source<'_>) -> Result<Self, OutputError> {
        Self::open(sequence, source, None)
    }

    /// Goes on with a sequence at frame `next`. Frames before it are left alone; those from it on are written again.
    ///
    /// # Errors
    /// As [`FrameWriter::create`]; a point cache that is missing, of another mesh, or too short.
    pub fn resume(sequence: Sequence, source: Source<'_>, next: u64) -> Result<Self, OutputError> {
        Self::open(sequence, source, Some(next))
    }

    fn open(sequence: Sequence, source: Source<'_>, next: Option<u64>) -> Result<Self, OutputError> {
        let directory = &sequence.directory;
        fs::create_dir_all(directory).map_err(OutputError::io("create", directory))?;
        if let Source::Document(document, _) = source {
            sequence.spare(document.path())?;
        }
        match next {
            None => sequence.remove_existing()?,
            Some(_) => sequence.remove_parts()?,
        }
        let kind = match (sequence.format, source) {
            (Format::Obj, Source::Mesh(mesh)) => Kind::Plain(PlainObj::new(mesh)),
            (Format::Obj, Source::Document(document, part)) => {
                Kind::Obj(Box::new(ObjTemplate::new(document, part, directory)))
            }
            (Format::Ply, source) => Kind::Ply(Ply::new(source.mesh())),
            (Format::Pc2, source) => {
                let points = CachedPoints::new(source);
                let count = points.points.len() as u32;
                let cache = match next {
                    None => PointCache::create(&sequence, count)?,
                    Some(next) => PointCache::resume(&sequence, count, sequence.frames_before(next))?,
                };
                Kind::Cache(cache, points)
            }
        };
        Ok(Self { sequence, vertices: source.mesh().vertices().len(), kind, buffer: Vec::new() })
    }

    /// Shares the work of a frame out from now on, where that pays; the bytes are the same.
    pub(crate) fn share(&mut self, executor: &Executor) {
        if let Kind::Obj(template) = &mut self.kind {
            template.share(executor);
        }
    }

    /// Whether [`FrameWriter::write`] looks at the normals that it is given; else they may be empty.
    pub fn needs_normals(&self) -> bool {
        matches!(self.kind, Kind::Ply(_))
    }

    /// Writes a frame: `positions` in world space and unit `normals`, one per vertex of the mesh.
    ///
    /// Frames of a point cache come in order, each once.
    ///
    /// # Errors
    /// If the system refuses (the half-written file is removed, frames before stay valid), or a position is not
    /// finite.
    ///
    /// # Panics
    /// If the arrays have another length than the mesh has vertices; empty `normals` are right where
    /// [`FrameWriter::needs_normals`] says so.
    pub fn write(
        &mut self,
        frame: u64,
        positions: &[[f32; 3]],
        normals: &[[f32; 3]],
    ) -> Result<(), OutputError> {
        assert_eq!(positions.len(), self.vertices, "one position per vertex");
        if let Some(vertex) =
            positions.iter().position(|point| point.iter().any(|number| !number.is_finite()))
        {
            return Err(OutputError::NotFinite { frame, vertex });
        }
        self.buffer.clear();
        match &mut self.kind {
            Kind::Plain(plain) => plain.fill(positions, &mut self.buffer),
            Kind::Obj(template) => {
                template.fill(positions);
                return replace(&self.sequence.path(frame), template.texts());
            }
            Kind::Ply(ply) => {
                assert_eq!(normals.len(), self.vertices, "one normal per vertex");
                ply.fill(positions, normals, &mut self.buffer);
            }
            Kind::Cache(cache, points) => return cache.write(&points.sample(positions)),
        }
        replace(&self.sequence.path(frame), std::iter::once(&self.buffer[..]))
    }

    /// Ends the sequence: a point cache gets its final name. Without it the cache stays as `.part`, to be resumed.
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

/// Writes texts one after another to a file.
fn replace<'a>(path: &Path, mut texts: impl Iterator<Item = &'a [u8]>) -> Result<(), OutputError> {
    write_whole(path, |file| texts.try_for_each(|text| file.write_all(text)))
        .map_err(OutputError::io("write", path))
}

impl CachedPoints {
    fn new(source: Source<'_>) -> Self {
        match source {
            Source::Mesh(mesh) => Self { points: vec![[0.0; 3]; mesh.vertices().len()], map: None },
            Source::Document(document, part) => {
                Self { points: document.positions().to_vec(), map: Some(part.vertices().collect()) }
            }
        }
    }

    /// The bytes of a sample with the vertices of the mesh at `positions`.
    fn sample(&mut self, positions: &[[f32; 3]]) -> Cow<'_, [u8]> {
        match &self.map {
            None => self.points.copy_from_slice(positions),
            Some(map) => map.iter().zip(positions).for_each(|(&point, &at)| self.points[point as usize] = at),
        }
        if cfg!(target_endian = "little") {
            return bytemuck::cast_slice(&self.points).into();
        }
        self.points.iter().flatten().flat_map(|number| number.to_le_bytes()).collect()
    }
}
