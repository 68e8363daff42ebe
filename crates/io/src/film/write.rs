//! Writes a film: renders the frames in parallel, and encodes what changes.

use std::fs::File;
use std::io::{self, BufWriter, ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::Path;

use ::gif::Frame;
use supple::Executor;

use super::camera::{Camera, Places};
use super::patch::{Canvas, Patch};
use super::render::Renderer;
use super::shade::ToSrgb;
use super::{FilmFile, FilmOptions, Footage, Moment, Picture, gif, webp};

/// Frames that each thread renders before they are written.
const PER_THREAD: usize = 2;
/// Size of the facts at the end of a file, in bytes. The number is even, as chunks of WebP are.
const FACTS: usize = 96;
/// What the facts begin with.
const HEAD: &str = "supple film ";
/// What may follow the facts: the ends of the comment and of a GIF file.
const TAIL: u64 = 2;

/// A frame on its way to the file.
#[derive(Default)]
struct Work {
    moment: Moment,
    picture: Option<Picture>,
    patch: Option<Patch>,
    encoded: Option<io::Result<Encoded>>,
}

enum Encoded {
    Webp((Vec<u8>, bool)),
    Gif(Frame<'static>),
}

/// A file that is written.
enum Out<'a> {
    Webp(BufWriter<&'a mut File>),
    Gif(gif::File<BufWriter<&'a mut File>>),
}

/// Writes a film with at least one frame.
///
/// * `facts`: a line for later runs of this program, of at most 80 bytes; see [`read_facts`].
pub(crate) fn write_film(
    file: &mut File,
    kind: FilmFile,
    footage: &mut dyn Footage,
    options: &FilmOptions,
    executor: &Executor,
    facts: &str,
) -> io::Result<()> {
    let (frames, fps) = (footage.frames(), footage.fps());
    let mut places = Places::new(footage.up());
    for frame in 0..frames {
        places.add(&footage.read(frame)?);
    }
    let renderer = Renderer {
        camera: Camera::new(&places, options.size, options.view),
        size: options.size,
        coloring: options.coloring,
        to_srgb: ToSrgb::new(),
    };
    let mut out = Out::start(file, kind, options.size)?;
    let mut canvas = Canvas::default();
    let mut first = 0;
    while first < frames {
        let count = (PER_THREAD * executor.threads()).min(frames - first);
        let mut work = Vec::new();
        for frame in first..first + count {
            work.push(Work { moment: footage.read(frame)?, ..Work::default() });
        }
        executor.for_each(work.iter_mut(), |work| {
            work.picture = Some(renderer.render(&std::mem::take(&mut work.moment)));
        });
        for work in &mut work {
            work.patch = work.picture.take().map(|picture| canvas.show(&picture));
        }
        executor.for_each(work.iter_mut(), |work| {
            work.encoded = work.patch.as_ref().map(|patch| kind.encode(patch))
        });
        for (frame, work) in (first..).zip(work) {
            if let (Some(patch), Some(encoded)) = (work.patch, work.encoded) {
                out.add(&patch, encoded?, (frame, fps))?;
            }
        }
        first += count;
    }
    let mut line = format!("{HEAD}{facts}").into_bytes();
    line.resize(FACTS, b' ');
    out.finish(&line)
}

/// Returns the duration of a frame in units of 1/`rate` seconds. The sum of durations is that of the times, rounded.
fn duration(frame: usize, fps: f64, rate: f64) -> u32 {
    let end = |frame: usize| (frame as f64 * rate / fps).round();
    (end(frame + 1) - end(frame)).clamp(0.0, f64::from(0xff_ffff)) as u32
}

impl FilmFile {
    fn encode(self, patch: &Patch) -> io::Result<Encoded> {
        match self {
            Self::Webp => webp::encode(patch).map(Encoded::Webp),
            Self::Gif => gif::encode(patch).map(Encoded::Gif),
        }
    }
}

impl<'a> Out<'a> {
    fn start(file: &'a mut File, kind: FilmFile, size: [u32; 2]) -> io::Result<Self> {
        let mut out = BufWriter::new(file);
        match kind {
            FilmFile::Webp => webp::start(&mut out, size).map(|()| Self::Webp(out)),
            FilmFile::Gif => gif::File::start(out, size).map(Self::Gif),
        }
    }

    fn add(&mut self, patch: &Patch, encoded: Encoded, (frame, fps): (usize, f64)) -> io::Result<()> {
        match (self, encoded) {
            (Self::Webp(out), Encoded::Webp(chunk)) => {
                webp::add(out, patch, &chunk, duration(frame, fps, 1000.0))
            }
            (Self::Gif(out), Encoded::Gif(of_patch)) => out.add(of_patch, duration(frame, fps, 100.0)),
            _ => Ok(()),
        }
    }

    fn finish(self, facts: &[u8]) -> io::Result<()> {
        match self {
            Self::Webp(mut out) => {
                webp::finish(&mut out, facts)?;
                out.flush()
            }
            Self::Gif(out) => out.finish(facts),
        }
    }
}

/// Returns the facts of a film; `None` if it is no complete film of this program.
pub(crate) fn read_facts(path: &Path) -> io::Result<Option<String>> {
    let mut file = File::open(path)?;
    let length = file.metadata()?.len();
    let mut end = Vec::new();
    file.seek(SeekFrom::Start(length.saturating_sub(FACTS as u64 + TAIL)))?;
    file.read_to_end(&mut end)?;
    let text = String::from_utf8_lossy(&end);
    let facts = text.find(HEAD).and_then(|at| text.get(at + HEAD.len()..at + FACTS));
    let mut head = [0; 8];
    file.seek(SeekFrom::Start(0))?;
    match file.read_exact(&mut head) {
        Err(error) if error.kind() == ErrorKind::UnexpectedEof => return Ok(None),
        result => result?,
    }
    let size = u32::from_le_bytes(std::array::from_fn(|byte| head[4 + byte]));
    let is_whole = match &head[..4] {
        b"RIFF" => u64::from(size) + 8 == length,
        _ => head.starts_with(b"GIF89a") && end.ends_with(&[0, b';']),
    };
    Ok(facts.filter(|_| is_whole).map(|facts| facts.trim_end().to_owned()))
}
