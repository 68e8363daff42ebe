//! Films of runs that are on disk: of pages, and of folders with pages or frames.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use supple::{Executor, Mesh};

use crate::collider;
use crate::escape::Escaped;
use crate::file::{self, write_durably};
use crate::film::{FilmFile, FilmOptions, Footage, Moment, PlaneAt, Solid, Surface, Tint, write_film};
use crate::html::{Playback, read_page};
use crate::model::read_document;
use crate::run::{MANIFEST, PAGE};
use crate::space::Up;

/// Rate of frames of which no manifest tells it, in 1/s.
const FPS: f64 = 30.0;
/// Distance of the ground below the lowest point of frames, relative to the height of the bodies in the first frame.
const GROUND: f64 = 1e-3;

/// Error of a film of a run on disk.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FilmError {
    /// The run cannot be read.
    #[error("cannot read {}: {source}", Escaped(path.display()))]
    Read {
        /// A page, a frame or a folder.
        path: PathBuf,
        /// Cause.
        source: io::Error,
    },
    /// A folder has nothing to show.
    #[error(
        "{} has neither a page {PAGE}.html nor frames like NAME_0000.obj or NAME_0000.ply: run the scene with --format \
         film, or with html, obj or ply",
        Escaped(path.display())
    )]
    NoRun {
        /// The folder.
        path: PathBuf,
    },
    /// A page has several runs.
    #[error("{} has {runs} runs, and a film shows one: give the page or the folder of one of them", Escaped(path.display()))]
    ManyRuns {
        /// The page.
        path: PathBuf,
        /// Number of its runs.
        runs: usize,
    },
    /// A frame of a body is missing.
    #[error("{} has no frame {frame} of {name}", Escaped(path.display()))]
    Missing {
        /// The folder.
        path: PathBuf,
        /// Number of the frame.
        frame: u64,
        /// The body.
        name: String,
    },
    /// The name of the film has another extension.
    #[error("{} is no name of a film: it must end in .webp or .gif", Escaped(path.display()))]
    Extension {
        /// The film.
        path: PathBuf,
    },
    /// The film cannot be written.
    #[error("cannot write {}: {source}", Escaped(path.display()))]
    Write {
        /// The film.
        path: PathBuf,
        /// Cause.
        source: io::Error,
    },
}

impl FilmError {
    /// Returns whether the cause is an invalid input or argument. In this case nothing was written.
    pub fn is_input(&self) -> bool {
        !matches!(self, Self::Write { .. })
    }
}

/// How a run on disk is shown.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct FilmRequest {
    /// The look.
    pub look: FilmOptions,
    /// Rate of the frames, above 0; by default that of the run, or 30 per second.
    pub fps: Option<f64>,
    /// Axis that points up in frames; y by default. Pages tell it.
    pub up: Up,
    /// Number of threads; 0, the default, uses all processors.
    pub threads: usize,
}

/// Writes a film of a run: of a page, or of a folder with the page `supple.html`, or else with OBJ or PLY frames. A
/// page has the colliders; frames of a folder have none, and are shown above a ground below their lowest point. The
/// extension of `output` is `.webp` or `.gif`; an existing film is replaced. Returns the number of frames.
///
/// # Errors
///
/// If the input cannot be read or has no frames, or if the film cannot be written.
pub fn film(input: &Path, output: &Path, request: &FilmRequest) -> Result<usize, FilmError> {
    let extension = output.extension().and_then(|extension| extension.to_str());
    let kind = match extension.map(str::to_ascii_lowercase).as_deref() {
        Some("webp") => FilmFile::Webp,
        Some("gif") => FilmFile::Gif,
        _ => return Err(FilmError::Extension { path: output.to_owned() }),
    };
    let read = |source| FilmError::Read { path: input.to_owned(), source };
    let is_folder = fs::metadata(input).map_err(read)?.is_dir();
    let page = if is_folder { input.join(format!("{PAGE}.html")) } else { input.to_owned() };
    let footage: Box<dyn Footage> = if !is_folder || page.is_file() {
        Box::new(of_page(&page)?)
    } else {
        Box::new(Frames::find(input, request.up)?)
    };
    let mut footage = Timed { fps: request.fps.unwrap_or(footage.fps()), footage, failed: false };
    let frames = footage.frames();
    let executor = Executor::new(request.threads);
    let written = write_durably(output, |file| {
        write_film(file, kind, &mut footage, &request.look, &executor, "of a run on disk")
    });
    match written {
        Ok(()) => Ok(frames),
        // What stopped the film is a frame.
        Err(source) if footage.failed => Err(read(source)),
        Err(source) => Err(FilmError::Write { path: output.to_owned(), source }),
    }
}

/// Reads the only run of a page.
fn of_page(path: &Path) -> Result<Playback<'static>, FilmError> {
    let read = |source| FilmError::Read { path: path.to_owned(), source };
    let mut runs = file::read(path, u64::MAX).and_then(|bytes| read_page(&bytes)).map_err(read)?;
    let count = runs.len();
    match (runs.pop(), count) {
        (Some(run), 1) if run.header.frames > 0 => Playback::new(run).map_err(read),
        (Some(_), 1) => Err(read(io::Error::other("it has no frames"))),
        _ => Err(FilmError::ManyRuns { path: path.to_owned(), runs: count }),
    }
}

/// A motion that is shown at a rate, and whether it could not be read.
struct Timed {
    footage: Box<dyn Footage>,
    fps: f64,
    failed: bool,
}

impl Footage for Timed {
    fn frames(&self) -> usize {
        self.footage.frames()
    }

    fn fps(&self) -> f64 {
        self.fps
    }

    fn up(&self) -> [f64; 3] {
        self.footage.up()
    }

