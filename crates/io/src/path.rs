//! Absolute paths, and paths relative to a directory, of files that may be missing.

use std::ffi::OsString;
use std::fs;
use std::path::{Component, Path, PathBuf};

/// Returns the absolute path of a file that may be missing. Links in its directory are resolved; if the file
/// itself is a link, the link is kept.
pub(crate) fn resolve(path: &Path) -> PathBuf {
    match (path.parent(), path.file_name()) {
        (Some(parent), Some(name)) => resolve_directory(parent).join(name),
        _ => resolve_directory(path),
    }
}

/// Returns the absolute path of a directory that may be missing. Links are resolved in the existing
/// ancestors.
pub(crate) fn resolve_directory(path: &Path) -> PathBuf {
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
pub(crate) fn relative(target: &Path, base: &Path) -> OsString {
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
