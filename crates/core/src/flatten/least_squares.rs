//! The displacements of lattice vertices that move mesh vertices by given displacements.
//!
//! The displacements u of the vertices minimize
//!
//! ```text
//! Σ over cells of  mean |w u - d|²   +   BENDING Σ over links |uᵢ - uⱼ|² / l²   +   RIDGE Σ |uᵢ|² / aᵢ²
//! ```
//!
//! with the trilinear weights w of the mesh vertices of a cell, their given displacements d, and the activity a of each
//! vertex in [0, 1]. The length l of each link keeps crushed cells from being turned inside out. A vertex whose activity approaches 0 comes to rest, so that the result is continuous when cells become
//! active. The minimum is found by the method of conjugate gradients (Hestenes & Stiefel 1952), with the diagonal as
//! preconditioner, on one thread.

use nalgebra::Vector3;

use super::table::FlattenTable;

/// Weight of the differences of displacements along links, relative to the lengths of the links. With 1e-4 cells of a ring that is
/// pressed to 0.6 of its height are turned inside out; with 1e-3 the gaps of a pressed ball are twice as large.
const BENDING: f32 = 2e-4;

/// Least length of a link in cells.
const LEAST_LENGTH: f32 = 0.05;

/// Weight of the displacements.
const RIDGE: f32 = 3e-5;

/// Number of iterations. With twice as many, the share of the vertices of pressed balls, rings and fish within 1 % of a cell changes by
/// less than 1 %.
const ITERATIONS: usize = 15;

/// Activity below which a vertex does not move. Its ridge would be 30, hundreds of times the other weights.
const LEAST_ACTIVITY: f32 = 1e-3;

/// Entry of `indices` for vertices that do not move.
const NONE: u32 = u32::MAX;

/// Vectors `(x, y, z, 0)`.
type Vectors = Vec<[f32; 4]>;

/// Buffers of the method.
#[derive(Debug, Default)]
pub(super) struct LeastSquares {
    /// Activity of each lattice vertex.
    activity: Vec<f32>,
    spread: Vec<f32>,
    /// The vertices that move, in increasing order, and the index of each vertex among them.
    vertices: Vec<u32>,
    indices: Vec<u32>,
    /// The cells with a vertex that moves, with the indices of their corners.
    cells: Vec<(u32, [u32; 8])>,
    /// Indices of the six neighbors of each vertex that moves. A missing one is the vertex itself.
    neighbors: Vec<[u32; 6]>,
    /// Weights of the links to these neighbors; zero for a missing one.
    stiffnesses: Vec<[f32; 6]>,
    ridges: Vec<f32>,
    inverse_diagonal: Vec<f32>,
    right: Vectors,
    displacements: Vectors,
    residuals: Vectors,
    directions: Vectors,
    products: Vectors,
}

