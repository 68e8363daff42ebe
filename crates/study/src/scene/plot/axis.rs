//! A logarithmic axis: its range, the numbers beside it, the fine lines between.

use std::ops::Range;

/// A logarithmic axis.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Axis {
    pub(super) range: Range<f64>,
    /// Where numbers stand.
    pub(super) ticks: Vec<f64>,
    /// Where fine lines run.
    pub(super) fine: Vec<f64>,
}

/// Least room at both ends, in decades: twice as much is more than 2 is from 5, so that a number stands on every axis.
const ROOM: f64 = 0.2;
/// Decades below which numbers stand at 1, 2 and 5 and not at powers of ten alone.
const FEW: f64 = 2.5;

impl Axis {
    /// An axis around the positive ones of some values, with room at both ends.
    pub(super) fn around(values: impl Iterator<Item = f64>) -> Self {
        let positive = values.filter(|x| x.is_finite() && *x > 0.0).map(f64::log10);
        let (low, high) =
            positive.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
        // Without any value the axis is there all the same.
        let (low, high) = if low <= high { (low, high) } else { (-1.0, 0.0) };
        let room = ((high - low) * 0.08).max(ROOM);
        let (low, high) = (low - room, high + room);
        let marks = |steps: &[f64]| -> Vec<f64> {
            let decades = low.floor() as i32..=high.ceil() as i32;
            let all = decades.flat_map(|decade| steps.iter().map(move |step| step * 10.0_f64.powi(decade)));
            all.filter(|x| (low..=high).contains(&x.log10())).collect()
        };
        let steps: &[f64] = if high - low < FEW { &[1.0, 2.0, 5.0] } else { &[1.0] };
        Self {
            range: 10.0_f64.powf(low)..10.0_f64.powf(high),
            ticks: thinned(marks(steps)),
            fine: marks(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0]),
        }
    }
}

/// At most ten of them, evenly.
fn thinned(ticks: Vec<f64>) -> Vec<f64> {
    let every = ticks.len().div_ceil(10).max(1);
    ticks.into_iter().step_by(every).collect()
}

/// A number as people read it beside an axis: `0.02`, `5`, `1e-7`.
pub(super) fn number(value: f64) -> String {
    let exponent = value.log10().floor();
    if (-3.0..4.0).contains(&exponent) {
        // Rounding to the first digit: 0.1 is not 0.1 in binary.
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
    fn numbers_stand_at_powers_of_ten_or_at_one_two_five() {
        let axis = Axis::around([0.3, 4.0].into_iter());
        assert_eq!(axis.ticks.iter().map(|&x| number(x)).collect::<Vec<_>>(), ["0.2", "0.5", "1", "2", "5"]);
        assert!(axis.range.start < 0.3 && axis.range.end > 4.0);
        let wide = Axis::around([1e-8, f64::NAN, 0.0, 1e-3].into_iter());
        assert!(wide.ticks.iter().all(|x| (x.log10() - x.log10().round()).abs() < 1e-9));
        assert!(wide.ticks.len() >= 5 && number(wide.ticks[0]) == "1e-8", "{:?}", wide.ticks);
    }

    #[test]
    fn one_value_or_none_has_an_axis_too() {
        for axis in [Axis::around([2.0].into_iter()), Axis::around(std::iter::empty())] {
            assert!(axis.range.start > 0.0 && axis.range.start < axis.range.end && !axis.ticks.is_empty());
        }
    }

    #[test]
    fn a_number_stands_on_every_axis() {
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
