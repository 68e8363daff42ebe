//! The file `NAME.html.data` with the frames of a page that is not written yet.
//!
//! ```text
//! offset  0   8 bytes   "SUPPLEPG"
//!         8   u64       length of the description and its arrays, little endian
//!        16   u8        the description and its arrays
//!             u8        the frames, all of the same size
//! ```

use std::fs::File;
use std::io::{self, BufWriter, ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use super::sequence::PAGE_DATA;
use super::{OutputError, Sequence};
use crate::file::{write_atomically, write_durably};
use crate::html::{FrameSource, Header, Layout, Run, decode_header, encode_header};

const SIGNATURE: &[u8; 8] = b"SUPPLEPG";
/// Size of the signature and the length, in bytes.
const PREFIX: u64 = 16;

/// The open data of a page.
#[derive(Debug)]
pub(super) struct Data {
    file: File,
    pub(super) header: Header,
    pub(super) layout: Layout,
    pub(super) arrays: Vec<u8>,
    /// Offset of the first frame.
    start: u64,
    /// Size of a frame, in bytes.
    pub(super) frame_bytes: u64,
}

impl Data {
    /// Appends a frame. If this fails, truncates the file after the previous frame.
    pub(super) fn append(&mut self, frame: &[u8]) -> io::Result<()> {
        debug_assert_eq!(frame.len() as u64, self.frame_bytes, "all frames have the size of the layout");
        if let Err(error) = self.file.write_all(frame) {
            // The write error is returned; an error of the truncation would add nothing.
            let _ = self.truncate(self.header.frames as u64);
            return Err(error);
        }
        self.header.frames += 1;
        Ok(())
    }

    /// `length` is that of the encoded header.
    fn new(file: File, header: Header, arrays: Vec<u8>, length: usize) -> Self {
        let layout = Layout::new(&header);
        let frame_bytes = layout.bytes() as u64;
        Self { file, header, layout, arrays, start: PREFIX + length as u64, frame_bytes }
    }

    /// Returns the number of complete frames.
    pub(super) fn complete(&self) -> io::Result<u64> {
        Ok(self.file.metadata()?.len().saturating_sub(self.start) / self.frame_bytes.max(1))
    }

    /// Truncates the file after `frames` frames, and seeks to the end.
    pub(super) fn truncate(&mut self, frames: u64) -> io::Result<()> {
        self.header.frames = frames as usize;
        self.file.set_len(self.start + frames * self.frame_bytes)?;
        self.file.seek(SeekFrom::End(0)).map(drop)
    }
}

/// The frames of a data file.
pub(super) struct DataFrames {
    file: File,
    start: u64,
    frame_bytes: u64,
}

impl DataFrames {
    pub(super) fn open(path: &Path, data: &Data) -> Result<Self, OutputError> {
        let file = File::open(path).map_err(OutputError::io("read", path))?;
        Ok(Self { file, start: data.start, frame_bytes: data.frame_bytes })
    }
}

impl FrameSource for DataFrames {
    fn read_frame(&mut self, index: usize, frame: &mut Vec<u8>) -> io::Result<()> {
        frame.resize(self.frame_bytes as usize, 0);
        self.file.seek(SeekFrom::Start(self.start + index as u64 * self.frame_bytes))?;
        self.file.read_exact(frame)
    }
}

/// Returns the path of the data of a page.
pub(super) fn data_path(sequence: &Sequence) -> PathBuf {
    let mut name = sequence.path(0).into_os_string();
    name.push(PAGE_DATA);
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
    // Frames are counted by the length of the file.
    let mut header = run.header.clone();
    header.frames = 0;
    write_prefix(&mut out, &encode_header(&header, &run.arrays)?)?;
    let mut frame = Vec::new();
    for index in 0..run.header.frames {
        run.frames.read_frame(index, &mut frame)?;
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
        Ok(Data::new(file, header, arrays, encoded.len()))
    };
    open().map_err(|error: io::Error| match error.kind() {
        ErrorKind::UnexpectedEof | ErrorKind::InvalidData => OutputError::Cache {
            path: path.to_owned(),
            reason: "its beginning is incomplete or was changed".to_owned(),
        },
        _ => OutputError::io("read", path)(error),
    })
}
