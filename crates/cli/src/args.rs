//! Command-line arguments.

use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{ArgGroup, Args, Parser, Subcommand, ValueEnum};
use supple_io::frames::{Format, VatEncoding};
use supple_io::run::Resume;
use supple_io::scene::{self, Scene, SceneError};

/// Simulates soft bodies by lattice shape matching with volume preservation.
#[derive(Debug, Parser)]
#[command(name = "supple", version, propagate_version = true)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
}

/// The subcommands.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Simulate scenes or models and write the frames
    Run(RunArgs),
    /// Describe a scene without running it: meshes, lattices, memory, and disk space of the frames
    Inspect(InspectArgs),
    /// Measure error against run time for a scene, the accuracy of the summation, the stability of extreme cases, or
    /// materials
    Study(StudyArgs),
    /// Show finished runs side by side in one page for browsers
    Html(HtmlArgs),
    /// Show a finished run as a moving picture, animated WebP or GIF
    Film(FilmArgs),
}

/// Arguments of `supple run`.
#[derive(Debug, Args)]
pub(crate) struct RunArgs {
    /// Scenes (.toml) or models (.obj, .glb, .gltf, .stl, .ply); several inputs run one after another
    #[arg(value_name = "INPUT", required = true)]
    pub(crate) inputs: Vec<PathBuf>,
    /// Output directory [default: the scene's output.directory]; with several inputs, DIR/INPUT-NAME for each;
    /// with --print-scene, the scene file (.toml) to write
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: Option<PathBuf>,
    /// Formats of the frames, separated by commas [default: the scene's output.format]
    #[arg(long, value_parser = format(), value_delimiter = ',')]
    pub(crate) format: Vec<Format>,
    /// With the format vat: encoding of the images [default: the scene's output.vat_encoding, which is png]
    #[arg(long, value_name = "ENCODING", value_parser = vat_encoding())]
    pub(crate) vat_encoding: Option<VatEncoding>,
    /// Number of frames after frame 0 [default: the scene's simulation.frames]
    #[arg(long, value_name = "N", value_parser = count::<0, 10_000_000>, allow_negative_numbers = true)]
    pub(crate) frames: Option<u32>,
    /// Write only every K-th frame; frames keep their numbers
    #[arg(long, value_name = "K", default_value_t = 1, value_parser = count::<1, { u32::MAX }>, allow_negative_numbers = true)]
    pub(crate) every: u32,
    /// Number of the first frame (the rest pose) in file names, statistics, PC2 headers and time codes of USD
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = count::<0, { u32::MAX }>, allow_negative_numbers = true)]
    pub(crate) start_frame: u32,
    /// Number of threads; 0 uses all processors [default: the scene's simulation.threads]
    #[arg(long, value_name = "N", value_parser = count::<0, 1024>, allow_negative_numbers = true)]
    pub(crate) threads: Option<u32>,
    /// Write statistics to a .csv or .json file, one row per frame and body; with several inputs, FILE.csv becomes
    /// FILE_INPUT.csv for each
    #[arg(long, value_name = "FILE")]
    pub(crate) stats: Option<PathBuf>,
    /// Continue an earlier run from its last checkpoint; with `=auto`, start at the first frame if the checkpoint does
    /// not fit the scene; without this flag all existing frames of the same names are removed
    #[arg(long, value_name = "auto", num_args = 0..=1, require_equals = true, default_missing_value = "", value_parser = resume)]
    pub(crate) resume: Option<Resume>,
    /// Continue an earlier run with the scene as it is now, after the newest state or checkpoint at or before frame N; later
    /// frames are written anew. Keep states with output.states. Handles, colliders, fields, materials, gravity and volume
    /// options may have changed, but not bodies, meshes, lattices, frames per second and formats
    #[arg(long, value_name = "N", value_parser = count::<0, { u32::MAX }>, allow_negative_numbers = true, conflicts_with = "resume")]
    pub(crate) from: Option<u32>,
    /// With --resume: compare the contents of the frames with the hashes in the checkpoint, not only their sizes
    #[arg(long, requires = "resume")]
    pub(crate) verify: bool,
    /// Seconds between checkpoints, from which --resume continues
    #[arg(long, value_name = "SECONDS", default_value = "10", value_parser = seconds, allow_negative_numbers = true)]
    pub(crate) checkpoint: Duration,
    /// Form of the progress, for users or for programs
    #[arg(long, value_name = "FORM", value_enum, default_value_t = ProgressForm::Bar, conflicts_with = "quiet")]
    pub(crate) progress: ProgressForm,
    /// Print no progress, as --progress none; errors and the summary are still printed
    #[arg(short, long)]
    pub(crate) quiet: bool,
    /// Print the complete scene with all defaults and overrides, without running it; paths are absolute, or with -o
    /// FILE.toml relative to FILE.toml
    #[arg(long)]
    pub(crate) print_scene: bool,
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
}

