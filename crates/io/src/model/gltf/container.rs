//! Parses the JSON of a file, and checks it.

use ::gltf::json::mesh::Semantic;
use ::gltf::json::validation::{Checked, Error, Validate};
use ::gltf::json::{Path, Root, deserialize};
use ::gltf::{Document, Glb};

use super::super::error::Fault;
use super::super::surface::excerpt;

/// First bytes of a GLB file.
const MAGIC: &[u8] = b"glTF";
/// Bytes of the header of a GLB file: the first bytes, the version and the length.
const HEADER: usize = 12;

/// Largest number of objects in the JSON of a file. An object of two bytes, `{}`, takes some hundred bytes of memory.
const MAX_OBJECTS: usize = 1_000_000;

/// Extensions that compress or quantize meshes, and the command that undoes it.
const COMPRESSIONS: [(&str, &str); 4] = [
    ("KHR_draco_mesh_compression", "gltf-transform copy IN OUT"),
    ("EXT_meshopt_compression", "gltf-transform copy IN OUT"),
    ("KHR_meshopt_compression", "gltf-transform copy IN OUT"),
    ("KHR_mesh_quantization", "gltf-transform dequantize IN OUT"),
];

/// Beginnings of the names of extensions that change only the appearance.
const APPEARANCE: [&str; 8] = [
    "KHR_materials_",
    "KHR_texture_",
    "EXT_texture_",
    "MSFT_texture_",
    "KHR_lights_",
    "EXT_lights_",
    "KHR_animation_",
    "KHR_xmp",
];

/// Returns whether bytes are those of a GLB file, or JSON with the key `asset`.
pub(super) fn is(bytes: &[u8]) -> bool {
    let text = without_mark(bytes).trim_ascii_start();
    bytes.starts_with(MAGIC) || text.starts_with(b"{") && text.windows(7).any(|part| part == b"\"asset\"")
}

/// Returns the bytes without the byte-order mark.
fn without_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)
}

/// Returns the checked contents of a file, and the binary chunk of a GLB file.
pub(super) fn parse(bytes: &[u8]) -> Result<(Document, Option<Vec<u8>>), Fault> {
    let glb;
    let (text, chunk) = if bytes.starts_with(MAGIC) {
        check_header(bytes)?;
        glb = Glb::from_slice(bytes)
            .map_err(|error| Fault(format!("the GLB file is invalid: {error}; export or copy it again")))?;
        (&*glb.json, glb.bin.as_ref().map(|bin| bin.to_vec()))
    } else {
        (without_mark(bytes), None)
    };
    let objects = text.iter().filter(|&&byte| byte == b'{').count();
    if objects > MAX_OBJECTS {
        return Err(Fault(format!(
            "its JSON has {objects} objects, such as nodes and accessors; at most {MAX_OBJECTS} are read; join its meshes"
        )));
    }
    let root: Root = deserialize::from_slice(text).map_err(|error| {
        Fault(format!(
            "the JSON of the glTF file is invalid: {}; export it again",
            excerpt(&error.to_string())
        ))
    })?;
    check(&root)?;
    Ok((Document::from_json_without_validation(root), chunk))
}

/// Checks the version and the length of a GLB file.
fn check_header(bytes: &[u8]) -> Result<(), Fault> {
    let number = |at: usize| Some(u32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?));
    let (version, length) = (number(4).unwrap_or(0), number(8).unwrap_or(0) as usize);
    if version != 2 {
        return Err(Fault(format!("has version {version} of GLB; export it as glTF 2.0")));
    }
    if !(HEADER..=bytes.len()).contains(&length) {
        return Err(Fault(format!(
            "the header of the GLB file tells {length} bytes, and it has {}; export or copy it again",
            bytes.len()
        )));
    }
    Ok(())
}

/// Checks the extensions, and all indices and values.
fn check(root: &Root) -> Result<(), Fault> {
    for name in &root.extensions_required {
        if let Some((name, command)) = COMPRESSIONS.iter().find(|(known, _)| known == name) {
            return Err(Fault(format!(
                "is compressed or quantized with {name}, which is not read; export it without compression, or run: {command}"
            )));
        }
        if !APPEARANCE.iter().any(|start| name.starts_with(start)) {
            let name = excerpt(name);
            return Err(Fault(format!("needs the extension {name}, which is not read; export it without")));
        }
    }
    let accessors = root.accessors.len();
    for (mesh, of_mesh) in root.meshes.iter().enumerate() {
        for (primitive, of_primitive) in of_mesh.primitives.iter().enumerate() {
            let positions = of_primitive.attributes.get(&Checked::Valid(Semantic::Positions));
            match positions.map(|index| index.value()) {
                Some(index) if index < accessors => {}
                Some(index) => {
                    return Err(Fault(format!(
                        "mesh {mesh}, primitive {primitive}: POSITION is accessor {index} of {accessors}, counted from 0; \
                         export it again"
                    )));
                }
                None => {
                    return Err(Fault(format!(
                        "mesh {mesh}, primitive {primitive} has no POSITION; export it again"
                    )));
                }
            }
        }
    }
    let mut fault = None;
    root.validate(root, Path::new, &mut |path, error| {
        // Extensions are checked above, and the bounds of positions are not used.
        let path = path().0;
        let is_bound = path.ends_with("[\"POSITION\"].min") || path.ends_with("[\"POSITION\"].max");
        if fault.is_none() && error != Error::Unsupported && !is_bound {
            let error = error.to_string().to_lowercase();
            fault = Some(Fault(format!("`{}`: {error}; export it again", excerpt(&path))));
        }
    });
    fault.map_or(Ok(()), Err)
}
