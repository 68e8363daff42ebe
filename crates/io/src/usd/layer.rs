//! Writes the structure of a crate file: all but the values in the frames.
//!
//! ```text
//! offset  0   8 bytes    "PXR-USDC"
//!         8   8 bytes    version: 0, 8, 0, zeros
//!        16   u64        offset of the table of contents
//!        24   64 bytes   zeros
//!        88   u64        XXH3 hash of what follows the frames; other programs skip it
//!        96              the frames, all of the same size but for the pieces of broken bodies
//!             arrays and other values that do not fit into their 48 bits, each at a multiple of 8
//!             the sections TOKENS, STRINGS, FIELDS, FIELDSETS, PATHS, SPECS
//!             table of contents: u64 number of sections; name (16 bytes), u64 offset and u64 size of each
//! ```
//!
//! A spec is a path with a list of fields; a field is a name (a token) with a value, in 64 bits: flags, a type, and 48
//! bits that hold the value or its offset in the file. All numbers are little endian. The version is the one that
//! OpenUSD 23.05 writes by default and 20.11 reads; later versions add only types that are not used here.
//!
//! The crate openusd (0.6) also writes such files, from all values in memory: 565 MB for a run of 240 frames of 100,000
//! points, a file of 288 MB, and it cannot continue a file. Here the frames go straight into the file, one frame is in
//! memory, and a run that is resumed continues the file.

use std::collections::HashMap;
use std::io::{self, Seek, SeekFrom, Write};

use xxhash_rust::xxh3::Xxh3Default;

use super::kind::{ARRAY, EXPLICIT, FRAMES, FrameTable, PREPENDED, Type, head};
use super::prim::{Prim, Property, Stored, Value};
use super::section::{END_OF_FIELDS, PathNode, SpecType, Tables};

struct Writer<'a, W> {
    out: W,
    /// Hash of all bytes so far.
    hash: Xxh3Default,
    /// Offset in the file.
    at: u64,
    frames: FrameTable<'a>,
    /// Field value of the time codes.
    times: u64,
    tables: Tables,
    token_indices: HashMap<String, u32>,
    /// Indices of the paths.
    path_indices: HashMap<String, u32>,
}

/// Writes the structure of a stage after its frames, and then its beginning. `root` has the metadata of the stage.
pub(super) fn write_layer(
    out: &mut (impl Write + Seek),
    root: &Prim,
    frames: FrameTable<'_>,
) -> io::Result<()> {
    out.seek(SeekFrom::Start(frames.end))?;
    let mut writer = Writer {
        at: frames.end,
        hash: Xxh3Default::new(),
        frames,
        times: 0,
        // Token 0 must not be the name of a property, because names of properties are negative.
        tables: Tables { tokens: vec![String::new()], ..Tables::default() },
        token_indices: HashMap::from([(String::new(), 0)]),
        path_indices: HashMap::new(),
        out: &mut *out,
    };
    writer.times = writer.write_value(Type::DoubleVector, |bytes| {
        bytes.extend((frames.times.len() as u64).to_le_bytes());
        bytes.extend(frames.times.iter().flat_map(|time| time.to_le_bytes()));
    })?;
    writer.index_paths(root, "", SpecType::PseudoRoot, false);
    writer.write_specs(root, true)?;
    let (sections, contents) = writer.tables.sections(writer.at);
    writer.append(&sections)?;
    let hash = writer.hash.digest();
    out.seek(SeekFrom::Start(0))?;
    out.write_all(&head(contents, hash))?;
    out.flush()
}

