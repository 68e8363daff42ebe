//! Relaxation of parts of a lattice that sweeps of single vertices do not untangle.
//!
//! The gradients of the cells are smoothed, opened where they are inside out or thin, and each vertex moves to the mean
//! of the positions that the cells around it would give it. This moves many vertices at once, so that a part leaves a
//! minimum in which no single vertex can be moved with profit.

use nalgebra::{Matrix3, Vector3};

use super::cells::Cells;
use super::determinants::{mean_edges, opened};
use super::limits::Within;
use crate::simd::vector::wide;

/// Iterations of a relaxation. A few move a part far enough out of its minimum.
pub(super) const ITERATIONS: usize = 4;

/// Buffers of a relaxation.
#[derive(Debug, Default)]
pub(super) struct Relaxation {
    /// Gradient of each cell: its mean edges.
    gradients: Vec<Matrix3<f64>>,
    /// Sum of the gradients of the cells around each vertex, and their number.
    sums: Vec<(Matrix3<f64>, f64)>,
    /// Sum of the goals of each vertex, and their number.
    goals: Vec<(Vector3<f64>, f64)>,
    /// Index of each vertex of the lattice in the part.
    index: Vec<u32>,
}

impl Relaxation {
    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        let gradients = size_of_val(&*self.gradients) + size_of_val(&*self.sums);
        gradients + size_of_val(&*self.goals) + size_of_val(&*self.index)
    }

    /// Relaxes the cells of a part of the lattice. `vertices`: the corners of these cells. `smoothings`: how often the
    /// gradients are averaged.
    pub(super) fn relax(
        &mut self,
        (lattice, within): (&Cells, Within<'_>),
        (cells, vertices): (&[u32], &[u32]),
        smoothings: usize,
        positions: &mut [[f32; 3]],
    ) {
        self.index.resize(lattice.vertex_count(), 0);
        for (index, &vertex) in (0..).zip(vertices) {
            self.index[vertex as usize] = index;
        }
        for _ in 0..ITERATIONS {
            self.gradients.clear();
            let corners = |cell: u32, positions: &[[f32; 3]]| lattice.corners(cell, positions);
            let gradient = |&cell: &u32| Matrix3::from_columns(&mean_edges(&corners(cell, positions)));
            self.gradients.extend(cells.iter().map(gradient));
            for _ in 0..smoothings {
                self.smooth(lattice, cells, vertices.len());
            }
            self.goals.clear();
            self.goals.resize(vertices.len(), (Vector3::zeros(), 0.0));
            for (&cell, gradient) in cells.iter().zip(&self.gradients) {
                let Some(edges) = opened(gradient) else { continue };
                let center = corners(cell, positions).iter().sum::<Vector3<f64>>() / 8.0;
                for (k, &vertex) in lattice.vertices(cell).iter().enumerate() {
                    let at = Vector3::from([1, 2, 4].map(|bit| if k & bit == 0 { -0.5 } else { 0.5 }));
                    let (sum, count) = &mut self.goals[self.index[vertex as usize] as usize];
                    *sum += center + edges * at;
                    *count += 1.0;
                }
            }
            for (&vertex, (sum, count)) in vertices.iter().zip(&self.goals) {
                if *count > 0.0 {
                    let step = sum / *count - wide(positions[vertex as usize]);
                    let along = |normal: Vector3<f64>, along| step + normal * (along - normal.dot(&step));
                    within.advance(vertex, step, along, positions);
                }
            }
        }
    }

    /// Replaces the gradient of each cell by the mean over its corners, where the gradient of a corner is the mean over
    /// the cells of the part around it.
    fn smooth(&mut self, lattice: &Cells, cells: &[u32], vertices: usize) {
        let Self { gradients, sums, index, .. } = self;
        sums.clear();
        sums.resize(vertices, (Matrix3::zeros(), 0.0));
        for (&cell, gradient) in cells.iter().zip(&*gradients) {
            for &vertex in lattice.vertices(cell) {
                let (sum, count) = &mut sums[index[vertex as usize] as usize];
                *sum += gradient;
                *count += 1.0;
            }
        }
        for (&cell, gradient) in cells.iter().zip(gradients) {
            let means = lattice.vertices(cell).iter().map(|&vertex| {
                let (sum, count) = &sums[index[vertex as usize] as usize];
                sum / (8.0 * count)
            });
            *gradient = means.sum();
        }
    }
}
