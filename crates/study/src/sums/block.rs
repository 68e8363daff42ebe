//! Computes a block of lattice vertices and the constants of its regions.

use nalgebra::Vector3;

use super::windows::{Summing, Windows};

/// Distances of the block's corner from the origin along each axis, in cells.
pub(super) const DISTANCES: [f64; 4] = [0.0, 1e2, 1e4, 1e6];

/// A block of `side` lattice vertices along each edge, with cells of edge 1. Vertices are ordered by z, then
/// y, then x.
#[derive(Clone, Debug)]
pub(super) struct Block {
    pub(super) side: usize,
    pub(super) half_width: usize,
    /// Region weight m_i / n_i of each vertex i, where m_i is its mass (1 for the mass of a cell) and n_i is
    /// the number of regions that contain it.
    pub(super) weights: Vec<f64>,
    /// 1 / n_i of each vertex.
    pub(super) inverse_counts: Vec<f64>,
    /// Sum of the region weights in the region of each vertex.
    pub(super) masses: Vec<f64>,
    /// Rest centroid of the region of each vertex, relative to the vertex.
    pub(super) centroids: Vec<Vector3<f64>>,
}

impl Block {
    /// Creates a block and computes the constants of its regions.
    pub(super) fn new(side: usize, half_width: usize) -> Self {
        // Number of vertices in the window around coordinate i of an axis. In a block, the number of windows
        // that contain i is the same.
        let window_size =
            |i: usize| ((i + half_width).min(side - 1) - i.saturating_sub(half_width) + 1) as f64;
        // Number of cells next to coordinate i of an axis.
        let cells = |i: usize| if i == 0 || i + 1 == side { 1.0 } else { 2.0 };
        let count = side.pow(3);
        let coordinates = |vertex: usize| [vertex % side, vertex / side % side, vertex / (side * side)];
        let product = |vertex: usize, factor: &dyn Fn(usize) -> f64| -> f64 {
            coordinates(vertex).into_iter().map(factor).product()
        };
        let inverse_counts: Vec<f64> = (0..count).map(|vertex| 1.0 / product(vertex, &window_size)).collect();
        let weights: Vec<f64> = (0..count).map(|v| product(v, &cells) / 8.0 * inverse_counts[v]).collect();
        let mut block =
            Self { side, half_width, weights, inverse_counts, masses: Vec::new(), centroids: Vec::new() };
        let windows = block.windows(Summing::Direct);
        // Plain and weighted sums of the weights, one axis after the other.
        let mut sums = vec![block.weights.clone()];
        for axis in 0..3 {
            let mut next = Vec::new();
            for field in &sums {
                let mut plain = vec![0.0; count];
                windows.plain(axis, field, &mut plain);
                next.push(plain);
            }
            let mut weighted = vec![0.0; count];
            windows.weighted(axis, &sums[0], &next[0], &mut weighted);
            next.push(weighted);
            sums = next;
        }
        block.centroids =
            (0..count).map(|v| Vector3::new(sums[1][v], sums[2][v], sums[3][v]) / sums[0][v]).collect();
        block.masses = sums.swap_remove(0);
        block
    }

    /// Returns the number of lattice vertices.
    pub(super) fn len(&self) -> usize {
        self.weights.len()
    }

    /// Returns the rest position of a vertex, relative to the block's corner.
    pub(super) fn rest(&self, vertex: usize) -> Vector3<f64> {
        let side = self.side;
        Vector3::new((vertex % side) as f64, (vertex / side % side) as f64, (vertex / (side * side)) as f64)
    }

    /// Returns the windows of the regions.
    pub(super) fn windows(&self, summing: Summing) -> Windows {
        Windows { side: self.side, half_width: self.half_width, summing }
    }

    /// Returns deformed positions: the block is bent and stretched, with deterministic noise of up to a tenth
    /// of a cell.
    pub(super) fn deformed(&self) -> Vec<Vector3<f64>> {
        let length = self.side as f64;
        let noise = |vertex: usize, axis: usize| (12.9898 * vertex as f64 + 78.233 * axis as f64).sin() * 0.1;
        (0..self.len())
            .map(|vertex| {
                let x = self.rest(vertex);
                let bent = Vector3::new(
                    x.x + 0.1 * length * (2.0 * x.y / length).sin(),
                    1.1 * x.y,
                    x.z + 0.08 * length * (3.0 * x.x / length).cos(),
                );
                bent + Vector3::from_fn(|axis, _| noise(vertex, axis))
            })
            .collect()
    }
}
