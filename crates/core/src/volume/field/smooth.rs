//! The smoothest field that moves a boundary by 1 along its normals.
//!
//! It minimises, with m the area of a wall and n its normal,
//!
//! ```text
//! sum over links |v_i - v_j|^2  +  STIFFNESS * sum over walls m ((n . v - 1)^2 + SLIDING |v - (n . v) n|^2)
//! ```
//!
//! The stairs of the lattice do not show where the walls are those of a surface, and edges stay sharp, since what moves
//! one wall along its normal may slide along the other.

use nalgebra::Vector3;

use super::walls::Wall;
use crate::volume::adjacency::Adjacency;

/// How much the walls weigh beside the links.
const STIFFNESS: f64 = 10.0;

/// How much less it costs a wall to slide than to be left behind. At 0 shapes that are stretched evenly come out
/// exactly, and long ones that are held at their ends slide along themselves; at 1 it is the other way round.
const SLIDING: f64 = 0.3;

/// The part of the residual at which the field is good enough.
const ACCURACY: f64 = 1e-2;

/// The most steps: a field that is only nearly the smoothest serves as well.
const STEPS: usize = 200;

/// By conjugate gradients (Hestenes & Stiefel 1952) with the diagonal as preconditioner, from the field `start`.
pub(super) fn fill(adjacency: &Adjacency, walls: &[Wall], start: Vec<Vector3<f64>>) -> Vec<Vector3<f64>> {
    let system = System::new(adjacency, walls);
    let mut field = start;
    let mut image = vec![Vector3::zeros(); field.len()];
    system.apply(&field, &mut image);
    let mut residual = system.wanted();
    let enough = ACCURACY * ACCURACY * residual.iter().map(Vector3::norm_squared).sum::<f64>();
    residual.iter_mut().zip(&image).for_each(|(r, image)| *r -= image);
    let mut along = vec![Vector3::zeros(); field.len()];
    let mut before = 1.0;
    for _ in 0..STEPS {
        let (mut size, mut product) = (0.0, 0.0);
        for (r, diagonal) in residual.iter().zip(&system.diagonal) {
            let square = r.norm_squared();
            (size, product) = (size + square, product + square / diagonal);
        }
        if size <= enough {
            break;
        }
        for ((along, r), diagonal) in along.iter_mut().zip(&residual).zip(&system.diagonal) {
            *along = r / *diagonal + *along * (product / before);
        }
        before = product;
        system.apply(&along, &mut image);
        let step = product / along.iter().zip(&image).map(|(along, image)| along.dot(image)).sum::<f64>();
        for (((field, r), along), image) in field.iter_mut().zip(&mut residual).zip(&along).zip(&image) {
            *field += along * step;
            *r -= image * step;
        }
    }
    field
}

/// The derivative of what is minimised: a symmetric matrix, never stored, and its diagonal.
struct System<'a> {
    adjacency: &'a Adjacency,
    walls: &'a [Wall],
    /// Of each vertex, a bound for all three components.
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

    /// The right-hand side: walls that move by 1.
    fn wanted(&self) -> Vec<Vector3<f64>> {
        let mut wanted = vec![Vector3::zeros(); self.diagonal.len()];
        for wall in self.walls {
            wanted[wall.vertex as usize] += wall.normal * (STIFFNESS * wall.area);
        }
        wanted
    }

    /// The image of a field.
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
