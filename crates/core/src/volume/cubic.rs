//! The root of least absolute value of a cubic polynomial, within a cap.
//!
//! Equation (1) of Takamatsu & Kanai (2009) is a cubic in the scale `lambda` of the correction, of which they take
//! the root of least absolute value. A closed formula loses that root where the leading coefficients all but vanish,
//! which happens whenever the field has little volume of its own. So the line is cut at the stationary points, and
//! the piece nearest to zero on which the sign changes is bisected over the floating-point numbers themselves:
//! at most 64 evaluations, no iteration that could fail to converge, and full accuracy at every magnitude.

/// The farthest that is looked, in any unit: beyond it the cube of `lambda` could overflow.
const FARTHEST: f64 = 1e75;

/// Rounding of Horner's rule on a cubic, in units of the sum of its terms' magnitudes (six roundings, doubled).
const ROUNDING: f64 = 12.0 * f64::EPSILON;

/// What [`smallest_root`] found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Root {
    /// The root; where there is none within the cap, the point within the cap where the polynomial is least in
    /// magnitude.
    pub lambda: f64,
    /// The polynomial's value at `lambda`.
    pub residual: f64,
    /// Whether there is no root within the cap.
    pub capped: bool,
}

/// The root of least absolute value of `c[0] + c[1] x + c[2] x^2 + c[3] x^3` in `-cap ..= cap`.
///
/// * Any coefficients may vanish. Of two roots of equal magnitude the positive one is taken.
/// * A stationary point whose value is zero up to rounding is a (double or triple) root.
/// * No root within the cap: the point within the cap of least residual, with `capped` set. Among equals the one
///   nearest to zero, so that a constant polynomial gives zero.
/// * `cap` may be infinite; zero, negative or NaN allow `lambda = 0` alone.
/// * The backward error `|p(lambda)| / sum |c_i lambda^i|` of a root is below `1e-14`.
/// * Finite coefficients never give NaN; others give `lambda = 0`, capped.
pub fn smallest_root(c: [f64; 4], cap: f64) -> Root {
    if c[0] == 0.0 {
        return Root { lambda: 0.0, residual: 0.0, capped: false };
    }
    let largest = c.iter().fold(0.0_f64, |largest, c| largest.max(c.abs()));
    if !c.iter().all(|c| c.is_finite()) || cap.is_nan() || cap <= 0.0 {
        return Root { lambda: 0.0, residual: c[0], capped: true };
    }
    // Dividing by a power of two rounds nothing, leaves every root in its place and keeps products in range.
    let unit = power_of_two_below(largest);
    let scaled = Scaled(c.map(|c| c / unit));
    let end = if cap.is_finite() { cap.min(FARTHEST) } else { scaled.root_bound().min(FARTHEST) };
    let stationary = scaled.stationary();

    let ahead = scaled.first_root(&stationary, end, 1.0);
    // The far side only matters as far out as what the near side has found.
    let behind = scaled.first_root(&stationary, ahead.map_or(end, |root| root.min(end)), -1.0);
    let lambda = match (ahead, behind) {
        (Some(ahead), Some(behind)) if behind < ahead => Some(-behind),
        (Some(ahead), _) => Some(ahead),
        (None, behind) => behind.map(|behind| -behind),
    };
    let (lambda, capped) = match lambda {
        Some(lambda) => (lambda, false),
        None => (scaled.least(&stationary, end), true),
    };
    Root { lambda, residual: scaled.at(lambda) * unit, capped }
}

/// The largest power of two that `x > 0` reaches, of the normal numbers.
fn power_of_two_below(x: f64) -> f64 {
    const EXPONENT: u64 = 0x7ff << 52;
    f64::from_bits(x.to_bits() & EXPONENT).max(f64::MIN_POSITIVE)
}

/// A cubic whose largest coefficient has a magnitude from one to two.
struct Scaled([f64; 4]);

impl Scaled {
    fn at(&self, x: f64) -> f64 {
        let c = &self.0;
        ((c[3] * x + c[2]) * x + c[1]) * x + c[0]
    }

    /// Whether the value at `x` cannot be told from zero.
    fn vanishes(&self, x: f64) -> bool {
        let (c, m) = (self.0.map(f64::abs), x.abs());
        self.at(x).abs() <= ROUNDING * (((c[3] * m + c[2]) * m + c[1]) * m + c[0])
    }

    /// A magnitude that no root exceeds (Fujiwara 1916), of the polynomial without its vanishing leading terms.
    fn root_bound(&self) -> f64 {
        let c = self.0;
        let Some(degree) = (1..4).rev().find(|&i| c[i] != 0.0) else { return 1.0 };
        let bound =
            (1..=degree).map(|k| (c[degree - k] / c[degree]).abs().powf(1.0 / k as f64)).fold(0.0, f64::max);
        // Twice the largest bounds the roots; the rest is room for the rounding of the powers.
        2.5 * bound
    }

