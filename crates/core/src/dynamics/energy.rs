//! The energy book: what a body on which nothing acts must not have more of than it began with.
//!
//! The pull towards the goals has a potential, V = alpha/(2 dt²) Σ over regions Σ m/n |goal - x|². A step, which is one of
//! the leapfrog method, keeps Σ m v₋·v₊ / 2 + V while a body vibrates (v₋ and v₊ are the velocities before and after the
//! pull), exactly where V is harmonic. But V has kinks where a region that is turned inside out has two best rotations,
//! and steps across them give energy: bodies let go from a point, or shuffled, come to have 6 to 300 times what they
//! began with in 10,000 steps. Near a kink, and nowhere else, Newton's method leaves rotations to the robust path. So in
//! those steps the energy is summed, and a body that has more than its book is slowed down beside its rigid motion.

use std::sync::atomic::{AtomicU64, Ordering};

use fearless_simd::{Simd, SimdBase, SimdFloat, f32x16};

use super::momentum::Bookkeeper;
use crate::body::State;
use crate::matching::Matching;
use crate::simd::lanes::{Block, LANES, Lanes};

/// The share of Σ m x² that rounding may make of the potential.
const NOISE: f64 = 1e-6;

/// What a body may have.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct EnergyBook {
    /// In full cells times (cells/s)².
    energy: f64,
    /// alpha/dt in 1/s and dt in seconds, by which it was measured: with others it is another energy.
    pull: f64,
    dt: f64,
}

/// Sums the energy of a body; its buffers.
#[derive(Debug)]
pub(crate) struct EnergyGuard {
    /// Σ over regions Σ m/n |x⁰ - c⁰|².
    rest: f64,
    matched: RegionSums,
    came: Lanes<3>,
}

/// A number in f64 for each block of regions, each written by one thread.
#[derive(Debug)]
pub(crate) struct RegionSums(Vec<AtomicU64>);

impl RegionSums {
    /// Takes Σ M (c² + 2 tr(Rᵀ A)) of the regions of two blocks that hold a vertex, given by bits.
    #[inline(always)]
    pub(crate) fn take<S: Simd>(
        &self,
        blocks: [usize; 2],
        occupied: [u8; 2],
        inverse_mass: f32x16<S>,
        mean: [f32x16<S>; 3],
        [a, r]: [&[f32x16<S>; 9]; 2],
    ) {
        let mut trace = r[0] * a[0];
        for i in 1..9 {
            trace = r[i].mul_add(a[i], trace);
        }
        let square = mean[0].mul_add(mean[0], mean[1].mul_add(mean[1], mean[2] * mean[2]));
        let values = (square + (trace + trace)).to_array();
        let inverse_masses = inverse_mass.to_array();
        // The first last: where both are the same block it is the one that was asked for.
        for half in [1, 0] {
            let mut sum = 0.0;
            for lane in (0..LANES).filter(|lane| occupied[half] >> lane & 1 != 0) {
                let at = half * LANES + lane;
                sum += f64::from(values[at]) / f64::from(inverse_masses[at]);
            }
            self.0[blocks[half]].store(sum.to_bits(), Ordering::Relaxed);
        }
    }

    fn sum(&self) -> f64 {
        self.0.iter().map(|sum| f64::from_bits(sum.load(Ordering::Relaxed))).sum()
    }
}

impl EnergyGuard {
    /// For the regions of a matching stage.
    pub(crate) fn new(matching: &Matching) -> Self {
        let blocks = matching.layout.blocks();
        Self {
            rest: matching.regions.rest_spread(&matching.layout),
            matched: RegionSums((0..blocks).map(|_| AtomicU64::new(0)).collect()),
            came: Lanes::zeros(blocks),
        }
    }

    /// Memory that it takes.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(self.matched.0.as_slice()) + self.came.bytes()
    }

    /// Where the sums of regions go.
    pub(crate) fn matched(&self) -> &RegionSums {
        &self.matched
    }

    /// Keeps the velocities before the pull.
    pub(crate) fn begin(&mut self, velocities: &Lanes<3>) {
        self.came.copy_from(velocities);
    }

    /// After the pull towards the goals, by `pull` = alpha/dt in 1/s, in a step of `dt` seconds: opens the book, or slows
    /// the body down to what it says.
    pub(crate) fn hold(
        &self,
        (pull, dt): (f64, f64),
        shares: &Lanes<2>,
        state: &mut State,
        bookkeeper: &mut Bookkeeper,
    ) {
        let State { positions, velocities, energy: book, .. } = state;
        let Sums { square, before_after, after } = self.sums(shares, positions, velocities);
        let potential = 0.5 * pull / dt * (self.rest + square - self.matched.sum());
        let noise = 0.5 * pull / dt * NOISE * square;
        let energy = 0.5 * before_after + potential;
        let limit = match *book {
            Some(book) if book.pull == pull && book.dt == dt => book.energy,
            _ => {
                *book = energy.is_finite().then_some(EnergyBook { energy, pull, dt });
                return;
            }
        };
        if energy <= limit + noise || !energy.is_finite() {
            return;
        }
        // With the velocities beside the rigid ones times s the energy is potential + rigid + s² beside - s pulled.
        let rigid = bookkeeper.rigid_energy();
        let (beside, pulled) = (0.5 * after - rigid, 0.5 * (after - before_after));
        let room = limit - potential - rigid;
        let scale = (pulled + (pulled * pulled + 4.0 * beside * room).max(0.0).sqrt()) / (2.0 * beside);
        if beside > 0.0 && scale.is_finite() {
            let scale = scale.clamp(0.0, 1.0);
            velocities.blocks_mut().iter_mut().flatten().for_each(|row| {
                row.iter_mut().for_each(|v| *v *= scale as f32);
            });
            bookkeeper.slow(f64::from(scale as f32));
        }
    }

    fn sums(&self, shares: &Lanes<2>, positions: &Lanes<3>, velocities: &Lanes<3>) -> Sums {
        let mut sums = Sums::default();
        let blocks = shares.blocks().iter().zip(positions.blocks()).zip(self.came.blocks());
        for (((shares, x), came), v) in blocks.zip(velocities.blocks()) {
            for lane in 0..LANES {
                let m = f64::from(shares[0][lane]);
                sums.square += m * product(x, x, lane);
                sums.before_after += m * product(came, v, lane);
                sums.after += m * product(v, v, lane);
            }
        }
        sums
    }
}

/// Σ m x², Σ m v₋·v₊, Σ m v₊².
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    square: f64,
    before_after: f64,
    after: f64,
}

fn product(a: &Block<3>, b: &Block<3>, lane: usize) -> f64 {
    a.iter().zip(b).map(|(a, b)| f64::from(a[lane]) * f64::from(b[lane])).sum()
}
