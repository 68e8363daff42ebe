//! Bytes as base64 text in a page.
//!
//! The text is divided into `<script>` elements of a type that browsers do not run, because browsers limit the length
//! of a string to about 500 million characters. Each element is base64 text of its own.

use std::io::{self, Error, ErrorKind, Write};

use base64::display::Base64Display;
use base64::prelude::{BASE64_STANDARD, Engine};

/// Number of bytes in an element: 2^20 characters.
const ELEMENT: usize = 3 << 18;

/// Returns the start tag of the elements of a run.
fn start_tag(run: usize) -> String {
    format!("<script type=\"text/plain\" data-run=\"{run}\">")
}

/// Writes bytes as text in the elements of a run.
pub(super) struct TextWriter<W: Write> {
    inner: W,
    run: usize,
    /// The bytes of the next element.
    bytes: Vec<u8>,
}

impl<W: Write> TextWriter<W> {
    pub(super) fn new(inner: W, run: usize) -> Self {
        Self { inner, run, bytes: Vec::new() }
    }

    /// Writes the last element.
    pub(super) fn finish(mut self) -> io::Result<W> {
        self.write_element()?;
        Ok(self.inner)
    }

    /// Writes the collected bytes as an element, if there are any.
    fn write_element(&mut self) -> io::Result<()> {
        if !self.bytes.is_empty() {
            let text = Base64Display::new(&self.bytes, &BASE64_STANDARD);
            writeln!(self.inner, "{}{text}</script>", start_tag(self.run))?;
            self.bytes.clear();
        }
        Ok(())
    }
}

impl<W: Write> Write for TextWriter<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let taken = bytes.len().min(ELEMENT - self.bytes.len());
        self.bytes.extend_from_slice(&bytes[..taken]);
        if self.bytes.len() == ELEMENT {
            self.write_element()?;
        }
        Ok(taken)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Returns the bytes of each run of a page.
pub(super) fn runs(page: &[u8]) -> io::Result<Vec<Vec<u8>>> {
    let mut runs: Vec<Vec<u8>> = Vec::new();
    let mut rest = page;
    // Base64 text contains no `<`, so that the search for the next tag passes over it quickly.
    while let Some(at) = rest.iter().position(|&byte| byte == b'<') {
        rest = &rest[at..];
        let is_next = rest.starts_with(start_tag(runs.len()).as_bytes());
        let is_same = !runs.is_empty() && rest.starts_with(start_tag(runs.len() - 1).as_bytes());
        if is_next {
            runs.push(Vec::new());
        }
        let run = match runs.last_mut() {
            Some(run) if is_next || is_same => run,
            _ => {
                rest = &rest[1..];
                continue;
            }
        };
        let start = 1 + rest.iter().position(|&byte| byte == b'>').unwrap_or(0);
        let length = rest[start..].iter().position(|&byte| byte == b'<');
        let length = length.ok_or_else(|| invalid("the page is incomplete"))?;
        let decoded = BASE64_STANDARD.decode_vec(&rest[start..start + length], run);
        decoded.map_err(|_| invalid("the page has other data than this version writes"))?;
        rest = &rest[start + length..];
    }
    Ok(runs)
}

/// Returns the error that a page is invalid.
pub(super) fn invalid(problem: &str) -> Error {
    Error::new(ErrorKind::InvalidData, problem)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(bytes: &[u8], run: usize) -> Vec<u8> {
        let mut writer = TextWriter::new(Vec::new(), run);
        bytes.chunks(1000).for_each(|chunk| writer.write_all(chunk).unwrap());
        writer.finish().unwrap()
    }

    /// Bytes of a linear congruential generator (Knuth's MMIX).
    fn random(count: usize) -> Vec<u8> {
        let mut state = 1_u64;
        let next = |_| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 56) as u8
        };
        (0..count).map(next).collect()
    }

    #[test]
    fn bytes_of_several_runs_read_back_from_elements() {
        // The second run has more than one element.
        let all = [random(1), random(ELEMENT + 1), Vec::from([0_u8; 9]), vec![0xff; 15]];
        let mut page = b"<!doctype html>\n<p>".to_vec();
        all.iter().enumerate().for_each(|(run, bytes)| page.extend(text(bytes, run)));
        page.extend_from_slice(b"<script>let a = 1 < 2;</script>");
        assert_eq!(runs(&page).unwrap(), all);
        assert!(runs(&page[..page.len() / 2]).is_err(), "the element does not end");
        let start = page.len() / 2;
        page[start] = 0x7f;
        assert!(runs(&page).is_err(), "the element has a character that is not base64");
    }
}
