//! Hashes of the results of scenes, which are the same on every machine.

use std::path::{Path, PathBuf};

use supple::{Display, Simulation};
use supple_io::run::prepare;
use supple_io::scene::Scene;
use xxhash_rust::xxh3::Xxh3;

/// The table of hashes, below the top directory of the project.
pub const BITS_TABLE: &str = "tests/bits/hashes.txt";

/// Number of frames of each scene that are hashed. The bust of `wedge.toml` has broken by then.
const FRAMES: u64 = 16;

/// Returns the names of the scenes below the top directory of the project, and the hash of the results of each: all
/// surfaces and lattice positions after each of its first frames. Their order is that of the names.
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

/// Returns what differs between hashes and those of the table: one line for each scene with other bits, or that only one of
/// them has.
///
/// # Panics
///
/// Panics if the table cannot be read.
#[must_use]
pub fn differences(root: &Path, found: &[(String, String)]) -> Vec<String> {
    let table = std::fs::read_to_string(root.join(BITS_TABLE)).expect(BITS_TABLE);
    let found: Vec<String> = found.iter().map(|(scene, hash)| format!("{scene} {hash}")).collect();
    let new = found.iter().filter(|row| !table.lines().any(|line| line == *row));
    let lost = table.lines().filter(|line| !found.iter().any(|row| row == line));
    new.map(|row| format!("found {row}")).chain(lost.map(|row| format!("recorded {row}"))).collect()
}

/// Returns the hash of all surfaces and lattice positions of a scene, after each of its first frames.
fn hash_of(scene: &Path) -> u64 {
    let scene = Scene::read(scene).unwrap_or_else(|error| panic!("{error}"));
    let mut simulation = prepare(&scene).unwrap_or_else(|error| panic!("{error}")).simulation;
    let mut hash = Xxh3::new();
    for _ in 0..FRAMES {
        simulation.advance(1);
        add(&simulation, &mut hash);
    }
    hash.digest()
}

/// Adds the surfaces and the lattice positions of all bodies.
fn add(simulation: &Simulation, hash: &mut Xxh3) {
    let mut display = Display::new();
    for body in simulation.bodies() {
        let surface = display.evaluate(body).surface();
        let positions = body.positions();
        let numbers = surface.positions.iter().chain(&positions).flat_map(|point| point.coords.as_slice());
        numbers.for_each(|number| hash.update(&number.to_le_bytes()));
    }
}
