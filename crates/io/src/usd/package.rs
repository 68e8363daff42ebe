//! Packages: a stage and its images in one file (Pixar, USDZ file format specification 1.3). It is a ZIP archive whose
//! files are not compressed. The stage is the first one, and the bytes of each begin at a multiple of 64.

use std::fs::File;
use std::io::{self, ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::Path;

use super::name::Names;
use crate::obj::Image;

/// The bytes of a file in a package begin at a multiple of this.
const ALIGNMENT: u64 = 64;

/// Offset of the stage in a package.
pub(crate) const STAGE: u64 = ALIGNMENT;

/// Name of the stage in a package: its bytes begin at [`STAGE`], after a header with the name.
const NAME: &str = "stage.usdc";

/// Sizes of the header before a file without its name, and of the head of a further field in it, in bytes.
const LOCAL: u64 = 30;
const EXTRA_HEAD: u64 = 4;

/// Identifier of the field that moves the bytes of a file to their place; OpenUSD has the same.
const EXTRA_ID: u16 = 0x1986;

/// Version of the format that a reader needs, times 10.
const VERSION: u16 = 10;

/// Most bytes of a package without its list of files: offsets have 32 bits.
const MAX: u64 = u32::MAX as u64 - (1 << 20);

const TOO_LARGE: &str = "it would have more than 4 GiB, and USDZ files have less: write fewer frames with `--every`, or write `usd`";

/// The images of a package.
#[derive(Debug, Default)]
pub(crate) struct Packed {
    /// The images, and their names in the package; `None` if the package cannot have one.
    images: Vec<(Image, Option<String>)>,
    names: Names,
}

impl Packed {
    /// Returns the name of an image in the package; `None` if the package cannot have it.
    pub(super) fn name_of(&mut self, image: &Image) -> Option<String> {
        if let Some((_, name)) = self.images.iter().find(|(known, _)| known == image) {
            return name.clone();
        }
        let name = image
            .read()
            .map(|(kind, _)| format!("images/{}.{}", self.names.unique(&image.stem()), kind.extension()));
        self.images.push((image.clone(), name.clone()));
        name
    }

    /// Returns the paths of the images that the package cannot have.
    pub(crate) fn left_out(&self) -> impl Iterator<Item = &Path> {
        let missing = self.images.iter().filter(|(_, name)| name.is_none());
        missing.filter_map(|(image, _)| match image {
            Image::File(path) => Some(path.as_path()),
            Image::Embedded(_) => None,
        })
    }

    /// Writes a package with the stage in `stage`.
    pub(crate) fn write(&self, out: &mut (impl Write + Seek), stage: &mut File) -> io::Result<()> {
        stage.rewind()?;
        let mut archive = Archive { out, at: 0, entries: Vec::new() };
        archive.add(NAME, stage)?;
        for (image, name) in &self.images {
            let Some(name) = name else { continue };
            let changed =
                || io::Error::new(ErrorKind::InvalidData, format!("the image {} has changed", image.stem()));
            let (_, bytes) = image.read().ok_or_else(changed)?;
            archive.add(name, &mut &bytes[..])?;
        }
        archive.finish()
    }
}

/// A file of an archive.
struct Entry {
    name: String,
    /// Offset of its header.
    at: u64,
    crc: u32,
    bytes: u64,
}

/// An archive that is written (PKWARE, APPNOTE.TXT 6.3.10, without compression, encryption and 64-bit sizes).
///
/// The crate zip (9.8) brings five further packages, most of them for encryption, which is not used here.
struct Archive<'a, W> {
    out: &'a mut W,
    at: u64,
    entries: Vec<Entry>,
}

impl<W: Write + Seek> Archive<'_, W> {
    /// Adds a file, whose bytes begin at a multiple of 64.
    fn add(&mut self, name: &str, from: &mut impl Read) -> io::Result<()> {
        let at = self.at;
        // A field of any length, at least that of its head, moves the bytes to their place.
        let head = at + LOCAL + name.len() as u64 + EXTRA_HEAD;
        let padding = head.next_multiple_of(ALIGNMENT) - head;
        let mut entry = Entry { name: name.to_owned(), at, crc: 0, bytes: 0 };
        self.out.write_all(&entry.local(padding as u16))?;
        let mut from = Hashed { from, hash: crc32fast::Hasher::new() };
        entry.bytes = io::copy(&mut from, self.out)?;
        entry.crc = from.hash.finalize();
        self.at = head + padding + entry.bytes;
        if self.at > MAX {
            return Err(io::Error::new(ErrorKind::FileTooLarge, TOO_LARGE));
        }
        self.out.seek(SeekFrom::Start(at))?;
        self.out.write_all(&entry.local(padding as u16))?;
        self.out.seek(SeekFrom::Start(self.at))?;
        self.entries.push(entry);
        Ok(())
    }

    /// Writes the list of the files.
    fn finish(self) -> io::Result<()> {
        let list: Vec<u8> = self.entries.iter().flat_map(Entry::central).collect();
        let (count, size) = (self.entries.len() as u16, list.len() as u32);
        self.out.write_all(&list)?;
        let mut end = Bytes::default();
        end.signature(0x0605_4b50).u16s(&[0, 0, count, count]).u32s(&[size, self.at as u32]).u16s(&[0]);
        self.out.write_all(&end.0)?;
        self.out.flush()
    }
}

impl Entry {
    /// Returns the header before the bytes of the file.
    fn local(&self, padding: u16) -> Vec<u8> {
        let mut bytes = Bytes::default();
        bytes.signature(0x0403_4b50);
        self.describe(&mut bytes).u16s(&[self.name.len() as u16, EXTRA_HEAD as u16 + padding]);
        bytes.0.extend(self.name.bytes());
        bytes.u16s(&[EXTRA_ID, padding]);
        bytes.0.resize(bytes.0.len() + usize::from(padding), 0);
        bytes.0
    }

    /// Returns the entry in the list of files.
    fn central(&self) -> Vec<u8> {
        let mut bytes = Bytes::default();
        bytes.signature(0x0201_4b50).u16s(&[VERSION]);
        // No extra field, comment, number of a disk and attributes of a file.
        self.describe(&mut bytes).u16s(&[self.name.len() as u16, 0, 0, 0, 0]).u32s(&[0, self.at as u32]);
        bytes.0.extend(self.name.bytes());
        bytes.0
    }

    /// Appends what both have: no flags, no compression, the first day of the format, the sum and the sizes.
    fn describe<'b>(&self, bytes: &'b mut Bytes) -> &'b mut Bytes {
        let size = self.bytes as u32;
        bytes.u16s(&[VERSION, 0, 0, 0, 1 << 5 | 1]).u32s(&[self.crc, size, size])
    }
}

/// Bytes that are built from numbers, little endian.
#[derive(Default)]
struct Bytes(Vec<u8>);

impl Bytes {
    fn signature(&mut self, signature: u32) -> &mut Self {
        self.u32s(&[signature])
    }

    fn u16s(&mut self, numbers: &[u16]) -> &mut Self {
        self.0.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
        self
    }

    fn u32s(&mut self, numbers: &[u32]) -> &mut Self {
        self.0.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
        self
    }
}

/// A reader whose bytes are hashed.
struct Hashed<'a, R> {
    from: &'a mut R,
    hash: crc32fast::Hasher,
}

impl<R: Read> Read for Hashed<'_, R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.from.read(buffer)?;
        self.hash.update(&buffer[..count]);
        Ok(count)
    }
}
