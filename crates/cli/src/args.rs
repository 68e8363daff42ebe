//! The arguments, as users type them.

use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::{ArgGroup, Args, Parser, Subcommand, ValueEnum};
use supple_io::frames;
use supple_io::scene::{self, Scene, SceneError};

/// Soft bodies by lattice shape matching that keep their volume.
#[derive(Debug, Parser)]
#[command(name = "supple", version, propagate_version = true)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Step scenes or models to frame sequences
    Run(RunArgs),
    /// Say what would be simulated; nothing is run
    Inspect(InspectArgs),
    /// Measure what accuracy costs: of a scene, of the summation alone, or in stiff and extreme cases
    Study(StudyArgs),
}

/// `supple run`.
#[derive(Debug, Args)]
pub(crate) struct RunArgs {
    /// Scenes (.toml) or models (.obj); several run one after another
    #[arg(value_name = "INPUT", required = true)]
    pub(crate) inputs: Vec<PathBuf>,
    /// Folder of the frames [default: the scene's output.directory]; several inputs write to DIR/STEM each
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: Option<PathBuf>,
    /// Format of the frames [default: the scene's output.format]
    #[arg(long, value_enum)]
    pub(crate) format: Option<Format>,
    /// Frames after frame 0 [default: the scene's simulation.frames]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(..=10_000_000))]
    pub(crate) frames: Option<u32>,
    /// Write every K-th frame only, under its own number
    #[arg(long, value_name = "K", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) every: u32,
    /// Number that frame 0, the rest pose, goes by in file names, statistics and PC2 headers
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) start_frame: u32,
    /// Threads; 0 takes all [default: the scene's simulation.threads]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(..=1024))]
    pub(crate) threads: Option<u16>,
    /// Write a row of statistics a frame and body; with several inputs, FILE_STEM each
    #[arg(long, value_name = "FILE.csv|.json")]
    pub(crate) stats: Option<PathBuf>,
    /// Go on where an earlier run ended; without it an existing sequence is replaced
    #[arg(long)]
    pub(crate) resume: bool,
    /// Seconds between checkpoints, from which --resume goes on
    #[arg(long, value_name = "SECONDS", default_value = "10", value_parser = seconds)]
    pub(crate) checkpoint: Duration,
    /// No progress; errors and the last line are still printed
    #[arg(short, long)]
    pub(crate) quiet: bool,
    /// Print the scene that an input means, with every default and change, and run nothing
    #[arg(long)]
    pub(crate) print_scene: bool,
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
}

/// `supple inspect`.
#[derive(Debug, Args)]
pub(crate) struct InspectArgs {
    /// A scene (.toml) or a model (.obj)
    #[arg(value_name = "INPUT")]
    pub(crate) input: PathBuf,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
}

/// `supple study`.
#[derive(Debug, Args)]
#[command(group = ArgGroup::new("subject").required(true).args(["input", "sums", "stability"]))]
pub(crate) struct StudyArgs {
    /// A scene (.toml) with a known motion: error against run time, to study.csv, study.json and study.svg
    #[arg(value_name = "SCENE")]
    pub(crate) input: Option<PathBuf>,
    /// The summation alone: local and global moments, direct and running sums, f32 and f64
    #[arg(long, conflicts_with_all = ["overrides", "up"])]
    pub(crate) sums: bool,
    /// Stiff and extreme cases, each against a bound, to stability.json
    #[arg(long, conflicts_with_all = ["overrides", "up"])]
    pub(crate) stability: bool,
    /// Folder of what is written; made if it is not there
    #[arg(short, long, value_name = "DIR", default_value = ".")]
    pub(crate) output: PathBuf,
    /// A selection that takes less than a minute on two cores
    #[arg(long)]
    pub(crate) quick: bool,
    /// Go on where an earlier study of the scene ended; without it an existing study is replaced
    #[arg(long, conflicts_with_all = ["sums", "stability"])]
    pub(crate) resume: bool,
    /// No progress; the table, errors and the last line are still printed
    #[arg(short, long)]
    pub(crate) quiet: bool,
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
}

/// What changes a scene.
#[derive(Debug, Args)]
pub(crate) struct SceneArgs {
    /// Change the scene, as body.bust.half_width=3 or simulation.frames=60; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub(crate) overrides: Vec<String>,
    /// Axis of a model alone that points up
    #[arg(long, value_enum, default_value_t = Up::Y)]
    pub(crate) up: Up,
}

impl SceneArgs {
    /// Reads the scene that an input means: a scene file, or a model alone.
    pub(crate) fn open(&self, input: &Path) -> Result<Scene, SceneError> {
        Scene::open(input, self.up.into(), &self.overrides)
    }
}

/// Formats of frames.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum Format {
    /// One Wavefront OBJ a frame
    Obj,
    /// One binary PLY a frame
    Ply,
    /// One point cache a body
    Pc2,
}

/// Axes that may point up.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum Up {
    /// y
    Y,
    /// z
    Z,
}

impl From<Format> for frames::Format {
    fn from(format: Format) -> Self {
        match format {
            Format::Obj => Self::Obj,
            Format::Ply => Self::Ply,
            Format::Pc2 => Self::Pc2,
        }
    }
}

impl From<Up> for scene::Up {
    fn from(up: Up) -> Self {
        match up {
            Up::Y => Self::Y,
            Up::Z => Self::Z,
        }
    }
}

fn seconds(text: &str) -> Result<Duration, String> {
    let seconds = text.parse::<f64>().map_err(|_| "must be a number of seconds".to_owned())?;
    Duration::try_from_secs_f64(seconds).map_err(|_| "must be at least 0 seconds".to_owned())
}
