//! Run times: a sample is a whole run of the motion, divided by its frames.

use serde::{Deserialize, Serialize};

/// Milliseconds of wall clock a frame, in one run of the whole motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Sample {
    /// The steps of the frame.
    pub step: f64,
    /// The volume correction, with the rotations that turn its field.
    pub correction: f64,
    /// The mesh update, with normals.
    pub update: f64,
}

impl Sample {
    /// All of a frame.
    pub fn total(&self) -> f64 {
        self.step + self.correction + self.update
    }
}

/// The middle and the ends of some samples, ms.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    /// The median.
    pub median: f64,
    /// The least.
    pub low: f64,
    /// The greatest.
    pub high: f64,
}

impl Spread {
    /// Of at least one value.
    pub(crate) fn of(values: impl Iterator<Item = f64>) -> Self {
        let mut sorted: Vec<f64> = values.collect();
        sorted.sort_by(f64::total_cmp);
        let middle = sorted.len() / 2;
        let median = match sorted.len() % 2 {
            _ if sorted.is_empty() => f64::NAN,
            0 => (sorted[middle - 1] + sorted[middle]) / 2.0,
            _ => sorted[middle],
        };
        let end = |at: Option<&f64>| at.copied().unwrap_or(f64::NAN);
        Self { median, low: end(sorted.first()), high: end(sorted.last()) }
    }
}

/// What a frame took, ms.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Timing {
    /// The steps.
    pub step: Spread,
    /// The volume correction.
    pub correction: Spread,
    /// The mesh update.
    pub update: Spread,
    /// All of it.
    pub total: Spread,
    /// The first run, which is not counted in.
    pub warm_up: Option<Sample>,
    /// The runs that are counted.
    pub samples: Vec<Sample>,
}

impl Timing {
    /// Of at least one run.
    pub(crate) fn new(warm_up: Option<Sample>, samples: Vec<Sample>) -> Self {
        let spread = |part: fn(&Sample) -> f64| Spread::of(samples.iter().map(part));
        Self {
            step: spread(|sample| sample.step),
            correction: spread(|sample| sample.correction),
            update: spread(|sample| sample.update),
            total: spread(Sample::total),
            warm_up,
            samples,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_of_an_even_number_lies_between_the_middle_two() {
        let spread = |values: &[f64]| Spread::of(values.iter().copied());
        assert_eq!(spread(&[3.0]), Spread { median: 3.0, low: 3.0, high: 3.0 });
        assert_eq!(spread(&[4.0, 1.0, 2.0]), Spread { median: 2.0, low: 1.0, high: 4.0 });
        assert_eq!(spread(&[4.0, 1.0, 2.0, 3.0]), Spread { median: 2.5, low: 1.0, high: 4.0 });
    }
}
