//! The table of the formats: how a run opens, checks and completes the files of each. Their names are in `format`.

use super::listing::ListedFile;
use super::per_frame::{Renames, check_files};
use super::record::{Compare, Record};
use super::sink::{FrameRun, FrameSink};
use super::{Format, FrameWriter, OutputError, Sequence, Source};
use super::{clip, film, grids, obj, page, pc2, ply, stage};

/// What a run does with the files of a format.
pub(super) struct Kind {
    /// Returns the size of a frame of a body on disk, in bytes.
    pub(super) frame_bytes: fn(&Source<'_>) -> u64,
    /// Returns an error if a sequence of a run cannot be written. Changes nothing.
    pub(super) check_run: fn(&Sequence, usize, &FrameRun<'_>) -> Result<(), OutputError>,
    /// Starts the files of a sequence, or continues them after the frames that the run keeps. The number is the index of
    /// the body of a sequence that has one body.
    pub(super) open: fn(Sequence, usize, &FrameRun<'_>) -> Opened,
    /// Compares the files of a sequence with the records of its frames. Returns the problem if they differ.
    pub(super) check: fn(Found<'_>, &Sequence, &[Record], Compare) -> Checked,
    /// Gives the unfinished file of a sequence that has all frames its final form and name, without the frames after the
    /// records. Returns false if this needs the simulation.
    pub(super) finish: fn(&Sequence, &[Record], Compare) -> Result<bool, OutputError>,
    /// Returns an error if the existing file of a sequence is a link, which would have to be followed to continue it.
    pub(super) check_link: fn(&Sequence) -> Result<(), OutputError>,
}

/// The files of a sequence that are open, or why they are not.
pub(super) type Opened = Result<Box<dyn FrameSink>, OutputError>;

/// The problem of files that differ from their records.
pub(super) type Checked = Result<Option<String>, OutputError>;

/// What is known of the files of a sequence before they are compared.
pub(super) struct Found<'a> {
    /// The files that exist.
    pub(super) files: &'a [ListedFile],
    /// Those that get new names.
    pub(super) renames: &'a mut Renames,
    /// Whether the run adds frames to them.
    pub(super) continues: bool,
}

impl Format {
    /// Returns what a run does with its files.
    pub(super) const fn kind(self) -> &'static Kind {
        match self {
            Self::Obj => &OBJ,
            Self::Ply => &PLY,
            Self::Pc2 => &PC2,
            Self::Usd => &USD,
            Self::Usdz => &USDZ,
            Self::Html => &HTML,
            Self::Glb => &CLIP,
            Self::Vat => &CLIP,
            Self::Vtu => &VTU,
            Self::Lattice => &LATTICE,
            Self::Film | Self::Gif => &FILM,
        }
    }
}

/// Returns an error if a sequence of a run cannot be written. Changes nothing. `body`: as for [`open_sink`].
pub(crate) fn check_run(sequence: &Sequence, body: usize, run: &FrameRun<'_>) -> Result<(), OutputError> {
    (sequence.format.kind().check_run)(sequence, body, run)
}

/// Starts the files of a sequence, or continues them after the frames that `run` keeps. `body`: the index of the body
/// of a sequence that has one body.
pub(crate) fn open_sink(
    sequence: Sequence,
    body: usize,
    run: &FrameRun<'_>,
) -> Result<Box<dyn FrameSink>, OutputError> {
    (sequence.format.kind().open)(sequence, body, run)
}

impl Source<'_> {
    /// Returns the size of a frame on disk, in bytes. The size is exact for PLY and PC2, and approximate for OBJ. For
    /// USD it leaves out normals and colliders. For HTML it is that of the positions on disk while a run writes them;
    /// in the page they are compressed, and in films they are pictures. For GLB and textures it is that of the frames
    /// on disk while a run writes them, without vertices that are split.
    pub fn frame_bytes(&self, format: Format) -> u64 {
        (format.kind().frame_bytes)(self)
    }
}

/// The parts that formats with a file per frame have in common.
const PER_FRAME: Kind = Kind {
    frame_bytes: |_| 0,
    check_run: |_, _, _| Ok(()),
    open: |sequence, body, run| Ok(Box::new(FrameWriter::of_run(sequence, body, run)?)),
    check: |found, sequence, records, compare| {
        check_files(found.files, sequence, records, compare, found.renames)
    },
    finish: |_, _, _| Ok(true),
    check_link: |_| Ok(()),
};

static OBJ: Kind = Kind { frame_bytes: obj::frame_bytes, ..PER_FRAME };

static PLY: Kind = Kind { frame_bytes: ply::frame_bytes, ..PER_FRAME };

static PC2: Kind = Kind {
    frame_bytes: |source| 12 * source.points() as u64,
    check: |_, sequence, records, compare| pc2::check(sequence, records, compare),
    finish: |sequence, records, _| pc2::finish(sequence, records).map(|()| true),
    check_link: Sequence::check_continued_path,
    ..PER_FRAME
};

static USD: Kind = Kind {
    // The points and their bounds.
    frame_bytes: |source| 12 * source.mesh().vertices().len() as u64 + 48,
    open: |sequence, _, run| Ok(Box::new(stage::StageWriter::open(&sequence, run, None)?)),
    check: |_, sequence, records, compare| stage::check(sequence, records, compare),
    finish: stage::is_complete,
    check_link: Sequence::check_continued_path,
    ..PER_FRAME
};

static USDZ: Kind = Kind {
    frame_bytes: USD.frame_bytes,
    open: |sequence, _, run| {
        Ok(Box::new(stage::StageWriter::open(&sequence.frames(), run, Some(sequence.path(0)))?))
    },
    check: |found, sequence, records, compare| {
        stage::check_package(sequence, records, compare, found.continues)
    },
    finish: |sequence, _, _| Ok(clip::is_complete(sequence)),
    check_link: clip::check_link,
    ..PER_FRAME
};

/// The parts that pages and films have in common.
const PAGE: Kind = Kind {
    frame_bytes: |source| 6 * source.mesh().vertices().len() as u64,
    open: |sequence, _, run| Ok(Box::new(page::PageWriter::open(sequence, run)?)),
    check: |_, sequence, records, compare| page::check(sequence, records, compare),
    finish: |sequence, records, _| page::finish(sequence, records).map(|()| true),
    check_link: page::check_link,
    ..PER_FRAME
};

static HTML: Kind = PAGE;

static CLIP: Kind = Kind {
    // Positions and normals, while the run writes them.
    frame_bytes: |source| 24 * source.mesh().vertices().len() as u64,
    check_run: |sequence, body, run| match sequence.format {
        Format::Vat => clip::check_textures(sequence, body, run),
        _ => Ok(()),
    },
    open: |sequence, body, run| Ok(Box::new(clip::ClipWriter::open(sequence, body, run)?)),
    check: |found, sequence, records, compare| clip::check(sequence, records, compare, found.continues),
    finish: |sequence, _, _| Ok(clip::is_complete(sequence)),
    check_link: clip::check_link,
};

/// The parts that grids have in common.
const GRID: Kind = Kind {
    open: |sequence, body, run| Ok(Box::new(grids::GridWriter::open(sequence, body, run)?)),
    finish: |sequence, _, _| Ok(grids::is_complete(sequence)),
    ..PER_FRAME
};

static VTU: Kind = Kind { frame_bytes: grids::surface_bytes, ..GRID };

// A surface does not tell the size of its lattice.
static LATTICE: Kind = GRID;

static FILM: Kind = Kind {
    check: |found, sequence, records, compare| page::check_film(sequence, records, compare, found.continues),
    finish: |sequence, _, _| Ok(film::is_complete(sequence)),
    ..PAGE
};
