//! Finds the real root of least absolute value of a cubic polynomial, within a cap.
//!
//! Eq. (1) of Takamatsu & Kanai 2009, `vol(P^ + lambda V) - vol(P) = 0`, is a cubic in the scale `lambda` of
//! the correction. Their solution is the root of least absolute value. A closed-form solution loses this root
//! if the leading coefficients almost vanish, which happens whenever the vectors of the field `V`, taken as
//! positions, enclose little volume. Here the interval from 0 to the cap is split at the stationary points of
//! the cubic, on either side of 0. The subinterval nearest to 0 in which the sign changes is bisected over
//! the bit patterns of the floating-point numbers. The bisection needs at most 64 evaluations, always
//! converges, and has full accuracy at every magnitude.

/// Greatest magnitude of a root that is searched; the cube of a larger `lambda` could overflow.
const MAX_MAGNITUDE: f64 = 1e75;

/// Bound of the rounding error of Horner's rule on a cubic, relative to the sum of the magnitudes of the
/// terms (six roundings, doubled).
const ROUNDING: f64 = 12.0 * f64::EPSILON;

/// Result of [`smallest_root`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Root {
    /// The root. Without a root within the cap: the point within the cap at which the polynomial has the
    /// least magnitude.
    pub lambda: f64,
    /// Value of the polynomial at `lambda`.
    pub residual: f64,
    /// Whether no root lies within the cap.
    pub capped: bool,
}

/// Returns the root of least absolute value of `c[0] + c[1] x + c[2] x^2 + c[3] x^3` in `-cap ..= cap`.
///
/// * Any coefficients may vanish. Of two roots of equal magnitude the positive one is returned.
/// * A stationary point at which the polynomial is zero up to rounding is a (double or triple) root.
/// * Without a root within the cap, the result is the point within the cap of least residual, with `capped`
///   set. Of several points with this residual, the point nearest to zero is returned, so that a constant
///   polynomial gives zero.
/// * `cap` may be infinite. A cap that is zero, negative or NaN allows only `lambda = 0`.
/// * The backward error of a root, `|p(lambda)| / sum |c[i] lambda^i|` with the polynomial `p`, is below
///   `1e-14`.
/// * Finite coefficients never give NaN. Infinite or NaN coefficients give `lambda = 0` with `capped` set.
pub fn smallest_root(c: [f64; 4], cap: f64) -> Root {
    if c[0] == 0.0 {
        return Root { lambda: 0.0, residual: 0.0, capped: false };
    }
    let largest = c.iter().fold(0.0_f64, |largest, c| largest.max(c.abs()));
    if !c.iter().all(|c| c.is_finite()) || cap.is_nan() || cap <= 0.0 {
        return Root { lambda: 0.0, residual: c[0], capped: true };
    }
    // Division by a power of two is exact, does not change the roots, and keeps products in range.
    let divisor = power_of_two_below(largest);
    let scaled = Scaled(c.map(|c| c / divisor));
    let end = if cap.is_finite() { cap.min(MAX_MAGNITUDE) } else { scaled.root_bound().min(MAX_MAGNITUDE) };
    let stationary = scaled.stationary();

    let positive = scaled.first_root(&stationary, end, 1.0);
    // On the negative side, only roots up to the magnitude of the positive root matter.
    let negative = scaled.first_root(&stationary, positive.map_or(end, |root| root.min(end)), -1.0);
    let lambda = match (positive, negative) {
        (Some(positive), Some(negative)) if negative < positive => Some(-negative),
        (Some(positive), _) => Some(positive),
        (None, negative) => negative.map(|negative| -negative),
    };
    let (lambda, capped) = match lambda {
        Some(lambda) => (lambda, false),
        None => (scaled.least_residual(&stationary, end), true),
    };
    Root { lambda, residual: scaled.at(lambda) * divisor, capped }
}

/// Returns the largest normal power of two that is at most `x > 0`; for subnormal `x`, the smallest normal
/// power of two.
fn power_of_two_below(x: f64) -> f64 {
    const EXPONENT: u64 = 0x7ff << 52;
    f64::from_bits(x.to_bits() & EXPONENT).max(f64::MIN_POSITIVE)
}

/// Cubic whose largest coefficient has a magnitude in [1, 2).
struct Scaled([f64; 4]);

