//! Errors of reading OBJ files.

use std::path::PathBuf;

use supple::mesh::MeshError;

use crate::escape::{Escaped, Excerpt};

/// Error of reading an OBJ file, displayed as `path:line: problem`.
#[derive(Debug)]
pub struct ObjError {
    /// The file.
    pub path: PathBuf,
    /// Line of the problem, from 1; `None` if it concerns the whole file.
    pub line: Option<usize>,
    /// The problem.
    pub problem: ObjProblem,
}

/// A problem in an OBJ file. Indices count from 1, as in the file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ObjProblem {
    /// The file cannot be read.
    #[error("cannot be read: {0}")]
    Read(#[source] std::io::Error),
    /// The file has another format.
    #[error("is not an OBJ file: {0}; export the model as OBJ, GLB, glTF, STL or PLY")]
    NotObj(String),
    /// The text is UTF-16.
    #[error("is UTF-16 text; save it as UTF-8 or ASCII")]
    Utf16,
    /// A name ends in `\`, so that the statement continues on a line with another one.
    #[error(
        "the name in `{statement}` ends in `\\`, which continues the line, here with `{}`; remove the `\\` at the end of \
         the line",
        Excerpt(.next)
    )]
    NameContinues {
        /// The statement: `o`, `g`, `usemtl` or `mtllib`.
        statement: String,
        /// The next line.
        next: String,
    },
    /// No face has three corners or more.
    #[error("no faces: no `f` with three corners among {faces} `f` and {vertices} `v`; export polygons")]
    NoFaces {
        /// Number of `v` statements.
        vertices: usize,
        /// Number of `f` statements.
        faces: usize,
    },
    /// A statement has too few numbers.
    #[error("`{statement}` needs {needed} numbers, {found} found; complete the line")]
    TooFewNumbers {
        /// The statement: `v` or `vn`.
        statement: &'static str,
        /// Required number of numbers.
        needed: usize,
        /// Number of numbers in the statement.
        found: usize,
    },
    /// The text where a number is expected is not a number.
    #[error("`{}` in `{statement}` is not a number; write numbers like 1.5 or 2e-3", Excerpt(.text))]
    NotANumber {
        /// The statement: `v` or `vn`.
        statement: &'static str,
        /// The invalid text.
        text: String,
    },
    /// A number is NaN, infinite, or beyond the range of `f32`.
    #[error("`{}` in `{statement}`: numbers must be finite and within the range of f32", Excerpt(.text))]
    NotFinite {
        /// The statement: `v` or `vn`.
        statement: &'static str,
        /// The invalid text.
        text: String,
    },
    /// A face corner does not have the form `v`, `v/vt`, `v//vn` or `v/vt/vn`.
    #[error("face {face} has a corner `{}`; a corner must be v, v/vt, v//vn or v/vt/vn", Excerpt(.text))]
    Corner {
        /// The face, from 1.
        face: usize,
        /// The invalid text.
        text: String,
    },
    /// A face corner refers to an element that does not exist.
    #[error("face {face} refers to {what} {index} of {count}; indices count from 1, or back from -1")]
    IndexOutOfRange {
        /// The face, from 1.
        face: usize,
        /// `"vertex"`, `"texture coordinate"` or `"normal"`.
        what: &'static str,
        /// Index as written in the file. A negative index counts back from the line; -1 is the last element
        /// above it.
        index: i64,
        /// Number of elements in the file; for a negative index, number of elements above the line.
        count: usize,
    },
    /// No `o` or `g` with faces has the requested name.
    #[error("no object or group `{}` with faces; the file has: {}", Excerpt(.name), list(.known))]
    UnknownObject {
        /// Requested name.
        name: String,
        /// Names in the file that have faces.
        known: Vec<String>,
    },
    /// The faces of the file are not a valid mesh.
    #[error("{0}")]
    Mesh(#[source] MeshError),
    /// The file exceeds the range of 32-bit indices.
    #[error("more vertices, normals or corners, or a longer line, than 32 bits can count; split the file")]
    TooLarge,
}

impl std::fmt::Display for ObjError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", Escaped(self.path.display()))?;
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

/// A value and its line, from 1; `None` if the value concerns the whole file.
pub(super) type Located<T> = (Option<usize>, T);

/// Formats names as a list in quotes, or as `none` if there are no names. Names beyond the first 20 are
/// counted.
fn list(names: &[String]) -> String {
    const MAX: usize = 20;
    let mut list: Vec<_> = names.iter().take(MAX).map(|name| format!("`{}`", Excerpt(name))).collect();
    if names.len() > MAX {
        list.push(format!("and {} more", names.len() - MAX));
    }
    if list.is_empty() { "none".to_owned() } else { list.join(", ") }
}
