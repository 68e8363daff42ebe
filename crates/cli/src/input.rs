//! From an input to a scene: a scene file, or a model alone.

use std::path::Path;

use supple::run::RunError;
use supple::scene::Scene;

use crate::args::SceneArgs;

/// Reads the scene that an input means.
pub(crate) fn scene(input: &Path, args: &SceneArgs) -> Result<Scene, RunError> {
    let extension = input.extension().and_then(|extension| extension.to_str()).unwrap_or_default();
    match extension.to_ascii_lowercase().as_str() {
        "toml" => Ok(Scene::read_with(input, &args.overrides)?),
        "obj" => Scene::from_model(input, args.up.into(), &args.overrides),
        _ => Err(RunError::Input { path: input.to_owned() }),
    }
}

/// The name of an input in tables and folders.
pub(crate) fn stem(input: &Path) -> String {
    input.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}
