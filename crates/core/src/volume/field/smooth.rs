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
//!
//! Vectors are stored in [`Blocks`], so that sums over links run on eight vertices at a time. Scalar products are
//! summed in f64.

use fearless_simd::{Simd, SimdBase, dispatch, f32x8, f64x4};
use nalgebra::{Matrix3, Vector3};

use super::walls::Wall;
use crate::lattice::Lattice;
use crate::simd::lanes::{Block, Row, block_and_lane, load, store};
use crate::simd::level;
use crate::simd::vector::Product;
use crate::volume::adjacency::Adjacency;
use crate::volume::blocks::Blocks;

/// Weight of the walls relative to the links.
const STIFFNESS: f64 = 10.0;

/// Weight of the tangential motion of a wall relative to the near field, in units of the weight of the error along
/// its normal.
const SLIDING: f32 = 1.0;

/// Decay of the near field, per thickness. With 0, evenly stretched shapes are corrected best, but long shapes
/// with constrained ends slide along themselves. Large values suppress all tangential motion.
const DECAY: f64 = 2.0;

/// Tolerance for the norm of the residual, relative to the norm of the right-hand side.
const TOLERANCE: f64 = 1e-2;

/// Maximum number of iterations; an approximate minimizer is sufficient.
const MAX_ITERATIONS: usize = 200;

/// One vector for each vertex, in [`Blocks`].
type Vectors = Vec<Block<3>>;

/// Computes the field. `thickness`: thickness of each component; see [`Field`](super::Field). `start`: initial
/// value.
pub(super) fn fill(
    (lattice, adjacency): (&Lattice, &Adjacency),
    thickness: &[f64],
    walls: &[Wall],
    start: &[Vector3<f64>],
) -> Vec<[f32; 3]> {
    let blocks = Blocks::new(lattice, adjacency);
    let mut field = Vec::new();
    blocks.resize(&mut field);
    for (vector, &slot) in start.iter().zip(&blocks.slots) {
        add(&mut field, slot, vector.map(|x| x as f32));
    }
    let decay = |component: usize| (DECAY / thickness[component]).powi(2) as f32;
    System::new(&blocks, walls, decay, None).solve(&mut field);
    System::new(&blocks, walls, |_| 0.0, Some(&field)).solve(&mut field);
    blocks.slots.iter().map(|&slot| get(&field, slot).into()).collect()
}

/// Returns the vector at a slot.
fn get(vectors: &[Block<3>], slot: u32) -> Vector3<f32> {
    let (block, lane) = block_and_lane(slot);
    Vector3::from(vectors[block].map(|row| row[lane]))
}

/// Adds a vector at a slot.
fn add(vectors: &mut [Block<3>], slot: u32, vector: Vector3<f32>) {
    let (block, lane) = block_and_lane(slot);
    for c in 0..3 {
        vectors[block][c][lane] += vector[c];
    }
}

/// Linear system whose solution is the minimum. Of its symmetric matrix, only the part of the walls is stored.
struct System<'a> {
    blocks: &'a Blocks,
    /// For each vertex: the number of links plus the weight of the square of its vector, and the inverse of an upper
    /// bound of its three diagonal elements; both are 0 in lanes without a vertex.
    diagonal: Vec<Block<2>>,
    /// Slot and matrix of the walls of a vertex, or of some of them.
    walls: Vec<(u32, Matrix3<f32>)>,
    right_hand_side: Vectors,
}

/// Squared norm of the residual, and its scalar product with the preconditioned residual.
#[derive(Clone, Copy)]
struct Norms {
    squared: f64,
    preconditioned: f64,
}

impl<'a> System<'a> {
    /// Creates a system. `decay`: weight of the square of each vector of a component. `near`: the near field; `None` if
    /// it is the unknown of the system.
    fn new(
        blocks: &'a Blocks,
        all_walls: &[Wall],
        decay: impl Fn(usize) -> f32,
        near: Option<&Vectors>,
    ) -> Self {
        let mut diagonal = vec![[Row::ZERO; 2]; blocks.len()];
        dispatch!(level(), simd => {
            for (block, rows) in diagonal.iter_mut().enumerate() {
                let decay = f32x8::splat(simd, decay(blocks.components[block] as usize));
                let weight = blocks.filled(simd, block, blocks.links(simd, block) + decay);
                store([weight; 2], rows);
            }
        });
        let mut right_hand_side = vec![[Row::ZERO; 3]; blocks.len() + 1];
        let mut walls: Vec<(u32, Matrix3<f32>)> = Vec::new();
        for Wall { vertex, normal, area } in all_walls {
            let (slot, normal) = (blocks.slots[*vertex as usize], normal.map(|x| x as f32));
            let weight = (STIFFNESS * area) as f32;
            let (block, lane) = block_and_lane(slot);
            diagonal[block][1][lane] += weight;
            let along_normal = normal * normal.transpose();
            let (mut matrix, mut target) = (along_normal, normal);
            if let Some(near) = near {
                let tangential = (Matrix3::identity() - along_normal) * SLIDING;
                (matrix, target) = (matrix + tangential, target + tangential * get(near, slot));
            }
            add(&mut right_hand_side, slot, target * weight);
            match walls.last_mut() {
                Some((last, sum)) if *last == slot => *sum += matrix * weight,
                _ => walls.push((slot, matrix * weight)),
            }
        }
        for row in diagonal.iter_mut().flat_map(|rows| rows[1].iter_mut()).filter(|x| **x > 0.0) {
            *row = row.recip();
        }
        Self { blocks, diagonal, walls, right_hand_side }
    }

