//! Computes a logarithmic axis: its range, ticks and grid lines.

use std::ops::Range;

/// A logarithmic axis.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Axis {
    pub(super) range: Range<f64>,
    /// Values at the labeled ticks.
    pub(super) ticks: Vec<f64>,
    /// Values at the grid lines, which include lines between the ticks.
    pub(super) grid_lines: Vec<f64>,
}

/// Minimum margin at both ends, in decades. Twice the margin exceeds log10(5 / 2), the largest gap between
/// ticks, so every axis has a tick.
const MARGIN: f64 = 0.2;
/// Number of decades below which ticks are at 1, 2 and 5 instead of only at powers of ten.
const FEW_DECADES: f64 = 2.5;

impl Axis {
    /// Creates an axis that contains all positive finite values, with a margin at both ends.
    pub(super) fn around(values: impl Iterator<Item = f64>) -> Self {
        let positive = values.filter(|x| x.is_finite() && *x > 0.0).map(f64::log10);
        let (low, high) =
            positive.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
        // Without values the axis has a default range.
        let (low, high) = if low <= high { (low, high) } else { (-1.0, 0.0) };
        let margin = ((high - low) * 0.08).max(MARGIN);
        let (low, high) = (low - margin, high + margin);
        let marks = |steps: &[f64]| -> Vec<f64> {
            let decades = low.floor() as i32..=high.ceil() as i32;
            let all = decades.flat_map(|decade| steps.iter().map(move |step| step * 10.0_f64.powi(decade)));
            all.filter(|x| (low..=high).contains(&x.log10())).collect()
        };
        let steps: &[f64] = if high - low < FEW_DECADES { &[1.0, 2.0, 5.0] } else { &[1.0] };
        Self {
            range: 10.0_f64.powf(low)..10.0_f64.powf(high),
            ticks: thinned(marks(steps)),
            grid_lines: marks(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0]),
        }
    }
}

/// Thins the ticks evenly to at most ten.
fn thinned(ticks: Vec<f64>) -> Vec<f64> {
    let every = ticks.len().div_ceil(10).max(1);
    ticks.into_iter().step_by(every).collect()
}

/// Formats a tick label: `0.02`, `5`, `1e-7`.
pub(super) fn number(value: f64) -> String {
    let exponent = value.log10().floor();
    if (-3.0..4.0).contains(&exponent) {
        // Round to the first digit, because 0.1 is not exact in binary.
        let decimals = (-exponent).max(0.0) as usize;
        format!("{value:.decimals$}")
    } else {
        format!("{value:.0e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_powers_of_ten_or_one_two_five() {
        let axis = Axis::around([0.3, 4.0].into_iter());
        assert_eq!(axis.ticks.iter().map(|&x| number(x)).collect::<Vec<_>>(), ["0.2", "0.5", "1", "2", "5"]);
        assert!(axis.range.start < 0.3 && axis.range.end > 4.0);
        let wide = Axis::around([1e-8, f64::NAN, 0.0, 1e-3].into_iter());
        assert!(wide.ticks.iter().all(|x| (x.log10() - x.log10().round()).abs() < 1e-9));
        assert!(wide.ticks.len() >= 5 && number(wide.ticks[0]) == "1e-8", "{:?}", wide.ticks);
    }

    #[test]
    fn axes_of_one_value_and_of_no_values_are_valid() {
        for axis in [Axis::around([2.0].into_iter()), Axis::around(std::iter::empty())] {
            assert!(axis.range.start > 0.0 && axis.range.start < axis.range.end && !axis.ticks.is_empty());
        }
    }

    #[test]
    fn every_axis_has_one_to_ten_ticks() {
        let thousandths = |number: i32| 10.0_f64.powf(f64::from(number) / 1000.0);
        for low in -1000..1000 {
            for width in [0, 1, 10, 100, 500, 2000, 2080, 2160, 2240, 2500, 5000] {
                let values = [thousandths(low), thousandths(low + width)];
                let axis = Axis::around(values.into_iter());
                assert!((1..=10).contains(&axis.ticks.len()), "{values:?}: {axis:?}");
            }
        }
    }
}