impl LeastSquares {
    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        let vertices =
            size_of_val(&*self.activity) + size_of_val(&*self.spread) + size_of_val(&*self.indices);
        let links = size_of_val(&*self.neighbors) + size_of_val(&*self.stiffnesses);
        let moved = size_of_val(&*self.vertices) + links + size_of_val(&*self.cells);
        let numbers = size_of_val(&*self.ridges) + size_of_val(&*self.inverse_diagonal);
        let vectors = [&self.right, &self.displacements, &self.residuals, &self.directions, &self.products];
        let vectors: usize = vectors.iter().map(|list| size_of_val(&***list)).sum();
        vertices + moved + numbers + vectors
    }

    /// Removes the activities.
    pub(super) fn clear(&mut self, vertices: usize) {
        self.activity.clear();
        self.activity.resize(vertices, 0.0);
    }

    /// Raises the activity of the corners of a cell to `activity` at least.
    pub(super) fn activate(&mut self, corners: &[u32; 8], activity: f32) {
        for &corner in corners {
            let greatest = &mut self.activity[corner as usize];
            *greatest = greatest.max(activity);
        }
    }

    /// Finds the vertices that move: those with activity, and their neighbors and the neighbors of these with a half and a
    /// quarter of it. `fixed`: vertices that do not move.
    pub(super) fn prepare(
        &mut self,
        table: &FlattenTable,
        fixed: impl Iterator<Item = u32>,
        positions: &[[f32; 3]],
    ) {
        for _ in 0..2 {
            self.spread.clear();
            self.spread.extend(table.stencils.iter().map(|stencil| {
                let around = stencil.vertices().map(|vertex| self.activity[vertex as usize]);
                around[0].max(0.5 * around.into_iter().fold(0.0, f32::max))
            }));
            std::mem::swap(&mut self.activity, &mut self.spread);
        }
        fixed.for_each(|vertex| self.activity[vertex as usize] = 0.0);
        self.vertices.clear();
        self.indices.clear();
        self.ridges.clear();
        for (vertex, &activity) in (0..).zip(&self.activity) {
            let is_active = activity > LEAST_ACTIVITY;
            self.indices.push(if is_active { self.vertices.len() as u32 } else { NONE });
            if is_active {
                self.vertices.push(vertex);
                self.ridges.push(RIDGE / (activity * activity));
            }
        }
        let index = |vertex: u32| self.indices[vertex as usize];
        self.neighbors.clear();
        self.neighbors.extend(self.vertices.iter().map(|&vertex| {
            let [_, around @ ..] = table.stencils[vertex as usize].vertices();
            around.map(index)
        }));
        self.stiffnesses.clear();
        self.stiffnesses.extend(self.vertices.iter().map(|&vertex| {
            let [own, around @ ..] = table.stencils[vertex as usize].vertices();
            around.map(|other| if other == own { 0.0 } else { stiffness(positions, [own, other]) })
        }));
        self.cells.clear();
        self.cells.extend((0..).zip(&table.corners).filter_map(|(cell, corners)| {
            let corners = corners.map(index);
            corners.iter().any(|&index| index != NONE).then_some((cell, corners))
        }));
        let links = self.stiffnesses.iter().map(|links| links.iter().sum::<f32>());
        self.inverse_diagonal.clear();
        self.inverse_diagonal.extend(self.ridges.iter().zip(links).map(|(ridge, links)| ridge + links));
        for (cell, corners) in &self.cells {
            for (&corner, weight) in corners.iter().zip(table.diagonal(*cell as usize)) {
                if corner != NONE {
                    self.inverse_diagonal[corner as usize] += weight;
                }
            }
        }
        self.inverse_diagonal.iter_mut().for_each(|x| *x = x.recip());
        self.right.clear();
        self.right.resize(self.vertices.len(), [0.0; 4]);
    }

    /// Adds the displacement of a mesh vertex with the weights `weights` at the corners of a cell. The weights include
    /// the factor of the mean.
    pub(super) fn add(&mut self, corners: &[u32; 8], weights: &[f32; 8], displacement: [f32; 3]) {
        for (&corner, weight) in corners.iter().zip(weights) {
            let index = self.indices[corner as usize];
            if index != NONE {
                (0..3).for_each(|k| self.right[index as usize][k] += weight * displacement[k]);
            }
        }
    }

    /// Finds the displacements, and adds them to `positions`. Removes the displacements of mesh vertices.
    pub(super) fn displace(&mut self, table: &FlattenTable, positions: &mut [[f32; 3]]) {
        self.solve(table);
        for (&vertex, displacement) in self.vertices.iter().zip(&self.displacements) {
            (0..3).for_each(|k| positions[vertex as usize][k] += displacement[k]);
        }
        self.right.fill([0.0; 4]);
    }

    fn solve(&mut self, table: &FlattenTable) {
        let count = self.vertices.len();
        self.displacements.clear();
        self.displacements.resize(count, [0.0; 4]);
        self.residuals.clone_from(&self.right);
        self.directions.clear();
        let conditioned =
            self.residuals.iter().zip(&self.inverse_diagonal).map(|(r, inverse)| r.map(|x| x * inverse));
        self.directions.extend(conditioned);
        let mut square = dot(&self.residuals, &self.directions);
        for _ in 0..ITERATIONS {
            self.multiply_directions(table);
            let curvature = dot(&self.directions, &self.products);
            if curvature <= 0.0 {
                break;
            }
            let length = (square / curvature) as f32;
            for k in 0..count {
                for c in 0..3 {
                    self.displacements[k][c] += length * self.directions[k][c];
                    self.residuals[k][c] -= length * self.products[k][c];
                }
            }
            // The products are not needed any more.
            let conditioned =
                self.residuals.iter().zip(&self.inverse_diagonal).map(|(r, inverse)| r.map(|x| x * inverse));
            self.products.iter_mut().zip(conditioned).for_each(|(out, z)| *out = z);
            let next = dot(&self.residuals, &self.products);
            let ratio = (next / square) as f32;
            square = next;
            for (direction, z) in self.directions.iter_mut().zip(&self.products) {
                *direction = std::array::from_fn(|c| z[c] + ratio * direction[c]);
            }
            if square <= 0.0 {
                break;
            }
        }
    }

    /// Multiplies the matrix of the problem by the directions.
    fn multiply_directions(&mut self, table: &FlattenTable) {
        let Self { cells, neighbors, stiffnesses, ridges, directions, products, .. } = self;
        let get = |index: u32| if index == NONE { [0.0; 4] } else { directions[index as usize] };
        let links = neighbors.iter().zip(&*stiffnesses);
        products.clear();
        products.extend(directions.iter().zip(&*ridges).zip(links).map(
            |((own, ridge), (neighbors, links))| {
                let mut sum = own.map(|x| ridge * x);
                for (&neighbor, link) in neighbors.iter().zip(links) {
                    let other = get(neighbor);
                    (0..4).for_each(|k| sum[k] += link * (own[k] - other[k]));
                }
                sum
            },
        ));
        for (cell, corners) in cells {
            let sums = table.multiply(*cell as usize, &corners.map(get));
            for (&corner, sum) in corners.iter().zip(sums) {
                if corner != NONE {
                    (0..4).for_each(|k| products[corner as usize][k] += sum[k]);
                }
            }
        }
    }
}

/// Returns the weight of the difference of the displacements of two linked vertices.
fn stiffness(positions: &[[f32; 3]], link: [u32; 2]) -> f32 {
    let [a, b] = link.map(|vertex| Vector3::from(positions[vertex as usize]));
    BENDING / (b - a).norm_squared().max(LEAST_LENGTH * LEAST_LENGTH)
}

/// Returns the sum of the dot products of vectors.
fn dot(a: &[[f32; 4]], b: &[[f32; 4]]) -> f64 {
    let product = |(a, b): (&[f32; 4], &[f32; 4])| f64::from(a[0] * b[0] + a[1] * b[1] + a[2] * b[2]);
    a.iter().zip(b).map(product).sum()
}
