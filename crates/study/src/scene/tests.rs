//! Provides a small scene for unit tests: a closed block swings from a pin at its side.

use std::fs;

use supple::reference::Regions;
use supple_io::scene::Scene;
use tempfile::TempDir;

use super::physical::Physical;
use super::setting::{Dynamics, Sums};

/// OBJ text of a block of 2 x 3 x 1 scene units.
const BLOCK: &str = include_str!("../../tests/block.obj");

/// Parameters of the unchanged scene, with the sums of the library.
pub(super) const FAST: Dynamics =
    Dynamics { refinement: 1.0, region_factor: 1.0, half_width: None, substeps: 2, sums: Sums::Fast };
/// Parameters of the unchanged scene, with naive sums over staircase regions.
pub(super) const NAIVE: Dynamics = Dynamics { sums: Sums::Naive(Regions::Staircase), ..FAST };

/// Creates a scene with one block for each half-width. Also returns the temporary directory of its mesh,
/// which must be kept.
pub(super) fn physical(frames: u32, half_widths: &[usize]) -> (TempDir, Physical) {
    let half_widths: Vec<String> = half_widths.iter().map(|w| format!("half_width = {w}")).collect();
    let keys: Vec<&str> = half_widths.iter().map(String::as_str).collect();
    physical_with("substeps = 2", frames, &keys)
}

/// Creates a scene with one block for each string, the keys of its material. `simulation` has keys of the simulation.
/// Also returns the temporary directory of its mesh, which must be kept.
pub(super) fn physical_with(simulation: &str, frames: u32, materials: &[&str]) -> (TempDir, Physical) {
    let directory = tempfile::tempdir().unwrap();
    fs::write(directory.path().join("block.obj"), BLOCK).unwrap();
    let mut text = format!("[simulation]\nframes = {frames}\nfps = 30\n{simulation}\n");
    for (index, material) in materials.iter().enumerate() {
        text += &format!(
            "[[body]]\nname = \"block{index}\"\nmesh = \"block.obj\"\nlattice_vertices = 100\n{material}\n\
             [[body.pin]]\nbox = {{ min = [-9, -9, -9], max = [-0.7, 9, 9] }}\n"
        );
    }
    let scene = Scene::parse(&text, "scene.toml", directory.path(), &[]).unwrap();
    let physical = Physical::new(scene).unwrap();
    (directory, physical)
}
