//! The smoothest field that moves the boundary by 1 along its normals.
//!
//! A wall is a piece of the boundary at a lattice vertex, with area m and unit normal n. The field v
//! minimizes
//!
//! ```text
//! sum over links |v_i - v_j|^2  +  STIFFNESS * sum over walls m ((n . v - 1)^2 + SLIDING |v - (n . v) n|^2)
//! ```
//!
//! With the walls of a surface mesh, the field does not depend on the steps of the lattice boundary. Edges
//! stay sharp, since a vertex that moves one wall along its normal may slide along the other wall.

use nalgebra::Vector3;

use super::walls::Wall;
use crate::volume::adjacency::Adjacency;

/// Weight of the walls relative to the links.
const STIFFNESS: f64 = 10.0;

/// Weight of the tangential motion of a wall, relative to its error along the normal. At 0 evenly stretched
/// shapes are corrected exactly, but long shapes with constrained ends slide along themselves. At 1 it is the
/// other way round.
const SLIDING: f64 = 0.3;

/// Tolerance: the norm of the residual relative to that of the right-hand side.
const TOLERANCE: f64 = 1e-2;

/// Maximum number of iterations; an approximate minimizer is sufficient.
const MAX_ITERATIONS: usize = 200;

/// Computes the field from `start` by conjugate gradients (Hestenes & Stiefel 1952) with Jacobi
/// preconditioner.
pub(super) fn fill(adjacency: &Adjacency, walls: &[Wall], start: Vec<Vector3<f64>>) -> Vec<Vector3<f64>> {
    let system = System::new(adjacency, walls);
    let mut field = start;
    let mut image = vec![Vector3::zeros(); field.len()];
    system.apply(&field, &mut image);
    let mut residual = system.right_hand_side();
    let threshold = TOLERANCE * TOLERANCE * residual.iter().map(Vector3::norm_squared).sum::<f64>();
    residual.iter_mut().zip(&image).for_each(|(r, image)| *r -= image);
    let mut direction = vec![Vector3::zeros(); field.len()];
    let mut previous = 1.0;
    for _ in 0..MAX_ITERATIONS {
        let (mut size, mut product) = (0.0, 0.0);
        for (r, diagonal) in residual.iter().zip(&system.diagonal) {
            let square = r.norm_squared();
            (size, product) = (size + square, product + square / diagonal);
        }
        if size <= threshold {
            break;
        }
        for ((direction, r), diagonal) in direction.iter_mut().zip(&residual).zip(&system.diagonal) {
            *direction = r / *diagonal + *direction * (product / previous);
        }
        previous = product;
        system.apply(&direction, &mut image);
        let step = product / direction.iter().zip(&image).map(|(d, image)| d.dot(image)).sum::<f64>();
        for (((field, r), d), image) in field.iter_mut().zip(&mut residual).zip(&direction).zip(&image) {
            *field += d * step;
            *r -= image * step;
        }
    }
    field
}

/// Linear system of the minimum: a symmetric matrix that is applied and never stored, and its diagonal.
struct System<'a> {
    adjacency: &'a Adjacency,
    walls: &'a [Wall],
    /// Upper bound of the diagonal for the three components of each vertex.
    diagonal: Vec<f64>,
}

impl<'a> System<'a> {
    fn new(adjacency: &'a Adjacency, walls: &'a [Wall]) -> Self {
        let mut diagonal: Vec<f64> =
            (0..adjacency.len()).map(|i| adjacency.linked(i).count() as f64).collect();
        for wall in walls {
            diagonal[wall.vertex as usize] += STIFFNESS * wall.area;
        }
        Self { adjacency, walls, diagonal }
    }

    /// Returns the right-hand side: walls that move by 1 along their normals.
    fn right_hand_side(&self) -> Vec<Vector3<f64>> {
        let mut sums = vec![Vector3::zeros(); self.diagonal.len()];
        for wall in self.walls {
            sums[wall.vertex as usize] += wall.normal * (STIFFNESS * wall.area);
        }
        sums
    }

    /// Writes the product of the matrix and `field` to `image`.
    fn apply(&self, field: &[Vector3<f64>], image: &mut [Vector3<f64>]) {
        for ((i, own), image) in field.iter().enumerate().zip(&mut *image) {
            *image = self.adjacency.linked(i).map(|j| own - field[j]).sum();
        }
        for wall in self.walls {
            let v = &field[wall.vertex as usize];
            let out = wall.normal * wall.normal.dot(v);
            image[wall.vertex as usize] += (out + (v - out) * SLIDING) * (STIFFNESS * wall.area);
        }
    }
}
