//! Contact patches. A patch consists of the touching samples that have the same nearest lattice vertex.
//!
//! A sample with n equally near vertices belongs to the patches of all n, and counts as the fraction 1/n in
//! each of them.
//!
//! The sample weight `s_i` of sample i is this fraction times the depth of the sample below the outer bound
//! of the skin (skin thickness minus signed distance). The contact point of a patch is the mean of the
//! positions of its samples, weighted by `s_i`. The position of a sample is a sum over the corners k of its
//! cell: the position of the corner times the trilinear coefficient `t_ik`. The contact point is therefore a
//! weighted mean of lattice vertices, in which vertex k has the weight `sum_i s_i t_ik / sum_i s_i`. With a smooth
//! skin, these weights distribute the impulses, and only the distances use the smooth positions.

use fearless_simd::{Select, Simd, SimdBase, f32x8, f64x4};
use nalgebra::Vector3;

use super::samples::SampleBlock;
use super::sides::SidedContact;
use crate::lattice::corner_sums;
use crate::simd::lanes::LANES;

/// Number of vertices in the neighborhood of a vertex: 3 x 3 x 3, x fastest. The vertex itself has index 13.
const NEIGHBORHOOD: usize = 27;

/// Offsets of the corners of a cell: corner k has the index `13 + OFFSETS[k] - OFFSETS[l]` in the
/// neighborhood of corner l.
const OFFSETS: [usize; 8] = [0, 1, 3, 4, 9, 10, 12, 13];

/// Touching samples that have the same nearest lattice vertex. They act as one contact point.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Patch {
    /// Bit mask of the vertices of the neighborhood that are in `rows` and `vertex_sums`.
    used: u32,
    /// Row of each vertex of the neighborhood: its index in `SampleCells::vertices`.
    rows: [u32; NEIGHBORHOOD],
    /// Sum of sample weight times trilinear coefficient over all samples, for each of these vertices.
    vertex_sums: [f64; NEIGHBORHOOD],
    /// Sum of the sample weights, in cells.
    total_weight: f64,
    /// Sum of sample weight times signed distance of the sample from the collider.
    distance_sum: f64,
    /// Depth of the deepest sample below the surface of the collider, in cells; negative outside.
    pub(super) deepest: f64,
    /// Whether the contact is not at the nearest surface of the shape: see `sides`.
    has_side: bool,
    /// Sums of sample weight times normal, and times distance before the step, if the search computes them.
    side_sums: (Vector3<f64>, f64),
    /// Normal of the deepest sample.
    deepest_normal: Vector3<f64>,
}

/// Surface of a patch whose samples came from one side of a shape.
#[derive(Clone, Copy, Debug)]
pub(super) struct PatchSide {
    /// Mean normal, a unit vector.
    pub(super) normal: Vector3<f64>,
    /// Mean signed distance before the step, in cells.
    pub(super) distance_before: f64,
}

/// Touching samples of one [`SampleBlock`] of eight samples, or of the first half of it.
pub(super) struct Touching<S: Simd, const HALVES: usize> {
    /// Number of touching samples. A sample with n equally near corners counts 1/n here, because it is in the
    /// blocks of all n corners.
    pub(super) count: f64,
    /// Depth of the deepest sample below the surface of the collider, in cells; negative outside.
    pub(super) deepest: f64,
    /// Sample weights, in cells; zero for samples that do not touch.
    sample_weights: [f64x4<S>; HALVES],
    /// Signed distances of the samples, in cells; zero for samples that do not touch.
    distances: [f64x4<S>; HALVES],
}

impl<S: Simd, const HALVES: usize> Touching<S, HALVES> {
    /// Selects the samples whose signed distance from the shape is at most `skin`, in cells.
    ///
    /// Returns `None` if no sample touches. A sample with a NaN distance does not touch. `fractions`: see
    /// `SampleBlock::fractions`.
    #[inline(always)]
    pub(super) fn within(
        simd: S,
        distances: [f64x4<S>; HALVES],
        fractions: &[f32; LANES],
        skin: f64,
    ) -> Option<Self> {
        let (zero, lowest) = (f64x4::splat(simd, 0.0), f64x4::splat(simd, f64::NEG_INFINITY));
        let (low, high) = simd.widen_f32x8(f32x8::load_array_ref(simd, fractions));
        let (mut sample_weights, mut touching) = ([zero; HALVES], [zero; HALVES]);
        let (mut count, mut deepest) = (zero, lowest);
        for (half, fraction) in [low, high].into_iter().enumerate().take(HALVES) {
            // Depth below the outer bound of the skin.
            let depth = f64x4::splat(simd, skin) - distances[half];
            let touches = depth.simd_ge(zero);
            sample_weights[half] = touches.select(depth * fraction, zero);
            touching[half] = touches.select(distances[half], zero);
            count += touches.select(fraction, zero);
            deepest = deepest.max(touches.select(depth, lowest));
        }
        let [a, b, c, d] = count.to_array();
        let count = (a + b) + (c + d);
        if count == 0.0 {
            return None;
        }
        // Until here `deepest` is a depth below the outer bound of the skin.
        let deepest = deepest.to_array().into_iter().fold(f64::NEG_INFINITY, f64::max) - skin;
        Some(Self { count, deepest, sample_weights, distances: touching })
    }
}

