//! `supple.rotations` and `supple.reference`: functions over arrays.

use nalgebra::{Matrix3, Vector3};
use numpy::{PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use supple::reference::Regions;

use crate::argument::{self, wrong_type};
use crate::arrays::{self, Side};
use crate::lattice::Lattice;

/// The rotation factor of each 3x3 matrix, as used in the step: the rotation R that maximises trace(R^T A).
///
/// a : (n, 3, 3) float, or a single (3, 3)
///     Finite, of any scale.
///
/// Returns (n, 3, 3) float64, or (3, 3). Each is a proper rotation, det +1, also where A is singular or inverted: for
/// det A < 0 it is U diag(1, 1, -1) V^T (Umeyama 1991); for zero it is the identity.
#[pyfunction]
pub(crate) fn rotations<'py>(a: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    let py = a.py();
    if let Some(matrix) = arrays::matrix(a, "a")? {
        let rotation = supple::rotations(&[Matrix3::from_row_slice(&matrix)]);
        return Ok(arrays::of_matrices(py, &rotation).reshape([3, 3])?.into_any());
    }
    let rows = arrays::matrices(a, "a")?;
    let rotations = py.detach(|| {
        let matrices: Vec<_> = rows.iter().map(|rows| Matrix3::from_row_slice(rows)).collect();
        supple::rotations(&matrices)
    });
    Ok(arrays::of_matrices(py, &rotations).into_any())
}

/// Goal positions by plain sums in float64: slow, and the oracle of the fast ones.
///
/// lattice : Lattice
/// positions : (n, 3) float
///     One per lattice vertex, in the units of the lattice's cell size.
/// half_width : int
///     Of the regions, in cells, at least 0.
/// regions : "staircase" or "breadth_first"
///     "staircase": up to half_width linked steps along z, then y, then x, as the fast sums have them.
///     "breadth_first": all vertices within half_width steps between corners of a common cell (Rivers and James 2007).
///
/// Returns (n, 3) float64. Masses are occupied cells / 8; each vertex counts m_i / n_i in the n_i regions that hold it.
#[pyfunction]
#[pyo3(name = "reference_goals", signature = (lattice, positions, half_width, regions=None), text_signature = "(lattice, positions, half_width, regions='staircase')")]
pub(crate) fn reference_goals<'py>(
    lattice: &Bound<'py, PyAny>,
    positions: &Bound<'py, PyAny>,
    half_width: &Bound<'py, PyAny>,
    regions: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let py = lattice.py();
    let lattice =
        lattice.cast::<Lattice>().map_err(|_| wrong_type(lattice, "lattice", "a supple.Lattice"))?;
    let lattice = &lattice.get().lattice;
    let positions = arrays::vectors(positions, "positions", Side::Is(lattice.len()))?;
    let half_width = argument::count(half_width, "half_width", 0)?;
    let choices = [("staircase", Regions::Staircase), ("breadth_first", Regions::BreadthFirst)];
    let regions =
        regions.map_or(Ok(Regions::Staircase), |regions| argument::choice(regions, "regions", &choices))?;
    let goals = py.detach(|| {
        let positions: Vec<Vector3<f64>> = positions.into_iter().map(Vector3::from).collect();
        let goals = supple::reference::goals(lattice, &positions, half_width, regions);
        goals.into_iter().map(Into::into).collect()
    });
    Ok(arrays::of_vectors(py, goals))
}
