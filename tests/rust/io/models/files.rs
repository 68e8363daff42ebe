//! Writes files of all formats.

use std::fmt::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};
use supple::Mesh;

/// A surface with texture coordinates of its vertices.
#[derive(Clone)]
pub(super) struct Shape {
    pub(super) vertices: Vec<[f32; 3]>,
    pub(super) faces: Vec<Vec<u32>>,
}

/// A cube with three different edges: six quads.
pub(super) fn cube() -> Shape {
    let (vertices, faces) = supple_tests::plain_box([0.0, 0.1, 0.0], [1.0, 2.3, 0.7]);
    Shape { vertices: vertices.iter().map(|p| p.map(|x| x as f32)).collect(), faces }
}

pub(super) fn tetrahedron() -> Shape {
    let vertices = vec![[0.0; 3], [1.1, 0.0, 0.0], [0.0, 1.2, 0.0], [0.0, 0.0, 1e-3]];
    Shape { vertices, faces: vec![vec![0, 2, 1], vec![0, 1, 3], vec![1, 2, 3], vec![2, 0, 3]] }
}

/// The bust of the example scenes.
pub(super) fn bust() -> Shape {
    let mesh = supple_tests::bust();
    let vertices = mesh.vertices().iter().map(|p| p.cast::<f32>().into()).collect();
    Shape { vertices, faces: mesh.faces().map(<[u32]>::to_vec).collect() }
}

pub(super) fn shapes() -> [Shape; 3] {
    [cube(), tetrahedron(), bust()]
}

impl Shape {
    /// Returns the surface with the triangles that the core makes of its faces.
    pub(super) fn triangulated(&self) -> Self {
        let mesh = self.mesh();
        Self { faces: mesh.triangles().iter().map(|face| face.to_vec()).collect(), ..self.clone() }
    }

    pub(super) fn mesh(&self) -> Mesh {
        supple_io::obj::Document::from_bytes("x.obj", self.obj().into()).unwrap().mesh(None).unwrap()
    }

    /// Returns the corners of all triangles.
    pub(super) fn corners(&self) -> Vec<[f32; 3]> {
        self.faces.iter().flatten().map(|&vertex| self.vertices[vertex as usize]).collect()
    }

    /// Returns texture coordinates of the vertices, whose v is exact when it is turned over.
    pub(super) fn coordinates(&self) -> Vec<[f32; 2]> {
        (0..self.vertices.len()).map(|vertex| [vertex as f32, (vertex % 7) as f32 / 8.0]).collect()
    }

    pub(super) fn obj(&self) -> String {
        let mut text = String::new();
        for [x, y, z] in &self.vertices {
            writeln!(text, "v {x} {y} {z}").unwrap();
        }
        for face in &self.faces {
            let corners = face.iter().fold(String::new(), |text, corner| format!("{text} {}", corner + 1));
            writeln!(text, "f{corners}").unwrap();
        }
        text
    }

    /// Returns a text of several solids, each with some of the triangles.
    pub(super) fn stl_text(&self, solids: &[&str]) -> Vec<u8> {
        let mut text = String::new();
        let each = self.faces.len().div_ceil(solids.len());
        for (faces, name) in self.faces.chunks(each).zip(solids) {
            writeln!(text, "solid {name}").unwrap();
            for face in faces {
                text.push_str("facet normal 0 0 0\nouter loop\n");
                for &corner in face {
                    let [x, y, z] = self.vertices[corner as usize];
                    writeln!(text, "  vertex {x} {y} {z:e}").unwrap();
                }
                text.push_str("endloop\nendfacet\n");
            }
            writeln!(text, "endsolid {name}").unwrap();
        }
        text.into()
    }

    pub(super) fn stl_binary(&self, header: &str) -> Vec<u8> {
        let mut bytes = header.as_bytes().to_vec();
        bytes.resize(80, 0);
        bytes.extend((self.faces.len() as u32).to_le_bytes());
        for face in &self.faces {
            bytes.extend([0; 12]);
            let numbers = face.iter().flat_map(|&corner| self.vertices[corner as usize]);
            bytes.extend(numbers.flat_map(f32::to_le_bytes));
            bytes.extend([0; 2]);
        }
        bytes
    }

    /// Returns a PLY file. `encoding` is its name in the header, and `kind` the type of positions.
    pub(super) fn ply(&self, encoding: &str, kind: &str, textures: bool) -> Vec<u8> {
        let mut bytes = format!(
            "ply\nformat {encoding} 1.0\ncomment made by a test\nelement vertex {}\n",
            self.vertices.len()
        );
        for name in ["x", "y", "z"] {
            writeln!(bytes, "property {kind} {name}").unwrap();
        }
        if textures {
            bytes.push_str("property float s\nproperty float t\n");
        }
        writeln!(bytes, "property uchar red\nelement face {}", self.faces.len()).unwrap();
        bytes
            .push_str("property list uchar int vertex_indices\nelement edge 1\nproperty int a\nend_header\n");
        let mut bytes = bytes.into_bytes();
        let (is_text, is_big) = (encoding == "ascii", encoding == "binary_big_endian");
        let mut push = |number: f64, kind: &str| {
            let mut value = match kind {
                _ if is_text => format!("{number} ").into_bytes(),
                "float" => (number as f32).to_le_bytes().to_vec(),
                "double" => number.to_le_bytes().to_vec(),
                "int" => (number as i32).to_le_bytes().to_vec(),
                _ => vec![number as u8],
            };
            if is_big {
                value.reverse();
            }
            bytes.append(&mut value);
            bytes.len()
        };
        let line_end = |bytes: &mut Vec<u8>| bytes.extend(is_text.then_some(b'\n'));
        let mut ends = Vec::new();
        for (position, uv) in self.vertices.iter().zip(self.coordinates()) {
            // Numbers of 64 bits with the same digits.
            for x in position {
                push(x.to_string().parse().unwrap(), kind);
            }
            if textures {
                for x in uv {
                    push(x.into(), "float");
                }
            }
            ends.push(push(7.0, "uchar"));
        }
        for face in &self.faces {
            push(face.len() as f64, "uchar");
            ends.extend(face.iter().map(|&corner| push(corner.into(), "int")).last());
        }
        ends.push(push(1.0, "int"));
        if is_text {
            for end in ends.into_iter().rev() {
                bytes.insert(end, b'\n');
            }
        } else {
            line_end(&mut bytes);
        }
        bytes
    }

