//! Computes the smoothest field that moves the boundary by 1 along its normals.
//!
//! A wall is a piece of the boundary at a lattice vertex. Two fields are computed. Each has a vector `v_i` at
//! each vertex `i` and minimizes a sum of terms of links, walls and vertices:
//!
//! ```text
//! both fields, for each link between vertices i and j:  |v_i - v_j|^2
//! both fields, for each wall at a vertex i:             STIFFNESS m (n . v_i - 1)^2
//! near field u, for each vertex i:                      (DECAY / thickness)^2 |u_i|^2
//! field v, for each wall at a vertex i:                 STIFFNESS m SLIDING |t_i|^2,
//!                                                       t_i = (v_i - u_i) - (n . (v_i - u_i)) n
//! ```
//!
//! where `m` is the area of the wall in faces of a cell, and `n` its outward unit normal. The motion that a wall
//! demands reaches about half of the thickness into the near field. The near field thus has the tangential
//! motion of a wall by which other walls nearby move along their normals: beside the edges of a bar, the sides
//! contract. It does not have the motion along a long body by which distant walls, such as its ends, would move.
//! The field `v` takes its tangential motion at the walls from the near field, and is smooth in between.
//!
//! If the walls are pieces of a surface mesh, the field does not depend on the staircase shape of the lattice
//! boundary. Edges of the surface stay sharp: a vertex beside an edge has several walls.

use nalgebra::Vector3;

use super::walls::Wall;
use crate::volume::adjacency::Adjacency;

/// Weight of the walls relative to the links.
const STIFFNESS: f64 = 10.0;

/// Weight of the tangential motion of a wall relative to the near field, in units of the weight of the error along
/// its normal.
const SLIDING: f64 = 1.0;

/// Decay of the near field, per thickness. With 0, evenly stretched shapes are corrected best, but long shapes
/// with constrained ends slide along themselves. Large values suppress all tangential motion.
const DECAY: f64 = 2.0;

/// Tolerance for the norm of the residual, relative to the norm of the right-hand side.
const TOLERANCE: f64 = 1e-2;

/// Maximum number of iterations; an approximate minimizer is sufficient.
const MAX_ITERATIONS: usize = 200;

/// Computes the field. `thickness`: thickness of each component; see [`Field`](super::Field). `start`: initial
/// value.
pub(super) fn fill(
    adjacency: &Adjacency,
    thickness: &[f64],
    walls: &[Wall],
    start: Vec<Vector3<f64>>,
) -> Vec<Vector3<f64>> {
    let decay = |vertex| (DECAY / thickness[adjacency.component(vertex)]).powi(2);
    let near = solve(&System::new(adjacency, walls, &decay, None), start);
    solve(&System::new(adjacency, walls, &|_| 0.0, Some(&near)), near.clone())
}

/// Solves a system by conjugate gradients (Hestenes & Stiefel 1952) with Jacobi preconditioner, from the initial
/// value `start`.
fn solve(system: &System<'_>, start: Vec<Vector3<f64>>) -> Vec<Vector3<f64>> {
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
    /// Weight of the square of each vector.
    decay: &'a dyn Fn(usize) -> f64,
    /// The near field; `None` if it is the unknown of the system.
    near: Option<&'a [Vector3<f64>]>,
    /// Upper bound of the three diagonal elements of each vertex.
    diagonal: Vec<f64>,
}

impl<'a> System<'a> {
    fn new(
        adjacency: &'a Adjacency,
        walls: &'a [Wall],
        decay: &'a dyn Fn(usize) -> f64,
        near: Option<&'a [Vector3<f64>]>,
    ) -> Self {
        let vertices = 0..adjacency.len();
        let mut diagonal: Vec<f64> =
            vertices.map(|i| adjacency.linked(i).count() as f64 + decay(i)).collect();
        for wall in walls {
            diagonal[wall.vertex as usize] += STIFFNESS * wall.area;
        }
        Self { adjacency, walls, decay, near, diagonal }
    }

    /// Returns the right-hand side: the motion of the walls by 1 along their normals, and the tangential motion
    /// of the near field.
    fn right_hand_side(&self) -> Vec<Vector3<f64>> {
        let mut sums = vec![Vector3::zeros(); self.diagonal.len()];
        for Wall { vertex, normal, area } in self.walls {
            let vertex = *vertex as usize;
            let tangential = self.near.map_or(Vector3::zeros(), |near| tangential(&near[vertex], normal));
            sums[vertex] += (normal + tangential * SLIDING) * (STIFFNESS * area);
        }
        sums
    }

    /// Writes the product of the matrix and `field` to `image`.
    fn apply(&self, field: &[Vector3<f64>], image: &mut [Vector3<f64>]) {
        for ((i, v), image) in field.iter().enumerate().zip(&mut *image) {
            let differences: Vector3<f64> = self.adjacency.linked(i).map(|j| v - field[j]).sum();
            *image = differences + v * (self.decay)(i);
        }
        let sliding = if self.near.is_some() { SLIDING } else { 0.0 };
        for Wall { vertex, normal, area } in self.walls {
            let v = &field[*vertex as usize];
            let along_normal = normal * normal.dot(v);
            image[*vertex as usize] += (along_normal + tangential(v, normal) * sliding) * (STIFFNESS * area);
        }
    }
}

/// Returns the part of `v` perpendicular to the unit vector `normal`.
fn tangential(v: &Vector3<f64>, normal: &Vector3<f64>) -> Vector3<f64> {
    v - normal * normal.dot(v)
}
