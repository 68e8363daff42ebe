//! `supple._core`: array checks, errors and classes over the `supple` crate. No algorithm lives here.
//!
//! | file | what |
//! |---|---|
//! | `argument`, `settings` | numbers, words and keyword arguments, checked by name |
//! | `arrays` | numpy arrays in and out |
//! | `error` | Rust errors as the exceptions of `supple.errors` |
//! | `mesh`, `lattice`, `body`, `simulation` | the classes |
//! | `selection`, `keys`, `collider` | what pins, handles and colliders are described by |
//! | `report` | reports, as the dataclasses of `supple.reports` |
//! | `reference`, `rotations` | functions over arrays |

mod argument;
mod arrays;
mod body;
mod collider;
mod error;
mod keys;
mod lattice;
mod mesh;
mod reference;
mod report;
mod rotations;
mod selection;
mod settings;
mod simulation;

/// The compiled part of `supple`.
#[pyo3::pymodule]
mod _core {
    #[pymodule_export]
    use crate::body::Body;
    #[pymodule_export]
    use crate::collider::check_collider;
    #[pymodule_export]
    use crate::lattice::Lattice;
    #[pymodule_export]
    use crate::mesh::{Mesh, read_obj};
    #[pymodule_export]
    use crate::reference::reference_goals;
    #[pymodule_export]
    use crate::rotations::rotations;
    #[pymodule_export]
    use crate::simulation::Simulation;
    #[pymodule_export]
    use crate::simulation::simd_level;
}
