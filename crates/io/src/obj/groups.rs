//! Collects the objects (`o`) and groups (`g`) of a file, and their faces.

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

/// Collects groups while the file is parsed.
#[derive(Debug, Default)]
pub(super) struct GroupBuilder {
    groups: Vec<Group>,
    /// Index in `groups`, by `is_object` and name.
    index: HashMap<(bool, String), usize>,
    /// Index of the current object.
    object: Option<usize>,
    /// Indices of the current groups.
    current: Vec<usize>,
}

impl GroupBuilder {
    /// Processes an `o` statement. `face` is the index of the next face. An empty name only ends the current
    /// object.
    pub(super) fn start_object(&mut self, name: String, face: u32) {
        let ended = self.object.take();
        self.close(ended, face);
        if !name.is_empty() {
            self.object = Some(self.open(name, true, false, face));
        }
    }

    /// Processes a `g` statement with the words `names` and the whole text `text`. `face` is the index of the
    /// next face.
    pub(super) fn start_groups(&mut self, names: Vec<String>, text: String, face: u32) {
        let ended = std::mem::take(&mut self.current);
        self.close(ended, face);
        let several = names.len() > 1;
        for name in names {
            let group = self.open(name, false, false, face);
            if !self.current.contains(&group) {
                self.current.push(group);
            }
        }
        if several {
            let alias = self.open(text, false, true, face);
            if !self.current.contains(&alias) {
                self.current.push(alias);
            }
        }
    }

    /// Returns the objects and groups that have faces, in the order of their first statements.
    pub(super) fn finish(mut self, faces: u32) -> Vec<Group> {
        let ended: Vec<_> = self.object.take().into_iter().chain(self.current.drain(..)).collect();
        self.close(ended, faces);
        self.groups.retain(|group| !group.faces.is_empty());
        self.groups
    }

    /// Starts a range of faces at `face` in the group `name`, which is created if necessary. Returns the
    /// index of the group.
    fn open(&mut self, name: String, is_object: bool, is_alias: bool, face: u32) -> usize {
        let next = self.groups.len();
        let group = *self.index.entry((is_object, name.clone())).or_insert(next);
        if group == next {
            self.groups.push(Group { name, is_object, faces: Vec::new(), is_alias });
        }
        let group_faces = &mut self.groups[group].faces;
        // A name that occurs twice in a statement has already started this range.
        if group_faces.last().is_none_or(|range| range.start != face || range.end != face) {
            group_faces.push(face..face);
        }
        group
    }

    /// Ends the last range of each group before `face`, and removes the range if it is empty.
    fn close(&mut self, groups: impl IntoIterator<Item = usize>, face: u32) {
        for group in groups {
            let faces = &mut self.groups[group].faces;
            match faces.last_mut() {
                Some(range) if range.start < face => range.end = face,
                _ => drop(faces.pop()),
            }
        }
    }
}
