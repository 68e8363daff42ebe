//! A small scene for unit tests: a closed block hangs by its side and swings.

use std::fs;

use supple::scene::Scene;
use tempfile::TempDir;

use crate::physical::Physical;

/// A block of 2 x 3 x 1.
const BLOCK: &str = "\
v -1 0 -0.5\nv 1 0 -0.5\nv 1 3 -0.5\nv -1 3 -0.5\nv -1 0 0.5\nv 1 0 0.5\nv 1 3 0.5\nv -1 3 0.5
f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

/// The scene, with blocks of these half-widths, in a folder that goes with the first of what is returned.
pub(crate) fn physical(frames: u32, half_widths: &[usize]) -> (TempDir, Physical) {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("block.obj"), BLOCK).unwrap();
    let mut text = format!("[simulation]\nframes = {frames}\nfps = 30\nsubsteps = 2\n");
    for (index, half_width) in half_widths.iter().enumerate() {
        text += &format!(
            "[[body]]\nname = \"block{index}\"\nmesh = \"block.obj\"\nlattice_vertices = 100\n\
             half_width = {half_width}\n\
             [[body.pin]]\nbox = {{ min = [-9, -9, -9], max = [-0.7, 9, 9] }}\n"
        );
    }
    let scene = Scene::parse(&text, "scene.toml", folder.path(), &[]).unwrap();
    let physical = Physical::new(scene).unwrap();
    (folder, physical)
}
