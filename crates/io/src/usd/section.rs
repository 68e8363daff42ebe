//! The sections of a crate file, and its table of contents.

use super::coding::{code_integers, lz4};

/// Types of specs.
#[derive(Clone, Copy)]
#[repr(u32)]
pub(super) enum SpecType {
    Attribute = 1,
    Prim = 6,
    PseudoRoot = 7,
    Relationship = 8,
}

/// Number of sections.
const SECTIONS: usize = 6;

/// Size of the table of contents, in bytes.
pub(crate) const CONTENTS: u64 = 8 + 32 * SECTIONS as u64;

/// Marks the end of a list of fields.
pub(super) const END_OF_FIELDS: u32 = u32::MAX;

/// A path element below its parent.
pub(super) struct PathNode {
    /// Token of the name; negative for a property.
    pub(super) element: i32,
    pub(super) jump: i32,
}

/// The tables of a file.
#[derive(Default)]
pub(super) struct Tables {
    pub(super) tokens: Vec<String>,
    /// Tokens of the strings.
    pub(super) strings: Vec<u32>,
    /// Tokens of the names of fields, and their values.
    pub(super) fields: Vec<(u32, u64)>,
    /// Fields of the specs, each list with [`END_OF_FIELDS`] after it.
    pub(super) field_lists: Vec<u32>,
    pub(super) paths: Vec<PathNode>,
    /// Type and first field of each spec; spec `k` has path `k`.
    pub(super) specs: Vec<(SpecType, u32)>,
}

impl Tables {
    /// Returns the bytes of the sections and of the table of contents, and the offset of the table, for sections that
    /// begin at an offset.
    pub(super) fn sections(&self, offset: u64) -> (Vec<u8>, u64) {
        let tokens: Vec<u8> = self.tokens.iter().flat_map(|token| token.bytes().chain([0])).collect();
        let words = |integers: &mut dyn ExactSizeIterator<Item = u32>| sized(&lz4(&code_integers(integers)));
        let count = |count: usize| (count as u64).to_le_bytes().to_vec();
        let values: Vec<u8> = self.fields.iter().flat_map(|(_, value)| value.to_le_bytes()).collect();
        let strings: Vec<u8> = self.strings.iter().flat_map(|token| token.to_le_bytes()).collect();
        let paths = self.paths.len();
        let sections: [_; SECTIONS] = [
            ("TOKENS", [count(self.tokens.len()), count(tokens.len()), sized(&lz4(&tokens))].concat()),
            ("STRINGS", [count(self.strings.len()), strings].concat()),
            (
                "FIELDS",
                [
                    count(self.fields.len()),
                    words(&mut self.fields.iter().map(|(name, _)| *name)),
                    sized(&lz4(&values)),
                ]
                .concat(),
            ),
            (
                "FIELDSETS",
                [count(self.field_lists.len()), words(&mut self.field_lists.iter().copied())].concat(),
            ),
            (
                "PATHS",
                [
                    count(paths),
                    count(paths),
                    words(&mut (0..paths as u32)),
                    words(&mut self.paths.iter().map(|path| path.element as u32)),
                    words(&mut self.paths.iter().map(|path| path.jump as u32)),
                ]
                .concat(),
            ),
            (
                "SPECS",
                [
                    count(paths),
                    words(&mut (0..paths as u32)),
                    words(&mut self.specs.iter().map(|(_, fields)| *fields)),
                    words(&mut self.specs.iter().map(|(spec, _)| *spec as u32)),
                ]
                .concat(),
            ),
        ];
        let (mut all, mut contents) = (Vec::new(), count(sections.len()));
        for (name, bytes) in sections {
            let mut padded = [0; 16];
            padded[..name.len()].copy_from_slice(name.as_bytes());
            contents.extend(padded);
            contents.extend((offset + all.len() as u64).to_le_bytes());
            contents.extend((bytes.len() as u64).to_le_bytes());
            all.extend(bytes);
        }
        let table = offset + all.len() as u64;
        all.extend(contents);
        (all, table)
    }
}

/// Returns bytes after their number.
fn sized(bytes: &[u8]) -> Vec<u8> {
    [&(bytes.len() as u64).to_le_bytes()[..], bytes].concat()
}