    /// Solves the system by conjugate gradients (Hestenes & Stiefel 1952) with Jacobi preconditioner, from the present
    /// value of `field`.
    fn solve(self, field: &mut Vectors) {
        let [mut direction, mut image] = [(); 2].map(|()| vec![[Row::ZERO; 3]; field.len()]);
        let mut residual = self.right_hand_side.clone();
        let advance = |step: f64,
                       direction: &Vectors,
                       image: &Vectors,
                       field: &mut Vectors,
                       residual: &mut Vectors| {
            dispatch!(level(), simd => self.advance(simd, step as f32, (direction, image), (field, residual)))
        };
        let right = advance(0.0, &direction, &image, field, &mut residual);
        self.apply(field, &mut image);
        let mut norms = advance(1.0, &direction, &image, field, &mut residual);
        let mut previous = f64::INFINITY;
        for _ in 0..MAX_ITERATIONS {
            if norms.squared <= TOLERANCE * TOLERANCE * right.squared {
                break;
            }
            let factor = (norms.preconditioned / previous) as f32;
            previous = norms.preconditioned;
            dispatch!(level(), simd => self.turn(simd, factor, &residual, &mut direction));
            let product = self.apply(&direction, &mut image);
            // Squares of vectors shorter than 1e-23 are 0 in f32.
            if product <= 0.0 {
                break;
            }
            norms = advance(previous / product, &direction, &image, field, &mut residual);
        }
    }

    /// Writes the product of the matrix and `vectors` to `image`. Returns the scalar product of both.
    fn apply(&self, vectors: &Vectors, image: &mut Vectors) -> f64 {
        let mut product = dispatch!(level(), simd => self.apply_links(simd, vectors, image));
        for (slot, matrix) in &self.walls {
            let vector = get(vectors, *slot);
            let added = matrix * vector;
            add(image, *slot, added);
            product += f64::from(vector.dot(&added));
        }
        product
    }

    /// Does as [`apply`](Self::apply), without the walls.
    #[inline(always)]
    fn apply_links<S: Simd>(&self, simd: S, vectors: &Vectors, image: &mut Vectors) -> f64 {
        let mut total = Sum::zero(simd);
        for block in 0..self.blocks.len() {
            let [weight, _] = load(simd, &self.diagonal[block]);
            let mut rows: [f32x8<S>; 3] = load(simd, &vectors[block]);
            let mut products = f32x8::splat(simd, 0.0);
            for c in 0..3 {
                let links = self.blocks.sum(simd, block, (vectors, c));
                let row = self.blocks.filled(simd, block, weight.times_minus(rows[c], links));
                products = row.times_plus(rows[c], products);
                rows[c] = row;
            }
            total.add(simd, products);
            store(rows, &mut image[block]);
        }
        total.value()
    }

    /// Turns the direction: `direction = factor direction + preconditioned residual`.
    #[inline(always)]
    fn turn<S: Simd>(&self, simd: S, factor: f32, residual: &Vectors, direction: &mut Vectors) {
        let factor = f32x8::splat(simd, factor);
        for ((diagonal, residual), direction) in self.diagonal.iter().zip(residual).zip(direction) {
            let [_, inverse] = load(simd, diagonal);
            let (residual, mut rows): ([f32x8<S>; 3], [f32x8<S>; 3]) =
                (load(simd, residual), load(simd, direction));
            for c in 0..3 {
                rows[c] = rows[c].times_plus(factor, residual[c] * inverse);
            }
            store(rows, direction);
        }
    }

    /// Adds `step direction` to the field and subtracts `step image` from the residual. Returns the norms of the
    /// residual.
    #[inline(always)]
    fn advance<S: Simd>(
        &self,
        simd: S,
        step: f32,
        (direction, image): (&Vectors, &Vectors),
        (field, residual): (&mut Vectors, &mut Vectors),
    ) -> Norms {
        let step = f32x8::splat(simd, step);
        let (mut squared, mut preconditioned) = (Sum::zero(simd), Sum::zero(simd));
        let changes = self.diagonal.iter().zip(direction.iter().zip(image));
        for ((diagonal, (direction, image)), (field, residual)) in changes.zip(field.iter_mut().zip(residual))
        {
            let [_, inverse] = load(simd, diagonal);
            let (direction, image): ([f32x8<S>; 3], [f32x8<S>; 3]) =
                (load(simd, direction), load(simd, image));
            let (mut v, mut r): ([f32x8<S>; 3], [f32x8<S>; 3]) = (load(simd, field), load(simd, residual));
            let mut squares = f32x8::splat(simd, 0.0);
            for c in 0..3 {
                v[c] = direction[c].times_plus(step, v[c]);
                r[c] -= image[c] * step;
                squares = r[c].times_plus(r[c], squares);
            }
            store(v, field);
            store(r, residual);
            squared.add(simd, squares);
            preconditioned.add(simd, squares * inverse);
        }
        Norms { squared: squared.value(), preconditioned: preconditioned.value() }
    }
}

/// Sum of rows in f64.
struct Sum<S: Simd>([f64x4<S>; 2]);

impl<S: Simd> Sum<S> {
    #[inline(always)]
    fn zero(simd: S) -> Self {
        Self([f64x4::splat(simd, 0.0); 2])
    }

    #[inline(always)]
    fn add(&mut self, simd: S, row: f32x8<S>) {
        let (low, high) = simd.widen_f32x8(row);
        self.0[0] += low;
        self.0[1] += high;
    }

    #[inline(always)]
    fn value(self) -> f64 {
        (self.0[0] + self.0[1]).reduce_sum()
    }
}
