//! Scenes: loaded as a live simulation, or run to frames on disk.

mod job;
mod load;

pub(crate) use job::run;
pub(crate) use load::load_scene;

use pyo3::prelude::*;
use supple_io::run::RunError;
use supple_io::scene::{Scene, SceneError, Up};

use crate::argument;
use crate::error::{self, Exception};

/// The scene of a file: TOML, or the scene that a model alone means.
fn open(path: &Bound<'_, PyAny>, overrides: &[String]) -> PyResult<Scene> {
    let py = path.py();
    let path = argument::path(path, "path")?;
    py.detach(|| {
        // A file that is not there is told so, whatever its name ends in.
        if let Err(missing) = std::fs::metadata(&path) {
            return Err(SceneError::Read { path, source: missing });
        }
        Scene::open(&path, Up::default(), overrides)
    })
    .map_err(of_scene)
}

/// What is wrong with a scene.
fn of_scene(error: SceneError) -> PyErr {
    match error {
        SceneError::Read { path, source } => error::of_file(&path, &source),
        SceneError::Mesh(error) => error::of_obj(error),
        error => Exception::Scene.with(error.to_string()),
    }
}

/// What stopped a run, or kept it from starting.
fn of_run(error: RunError) -> PyErr {
    let message = error.to_string();
    match error {
        RunError::Scene(error) => of_scene(error),
        RunError::MeshFile { path, source, .. } => error::of_file(&path, &source),
        RunError::Mesh(error) => error::of_obj(error),
        RunError::Body { source: supple::Error::Mesh(_), .. } => Exception::Mesh.with(message),
        RunError::Body { source: supple::Error::Lattice(_), .. } => Exception::Lattice.with(message),
        error if error.is_input() && !matches!(error, RunError::NotAFolder { .. }) => {
            Exception::Scene.with(message)
        }
        _ => Exception::Output.with(message),
    }
}
