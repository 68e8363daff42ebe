//! The file `NAME.html.data` with the frames of a page that is not written yet.
//!
//! ```text
//! offset  0   8 bytes   "SUPPLEP2"
//!         8   u64       length of the description and its arrays, little endian
//!        16   u8        the description and its arrays
//! then of each frame
//!             u64       its size, little endian
//!             u8        the frame
//! ```

use std::fs::File;
use std::io::{self, BufReader, BufWriter, ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use super::{OutputError, Sequence};
use crate::file::{write_atomically, write_durably};
use crate::html::{FrameSource, Header, Layout, Run, decode_header, encode_header};

const SIGNATURE: &[u8; 8] = b"SUPPLEP2";
/// Size of the signature and the length, in bytes.
const PREFIX: u64 = 16;
/// Size of the size of a frame, in bytes.
const SIZE: u64 = 8;

/// The open data of a page.
#[derive(Debug)]
pub(super) struct Data {
    file: File,
    pub(super) header: Header,
    pub(super) layout: Layout,
    pub(super) arrays: Vec<u8>,
    places: Places,
}

/// Places of the frames in a file.
#[derive(Clone, Debug)]
struct Places {
    /// Offset of the size of the first frame.
    start: u64,
    /// Offset of the end of each complete frame.
    ends: Vec<u64>,
}

impl Places {
    /// Finds the complete frames of a file, which begin at `start`.
    fn find(file: &mut File, start: u64) -> io::Result<Self> {
        let length = file.metadata()?.len();
        let mut places = Self { start, ends: Vec::new() };
        let mut reader = BufReader::new(file);
        reader.seek(SeekFrom::Start(start))?;
        loop {
            let first = places.end() + SIZE;
            if first > length {
                return Ok(places);
            }
            let mut size = [0; SIZE as usize];
            reader.read_exact(&mut size)?;
            match first.checked_add(u64::from_le_bytes(size)) {
                Some(end) if end <= length => places.ends.push(end),
                _ => return Ok(places),
            }
            // The size is less than the length of the file, which is an `i64`.
            reader.seek_relative((places.end() - first) as i64)?;
        }
    }

    /// Returns the offset of the end of the last frame.
    fn end(&self) -> u64 {
        self.ends.last().copied().unwrap_or(self.start)
    }

    /// Returns the offset and the size of a frame.
    fn frame(&self, index: usize) -> (u64, u64) {
        let start = SIZE + index.checked_sub(1).map_or(self.start, |before| self.ends[before]);
        (start, self.ends[index] - start)
    }

    fn read(&self, file: &mut File, index: usize, frame: &mut Vec<u8>) -> io::Result<()> {
        let (start, size) = self.frame(index);
        frame.resize(size as usize, 0);
        file.seek(SeekFrom::Start(start))?;
        file.read_exact(frame)
    }
}

impl Data {
    /// Appends a frame. If this fails, truncates the file after the previous frame.
    pub(super) fn append(&mut self, frame: &[u8]) -> io::Result<()> {
        let size = frame.len() as u64;
        let written = self.file.write_all(&size.to_le_bytes()).and_then(|()| self.file.write_all(frame));
        if let Err(error) = written {
            // The write error is returned; an error of the truncation would add nothing.
            let _ = self.truncate(self.header.frames as u64);
            return Err(error);
        }
        self.header.frames += 1;
        self.places.ends.push(self.places.end() + SIZE + size);
        Ok(())
    }

    /// Returns the number of complete frames.
    pub(super) fn complete(&self) -> u64 {
        self.places.ends.len() as u64
    }

    /// Truncates the file after `frames` frames, of which it has at least as many, and seeks to the end.
    pub(super) fn truncate(&mut self, frames: u64) -> io::Result<()> {
        self.header.frames = frames as usize;
        self.places.ends.truncate(frames as usize);
        self.file.set_len(self.places.end())?;
        self.file.seek(SeekFrom::End(0)).map(drop)
    }

    /// Reads a complete frame. To append frames, call [`truncate`](Self::truncate) afterwards.
    pub(super) fn read_frame(&mut self, index: u64) -> io::Result<Vec<u8>> {
        let mut frame = Vec::new();
        self.places.read(&mut self.file, index as usize, &mut frame)?;
        Ok(frame)
    }

    /// Returns the description of the run for its page.
    pub(super) fn page_header(&self) -> Header {
        let mut header = self.header.clone();
        let whole = self.layout.whole_bytes() as u64;
        // Pieces only add to the size of a frame.
        header.set_has_pieces((0..header.frames).any(|frame| self.places.frame(frame).1 != whole));
        header
    }
}

/// Returns the run of data, which are in the file `path`.
pub(super) fn run_of(path: &Path, data: &Data) -> Result<Run<'static>, OutputError> {
    let frames = Box::new(DataFrames::open(path, data)?);
    Ok(Run { header: data.page_header(), arrays: data.arrays.clone(), frames })
}

