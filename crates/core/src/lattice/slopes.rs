//! Slopes of a deformed lattice: its derivatives at the vertices, by differences along the links.
//!
//! The smooth skin ([`smooth`](super::smooth)) is limited, as the slopes of finite-volume schemes are: where the links
//! of a vertex differ from its slopes by half of them or more, it changes to the trilinear skin. The *slope weight*
//! of a vertex, in `[0, 1]`, is the factor of the smooth skin.
//!
//! Only vertices with a stencil have a bend, and only their bends count for the slope weights of their neighbors.
//! They are the corners of the cells that contain mesh vertices, or for contact, samples. So where the mesh is
//! coarser than the cells, the slope weights for contact may be less than those for the display.

use std::ops::{Mul, Sub};
use std::sync::Arc;

use fearless_simd::{SimdBase, dispatch, f32x4};
use nalgebra::Vector3;

use super::Lattice;
use super::smooth::SmoothCoordinate;
use crate::simd::level;
use crate::simd::xyzx::Xyzx;

/// Bend up to which the slope weight is 1. See [`Stencil::bend`].
///
/// With these two limits, random and layered lattices have no folds beside the folds of the trilinear interpolation;
/// with 0.6 and 1.2 some have more folds.
const FULL_WEIGHT_BEND: f32 = 0.5;

/// Bend from which the slope weight is 0.
const ZERO_WEIGHT_BEND: f32 = 1.0;

/// A vertex and its neighbors along the axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Stencil {
    pub vertex: u32,
    /// The neighbors at -x, +x, -y, +y, -z, +z. A missing neighbor is replaced by the vertex itself.
    neighbors: [u32; 6],
    /// Factor of the difference of the two neighbors along each axis: 1/2 if both exist, otherwise 1.
    factors: [f32; 3],
}

impl Stencil {
    pub(crate) fn new(lattice: &Lattice, vertex: u32) -> Self {
        let neighbors = lattice.neighbors(vertex);
        let has_both = |axis: usize| neighbors[2 * axis].is_some() && neighbors[2 * axis + 1].is_some();
        Self {
            vertex,
            neighbors: neighbors.map(|neighbor| neighbor.unwrap_or(vertex)),
            factors: std::array::from_fn(|axis| if has_both(axis) { 0.5 } else { 1.0 }),
        }
    }

    /// Returns the stencil of a vertex without neighbors. Its slopes are zero.
    pub(crate) fn isolated(vertex: u32) -> Self {
        Self { vertex, neighbors: [vertex; 6], factors: [1.0; 3] }
    }

    /// Returns whether the vertex has no neighbors.
    pub(crate) fn is_isolated(&self) -> bool {
        self.neighbors == [self.vertex; 6]
    }

    /// Returns the slopes of the vertex: the derivative of `value` along x, y and z, per cell. Central differences if
    /// both neighbors along an axis exist, otherwise the difference along the only link.
    #[inline(always)]
    pub(crate) fn slopes<T>(&self, value: impl Fn(u32) -> T) -> [T; 3]
    where
        T: Sub<Output = T> + Mul<f32, Output = T>,
    {
        let [x0, x1, y0, y1, z0, z1] = self.neighbors;
        let [x, y, z] = self.factors;
        [(value(x1) - value(x0)) * x, (value(y1) - value(y0)) * y, (value(z1) - value(z0)) * z]
    }

    /// Returns the bend, in `[0, ∞]`: half of the greatest difference between the two links along an axis, relative to
    /// the slopes.
    ///
    /// The difference is taken back to the rest shape by the inverse of the slopes, so that an affine motion of the
    /// whole lattice does not change the bend. It is infinite if the slopes are inverted or flat. Along one axis, the
    /// derivative of the smooth skin at the middle of a cell is at least 1 minus 3/2 of the bend, so that it does not
    /// fold up to a bend of 2/3.
    #[inline(always)]
    pub(crate) fn bend(&self, position: impl Fn(u32) -> Vector3<f32>) -> f32 {
        let [x, y, z] = self.slopes(&position);
        let faces = [y.cross(&z), z.cross(&x), x.cross(&y)];
        let volume = x.dot(&faces[0]);
        let center = position(self.vertex);
        let scale = 0.5 / volume;
        let mut greatest_square = 0.0_f32;
        for axis in 0..3 {
            if self.factors[axis] == 0.5 {
                let [low, high] = [0, 1].map(|side| position(self.neighbors[2 * axis + side]));
                let difference = (high - center) - (center - low);
                let relative = faces.map(|face| face.dot(&difference) * scale);
                let square = Vector3::from(relative).norm_squared();
                greatest_square = if square <= greatest_square { greatest_square } else { square };
            }
        }
        // The comparisons are false for NaN.
        if volume > 0.0 && greatest_square.is_finite() { greatest_square.sqrt() } else { f32::INFINITY }
    }

