//! Defines [`Job`]: a scene, its output directory, and the options of the run.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::Duration;

use super::checkpoint::{CHECKPOINT, Checkpoint};
use super::error::RunError;
use super::lock::LOCK;
use super::manifest::{self, MANIFEST};
use super::report::Outcome;
use super::settings::Settings;
use super::states;
use super::stats;
use crate::file::{is_same_file, parent};
use crate::frames::{Format, Sequence, check_inputs};
use crate::scene::Scene;
use crate::space::{FileSpace, Up};

/// Name of the page and of the USD stage of a run, without its extension.
pub const PAGE: &str = "supple";

/// A scene, its output directory, and the options of the run.
#[derive(Clone, Debug)]
pub struct Job {
    /// Scene to simulate. Its `output.directory` is ignored; see [`Job::directory`].
    pub scene: Scene,
    /// Directory of the frames. It is created if it is missing.
    pub directory: PathBuf,
    /// Interval between written frames, in frames, at least 1; default 1.
    pub every: u32,
    /// Number of frame 0 (the rest pose) in file names; default 0. Frame `k` is written as number
    /// `start_frame + k`, for shots that are numbered 1001, 1002, ...; its time remains `k / fps`.
    pub start_frame: u32,
    /// Statistics file, `.csv` or `.json`, with one [`Row`](super::Row) per written frame and body; default
    /// `None`.
    pub stats: Option<PathBuf>,
    /// Whether to continue an earlier run; default [`Resume::No`].
    pub resume: Resume,
    /// Number of a frame, as in file names: the job continues an earlier run after the newest kept state or checkpoint
    /// at or before this frame, with the scene as it is now; default `None`. Up to there, the frames stay as they are;
    /// later ones are removed, and simulated and written anew. The number of the first frame starts a new run.
    ///
    /// The scene may have another gravity, number of steps, material, zones, volume options, pins, handles and fields,
    /// other contact settings, and other colliders, but the same number of them. It is an error if it has other bodies,
    /// meshes, lattices or frames per second, if the formats, their settings, `every` or `start_frame` differ, if a frame
    /// is missing, or if a format keeps no single frames once its file is complete (GLB, textures, films). States are kept
    /// with [`OutputData::states`](crate::scene::OutputData::states).
    pub from: Option<u32>,
    /// Whether a job that continues compares the contents of the frames with the hashes in the checkpoint;
    /// default false. Their sizes are always compared.
    pub verify: bool,
    /// Scene file, which no output may replace; default `None`. The meshes and animations of the scene are
    /// protected in any case.
    pub scene_file: Option<PathBuf>,
    /// Smallest wall-clock time between checkpoints; default 10 s.
    pub checkpoint_interval: Duration,
}

/// Whether a job continues an earlier run in its directory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Resume {
    /// The job starts at frame 0, and replaces an existing sequence.
    #[default]
    No,
    /// The job continues after the last checkpoint. It is an error if the checkpoint belongs to other settings, or is
    /// damaged.
    Yes,
    /// As [`Resume::Yes`], but where that is an error, the job starts at frame 0 as with [`Resume::No`], and
    /// [`Note::Restarted`](super::Note::Restarted) has the reason.
    Auto,
}

/// True is [`Resume::Yes`].
impl From<bool> for Resume {
    fn from(resume: bool) -> Self {
        if resume { Self::Yes } else { Self::No }
    }
}

impl Job {
    /// Creates a job that starts at frame 0 and writes every frame, without statistics.
    pub fn new(scene: Scene, directory: impl Into<PathBuf>) -> Self {
        Self {
            scene,
            directory: directory.into(),
            every: 1,
            start_frame: 0,
            stats: None,
            resume: Resume::No,
            from: None,
            verify: false,
            scene_file: None,
            checkpoint_interval: Duration::from_secs(10),
        }
    }

    /// Returns the file sequences: for each format of the scene those of all bodies in the order of the scene, or that
    /// of the run if a file of the format contains all bodies. The file of the run has the name [`PAGE`].
    pub fn sequences(&self) -> Vec<Sequence> {
        let sequence = |name: &str, format: Format| Sequence {
            directory: self.directory.clone(),
            name: name.to_owned(),
            format,
            first: self.number(0),
            every: u64::from(self.every),
            last: self.number(self.scene.simulation.frames),
        };
        let mut sequences = Vec::new();
        for format in self.scene.output.format.iter() {
            if format.is_per_run() {
                sequences.push(sequence(PAGE, format));
            } else {
                sequences.extend(self.scene.bodies.iter().map(|body| sequence(&body.name, format)));
            }
        }
        sequences
    }

    /// Returns the index of the body of a sequence that has one body.
    pub(super) fn body_of(&self, sequence: &Sequence) -> usize {
        self.scene.bodies.iter().position(|body| body.name == sequence.name).unwrap_or(0)
    }

    /// Returns the name of the run: that of the scene file, or else of the directory.
    pub(super) fn name(&self) -> String {
        let file = self.scene_file.as_deref().and_then(Path::file_stem);
        let directory = || std::fs::canonicalize(&self.directory).ok()?.file_name().map(ToOwned::to_owned);
        let name = file.map(ToOwned::to_owned).or_else(directory).unwrap_or_default();
        name.to_string_lossy().into_owned()
    }

