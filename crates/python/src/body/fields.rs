//! The force fields of a body: forces that act in every step.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use numpy::PyArray1;
use pyo3::prelude::*;

use crate::arrays;

/// A force on some vertices, in mass x length / s^2.
#[derive(Clone)]
pub(super) enum Force {
    /// The total force, distributed over the vertices in proportion to their masses.
    Total([f64; 3]),
    /// One force per vertex.
    Each(Vec<[f64; 3]>),
}

/// A force that acts in every step.
pub(super) struct Field {
    pub(super) id: u64,
    pub(super) source: Source,
    /// The lattice vertices; `None`: all.
    pub(super) vertices: Option<Vec<u32>>,
}

/// What gives the force of a field in a step.
pub(super) enum Source {
    Constant(Force),
    /// A Python function of positions, velocities and time.
    Function(Py<PyAny>),
}

/// The force fields of a body.
#[derive(Default)]
pub(super) struct Fields(Mutex<Vec<Arc<Field>>>);

impl Fields {
    /// Locks the list, in the order in which the fields were added.
    pub(super) fn lock(&self) -> MutexGuard<'_, Vec<Arc<Field>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Source {
    /// Returns the force as a Python object.
    pub(super) fn python<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        match self {
            Self::Constant(Force::Total(force)) => arrays::frozen(PyArray1::from_slice(py, force)).into_any(),
            Self::Constant(Force::Each(forces)) => {
                arrays::read_only(py, forces.clone()).into_bound(py).into_any()
            }
            Self::Function(function) => function.bind(py).clone(),
        }
    }
}
