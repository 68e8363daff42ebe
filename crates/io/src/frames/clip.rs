//! Writes clips: files that need all frames of a motion, the GLB file of a run and the textures of a body. Until the run
//! ends, the frames are kept in the point cache `NAME.glb.pc2.part` or `NAME.vat.pc2.part`.

use std::fs::{self, File};
use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};
use supple::Simulation;

use super::error::check_finite;
use super::normal_transform::NormalTransform;
use super::pc2::{self, PointCache, SampleReader};
use super::record::{Compare, Record, hash_of_frames};
use super::single_file::{no_frames, other_frames, without};
use super::sink::{BodyFrame, Ending, FrameRun, FrameSink};
use super::{Format, OutputError, Sequence};
use crate::file::{parent, part_path, remove_if_present, write_durably};
use crate::glb::{
    self, BodyPoints, ColliderSurface, Materials, Samples, SceneDescription, SplitSurface, write_scene,
};
use crate::space::{FileSpace, Up};
use crate::vat::{self, MAX_SIZE, TexelLayout, VatEncoding, write_textures};

/// A clip that is being written.
#[derive(Debug)]
pub(super) struct ClipWriter {
    sequence: Sequence,
    cache: PointCache,
    bodies: Vec<Body>,
    colliders: Vec<ColliderSurface>,
    materials: Materials,
    /// Whether the clip has all bodies of the run, or one.
    is_run: bool,
    /// Name of the run.
    name: String,
    /// Time between frames, in seconds.
    interval: f64,
    /// Largest error, relative to the size of a body.
    tolerance: f64,
    /// Encoding of textures.
    encoding: VatEncoding,
    /// The coordinates of files, and those of glTF in them: y up, in meters.
    spaces: [FileSpace; 2],
    /// Positions and normals of the bodies of the frame that is built, and the number of these bodies.
    sample: Vec<[f32; 3]>,
    added: usize,
    /// Scratch: normals of corners, and all `vn`.
    corners: Vec<[f32; 3]>,
    directions: Vec<[f32; 3]>,
}

#[derive(Debug)]
struct Body {
    name: String,
    surface: SplitSurface,
    /// The computation of the `vn` of the file, if the surface has them.
    normals: Option<NormalTransform>,
    /// Index of its first point in a sample.
    first: usize,
}

impl Body {
    fn points(&self) -> BodyPoints<'_> {
        BodyPoints { name: &self.name, surface: &self.surface, first: self.first }
    }
}

impl ClipWriter {
    /// Starts a clip, or continues the frames of an unfinished one. `body`: the index of the body of a clip that has one.
    pub(super) fn open(sequence: Sequence, body: usize, run: &FrameRun<'_>) -> Result<Self, OutputError> {
        let is_run = sequence.format.is_per_run();
        let of_clip = if is_run { 0..run.sources.len() } else { body..body + 1 };
        let mut materials = Materials::default();
        let (mut bodies, mut points) = (Vec::new(), 0);
        for (source, body) in run.sources[of_clip.clone()].iter().zip(&run.simulation.bodies()[of_clip]) {
            let file = source.file();
            let surface = SplitSurface::new(source.mesh(), file, &mut materials);
            let normals = file.filter(|_| surface.has_file_normals());
            let normals = normals.map(|(document, part)| NormalTransform::new(document, part));
            let (first, name) = (points, body.name().to_owned());
            points += 2 * surface.len();
            bodies.push(Body { name, surface, normals, first });
        }
        let mut colliders = Vec::new();
        let count = if is_run { run.simulation.collider_count() } else { 0 };
        for index in 0..count {
            let collider = ColliderSurface::new(run.simulation, index, points, &mut materials);
            points += collider.as_ref().map_or(0, ColliderSurface::len);
            colliders.extend(collider);
        }
        let data = sequence.frames();
        let count = u32::try_from(points).map_err(|_| OutputError::Cache {
            path: sequence.path(0),
            reason: "its bodies have more than 2^31 vertices".to_owned(),
        })?;
        if sequence.format == Format::Vat {
            // Without its last file, the folder of an earlier run is not complete.
            let info = sequence.path(0);
            let folder = parent(&info);
            fs::create_dir_all(folder).map_err(OutputError::io("create", folder))?;
            remove_if_present(&info).map_err(OutputError::io("remove", &info))?;
        }
        let cache = match run.kept {
            None => PointCache::create(&data, count)?,
            Some(kept) => PointCache::resume(&data, count, kept)?,
        };
        Ok(Self {
            cache,
            bodies,
            colliders,
            materials,
            name: run.name.clone(),
            interval: sequence.every as f64 / run.fps,
            is_run,
            tolerance: run.options.glb_error,
            encoding: run.options.vat_encoding,
            spaces: [run.space, FileSpace::new(run.space.up(), Up::Y, run.options.meters_per_unit)],
            sequence,
            sample: Vec::new(),
            added: 0,
            corners: Vec::new(),
            directions: Vec::new(),
        })
    }