impl Scaled {
    /// Evaluates the cubic.
    fn at(&self, x: f64) -> f64 {
        let c = &self.0;
        ((c[3] * x + c[2]) * x + c[1]) * x + c[0]
    }

    /// Returns whether the value at `x` is zero up to rounding.
    fn vanishes(&self, x: f64) -> bool {
        let (c, m) = (self.0.map(f64::abs), x.abs());
        self.at(x).abs() <= ROUNDING * (((c[3] * m + c[2]) * m + c[1]) * m + c[0])
    }

    /// Returns an upper bound of the magnitudes of the roots (Fujiwara 1916); leading coefficients that are
    /// zero are ignored.
    fn root_bound(&self) -> f64 {
        let c = self.0;
        let Some(degree) = (1..4).rev().find(|&i| c[i] != 0.0) else { return 1.0 };
        let bound = (1..=degree)
            .map(|k| libm::pow((c[degree - k] / c[degree]).abs(), 1.0 / k as f64))
            .fold(0.0, f64::max);
        // Twice the maximum is Fujiwara's bound; the factor 2.5 allows for the rounding of `pow`.
        2.5 * bound
    }

    /// Returns the two real stationary points in any order; NaN replaces a stationary point that does not
    /// exist.
    fn stationary(&self) -> [f64; 2] {
        let [_, c1, c2, c3] = self.0;
        // A quarter of the discriminant of the derivative 3 c3 x^2 + 2 c2 x + c1. It is compensated for the
        // rounding error of a product, so that cancellation does not lose a double stationary point.
        let product = 3.0 * c3 * c1;
        let product_error = libm::fma(3.0 * c3, c1, -product);
        let discriminant = libm::fma(c2, c2, -product) - product_error;
        let noise = 4.0 * f64::EPSILON * c2 * c2;
        if discriminant < -noise {
            return [f64::NAN; 2];
        }
        let q = -(c2 + discriminant.max(0.0).sqrt().copysign(c2));
        [q / (3.0 * c3), c1 / q].map(|x| if x.is_finite() { x } else { f64::NAN })
    }

    /// Returns the magnitude of the root nearest to zero, up to `end`, on one side of zero: positive for a
    /// `side` of 1, negative for -1.
    fn first_root(&self, stationary: &[f64; 2], end: f64, side: f64) -> Option<f64> {
        let mut interval_ends = [end; 3];
        for (interval_end, x) in interval_ends.iter_mut().zip(stationary) {
            let distance = x * side;
            if distance > 0.0 && distance < end {
                *interval_end = distance;
            }
        }
        if interval_ends[0] > interval_ends[1] {
            interval_ends.swap(0, 1);
        }
        let starts_positive = self.0[0] > 0.0;
        let mut interval_start = 0.0;
        for interval_end in interval_ends {
            if interval_end < end && self.vanishes(side * interval_end) {
                return Some(interval_end);
            }
            let value = self.at(side * interval_end);
            if value == 0.0 || (value > 0.0) != starts_positive {
                return Some(self.bisect(interval_start, interval_end, side, starts_positive));
            }
            interval_start = interval_end;
        }
        None
    }

    /// Bisects the magnitudes `low ..= high` for the change of sign, on one side of zero as in `first_root`.
    ///
    /// `starts_positive`: whether the value at `low` is positive. The sign changes between two adjacent
    /// floating-point numbers; the number with the smaller residual is returned. The bit patterns of
    /// non-negative floating-point numbers, as integers, have the same order as the numbers.
    fn bisect(&self, low: f64, high: f64, side: f64, starts_positive: bool) -> f64 {
        let (mut low, mut high) = (low.to_bits(), high.to_bits());
        while high - low > 1 {
            let middle = low + (high - low) / 2;
            let value = self.at(side * f64::from_bits(middle));
            if value != 0.0 && (value > 0.0) == starts_positive {
                low = middle;
            } else {
                high = middle;
            }
        }
        let (low, high) = (f64::from_bits(low), f64::from_bits(high));
        if self.at(side * low).abs() < self.at(side * high).abs() { low } else { high }
    }