/// Arguments of `supple inspect`.
#[derive(Debug, Args)]
pub(crate) struct InspectArgs {
    /// Scene (.toml) or model (.obj, .glb, .gltf, .stl, .ply)
    #[arg(value_name = "INPUT")]
    pub(crate) input: PathBuf,
    /// Print JSON; it always contains the plan, and estimates of memory and time, for which it runs a few steps
    #[arg(long)]
    pub(crate) json: bool,
    /// Print the stages of the simulation and the memory of each
    #[arg(long)]
    pub(crate) plan: bool,
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
}

/// Arguments of `supple study`.
#[derive(Debug, Args)]
#[command(group = ArgGroup::new("subject").required(true).args(["input", "sums", "stability", "material"]))]
pub(crate) struct StudyArgs {
    /// Scene (.toml) to study: writes error against run time to study.csv, study.json and study.svg
    #[arg(value_name = "SCENE")]
    pub(crate) input: Option<PathBuf>,
    /// Study the summation alone: local and global moments, direct and running sums, f32 and f64
    #[arg(long, conflicts_with_all = ["overrides", "up"])]
    pub(crate) sums: bool,
    /// Run stiff and extreme cases, check each against its bounds, and write stability.json
    #[arg(long, conflicts_with_all = ["overrides", "up"])]
    pub(crate) stability: bool,
    /// Measure elasticity, damping, rest and contact, compare them with their laws and targets, and write material.json
    #[arg(long, conflicts_with_all = ["overrides", "up"])]
    pub(crate) material: bool,
    /// With --stability or --material: run only the cases with this text in their name or family
    #[arg(long, value_name = "TEXT", conflicts_with_all = ["input", "sums"])]
    pub(crate) filter: Option<String>,
    /// Output directory; created if it does not exist
    #[arg(short, long, value_name = "DIR", default_value = ".")]
    pub(crate) output: PathBuf,
    /// Run only the quick cases
    #[arg(long)]
    pub(crate) quick: bool,
    /// Continue an earlier study of the scene; without this flag an existing study is replaced
    #[arg(long, conflicts_with_all = ["sums", "stability", "material"])]
    pub(crate) resume: bool,
    /// Print no progress; the table, errors and the summary are still printed
    #[arg(short, long)]
    pub(crate) quiet: bool,
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
}

/// Arguments of `supple html`.
#[derive(Debug, Args)]
pub(crate) struct HtmlArgs {
    /// Folders of runs with --format html, or pages (.html)
    #[arg(value_name = "RUN", required = true)]
    pub(crate) inputs: Vec<PathBuf>,
    /// Page to write; an existing file is replaced
    #[arg(short, long, value_name = "PAGE.html", default_value = "page.html")]
    pub(crate) output: PathBuf,
}

/// Arguments of `supple film`.
#[derive(Debug, Args)]
pub(crate) struct FilmArgs {
    /// Folder of a run with --format html, obj or ply, or a page (.html). OBJ and PLY frames have no colliders, but a
    /// ground
    #[arg(value_name = "RUN")]
    pub(crate) input: PathBuf,
    /// Film to write, .webp or .gif; an existing file is replaced
    #[arg(short, long, value_name = "FILM", default_value = "film.webp")]
    pub(crate) output: PathBuf,
    /// Width and height in pixels, from 16 to 4096
    #[arg(long, value_name = "W,H", default_value = "800,600", value_parser = size)]
    pub(crate) size: [u32; 2],
    /// Direction from the bodies to the camera [default: from the front, the right and above]
    #[arg(long, value_name = "X,Y,Z", value_parser = view, allow_hyphen_values = true)]
    pub(crate) view: Option<[f64; 3]>,
    /// Color of the bodies: that of their materials, or their error of volume (runs with --format html)
    #[arg(long, value_enum, default_value = "material")]
    pub(crate) color: Color,
    /// Frames per second [default: those of the run]
    #[arg(long, value_name = "N", value_parser = positive)]
    pub(crate) fps: Option<f64>,
    /// Up axis of OBJ and PLY frames [default: y]; pages tell theirs
    #[arg(long, value_enum)]
    pub(crate) up: Option<Up>,
    /// Number of threads; 0 uses all processors
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = count::<0, 1024>, allow_negative_numbers = true)]
    pub(crate) threads: u32,
}

/// What colors of bodies show.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum Color {
    Material,
    Volume,
}

/// Parses the size of a picture.
fn size(text: &str) -> Result<[u32; 2], String> {
    let sides: Option<Vec<u32>> = text.split(',').map(|side| side.trim().parse().ok()).collect();
    let sides = sides.and_then(|sides| <[u32; 2]>::try_from(sides).ok());
    let valid = sides.filter(|sides| sides.iter().all(|side| (16..=4096).contains(side)));
    valid.ok_or_else(|| "it must be width and height such as 800,600, from 16 to 4096".to_owned())
}

/// Parses a direction.
fn view(text: &str) -> Result<[f64; 3], String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|number| number.trim().parse().ok()).collect();
    let vector = numbers.and_then(|numbers| <[f64; 3]>::try_from(numbers).ok());
    let valid = vector.filter(|vector| vector.iter().all(|x| x.is_finite()) && *vector != [0.0; 3]);
    valid.ok_or_else(|| "it must be three numbers such as 1,0.5,1 that are not all 0".to_owned())
}

