//! `supple.rotations`: the rotation factor of matrices.

use nalgebra::Matrix3;
use numpy::PyArrayMethods;
use pyo3::prelude::*;

use crate::arrays;

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
