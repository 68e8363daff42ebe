//! Writes point caches: the positions of a mesh in all frames, in one file.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use supple_io::frames::{Format, FrameWriter, Sequence, Source};

use crate::argument::{self, wrong_type};
use crate::arrays::{self, Axis};
use crate::error;
use crate::mesh::Mesh;

/// A file with the positions of a mesh; see supple.PointCache.
#[pyclass(frozen, module = "supple._core")]
pub(crate) struct CacheFile {
    path: PathBuf,
    /// Number of points in a frame.
    points: usize,
    state: Mutex<State>,
}

struct State {
    /// `None` when the file is complete.
    writer: Option<FrameWriter>,
    frames: u64,
}

#[pymethods]
impl CacheFile {
    /// Start a file.
    #[new]
    fn new(
        path: &Bound<'_, PyAny>,
        mesh: &Bound<'_, PyAny>,
        first_frame: &Bound<'_, PyAny>,
    ) -> PyResult<Self> {
        let path = argument::path(path, "path")?;
        let mesh = mesh.cast::<Mesh>().map_err(|_| wrong_type(mesh, "mesh", "a supple.Mesh"))?;
        let mesh = &mesh.get().mesh;
        let first = argument::count_u32(first_frame, "first_frame", 0)?;
        let sequence = sequence(&path, first.into())?;
        let writer = FrameWriter::create(sequence, Source::Mesh(mesh)).map_err(error::output)?;
        let points = mesh.vertices().len();
        Ok(Self { path, points, state: Mutex::new(State { writer: Some(writer), frames: 0 }) })
    }

    /// Append a frame with the positions of all vertices.
    fn write(&self, py: Python<'_>, positions: &Bound<'_, PyAny>) -> PyResult<()> {
        let positions = arrays::vectors(positions, "positions", Axis::Is(self.points))?;
        let append = || {
            let positions: Vec<[f32; 3]> =
                positions.into_iter().map(|position| position.map(|x| x as f32)).collect();
            let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
            let State { writer, frames } = &mut *state;
            let written = writer.as_mut()?.write(*frames, &positions, &[]);
            *frames += u64::from(written.is_ok());
            Some(written)
        };
        match py.detach(append) {
            Some(written) => written.map_err(error::output),
            None => {
                let path = self.path.display();
                Err(PyValueError::new_err(format!("{path} is complete; start another PointCache")))
            }
        }
    }

    /// Number of frames so far.
    #[getter]
    fn frames(&self, py: Python<'_>) -> u64 {
        py.detach(|| self.state.lock().unwrap_or_else(PoisonError::into_inner).frames)
    }

    /// Complete the file. Does nothing when it is complete.
    fn close(&self, py: Python<'_>) -> PyResult<()> {
        let finish = || {
            let writer = self.state.lock().unwrap_or_else(PoisonError::into_inner).writer.take();
            writer.map_or(Ok(()), FrameWriter::finish)
        };
        py.detach(finish).map_err(error::output)
    }
}

/// Returns the sequence with the one file `path`.
fn sequence(path: &Path, first_frame: u64) -> PyResult<Sequence> {
    let invalid = || PyValueError::new_err(format!("path is {}; it must end in NAME.pc2", path.display()));
    let is_cache = path.extension().is_some_and(|extension| extension == Format::Pc2.to_string().as_str());
    let name = path.file_stem().filter(|_| is_cache).and_then(|name| name.to_str()).ok_or_else(invalid)?;
    let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty());
    Ok(Sequence {
        directory: parent.unwrap_or(Path::new(".")).to_path_buf(),
        name: name.to_owned(),
        format: Format::Pc2,
        first: first_frame,
        every: 1,
        last: first_frame,
    })
}