/// The frames of a data file.
pub(super) struct DataFrames {
    file: File,
    places: Places,
}

impl DataFrames {
    pub(super) fn open(path: &Path, data: &Data) -> Result<Self, OutputError> {
        let file = File::open(path).map_err(OutputError::io("read", path))?;
        Ok(Self { file, places: data.places.clone() })
    }
}

impl FrameSource for DataFrames {
    fn frame_bytes(&self, index: usize) -> u64 {
        self.places.frame(index).1
    }

    fn read_frame(&mut self, index: usize, frame: &mut Vec<u8>) -> io::Result<()> {
        self.places.read(&mut self.file, index, frame)
    }
}

/// Returns the path of the data of a page.
pub(super) fn data_path(sequence: &Sequence) -> PathBuf {
    let mut name = sequence.path(0).into_os_string();
    name.push(sequence.format.data());
    name.into()
}

fn write_prefix(file: &mut impl Write, encoded: &[u8]) -> io::Result<()> {
    file.write_all(SIGNATURE)?;
    file.write_all(&(encoded.len() as u64).to_le_bytes())?;
    file.write_all(encoded)
}

/// Creates data without frames.
pub(super) fn create(path: &Path, header: &Header, arrays: &[u8]) -> Result<Data, OutputError> {
    let write = |file: &mut File| write_prefix(file, &encode_header(header, arrays)?);
    write_atomically(path, write).map_err(OutputError::io("write", path))?;
    open(path)
}

/// Creates data with the frames of a run, durably.
pub(super) fn create_from(path: &Path, run: &mut Run<'_>) -> Result<(), OutputError> {
    write_durably(path, |file| write_data(file, run)).map_err(OutputError::io("write", path))
}

/// Writes the data of a run to a file.
fn write_data(file: &mut File, run: &mut Run<'_>) -> io::Result<()> {
    let mut out = BufWriter::new(file);
    // Frames are counted when the data are opened.
    let mut header = run.header.clone();
    header.frames = 0;
    write_prefix(&mut out, &encode_header(&header, &run.arrays)?)?;
    let mut frame = Vec::new();
    for index in 0..run.header.frames {
        run.frames.read_frame(index, &mut frame)?;
        out.write_all(&(frame.len() as u64).to_le_bytes())?;
        out.write_all(&frame)?;
    }
    out.flush()
}

/// Opens existing data, for reading and writing.
pub(super) fn open(path: &Path) -> Result<Data, OutputError> {
    let open = || {
        let mut file = File::options().read(true).write(true).open(path)?;
        let mut prefix = [0; PREFIX as usize];
        file.read_exact(&mut prefix)?;
        let (signature, length) = prefix.split_at(8);
        let length = u64::from_le_bytes(std::array::from_fn(|byte| length[byte]));
        if signature != SIGNATURE || length > file.metadata()?.len() {
            return Err(ErrorKind::UnexpectedEof.into());
        }
        let mut encoded = vec![0; length as usize];
        file.read_exact(&mut encoded)?;
        let (header, arrays, _) = decode_header(&encoded)?;
        let arrays = arrays.to_vec();
        let places = Places::find(&mut file, PREFIX + length)?;
        Ok(Data { layout: Layout::new(&header), file, header, arrays, places })
    };
    open().map_err(|error: io::Error| match error.kind() {
        ErrorKind::UnexpectedEof | ErrorKind::InvalidData => OutputError::Cache {
            path: path.to_owned(),
            reason: "its beginning is incomplete or was changed".to_owned(),
        },
        _ => OutputError::io("read", path)(error),
    })
}