    /// Returns the slope weight of the vertex, in `[0, 1]`, from the bends of the vertices.
    ///
    /// The greatest bend of the vertex and its neighbors counts: a slope does not depend on the bend at the
    /// other end of a link.
    #[inline(always)]
    pub(crate) fn slope_weight(&self, bend: impl Fn(u32) -> f32) -> f32 {
        let mut greatest = bend(self.vertex);
        for neighbor in self.neighbors {
            greatest = greatest.max(bend(neighbor));
        }
        SmoothCoordinate::new(
            ((ZERO_WEIGHT_BEND - greatest) / (ZERO_WEIGHT_BEND - FULL_WEIGHT_BEND)).clamp(0.0, 1.0),
        )
        .s
    }

    /// Returns the stencil with other numbers for the vertices.
    pub(crate) fn renumbered(self, number: impl Fn(u32) -> u32) -> Self {
        Self { vertex: number(self.vertex), neighbors: self.neighbors.map(number), ..self }
    }

    /// Returns the vertex and its neighbors. A missing neighbor is replaced by the vertex itself.
    pub(crate) fn vertices(&self) -> [u32; 7] {
        let [x0, x1, y0, y1, z0, z1] = self.neighbors;
        [self.vertex, x0, x1, y0, y1, z0, z1]
    }
}

/// The stencils of the vertices whose slopes an embedding needs: the corners of the cells that contain points.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Smoothing {
    /// By increasing vertex.
    stencils: Arc<[Stencil]>,
    /// Number of vertices of the lattice.
    vertices: usize,
}

/// Slopes of the lattice at one time, `(x, y, z, x)` each, and the slope weights.
///
/// Arrays have one entry per lattice vertex. Entries of vertices without a stencil are not used.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Slopes<'a> {
    pub slopes: &'a [[Xyzx; 3]],
    pub slope_weights: &'a [f32],
}

/// Slope weights of a lattice, one number in `[0, 1]` per lattice vertex.
#[derive(Clone, Debug, Default)]
pub(crate) struct SlopeWeights {
    bends: Vec<f32>,
    values: Vec<f32>,
}

impl SlopeWeights {
    /// Returns the slope weight of each lattice vertex; empty before the first update.
    pub(crate) fn values(&self) -> &[f32] {
        &self.values
    }

    /// Returns the memory in bytes.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&*self.bends) + size_of_val(&*self.values)
    }
}

impl Smoothing {
    /// Finds the stencils of the corners of cells.
    pub(super) fn new(lattice: &Lattice, corners: impl Iterator<Item = [u32; 8]>) -> Self {
        let mut is_corner = vec![false; lattice.len()];
        corners.flatten().for_each(|vertex| is_corner[vertex as usize] = true);
        let vertices = (0..).zip(&is_corner).filter(|(_, is_corner)| **is_corner);
        let stencils = vertices.map(|(vertex, _)| Stencil::new(lattice, vertex)).collect();
        Self { stencils, vertices: lattice.len() }
    }

    /// Returns the stencils, by increasing vertex.
    pub(crate) fn stencils(&self) -> &[Stencil] {
        &self.stencils
    }

    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.stencils)
    }

    /// Computes the slope weights of the lattice `positions`.
    pub(crate) fn update_slope_weights(&self, positions: &[[f32; 3]], slope_weights: &mut SlopeWeights) {
        let SlopeWeights { bends, values } = slope_weights;
        // The bends of vertices without a stencil do not count: they are not corners of cells with points.
        bends.clear();
        bends.resize(self.vertices, 0.0);
        values.resize(self.vertices, 1.0);
        for stencil in &*self.stencils {
            bends[stencil.vertex as usize] = stencil.bend(|vertex| positions[vertex as usize].into());
        }
        for stencil in &*self.stencils {
            values[stencil.vertex as usize] = stencil.slope_weight(|vertex| bends[vertex as usize]);
        }
    }

    /// Writes the slopes of the lattice `positions`, `(x, y, z, x)` of each vertex, to `slopes`.
    pub(crate) fn update_slopes(&self, positions: &[Xyzx], slopes: &mut Vec<[Xyzx; 3]>) {
        slopes.resize(self.vertices, [[0.0; 4]; 3]);
        dispatch!(level(), simd => {
            for stencil in &*self.stencils {
                let found = stencil.slopes(|vertex| f32x4::load_array_ref(simd, &positions[vertex as usize]));
                for (slope, out) in found.into_iter().zip(&mut slopes[stencil.vertex as usize]) {
                    slope.store_array(out);
                }
            }
        });
    }
}
