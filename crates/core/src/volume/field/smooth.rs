//! Computes the smoothest field that moves the boundary by 1 along its normals.
//!
//! A wall is a piece of the boundary at a lattice vertex. The field has a vector `v_i` at each vertex `i` and
//! minimizes the sum of
//!
//! ```text
//! for each link between vertices i and j:  |v_i - v_j|^2
//! for each wall at a vertex i:             STIFFNESS m ((n . v_i - 1)^2 + SLIDING |v_i - (n . v_i) n|^2)
//! ```
//!
//! where `m` is the area of the wall in faces of a cell, and `n` its outward unit normal. The first term of a
//! wall is the error along its normal, and the second term is its tangential motion.
//!
//! If the walls are pieces of a surface mesh, the field does not depend on the staircase shape of the lattice
//! boundary. Edges of the surface stay sharp: a vertex beside an edge has several walls, and may slide along
//! each wall to move the other walls along their normals.

use nalgebra::Vector3;

use super::walls::Wall;
use crate::volume::adjacency::Adjacency;

/// Weight of the walls relative to the links.
const STIFFNESS: f64 = 10.0;

/// Weight of the tangential motion of a wall, relative to the error along its normal.
///
/// With 0, evenly stretched shapes are corrected exactly, but long shapes with constrained ends slide along
/// themselves. With 1, long shapes do not slide, but evenly stretched shapes are not corrected exactly.
const SLIDING: f64 = 0.3;

/// Tolerance for the norm of the residual, relative to the norm of the right-hand side.
const TOLERANCE: f64 = 1e-2;

/// Maximum number of iterations; an approximate minimizer is sufficient.
const MAX_ITERATIONS: usize = 200;

/// Computes the field by conjugate gradients (Hestenes & Stiefel 1952) with Jacobi preconditioner, from the
/// initial value `start`.
pub(super) fn fill(adjacency: &Adjacency, walls: &[Wall], start: Vec<Vector3<f64>>) -> Vec<Vector3<f64>> {
    let system = System::new(adjacency, walls);
    let mut field = start;
    let mut image = vec![Vector3::zeros(); field.len()];
    system.apply(&field, &mut image);
    let mut residual = system.right_hand_side();
    let threshold = TOLERANCE * TOLERANCE * residual.iter().map(Vector3::norm_squared).sum::<f64>();
    residual.iter_mut().zip(&image).for_each(|(r, image)| *r -= image);
    let mut direction = vec![Vector3::zeros(); field.len()];
    let mut previous_product = 1.0;
    for _ in 0..MAX_ITERATIONS {
        // Squared norm of the residual, and its scalar product with the preconditioned residual.
        let (mut norm_squared, mut product) = (0.0, 0.0);
        for (r, diagonal) in residual.iter().zip(&system.diagonal) {
            let length_squared = r.norm_squared();
            (norm_squared, product) = (norm_squared + length_squared, product + length_squared / diagonal);
        }
        if norm_squared <= threshold {
            break;
        }
        for ((direction, r), diagonal) in direction.iter_mut().zip(&residual).zip(&system.diagonal) {
            *direction = r / *diagonal + *direction * (product / previous_product);
        }
        previous_product = product;
        system.apply(&direction, &mut image);
        let step = product / direction.iter().zip(&image).map(|(d, image)| d.dot(image)).sum::<f64>();
        for (((field, r), d), image) in field.iter_mut().zip(&mut residual).zip(&direction).zip(&image) {
            *field += d * step;
            *r -= image * step;
        }
    }
    field
}

/// Linear system whose solution is the minimum. Its symmetric matrix is applied and never stored.
struct System<'a> {
    adjacency: &'a Adjacency,
    walls: &'a [Wall],
    /// Upper bound of the three diagonal elements of each vertex.
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

    /// Returns the right-hand side, from the terms that move the walls by 1 along their normals.
    fn right_hand_side(&self) -> Vec<Vector3<f64>> {
        let mut sums = vec![Vector3::zeros(); self.diagonal.len()];
        for wall in self.walls {
            sums[wall.vertex as usize] += wall.normal * (STIFFNESS * wall.area);
        }
        sums
    }

    /// Writes the product of the matrix and `field` to `image`.
    fn apply(&self, field: &[Vector3<f64>], image: &mut [Vector3<f64>]) {
        for ((i, v), image) in field.iter().enumerate().zip(&mut *image) {
            *image = self.adjacency.linked(i).map(|j| v - field[j]).sum();
        }
        for wall in self.walls {
            let v = &field[wall.vertex as usize];
            let normal_part = wall.normal * wall.normal.dot(v);
            image[wall.vertex as usize] +=
                (normal_part + (v - normal_part) * SLIDING) * (STIFFNESS * wall.area);
        }
    }
}
