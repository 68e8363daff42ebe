//! Splits bytes into statements and words, and handles continued lines and comments. Returns byte ranges;
//! decodes and copies nothing.

use std::borrow::Cow;
use std::ops::Range;

/// A statement: a line together with the lines that continue it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Statement {
    /// Byte range, without the final line end, but with the continuations (`\` and a line end) inside.
    pub(super) bytes: Range<usize>,
    /// First line, from 1.
    pub(super) line: usize,
}

/// Iterator over the statements of a file. Lines end with LF, CRLF or CR; the last line may have no line end.
#[derive(Debug)]
pub(super) struct Statements<'a> {
    raw: &'a [u8],
    /// Offset of the next line.
    at: usize,
    /// Number of lines read so far.
    line: usize,
}

impl<'a> Statements<'a> {
    pub(super) fn new(raw: &'a [u8]) -> Self {
        // Skips a byte-order mark, which is not part of the first word.
        let at = if raw.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 };
        Self { raw, at, line: 0 }
    }

    /// Returns the number of lines read so far.
    pub(super) fn lines(&self) -> usize {
        self.line
    }

    /// Returns the offset of the next line.
    pub(super) fn offset(&self) -> usize {
        self.at
    }

    /// Advances past one line and returns the end of its text.
    fn next_line(&mut self) -> usize {
        let rest = &self.raw[self.at..];
        let length = rest.iter().position(|&byte| byte == b'\n' || byte == b'\r').unwrap_or(rest.len());
        let end = self.at + length;
        self.at = end + line_end(&self.raw[end..]);
        self.line += 1;
        end
    }
}

impl Iterator for Statements<'_> {
    type Item = Statement;

    fn next(&mut self) -> Option<Statement> {
        if self.at >= self.raw.len() {
            return None;
        }
        let start = self.at;
        let mut end = self.next_line();
        let line = self.line;
        let mut text = Continuation::default();
        let mut read = start;
        while text.continues_after(&self.raw[read..end]) && self.at < self.raw.len() {
            read = self.at;
            end = self.next_line();
        }
        Some(Statement { bytes: start..end, line })
    }
}

/// Finds out whether the next line continues a statement, line by line. It does if the text of the statement
/// so far, without blanks at its end, ends in `\` outside a comment. The comment `# C:\models\` does not
/// continue.
#[derive(Default)]
struct Continuation {
    has_comment: bool,
    ends_in_backslash: bool,
}

impl Continuation {
    /// Adds a line to the statement, and returns whether the next line continues it.
    fn continues_after(&mut self, line: &[u8]) -> bool {
        // A blank line changes nothing.
        if let Some(last) = line.trim_ascii_end().last() {
            self.ends_in_backslash = *last == b'\\';
        }
        // Searches for a comment only if it matters: most lines do not end in a backslash.
        self.has_comment |= self.ends_in_backslash && line.contains(&b'#');
        self.ends_in_backslash && !self.has_comment
    }
}

/// Returns the length of the line end at the start of `rest`, or 0 if `rest` does not start with a line end.
fn line_end(rest: &[u8]) -> usize {
    match rest {
        [b'\r', b'\n', ..] => 2,
        [b'\r' | b'\n', ..] => 1,
        _ => 0,
    }
}

/// Class of a byte for splitting words.
#[derive(Clone, Copy, PartialEq)]
enum Byte {
    Text,
    Space,
    Hash,
    Backslash,
}

/// Class of each byte. A table is fast, and most bytes of a file are classified.
const CLASSES: [Byte; 256] = {
    let mut bytes = [Byte::Text; 256];
    let spaces = b" \t\n\r\x0b\x0c";
    let mut at = 0;
    while at < spaces.len() {
        bytes[spaces[at] as usize] = Byte::Space;
        at += 1;
    }
    bytes[b'#' as usize] = Byte::Hash;
    bytes[b'\\' as usize] = Byte::Backslash;
    bytes
};

/// Iterator over the words of a statement, as byte ranges of `raw`.
#[derive(Clone, Debug)]
pub(super) struct Words<'a> {
    raw: &'a [u8],
    /// Offset of the next byte to read.
    at: usize,
    /// End of the statement.
    end: usize,
}

impl<'a> Words<'a> {
    pub(super) fn new(raw: &'a [u8], statement: &Range<usize>) -> Self {
        Self { raw, at: statement.start, end: statement.end }
    }

    /// Returns the length of the blank (a space or a continuation) at offset `at`, or 0 if there is no blank.
    #[inline]
    fn blank(&self, at: usize) -> usize {
        match CLASSES[self.raw[at] as usize] {
            Byte::Text | Byte::Hash => 0,
            Byte::Space => 1,
            Byte::Backslash => self.continuation(at),
        }
    }

