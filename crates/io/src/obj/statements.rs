//! Finds the statements of the faces of a file, and the objects, groups and materials that they belong to, in a pass of
//! its own, because only frames of broken bodies need them.

use std::ops::Range;

use super::Document;
use super::corner;
use super::lines::{Statements, Words};

/// Marks a corner without a `vt` in [`FaceStatements::textures`].
pub(crate) const NO_TEXTURE: u32 = u32::MAX;

/// The statements in force at a face, each with its byte range: `o`, `g`, `s` and `usemtl`.
pub(crate) type Context = [Option<Range<usize>>; 4];

/// The keywords of a [`Context`].
pub(crate) const CONTEXT: [&str; 4] = ["o", "g", "s", "usemtl"];

/// The statements of the faces of a file. Faces count as in the [`Document`].
#[derive(Debug, Default)]
pub(crate) struct FaceStatements {
    /// Byte range of each statement, without its line end.
    pub(crate) bytes: Vec<Range<usize>>,
    /// Offset of the line after each statement.
    pub(crate) next: Vec<usize>,
    /// `vt` index of each corner, from 0, or [`NO_TEXTURE`]; the corners of all faces one after another.
    pub(crate) textures: Vec<u32>,
    /// Number of `vt` statements.
    pub(crate) texture_count: usize,
    /// The different contexts, in the order of the file.
    pub(crate) contexts: Vec<Context>,
    /// Index of the context of each face.
    pub(crate) context_of: Vec<u32>,
    /// The context at the end of the file.
    pub(crate) last: Context,
    /// Offset of a line before which all `v`, `vt` and `vn` are, and after which no index is negative.
    pub(crate) elements_end: usize,
}

impl Document {
    /// Returns the words of a `v` statement after its three numbers, such as a color, with a blank before each.
    pub(crate) fn vertex_suffix(&self, v: u32) -> Vec<u8> {
        let rest = &self.bytes()[self.vertex_numbers()[v as usize].span().end..];
        let Some(statement) = Statements::new(rest).next() else { return Vec::new() };
        Words::new(rest, &statement.bytes).flat_map(|word| [b" ", &rest[word]].concat()).collect()
    }

    /// Returns the statements of the faces.
    pub(crate) fn face_statements(&self) -> FaceStatements {
        let raw = self.bytes();
        let mut found = FaceStatements::default();
        let mut context = Context::default();
        let (mut corners, mut is_relative) = (Vec::new(), false);
        let mut statements = Statements::new(raw);
        while let Some(statement) = statements.next() {
            let next = statements.offset();
            let mut words = Words::new(raw, &statement.bytes);
            let Some(keyword) = words.next() else { continue };
            let keyword = &raw[keyword];
            if let Some(index) = CONTEXT.iter().position(|name| name.as_bytes() == keyword) {
                context[index] = Some(statement.bytes);
                continue;
            }
            match keyword {
                b"v" | b"vt" | b"vn" => {
                    found.texture_count += usize::from(keyword == b"vt");
                    (found.elements_end, is_relative) = (next, false);
                }
                b"f" | b"fo" | b"l" | b"p" | b"curv" | b"curv2" | b"surf" => {
                    is_relative |= words.clone().any(|word| raw[word].contains(&b'-'));
                    if !keyword.starts_with(b"f") {
                        continue;
                    }
                    corners.clear();
                    corners.extend(words.map(|word| {
                        let texture = corner::parse(&raw[word]).and_then(|corner| corner.texture);
                        let count = found.texture_count as i64;
                        let texture = texture.map(|index| if index < 0 { count + index } else { index - 1 });
                        texture.and_then(|index| u32::try_from(index).ok()).unwrap_or(NO_TEXTURE)
                    }));
                    if corners.len() > 2 {
                        if found.contexts.last() != Some(&context) {
                            found.contexts.push(context.clone());
                        }
                        found.context_of.push(found.contexts.len() as u32 - 1);
                        found.textures.append(&mut corners);
                        found.bytes.push(statement.bytes);
                        found.next.push(next);
                    }
                }
                _ => {}
            }
        }
        if is_relative {
            found.elements_end = raw.len();
        }
        found.last = context;
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn statements(text: &str) -> FaceStatements {
        Document::from_bytes("a.obj", text.into()).unwrap().face_statements()
    }

    #[test]
    fn faces_have_their_texts_contexts_and_textures() {
        let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\no a\nf 1/1 2/2 3 # x\nf 1 2\nusemtl m\n\
                    f 1/2/ 2/1 3/1\n";
        let found = statements(text);
        assert_eq!(&text[found.bytes[0].clone()], "f 1/1 2/2 3 # x");
        assert_eq!(&text[found.next[0]..][..7], "f 1 2\nu");
        assert_eq!(found.textures, [0, 1, NO_TEXTURE, 1, 0, 0]);
        assert_eq!((found.texture_count, &found.context_of[..]), (2, &[0, 1][..]));
        assert_eq!(found.contexts[1][3].clone().map(|range| &text[range]), Some("usemtl m"));
        assert_eq!(&text[found.elements_end..][..3], "o a");
    }

    #[test]
    fn suffixes_are_the_words_after_the_numbers_of_the_whole_statement() {
        let text = "v 0 0 0\nv 1 0 0 1 0.5  0 # red\nv 0 1 0 1 \\\n 0 \\\r\n1 \nv 0 0 1 1#\nf 1 2 3";
        let document = Document::from_bytes("a.obj", text.into()).unwrap();
        let suffix = |v: u32| String::from_utf8(document.vertex_suffix(v)).unwrap();
        assert_eq!([0, 1, 2, 3].map(suffix), ["", " 1 0.5 0", " 1 0 1", " 1"]);
    }

    #[test]
    fn elements_end_after_the_last_relative_index() {
        let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -1\n";
        assert_eq!(statements(text).elements_end, text.len());
        let again = format!("{text}v 0 0 1\nf 1 2 4\n");
        assert_eq!(&again[statements(&again).elements_end..], "f 1 2 4\n");
    }
}
