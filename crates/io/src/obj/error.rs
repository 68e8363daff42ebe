//! What makes an OBJ file unusable, and where.

use std::path::PathBuf;

use supple::mesh::MeshError;

/// Why an OBJ file is refused: the file, the line, the problem. Shown as `path:line: problem`.
#[derive(Debug)]
pub struct ObjError {
    /// The file.
    pub path: PathBuf,
    /// The line, from 1, where there is one to name.
    pub line: Option<usize>,
    /// What is wrong.
    pub problem: ObjProblem,
}

/// What is wrong with an OBJ file. Elements are counted from 1, as the format does.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ObjProblem {
    /// The file cannot be read.
    #[error("cannot be read: {0}")]
    Read(#[source] std::io::Error),
    /// The file is something else.
    #[error("is no OBJ file: {0}")]
    NotObj(String),
    /// There is no face with three distinct corners.
    #[error("no faces: no `f` with three corners among {faces} `f` and {vertices} `v`")]
    NoFaces {
        /// `v` statements.
        vertices: usize,
        /// `f` statements.
        faces: usize,
    },
    /// A statement with too few numbers.
    #[error("`{statement}` needs {needed} numbers, {found} found")]
    TooFewNumbers {
        /// The statement: `v` or `vn`.
        statement: &'static str,
        /// How many it needs.
        needed: usize,
        /// How many there are.
        found: usize,
    },
    /// Text where a number should be.
    #[error("`{text}` in `{statement}` is not a number")]
    NotANumber {
        /// The statement: `v` or `vn`.
        statement: &'static str,
        /// What stands there.
        text: String,
    },
    /// NaN, infinity, or a number beyond the range of `f32`.
    #[error("`{text}` in `{statement}`: numbers must be finite and within the range of f32")]
    NotFinite {
        /// The statement: `v` or `vn`.
        statement: &'static str,
        /// What stands there.
        text: String,
    },
    /// A corner of a face that is not `v`, `v/vt`, `v//vn` or `v/vt/vn`.
    #[error("face {face} has a corner `{text}`, which is none of v, v/vt, v//vn, v/vt/vn")]
    Corner {
        /// The face, from 1.
        face: usize,
        /// What stands there.
        text: String,
    },
    /// A corner of a face refers to something that the file does not have.
    #[error("face {face} refers to {what} {index} of {count}")]
    IndexOutOfRange {
        /// The face, from 1.
        face: usize,
        /// `"vertex"`, `"texture coordinate"` or `"normal"`.
        what: &'static str,
        /// The index as it stands in the file; negative ones count back from the line.
        index: i64,
        /// How many there are: in the file, or, for a negative index, above the line.
        count: usize,
    },
    /// No `o` or `g` of that name.
    #[error("no object or group `{name}` with faces; there are: {}", list(.known))]
    UnknownObject {
        /// The name that was asked for.
        name: String,
        /// The names that faces have.
        known: Vec<String>,
    },
    /// The file is read, but its faces make no mesh.
    #[error("{0}")]
    Mesh(#[source] MeshError),
    /// A file beyond what 32-bit indices can count.
    #[error("more vertices, normals or corners, or a longer line, than 32-bit indices can count")]
    TooLarge,
}

impl std::fmt::Display for ObjError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", self.path.display())?;
        if let Some(line) = self.line {
            write!(f, ":{line}")?;
        }
        write!(f, ": {}", self.problem)
    }
}

impl std::error::Error for ObjError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        self.problem.source()
    }
}

/// A problem and the line it is on, before the path is known.
pub(super) type At<T> = (Option<usize>, T);

fn list(names: &[String]) -> String {
    match names {
        [] => "none".to_owned(),
        names => names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", "),
    }
}
