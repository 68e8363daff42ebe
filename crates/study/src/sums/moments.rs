//! Goal positions by local or by global moments, in plain code that is alike for all, so that they can be compared.

use std::time::{Duration, Instant};

use nalgebra::{Matrix3, Vector3};
use supple::reference::rotation;

use super::block::Block;
use super::windows::{Number, Summing, Windows};

/// About what the moments of a region are taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Moments {
    /// About the center vertex of each region: offsets are small whole numbers.
    Local,
    /// About the origin: sums of m x and m x x0ᵀ, and then of [R t] (Rivers and James 2007, section 4).
    Global,
}

impl Moments {
    /// What it is called.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Local => "local",
            Self::Global => "global",
        }
    }
}

/// Fields, one number a vertex each.
type Fields<T> = Vec<Vec<T>>;

/// One way to sum, and its buffers.
pub(super) struct Rival<'a, T> {
    block: &'a Block,
    windows: Windows,
    moments: Moments,
    /// Rest positions: global moments are sums over them.
    rest: Fields<T>,
    fields: Fields<T>,
    out: Fields<T>,
    spare: Vec<T>,
}

impl<'a, T: Number> Rival<'a, T> {
    /// For a block whose corner is at rest at `(distance, distance, distance)`.
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

    /// The goal positions, and how long the sums took: not the rotations, which are the same for all, in f64.
    pub(super) fn goals(&mut self, positions: &[Vector3<T>]) -> (Vec<Vector3<f64>>, Duration) {
        let start = Instant::now();
        match self.moments {
            Moments::Local => self.gather_local(positions),
            Moments::Global => self.gather_global(positions),
        }
        let adjoint_time = start.elapsed();
        self.fit();
        let start = Instant::now();
        match self.moments {
            Moments::Local => self.scatter_local(),
            Moments::Global => self.all_axes(),
        }
        let goals = (0..self.block.len()).map(|v| self.goal(v)).collect();
        (goals, adjoint_time + start.elapsed())
    }

    /// Plain windows of all fields of `of`, along an axis.
    fn plain(&mut self, axis: usize, of: std::ops::Range<usize>) {
        for field in of {
            self.windows.plain(axis, &self.fields[field], &mut self.out[field]);
        }
    }

    /// x: S, Sx; y: S, Sx, Sy; z: S, Sx, Sy, Sz, each of three numbers.
    fn gather_local(&mut self, positions: &[Vector3<T>]) {
        for c in 0..3 {
            let weights = self.block.weights.iter();
            for ((field, x), weight) in self.fields[c].iter_mut().zip(positions).zip(weights) {
                *field = x[c] * T::of(*weight);
            }
        }
        for axis in 0..3 {
            let known = 3 * (axis + 1);
            self.plain(axis, 0..known);
            for c in 0..3 {
                let (sums, new) = self.out.split_at_mut(known);
                self.windows.weighted(axis, &self.fields[c], &sums[c], &mut new[c]);
            }
            std::mem::swap(&mut self.fields, &mut self.out);
        }
    }

    /// m x and m x x0ᵀ.
    fn gather_global(&mut self, positions: &[Vector3<T>]) {
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

    /// Twelve fields along three axes.
    fn all_axes(&mut self) {
        for axis in 0..3 {
            self.plain(axis, 0..12);
            std::mem::swap(&mut self.fields, &mut self.out);
        }
    }

    /// The motion of each region: t or b, and the columns of R.
    fn fit(&mut self) {
        for v in 0..self.block.len() {
            let (mass, d) = (T::of(1.0 / self.block.masses[v]), self.block.centroids[v]);
            let mean = Vector3::from_fn(|c, _| self.fields[c][v] * mass);
            // What the moments are taken about: the rest centroid from the region's center, or from the origin.
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

    /// The adjoint, z, y, x: B = W(b) - W'(column of the axis), and the columns that are left.
    fn scatter_local(&mut self) {
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

    /// The goal of a vertex, from what was scattered.
    fn goal(&self, v: usize) -> Vector3<f64> {
        let share = T::of(self.block.shares[v]);
        let goal = |c: usize| match self.moments {
            Moments::Local => self.fields[c][v],
            Moments::Global => {
                let turned = |k: usize| self.fields[3 + 3 * k + c][v] * self.rest[k][v];
                self.fields[c][v] + (turned(0) + turned(1) + turned(2))
            }
        };
        Vector3::from_fn(|c, _| (goal(c) * share).into())
    }
}