impl Patch {
    /// Creates a patch without samples.
    pub(super) fn new() -> Self {
        Self { deepest: f64::NEG_INFINITY, ..Self::default() }
    }

    /// Adds the touching samples of a block.
    ///
    /// * `corners`: rows of the corners of the block's cell.
    /// * `monomials`: the monomials 1, x, y, xy, ... of the positions of the block's samples in the cell.
    #[inline(always)]
    pub(super) fn add<S: Simd, const HALVES: usize>(
        &mut self,
        simd: S,
        touching: &Touching<S, HALVES>,
        block: &SampleBlock,
        corners: &[u32; 8],
        monomials: &[[f64x4<S>; 8]; HALVES],
    ) {
        self.deepest = self.deepest.max(touching.deepest);
        let mut sums = [0.0; 8];
        for k in 0..8 {
            let mut sum = f64x4::splat(simd, 0.0);
            for half in 0..HALVES {
                sum += monomials[half][k] * touching.sample_weights[half];
            }
            let [a, b, c, d] = sum.to_array();
            sums[k] = (a + b) + (c + d);
        }
        self.total_weight += sums[0];
        let mut sum = touching.sample_weights[0] * touching.distances[0];
        for half in 1..HALVES {
            sum += touching.sample_weights[half] * touching.distances[half];
        }
        let [a, b, c, d] = sum.to_array();
        self.distance_sum += (a + b) + (c + d);
        let sums = corner_sums(sums);
        let nearest = OFFSETS[usize::from(block.corner)];
        for k in 0..8 {
            // Skips sums at rounding level.
            if sums[k] > 1e-9 * self.total_weight {
                let index = 13 + OFFSETS[k] - nearest;
                self.used |= 1 << index;
                self.rows[index] = corners[k];
                self.vertex_sums[index] += sums[k];
            }
        }
    }

    /// Adds the sides of the touching samples of a block. `is_mesh`: whether the patch uses the mean normal in any
    /// case.
    pub(super) fn add_sides(
        &mut self,
        contacts: &[Option<SidedContact>; LANES],
        fractions: &[f32; LANES],
        skin: f64,
        is_mesh: bool,
    ) {
        for (contact, &fraction) in contacts.iter().zip(fractions) {
            let Some(contact) = contact else { continue };
            let weight = f64::from(fraction) * (skin - contact.distance);
            self.side_sums.0 += contact.normal * weight;
            self.side_sums.1 += contact.before * weight;
            self.has_side |= is_mesh || contact.has_passed;
            if -contact.distance >= self.deepest {
                self.deepest_normal = contact.normal;
            }
        }
    }

    /// Returns the surface of the patch if it is not the nearest one of the shape, or if the shape is a mesh.
    pub(super) fn side(&self) -> Option<PatchSide> {
        self.has_side.then(|| {
            let (normal, before) = self.side_sums;
            // The normals at an edge may cancel each other.
            let mean = (normal / self.total_weight).try_normalize(0.1);
            let normal = mean.unwrap_or(self.deepest_normal);
            PatchSide { normal, distance_before: before / self.total_weight }
        })
    }

    /// Returns the row of the nearest lattice vertex of the samples.
    pub(super) fn nearest_row(&self) -> u32 {
        self.rows[13]
    }

    /// Returns whether at least one sample of the patch has a weight above zero. A sample exactly at the
    /// outer bound of the skin has the weight zero.
    pub(super) fn has_weight(&self) -> bool {
        self.total_weight > 0.0
    }

    /// Returns the mean of the signed distances of the samples, weighted by the sample weights, in cells.
    pub(super) fn mean_distance(&self) -> f64 {
        self.distance_sum / self.total_weight
    }

    /// Returns the contact point as a weighted mean of lattice vertices.
    pub(super) fn vertices(&self) -> PatchVertices {
        let (mut count, mut list) = (0, [(0, 0.0); NEIGHBORHOOD]);
        let (mut remaining, scale) = (self.used, 1.0 / self.total_weight);
        while remaining != 0 {
            let k = remaining.trailing_zeros() as usize;
            remaining &= remaining - 1;
            list[count] = (self.rows[k], (self.vertex_sums[k] * scale) as f32);
            count += 1;
        }
        PatchVertices { count, list }
    }
}

/// The contact point of a patch as a weighted mean of lattice vertices.
pub(super) struct PatchVertices {
    count: usize,
    list: [(u32, f32); NEIGHBORHOOD],
}

impl PatchVertices {
    /// Returns pairs of row and weight.
    pub(super) fn iter(&self) -> impl Iterator<Item = (u32, f32)> + Clone + '_ {
        self.list[..self.count].iter().copied()
    }
}
