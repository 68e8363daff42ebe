//! Files of the repository.

use std::path::{Path, PathBuf};

use supple::Mesh;

/// Returns the top directory of the repository.
#[must_use]
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Returns the path of a file in `examples/scenes`.
#[must_use]
pub fn example(name: &str) -> PathBuf {
    root().join("examples/scenes").join(name)
}

/// Returns the path of a file in `tests/data`.
#[must_use]
pub fn data(name: &str) -> PathBuf {
    root().join("tests/data").join(name)
}

/// Returns the bust that the example scenes use.
///
/// # Panics
///
/// Panics if it cannot be read.
#[must_use]
pub fn bust() -> Mesh {
    supple_io::obj::read(example("bust.obj")).expect("the bust")
}
