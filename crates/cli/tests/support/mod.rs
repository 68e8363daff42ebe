//! Helpers for the tests of the command line: write a small scene to a temporary directory, and run the
//! program there.

// Each test binary uses only a part of this module.
#![allow(dead_code, unreachable_pub)]

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use tempfile::TempDir;

/// OBJ file of a block of size 2 x 3 x 1, with pentagons, texture coordinates and a comment.
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

/// Scene of a block that is pinned at one side for 0.2 s and then falls to the ground.
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

/// A temporary directory with a scene and its mesh. It is removed on drop.
pub struct Workspace {
    directory: TempDir,
}

impl Workspace {
    /// Creates a directory with [`SCENE`].
    pub fn new() -> Self {
        Self::with_scene(SCENE)
    }

    /// Creates a directory with the text `scene` as `scene.toml`.
    pub fn with_scene(scene: &str) -> Self {
        let workspace = Self { directory: tempfile::tempdir().unwrap() };
        workspace.write("block.obj", BLOCK);
        workspace.write("scene.toml", scene);
        workspace
    }

    /// Returns the path of a file in the directory.
    pub fn path(&self, name: &str) -> PathBuf {
        self.directory.path().join(name)
    }

    /// Writes a file in the directory.
    pub fn write(&self, name: &str, text: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), text).unwrap();
    }

    /// Returns a command that runs the program in the directory.
    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(program());
        command.args(arguments).current_dir(self.directory.path());
        command
    }

    /// Runs the program in the directory.
    pub fn supple(&self, arguments: &[&str]) -> ProgramOutput {
        ProgramOutput::new(self.command(arguments).output().unwrap())
    }

    /// Returns the names and bytes of the frames and pages in a subdirectory: all files except the checkpoint, the
    /// manifest and the lock.
    pub fn frames(&self, directory: &str) -> BTreeMap<String, Vec<u8>> {
        let mut frames = files(&self.path(directory));
        frames.remove("manifest.json");
        frames.retain(|name, _| !name.starts_with("supple.") || name.starts_with("supple.html"));
        frames
    }
}

/// Returns the path of the program.
pub fn program() -> &'static str {
    env!("CARGO_BIN_EXE_supple")
}

/// Returns the names and bytes of the files in a directory; empty if the directory is missing. A run may go on at the
/// same time: the files that it renames or removes during the search are left out.
pub fn files(directory: &Path) -> BTreeMap<String, Vec<u8>> {
    let Ok(entries) = std::fs::read_dir(directory) else { return BTreeMap::new() };
    let mut files = BTreeMap::new();
    for entry in entries {
        let entry = entry.unwrap();
        if !entry.path().is_file() {
            continue;
        }
        match std::fs::read(entry.path()) {
            Ok(bytes) => drop(files.insert(entry.file_name().into_string().unwrap(), bytes)),
            Err(error) => {
                assert_eq!(error.kind(), std::io::ErrorKind::NotFound, "{}", entry.path().display())
            }
        }
    }
    files
}

/// Exit code and text output of the program.
#[derive(Debug)]
pub struct ProgramOutput {
    pub code: Option<i32>,
    pub out: String,
    pub err: String,
}

/// Returns whether a line is not the warning that the faces of [`BLOCK`] are much larger than the cells.
pub fn is_not_of_large_faces(line: &str) -> bool {
    !line.contains("the surface shows no bend between its vertices")
}

impl ProgramOutput {
    /// Returns the messages but for the warning about the faces of [`BLOCK`].
    pub fn messages(&self) -> String {
        self.err.split_inclusive('\n').filter(|line| is_not_of_large_faces(line)).collect()
    }

    pub fn new(output: Output) -> Self {
        Self {
            code: output.status.code(),
            out: String::from_utf8(output.stdout).unwrap(),
            err: String::from_utf8(output.stderr).unwrap(),
        }
    }

    /// Checks the exit code, and that standard error contains all `words`.
    #[track_caller]
    pub fn expect(&self, code: i32, words: &[&str]) {
        assert_eq!(self.code, Some(code), "{self:?}");
        for word in words {
            assert!(self.err.contains(word), "{word:?} is not in {:?}", self.err);
        }
    }
}
