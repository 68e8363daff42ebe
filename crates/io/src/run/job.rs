//! A job: a scene, a folder, and how its frames are kept.

use std::path::PathBuf;
use std::time::Duration;

use super::error::RunError;
use super::stats;
use crate::frames::Sequence;
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
    pub(super) fn check(&self) -> Result<(), RunError> {
        if self.every == 0 {
            return Err(RunError::Option { option: "every", value: "0".into(), range: "at least 1" });
        }
        if let Some(stats) = &self.stats {
            stats::check_name(stats)?;
        }
        if self.directory.exists() && !self.directory.is_dir() {
            return Err(RunError::NotAFolder { path: self.directory.clone() });
        }
        // A mesh that lies in the folder of the frames must not look like one of them.
        for sequence in self.sequences() {
            let spared = |body: &BodyData| sequence.spare(&self.scene.resolve(&body.mesh));
            self.scene.bodies.iter().try_for_each(spared)?;
        }
        Ok(())
    }
}
