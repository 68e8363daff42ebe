//! Goal positions by local or global moments, in scalar code that all variants share for comparability.

use std::time::{Duration, Instant};

use nalgebra::{Matrix3, Vector3};
use supple::reference::rotation;

use super::block::Block;
use super::windows::{Number, Summing, Windows};

/// Origin of the moments of a region.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Moments {
    /// Moments about the center vertex of each region; offsets are small integers.
    Local,
    /// Moments about the origin: sums of m x and m x x0ᵀ, then of [R t] (Rivers & James 2007, Section 4).
    Global,
}

impl Moments {
    /// Returns the name in tables.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Local => "local",
            Self::Global => "global",
        }
    }
}

/// Scalar fields, each with one number per vertex.
type Fields<T> = Vec<Vec<T>>;

/// One variant of the summation, with its buffers.
pub(super) struct Summation<'a, T> {
    block: &'a Block,
    windows: Windows,
    moments: Moments,
    /// Rest positions, one field per axis; used by global moments.
    rest: Fields<T>,
    fields: Fields<T>,
    out: Fields<T>,
    spare: Vec<T>,
}

impl<'a, T: Number> Summation<'a, T> {
    /// Creates a variant for a block whose corner has the rest position `(distance, distance, distance)`.
    pub(super) fn new(block: &'a Block, moments: Moments, summing: Summing, distance: f64) -> Self {
        let along = |axis: usize| (0..block.len()).map(|v| T::of(block.rest(v)[axis] + distance)).collect();
        let fields = || vec![vec![T::of(0.0); block.len()]; 12];
        let rest = (0..3).map(along).collect();
        Self {
            block,
            windows: block.windows(summing),
            moments,
            rest,
            fields: fields(),
            out: fields(),
            spare: vec![T::of(0.0); block.len()],
        }
    }

    /// Computes the goal positions and the time of the sums. The time excludes the rotations, which are
    /// computed in f64 in all variants.
    pub(super) fn goals(&mut self, positions: &[Vector3<T>]) -> (Vec<Vector3<f64>>, Duration) {
        let start = Instant::now();
        match self.moments {
            Moments::Local => self.forward_local(positions),
            Moments::Global => self.forward_global(positions),
        }
        let forward_time = start.elapsed();
        self.fit();
        let start = Instant::now();
        match self.moments {
            Moments::Local => self.adjoint_local(),
            Moments::Global => self.all_axes(),
        }
        let goals = (0..self.block.len()).map(|v| self.goal(v)).collect();
        (goals, forward_time + start.elapsed())
    }

    /// Computes plain window sums of the fields in the range `of` along an axis.
    fn plain(&mut self, axis: usize, of: std::ops::Range<usize>) {
        for field in of {
            self.windows.plain(axis, &self.fields[field], &mut self.out[field]);
        }
    }

    /// Forward sums of local moments. The results are S, Sx after x; S, Sx, Sy after y; S, Sx, Sy, Sz after
    /// z, of three numbers each.
    fn forward_local(&mut self, positions: &[Vector3<T>]) {
        for c in 0..3 {
            let weights = self.block.weights.iter();
            for ((field, x), weight) in self.fields[c].iter_mut().zip(positions).zip(weights) {
                *field = x[c] * T::of(*weight);
            }
        }
        for axis in 0..3 {
            let count = 3 * (axis + 1);
            self.plain(axis, 0..count);
            for c in 0..3 {
                let (sums, new) = self.out.split_at_mut(count);
                self.windows.weighted(axis, &self.fields[c], &sums[c], &mut new[c]);
            }
            std::mem::swap(&mut self.fields, &mut self.out);
        }
    }

    /// Forward sums of global moments m x and m x x0ᵀ.
    fn forward_global(&mut self, positions: &[Vector3<T>]) {
        for v in 0..positions.len() {
            let weighted = positions[v].map(|x| x * T::of(self.block.weights[v]));
            for c in 0..3 {
                self.fields[c][v] = weighted[c];
                for k in 0..3 {
                    self.fields[3 + 3 * k + c][v] = weighted[c] * self.rest[k][v];
                }
            }
        }
        self.all_axes();
    }

    /// Computes plain window sums of all twelve fields along all three axes.
    fn all_axes(&mut self) {
        for axis in 0..3 {
            self.plain(axis, 0..12);
            std::mem::swap(&mut self.fields, &mut self.out);
        }
    }

    /// Replaces the moments of each region by its motion: t (global) or b (local), and the columns of R.
    fn fit(&mut self) {
        for v in 0..self.block.len() {
            let (mass, d) = (T::of(1.0 / self.block.masses[v]), self.block.centroids[v]);
            let mean = Vector3::from_fn(|c, _| self.fields[c][v] * mass);
            // The rest centroid, relative to the origin of the moments.
            let centroid = match self.moments {
                Moments::Local => d.map(T::of),
                Moments::Global => Vector3::from_fn(|k, _| self.rest[k][v] + T::of(d[k])),
            };
            let a: Matrix3<f64> = Matrix3::from_fn(|c, k| {
                (self.fields[3 + 3 * k + c][v] * mass - mean[c] * centroid[k]).into()
            });
            let r = rotation(&a).map(T::of);
            for c in 0..3 {
                let turned = r[(c, 0)] * centroid[0] + r[(c, 1)] * centroid[1] + r[(c, 2)] * centroid[2];
                self.fields[c][v] = mean[c] - turned;
                for k in 0..3 {
                    self.fields[3 + 3 * k + c][v] = r[(c, k)];
                }
            }
        }
    }

    /// Adjoint sums of local moments along z, y, x: B = W(b) - W'(column of the axis), and the remaining
    /// columns.
    fn adjoint_local(&mut self) {
        for axis in (0..3).rev() {
            let column = 3 * (axis + 1);
            self.plain(axis, 0..column + 3);
            for c in 0..3 {
                let (field, sums) = (&self.fields[column + c], &self.out[column + c]);
                self.windows.weighted(axis, field, sums, &mut self.spare);
                for (b, weighted) in self.out[c].iter_mut().zip(&self.spare) {
                    *b -= *weighted;
                }
            }
            std::mem::swap(&mut self.fields, &mut self.out);
        }
    }

    /// Computes the goal of a vertex from the adjoint sums.
    fn goal(&self, v: usize) -> Vector3<f64> {
        let inverse_count = T::of(self.block.inverse_counts[v]);
        let goal = |c: usize| match self.moments {
            Moments::Local => self.fields[c][v],
            Moments::Global => {
                let turned = |k: usize| self.fields[3 + 3 * k + c][v] * self.rest[k][v];
                self.fields[c][v] + (turned(0) + turned(1) + turned(2))
            }
        };
        Vector3::from_fn(|c, _| (goal(c) * inverse_count).into())
    }
}
