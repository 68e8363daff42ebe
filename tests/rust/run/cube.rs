//! Scenes with a cube of edge 1.

use std::path::Path;

use supple_io::scene::Scene;

pub(crate) const CUBE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
                    f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

/// Writes the cube to the file `cube.obj` of a folder, and returns the scene with a text and overrides.
pub(crate) fn scene(text: &str, folder: &Path, overrides: &[&str]) -> Scene {
    std::fs::write(folder.join("cube.obj"), CUBE).unwrap();
    let overrides: Vec<String> = overrides.iter().map(ToString::to_string).collect();
    Scene::parse(text, "scene.toml", folder, &overrides).unwrap()
}