    /// Writes the frame that is built.
    fn write_sample(&mut self) -> Result<Record, OutputError> {
        let written = self.cache.write(&self.sample);
        self.discard();
        written
    }

    /// Writes the clip. Returns lines about it.
    fn write(&self) -> Result<Vec<String>, OutputError> {
        let path = self.sequence.path(0);
        let mut samples = self.cache.reader()?;
        let hash = hash(&mut samples).map_err(OutputError::io("read", &path))?;
        let extras = extras(samples.samples(), hash);
        match (self.sequence.format, &self.bodies[..]) {
            (Format::Vat, [body]) => {
                let run = (self.interval.recip(), extras);
                let points = body.points();
                let materials = &self.materials;
                let written = write_textures(&path, &points, self.encoding, run, materials, &mut samples);
                let left_out = written.map_err(OutputError::io("write", &path))?;
                Ok(without(&format!("{}_vat", body.name), left_out.iter().map(PathBuf::as_path)).collect())
            }
            _ => self.write_glb(&path, extras, &mut samples),
        }
    }

    /// Writes the GLB file.
    fn write_glb(
        &self,
        path: &Path,
        extras: Value,
        samples: &mut SampleReader,
    ) -> Result<Vec<String>, OutputError> {
        let description =
            SceneDescription { name: &self.name, interval: self.interval, tolerance: self.tolerance, extras };
        let bodies: Vec<BodyPoints<'_>> = self.bodies.iter().map(Body::points).collect();
        let colliders = (&self.colliders[..], self.spaces);
        let mut written = None;
        let write = |file: &mut File| {
            written = Some(write_scene(file, &description, &bodies, colliders, &self.materials, samples)?);
            Ok(())
        };
        write_durably(path, write).map_err(OutputError::io("write", path))?;
        let (motions, left_out) = written.unwrap_or_default();
        let file = path.file_name().unwrap_or_default().to_string_lossy();
        let mut lines: Vec<String> = bodies
            .iter()
            .zip(motions)
            .map(|(body, motion)| {
                let targets = crate::count::counted(motion.targets, "morph target");
                format!("{file}: body {}: {targets}, error {:.1e} of its size", body.name, motion.error)
            })
            .collect();
        lines.extend(without(&file, left_out.iter().map(PathBuf::as_path)));
        Ok(lines)
    }
}

impl FrameSink for ClipWriter {
    fn needs_normals(&self) -> bool {
        self.bodies.iter().any(|body| body.normals.is_none())
    }

    fn push_body(&mut self, frame: &BodyFrame<'_>) -> Result<Option<Record>, OutputError> {
        let &BodyFrame { number, positions, normals, ref pieces, .. } = frame;
        let Self { bodies, sample, added, corners, directions, .. } = self;
        let body = &bodies[*added];
        if pieces.is_some() {
            return Err(OutputError::Broken {
                frame: number,
                body: body.name.clone(),
                format: self.sequence.format,
            });
        }
        check_finite(number, positions)?;
        sample.truncate(body.first);
        sample.extend(body.surface.positions(positions));
        match &body.normals {
            Some(transform) => {
                transform.transform(0..transform.len(), positions, corners, directions);
                sample.extend(body.surface.normals(directions).map(unit));
            }
            None => sample.extend(body.surface.normals(normals).map(unit)),
        }
        let (positions, normals) = sample[body.first..].split_at_mut(body.surface.len());
        self.spaces[1].convert_positions(positions);
        self.spaces[1].convert_directions(normals);
        *added += 1;
        if self.is_run { Ok(None) } else { self.write_sample().map(Some) }
    }

    fn finish_frame(&mut self, simulation: &Simulation) -> Result<Option<Record>, OutputError> {
        for collider in &self.colliders {
            collider.push(simulation, self.spaces, &mut self.sample);
        }
        self.write_sample().map(Some)
    }

