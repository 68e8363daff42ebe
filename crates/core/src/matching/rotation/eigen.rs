//! The robust path: one rotation as an eigenvalue problem in f64.
//!
//! tr(R(q)ᵀ A) = qᵀ K q with a symmetric 4 x 4 matrix K (Davenport 1968; Horn 1987), so the best rotation is the
//! eigenvector of K's largest eigenvalue, whatever A is. Where several rotations are equally good, the one nearest
//! to the rotation before is taken: its projection on the span of the eigenvectors.

use nalgebra::{Matrix4, Vector4};

/// Eigenvalues closer to the largest than this, relative to the scale of A, count as equal to it: the
/// matrices come in f32, so their rounding alone parts the eigenvalues of an ambiguous one by about 1e-7.
const TIE: f64 = 2e-7;

/// The unit quaternion (x, y, z, w) of the rotation factor of A, given by columns; `before` decides where the
/// factor is not unique. Zero or non-finite A keeps `before`.
pub(crate) fn rotation(a: [f32; 9], before: [f32; 4]) -> [f32; 4] {
    let scale = a.iter().fold(0.0_f32, |m, x| m.max(x.abs()));
    if !(scale > 0.0 && a.iter().all(|x| x.is_finite())) {
        return before;
    }
    let a = a.map(|x| f64::from(x) / f64::from(scale));
    let (eigenvalues, eigenvectors) = eigen(davenport(a));
    let largest = eigenvalues.max();
    let before_wide = Vector4::from(before.map(f64::from));
    let mut nearest = Vector4::zeros();
    let mut top = Vector4::zeros();
    for (value, vector) in eigenvalues.iter().zip(eigenvectors.column_iter()) {
        if *value >= largest - TIE {
            nearest += vector * vector.dot(&before_wide);
        }
        if *value == largest {
            top = vector.into_owned();
        }
    }
    // A rotation before that is orthogonal to all the best ones tells nothing: any of them will do.
    let best = if nearest.norm() > 1e-3 { nearest } else { top };
    let unit = best.normalize();
    let same_side = if unit.dot(&before_wide) < 0.0 { -unit } else { unit };
    std::array::from_fn(|c| same_side[c] as f32)
}

/// K of A given by columns, for quaternions (x, y, z, w).
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

/// Sweeps over all six pairs of axes; convergence is quadratic, and four or five do.
const SWEEPS: usize = 12;

/// Eigenvalues and eigenvectors (columns) of a symmetric matrix by cyclic Jacobi rotations, which are accurate
/// also where eigenvalues coincide.
fn eigen(mut k: Matrix4<f64>) -> (Vector4<f64>, Matrix4<f64>) {
    let mut vectors = Matrix4::identity();
    for _ in 0..SWEEPS {
        let off: f64 = (0..4).flat_map(|i| (0..i).map(move |j| (i, j))).map(|at| k[at] * k[at]).sum();
        if off <= 1e-36 {
            break;
        }
        for p in 0..3 {
            for q in p + 1..4 {
                if k[(p, q)] == 0.0 {
                    continue;
                }
                // The smaller of the two turns that bring k[p, q] to zero.
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
