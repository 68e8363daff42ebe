//! A file that holds one value whole or is refused: a header, a length, a checksum, the value.

use std::io::Write;
use std::path::Path;

use serde::Serialize;
use serde::de::DeserializeOwned;

use super::error::RunError;
use super::hash::fnv1a;

/// Says what the file is.
const MAGIC: [u8; 8] = *b"SUPPLECK";
/// Counts the changes of what a checkpoint holds; older files are refused.
const VERSION: u32 = 2;
/// Magic, version, length and checksum.
const HEADER: usize = 8 + 4 + 8 + 8;

/// Writes a value under a temporary name and renames it: the name never holds half a file.
pub(super) fn write<T: Serialize>(path: &Path, value: &T) -> Result<(), RunError> {
    let failed = |source| RunError::io("write", path, source);
    let payload = postcard::to_stdvec(value)
        .map_err(|error| failed(std::io::Error::other(format!("cannot encode: {error}"))))?;
    let temporary = path.with_extension("checkpoint.tmp");
    let save = || {
        let mut file = std::fs::File::create(&temporary)?;
        file.write_all(&MAGIC)?;
        file.write_all(&VERSION.to_le_bytes())?;
        file.write_all(&(payload.len() as u64).to_le_bytes())?;
        file.write_all(&fnv1a(&payload).to_le_bytes())?;
        file.write_all(&payload)?;
        drop(file);
        std::fs::rename(&temporary, path)
    };
    save().map_err(|source| {
        // What could be written is of no use; a failure to remove it leaves a file that nothing reads.
        let _ = std::fs::remove_file(&temporary);
        failed(source)
    })
}

/// Reads a value back; `None` if there is no file.
pub(super) fn read<T: DeserializeOwned>(path: &Path) -> Result<Option<T>, RunError> {
    let bytes = match std::fs::read(path) {
        Ok(bytes) => bytes,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(source) => return Err(RunError::io("read", path, source)),
    };
    let damaged = |what: &str| RunError::Checkpoint { path: path.to_owned(), what: what.to_owned() };
    if bytes.len() < HEADER || bytes[..8] != MAGIC {
        return Err(damaged("it is not a checkpoint of supple, or only its beginning"));
    }
    let number = |range: std::ops::Range<usize>| {
        bytes[range].iter().rev().fold(0_u64, |number, &byte| number << 8 | u64::from(byte))
    };
    let version = number(8..12);
    if version != u64::from(VERSION) {
        return Err(damaged(&format!("its format is version {version}, this program reads {VERSION}")));
    }
    let payload = &bytes[HEADER..];
    if payload.len() as u64 != number(12..20) {
        let expected = number(12..20);
        return Err(damaged(&format!("it holds {} bytes of {expected}", payload.len())));
    }
    if fnv1a(payload) != number(20..28) {
        return Err(damaged("its checksum does not match"));
    }
    postcard::from_bytes(payload).map(Some).map_err(|error| damaged(&format!("it does not decode: {error}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_damaged_file_is_refused_wherever_it_is_damaged() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("supple.checkpoint");
        assert!(read::<Vec<f32>>(&path).unwrap().is_none());
        let value = vec![1.0_f32, -2.5, f32::NAN];
        write(&path, &value).unwrap();
        let back: Vec<f32> = read(&path).unwrap().unwrap();
        assert!(back.iter().zip(&value).all(|(a, b)| a.to_bits() == b.to_bits()));

        let whole = std::fs::read(&path).unwrap();
        for length in 0..whole.len() {
            std::fs::write(&path, &whole[..length]).unwrap();
            assert!(matches!(read::<Vec<f32>>(&path), Err(RunError::Checkpoint { .. })), "{length}");
        }
        for at in 0..whole.len() {
            let mut bytes = whole.clone();
            bytes[at] ^= 0x20;
            std::fs::write(&path, &bytes).unwrap();
            assert!(matches!(read::<Vec<f32>>(&path), Err(RunError::Checkpoint { .. })), "{at}");
        }
    }
}