    /// Returns the coordinates of the files.
    pub(super) fn space(&self) -> FileSpace {
        let (scene, output) = (Up::of_gravity(self.scene.simulation.gravity.value(0.0)), &self.scene.output);
        FileSpace::new(scene, output.up.unwrap_or(scene), output.scale)
    }

    /// Returns the rate at which the files are played, in frames per second.
    pub(super) fn fps(&self) -> f64 {
        self.scene.output.fps.unwrap_or(self.scene.simulation.fps)
    }

    /// Writes the manifest of the job, whose files are complete. `checkpoint` is that of the last frame.
    pub(super) fn write_manifest(&self, checkpoint: &Checkpoint, outcome: Outcome) -> Result<(), RunError> {
        let bodies = self.scene.bodies.iter().map(|body| body.name.as_str());
        let has_images = self.scene.output.format.iter().any(Format::has_image_files);
        let files = manifest::Files {
            directory: &self.directory,
            sequences: self.sequences(),
            bodies_with_images: if has_images { bodies.collect() } else { Vec::new() },
            scene_file: self.scene_file.as_deref(),
            fps: self.fps(),
        };
        manifest::write(&files, checkpoint, outcome)
    }

    /// Returns whether the job writes frame `frame`, counted from 0.
    pub(super) fn is_written(&self, frame: u32) -> bool {
        frame.is_multiple_of(self.every)
    }

    /// Returns the number in file names of frame `frame`, counted from 0.
    pub(super) fn number(&self, frame: u32) -> u64 {
        u64::from(self.start_frame) + u64::from(frame)
    }

    /// Checks the options and the paths. Reads no mesh.
    pub(super) fn check(&self) -> Result<(), RunError> {
        if self.every == 0 {
            return Err(RunError::Option { option: "every", value: "0".into(), range: "at least 1" });
        }
        self.check_from()?;
        if let Some(stats) = &self.stats {
            stats::check_name(stats)?;
        }
        if self.directory.exists() && !self.directory.is_dir() {
            return Err(RunError::OutputIsAFile { path: self.directory.clone() });
        }
        let sequences = self.sequences();
        sequences.iter().try_for_each(Sequence::check_length)?;
        Sequence::check_different(&sequences)?;
        let inputs: BTreeSet<PathBuf> =
            self.scene.files().into_iter().chain(self.scene_file.clone()).collect();
        check_inputs(&sequences, &[CHECKPOINT, LOCK, MANIFEST], inputs.iter().map(PathBuf::as_path))?;
        states::check_inputs(&self.directory, &inputs)?;
        manifest::check(&self.directory)?;
        let absolute = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        if let Some(path) = &self.stats
            && path.file_name().is_some_and(|name| name == MANIFEST)
            && (is_same_file(parent(path), &self.directory)
                || absolute(parent(path)) == absolute(&self.directory))
        {
            return Err(RunError::StatsIsManifest { path: path.clone() });
        }
        if let Some(path) = &self.stats
            && let Some(input) = inputs.into_iter().find(|input| is_same_file(path, input))
        {
            return Err(RunError::StatsIsInput { path: path.clone(), input });
        }
        Ok(())
    }

    /// Returns the settings that a resumed run must keep.
    pub(super) fn settings(&self, fingerprint: String) -> Settings {
        let absolute = |path: &Path| {
            let directory = std::fs::canonicalize(parent(path)).unwrap_or_else(|_| parent(path).to_owned());
            path.file_name().map_or_else(|| directory.clone(), |name| directory.join(name))
        };
        let output = &self.scene.output;
        // Keys that change nothing without their format.
        let film = output.film();
        let look = [
            ("output.film_size", format!("{:?}", film.size)),
            ("output.film_view", film.view.map_or("the default".to_owned(), |view| format!("{view:?}"))),
            ("output.film_color", film.coloring.name().to_owned()),
        ];
        let velocities = ("output.usd_velocities", output.usd_velocities.to_string());
        let of_formats = [
            ([Format::Glb; 2], vec![("output.glb_error", output.glb_error.to_string())]),
            ([Format::Vat; 2], vec![("output.vat_encoding", output.vat_encoding.name().to_owned())]),
            ([Format::Usd, Format::Usdz], vec![velocities]),
            ([Format::Film, Format::Gif], look.to_vec()),
        ];
        let is_written = |formats: &[Format]| formats.iter().any(|format| output.format.contains(*format));
        let of_formats = of_formats.into_iter().filter(|(formats, _)| is_written(formats));
        Settings {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            fingerprint,
            format: self.scene.output.format.to_string(),
            files: [
                ("output.up", self.space().up().name().to_owned()),
                ("output.scale", self.scene.output.scale.to_string()),
                ("output.fps", self.fps().to_string()),
                ("output.meters_per_unit", self.scene.output.meters_per_unit.to_string()),
            ]
            .into_iter()
            .chain(of_formats.flat_map(|(_, settings)| settings))
            .map(|(key, value)| (key.to_owned(), value))
            .collect(),
            start_frame: self.start_frame,
            every: self.every,
            stats: self.stats.as_deref().map(|path| absolute(path).display().to_string()),
        }
    }
}
