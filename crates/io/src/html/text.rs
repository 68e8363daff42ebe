//! Bytes as text in a page: seven bits a character.
//!
//! A character is an ASCII character with the code of its seven bits, the lowest bits of the bytes first. The three
//! codes that an HTML parser would change or read as a tag become the character 128 codes higher, which UTF-8 encodes
//! in two bytes: zero, the carriage return and `<`. The seven bits of any character are its code modulo 128. Text of
//! random bytes is 8/7 (1 + 3/128) = 1.17 times as long as the bytes; base64 would be 1.33 times as long.
//!
//! The text is divided into `<script>` elements of a type that browsers do not run, because browsers limit the length
//! of a string to about 500 million characters. Each element holds whole groups of eight characters, except the last
//! one.

use std::io::{self, Error, ErrorKind, Write};

/// Number of characters of an element, a multiple of 8.
const ELEMENT: usize = 8 << 20;

/// Number of bytes that are written at once.
const BUFFER: usize = 1 << 16;

/// First byte of the two bytes of an escaped character in UTF-8.
const ESCAPE: u8 = 0xc2;

/// Returns the start tag of the elements of a run.
fn start_tag(run: usize) -> String {
    format!("<script type=\"text/plain\" data-run=\"{run}\">")
}

const END_TAG: &[u8] = b"</script>\n";

/// Writes bytes as text in the elements of a run.
pub(super) struct TextWriter<W: Write> {
    inner: W,
    run: usize,
    text: Vec<u8>,
    /// Bits that do not fill a character yet.
    bits: u32,
    bit_count: u32,
    /// Number of characters of the open element; 0 if no element is open.
    characters: usize,
}

impl<W: Write> TextWriter<W> {
    pub(super) fn new(inner: W, run: usize) -> Self {
        Self { inner, run, text: Vec::with_capacity(2 * BUFFER), bits: 0, bit_count: 0, characters: 0 }
    }

    /// Writes the remaining bits and ends the last element.
    pub(super) fn finish(mut self) -> io::Result<W> {
        if self.bit_count > 0 {
            self.push_character();
        }
        if self.characters > 0 {
            self.text.extend_from_slice(END_TAG);
        }
        self.inner.write_all(&self.text)?;
        Ok(self.inner)
    }

    /// Moves the seven lowest bits, or the remaining ones, to the text.
    fn push_character(&mut self) {
        if self.characters == 0 {
            self.text.extend_from_slice(start_tag(self.run).as_bytes());
        }
        match (self.bits & 127) as u8 {
            code @ (0 | b'\r' | b'<') => self.text.extend([ESCAPE, code | 0x80]),
            code => self.text.push(code),
        }
        self.bits >>= 7;
        self.bit_count = self.bit_count.saturating_sub(7);
        self.characters += 1;
        if self.characters == ELEMENT {
            self.text.extend_from_slice(END_TAG);
            self.characters = 0;
        }
    }
}

impl<W: Write> Write for TextWriter<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        for &byte in bytes {
            self.bits |= u32::from(byte) << self.bit_count;
            self.bit_count += 8;
            while self.bit_count >= 7 {
                self.push_character();
            }
        }
        if self.text.len() >= BUFFER {
            self.inner.write_all(&self.text)?;
            self.text.clear();
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Returns the bytes of each run of a page.
pub(super) fn runs(page: &[u8]) -> io::Result<Vec<Vec<u8>>> {
    let mut runs: Vec<Vec<u8>> = Vec::new();
    let mut rest = page;
    // Text contains no `<`, so that the search for the next tag passes over it quickly.
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
        decode(&rest[start..start + length], run)?;
        rest = &rest[start + length..];
    }
    Ok(runs)
}

/// Appends the bytes of the text of an element to `bytes`.
fn decode(text: &[u8], bytes: &mut Vec<u8>) -> io::Result<()> {
    let (mut bits, mut bit_count) = (0_u32, 0);
    for &code in text {
        match code {
            ESCAPE => continue,
            0..=0x7f => bits |= u32::from(code) << bit_count,
            0x80..=0xbf => bits |= u32::from(code & 0x7f) << bit_count,
            _ => return Err(invalid("the page was saved in another encoding than UTF-8")),
        }
        bit_count += 7;
        if bit_count >= 8 {
            bytes.push(bits as u8);
            bits >>= 8;
            bit_count -= 8;
        }
    }
    Ok(())
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
        let all = [random(1), random(ELEMENT), Vec::from([0_u8; 9]), vec![0xff; 15]];
        let mut page = b"<!doctype html>\n<p>".to_vec();
        all.iter().enumerate().for_each(|(run, bytes)| page.extend(text(bytes, run)));
        page.extend_from_slice(b"<script>let a = 1 < 2;</script>");
        assert_eq!(runs(&page).unwrap(), all);
        assert!(runs(&page[..page.len() / 2]).is_err(), "the element does not end");
    }

    #[test]
    fn text_is_utf8_without_the_characters_that_a_parser_changes() {
        let bytes = random(70_000);
        let text = String::from_utf8(text(&bytes, 0)).unwrap();
        let inside = text.strip_prefix(&start_tag(0)).unwrap().strip_suffix("</script>\n").unwrap();
        assert!(!inside.contains(['\0', '\r', '<']));
        assert_eq!(inside.chars().count(), 80_000);
        // 80,000 characters, of which 3/128 have two bytes: 1875, give or take five standard deviations of 43.
        assert!(inside.len().abs_diff(81_875) < 215, "{}", inside.len());
    }
}
