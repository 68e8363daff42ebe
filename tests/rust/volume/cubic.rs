//! The cubic solver compared with known roots and exact evaluation, over the whole range of coefficients.

use proptest::prelude::*;
use supple::internals::{Root, smallest_root};

/// A seeded random number generator (xorshift64*), fast enough for a million cases.
struct Stream(u64);

impl Stream {
    fn bits(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_f491_4f6c_dd1d)
    }

    /// Returns a number from -1 to 1.
    fn signed(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    fn below(&mut self, n: u64) -> u64 {
        (self.bits() >> 33) % n
    }

    /// Returns zero or a number with a magnitude from 1e-30 to 1e30.
    fn wide(&mut self) -> f64 {
        if self.below(8) == 0 { 0.0 } else { self.signed().signum() * 10_f64.powf(30.0 * self.signed()) }
    }
}

/// Returns `|p(x)|`, evaluated in double-double arithmetic, and the sum of the magnitudes of its terms.
fn evaluate_exactly(c: [f64; 4], x: f64) -> (f64, f64) {
    let (mut high, mut low, mut magnitude) = (c[3], 0.0, c[3].abs());
    for &c in c[..3].iter().rev() {
        let product = high * x;
        let error = high.mul_add(x, -product) + low * x;
        let sum = product + c;
        let back = sum - product;
        low = (product - (sum - back)) + (c - back) + error;
        high = sum;
        magnitude = magnitude * x.abs() + c.abs();
    }
    ((high + low).abs(), magnitude)
}

/// Asserts that a root is exact for coefficients with a relative error of at most 1e-14.
fn assert_backward_stable(c: [f64; 4], root: Root) {
    let (value, magnitude) = evaluate_exactly(c, root.lambda);
    assert!(value <= 1e-14 * magnitude, "{c:?}: {root:?}, {value:e} of {magnitude:e}");
}

#[test]
fn the_root_of_smallest_magnitude_is_found_for_a_million_known_roots() {
    let mut stream = Stream(1);
    for _ in 0..1_000_000 {
        // Integers times a power of two: the coefficients are exact.
        let mut roots: [f64; 3] = std::array::from_fn(|_| stream.below(2001) as f64 - 1000.0);
        roots.sort_by(f64::total_cmp);
        let separated = roots[1] - roots[0] >= 20.0 && roots[2] - roots[1] >= 20.0;
        let [a, b, c] = roots;
        let scale = 2_f64.powi(stream.below(60) as i32 - 30);
        let lead = 2_f64.powi(stream.below(60) as i32 - 30);
        let integers = [-a * b * c, a * b + b * c + c * a, -(a + b + c), 1.0];
        let coefficients = std::array::from_fn(|k| lead * integers[k] * scale.powi(3 - k as i32));
        let root = smallest_root(coefficients, f64::INFINITY);
        assert!(!root.capped, "{roots:?}: {root:?}");
        assert_backward_stable(coefficients, root);
        if separated {
            let least = scale * a.abs().min(b.abs()).min(c.abs());
            assert!((root.lambda.abs() - least).abs() <= 1e-12 * least, "{roots:?} x {scale}: {root:?}");
        }
    }
}

#[test]
fn roots_are_backward_stable_for_a_million_coefficients_of_any_magnitude() {
    let mut stream = Stream(2);
    for _ in 0..1_000_000 {
        let c: [f64; 4] = std::array::from_fn(|_| stream.wide());
        let cap = if stream.below(2) == 0 { f64::INFINITY } else { 10_f64.powf(10.0 * stream.signed()) };
        let root = smallest_root(c, cap);
        assert!(
            root.lambda.is_finite() && root.residual.is_finite() && root.lambda.abs() <= cap,
            "{c:?} {cap}"
        );
        if root.capped {
            assert!(c[3] == 0.0 || cap.is_finite(), "a cubic has a root: {c:?} {root:?}");
        } else {
            assert_backward_stable(c, root);
        }
    }
}