/// Parses a number above 0.
fn positive(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok().filter(|number| number.is_finite() && *number > 0.0);
    number.ok_or_else(|| "it must be a number above 0".to_owned())
}

/// Arguments that select or change the scene of an input.
#[derive(Debug, Args)]
pub(crate) struct SceneArgs {
    /// Override a scene key, e.g. body.bust.half_width=3 or simulation.frames=60; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub(crate) overrides: Vec<String>,
    /// Up axis of an input that is a model [default: y]; not for scenes
    #[arg(long, value_enum)]
    pub(crate) up: Option<Up>,
}

impl RunArgs {
    /// Returns the form of the progress.
    pub(crate) fn progress(&self) -> ProgressForm {
        if self.quiet { ProgressForm::None } else { self.progress }
    }
}

impl SceneArgs {
    /// Reads a scene file, or builds the default scene of a model, and applies the overrides.
    pub(crate) fn open(&self, input: &Path) -> Result<Scene, SceneError> {
        Scene::open(input, self.up.unwrap_or(Up::Y).into(), &self.overrides)
    }
}

impl Command {
    /// Checks arguments that depend on each other. Returns a message if `--up` is given for a scene.
    pub(crate) fn check(&self) -> Result<(), String> {
        let (scene, inputs) = match self {
            Self::Run(args) => (&args.scene, args.inputs.as_slice()),
            Self::Inspect(args) => (&args.scene, std::slice::from_ref(&args.input)),
            Self::Study(args) => (&args.scene, args.input.as_slice()),
            Self::Html(args) if !has_extension(&args.output, &["html"]) => {
                return Err(format!("-o {}: the page must end in .html", args.output.display()));
            }
            Self::Film(args) if !has_extension(&args.output, &["webp", "gif"]) => {
                return Err(format!("-o {}: the film must end in .webp or .gif", args.output.display()));
            }
            Self::Html(_) | Self::Film(_) => return Ok(()),
        };
        let input = inputs.iter().find(|input| has_extension(input, &["toml"]));
        match (scene.up, input) {
            (Some(_), Some(input)) => Err(format!(
                "--up is for models only, and {} is a scene; leave --up out, and set simulation.gravity and \
                 the rotate of each body",
                input.display()
            )),
            _ => Ok(()),
        }
    }
}

/// Returns whether a path has one of the extensions, in upper or lower case.
pub(crate) fn has_extension(path: &Path, extensions: &[&str]) -> bool {
    let found = path.extension().unwrap_or_default();
    extensions.iter().any(|extension| found.eq_ignore_ascii_case(extension))
}

/// Parses the name of a format of frames.
fn format() -> impl TypedValueParser<Value = Format> {
    let named = |format: Format| PossibleValue::new(format.name()).help(format.about());
    PossibleValuesParser::new(Format::ALL.map(named)).try_map(|name| name.parse::<Format>())
}

/// Parses the name of an encoding of images.
fn vat_encoding() -> impl TypedValueParser<Value = VatEncoding> {
    let named = |encoding: VatEncoding| PossibleValue::new(encoding.name()).help(encoding.about());
    let of_name = |name: String| VatEncoding::ALL.into_iter().find(|encoding| encoding.name() == name);
    PossibleValuesParser::new(VatEncoding::ALL.map(named))
        .try_map(move |name| of_name(name).ok_or("unknown encoding"))
}

/// Forms of the progress of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum ProgressForm {
    /// A bar on a terminal, and a line every 10 % in a pipe
    Bar,
    /// A JSON object a line on standard error, for each frame, each message, and the begin and the end of each input
    Json,
    /// The lines of Open Job Description on standard output
    #[value(name = "openjd")]
    OpenJd,
    /// No progress
    None,
}

/// Axes of a model that can point up.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum Up {
    /// The y axis
    Y,
    /// The z axis
    Z,
}

impl From<Up> for scene::Up {
    fn from(up: Up) -> Self {
        match up {
            Up::Y => Self::Y,
            Up::Z => Self::Z,
        }
    }
}

/// Parses a whole number from `LOW` to `HIGH`.
fn count<const LOW: u32, const HIGH: u32>(text: &str) -> Result<u32, String> {
    let number = text.parse().ok().filter(|number| (LOW..=HIGH).contains(number));
    number.ok_or_else(|| format!("it must be a whole number from {LOW} to {HIGH}"))
}

/// Parses the value of `--resume`. The argument without a value is an empty text.
fn resume(text: &str) -> Result<Resume, String> {
    match text {
        "" => Ok(Resume::Yes),
        "auto" => Ok(Resume::Auto),
        _ => Err("it must be `auto`, or be left out".to_owned()),
    }
}

/// Parses a non-negative number of seconds.
fn seconds(text: &str) -> Result<Duration, String> {
    let seconds = text.parse::<f64>().map_err(|_| "it must be a number of seconds".to_owned())?;
    Duration::try_from_secs_f64(seconds).map_err(|_| "it must be from 0 to 1e19 seconds".to_owned())
}