    /// Returns the length of the continuation (a `\`, blanks and a line end) at offset `at`, or 0 if there is
    /// no continuation.
    #[cold]
    fn continuation(&self, at: usize) -> usize {
        let rest = &self.raw[at + 1..self.end];
        let blanks = rest.iter().position(|&byte| byte != b' ' && byte != b'\t').unwrap_or(rest.len());
        match line_end(&rest[blanks..]) {
            // The statement ends in a `\` without a next line.
            0 if at + 1 + blanks == self.end => 1 + blanks,
            0 => 0,
            length => 1 + blanks + length,
        }
    }

    fn skip_blanks(&mut self) {
        while self.at < self.end {
            match self.blank(self.at) {
                0 => break,
                length => self.at += length,
            }
        }
    }

    /// Returns the range of the text after the words read so far, without blanks at its ends. The text is a
    /// name that may contain spaces. A `#` after a space starts a comment; a `#` inside a word belongs to the
    /// name.
    pub(super) fn rest(mut self) -> Range<usize> {
        self.skip_blanks();
        let start = self.at;
        let mut end = start;
        while self.at < self.end && self.raw[self.at] != b'#' {
            while self.at < self.end && self.blank(self.at) == 0 {
                self.at += 1;
            }
            end = self.at;
            self.skip_blanks();
        }
        start..end
    }
}

impl Iterator for Words<'_> {
    type Item = Range<usize>;

    /// Returns the next word. It ends at a blank or a comment.
    #[inline]
    fn next(&mut self) -> Option<Range<usize>> {
        self.skip_blanks();
        let start = self.at;
        loop {
            let rest = &self.raw[self.at..self.end];
            self.at +=
                rest.iter().position(|&byte| CLASSES[byte as usize] != Byte::Text).unwrap_or(rest.len());
            // A backslash that is not a continuation is text.
            if self.at == self.end || self.raw[self.at] == b'#' || self.blank(self.at) > 0 {
                break;
            }
            self.at += 1;
        }
        if self.at == start {
            self.at = self.end;
            return None;
        }
        Some(start..self.at)
    }
}

/// Returns the line number, from 1, of the byte at `offset`.
pub(super) fn line_of(raw: &[u8], offset: usize) -> usize {
    let mut line = 1;
    let mut at = 0;
    while at < offset {
        match line_end(&raw[at..]) {
            0 => at += 1,
            length => {
                at += length;
                line += usize::from(at <= offset);
            }
        }
    }
    line
}

/// Decodes bytes as UTF-8, or as Latin-1 if they are not valid UTF-8.
pub(super) fn decode(bytes: &[u8]) -> Cow<'_, str> {
    match std::str::from_utf8(bytes) {
        Ok(text) => text.into(),
        Err(_) => bytes.iter().map(|&byte| char::from(byte)).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(raw: &[u8]) -> Vec<(usize, Vec<&[u8]>)> {
        let statements = Statements::new(raw);
        statements.map(|s| (s.line, Words::new(raw, &s.bytes).map(|word| &raw[word]).collect())).collect()
    }

    #[test]
    fn every_line_end_counts_once() {
        let raw = b"\xef\xbb\xbfv 1\r\nv 2\rv\t3 # c\nf 1 \\\r\n 2\\  \n3\nv 4#c\\\nlast";
        let expected: Vec<(usize, Vec<&[u8]>)> = vec![
            (1, vec![b"v", b"1"]),
            (2, vec![b"v", b"2"]),
            (3, vec![b"v", b"3"]),
            (4, vec![b"f", b"1", b"2", b"3"]),
            (7, vec![b"v", b"4"]),
            (8, vec![b"last"]),
        ];
        assert_eq!(words(raw), expected);
        for (line, offset) in [(1, 3), (1, 7), (2, 8), (3, 12), (4, 21), (5, 29), (8, raw.len() - 4)] {
            assert_eq!(line_of(raw, offset), line, "offset {offset}");
        }
    }

    #[test]
    fn backslash_without_a_next_line_is_text() {
        assert_eq!(words(b"o a\\b c\\"), [(1, vec![&b"o"[..], b"a\\b", b"c"])]);
        assert_eq!(words(b"o \\ x\n"), [(1, vec![&b"o"[..], b"\\", b"x"])]);
        assert_eq!(words(b"\\\n\\\n"), [(1, vec![])]);
    }

    #[test]
    fn names_keep_inner_spaces_and_hashes() {
        let rest = |raw: &'static [u8]| {
            let mut words = Words::new(raw, &(0..raw.len()));
            words.next();
            &raw[words.rest()]
        };
        assert_eq!(rest(b"usemtl  Skin  of#2 \t # comment"), b"Skin  of#2");
        assert_eq!(rest(b"g"), b"");
        assert_eq!(rest(b"g #x"), b"");
    }
}
