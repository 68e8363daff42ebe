//! Collects the objects (`o`) and groups (`g`) of a file, and their faces.

use std::borrow::Cow;
use std::collections::HashMap;
use std::ops::Range;

/// An object or group: a name from `o` or `g` statements, and the faces after these statements.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Group {
    /// Name, decoded as UTF-8, or as Latin-1 if it is not valid UTF-8.
    pub name: String,
    /// Whether this is an object (`o`). Otherwise it is a group (`g`).
    pub is_object: bool,
    /// Ranges of faces, from 0, in file order. They do not overlap.
    pub faces: Vec<Range<u32>>,
    /// Whether `name` is the whole text of a `g` statement with several words. The format separates the names
    /// of several groups by spaces, but some programs write one name with spaces; the alias makes this name
    /// known.
    pub(super) is_alias: bool,
}

/// Collects groups while the file is parsed. Most names are borrowed from the file.
#[derive(Debug, Default)]
pub(super) struct GroupBuilder<'a> {
    groups: Vec<Builder<'a>>,
    /// Index in `groups`, by `is_object` and name.
    index: HashMap<(bool, Cow<'a, str>), usize>,
    /// Index of the current object.
    object: Option<usize>,
    /// Indices of the current groups.
    current: Vec<usize>,
}

/// A group, and the first face of its current range if it has one.
#[derive(Debug)]
struct Builder<'a> {
    name: Cow<'a, str>,
    is_object: bool,
    is_alias: bool,
    faces: Vec<Range<u32>>,
    start: Option<u32>,
}

impl<'a> GroupBuilder<'a> {
    /// Processes an `o` statement. `face` is the index of the next face. An empty name only ends the current
    /// object.
    pub(super) fn start_object(&mut self, name: Cow<'a, str>, face: u32) {
        if let Some(ended) = self.object.take() {
            self.close(ended, face);
        }
        if !name.is_empty() {
            self.object = self.open(name, true, false, face);
        }
    }

    /// Processes a `g` statement with the words `names` and the whole text `text`. `face` is the index of the
    /// next face.
    pub(super) fn start_groups(
        &mut self,
        names: impl Iterator<Item = Cow<'a, str>>,
        text: Cow<'a, str>,
        face: u32,
    ) {
        let mut current = std::mem::take(&mut self.current);
        current.drain(..).for_each(|ended| self.close(ended, face));
        let mut count = 0;
        for name in names {
            current.extend(self.open(name, false, false, face));
            count += 1;
        }
        if count > 1 {
            current.extend(self.open(text, false, true, face));
        }
        self.current = current;
    }

    /// Returns the objects and groups that have faces, in the order of their first statements.
    pub(super) fn finish(mut self, faces: u32) -> Vec<Group> {
        for ended in self.object.take().into_iter().chain(std::mem::take(&mut self.current)) {
            self.close(ended, faces);
        }
        drop(self.index);
        let with_faces = self.groups.into_iter().filter(|group| !group.faces.is_empty());
        let group = |Builder { name, is_object, is_alias, faces, .. }| Group {
            name: name.into_owned(),
            is_object,
            faces,
            is_alias,
        };
        with_faces.map(group).collect()
    }

    /// Starts a range of faces at `face` in the group `name`, which is created if necessary. Returns the
    /// index of the group, or `None` if its range has started already: a name can occur twice in a statement.
    fn open(&mut self, name: Cow<'a, str>, is_object: bool, is_alias: bool, face: u32) -> Option<usize> {
        let next = self.groups.len();
        let group = *self.index.entry((is_object, name.clone())).or_insert(next);
        if group == next {
            self.groups.push(Builder { name, is_object, is_alias, faces: Vec::new(), start: None });
        }
        let start = &mut self.groups[group].start;
        if start.is_some() {
            return None;
        }
        *start = Some(face);
        Some(group)
    }

    /// Ends the current range of a group before `face`, and keeps it unless it is empty.
    fn close(&mut self, group: usize, face: u32) {
        let group = &mut self.groups[group];
        if let Some(start) = group.start.take().filter(|&start| start < face) {
            group.faces.push(start..face);
        }
    }
}
