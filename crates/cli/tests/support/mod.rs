//! Shared by the tests of the command line: a small scene on disk, and a way to run the program on it.

// Each test binary uses only a part of this module.
#![allow(dead_code, unreachable_pub)]

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use tempfile::TempDir;

/// A block of 2 x 3 x 1 with a pentagon, texture coordinates and a comment.
pub const BLOCK: &str = "\
# block
o Block
v -1 0 -0.5
v 1 0 -0.5
v 1 3 -0.5
v 0 3 -0.5
v -1 3 -0.5
v -1 0 0.5
v 1 0 0.5
v 1 3 0.5
v 0 3 0.5
v -1 3 0.5
vt 0 0
vt 1 0
vt 1 1
f 5/1 4/1 3/1 2/2 1/3
f 6 7 8 9 10
f 1 2 7 6
f 2 3 8 7
f 3 4 9 8
f 4 5 10 9
f 5 1 6 10
";

/// A block that is pinned at one side for 0.2 s and then falls on the ground.
pub const SCENE: &str = r#"
[simulation]
frames = 20
fps = 30
substeps = 2

[output]
directory = "out"

[[body]]
name = "block"
mesh = "block.obj"
translate = [0, 1, 0]
lattice_vertices = 200
half_width = 1
region_damping = 0.1

[[body.pin]]
box = { min = [-2, 0, -1], max = [-0.9, 5, 1] }
end = 0.2

[[collider]]
plane = { point = [0, 0, 0], normal = [0, 1, 0] }
"#;

/// A temporary folder with the scene and its mesh; removed when dropped.
pub struct Stage {
    folder: TempDir,
}

impl Stage {
    pub fn new() -> Self {
        Self::of(SCENE)
    }

    pub fn of(scene: &str) -> Self {
        let stage = Self { folder: tempfile::tempdir().unwrap() };
        stage.write("block.obj", BLOCK);
        stage.write("scene.toml", scene);
        stage
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn write(&self, name: &str, text: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), text).unwrap();
    }

    /// Returns a command that runs the program in the folder.
    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(program());
        command.args(arguments).current_dir(self.folder.path());
        command
    }

    /// Runs the program in the folder.
    pub fn supple(&self, arguments: &[&str]) -> Ended {
        Ended::of(self.command(arguments).output().unwrap())
    }

    /// Returns the frame files of a folder and their bytes.
    pub fn frames(&self, folder: &str) -> BTreeMap<String, Vec<u8>> {
        let mut frames = files(&self.path(folder));
        frames.retain(|name, _| !name.starts_with("supple."));
        frames
    }
}

pub fn program() -> &'static str {
    env!("CARGO_BIN_EXE_supple")
}

/// Returns the files of a folder and their bytes.
pub fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let Ok(entries) = std::fs::read_dir(folder) else { return BTreeMap::new() };
    entries
        .map(|entry| entry.unwrap())
        .filter(|entry| entry.path().is_file())
        .map(|entry| (entry.file_name().into_string().unwrap(), std::fs::read(entry.path()).unwrap()))
        .collect()
}

/// Exit code and output of the program.
#[derive(Debug)]
pub struct Ended {
    pub code: Option<i32>,
    pub out: String,
    pub err: String,
}

impl Ended {
    pub fn of(output: Output) -> Self {
        Self {
            code: output.status.code(),
            out: String::from_utf8(output.stdout).unwrap(),
            err: String::from_utf8(output.stderr).unwrap(),
        }
    }

    /// Checks the exit code and that standard error contains all `words`.
    #[track_caller]
    pub fn expect(&self, code: i32, words: &[&str]) {
        assert_eq!(self.code, Some(code), "{self:?}");
        for word in words {
            assert!(self.err.contains(word), "{word:?} is not in {:?}", self.err);
        }
    }
}
