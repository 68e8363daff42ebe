//! Computes rotation matrices from Euler angles in degrees. The results are bit-identical on every machine.

use nalgebra::Matrix3;

/// Coefficients of x³, x⁵, ... x¹⁷ in the Taylor series of the sine.
const SIN: [f64; 8] = [
    -1.0 / 6.0,
    1.0 / 120.0,
    -1.0 / 5_040.0,
    1.0 / 362_880.0,
    -1.0 / 39_916_800.0,
    1.0 / 6_227_020_800.0,
    -1.0 / 1_307_674_368_000.0,
    1.0 / 355_687_428_096_000.0,
];

/// Coefficients of x², x⁴, ... x¹⁶ in the Taylor series of the cosine.
const COS: [f64; 8] = [
    -1.0 / 2.0,
    1.0 / 24.0,
    -1.0 / 720.0,
    1.0 / 40_320.0,
    -1.0 / 3_628_800.0,
    1.0 / 479_001_600.0,
    -1.0 / 87_178_291_200.0,
    1.0 / 20_922_789_888_000.0,
];

/// Computes the sine and the cosine of an angle in degrees. The error is approximately 1 ulp, and zero at
/// multiples of 90 degrees.
///
/// Uses only correctly rounded operations, so that the results are bit-identical on every machine. The math
/// library of a platform does not guarantee this. An angle of many full turns has the same accuracy. The
/// results are NaN for an angle that is not finite.
pub fn sin_cos_degrees(degrees: f64) -> (f64, f64) {
    // Both the remainder by 360 and the difference from a multiple of 90 are exact.
    let within_turn = degrees % 360.0;
    let quarters = (within_turn / 90.0).round();
    let x = (within_turn - 90.0 * quarters) * (std::f64::consts::PI / 180.0);
    let (s, c) = (x + x * series(&SIN, x * x), 1.0 + series(&COS, x * x));
    match (quarters as i32).rem_euclid(4) {
        0 => (s, c),
        1 => (c, -s),
        2 => (-s, -c),
        _ => (-c, s),
    }
}

/// Computes the sum of `coefficients[k] * x_squared^(k+1)`.
fn series(coefficients: &[f64; 8], x_squared: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| (sum + c) * x_squared)
}

/// Computes the rotation matrix of Euler angles in degrees about the *fixed* axes x, then y, then z:
/// `Rz * Ry * Rx`.
///
/// If all angles are multiples of 90 degrees, each entry is exactly 0, 1 or -1. Zero angles give the
/// identity.
pub fn euler_degrees(angles: [f64; 3]) -> Matrix3<f64> {
    let [(sx, cx), (sy, cy), (sz, cz)] = angles.map(sin_cos_degrees);
    Matrix3::new(cz, -sz, 0.0, sz, cz, 0.0, 0.0, 0.0, 1.0)
        * Matrix3::new(cy, 0.0, sy, 0.0, 1.0, 0.0, -sy, 0.0, cy)
        * Matrix3::new(1.0, 0.0, 0.0, 0.0, cx, -sx, 0.0, sx, cx)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Rotation3, Vector3};

    #[test]
    fn sine_and_cosine_agree_with_the_math_library() {
        for i in -72_000..72_000 {
            let degrees = f64::from(i) * 0.01 + 0.003;
            let (s, c) = sin_cos_degrees(degrees);
            let (s0, c0) = (degrees % 360.0).to_radians().sin_cos();
            assert!((s - s0).abs() < 1e-15 && (c - c0).abs() < 1e-15, "{degrees}");
        }
    }

    #[test]
    fn sine_and_cosine_are_exact_at_multiples_of_90_degrees() {
        for (degrees, expected) in [
            (0.0, (0.0, 1.0)),
            (90.0, (1.0, 0.0)),
            (180.0, (0.0, -1.0)),
            (270.0, (-1.0, 0.0)),
            (720.0, (0.0, 1.0)),
            (-90.0, (-1.0, 0.0)),
            (90.0 * 1e9 + 90.0, (1.0, 0.0)),
        ] {
            assert_eq!(sin_cos_degrees(degrees), expected, "{degrees}");
        }
        assert!(sin_cos_degrees(f64::INFINITY).0.is_nan());
    }

    #[test]
    fn euler_angles_are_about_fixed_axes_in_the_order_x_y_z() {
        let [x, y, z] = [20.0, -35.0, 70.0];
        let about = |axis: Vector3<f64>, a: f64| Rotation3::new(axis * a.to_radians()).into_inner();
        let expected = about(Vector3::z(), z) * about(Vector3::y(), y) * about(Vector3::x(), x);
        assert!((euler_degrees([x, y, z]) - expected).norm() < 1e-15);
        // 90 degrees about x leave the x axis unchanged; 90 degrees about z then map it to y.
        assert_eq!(euler_degrees([90.0, 0.0, 90.0]) * Vector3::x(), Vector3::y());
    }
}
