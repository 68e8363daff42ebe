//! Arrays out: fresh copies of what lives, read-only views of what is constant.

use nalgebra::{Matrix3, Point3};
use numpy::ndarray::{Array2, Array3};
use numpy::{Element, IntoPyArray, PyArray1, PyArray2, PyArray3, PyArrayMethods};
use pyo3::prelude::*;

/// A fresh `(n, 3)`.
pub(crate) fn of_vectors<'py>(py: Python<'py>, vectors: Vec<[f64; 3]>) -> Bound<'py, PyArray2<f64>> {
    rows(vectors).into_pyarray(py)
}

/// A fresh `(n, 3)`.
pub(crate) fn of_points<'py>(py: Python<'py>, points: Vec<Point3<f64>>) -> Bound<'py, PyArray2<f64>> {
    of_vectors(py, points.into_iter().map(Into::into).collect())
}

/// A fresh `(n, 3, 3)`.
pub(crate) fn of_matrices<'py>(py: Python<'py>, matrices: &[Matrix3<f64>]) -> Bound<'py, PyArray3<f64>> {
    let n = matrices.len();
    // nalgebra stores columns; a numpy array has rows.
    let numbers: Vec<f64> = matrices.iter().flat_map(|m| m.transpose().data.0).flatten().collect();
    Array3::from_shape_vec((n, 3, 3), numbers).expect("nine numbers a matrix").into_pyarray(py)
}

/// A fresh `(n,)`.
pub(crate) fn of_numbers<'py>(py: Python<'py>, numbers: Vec<f64>) -> Bound<'py, PyArray1<f64>> {
    numbers.into_pyarray(py)
}

/// A read-only `(n, 3)`.
pub(crate) fn constant_vectors(py: Python<'_>, vectors: Vec<[f64; 3]>) -> Py<PyArray2<f64>> {
    constant(py, vectors)
}

/// A read-only `(n, 3)` of integers.
pub(crate) fn constant_integers(py: Python<'_>, vectors: Vec<[i64; 3]>) -> Py<PyArray2<i64>> {
    constant(py, vectors)
}

fn constant<T: Element>(py: Python<'_>, vectors: Vec<[T; 3]>) -> Py<PyArray2<T>> {
    let array = rows(vectors).into_pyarray(py);
    array.readwrite().make_nonwriteable();
    array.unbind()
}

fn rows<T>(vectors: Vec<[T; 3]>) -> Array2<T> {
    Array2::from_shape_vec((vectors.len(), 3), vectors.into_flattened()).expect("three numbers a row")
}
