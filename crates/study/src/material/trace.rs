//! Frequency and decay of a recorded motion.

use std::f64::consts::PI;

/// Returns the mean angular frequency between the first and the last zero of samples at the interval `dt`; NaN if there
/// are fewer than two zeros.
pub(super) fn angular_frequency(samples: &[f64], dt: f64) -> f64 {
    let zero = |k: usize| {
        let (a, b) = (samples[k - 1], samples[k]);
        (a * b < 0.0).then(|| k as f64 - 1.0 + a / (a - b))
    };
    let zeros: Vec<f64> = (1..samples.len()).filter_map(zero).collect();
    match zeros[..] {
        [first, .., last] => PI * (zeros.len() - 1) as f64 / ((last - first) * dt),
        _ => f64::NAN,
    }
}

/// Returns the rate at which the extrema of samples at the interval `dt` decay: the slope of the line that fits the
/// logarithms of their magnitudes best. NaN if there are fewer than two extrema.
pub(super) fn decay_of_extrema(samples: &[f64], dt: f64) -> f64 {
    let is_extremum = |&k: &usize| {
        let [before, now, after] = [k - 1, k, k + 1].map(|k| samples[k].abs());
        now > before && now >= after
    };
    let extrema = (1..samples.len().saturating_sub(1)).filter(is_extremum);
    decay(extrema.map(|k| (k as f64 * dt, samples[k].abs().ln())))
}

/// Returns the decay rate of positive samples at the interval `dt`: the slope of the line that fits their logarithms
/// best.
pub(super) fn decay_of_samples(samples: &[f64], dt: f64) -> f64 {
    decay(samples.iter().enumerate().map(|(k, sample)| (k as f64 * dt, sample.ln())))
}

/// Returns the negative slope of the line that fits the points best.
fn decay(points: impl Iterator<Item = (f64, f64)>) -> f64 {
    -slope(&points.collect::<Vec<_>>())
}

/// Returns the slope of the line that fits the points best; NaN for fewer than two points.
pub(super) fn slope(points: &[(f64, f64)]) -> f64 {
    let mean = |value: fn(&(f64, f64)) -> f64| points.iter().map(value).sum::<f64>() / points.len() as f64;
    let (time, logarithm) = (mean(|p| p.0), mean(|p| p.1));
    let products: f64 = points.iter().map(|p| (p.0 - time) * (p.1 - logarithm)).sum();
    let squares: f64 = points.iter().map(|p| (p.0 - time).powi(2)).sum();
    products / squares
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frequency_and_decay_of_a_damped_oscillation_are_found() {
        let (dt, omega, rate) = (0.001_f64, 9.0_f64, 0.7_f64);
        let samples: Vec<f64> =
            (0..3000).map(|k| k as f64 * dt).map(|t| (-rate * t).exp() * (omega * t + 0.3).cos()).collect();
        // Zeros are interpolated, with an error of about (ω dt)³; the extrema are equally far from those of the cosine.
        assert!((angular_frequency(&samples, dt) / omega - 1.0).abs() < 1e-5);
        assert!((decay_of_extrema(&samples, dt) / rate - 1.0).abs() < 1e-3);
        let energies: Vec<f64> = (0..3000).map(|k| (-2.0 * rate * k as f64 * dt).exp()).collect();
        assert!((decay_of_samples(&energies, dt) / (2.0 * rate) - 1.0).abs() < 1e-9);
        assert!(angular_frequency(&[1.0, 2.0, -1.0], dt).is_nan());
        assert!(decay_of_extrema(&[1.0, 2.0, 3.0], dt).is_nan());
    }
}
