//! Reads rotations: Euler angles in degrees, quaternions, matrices, and `scipy.spatial.transform.Rotation`.

use nalgebra::Matrix3;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use supple::{euler_degrees_near, quaternion_rotation};

use crate::arrays::{self, Axis};

/// Greatest difference of an entry of R Rᵀ from the identity for a matrix R that counts as a rotation: some rounding
/// errors of float32.
const TOLERANCE: f64 = 1e-5;

/// Reads a rotation as Euler angles in degrees about the fixed axes x, then y, then z. Angles are taken as they are. Of
/// another rotation they are the ones nearest to `near`.
pub(crate) fn rotate(value: &Bound<'_, PyAny>, name: &str, near: [f64; 3]) -> PyResult<[f64; 3]> {
    let matrix = match value.getattr_opt("as_matrix")? {
        Some(as_matrix) => read_matrix(&as_matrix.call0()?, &format!("{name}.as_matrix()"))?,
        None => match shape(value)?.as_deref() {
            Some([4]) => read_quaternion(value, name)?,
            Some([_, _]) => read_matrix(value, name)?,
            Some([3]) | None => return arrays::vector(value, name),
            Some(found) => {
                let found: Vec<String> = found.iter().map(usize::to_string).collect();
                let comma = if found.len() == 1 { "," } else { "" };
                return Err(PyValueError::new_err(format!(
                    "{name} has the shape ({}{comma}); it must be (3,), angles in degrees, (4,), a quaternion x, y, z, w, or \
                     (3, 3), a matrix",
                    found.join(", ")
                )));
            }
        },
    };
    Ok(euler_degrees_near(&matrix, near))
}

/// Return the matrix of a rotation: angles in degrees, a quaternion, a matrix or an object with as_matrix. (3, 3)
/// float64.
#[pyfunction]
pub(crate) fn rotation_matrix<'py>(rotate: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    let matrix = supple::euler_degrees(rotate_once(rotate, "rotate")?);
    arrays::from_matrices(rotate.py(), &[matrix]).get_item(0)
}

/// Reads a rotation for [`Settings::read`](crate::argument::Settings::read).
pub(crate) fn rotate_once(value: &Bound<'_, PyAny>, name: &str) -> PyResult<[f64; 3]> {
    rotate(value, name, [0.0; 3])
}

/// Returns the shape of an array-like; `None` if it is none.
fn shape(value: &Bound<'_, PyAny>) -> PyResult<Option<Vec<usize>>> {
    let array = value.py().import("numpy")?.call_method1("asarray", (value,));
    Ok(array.and_then(|array| array.getattr("shape")?.extract()).ok())
}

/// Reads a quaternion x, y, z, w of any length except zero.
fn read_quaternion(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Matrix3<f64>> {
    let numbers = arrays::numbers(value, name, Axis::Is(4))?;
    quaternion_rotation([0, 1, 2, 3].map(|c| numbers[c]))
        .ok_or_else(|| PyValueError::new_err(format!("{name} is the quaternion zero, which is no rotation")))
}

/// Reads a rotation matrix.
fn read_matrix(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Matrix3<f64>> {
    let rows = arrays::vectors(value, name, Axis::Is(3))?;
    let matrix = Matrix3::from_fn(|row, column| rows[row][column]);
    let error = (matrix * matrix.transpose() - Matrix3::identity()).amax();
    if error > TOLERANCE || matrix.determinant() < 0.0 {
        let problem = match error > TOLERANCE {
            true => format!("R R\u{1d40} differs from the identity by {error:.1e}"),
            false => "it mirrors".to_owned(),
        };
        return Err(PyValueError::new_err(format!("{name} is no rotation matrix: {problem}")));
    }
    Ok(matrix)
}
