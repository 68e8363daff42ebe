//! Computes one rotation as an eigenvalue problem in f64: the fallback for matrices A for which Newton's
//! method does not converge.
//!
//! tr(R(q)ᵀ A) = qᵀ K q for each unit quaternion q with the rotation matrix R(q), where K is a symmetric 4 ×
//! 4 matrix (Davenport 1968; Horn 1987). So for any A, the quaternion of the optimal rotation is the
//! eigenvector of the largest eigenvalue of K. If several eigenvalues are the largest, several rotations are
//! optimal. The result is then the optimal rotation nearest to the previous rotation: the normalized
//! projection of the previous quaternion on the span of the eigenvectors of these eigenvalues.

use nalgebra::{Matrix4, Vector4};

/// Tolerance for equal eigenvalues, relative to the largest entry of A: an eigenvalue within this distance of
/// the largest eigenvalue counts as equal to it. A is given in f32, and its rounding errors separate equal
/// eigenvalues by approximately 1e-7.
const TIE: f64 = 2e-7;

/// Computes the unit quaternion (x, y, z, w) of the rotation R = argmax tr(Rᵀ A). `a` has the entries of A,
/// column by column.
///
/// If R is not unique, the result is the solution nearest to `previous`. If A is zero or not finite, the
/// result is `previous`.
pub(in crate::matching) fn rotation(a: [f32; 9], previous: [f32; 4]) -> [f32; 4] {
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
    // If the previous quaternion is orthogonal to all optimal quaternions, all of them are equally near to
    // it.
    let best = if nearest.norm() > 1e-3 { nearest } else { dominant };
    let unit = best.normalize();
    let aligned = if unit.dot(&previous) < 0.0 { -unit } else { unit };
    std::array::from_fn(|c| aligned[c] as f32)
}

/// Computes Davenport's matrix K for quaternions (x, y, z, w). `a` has the entries of A, column by column.
fn davenport(a: [f64; 9]) -> Matrix4<f64> {
    let entry = |row: usize, column: usize| a[3 * column + row];
    let trace = entry(0, 0) + entry(1, 1) + entry(2, 2);
    let mut k = Matrix4::zeros();
    for i in 0..3 {
        for j in 0..3 {
            k[(i, j)] = entry(i, j) + entry(j, i);
        }
        k[(i, i)] -= trace;
    }
    let axial = [entry(2, 1) - entry(1, 2), entry(0, 2) - entry(2, 0), entry(1, 0) - entry(0, 1)];
    for (i, x) in axial.into_iter().enumerate() {
        k[(i, 3)] = x;
        k[(3, i)] = x;
    }
    k[(3, 3)] = trace;
    k
}

/// Maximum number of Jacobi sweeps over all six pairs of axes. Four or five sweeps are sufficient, because
/// convergence is quadratic.
const SWEEPS: usize = 12;

/// Computes the eigenvalues and the eigenvectors (as columns) of a symmetric matrix by cyclic Jacobi
/// rotations, which are accurate even if eigenvalues coincide.
fn eigen(mut k: Matrix4<f64>) -> (Vector4<f64>, Matrix4<f64>) {
    let mut vectors = Matrix4::identity();
    for _ in 0..SWEEPS {
        let below_diagonal = (0..4).flat_map(|i| (0..i).map(move |j| (i, j)));
        let sum_of_squares: f64 = below_diagonal.map(|index| k[index] * k[index]).sum();
        // The entries of K are of order 1, so off-diagonal entries below 1e-18 are below f64 rounding.
        if sum_of_squares <= 1e-36 {
            break;
        }
        for p in 0..3 {
            for q in p + 1..4 {
                if k[(p, q)] == 0.0 {
                    continue;
                }
                // The tangent of the smaller of the two rotation angles that make k[p, q] zero.
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
