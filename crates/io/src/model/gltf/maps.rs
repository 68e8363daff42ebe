//! Collects the maps of a file from the attributes of its primitives.

use std::collections::BTreeMap;

use ::gltf::Primitive;
use ::gltf::accessor::Dimensions;
use ::gltf::mesh::Semantic;

use super::super::error::Fault;
use super::super::surface::{Surface, finite};
use super::accessors::{Accessors, Read};
use crate::obj::{COLORS, WHITE};

/// The maps of a file, by their names.
pub(super) struct Maps {
    maps: BTreeMap<String, Map>,
    /// Number of values that may still be added.
    left: usize,
    /// Whether the maps were removed, because they have too many values.
    is_full: bool,
}

/// A value for each vertex up to a last one.
struct Map {
    values: Vec<f32>,
    /// Value of the other vertices.
    default: f32,
}

/// An attribute of a primitive.
enum Attribute {
    /// Colors, of which the first `channels` numbers are in the file.
    Colors(Read<[f32; 4]>, usize),
    /// A number for each vertex, and the name of their map.
    Numbers(Read<f32>, String),
}

impl Maps {
    /// `limit`: number of values that all maps have at most.
    pub(super) fn new(limit: usize) -> Self {
        Self { maps: BTreeMap::new(), left: limit, is_full: false }
    }

    /// Appends the values of the vertices `new` of a primitive, which are the vertices of the surface from `first` on.
    pub(super) fn append(
        &mut self,
        accessors: &Accessors<'_>,
        (primitive, count, element): (&Primitive<'_>, usize, &str),
        (first, new): (usize, &[u32]),
    ) -> Result<(), Fault> {
        for attribute in read(accessors, (primitive, count, element))? {
            match attribute {
                Attribute::Colors(colors, channels) => {
                    for (channel, name) in COLORS.into_iter().enumerate().take(channels) {
                        let values = new.iter().map(|&vertex| colors[vertex as usize][channel]);
                        self.extend(name, WHITE, first, values);
                    }
                }
                Attribute::Numbers(numbers, name) => {
                    self.extend(&name, 0.0, first, new.iter().map(|&vertex| numbers[vertex as usize]));
                }
            }
        }
        Ok(())
    }

    /// Appends values from the vertex `first` on to a map, unless another attribute has given them.
    fn extend(&mut self, name: &str, default: f32, first: usize, values: impl ExactSizeIterator<Item = f32>) {
        let length = self.maps.get(name).map_or(0, |map| map.values.len());
        if self.is_full || length > first || !self.spend(first - length + values.len() + 1) {
            return;
        }
        let map = self.maps.entry(name.to_owned()).or_insert(Map { values: Vec::new(), default });
        map.values.resize(first, map.default);
        map.values.extend(values.flat_map(|value| finite([value])));
    }

    /// Counts values. Removes all maps if there are too many.
    fn spend(&mut self, count: usize) -> bool {
        match self.left.checked_sub(count) {
            Some(left) => self.left = left,
            None => (self.is_full, self.maps) = (true, BTreeMap::new()),
        }
        !self.is_full
    }

    /// Adds the maps to the surface with all their vertices.
    pub(super) fn finish(mut self, surface: &mut Surface) {
        let count = surface.positions.len();
        let missing = self.maps.values().map(|map| count - map.values.len()).sum();
        self.spend(missing);
        if self.is_full {
            surface.ignored.push("colors and attributes of vertices, of which there are too many".to_owned());
        }
        surface.maps.extend(self.maps.into_iter().map(|(name, Map { mut values, default })| {
            values.resize(count, default);
            (name, values)
        }));
    }
}

/// Reads the colors and the numbers of applications of a primitive with `count` vertices. `element` describes it in
/// messages.
fn read(
    accessors: &Accessors<'_>,
    (primitive, count, element): (&Primitive<'_>, usize, &str),
) -> Result<Vec<Attribute>, Fault> {
    let mut found = Vec::new();
    for (semantic, accessor) in primitive.attributes() {
        let element = format!("{element}, {}", semantic.to_string());
        let (length, attribute) = match semantic {
            Semantic::Colors(0) => {
                let colors = accessors.colors(&accessor, &element)?;
                let channels = if accessor.dimensions() == Dimensions::Vec4 { 4 } else { 3 };
                (colors.len(), Attribute::Colors(colors, channels))
            }
            Semantic::Extras(name) => match accessors.numbers(&accessor, &element)? {
                Some(numbers) => (numbers.len(), Attribute::Numbers(numbers, name.to_lowercase())),
                None => continue,
            },
            _ => continue,
        };
        if length < count {
            return Err(Fault(format!("{element}: fewer than vertices; export it again")));
        }
        found.push(attribute);
    }
    // Colors come first, so that they take precedence over an attribute with the name of one.
    found.sort_by_key(|attribute| matches!(attribute, Attribute::Numbers(..)));
    Ok(found)
}