    fn discard(&mut self) {
        self.sample.clear();
        self.added = 0;
    }

    fn take_unsynced(&mut self) -> Vec<PathBuf> {
        vec![self.cache.part_path()]
    }

    fn finish(self: Box<Self>, ending: Ending) -> Result<Vec<String>, OutputError> {
        let is_empty = self.cache.reader()?.samples() == 0;
        let path = self.sequence.path(0);
        let lines = if is_empty { Err(OutputError::NoFrames { path }) } else { Ok(self.write()?) };
        if ending == Ending::Complete {
            let data = self.cache.part_path();
            drop(self);
            fs::remove_file(&data).map_err(OutputError::io("remove", &data))?;
        }
        lines
    }
}

impl Samples for SampleReader {
    fn frames(&self) -> usize {
        self.samples()
    }

    fn read(&mut self, frame: usize, points: Range<usize>, out: &mut Vec<[f32; 3]>) -> io::Result<()> {
        self.read(frame, points, out)
    }
}

/// Returns a normal with length 1; a vertex whose normal is zero gets one upwards.
fn unit(normal: [f32; 3]) -> [f32; 3] {
    let normal = nalgebra::Vector3::from(normal);
    normal.try_normalize(f32::MIN_POSITIVE).map_or([0.0, 1.0, 0.0], Into::into)
}

/// Returns an error if the frames of a body are more texels than an image has, or if the folder of its textures cannot be
/// one.
pub(super) fn check_textures(
    sequence: &Sequence,
    body: usize,
    run: &FrameRun<'_>,
) -> Result<(), OutputError> {
    let source = &run.sources[body];
    let surface = SplitSurface::new(source.mesh(), source.file(), &mut Materials::default());
    let (vertices, frames) = (surface.len(), sequence.frames_before(sequence.last) as usize + 1);
    if TexelLayout::new(vertices, frames).is_none() {
        return Err(OutputError::Texels { body: sequence.name.clone(), vertices, frames, max: MAX_SIZE });
    }
    let info = sequence.path(0);
    let folder = parent(&info);
    match fs::symlink_metadata(folder) {
        Ok(found) if found.is_symlink() => Err(OutputError::Link { path: folder.to_owned() }),
        Ok(found) if !found.is_dir() => {
            Err(OutputError::io("create", folder)(io::ErrorKind::AlreadyExists.into()))
        }
        _ => Ok(()),
    }
}

/// Returns what a file says of its frames.
fn extras(frames: usize, hash: u64) -> Value {
    json!({ "frames": frames, "hash": format!("{hash:016x}") })
}

/// Returns the hash of all frames.
fn hash(samples: &mut SampleReader) -> io::Result<u64> {
    let records = (0..samples.samples()).map(|frame| samples.record(frame));
    Ok(hash_of_frames(&records.collect::<io::Result<Vec<_>>>()?))
}

/// Compares the frames of an unfinished file, or a finished one, with the records of the frames. Returns the problem if
/// they differ. `continues`: whether frames are added.
pub(super) fn check(
    sequence: &Sequence,
    records: &[Record],
    compare: Compare,
    continues: bool,
) -> Result<Option<String>, OutputError> {
    let (frames, path) = (sequence.frames(), sequence.path(0));
    if records.is_empty() || part_path(&frames.path(0)).exists() {
        return pc2::check(&frames, records, compare);
    }
    if continues {
        return Ok(Some(no_frames(&path)));
    }
    if let Some(missing) = sequence.whole_files().iter().find(|file| !file.is_file()) {
        return Ok(Some(format!("{} is missing", missing.display())));
    }
    let found = match sequence.format {
        Format::Vat => vat::read_extras(&path),
        _ => glb::read_extras(&path),
    };
    let found = found.map_err(OutputError::io("read", &path))?;
    let is_same = found == Some(extras(records.len(), hash_of_frames(records)));
    Ok((!is_same).then(|| other_frames(&path)))
}

/// Returns whether a file whose run has ended has its final form.
pub(super) fn is_complete(sequence: &Sequence) -> bool {
    !part_path(&sequence.frames().path(0)).exists()
}

/// Returns an error if the file with the frames is a link.
pub(super) fn check_link(sequence: &Sequence) -> Result<(), OutputError> {
    sequence.frames().check_continued_path()
}
