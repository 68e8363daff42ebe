//! The contents of a stage: prims with metadata and properties, and their values.

use super::name::Names;

/// A prim.
#[derive(Debug)]
pub(super) struct Prim {
    pub(super) name: String,
    /// Metadata: names and values.
    pub(super) metadata: Vec<(&'static str, Value)>,
    pub(super) properties: Vec<Property>,
    pub(super) children: Vec<Prim>,
}

/// A property: an attribute or a relationship.
#[derive(Debug)]
pub(super) struct Property {
    pub(super) name: String,
    pub(super) is_relationship: bool,
    pub(super) metadata: Vec<(&'static str, Value)>,
}

/// A value.
#[derive(Clone, Debug)]
pub(super) enum Value {
    Bool(bool),
    Float(f32),
    Double(f64),
    Token(String),
    Tokens(Vec<String>),
    /// A text.
    String(String),
    /// A path of a file.
    Asset(String),
    /// A color, or another vector.
    Vector([f32; 3]),
    /// A matrix that transforms row vectors, by rows.
    Matrix([[f64; 4]; 4]),
    Integers(Vec<i32>),
    Vectors2(Vec<[f32; 2]>),
    Vectors3(Vec<[f32; 3]>),
    /// Names of children.
    Names(Vec<String>),
    /// Names that are put before those of weaker layers.
    Prepended(Vec<String>),
    /// Paths of the targets of a relationship, or of the sources of a connection.
    Paths(Vec<String>),
    /// The specifier `def`.
    Def,
    /// The variability `uniform`.
    Uniform,
    /// The value of the first frame, which is stored in the frames.
    FirstFrame(Stored),
    /// The values of all frames, which are stored in the frames.
    Samples(Stored),
    /// The field value of a value that is in the file already.
    Written(u64),
    /// Some values, and for each frame the index of its value.
    PerFrame {
        values: Vec<Value>,
        of_frame: Vec<usize>,
    },
}

/// Place of a value in each frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stored {
    pub(super) kind: StoredKind,
    /// Offset from the beginning of a frame, in bytes.
    pub(super) at: u64,
}

/// Type of a value that is stored in the frames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum StoredKind {
    /// An array of vectors of three `f32`.
    Vectors3,
    /// A matrix of `f64`.
    Matrix,
}

impl Prim {
    /// Creates a prim that is defined here. `names` are those of its siblings; the name is changed if it is no
    /// identifier, or if a sibling has it. If it is changed, the prim is displayed with the name as given.
    pub(super) fn new(type_name: &str, name: &str, names: &mut Names) -> Self {
        let identifier = names.unique(name);
        let mut metadata = vec![("specifier", Value::Def), ("typeName", Value::Token(type_name.to_owned()))];
        if identifier != name {
            metadata.push(("displayName", Value::String(name.to_owned())));
        }
        Self { name: identifier, metadata, properties: Vec::new(), children: Vec::new() }
    }

    /// Adds metadata.
    pub(super) fn with(mut self, name: &'static str, value: Value) -> Self {
        self.metadata.push((name, value));
        self
    }

    /// Adds an attribute with a value that is the same in all frames and layers.
    pub(super) fn uniform(self, type_name: &str, name: &str, value: Value) -> Self {
        self.property(Property::attribute(type_name, name, value).with("variability", Value::Uniform))
    }

    /// Adds an attribute with a value that is the same in all frames.
    pub(super) fn constant(self, type_name: &str, name: &str, value: Value) -> Self {
        self.property(Property::attribute(type_name, name, value))
    }

    /// Adds an attribute whose values are stored in the frames. Its value without a time is that of the first frame.
    pub(super) fn animated(self, type_name: &str, name: &str, stored: Stored) -> Self {
        self.property(Property::animated(type_name, name, stored))
    }

    /// Adds a property.
    pub(super) fn property(mut self, property: Property) -> Self {
        self.properties.push(property);
        self
    }

    /// Binds a material.
    pub(super) fn bound(self, material: &str) -> Self {
        let binding = Property {
            name: "material:binding".to_owned(),
            is_relationship: true,
            metadata: vec![
                ("variability", Value::Uniform),
                ("targetPaths", Value::Paths(vec![material.to_owned()])),
            ],
        };
        self.with("apiSchemas", Value::Prepended(vec!["MaterialBindingAPI".to_owned()])).property(binding)
    }
}

impl Property {
    /// An attribute with a value.
    pub(super) fn attribute(type_name: &str, name: &str, value: Value) -> Self {
        Self::declared(type_name, name).with("default", value)
    }

    /// An attribute whose values are stored in the frames.
    pub(super) fn animated(type_name: &str, name: &str, stored: Stored) -> Self {
        Self::declared(type_name, name)
            .with("default", Value::FirstFrame(stored))
            .with("timeSamples", Value::Samples(stored))
    }

    /// An attribute with some values, and for each frame the index of its value. Its value without a time is that of the
    /// first frame.
    pub(super) fn chosen(type_name: &str, name: &str, values: Vec<Value>, of_frame: &[usize]) -> Self {
        let first = values[of_frame.first().copied().unwrap_or(0)].clone();
        let samples = Value::PerFrame { values, of_frame: of_frame.to_vec() };
        Self::declared(type_name, name).with("default", first).with("timeSamples", samples)
    }

    /// An attribute without a value.
    pub(super) fn declared(type_name: &str, name: &str) -> Self {
        let metadata = vec![("typeName", Value::Token(type_name.to_owned()))];
        Self { name: name.to_owned(), is_relationship: false, metadata }
    }

    /// Adds metadata.
    pub(super) fn with(mut self, name: &'static str, value: Value) -> Self {
        self.metadata.push((name, value));
        self
    }
}

/// Returns the prim of some faces without their indices.
pub(super) fn subset_prim(name: &str, family: &str, names: &mut Names) -> Prim {
    Prim::new("GeomSubset", name, names).uniform("token", "elementType", token("face")).uniform(
        "token",
        "familyName",
        token(family),
    )
}

/// Returns the value of a token.
pub(super) fn token(text: &str) -> Value {
    Value::Token(text.to_owned())
}

pub(super) fn face_varying() -> Value {
    token("faceVarying")
}

pub(super) fn integers(indices: &[u32]) -> Value {
    Value::Integers(indices.iter().map(|&index| index as i32).collect())
}
