//! Computes goal positions by local or global moments, in scalar code that all variants share.

use std::time::{Duration, Instant};

use nalgebra::{Matrix3, Vector3};
use supple::reference::rotation;

use super::block::Block;
use super::windows::{Number, Summing, Windows};

/// Origin of the moments of a region.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Moments {
    /// The rest positions in the moments of a region are relative to its center vertex, so they are small
    /// integers.
    Local,
    /// The rest positions x0 are relative to the origin. Sums of (m/n) x and (m/n) x x0ᵀ give the rotation R
    /// and the translation t of each region; goal positions are means of R x0 + t (Rivers & James 2007,
    /// Section 4).
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
    /// Input of a pass along an axis.
    fields: Fields<T>,
    /// Output of a pass; swapped with `fields` after each pass.
    out: Fields<T>,
    /// Weighted sums of one field.
    spare: Vec<T>,
}

impl<'a, T: Number> Summation<'a, T> {
    /// Creates a variant for a block whose corner has the rest position `(distance, distance, distance)`.
    pub(super) fn new(block: &'a Block, moments: Moments, summing: Summing, distance: f64) -> Self {
        let coordinates =
            |axis: usize| (0..block.len()).map(|v| T::of(block.rest(v)[axis] + distance)).collect();
        let fields = || vec![vec![T::of(0.0); block.len()]; 12];
        let rest = (0..3).map(coordinates).collect();
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

    /// Computes the plain window sums of a range of fields along an axis.
    fn plain(&mut self, axis: usize, range: std::ops::Range<usize>) {
        for field in range {
            self.windows.plain(axis, &self.fields[field], &mut self.out[field]);
        }
    }

    /// Computes the forward sums of local moments, one pass per axis. S is the sum of the weighted positions
    /// of the region; Sx, Sy and Sz are the sums weighted by the offsets in cells along x, y and z. Each has
    /// three numbers. The pass along x gives S and Sx, the pass along y adds Sy, and the pass along z adds
    /// Sz.
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

    /// Computes the forward sums of the global moments (m/n) x and (m/n) x x0ᵀ.
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

    /// Replaces the moments of each region by its best-fit rigid motion: the columns of the rotation R, and
    /// the translation (the position of the center vertex for local moments, of the origin for global
    /// moments).
    fn fit(&mut self) {
        for v in 0..self.block.len() {
            let (inverse_mass, d) = (T::of(1.0 / self.block.masses[v]), self.block.centroids[v]);
            let mean = Vector3::from_fn(|c, _| self.fields[c][v] * inverse_mass);
            // The rest centroid, relative to the origin of the moments.
            let centroid = match self.moments {
                Moments::Local => d.map(T::of),
                Moments::Global => Vector3::from_fn(|k, _| self.rest[k][v] + T::of(d[k])),
            };
            let a: Matrix3<f64> = Matrix3::from_fn(|c, k| {
                (self.fields[3 + 3 * k + c][v] * inverse_mass - mean[c] * centroid[k]).into()
            });
            let r = rotation(&a).map(T::of);
            for c in 0..3 {
                let rotated = r[(c, 0)] * centroid[0] + r[(c, 1)] * centroid[1] + r[(c, 2)] * centroid[2];
                self.fields[c][v] = mean[c] - rotated;
                for k in 0..3 {
                    self.fields[3 + 3 * k + c][v] = r[(c, k)];
                }
            }
        }
    }

    /// Computes the adjoint sums of local moments along z, then y, then x. W are plain and W' offset-weighted
    /// window sums. The pass along an axis replaces the translation b by W(b) - W'(column of R for the axis),
    /// and the columns for the remaining axes by their plain sums.
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
                let rotated = |k: usize| self.fields[3 + 3 * k + c][v] * self.rest[k][v];
                self.fields[c][v] + (rotated(0) + rotated(1) + rotated(2))
            }
        };
        Vector3::from_fn(|c, _| (goal(c) * inverse_count).into())
    }
}