    /// The real stationary points, in no order; NaN stands for one that does not exist.
    fn stationary(&self) -> [f64; 2] {
        let [_, c1, c2, c3] = self.0;
        // A quarter of the discriminant of 3 c3 x^2 + 2 c2 x + c1, with the rounding of one product given back, so
        // that a double stationary point is not lost to cancellation.
        let product = 3.0 * c3 * c1;
        let lost = (3.0 * c3).mul_add(c1, -product);
        let discriminant = c2.mul_add(c2, -product) - lost;
        let noise = 4.0 * f64::EPSILON * c2 * c2;
        if discriminant < -noise {
            return [f64::NAN; 2];
        }
        let q = -(c2 + discriminant.max(0.0).sqrt().copysign(c2));
        [q / (3.0 * c3), c1 / q].map(|x| if x.is_finite() { x } else { f64::NAN })
    }

    /// The magnitude of the first root on the way from zero to `end` in direction `side` (1 or -1).
    fn first_root(&self, stationary: &[f64; 2], end: f64, side: f64) -> Option<f64> {
        let mut stops = [end; 3];
        for (stop, x) in stops.iter_mut().zip(stationary) {
            let distance = x * side;
            if distance > 0.0 && distance < end {
                *stop = distance;
            }
        }
        if stops[0] > stops[1] {
            stops.swap(0, 1);
        }
        let above = self.0[0] > 0.0;
        let mut from = 0.0;
        for stop in stops {
            if stop < end && self.vanishes(side * stop) {
                return Some(stop);
            }
            let value = self.at(side * stop);
            if value == 0.0 || (value > 0.0) != above {
                return Some(self.bisect(from, stop, side, above));
            }
            from = stop;
        }
        None
    }

    /// The magnitude in `low ..= high` at which the sign first differs from `above`, or its neighbour below, whichever
    /// has the lesser value. The bit patterns of non-negative numbers are in the order of the numbers.
    fn bisect(&self, low: f64, high: f64, side: f64, above: bool) -> f64 {
        let (mut low, mut high) = (low.to_bits(), high.to_bits());
        while high - low > 1 {
            let middle = low + (high - low) / 2;
            let value = self.at(side * f64::from_bits(middle));
            if value != 0.0 && (value > 0.0) == above {
                low = middle;
            } else {
                high = middle;
            }
        }
        let (low, high) = (f64::from_bits(low), f64::from_bits(high));
        if self.at(side * low).abs() < self.at(side * high).abs() { low } else { high }
    }

    /// The point of `-end ..= end` of least magnitude of the value; among equals the one nearest to zero.
    fn least(&self, stationary: &[f64; 2], end: f64) -> f64 {
        let candidates = [stationary[0], stationary[1], end, -end];
        let mut least = 0.0_f64;
        for x in candidates.into_iter().filter(|x| x.abs() <= end) {
            let (value, best) = (self.at(x).abs(), self.at(least).abs());
            if value < best || (value == best && x.abs() < least.abs()) {
                least = x;
            }
        }
        least
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn roots(a: f64, b: f64, c: f64) -> [f64; 4] {
        [-a * b * c, a * b + b * c + c * a, -(a + b + c), 1.0]
    }

    #[test]
    fn lower_degrees() {
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
    fn double_and_triple_roots() {
        for r in [1.0, -0.5, 3.0, 1e-20] {
            let double = smallest_root(roots(r, r, 7.0), f64::INFINITY);
            assert!(!double.capped && (double.lambda - r).abs() <= 1e-12 * r.abs(), "{r}: {double:?}");
            let triple = smallest_root(roots(r, r, r), f64::INFINITY);
            assert!(!triple.capped && (triple.lambda - r).abs() <= 1e-4 * r.abs(), "{r}: {triple:?}");
        }
    }

    #[test]
    fn a_fold_gives_the_stationary_point() {
        // (x - 1)^2 + e: no root near 1 for e > 0.
        for e in [1e-3, 1e-9, 1e-15, 0.0] {
            let fold = smallest_root([1.0 + e, -2.0, 1.0, 0.0], 10.0);
            assert!((fold.lambda - 1.0).abs() < 1e-7, "{e}: {fold:?}");
            assert_eq!(fold.capped, e > 1e-14, "{e}");
        }
    }

    #[test]
    fn the_cap() {
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
    fn vanishing_leading_coefficients_do_not_send_the_root_away() {
        let root = smallest_root([-0.5, 1.0, 1e-30, -1e-30], f64::INFINITY);
        assert!((root.lambda - 0.5).abs() < 1e-15, "{root:?}");
        let far = smallest_root([1.0, 0.0, 0.0, 1e-30], f64::INFINITY);
        assert!((far.lambda + 1e10).abs() < 1e-2, "{far:?}");
    }

    #[test]
    fn not_finite() {
        let root = smallest_root([1.0, f64::NAN, 0.0, 0.0], 1.0);
        assert_eq!((root.lambda, root.capped), (0.0, true));
        assert!(!smallest_root([f64::MAX, f64::MIN, f64::MAX, f64::MIN], f64::INFINITY).lambda.is_nan());
        assert!(!smallest_root([f64::MIN_POSITIVE, 5e-324, 0.0, 5e-324], f64::INFINITY).lambda.is_nan());
    }
}
