//! Rotation factors compared with the sign-corrected singular value decomposition in f64.

use nalgebra::{Matrix3, Rotation3, Vector3};
use supple::reference;
use supple_tests::Random;

/// Returns the singular values in decreasing order, the last one with the sign of the determinant.
fn signed_singular_values(a: &Matrix3<f64>) -> Vector3<f64> {
    let r = reference::rotation(a);
    let mut values = (r.transpose() * a).symmetric_eigenvalues();
    values.as_mut_slice().sort_by(|x, y| y.total_cmp(x));
    values
}

/// Returns the vector of the differences of opposite off-diagonal entries. It is zero for a symmetric matrix.
fn axial(m: &Matrix3<f64>) -> Vector3<f64> {
    Vector3::new(m[(2, 1)] - m[(1, 2)], m[(0, 2)] - m[(2, 0)], m[(1, 0)] - m[(0, 1)])
}

/// Returns a random matrix of a random kind, with the name of the kind.
fn any_matrix(random: &mut Random) -> (&'static str, Matrix3<f64>) {
    let entries = Matrix3::from_fn(|_, _| random.signed());
    let (u, v) = (random.rotation(), random.rotation());
    let diagonal = |s: [f64; 3]| u * Matrix3::from_diagonal(&Vector3::from(s)) * v.matrix();
    let small = 10.0_f64.powf(-8.0 * random.unit());
    match random.bits() % 16 {
        0..5 => ("random", entries),
        5 => ("rotation", *u.matrix()),
        6 => ("near a rotation", u.matrix() + entries * 1e-3),
        7 => ("near singular", diagonal([1.0, random.unit(), small])),
        8 => ("inverted", diagonal([1.0, 0.9 * random.unit() + 0.1, -0.5 * small])),
        9 => ("thin inverted", diagonal([1.0, small, -small * random.unit()])),
        10 => ("rank 1", diagonal([1.0, 0.0, 0.0])),
        11 => ("rank 2", diagonal([1.0, random.unit(), 0.0])),
        12 => ("zero", Matrix3::zeros()),
        13 => ("point inversion", -u.matrix()),
        14 => ("tiny", entries * 1e-30),
        _ => ("huge", entries * 1e30),
    }
}

#[test]
fn a_million_matrices_have_optimal_proper_rotations() {
    let mut random = Random(11);
    let (names, matrices): (Vec<_>, Vec<_>) = (0..1_000_000).map(|_| any_matrix(&mut random)).unzip();
    for ((name, a), r) in names.iter().zip(&matrices).zip(supple::rotations(&matrices)) {
        assert!(r.iter().all(|x| x.is_finite()), "{name}: {r} of {a}");
        assert!(r.determinant() > 0.0, "{name}: {r} of {a}");
        assert!((r.transpose() * r - Matrix3::identity()).amax() < 1e-6, "{name}: {r} of {a}");
        let scale = a.amax();
        if scale == 0.0 {
            continue;
        }
        let a = a / scale;
        let s = signed_singular_values(&a);
        let m = r.transpose() * a;
        // RᵀA is symmetric for the optimal rotation R, so its axial vector, here called torque, is zero.
        // Rounding R and A to f32 changes the torque by up to this much.
        let rounding = 8.0 * f64::from(f32::EPSILON) * s[0];
        let torque = axial(&m).norm();
        assert!(torque <= (1e-6 * (s[1] + s[2])).max(rounding), "{name}: torque {torque:e} of {a}, s = {s}");
        let short = s.sum() - m.trace();
        assert!(short <= rounding, "{name}: the trace is {short:e} below its maximum for {a}, s = {s}");
    }
}

#[test]
fn a_rotation_depends_on_the_other_matrices_of_its_batch_only_by_rounding() {
    let mut random = Random(12);
    let matrices: Vec<_> =
        (0..1000).map(|_| any_matrix(&mut random)).filter(|(name, _)| *name == "random").collect();
    let matrices: Vec<_> = matrices.into_iter().map(|(_, a)| a).collect();
    let together = supple::rotations(&matrices);
    for (a, r) in matrices.iter().zip(&together) {
        let single = supple::rotations(std::slice::from_ref(a))[0];
        let s = signed_singular_values(a);
        // A perturbation E of A changes its rotation by an angle of about |E| / (s[1] + s[2]), where s[1] and
        // s[2] are the two smallest signed singular values. The regression bound of |E| is 4e-6 (34 ulp of
        // f32) times the largest singular value s[0].
        assert!((single - r).amax() < 4e-6 * s[0] / (s[1] + s[2]).max(1e-3), "{a}");
    }
}

#[test]
fn matrices_with_non_finite_entries_have_the_identity_as_rotation() {
    let a = Matrix3::new(f64::NAN, 0.0, 0.0, 0.0, f64::INFINITY, 0.0, 0.0, 0.0, 1.0);
    assert!((supple::rotations(&[a])[0] - Matrix3::identity()).amax() < 1e-6);
    assert_eq!(supple::rotations(&[Matrix3::zeros()])[0], Matrix3::identity());
    assert!(supple::rotations(&[]).is_empty());
}

#[test]
fn rotations_by_large_angles_are_recovered() {
    for axis in [Vector3::x_axis(), Vector3::y_axis(), Vector3::z_axis()] {
        for angle in [std::f64::consts::PI, 3.0, -3.1, 2.0] {
            let turn = *Rotation3::from_axis_angle(&axis, angle).matrix();
            assert!((supple::rotations(&[turn * 0.3])[0] - turn).amax() < 1e-6, "{angle} about {axis:?}");
        }
    }
}
