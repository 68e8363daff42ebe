//! A block of lattice vertices, and what of it does not change.

use nalgebra::Vector3;

use super::windows::{Summing, Windows};

/// Distances of the blocks' corners from the origin along each axis, in cells.
pub(super) const DISTANCES: [f64; 4] = [0.0, 1e2, 1e4, 1e6];

/// A block of `side` vertices along each edge, x fastest, with cells of edge 1.
#[derive(Clone, Debug)]
pub(super) struct Block {
    pub(super) side: usize,
    pub(super) half_width: usize,
    /// m_i / n_i of each vertex.
    pub(super) weights: Vec<f64>,
    /// 1 / n_i.
    pub(super) shares: Vec<f64>,
    /// Of each region: the sum of the weights.
    pub(super) masses: Vec<f64>,
    /// Of each region: the rest centroid from its center vertex.
    pub(super) centroids: Vec<Vector3<f64>>,
}

impl Block {
    pub(super) fn new(side: usize, half_width: usize) -> Self {
        // Vertices in the window around i, which in a block are also the windows that i is in.
        let reach = |i: usize| ((i + half_width).min(side - 1) - i.saturating_sub(half_width) + 1) as f64;
        // Cells beside a vertex.
        let cells = |i: usize| if i == 0 || i + 1 == side { 1.0 } else { 2.0 };
        let count = side.pow(3);
        let at = |vertex: usize| [vertex % side, vertex / side % side, vertex / (side * side)];
        let product =
            |vertex: usize, of: &dyn Fn(usize) -> f64| -> f64 { at(vertex).into_iter().map(of).product() };
        let shares: Vec<f64> = (0..count).map(|vertex| 1.0 / product(vertex, &reach)).collect();
        let weights: Vec<f64> = (0..count).map(|v| product(v, &cells) / 8.0 * shares[v]).collect();
        let mut block = Self { side, half_width, weights, shares, masses: Vec::new(), centroids: Vec::new() };
        let windows = block.windows(Summing::Direct);
        // Plain and weighted sums of the weights, axis after axis.
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

    /// Lattice vertices.
    pub(super) fn len(&self) -> usize {
        self.weights.len()
    }

    /// Rest position of a vertex from the block's corner.
    pub(super) fn rest(&self, vertex: usize) -> Vector3<f64> {
        let side = self.side;
        Vector3::new((vertex % side) as f64, (vertex / side % side) as f64, (vertex / (side * side)) as f64)
    }

    /// The windows of its regions.
    pub(super) fn windows(&self, summing: Summing) -> Windows {
        Windows { side: self.side, half_width: self.half_width, summing }
    }

    /// The block bent, stretched and shaken by up to a tenth of a cell, the same each time.
    pub(super) fn bent(&self) -> Vec<Vector3<f64>> {
        let long = self.side as f64;
        let shake = |vertex: usize, axis: usize| (12.9898 * vertex as f64 + 78.233 * axis as f64).sin() * 0.1;
        (0..self.len())
            .map(|vertex| {
                let x = self.rest(vertex);
                let bent = Vector3::new(
                    x.x + 0.1 * long * (2.0 * x.y / long).sin(),
                    1.1 * x.y,
                    x.z + 0.08 * long * (3.0 * x.x / long).cos(),
                );
                bent + Vector3::from_fn(|axis, _| shake(vertex, axis))
            })
            .collect()
    }
}