    /// Returns the point in `-end ..= end` with the least residual. Of several such points, returns the point
    /// nearest to zero.
    fn least_residual(&self, stationary: &[f64; 2], end: f64) -> f64 {
        let candidates = [stationary[0], stationary[1], end, -end];
        let mut best = 0.0_f64;
        for x in candidates.into_iter().filter(|x| x.abs() <= end) {
            let (residual, best_residual) = (self.at(x).abs(), self.at(best).abs());
            if residual < best_residual || (residual == best_residual && x.abs() < best.abs()) {
                best = x;
            }
        }
        best
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the coefficients of the cubic with the roots `a`, `b`, `c`.
    fn roots(a: f64, b: f64, c: f64) -> [f64; 4] {
        [-a * b * c, a * b + b * c + c * a, -(a + b + c), 1.0]
    }

    #[test]
    fn linear_quadratic_and_constant_polynomials_are_solved() {
        let linear = smallest_root([1.0, -4.0, 0.0, 0.0], f64::INFINITY);
        assert_eq!((linear.lambda, linear.residual, linear.capped), (0.25, 0.0, false));
        let quadratic = smallest_root([2.0, -3.0, 1.0, 0.0], f64::INFINITY);
        assert_eq!((quadratic.lambda, quadratic.capped), (1.0, false));
        let constant = smallest_root([3.0, 0.0, 0.0, 0.0], 5.0);
        assert_eq!((constant.lambda, constant.residual, constant.capped), (0.0, 3.0, true));
        assert_eq!(smallest_root([0.0; 4], 5.0).lambda, 0.0);
        assert_eq!(smallest_root([-8.0, 0.0, 0.0, 1.0], f64::INFINITY).lambda, 2.0);
    }

    #[test]
    fn double_and_triple_roots_are_found() {
        for r in [1.0, -0.5, 3.0, 1e-20] {
            let double = smallest_root(roots(r, r, 7.0), f64::INFINITY);
            assert!(!double.capped && (double.lambda - r).abs() <= 1e-12 * r.abs(), "{r}: {double:?}");
            let triple = smallest_root(roots(r, r, r), f64::INFINITY);
            assert!(!triple.capped && (triple.lambda - r).abs() <= 1e-4 * r.abs(), "{r}: {triple:?}");
        }
    }

    #[test]
    fn near_double_root_gives_the_stationary_point() {
        // (x - 1)^2 + e: no root near 1 for e > 0.
        for e in [1e-3, 1e-9, 1e-15, 0.0] {
            let fold = smallest_root([1.0 + e, -2.0, 1.0, 0.0], 10.0);
            assert!((fold.lambda - 1.0).abs() < 1e-7, "{e}: {fold:?}");
            assert_eq!(fold.capped, e > 1e-14, "{e}");
        }
    }

    #[test]
    fn cap_limits_the_root_and_sets_capped() {
        let capped = smallest_root([-8.0, 0.0, 0.0, 1.0], 1.5);
        assert_eq!((capped.lambda, capped.residual, capped.capped), (1.5, 1.5_f64.powi(3) - 8.0, true));
        assert_eq!(smallest_root([-8.0, 0.0, 0.0, 1.0], 2.0).lambda, 2.0);
        assert!(!smallest_root([-8.0, 0.0, 0.0, 1.0], 2.0).capped);
        for cap in [0.0, -1.0, f64::NAN] {
            assert_eq!(
                smallest_root([1.0, 1.0, 0.0, 0.0], cap),
                Root { lambda: 0.0, residual: 1.0, capped: true }
            );
        }
        // The least residual is at the stationary point, not at an end.
        assert_eq!(smallest_root([3.0, -2.0, 1.0, 0.0], 4.0).lambda, 1.0);
    }

    #[test]
    fn tiny_leading_coefficients_keep_the_root_accurate() {
        let root = smallest_root([-0.5, 1.0, 1e-30, -1e-30], f64::INFINITY);
        assert!((root.lambda - 0.5).abs() < 1e-15, "{root:?}");
        let far = smallest_root([1.0, 0.0, 0.0, 1e-30], f64::INFINITY);
        assert!((far.lambda + 1e10).abs() < 1e-2, "{far:?}");
    }

    #[test]
    fn non_finite_coefficients_give_zero_and_finite_ones_never_nan() {
        let root = smallest_root([1.0, f64::NAN, 0.0, 0.0], 1.0);
        assert_eq!((root.lambda, root.capped), (0.0, true));
        assert!(!smallest_root([f64::MAX, f64::MIN, f64::MAX, f64::MIN], f64::INFINITY).lambda.is_nan());
        assert!(!smallest_root([f64::MIN_POSITIVE, 5e-324, 0.0, 5e-324], f64::INFINITY).lambda.is_nan());
    }
}
