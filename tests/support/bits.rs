//! Hashes of the results of scenes, which are the same on every machine.

use std::path::{Path, PathBuf};

use supple::{Display, Simulation};
use supple_io::run::prepare;
use supple_io::scene::Scene;

/// The table of hashes, below the top directory of the project.
pub const BITS_TABLE: &str = "tests/bits/hashes.txt";

/// Number of frames of a scene that count.
const FRAMES: u64 = 24;

/// Returns the rows of the table: the name of each scene and its hash.
///
/// # Panics
///
/// Panics if it cannot be read.
#[must_use]
pub fn recorded_hashes(root: &Path) -> Vec<(String, String)> {
    let text = std::fs::read_to_string(root.join(BITS_TABLE)).expect(BITS_TABLE);
    let row = |line: &str| line.split_once(' ').map(|(scene, hash)| (scene.to_owned(), hash.to_owned()));
    text.lines().map(|line| row(line).unwrap_or_else(|| panic!("{BITS_TABLE}: {line:?}"))).collect()
}

/// Returns the names of the scenes below the top directory of the project, and the hash of the results of each: see
/// [`hash_of`]. Their order is that of the names.
///
/// # Panics
///
/// Panics if a scene cannot be read or built.
#[must_use]
pub fn hashes_of_scenes(root: &Path) -> Vec<(String, String)> {
    let folders = ["examples/scenes", "tests/bits"].map(|folder| root.join(folder));
    let files = folders.iter().flat_map(|folder| {
        let entries =
            std::fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
        entries.map(|entry| entry.unwrap().path())
    });
    let mut scenes: Vec<PathBuf> =
        files.filter(|path| path.extension().is_some_and(|end| end == "toml")).collect();
    scenes.sort_by_key(|path| path.file_name().map(ToOwned::to_owned));
    let name = |path: &Path| path.file_stem().unwrap().to_string_lossy().into_owned();
    scenes.iter().map(|path| (name(path), format!("{:016x}", hash_of(path)))).collect()
}

/// Returns the hash of all surfaces and lattice positions of a scene, after each of its first frames.
fn hash_of(scene: &Path) -> u64 {
    let scene = Scene::read(scene).unwrap_or_else(|error| panic!("{error}"));
    let mut simulation = prepare(&scene).unwrap_or_else(|error| panic!("{error}")).simulation;
    let mut hash = Fnv::default();
    for _ in 0..FRAMES {
        simulation.advance(1);
        add(&simulation, &mut hash);
    }
    hash.0
}

/// Adds the surfaces and the lattice positions of all bodies.
fn add(simulation: &Simulation, hash: &mut Fnv) {
    let mut display = Display::new();
    for body in simulation.bodies() {
        let surface = display.evaluate(body).surface();
        surface.positions.iter().for_each(|point| hash.add(point.coords.as_slice()));
        body.positions().iter().for_each(|point| hash.add(point.coords.as_slice()));
    }
}

/// The hash FNV-1a (Fowler, Noll & Vo 1991) of numbers, each taken as one word.
struct Fnv(u64);

impl Default for Fnv {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }
}

impl Fnv {
    fn add(&mut self, numbers: &[f64]) {
        for number in numbers {
            self.0 = (self.0 ^ number.to_bits()).wrapping_mul(0x0100_0000_01b3);
        }
    }
}
