//! Names of bodies, which name the files of their frames.

use std::path::Path;

/// Largest number of bytes in the name of a body. File systems allow 255 bytes in the name of a file, which
/// also contains the number of the frame and extensions.
const MAX_NAME: usize = 200;

/// Returns whether `name` is a valid name of a body.
pub(super) fn is_name(name: &str) -> bool {
    // A leading `.` would make the frames hidden files.
    (1..=MAX_NAME).contains(&name.len()) && !name.starts_with('.') && name.chars().all(is_name_character)
}

/// Returns whether a character is a letter or digit of any language, or `-`, `_` or `.`.
fn is_name_character(character: char) -> bool {
    // Combining marks are parts of letters. Characters that continue an identifier (Unicode, annex 31) are
    // letters, their marks, digits and connectors like `_`.
    matches!(character, '-' | '.') || unicode_ident::is_xid_continue(character)
}

/// Returns the default name of a body: the file name of its mesh without the extension, with `_` in place of
/// invalid characters, cut to the largest length.
pub(super) fn name_from(mesh: &Path) -> String {
    let stem = mesh.file_stem().unwrap_or_default().to_string_lossy();
    let mut name = String::new();
    for (at, character) in stem.char_indices() {
        let is_valid = is_name_character(character) && (at, character) != (0, '.');
        let character = if is_valid { character } else { '_' };
        if name.len() + character.len_utf8() > MAX_NAME {
            break;
        }
        name.push(character);
    }
    if name.is_empty() { "body".to_owned() } else { name }
}
