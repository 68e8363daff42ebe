//! A scale of the correction for each vertex: volume is given back where it was lost.
//!
//! One `lambda` for all of a body shrinks parts that nobody stretched. Here each region, a vertex with those up to one
//! link away in z, y and x, has a `lambda` of its own: what the volumes of its vertices have lost, over what they gain
//! per unit of `lambda`. A vertex takes the mean over the regions that hold it, by the adjoint of the same sums, so
//! that neighbours differ little.

use fearless_simd::{Simd, dispatch};

use super::adjacency::Adjacency;
use super::lattice_measure::add_vertex;
use super::line::{Determinants, Moving};
use crate::parallel::level;

/// How often: the first time moves most, the second mends where it moved too far.
const PASSES: usize = 2;

/// The part of a region's gain at rest below which it loses its say: what hardly gains must not move far for it.
const LEAST_GAIN: f64 = 0.4;

/// What a region's `lambda` stays below each time, as a part of the cap: where parts collapse, as about a sharp edge,
/// more would crease the body rather than fill it.
const MOST: f64 = 0.5;

/// The scales of a body.
#[derive(Clone, Debug)]
pub(super) struct Regional {
    /// Of each vertex at rest: its volume in cells.
    rest: Vec<f64>,
    /// Of each region at rest: how much it gains per unit of `lambda`.
    gains: Vec<f64>,
    /// How many regions hold each vertex.
    regions: Vec<f64>,
    /// Of each vertex, then of each region: what was lost, and what is gained per unit of `lambda`.
    lost: Buffer<[f64; 2]>,
    /// Of each region, then of each vertex.
    lambdas: Buffer<f64>,
    scales: Vec<f32>,
}

impl Regional {
    /// `points`: the lattice at rest, with its field.
    pub(super) fn new(adjacency: &Adjacency, points: &[Moving]) -> Self {
        let n = adjacency.len();
        let mut this = Self {
            rest: vec![0.0; n],
            gains: Vec::new(),
            regions: Vec::new(),
            lost: Buffer::new(n, [0.0; 2]),
            lambdas: Buffer::new(n, 1.0),
            scales: vec![0.0; n],
        };
        this.measure(adjacency, points);
        this.rest = this.lost.values.iter().map(|[lost, _]| -lost).collect();
        this.lost.sum(adjacency, [0, 1, 2], |a, b| [a[0] + b[0], a[1] + b[1]]);
        this.gains = this.lost.values.iter().map(|[_, gain]| *gain).collect();
        this.lambdas.sum(adjacency, [2, 1, 0], |a, b| a + b);
        this.regions.clone_from(&this.lambdas.values);
        this
    }

    /// Memory that it takes.
    pub(super) fn bytes(&self) -> usize {
        let at_rest = size_of_val(&*self.rest) + size_of_val(&*self.gains) + size_of_val(&*self.regions);
        at_rest + self.lost.bytes() + self.lambdas.bytes() + size_of_val(&*self.scales)
    }

    /// Moves the points along their directions, by scales below `caps[component]` in all.
    pub(super) fn give_back(&mut self, adjacency: &Adjacency, caps: &[f64], points: &mut [Moving]) {
        self.scales.fill(0.0);
        for _ in 0..PASSES {
            self.measure(adjacency, points);
            self.lost.sum(adjacency, [0, 1, 2], |a, b| [a[0] + b[0], a[1] + b[1]]);
            for (i, (lambda, &[lost, gain])) in
                self.lambdas.values.iter_mut().zip(&self.lost.values).enumerate()
            {
                let (least, most) = (LEAST_GAIN * self.gains[i], MOST * caps[adjacency.component(i)]);
                let wanted = lost * gain / (gain * gain + least * least);
                // The wish where it is small, and smoothly no more than the most.
                let wish = (wanted / most).clamp(-1e9, 1e9);
                let bounded = most * wish / (1.0 + wish * wish).sqrt();
                *lambda = if bounded.is_finite() { bounded } else { 0.0 };
            }
            self.lambdas.sum(adjacency, [2, 1, 0], |a, b| a + b);
            for (i, (scale, point)) in self.scales.iter_mut().zip(&mut *points).enumerate() {
                let more = (self.lambdas.values[i] / self.regions[i]) as f32;
                *scale += more;
                point.advance(more);
            }
        }
    }

    /// How far each point went, in units of its direction.
    pub(super) fn scales(&self) -> &[f32] {
        &self.scales
    }

    /// What each vertex's volume has lost since it was at rest, and what it gains per unit of `lambda`.
    fn measure(&mut self, adjacency: &Adjacency, points: &[Moving]) {
        let Self { rest, lost, .. } = self;
        dispatch!(level(), simd => measure(simd, adjacency.rows(), points, rest, &mut lost.values));
    }
}

/// As the measure `lattice`, vertex by vertex.
#[inline(always)]
fn measure<S: Simd>(simd: S, rows: &[[u32; 6]], points: &[Moving], rest: &[f64], out: &mut [[f64; 2]]) {
    for ((row, rest), out) in rows.iter().zip(rest).zip(out) {
        let mut volume = Determinants::zero(simd);
        add_vertex(simd, row, points, &mut volume);
        let [c0, c1, _, _] = volume.coefficients();
        *out = [rest - c0 / 8.0, c1 / 8.0];
    }
}

/// One value a vertex, summed in place.
#[derive(Clone, Debug)]
struct Buffer<T> {
    values: Vec<T>,
    before: Vec<T>,
}

impl<T: Copy> Buffer<T> {
    fn new(len: usize, value: T) -> Self {
        Self { values: vec![value; len], before: vec![value; len] }
    }

    fn bytes(&self) -> usize {
        size_of_val(&*self.values) + size_of_val(&*self.before)
    }

    /// Sums over each vertex and its neighbours along an axis, for some axes one after the other.
    fn sum(&mut self, adjacency: &Adjacency, axes: [usize; 3], add: impl Fn(T, T) -> T) {
        for axis in axes {
            std::mem::swap(&mut self.values, &mut self.before);
            let before = &self.before;
            for ((i, row), value) in adjacency.rows().iter().enumerate().zip(&mut self.values) {
                *value = before[i];
                for side in [2 * axis, 2 * axis + 1] {
                    if row[side] as usize != i {
                        *value = add(*value, before[row[side] as usize]);
                    }
                }
            }
        }
    }
}
