//! Bytes to statements: lines, continuations, comments, words. Nothing is decoded or copied.

use std::ops::Range;

/// A statement: a line together with the lines that continue it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Statement {
    /// Bytes without the final line end. Continuations (`\` and a line end) are still inside.
    pub(super) bytes: Range<usize>,
    /// Its first line, from 1.
    pub(super) line: usize,
}

/// The statements of a file. Lines end with LF, CRLF or CR; the last one may lack its end.
#[derive(Debug)]
pub(super) struct Statements<'a> {
    raw: &'a [u8],
    at: usize,
    line: usize,
}

impl<'a> Statements<'a> {
    pub(super) fn new(raw: &'a [u8]) -> Self {
        // A byte-order mark is not part of the first word.
        let at = if raw.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 };
        Self { raw, at, line: 0 }
    }

    /// How many lines were passed.
    pub(super) fn lines(&self) -> usize {
        self.line
    }

    /// Passes one line; returns where its text ends.
    fn pass_line(&mut self) -> usize {
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
        let mut end = self.pass_line();
        let line = self.line;
        while self.at < self.raw.len() && is_continued(&self.raw[start..end]) {
            end = self.pass_line();
        }
        Some(Statement { bytes: start..end, line })
    }
}

/// Length of the line end that `rest` starts with.
fn line_end(rest: &[u8]) -> usize {
    match rest {
        [b'\r', b'\n', ..] => 2,
        [b'\r' | b'\n', ..] => 1,
        _ => 0,
    }
}

/// Whether a `\` ends the line. One that ends a comment (`# C:\models\`) continues nothing.
fn is_continued(text: &[u8]) -> bool {
    let trimmed = text.trim_ascii_end();
    trimmed.last() == Some(&b'\\') && !trimmed.contains(&b'#')
}

/// What a byte may be among words.
#[derive(Clone, Copy, PartialEq)]
enum Byte {
    Text,
    Space,
    Hash,
    Backslash,
}

/// What each byte may be: looked up, since most are looked at.
const IN_WORDS: [Byte; 256] = {
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

/// The words of a statement, as ranges of `raw`.
#[derive(Clone, Debug)]
pub(super) struct Words<'a> {
    raw: &'a [u8],
    at: usize,
    end: usize,
}

impl<'a> Words<'a> {
    pub(super) fn new(raw: &'a [u8], statement: &Range<usize>) -> Self {
        Self { raw, at: statement.start, end: statement.end }
    }

    /// Length of the blank at `at`: a space, or a continuation; 0 if there is none.
    #[inline]
    fn blank(&self, at: usize) -> usize {
        match IN_WORDS[self.raw[at] as usize] {
            Byte::Text | Byte::Hash => 0,
            Byte::Space => 1,
            Byte::Backslash => self.continuation(at),
        }
    }

    /// Length of a `\`, blanks and a line end.
    #[cold]
    fn continuation(&self, at: usize) -> usize {
        let rest = &self.raw[at + 1..self.end];
        let blanks = rest.iter().position(|&byte| byte != b' ' && byte != b'\t').unwrap_or(rest.len());
        match line_end(&rest[blanks..]) {
            // Nothing follows that it could continue with.
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

    /// What follows the words read so far, trimmed: a name that may hold spaces. A `#` after a space starts a
    /// comment; one inside a word belongs to the name.
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

    /// The next word before a blank or a comment.
    #[inline]
    fn next(&mut self) -> Option<Range<usize>> {
        self.skip_blanks();
        let start = self.at;
        loop {
            let rest = &self.raw[self.at..self.end];
            self.at +=
                rest.iter().position(|&byte| IN_WORDS[byte as usize] != Byte::Text).unwrap_or(rest.len());
            // A backslash that continues nothing is text.
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

/// The line, from 1, that the byte at `offset` lies on.
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

/// Text for people: UTF-8 where it is that, else Latin-1.
pub(super) fn decode(bytes: &[u8]) -> String {
    match std::str::from_utf8(bytes) {
        Ok(text) => text.to_owned(),
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
    fn a_backslash_elsewhere_is_text() {
        assert_eq!(words(b"o a\\b c\\"), [(1, vec![&b"o"[..], b"a\\b", b"c"])]);
        assert_eq!(words(b"o \\ x\n"), [(1, vec![&b"o"[..], b"\\", b"x"])]);
        assert_eq!(words(b"\\\n\\\n"), [(1, vec![])]);
    }

    #[test]
    fn names_keep_spaces_and_hashes_inside() {
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