impl<W: Write> Writer<'_, W> {
    fn token(&mut self, text: &str) -> u32 {
        if let Some(&index) = self.token_indices.get(text) {
            return index;
        }
        let index = self.tables.tokens.len() as u32;
        self.tables.tokens.push(text.to_owned());
        self.token_indices.insert(text.to_owned(), index);
        index
    }

    fn string(&mut self, text: &str) -> u32 {
        let token = self.token(text);
        self.tables.strings.push(token);
        self.tables.strings.len() as u32 - 1
    }

    /// Gives the paths of a prim, its properties and its children their indices, in the order of depth. `has_sibling`
    /// tells whether a path with the same parent follows.
    fn index_paths(&mut self, prim: &Prim, path: &str, spec: SpecType, has_sibling: bool) {
        let is_root = matches!(spec, SpecType::PseudoRoot);
        let element = if is_root { 0 } else { self.token(&prim.name) as i32 };
        let index = self.push_path(if is_root { "/" } else { path }, element);
        let children = prim.properties.len() + prim.children.len();
        let more = |child: usize| child + 1 < children;
        for (child, property) in prim.properties.iter().enumerate() {
            let element = -(self.token(&property.name) as i32);
            let index = self.push_path(&format!("{path}.{}", property.name), element);
            self.tables.paths[index].jump = jump(false, more(child), 0);
        }
        for (child, prim_below) in prim.children.iter().enumerate() {
            let has_sibling = more(prim.properties.len() + child);
            let path = format!("{path}/{}", prim_below.name);
            self.index_paths(prim_below, &path, SpecType::Prim, has_sibling);
        }
        self.tables.paths[index].jump = jump(children > 0, has_sibling, self.tables.paths.len() - index);
    }

    fn push_path(&mut self, path: &str, element: i32) -> usize {
        let index = self.tables.paths.len();
        self.tables.paths.push(PathNode { element, jump: 0 });
        self.path_indices.insert(path.to_owned(), index as u32);
        index
    }

    /// Writes the values of a prim, its properties and its children, in the order of their paths.
    fn write_specs(&mut self, prim: &Prim, is_root: bool) -> io::Result<()> {
        let mut metadata = prim.metadata.clone();
        let names = |names: &mut dyn Iterator<Item = &String>| Value::Names(names.cloned().collect());
        if !prim.properties.is_empty() {
            metadata.push(("properties", names(&mut prim.properties.iter().map(|property| &property.name))));
        }
        if !prim.children.is_empty() {
            metadata.push(("primChildren", names(&mut prim.children.iter().map(|child| &child.name))));
        }
        self.write_spec(if is_root { SpecType::PseudoRoot } else { SpecType::Prim }, &metadata)?;
        for Property { is_relationship, metadata, .. } in &prim.properties {
            let spec = if *is_relationship { SpecType::Relationship } else { SpecType::Attribute };
            self.write_spec(spec, metadata)?;
        }
        prim.children.iter().try_for_each(|child| self.write_specs(child, false))
    }

    fn write_spec(&mut self, spec: SpecType, metadata: &[(&'static str, Value)]) -> io::Result<()> {
        self.tables.specs.push((spec, self.tables.field_lists.len() as u32));
        for (name, value) in metadata {
            let name = self.token(name);
            let value = self.field_value(value)?;
            self.tables.field_lists.push(self.tables.fields.len() as u32);
            self.tables.fields.push((name, value));
        }
        self.tables.field_lists.push(END_OF_FIELDS);
        Ok(())
    }

    /// Returns the 64 bits of a value. Writes a value that does not fit into them.
    fn field_value(&mut self, value: &Value) -> io::Result<u64> {
        Ok(match value {
            Value::Bool(value) => Type::Bool.inlined((*value).into()),
            Value::Float(value) => Type::Float.inlined(value.to_bits()),
            Value::Double(value) => {
                self.write_value(Type::Double, |bytes| bytes.extend(value.to_le_bytes()))?
            }
            Value::Token(text) => Type::Token.inlined(self.token(text)),
            Value::Tokens(texts) => {
                let tokens: Vec<u32> = texts.iter().map(|text| self.token(text)).collect();
                self.write_array(Type::Token, tokens.iter().map(|token| token.to_le_bytes()))?
            }
            Value::String(text) => Type::String.inlined(self.string(text)),
            Value::Asset(path) => Type::Asset.inlined(self.token(path)),
            Value::Vector(vector) => self.write_value(Type::Vec3f, |bytes| {
                bytes.extend(vector.iter().flat_map(|x| x.to_le_bytes()))
            })?,
            Value::Matrix(matrix) => self.write_value(Type::Matrix4d, |bytes| {
                bytes.extend(matrix.as_flattened().iter().flat_map(|x| x.to_le_bytes()));
            })?,
            Value::Integers(integers) => {
                self.write_array(Type::Int, integers.iter().map(|integer| integer.to_le_bytes()))?
            }
            Value::Vectors2(vectors) => {
                self.write_array(Type::Vec2f, vectors.as_flattened().iter().map(|x| x.to_le_bytes()))?
            }
            Value::Vectors3(vectors) => {
                self.write_array(Type::Vec3f, vectors.as_flattened().iter().map(|x| x.to_le_bytes()))?
            }
            Value::Names(names) => {
                let tokens: Vec<u32> = names.iter().map(|name| self.token(name)).collect();
                self.write_value(Type::TokenVector, |bytes| push_words(bytes, &tokens))?
            }
            Value::Prepended(names) => {
                let tokens: Vec<u32> = names.iter().map(|name| self.token(name)).collect();
                self.write_list(Type::TokenListOp, PREPENDED, &tokens)?
            }
            Value::Paths(paths) => {
                let indices: Vec<u32> = paths.iter().map(|path| self.path_indices[path]).collect();
                self.write_list(Type::PathListOp, EXPLICIT, &indices)?
            }
            Value::Def => Type::Specifier.inlined(0),
            Value::Uniform => Type::Variability.inlined(1),
            Value::FirstFrame(stored) => {
                stored.in_frame(self.frames.starts.first().map_or(FRAMES, |start| *start))
            }
            Value::Written(value) => *value,
            Value::PerFrame { values, of_frame } => self.write_chosen(values, of_frame)?,
            Value::Samples(stored) => self.write_samples(*stored)?,
        })
    }

    /// Writes the values of all frames: where the time codes are, and the value of each frame.
    fn write_samples(&mut self, stored: Stored) -> io::Result<u64> {
        let values = self.frames.starts.iter().map(|start| stored.in_frame(*start)).collect();
        self.write_times(values)
    }

    /// Writes values, and for each frame which one it has.
    fn write_chosen(&mut self, values: &[Value], of_frame: &[usize]) -> io::Result<u64> {
        let values = values.iter().map(|value| self.field_value(value)).collect::<io::Result<Vec<u64>>>()?;
        self.write_times(of_frame.iter().map(|&value| values[value]).collect())
    }

    /// Writes the field values of all frames.
    fn write_times(&mut self, values: Vec<u64>) -> io::Result<u64> {
        let times = self.times;
        self.write_value(Type::TimeSamples, |bytes| {
            // Each part is preceded by the distance to what follows it, which is not used here: 8 bytes.
            bytes.extend([8, times, 8, values.len() as u64].iter().flat_map(|word| word.to_le_bytes()));
            bytes.extend(values.iter().flat_map(|value| value.to_le_bytes()));
        })
    }

    fn write_list(&mut self, kind: Type, header: u8, items: &[u32]) -> io::Result<u64> {
        self.write_value(kind, |bytes| {
            bytes.push(header);
            push_words(bytes, items);
        })
    }

    /// Writes a value at a multiple of 8.
    fn write_value(&mut self, kind: Type, fill: impl FnOnce(&mut Vec<u8>)) -> io::Result<u64> {
        let padding = self.at.next_multiple_of(8) - self.at;
        let mut bytes = vec![0; padding as usize];
        fill(&mut bytes);
        let offset = self.at + padding;
        self.append(&bytes)?;
        Ok(kind.at(offset))
    }

    /// Writes an array of numbers: the number of elements, then their numbers.
    fn write_array(
        &mut self,
        kind: Type,
        numbers: impl ExactSizeIterator<Item = [u8; 4]>,
    ) -> io::Result<u64> {
        let size = match kind {
            Type::Vec2f => 2,
            Type::Vec3f => 3,
            _ => 1,
        };
        if numbers.len() == 0 {
            return Ok(kind.array(0));
        }
        let value = self.write_value(kind, |bytes| {
            bytes.extend((numbers.len() as u64 / size).to_le_bytes());
            bytes.extend(numbers.flatten());
        })?;
        Ok(ARRAY | value)
    }

    fn append(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.at += bytes.len() as u64;
        self.hash.update(bytes);
        self.out.write_all(bytes)
    }
}

/// Returns how the path after this one is found: a distance to the next sibling if the path has children.
fn jump(has_children: bool, has_sibling: bool, distance: usize) -> i32 {
    match (has_children, has_sibling) {
        (true, true) => distance as i32,
        (true, false) => -1,
        (false, true) => 0,
        (false, false) => -2,
    }
}

fn push_words(bytes: &mut Vec<u8>, words: &[u32]) {
    bytes.extend((words.len() as u64).to_le_bytes());
    bytes.extend(words.iter().flat_map(|word| word.to_le_bytes()));
}
