//! The force fields of a body: forces that act in every step.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::{PyTraverseError, PyVisit};
use serde::{Deserialize, Serialize};
use supple::{Joint, Lattice};

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
    pub(super) part: Part,
}

/// The lattice vertices of a field. They follow the body when joints break, and when a state with other broken joints
/// is restored: the part then has all vertices at the places of the selected ones.
#[derive(Clone, Serialize, Deserialize)]
pub(super) struct Part {
    /// The vertices in the lattice in which they were selected; `None`: all.
    selected: Option<Vec<u32>>,
    /// Their [sources](Lattice::source).
    sources: Vec<u32>,
    /// The broken joints of that lattice, which determine the numbers of its vertices.
    joints: Vec<Joint>,
}

impl Part {
    /// A part of a lattice. `selected`: its vertices; `None`: all. Returns `None` if the lattice does not have them.
    pub(super) fn new(lattice: &Lattice, selected: Option<Vec<u32>>) -> Option<Self> {
        let source = |vertex: u32| ((vertex as usize) < lattice.len()).then(|| lattice.source(vertex));
        let sources: Option<Vec<u32>> = match &selected {
            Some(list) => list.iter().copied().map(source).collect(),
            None => (0..lattice.len() as u32).map(source).collect(),
        };
        Some(Self { selected, sources: sources?, joints: lattice.broken_joints().to_vec() })
    }

    /// Returns whether the lattice has the vertices among which the part was selected.
    fn is_selected_in(&self, lattice: &Lattice) -> bool {
        lattice.broken_joints() == self.joints
    }

    /// Returns the vertices of the part in a lattice; `None`: all. Where joints broke or were mended, these are the
    /// sources of the selected vertices in their order, and then the copies of all of them in increasing order.
    pub(super) fn vertices(&self, lattice: &Lattice) -> Option<Vec<u32>> {
        let selected = self.selected.as_ref()?;
        if self.is_selected_in(lattice) {
            return Some(selected.clone());
        }
        let mut is_inside = vec![false; lattice.whole_len()];
        let is_first = |source: &u32| !std::mem::replace(&mut is_inside[*source as usize], true);
        let mut vertices: Vec<u32> = self.sources.iter().copied().filter(is_first).collect();
        let copies = lattice.whole_len() as u32..lattice.len() as u32;
        vertices.extend(copies.filter(|&copy| is_inside[lattice.source(copy) as usize]));
        Some(vertices)
    }

    /// Returns the force on each vertex of the part of a body. `forces` has one force per selected vertex. A vertex and
    /// its copies share the force of their source in proportion to their masses.
    pub(super) fn forces(&self, body: &supple::Body, forces: &[[f64; 3]]) -> Vec<(u32, [f64; 3])> {
        let lattice = body.lattice();
        let vertices = self.vertices(lattice);
        let vertices = vertices.unwrap_or_else(|| (0..lattice.len() as u32).collect());
        if self.is_selected_in(lattice) {
            return vertices.into_iter().zip(forces.iter().copied()).collect();
        }
        let (mut of_source, mut mass) = (vec![[0.0; 3]; lattice.whole_len()], vec![0.0; lattice.whole_len()]);
        for (&source, force) in self.sources.iter().zip(forces) {
            of_source[source as usize].iter_mut().zip(force).for_each(|(sum, force)| *sum += force);
        }
        let masses = body.masses();
        (0..).zip(&masses).for_each(|(vertex, own)| mass[lattice.source(vertex) as usize] += own);
        let of_vertex = |vertex: u32| {
            let source = lattice.source(vertex) as usize;
            (vertex, of_source[source].map(|force| force * (masses[vertex as usize] / mass[source])))
        };
        vertices.into_iter().map(of_vertex).collect()
    }
}

/// What gives the force of a field in a step.
pub(super) enum Source {
    Constant(Force),
    /// A Python function of positions, velocities and time.
    Function(Py<PyAny>),
}

/// The force fields of a body.
#[derive(Default)]
pub(crate) struct Fields(Mutex<Vec<Arc<Field>>>);

impl Fields {
    /// Locks the list, in the order in which the fields were added.
    ///
    /// Drop what is removed after the guard: a Python function may run code when it is freed.
    pub(super) fn lock(&self) -> MutexGuard<'_, Vec<Arc<Field>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Shows the Python functions to the garbage collector. Exactly one object may do so for a body, because the
    /// collector counts references.
    pub(crate) fn visit(&self, visit: &PyVisit<'_>) -> Result<(), PyTraverseError> {
        // No thread has locked the list while the collector runs: none releases the GIL in between.
        let Ok(fields) = self.0.try_lock() else { return Ok(()) };
        let functions = fields.iter().filter_map(|field| match &field.source {
            Source::Function(function) => Some(function),
            Source::Constant(_) => None,
        });
        functions.into_iter().try_for_each(|function| visit.call(function))
    }

    /// Removes all fields, for the garbage collector.
    pub(crate) fn clear(&self) {
        let fields = std::mem::take(&mut *self.lock());
        drop(fields);
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
