//! A wind: its gusts and eddies are sums of waves, which the mean wind carries along (Taylor 1938).

use std::f64::consts::TAU;

use nalgebra::{Point3, Vector3};

/// Air with a velocity u, which accelerates bodies by drag (u - v).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Wind {
    /// Mean velocity of the air, in length/s, each component at most 1e12.
    pub velocity: [f64; 3],
    /// Rate in 1/s, at least 0, at which a body takes the velocity of the air; default 1.
    pub drag: f64,
    /// Greatest relative change of the velocity by gusts, in [0, 1]; default 0. Gusts last for some seconds, and move
    /// with the air.
    pub gust: f64,
    /// Root mean square of the velocity of eddies, relative to that of the wind, in [0, 1000]; default 0. Eddies are about
    /// as large as the displacement of the air in a second.
    pub turbulence: f64,
    /// Seed of gusts and eddies; default 0.
    pub seed: u64,
}

impl Default for Wind {
    fn default() -> Self {
        Self { velocity: [0.0; 3], drag: 1.0, gust: 0.0, turbulence: 0.0, seed: 0 }
    }
}

/// Periods in seconds of the gusts at a point. They are no multiples of each other, so that gusts do not repeat soon.
const GUSTS: [f64; 3] = [5.3, 3.1, 1.9];

/// Sizes of the eddies, as multiples of the displacement of the air in a second. Two waves of each size cross each other.
const EDDIES: [f64; 8] = [1.7, 1.7, 1.0, 1.0, 0.6, 0.6, 0.35, 0.35];

/// The air of a wind at a time.
#[derive(Debug)]
pub(super) struct Air {
    mean: Vector3<f64>,
    /// Displacement of the air since the time 0.
    displacement: Vector3<f64>,
    /// Waves of the speed along the wind, and then eddies.
    waves: [Wave; GUSTS.len() + EDDIES.len()],
}

/// A wave: the velocity `amplitude` sin(2 pi (`number` · x + `phase`)).
#[derive(Clone, Copy, Debug, Default)]
struct Wave {
    number: Vector3<f64>,
    phase: f64,
    amplitude: Vector3<f64>,
}

impl Wave {
    fn velocity(&self, place: &Vector3<f64>) -> Vector3<f64> {
        self.amplitude * libm::sin(TAU * (self.number.dot(place) + self.phase))
    }
}

impl Air {
    /// `time`: in seconds.
    pub(super) fn new(wind: &Wind, time: f64) -> Self {
        let mean = Vector3::from(wind.velocity);
        let speed = mean.norm();
        let mut waves = [Wave::default(); GUSTS.len() + EDDIES.len()];
        let (gusts, eddies) = waves.split_at_mut(GUSTS.len());
        let mut numbers = Numbers(wind.seed);
        if speed > 0.0 && wind.gust > 0.0 {
            for (wave, period) in gusts.iter_mut().zip(GUSTS) {
                let number = mean / (speed * speed * period);
                let amplitude = mean * (wind.gust / GUSTS.len() as f64);
                *wave = Wave { number, phase: numbers.next(), amplitude };
            }
        }
        if speed > 0.0 && wind.turbulence > 0.0 {
            // Each of the waves has the mean square 1/2.
            let amplitude = speed * wind.turbulence * (2.0 / EDDIES.len() as f64).sqrt();
            for (wave, size) in eddies.iter_mut().zip(EDDIES) {
                let direction = numbers.direction();
                // Velocities across the wave: the air keeps its volume.
                let across = direction.cross(&numbers.direction()).try_normalize(1e-3);
                let amplitude = across.unwrap_or_else(Vector3::zeros) * amplitude;
                *wave = Wave { number: direction / (size * speed), phase: numbers.next(), amplitude };
            }
        }
        Self { mean, displacement: mean * time, waves }
    }

    /// Returns the velocity of the air at a point.
    pub(super) fn velocity(&self, point: &Point3<f64>) -> Vector3<f64> {
        let place = point.coords - self.displacement;
        let waves = self.waves.iter().filter(|wave| wave.amplitude != Vector3::zeros());
        self.mean + waves.map(|wave| wave.velocity(&place)).sum::<Vector3<f64>>()
    }
}

/// A sequence of numbers in [0, 1) that depend on a seed (splitmix64: Steele, Lea & Flood 2014).
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z ^ (z >> 31)) as f64 / 18_446_744_073_709_551_616.0
    }

    /// Returns a unit vector, with the same density in all directions.
    fn direction(&mut self) -> Vector3<f64> {
        let (z, angle) = (2.0 * self.next() - 1.0, TAU * self.next());
        let radius = (1.0 - z * z).max(0.0).sqrt();
        Vector3::new(radius * libm::cos(angle), radius * libm::sin(angle), z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn samples(wind: &Wind) -> Vec<Vector3<f64>> {
        let place =
            |k: usize| Point3::new((k % 13) as f64 * 1.7, (k % 7) as f64 * 2.3, (k % 11) as f64 * 1.1);
        (0..4000).map(|k| Air::new(wind, k as f64 * 0.37).velocity(&place(k))).collect()
    }

    #[test]
    fn eddies_have_the_given_root_mean_square_and_no_mean() {
        let wind = Wind { velocity: [3.0, 0.0, 0.0], turbulence: 0.2, seed: 5, ..Wind::default() };
        let samples = samples(&wind);
        let mean: Vector3<f64> = samples.iter().sum::<Vector3<f64>>() / samples.len() as f64;
        let square = samples.iter().map(|u| (u - Vector3::from(wind.velocity)).norm_squared()).sum::<f64>();
        // 8 waves, each sampled over hundreds of periods: means within some percent.
        assert!((mean - Vector3::from(wind.velocity)).norm() < 0.05 * 3.0, "{mean}");
        assert!(((square / samples.len() as f64).sqrt() / (0.2 * 3.0) - 1.0).abs() < 0.1);
    }

    #[test]
    fn gusts_change_the_speed_by_at_most_their_share() {
        let wind = Wind { velocity: [0.0, -2.0, 0.0], gust: 0.5, seed: 1, ..Wind::default() };
        let speeds: Vec<f64> = samples(&wind).iter().map(|u| u.norm() / 2.0).collect();
        let (low, high) = speeds.iter().fold((f64::MAX, 0.0_f64), |(a, b), s| (a.min(*s), b.max(*s)));
        assert!(low >= 0.5 && high <= 1.5 && low < 0.65 && high > 1.35, "{low} {high}");
    }

    #[test]
    fn seeds_give_different_winds() {
        let wind = |seed| Wind { velocity: [1.0, 0.0, 0.0], gust: 0.5, seed, ..Wind::default() };
        let at = |seed| Air::new(&wind(seed), 0.7).velocity(&Point3::origin());
        assert!(at(1) != at(2) && at(1) == at(1));
    }
}
