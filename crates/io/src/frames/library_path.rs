//! Rewrites the paths of material libraries (`mtllib`) so that they are correct relative to the directory of
//! the frames.

use std::ffi::OsString;
use std::fs;
use std::path::{Component, Path, PathBuf};

use crate::obj::Library;

/// Returns the bytes that replace the path of `library` in a frame. The input file is in the directory
/// `input`, and the frames are in the directory `output`. Returns `None` if the path stays correct: it is
/// absolute, or relative to `output` it leads to the same file.
pub(super) fn rewritten(library: &Library, input: &Path, output: &Path) -> Option<Vec<u8>> {
    if Path::new(&library.name).is_absolute() || has_drive(&library.name) {
        return None;
    }
    let target = resolve(&library.path);
    let from_output = output.join(library.path.strip_prefix(input).unwrap_or(&library.path));
    if resolve(&from_output) == target {
        return None;
    }
    Some(bytes(&relative(&target, &resolve_directory(output))))
}

/// Returns whether `name` starts with a drive (`C:\...`). `Path` recognizes drives on Windows only.
fn has_drive(name: &str) -> bool {
    matches!(name.as_bytes(), [letter, b':', ..] if letter.is_ascii_alphabetic())
}

/// Returns the absolute path of a file that may be missing. Links in its directory are resolved; if the file
/// itself is a link, the link is kept.
fn resolve(path: &Path) -> PathBuf {
    match (path.parent(), path.file_name()) {
        (Some(parent), Some(name)) => resolve_directory(parent).join(name),
        _ => resolve_directory(path),
    }
}

/// Returns the absolute path of a directory that may be missing. Links are resolved in the existing
/// ancestors.
fn resolve_directory(path: &Path) -> PathBuf {
    let path = if path.as_os_str().is_empty() { Path::new(".") } else { path };
    if let Ok(resolved) = fs::canonicalize(path) {
        return resolved;
    }
    match (path.parent(), path.components().next_back()) {
        (Some(parent), Some(Component::Normal(name))) => resolve_directory(parent).join(name),
        (Some(parent), Some(Component::ParentDir)) => {
            let resolved = resolve_directory(parent);
            resolved.parent().map_or_else(|| resolved.clone(), Path::to_owned)
        }
        (Some(parent), _) => resolve_directory(parent),
        (None, _) => path.to_owned(),
    }
}

/// Returns the relative path from the absolute directory `base` to the absolute path `target`, with `/`
/// between names. Returns `target` itself if the two paths have different roots (Windows drives).
fn relative(target: &Path, base: &Path) -> OsString {
    let common = target.components().zip(base.components()).take_while(|(a, b)| a == b).count();
    if common == 0 {
        return target.as_os_str().to_owned();
    }
    let up = base.components().skip(common).map(|_| Path::new("..").as_os_str());
    let down = target.components().skip(common).map(Component::as_os_str);
    let mut path = OsString::new();
    for (index, name) in up.chain(down).enumerate() {
        if index > 0 {
            path.push("/");
        }
        path.push(name);
    }
    path
}

/// Returns the bytes of a path in a text file: the same bytes on Unix, UTF-8 elsewhere.
fn bytes(path: &OsString) -> Vec<u8> {
    #[cfg(unix)]
    {
        use std::os::unix::ffi::OsStrExt;
        path.as_bytes().to_vec()
    }
    #[cfg(not(unix))]
    {
        path.to_string_lossy().into_owned().into_bytes()
    }
}
