//! A job: a scene, a folder, and how its frames are kept.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::advance::Running;
use super::checkpoint::Checkpoint;
use super::error::RunError;
use super::fingerprint::fingerprint;
use super::lock::Lock;
use super::observer::{Note, Observer};
use super::prepare::{Prepared, prepare};
use super::report::{Outcome, RunReport};
use super::resume::{self, Start};
use super::sinks::Sinks;
use super::stats::{self, Stats};
use crate::frames::{OutputError, Sequence};
use crate::scene::{BodyData, Scene};

/// A scene, the folder that its frames go to, and which of them are kept.
#[derive(Clone, Debug)]
pub struct Job {
    /// What is simulated. Its `output.directory` is not looked at: see [`Job::directory`].
    pub scene: Scene,
    /// The folder of the frames; made if it is not there.
    pub directory: PathBuf,
    /// Every how many frames one is written, at least 1; default 1.
    pub every: u32,
    /// The number that frame 0, the rest pose, goes by; default 0. Frame `k` is written as number
    /// `start_frame + k`, as shots are numbered (1001, 1002, ...); its time stays `k / fps`.
    pub start_frame: u32,
    /// A `.csv` or `.json` file for one [`Row`](super::Row) a frame and body; default none.
    pub stats: Option<PathBuf>,
    /// Whether to go on where an earlier run ended; by default an existing sequence is replaced.
    pub resume: bool,
    /// Wall-clock time between checkpoints; default 10 s.
    pub checkpoint_interval: Duration,
}

impl Job {
    /// A job that keeps every frame, without statistics, from the start.
    pub fn new(scene: Scene, directory: impl Into<PathBuf>) -> Self {
        Self {
            scene,
            directory: directory.into(),
            every: 1,
            start_frame: 0,
            stats: None,
            resume: false,
            checkpoint_interval: Duration::from_secs(10),
        }
    }

    /// Runs the job: everything that can be wrong with it is looked for before anything is written.
    ///
    /// Frames appear under their names only when they are whole. With [`Job::resume`]: nothing there
    /// starts at frame 0; a finished sequence is left alone; a sequence that ended early, or is now to
    /// be longer, goes on after its checkpoint, with the bits of an uninterrupted run.
    ///
    /// # Errors
    ///
    /// [`RunError::is_input`] tells what the user's input is to blame for from what failed while running.
    pub fn run(&self, observer: &mut dyn Observer) -> Result<RunReport, RunError> {
        let begun = Instant::now();
        self.check()?;
        let fingerprint = fingerprint(&self.scene)?;

        let mut lock = None;
        let mut start = Start::Fresh;
        if self.resume && self.directory.is_dir() {
            lock = Some(Lock::take(&self.directory)?);
            start = resume::decide(self, &fingerprint, observer)?;
        }
        if matches!(start, Start::Finished) {
            return Ok(self.already_finished(begun));
        }

        let prepared = prepare(&self.scene)?;
        let _lock = match lock {
            Some(lock) => lock,
            None => self.open_folder()?,
        };
        let running = match start {
            Start::After(checkpoint) => self.reopen(prepared, *checkpoint, fingerprint, observer)?,
            _ => self.open(prepared, fingerprint)?,
        };
        running.run(begun, observer)
    }

    /// The files of each body, in the order of the scene.
    pub fn sequences(&self) -> Vec<Sequence> {
        let sequence = |body: &BodyData| Sequence {
            directory: self.directory.clone(),
            name: body.name.clone(),
            format: self.scene.output.format,
            first: self.number(0),
            every: u64::from(self.every),
            last: self.number(self.scene.simulation.frames),
        };
        self.scene.bodies.iter().map(sequence).collect()
    }

    /// Whether a frame, counted from 0, is written.
    pub(super) fn keeps(&self, frame: u32) -> bool {
        frame.is_multiple_of(self.every)
    }

    /// The number that a frame, counted from 0, goes by.
    pub(super) fn number(&self, frame: u32) -> u64 {
        u64::from(self.start_frame) + u64::from(frame)
    }

    /// Looks for what is wrong without reading a mesh.
    fn check(&self) -> Result<(), RunError> {
        if self.every == 0 {
            return Err(RunError::Option { option: "every", value: "0".into(), range: "at least 1" });
        }
        if let Some(stats) = &self.stats {
            stats::check_name(stats)?;
        }
        if self.directory.exists() && !self.directory.is_dir() {
            return Err(RunError::NotAFolder { path: self.directory.clone() });
        }
        self.check_inputs_are_safe()
    }

    /// A mesh that lies in the folder of the frames must not look like one of them.
    fn check_inputs_are_safe(&self) -> Result<(), RunError> {
        if !self.directory.is_dir() {
            return Ok(());
        }
        for sequence in self.sequences() {
            for path in sequence.existing()? {
                let is_mesh = |body: &BodyData| is_same(&self.scene.resolve(&body.mesh), &path);
                if self.scene.bodies.iter().any(is_mesh) {
                    return Err(RunError::OverInput { path });
                }
            }
        }
        Ok(())
    }

    fn open_folder(&self) -> Result<Lock, RunError> {
        std::fs::create_dir_all(&self.directory)
            .map_err(|source| RunError::io("create the folder", &self.directory, source))?;
        Lock::take(&self.directory)
    }

    /// Replaces whatever sequence is there.
    fn open(&self, prepared: Prepared, fingerprint: String) -> Result<Running<'_>, RunError> {
        let stats = self.stats.as_deref().map(Stats::create).transpose()?;
        Checkpoint::remove(&self.directory)?;
        let sinks = Sinks::create(self, &prepared)?;
        Ok(Running::new(self, prepared, sinks, stats, fingerprint, None))
    }

    /// Goes on after a checkpoint.
    fn reopen(
        &self,
        mut prepared: Prepared,
        checkpoint: Checkpoint,
        fingerprint: String,
        observer: &mut dyn Observer,
    ) -> Result<Running<'_>, RunError> {
        let frame = checkpoint.frame;
        let sinks = match Sinks::resume(self, &prepared, frame) {
            // A cache of other frames of the same motion.
            Err(RunError::Output(error @ OutputError::Cache { .. })) => {
                observer.note(&Note::StartsAgain { reason: error.to_string() });
                return self.open(prepared, fingerprint);
            }
            sinks => sinks?,
        };
        let level = supple::simd_level();
        if checkpoint.level != level {
            observer.note(&Note::OtherLevel { before: checkpoint.level, now: level.to_string() });
        }
        prepared.simulation.restore(&checkpoint.state).map_err(|error| RunError::Checkpoint {
            path: self.directory.join(super::CHECKPOINT),
            what: error.to_string(),
        })?;
        let last = self.number(frame);
        let stats = self.stats.as_deref().map(|path| Stats::resume(path, last)).transpose()?;
        observer.note(&Note::Resumed { frame });
        Ok(Running::new(self, prepared, sinks, stats, fingerprint, Some(frame)))
    }

    fn already_finished(&self, begun: Instant) -> RunReport {
        RunReport {
            directory: self.directory.clone(),
            outcome: Outcome::AlreadyFinished,
            resumed_after: None,
            last: self.scene.simulation.frames,
            simulated: 0,
            written: 0,
            substeps: 0,
            elapsed: begun.elapsed(),
            bodies: Vec::new(),
        }
    }
}

/// Whether two paths lead to the same file.
fn is_same(a: &Path, b: &Path) -> bool {
    match (a.canonicalize(), b.canonicalize()) {
        (Ok(a), Ok(b)) => a == b,
        _ => false,
    }
}
