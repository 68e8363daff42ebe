//! Places of the arrays of a file in its binary chunk.

use std::collections::BTreeMap;

use serde_json::{Value, json};

/// Usage of an array, for graphics memory.
#[derive(Clone, Copy)]
pub(super) enum Usage {
    /// Attributes of vertices.
    Vertices = 34962,
    /// Corners of triangles.
    Corners = 34963,
    /// Other numbers.
    Other = 0,
}

/// Type of the elements of an array, by its name in glTF.
#[derive(Clone, Copy)]
pub(super) enum Element {
    /// `u32`.
    Index,
    /// One `f32`.
    Scalar,
    /// Several `f32`.
    Vector(u64),
}

impl Element {
    fn bytes(self) -> u64 {
        match self {
            Self::Index | Self::Scalar => 4,
            Self::Vector(numbers) => 4 * numbers,
        }
    }

    fn json(self, count: u64, view: usize) -> Value {
        let (component, name) = match self {
            Self::Index => (5125, "SCALAR".to_owned()),
            Self::Scalar => (5126, "SCALAR".to_owned()),
            Self::Vector(numbers) => (5126, format!("VEC{numbers}")),
        };
        json!({ "bufferView": view, "componentType": component, "count": count, "type": name })
    }
}

/// An array of the file.
#[derive(Clone, Copy, Debug)]
pub(super) struct Array {
    /// Its index among the accessors.
    pub(super) accessor: usize,
    /// Its offset in the binary chunk, in bytes.
    pub(super) at: u64,
}

/// The arrays of a file, one after another.
#[derive(Default)]
pub(super) struct Layout {
    views: Vec<Value>,
    accessors: Vec<Value>,
    /// The smallest and the largest numbers of arrays that state them, by the accessor.
    bounds: BTreeMap<usize, Bounds>,
    bytes: u64,
}

/// The smallest and the largest numbers of an array, per component.
#[derive(Clone, Debug)]
pub(super) struct Bounds {
    low: Vec<f32>,
    high: Vec<f32>,
}

impl Layout {
    /// Adds an array.
    pub(super) fn add(&mut self, element: Element, count: u64, usage: Usage) -> Array {
        let (view, at) = self.add_bytes(count * element.bytes(), usage);
        self.accessors.push(element.json(count, view));
        Array { accessor: self.accessors.len() - 1, at }
    }

    /// Adds an array that states its bounds.
    pub(super) fn add_bounded(&mut self, element: Element, count: u64, usage: Usage) -> Array {
        let array = self.add(element, count, usage);
        let numbers = element.bytes() as usize / 4;
        let bounds = Bounds { low: vec![f32::INFINITY; numbers], high: vec![f32::NEG_INFINITY; numbers] };
        self.bounds.insert(array.accessor, bounds);
        array
    }

    /// Adds bytes. Returns the index of their view and their offset.
    pub(super) fn add_bytes(&mut self, bytes: u64, usage: Usage) -> (usize, u64) {
        let at = self.bytes;
        let mut view = json!({ "buffer": 0, "byteOffset": at, "byteLength": bytes });
        if !matches!(usage, Usage::Other) {
            view["target"] = json!(usage as u32);
        }
        self.views.push(view);
        self.bytes += bytes.next_multiple_of(4);
        (self.views.len() - 1, at)
    }

    /// Includes numbers of an array, whole elements, in its bounds.
    pub(super) fn include(&mut self, array: Array, numbers: &[f32]) {
        if let Some(Bounds { low, high }) = self.bounds.get_mut(&array.accessor) {
            for element in numbers.chunks_exact(low.len()) {
                for (axis, &number) in element.iter().enumerate() {
                    low[axis] = low[axis].min(number);
                    high[axis] = high[axis].max(number);
                }
            }
        }
    }

    /// Returns the size of the binary chunk, in bytes.
    pub(super) fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Adds the buffer, its views and the arrays to the JSON of a file.
    pub(super) fn add_to(&self, root: &mut Value) {
        let mut accessors = self.accessors.clone();
        for (&accessor, Bounds { low, high }) in &self.bounds {
            // Before the numbers are known, the text of the longest ones.
            let known =
                |number: f32| if number.is_finite() { number.into() } else { -1.234_567_890_123_456_7e-300 };
            let known = |numbers: &[f32]| numbers.iter().map(|&number| known(number)).collect::<Vec<f64>>();
            accessors[accessor]["min"] = json!(known(low));
            accessors[accessor]["max"] = json!(known(high));
        }
        root["buffers"] = json!([{ "byteLength": self.bytes }]);
        root["bufferViews"] = json!(self.views);
        root["accessors"] = json!(accessors);
    }
}