    fn read(&mut self, frame: usize) -> io::Result<Moment> {
        self.footage.read(frame).inspect_err(|_| self.failed = true)
    }
}

/// Triangles of a mesh, and its surface.
type LastSurface = (Vec<[u32; 3]>, Arc<Surface>);

/// OBJ or PLY frames of a folder.
struct Frames {
    /// The files of each frame, one per body.
    files: Vec<Vec<PathBuf>>,
    fps: f64,
    up: Up,
    /// For each body, its triangles in the last frame that was read.
    surfaces: Vec<Option<LastSurface>>,
    ground: f64,
}

impl Frames {
    fn find(folder: &Path, up: Up) -> Result<Self, FilmError> {
        let read = |source| FilmError::Read { path: folder.to_owned(), source };
        // For each format and body, the files by their numbers.
        let mut found: [BTreeMap<String, BTreeMap<u64, PathBuf>>; 2] = Default::default();
        for entry in fs::read_dir(folder).map_err(read)? {
            let path = entry.map_err(read)?.path();
            let parts =
                path.file_stem().and_then(|stem| stem.to_str()).and_then(|stem| stem.rsplit_once('_'));
            let kind =
                ["obj", "ply"].iter().position(|kind| path.extension().is_some_and(|own| own == *kind));
            let (Some((name, digits)), Some(kind)) = (parts, kind) else { continue };
            if digits.len() >= 4
                && let Ok(number) = digits.parse()
            {
                found[kind].entry(name.to_owned()).or_default().insert(number, path);
            }
        }
        let [obj, ply] = found;
        let bodies = if obj.is_empty() { ply } else { obj };
        let Some(first) = bodies.values().next() else {
            return Err(FilmError::NoRun { path: folder.to_owned() });
        };
        let mut files = Vec::new();
        for &frame in first.keys() {
            let of_body = |(name, files): (&String, &BTreeMap<u64, PathBuf>)| {
                let missing = || FilmError::Missing { path: folder.to_owned(), frame, name: name.clone() };
                files.get(&frame).cloned().ok_or_else(missing)
            };
            files.push(bodies.iter().map(of_body).collect::<Result<Vec<_>, _>>()?);
        }
        let surfaces = vec![None; bodies.len()];
        let mut frames =
            Self { files, fps: rate(folder).unwrap_or(FPS), up, surfaces, ground: f64::NEG_INFINITY };
        frames.ground = frames.lowest().map_err(read)?;
        Ok(frames)
    }

    /// Returns the height of the ground, just below the lowest point of all frames.
    fn lowest(&mut self) -> io::Result<f64> {
        let axis = if self.up == Up::Z { 2 } else { 1 };
        let (mut lowest, mut first) = (f64::INFINITY, [f64::INFINITY, f64::NEG_INFINITY]);
        for frame in 0..self.files.len() {
            for solid in self.read(frame)?.bodies {
                for point in &solid.positions {
                    let height = f64::from(point[axis]);
                    lowest = lowest.min(height);
                    if frame == 0 {
                        first = [first[0].min(height), first[1].max(height)];
                    }
                }
            }
        }
        Ok(lowest - GROUND * (first[1] - first[0]))
    }

    /// Returns the surface of a body whose mesh is read, which is the one before if the triangles are the same.
    fn surface(
        &mut self,
        body: usize,
        mesh: &Mesh,
        positions: &[[f32; 3]],
        colors: &[Option<[f32; 3]>],
    ) -> Arc<Surface> {
        if let Some((triangles, surface)) = &self.surfaces[body]
            && triangles == mesh.triangles()
        {
            return surface.clone();
        }
        // A face of n corners has n - 2 triangles, in the order of the faces.
        let faces = mesh
            .faces()
            .zip(0..)
            .flat_map(|(face, index)| std::iter::repeat_n(index, face.len().saturating_sub(2)));
        let tint = |face: usize| colors.get(face).copied().flatten().map_or(Tint::Palette, Tint::Material);
        let tints = faces.map(tint).collect();
        let surface = Arc::new(Surface::new(positions, mesh.triangles(), mesh.weld(), tints));
        self.surfaces[body] = Some((mesh.triangles().to_vec(), surface.clone()));
        surface
    }
}

/// Returns the rate of the frames of a folder that its manifest tells.
fn rate(folder: &Path) -> Option<f64> {
    let manifest: serde_json::Value = serde_json::from_slice(&fs::read(folder.join(MANIFEST)).ok()?).ok()?;
    let rate = manifest["fps"].as_f64()? / manifest["every"].as_f64()?;
    (rate.is_finite() && rate > 0.0).then_some(rate)
}

impl Footage for Frames {
    fn frames(&self) -> usize {
        self.files.len()
    }

    fn fps(&self) -> f64 {
        self.fps
    }

    fn up(&self) -> [f64; 3] {
        if self.up == Up::Z { [0.0, 0.0, 1.0] } else { [0.0, 1.0, 0.0] }
    }

    fn read(&mut self, frame: usize) -> io::Result<Moment> {
        let mut moment = Moment::default();
        for (body, path) in self.files[frame].clone().iter().enumerate() {
            let document = Arc::new(read_document(path).map_err(io::Error::other)?);
            let part = document.part(None).map_err(io::Error::other)?;
            let (mesh, colors) = (part.mesh(), document.face_colors(&part));
            let positions: Vec<_> = mesh.vertices().iter().copied().map(collider::finite).collect();
            let surface = self.surface(body, mesh, &positions, &colors);
            moment.bodies.push(Solid { surface, positions, volume: None });
        }
        if self.ground.is_finite() {
            let up = self.up();
            moment.planes.push(PlaneAt { point: up.map(|axis| axis * self.ground), normal: up });
        }
        Ok(moment)
    }
}
