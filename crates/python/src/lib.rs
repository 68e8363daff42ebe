//! The module `supple._core`: the Python bindings of the `supple` crate. They convert arrays, errors and
//! classes, and contain no algorithms.
//!
//! | file | contents |
//! |---|---|
//! | `appearance` | reads the texture coordinates and materials of meshes |
//! | `argument` | checks numbers, strings and keyword arguments |
//! | `arrays` | converts numpy arrays |
//! | `error` | converts Rust errors to the exceptions of `supple.errors` |
//! | `forked` | locks mutexes without a deadlock after a fork |
//! | `interrupt` | lets Ctrl-C end the wait for long work |
//! | `keys` | converts keyword arguments that a scene has too, and keys of scenes |
//! | `mesh`, `lattice`, `body`, `simulation` | define the classes of the same names |
//! | `constraint` | reads the descriptions of pins and handles |
//! | `point_cache` | writes the positions of a mesh in all frames to one file |
//! | `animation` | reads the positions of animated meshes |
//! | `collider` | reads the descriptions of colliders, and moves the colliders of a simulation |
//! | `rotation` | reads angles, quaternions and matrices |
//! | `scene` | loads and runs scenes |
//! | `command` | runs the command line |
//! | `pickle` | encodes the data of pickles, with a checksum |
//! | `report` | converts reports to the dataclasses of `supple.reports` |
//! | `functions` | defines functions on arrays |

mod animation;
mod appearance;
mod argument;
mod arrays;
mod body;
mod collider;
mod command;
mod constraint;
mod error;
mod forked;
mod functions;
mod interrupt;
mod keys;
mod lattice;
mod mesh;
mod pickle;
mod point_cache;
mod report;
mod rotation;
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
    use crate::body::{Body, ForceField, Hold, keys_of};
    #[pymodule_export]
    use crate::collider::{ColliderMotion, check_collider};
    #[pymodule_export]
    use crate::command::main;
    #[pymodule_export]
    use crate::functions::{reference_goals, rotations};
    #[pymodule_export]
    use crate::lattice::Lattice;
    #[pymodule_export]
    use crate::mesh::{Mesh, read_obj};
    #[pymodule_export]
    use crate::point_cache::CacheFile;
    #[pymodule_export]
    use crate::rotation::rotation_matrix;
    #[pymodule_export]
    use crate::scene::{load_scene, run};
    #[pymodule_export]
    use crate::simulation::{Recording, Simulation, film, simd_level, step_all};
}
