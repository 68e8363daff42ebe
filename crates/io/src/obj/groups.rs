//! The names in `o` and `g` statements and their faces.

use std::collections::HashMap;
use std::ops::Range;

/// A name from an `o` or `g` statement, and its faces.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Group {
    /// Name, decoded as UTF-8, or as Latin-1 if it is not valid UTF-8.
    pub name: String,
    /// Whether the statement is `o`; otherwise it is `g`.
    pub is_object: bool,
    /// Ranges of faces, from 0, in file order. They do not overlap.
    pub faces: Vec<Range<u32>>,
    /// Whether `name` is the whole text of a `g` with several names. Such an entry makes a name with spaces
    /// known.
    pub(super) is_alias: bool,
}

/// Collects groups while the file is parsed.
#[derive(Debug, Default)]
pub(super) struct GroupBuilder {
    groups: Vec<Group>,
    index: HashMap<(bool, String), usize>,
    object: Option<usize>,
    current: Vec<usize>,
}

impl GroupBuilder {
    /// Processes an `o` statement before face number `face`. An empty name only ends the current object.
    pub(super) fn start_object(&mut self, name: String, face: u32) {
        let open = self.object.take();
        self.close(open, face);
        if !name.is_empty() {
            self.object = Some(self.open(name, true, false, face));
        }
    }

    /// Processes a `g` statement before face number `face`, from its names and its unsplit text.
    pub(super) fn start_groups(&mut self, names: Vec<String>, text: String, face: u32) {
        let open = std::mem::take(&mut self.current);
        self.close(open, face);
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

    /// Returns the groups that have faces, in order of their first statement.
    pub(super) fn finish(mut self, faces: u32) -> Vec<Group> {
        let open: Vec<_> = self.object.take().into_iter().chain(self.current.drain(..)).collect();
        self.close(open, faces);
        self.groups.retain(|group| !group.faces.is_empty());
        self.groups
    }

    /// Starts a range of faces in the group of this name and returns the index of the group.
    fn open(&mut self, name: String, is_object: bool, is_alias: bool, face: u32) -> usize {
        let next = self.groups.len();
        let group = *self.index.entry((is_object, name.clone())).or_insert(next);
        if group == next {
            self.groups.push(Group { name, is_object, faces: Vec::new(), is_alias });
        }
        let group_faces = &mut self.groups[group].faces;
        // A range may already be open: the same name twice on one line.
        if group_faces.last().is_none_or(|range| range.start != face || range.end != face) {
            group_faces.push(face..face);
        }
        group
    }

    /// Ends the last range of each of these groups before `face`; removes the range if it is empty.
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
