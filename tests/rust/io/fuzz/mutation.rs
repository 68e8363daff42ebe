//! Mutations of an input.

use std::ops::Range;

use fastrand::Rng;

/// Numbers at the limits of integer and float types, and malformed ones.
const NUMBERS: [&str; 22] = [
    "0",
    "-0",
    "1",
    "-1",
    "2",
    "7",
    "255",
    "65536",
    "2147483648",
    "-2147483649",
    "4294967296",
    "18446744073709551616",
    "1e39",
    "-1e309",
    "1e-320",
    "nan",
    "-inf",
    "0x10",
    "1_000",
    "1.5.2",
    "999999999999999999999999",
    "+.5e+3",
];

/// One kind of mutation.
#[derive(Clone, Copy)]
pub(super) enum Mutation {
    FlipByte,
    InsertByte,
    RemoveRange,
    RepeatRange,
    TakeFromOther,
    ReplaceNumber,
    ReplaceWord,
    SwapLines,
    RepeatLine,
    RemoveLine,
    Truncate,
}

impl Mutation {
    /// Returns a random mutation.
    pub(super) fn any(rng: &mut Rng) -> Self {
        const ALL: [Mutation; 14] = [
            Mutation::FlipByte,
            Mutation::InsertByte,
            Mutation::RemoveRange,
            Mutation::RepeatRange,
            Mutation::TakeFromOther,
            Mutation::TakeFromOther,
            Mutation::ReplaceNumber,
            Mutation::ReplaceNumber,
            Mutation::ReplaceWord,
            Mutation::ReplaceWord,
            Mutation::SwapLines,
            Mutation::RepeatLine,
            Mutation::RemoveLine,
            Mutation::Truncate,
        ];
        ALL[rng.usize(..ALL.len())]
    }

    /// Mutates `input`; `other` is another input of the corpus.
    pub(super) fn apply(self, input: &mut Vec<u8>, other: &[u8], words: &[&str], rng: &mut Rng) {
        let at = rng.usize(..=input.len());
        match self {
            Self::FlipByte => {
                if let Some(byte) = input.get_mut(at) {
                    *byte ^= 1 << rng.u32(..8);
                }
            }
            Self::InsertByte => input.insert(at, rng.u8(..)),
            Self::RemoveRange => drop(input.drain(range(input.len(), 64, rng))),
            Self::RepeatRange => {
                let repeated = input[range(input.len(), 256, rng)].repeat(rng.usize(1..8));
                input.splice(at..at, repeated);
            }
            Self::TakeFromOther => {
                let taken = &other[range(other.len(), 512, rng)];
                input.splice(at..at, taken.iter().copied());
            }
            Self::ReplaceNumber => {
                let token = token(input, at, |byte| byte.is_ascii_digit() || b"+-._eE".contains(&byte));
                input.splice(token, NUMBERS[rng.usize(..NUMBERS.len())].bytes());
            }
            Self::ReplaceWord => {
                let token = token(input, at, |byte| byte.is_ascii_alphanumeric() || byte == b'_');
                input.splice(token, words[rng.usize(..words.len())].bytes());
            }
            Self::SwapLines => {
                let (one, two) = (line(input, at), line(input, rng.usize(..=input.len())));
                if one.end <= two.start {
                    let (first, second) = (input[one.clone()].to_vec(), input[two.clone()].to_vec());
                    input.splice(two, first);
                    input.splice(one, second);
                }
            }
            Self::RepeatLine => {
                let line = line(input, at);
                // With other line ends, the whole input may be one line.
                let repeated =
                    input[line.clone()].repeat(rng.usize(1..if line.len() < 1000 { 40 } else { 2 }));
                input.splice(line.end..line.end, repeated);
            }
            Self::RemoveLine => drop(input.drain(line(input, at))),
            Self::Truncate => input.truncate(at),
        }
    }
}

/// Returns a random range of at most `longest` bytes.
fn range(length: usize, longest: usize, rng: &mut Rng) -> Range<usize> {
    let start = rng.usize(..=length);
    start..length.min(start + rng.usize(..=longest))
}

/// Returns the range of adjacent bytes around `at` that satisfy `belongs`.
fn token(input: &[u8], at: usize, belongs: impl Fn(u8) -> bool) -> Range<usize> {
    let before = input[..at].iter().rev().take_while(|byte| belongs(**byte)).count();
    let after = input[at..].iter().take_while(|byte| belongs(**byte)).count();
    at - before..at + after
}

/// Returns the range of the line around `at`, with its line end.
fn line(input: &[u8], at: usize) -> Range<usize> {
    let start = input[..at].iter().rposition(|byte| *byte == b'\n').map_or(0, |end| end + 1);
    let end = input[at..].iter().position(|byte| *byte == b'\n').map_or(input.len(), |end| at + end + 1);
    start..end
}
