//! `supple._core`: array checks, errors and classes over the `supple` crate. No algorithm lives here.
//!
//! | file | what |
//! |---|---|
//! | `argument` | numbers, words and keyword arguments, checked by name |
//! | `arrays` | numpy arrays in and out |
//! | `error` | Rust errors as the exceptions of `supple.errors` |
//! | `forked` | locks, after a fork |
//! | `mesh`, `lattice`, `body`, `simulation` | the classes |
//! | `constraint`, `collider` | pins, handles and colliders, as they are described |
//! | `scene` | scenes, loaded or run |
//! | `report` | reports, as the dataclasses of `supple.reports` |
//! | `functions` | functions over arrays |

mod argument;
mod arrays;
mod body;
mod collider;
mod constraint;
mod error;
mod forked;
mod functions;
mod lattice;
mod mesh;
mod report;
mod scene;
mod simulation;

/// The compiled part of `supple`.
#[pyo3::pymodule]
mod _core {
    use pyo3::exceptions::PyImportError;
    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        supple::check_simd_request().map_err(|error| PyImportError::new_err(error.to_string()))?;
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }

    #[pymodule_export]
    use crate::body::{Body, Hold, body_keys};
    #[pymodule_export]
    use crate::collider::check_collider;
    #[pymodule_export]
    use crate::functions::{reference_goals, rotations};
    #[pymodule_export]
    use crate::lattice::Lattice;
    #[pymodule_export]
    use crate::mesh::{Mesh, read_obj};
    #[pymodule_export]
    use crate::scene::{load_scene, run};
    #[pymodule_export]
    use crate::simulation::{Simulation, simd_level};
}
