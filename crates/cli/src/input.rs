//! From an input to a scene: a scene file, or a model alone.

use std::path::Path;

use supple_io::scene::{Scene, SceneError};

use crate::args::SceneArgs;

/// Reads the scene that an input means.
pub(crate) fn scene(input: &Path, args: &SceneArgs) -> Result<Scene, SceneError> {
    Scene::open(input, args.up.into(), &args.overrides)
}

/// The name of an input in tables and folders.
pub(crate) fn stem(input: &Path) -> String {
    input.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}
