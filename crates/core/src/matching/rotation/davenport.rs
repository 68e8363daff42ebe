//! The robust path: one rotation as an eigenvalue problem in f64.
//!
//! tr(R(q)ᵀ A) = qᵀ K q with a symmetric 4 x 4 matrix K (Davenport 1968; Horn 1987). So the optimal rotation
//! is the eigenvector of K's largest eigenvalue, for any A. Where several rotations are optimal, the result
//! is the one nearest to the previous rotation: the projection of the previous rotation on the span of their
//! eigenvectors.

use nalgebra::{Matrix4, Vector4};

/// Tolerance for ties: an eigenvalue within this distance of the largest, relative to the scale of A, counts
/// as equal to it. A is given in f32, and its rounding separates equal eigenvalues by about 1e-7.
const TIE: f64 = 2e-7;

/// Computes the unit quaternion (x, y, z, w) of the rotation R = argmax tr(Rᵀ A), with A given by columns.
///
/// `previous` selects the result where R is not unique. It is the result if A is zero or not finite.
pub(crate) fn rotation(a: [f32; 9], previous: [f32; 4]) -> [f32; 4] {
    let scale = a.iter().fold(0.0_f32, |m, x| m.max(x.abs()));
    if !(scale > 0.0 && a.iter().all(|x| x.is_finite())) {
        return previous;
    }
    let a = a.map(|x| f64::from(x) / f64::from(scale));
    let (eigenvalues, eigenvectors) = eigen(davenport(a));
    let largest = eigenvalues.max();
    let previous = Vector4::from(previous.map(f64::from));
    let mut nearest = Vector4::zeros();
    let mut dominant = Vector4::zeros();
    for (value, vector) in eigenvalues.iter().zip(eigenvectors.column_iter()) {
        if *value >= largest - TIE {
            nearest += vector * vector.dot(&previous);
        }
        if *value == largest {
            dominant = vector.into_owned();
        }
    }
    // If the previous rotation is orthogonal to all optimal ones, any of them is equally near.
    let best = if nearest.norm() > 1e-3 { nearest } else { dominant };
    let unit = best.normalize();
    let aligned = if unit.dot(&previous) < 0.0 { -unit } else { unit };
    std::array::from_fn(|c| aligned[c] as f32)
}

/// Computes Davenport's matrix K of A, given by columns, for quaternions (x, y, z, w).
fn davenport(a: [f64; 9]) -> Matrix4<f64> {
    let at = |row: usize, column: usize| a[3 * column + row];
    let trace = at(0, 0) + at(1, 1) + at(2, 2);
    let mut k = Matrix4::zeros();
    for i in 0..3 {
        for j in 0..3 {
            k[(i, j)] = at(i, j) + at(j, i);
        }
        k[(i, i)] -= trace;
    }
    let axial = [at(2, 1) - at(1, 2), at(0, 2) - at(2, 0), at(1, 0) - at(0, 1)];
    for (i, x) in axial.into_iter().enumerate() {
        k[(i, 3)] = x;
        k[(3, i)] = x;
    }
    k[(3, 3)] = trace;
    k
}

/// Maximum number of Jacobi sweeps over all six pairs of axes. Convergence is quadratic: four or five
/// suffice.
const SWEEPS: usize = 12;

/// Computes eigenvalues and eigenvectors (columns) of a symmetric matrix by cyclic Jacobi rotations, which
/// are also accurate where eigenvalues coincide.
fn eigen(mut k: Matrix4<f64>) -> (Vector4<f64>, Matrix4<f64>) {
    let mut vectors = Matrix4::identity();
    for _ in 0..SWEEPS {
        let off: f64 = (0..4).flat_map(|i| (0..i).map(move |j| (i, j))).map(|at| k[at] * k[at]).sum();
        // Off-diagonal entries below 1e-18, where the entries of K are of order 1, are below f64 rounding.
        if off <= 1e-36 {
            break;
        }
        for p in 0..3 {
            for q in p + 1..4 {
                if k[(p, q)] == 0.0 {
                    continue;
                }
                // The smaller of the two rotation angles that make k[p, q] zero.
                let cotangent = (k[(q, q)] - k[(p, p)]) / (2.0 * k[(p, q)]);
                let tangent = cotangent.signum() / (cotangent.abs() + (cotangent * cotangent + 1.0).sqrt());
                let cosine = 1.0 / (tangent * tangent + 1.0).sqrt();
                let sine = tangent * cosine;
                for i in 0..4 {
                    let (x, y) = (k[(i, p)], k[(i, q)]);
                    (k[(i, p)], k[(i, q)]) = (cosine * x - sine * y, sine * x + cosine * y);
                    let (x, y) = (vectors[(i, p)], vectors[(i, q)]);
                    (vectors[(i, p)], vectors[(i, q)]) = (cosine * x - sine * y, sine * x + cosine * y);
                }
                for i in 0..4 {
                    let (x, y) = (k[(p, i)], k[(q, i)]);
                    (k[(p, i)], k[(q, i)]) = (cosine * x - sine * y, sine * x + cosine * y);
                }
            }
        }
    }
    (k.diagonal(), vectors)
}
