//! Defines the functions on arrays: `supple.rotations` and `supple.reference.goals`.

use nalgebra::{Matrix3, Vector3};
use numpy::{PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use supple::reference::Regions;

use crate::argument::{self, Given, wrong_type};
use crate::arrays::{self, Axis};
use crate::body;
use crate::interrupt::interruptible;
use crate::lattice::Lattice;

/// Compute the rotation factor of each 3x3 matrix A, with the algorithm of a step.
///
/// The rotation factor is the rotation R that maximizes trace(R^T A).
///
/// a : (n, 3, 3) float, or a single (3, 3)
///     Finite, of any scale.
///
/// Returns (n, 3, 3) float64, or (3, 3) for a single matrix. Each R is a proper rotation (det R = +1), also
/// for a singular or inverted A. For det A < 0, R is U diag(1, 1, -1) V^T with the singular value
/// decomposition A = U S V^T (Umeyama 1991). For A = 0, R is the identity.
#[pyfunction]
pub(crate) fn rotations<'py>(a: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    let py = a.py();
    if let Some(matrix) = arrays::matrix(a, "a")? {
        let rotation = supple::rotations(&[Matrix3::from_row_slice(&matrix)]);
        return Ok(arrays::from_matrices(py, &rotation).reshape([3, 3])?.into_any());
    }
    let rows = arrays::matrices(a, "a")?;
    let rotations = py.detach(|| {
        let matrices: Vec<_> = rows.iter().map(|rows| Matrix3::from_row_slice(rows)).collect();
        supple::rotations(&matrices)
    });
    Ok(arrays::from_matrices(py, &rotations).into_any())
}

/// Compute goal positions by naive sums in float64. The function is slow; it is the reference for Body.goals.
///
/// lattice : Lattice
/// positions : (n, 3) float
///     One per lattice vertex, in the length unit of lattice.cell_size.
/// half_width : int
///     Half-width of the regions in cells, at least 1.
/// regions : "staircase" or "breadth_first"
///     "staircase": the regions of a step, up to half_width links along z, then y, then x.
///     "breadth_first": all vertices that are reached by at most half_width steps, each between two corners
///     of one cell (Rivers & James 2007).
///
/// Returns (n, 3) float64. The mass m_i of vertex i is the number of occupied cells that share the vertex,
/// divided by 8. The weight of the vertex in each of the n_i regions that contain it is m_i / n_i.
#[pyfunction]
#[pyo3(name = "reference_goals", signature = (lattice, positions, half_width, regions=Given(None)), text_signature = "(lattice, positions, half_width, regions='staircase')")]
pub(crate) fn reference_goals<'py>(
    lattice: &Bound<'py, PyAny>,
    positions: &Bound<'py, PyAny>,
    half_width: &Bound<'py, PyAny>,
    regions: Given<'py>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let py = lattice.py();
    let lattice =
        lattice.cast::<Lattice>().map_err(|_| wrong_type(lattice, "lattice", "a supple.Lattice"))?;
    let lattice = lattice.get().lattice.clone();
    let positions = arrays::vectors(positions, "positions", Axis::Is(lattice.len()))?;
    let half_width = body::half_width(half_width)?;
    let choices = [("staircase", Regions::Staircase), ("breadth_first", Regions::BreadthFirst)];
    let regions = regions.read("regions", |regions, name| argument::choice(regions, name, &choices))?;
    let regions = regions.unwrap_or(Regions::Staircase);
    let goals = interruptible(py, move || {
        let positions: Vec<Vector3<f64>> = positions.into_iter().map(Vector3::from).collect();
        let goals = supple::reference::goals(&lattice, &positions, half_width, regions);
        goals.into_iter().map(Into::into).collect()
    })?;
    Ok(arrays::from_vectors(py, goals))
}