#[test]
fn no_root_of_smaller_magnitude_exists() {
    let mut stream = Stream(3);
    for _ in 0..50_000 {
        let c: [f64; 4] = std::array::from_fn(|_| stream.signed());
        let cap = 3.0;
        let root = smallest_root(c, cap);
        let radius = if root.capped { cap } else { root.lambda.abs() };
        let (mut least, steps) = (f64::INFINITY, 100_i32);
        for k in -steps..=steps {
            let x = radius * f64::from(k) / f64::from(steps);
            let value = ((c[3] * x + c[2]) * x + c[1]) * x + c[0];
            least = least.min(value.abs());
            // The sign up to the root is the sign at zero.
            assert!(k.abs() == steps || value * c[0] > -1e-13, "{c:?}: {root:?}, but p({x}) = {value}");
        }
        assert!(!root.capped || root.residual.abs() <= least + 1e-13, "{c:?}: {root:?}, but {least}");
    }
}

#[test]
fn double_and_triple_roots_are_found_at_any_scale() {
    let mut stream = Stream(4);
    for _ in 0..100_000 {
        let scale = 2_f64.powi(stream.below(160) as i32 - 80);
        let (r, s) = (stream.below(99) as f64 - 49.0, stream.below(99) as f64 - 49.0);
        let double = [-r * r * s, r * r + 2.0 * r * s, -(2.0 * r + s), 1.0];
        let coefficients = std::array::from_fn(|k| double[k] * scale.powi(3 - k as i32));
        let root = smallest_root(coefficients, f64::INFINITY);
        assert!(!root.capped);
        assert_backward_stable(coefficients, root);
        // A rounding error of the evaluation moves a double root by its square root, a triple root by its
        // cube root.
        let (least, tolerance) = (r.abs().min(s.abs()), if (r - s).abs() < 2.0 { 1e-3 } else { 1e-6 });
        assert!(
            (root.lambda.abs() / scale - least).abs() <= tolerance * 49.0,
            "{r} {r} {s} x {scale}: {root:?}"
        );
    }
}

/// The constant term rises until two roots merge and vanish. The solution must not jump there.
#[test]
fn the_solution_is_continuous_where_two_roots_vanish() {
    // (x - 1)² (x + 20) + e for e from -0.1 to 0.1. The third root lies beyond the cap.
    let at = |e: f64| smallest_root([20.0 + e, -39.0, 18.0, 1.0], 10.0);
    let mut before = at(-0.1);
    for k in -99_999..=100_000 {
        let root = at(f64::from(k) * 1e-6);
        assert!((root.lambda - before.lambda).abs() < 1e-3, "{k}: {before:?} {root:?}");
        before = root;
    }
    assert!(before.capped && (before.lambda - 1.0).abs() < 1e-12);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 20_000, failure_persistence: None, ..Default::default() })]

    #[test]
    fn arbitrary_coefficients_give_finite_roots_within_the_cap(c: [f64; 4], cap: f64) {
        let root = smallest_root(c, cap);
        prop_assert!(root.lambda.is_finite());
        if c.iter().all(|c| c.is_finite()) {
            prop_assert!(!root.residual.is_nan());
        }
        prop_assert!(root.lambda == 0.0 || root.lambda.abs() <= cap);
    }

    #[test]
    fn the_root_is_independent_of_a_factor_on_the_polynomial(c in prop::array::uniform4(-1.0..1.0_f64), power in -90..90) {
        let factor = 2_f64.powi(power);
        let (root, scaled) = (smallest_root(c, 2.0), smallest_root(c.map(|c| c * factor), 2.0));
        prop_assert_eq!(root.lambda, scaled.lambda);
        prop_assert_eq!(root.capped, scaled.capped);
    }

    #[test]
    fn a_mirrored_polynomial_has_the_mirrored_root(c in prop::array::uniform4(-1.0..1.0_f64)) {
        let (root, mirrored) = (smallest_root(c, 2.0), smallest_root([c[0], -c[1], c[2], -c[3]], 2.0));
        prop_assert_eq!(root.capped, mirrored.capped);
        // The two solutions may stop at different ends of an interval where rounding decides the sign.
        prop_assert!((root.lambda.abs() - mirrored.lambda.abs()).abs() <= 1e-7);
    }
}
