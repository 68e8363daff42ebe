//! Defines run times per frame. A sample is the time of one run of the whole motion, divided by its number of
//! frames.

use serde::{Deserialize, Serialize};

/// Wall-clock times of a frame in milliseconds: means over one run of the whole motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Sample {
    /// Steps of the frame.
    pub step: f64,
    /// Volume correction, including the rotations of its field.
    pub correction: f64,
    /// Mesh update with normals.
    pub update: f64,
}

impl Sample {
    /// Returns the total time of a frame.
    pub fn total(&self) -> f64 {
        self.step + self.correction + self.update
    }
}

/// Median, minimum and maximum of samples.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    /// Median.
    pub median: f64,
    /// Minimum.
    pub low: f64,
    /// Maximum.
    pub high: f64,
}

impl Spread {
    /// Computes the spread of `values`; all fields are NaN if there are no values.
    pub(crate) fn of(values: impl Iterator<Item = f64>) -> Self {
        let mut sorted: Vec<f64> = values.collect();
        sorted.sort_by(f64::total_cmp);
        let middle = sorted.len() / 2;
        let median = match sorted.len() % 2 {
            _ if sorted.is_empty() => f64::NAN,
            0 => (sorted[middle - 1] + sorted[middle]) / 2.0,
            _ => sorted[middle],
        };
        let number = |value: Option<&f64>| value.copied().unwrap_or(f64::NAN);
        Self { median, low: number(sorted.first()), high: number(sorted.last()) }
    }
}

/// Run time of a frame, in ms.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Timing {
    /// Steps.
    pub step: Spread,
    /// Volume correction.
    pub correction: Spread,
    /// Mesh update.
    pub update: Spread,
    /// Total of the three parts.
    pub total: Spread,
    /// First run, which the statistics exclude.
    pub warm_up: Option<Sample>,
    /// Runs that the statistics include.
    pub samples: Vec<Sample>,
}

impl Timing {
    /// Computes the statistics of `samples`.
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
    fn the_median_of_an_even_count_is_the_mean_of_the_middle_two() {
        let spread = |values: &[f64]| Spread::of(values.iter().copied());
        assert_eq!(spread(&[3.0]), Spread { median: 3.0, low: 3.0, high: 3.0 });
        assert_eq!(spread(&[4.0, 1.0, 2.0]), Spread { median: 2.0, low: 1.0, high: 4.0 });
        assert_eq!(spread(&[4.0, 1.0, 2.0, 3.0]), Spread { median: 2.5, low: 1.0, high: 4.0 });
    }
}