    /// Returns the parts of a glTF file with one mesh at one node.
    pub(super) fn gltf(&self, textures: bool) -> Gltf {
        let mut gltf = Gltf::default();
        let mut primitive = json!({
            "attributes": { "POSITION": gltf.floats(&self.vertices) },
            "indices": gltf.indices(&self.faces.concat()),
        });
        if textures {
            // The origin of glTF is at the upper left.
            let turned: Vec<[f32; 2]> = self.coordinates().iter().map(|&[u, v]| [u, 1.0 - v]).collect();
            primitive["attributes"]["TEXCOORD_0"] = gltf.floats(&turned);
        }
        gltf.root["meshes"] = json!([{ "primitives": [primitive] }]);
        gltf.root["nodes"] = json!([{ "mesh": 0 }]);
        gltf.root["scenes"] = json!([{ "nodes": [0] }]);
        gltf
    }
}

/// JSON and buffer of a glTF file.
#[derive(Clone)]
pub(super) struct Gltf {
    pub(super) root: Value,
    pub(super) buffer: Vec<u8>,
}

impl Default for Gltf {
    fn default() -> Self {
        let root =
            json!({ "asset": { "version": "2.0" }, "accessors": [], "bufferViews": [], "buffers": [] });
        Self { root, buffer: Vec::new() }
    }
}

impl Gltf {
    /// Appends an accessor of bytes, and returns its index.
    pub(super) fn accessor(&mut self, bytes: Vec<u8>, accessor: Value) -> Value {
        let views = self.root["bufferViews"].as_array_mut().unwrap();
        views.push(json!({ "buffer": 0, "byteOffset": self.buffer.len(), "byteLength": bytes.len() }));
        let mut accessor = accessor;
        accessor["bufferView"] = json!(views.len() - 1);
        let accessors = self.root["accessors"].as_array_mut().unwrap();
        accessors.push(accessor);
        self.buffer.extend(bytes);
        self.buffer.resize(self.buffer.len().next_multiple_of(4), 0);
        json!(accessors.len() - 1)
    }

    /// Appends an accessor of vectors or matrices, and returns its index.
    pub(super) fn floats<const N: usize>(&mut self, values: &[[f32; N]]) -> Value {
        let bytes = values.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
        let kind = if N == 16 { "MAT4".to_owned() } else { format!("VEC{N}") };
        let accessor = json!({ "componentType": 5126, "count": values.len(), "type": kind });
        let index = self.accessor(bytes, accessor);
        if N == 3 {
            let accessor = &mut self.root["accessors"][index.as_u64().unwrap() as usize];
            (accessor["min"], accessor["max"]) = (json!([0, 0, 0]), json!([1, 1, 1]));
        }
        index
    }

    /// Appends an accessor of joints, and returns its index.
    pub(super) fn joints(&mut self, values: &[[u8; 4]]) -> Value {
        self.accessor(
            values.concat(),
            json!({ "componentType": 5121, "count": values.len(), "type": "VEC4" }),
        )
    }

    /// Appends an accessor of indices, and returns its index.
    pub(super) fn indices(&mut self, values: &[u32]) -> Value {
        let bytes = values.iter().flat_map(|&index| (index as u16).to_le_bytes()).collect();
        self.accessor(bytes, json!({ "componentType": 5123, "count": values.len(), "type": "SCALAR" }))
    }

    /// Returns the file with its buffer as a binary chunk.
    pub(super) fn glb(&self) -> Vec<u8> {
        let mut root = self.root.clone();
        root["buffers"] = json!([{ "byteLength": self.buffer.len() }]);
        let mut text = root.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let length = 12 + 8 + text.len() + 8 + self.buffer.len();
        let mut bytes = b"glTF".to_vec();
        bytes.extend([2, length as u32].map(u32::to_le_bytes).concat());
        for (kind, chunk) in [(b"JSON", &text), (b"BIN\0", &self.buffer)] {
            bytes.extend((chunk.len() as u32).to_le_bytes());
            bytes.extend(kind);
            bytes.extend(chunk);
        }
        bytes
    }

    /// Returns the JSON with its buffer at an address.
    pub(super) fn json(&self, uri: &str) -> Vec<u8> {
        let mut root = self.root.clone();
        root["buffers"] = json!([{ "byteLength": self.buffer.len(), "uri": uri }]);
        root.to_string().into_bytes()
    }

    /// Returns the JSON with its buffer as base64.
    pub(super) fn embedded(&self) -> Vec<u8> {
        self.json(&format!("data:application/octet-stream;base64,{}", STANDARD.encode(&self.buffer)))
    }
}
