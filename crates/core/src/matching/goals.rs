//! Computes the rigid motion of each region, and the goal position of each vertex.
//!
//! m, x and x⁰ are the mass, position and rest position of a vertex, n is the number of regions that contain
//! it, and m/n is its region weight. M = Σ m/n, c and c⁰ are the mass, center of mass and rest centroid of a
//! region; sums are over the vertices of the region. The rigid motion of a region is given by c and by the
//! rotation R of A = M⁻¹ Σ m/n (x - c) (x⁰ - c⁰)ᵀ, where R maximizes tr(Rᵀ A). The goal position g of a
//! vertex is the mean of R (x⁰ - c⁰) + c over the n regions that contain the vertex (Müller et al. 2005, Eqs.
//! (3) to (7); Rivers & James 2007, Eqs. (5) and (6)). Positions are in cells, so that the rest offset
//! between two vertices is a number of links along each axis.
//!
//! The cascade computes the sums of a region: S = Σ m/n x and, with the rest offset (i, j, k) of a vertex
//! from the center vertex of the region, Sx = Σ i m/n x, Sy = Σ j m/n x and Sz = Σ k m/n x. d is c⁰ relative
//! to the center vertex.

use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};

use fearless_simd::{Select, Simd, SimdBase, SimdFloat, SimdMask, f32x8, f32x16};

use super::cascade::{RegionTransform, VertexUpdate};
use super::factors::Factors;
use super::rotation::{columns, newton};
use crate::simd::lanes::{Block, LANES, Lanes, load, load_two, split_two, store};
use crate::simd::vector::Product;

/// Means over a region, weighted by m/n, of a vector field: the positions or the velocities of the vertices.
pub(crate) struct Means<V> {
    /// S/M. If the field is the positions, this is the center of mass; if the field is the velocities, it is
    /// the velocity of the center of mass.
    pub mean: [V; 3],
    /// The columns of [Sx Sy Sz]/M - (S/M) dᵀ: the first moments of the field with respect to the rest
    /// offsets from the rest centroid.
    pub central: [V; 9],
    /// Rest centroid relative to the center vertex of the region, in cells.
    pub d: [V; 3],
}

impl<V> Means<V> {
    /// Computes the means from the constants (1/M, d) and the sums (S, Sx, Sy, Sz) of regions.
    #[inline(always)]
    pub(crate) fn new<S: Simd>([inverse_mass, d0, d1, d2]: [V; 4], sums: [V; 12]) -> Self
    where
        V: SimdFloat<S, Element = f32>,
    {
        let d = [d0, d1, d2];
        let mean = [sums[0] * inverse_mass, sums[1] * inverse_mass, sums[2] * inverse_mass];
        let mut central = [inverse_mass; 9];
        for column in 0..3 {
            for row in 0..3 {
                let i = 3 * column + row;
                central[i] = (-mean[row]).times_plus(d[column], sums[3 + i] * inverse_mass);
            }
        }
        Self { mean, central, d }
    }

    /// As [`Means::new`] for cells: d = 0.
    #[inline(always)]
    fn of_cells<S: Simd>(simd: S, inverse_mass: V, sums: [V; 12]) -> Self
    where
        V: SimdFloat<S, Element = f32>,
    {
        let mut central = [inverse_mass; 9];
        for i in 0..9 {
            central[i] = sums[3 + i] * inverse_mass;
        }
        let mean = [sums[0] * inverse_mass, sums[1] * inverse_mass, sums[2] * inverse_mass];
        Self { mean, central, d: [V::splat(simd, 0.0); 3] }
    }
}

/// The region transform that fits a rigid motion to each region. Its memory is the rotation quaternion, which
/// is first the warm start and then the result.
pub(super) struct FitRotations<'a> {
    /// 1/M and d of each region.
    pub(super) constants: &'a Lanes<4>,
    /// Whether the regions are cells, which have the same constants.
    pub(super) are_cells: bool,
    /// As [`Regions::factors`](super::Regions::factors).
    pub(super) factors: Option<&'a Factors>,
    /// For each block of eight regions, the bit mask of the lanes with a region.
    pub(super) occupied: &'a [u8],
    /// Half-width of the regions in cells.
    pub(super) half_width: f32,
    /// Counts the rotations for which Newton's method does not converge.
    pub(super) unconverged: &'a AtomicUsize,
    /// Receives the sums of the elastic potential. `None` if the potential is not needed.
    pub(super) potential: Option<&'a PotentialSums>,
}

impl RegionTransform<&mut [Block<4>]> for FitRotations<'_> {
    #[inline(always)]
    fn apply<S: Simd>(&self, simd: S, first: usize, sums: &mut [Block<12>], quaternions: &mut [Block<4>]) {
        for index in (0..sums.len()).step_by(2) {
            let pair = Pair::new(first, index, sums.len());
            let (inverse_mass, means) = self.means(simd, pair, sums);
            let q = self.rotate(simd, pair, (means.mean, means.central), quaternions);
            let r = columns(simd, q);
            if let Some(potential) = self.potential {
                potential.store(self, pair, inverse_mass, means.mean, twice_trace(&means.central, &r));
            }
            self.store(simd, pair, (means.mean, means.d), r, sums);
        }
    }
}

/// Two blocks that are computed at once.
#[derive(Clone, Copy)]
pub(super) struct Pair {
    /// Indices of the blocks in the layout.
    pub(super) blocks: [usize; 2],
    /// Indices of the blocks in the arrays of a call.
    pub(super) indices: [usize; 2],
}

impl Pair {
    /// Returns the pair of the blocks at `index` and behind it. If the number of blocks is odd, the last block is
    /// paired with itself. `first` is the index in the layout of the first of `count` blocks.
    #[inline(always)]
    pub(super) fn new(first: usize, index: usize, count: usize) -> Self {
        let indices = [index, (index + 1).min(count - 1)];
        Self { blocks: [first + indices[0], first + indices[1]], indices }
    }

    /// Loads rows of the two blocks from an array of the layout.
    #[inline(always)]
    pub(super) fn load_regions<S: Simd, const N: usize, const M: usize>(
        self,
        simd: S,
        regions: &Lanes<M>,
    ) -> [f32x16<S>; N] {
        load_two(simd, self.blocks.map(|block| &regions.blocks()[block]))
    }

    /// Loads rows of the two blocks from an array of a call.
    #[inline(always)]
    pub(super) fn load<S: Simd, const N: usize, const M: usize>(
        self,
        simd: S,
        blocks: &[Block<M>],
    ) -> [f32x16<S>; N] {
        load_two(simd, self.indices.map(|index| &blocks[index]))
    }

    /// Stores rows of the two blocks in an array of a call. The first block is stored last: if a block is paired with
    /// itself, only the lanes of the first copy are active.
    #[inline(always)]
    pub(super) fn store<S: Simd, const N: usize>(
        self,
        simd: S,
        values: [f32x16<S>; N],
        blocks: &mut [Block<N>],
    ) {
        let halves = split_two(simd, values);
        store(halves[1], &mut blocks[self.indices[1]]);
        store(halves[0], &mut blocks[self.indices[0]]);
    }
}

impl FitRotations<'_> {
    /// Returns 1/M and the means c = S/M, A = [Sx Sy Sz]/M - c dᵀ and d of the regions of two blocks.
    #[inline(always)]
    pub(super) fn means<S: Simd>(
        &self,
        simd: S,
        pair: Pair,
        sums: &[Block<12>],
    ) -> (f32x16<S>, Means<f32x16<S>>) {
        let moments = pair.load(simd, sums);
        if self.are_cells {
            let inverse_mass = f32x16::splat(simd, 0.125);
            return (inverse_mass, Means::of_cells(simd, inverse_mass, moments));
        }
        let constants: [_; 4] = pair.load_regions(simd, self.constants);
        (constants[0], Means::new(constants, moments))
    }

    /// Computes the rotation R of A of the regions of two blocks. `quaternions` has the warm start, and receives R.
    #[inline(always)]
    pub(super) fn rotate<S: Simd>(
        &self,
        simd: S,
        pair: Pair,
        (mean, a): ([f32x16<S>; 3], [f32x16<S>; 9]),
        quaternions: &mut [Block<4>],
    ) -> [f32x16<S>; 4] {
        let warm = pair.load(simd, quaternions);
        // A region that is collapsed to a point has no rotation. Its |A| is at the level of rounding errors,
        // at most |c| eps half_width times a margin of 8.
        let noise_squared = mean[0].times_plus(mean[0], mean[1].times_plus(mean[1], mean[2] * mean[2]))
            * (8.0 * f32::EPSILON * self.half_width).powi(2);
        let mut norm_squared = [a[0] * a[0], a[1] * a[1], a[2] * a[2]];
        for i in 3..9 {
            norm_squared[i % 3] = a[i].times_plus(a[i], norm_squared[i % 3]);
        }
        let norm_squared = (norm_squared[0] + norm_squared[1]) + norm_squared[2];
        let collapsed = norm_squared.simd_le(noise_squared).to_bitmask() as u16;
        let [first, second] = pair.blocks.map(|block| u16::from(self.occupied[block]));
        let active = first | if pair.blocks[0] == pair.blocks[1] { 0 } else { second << LANES };
        let (q, unconverged) = newton::solve(simd, a, warm, active, collapsed);
        if unconverged != 0 {
            self.unconverged.fetch_add(unconverged.count_ones() as usize, Ordering::Relaxed);
        }
        pair.store(simd, q, quaternions);
        q
    }

    /// Replaces the sums of the regions of two blocks by b = c - G d and the columns of G, so that the motion of a
    /// region moves the vertex at the rest offset (i, j, k) to b + G (i, j, k). G is the rotation R, or R S with a
    /// plastic shape.
    #[inline(always)]
    pub(super) fn store<S: Simd>(
        &self,
        simd: S,
        Pair { blocks, indices }: Pair,
        (mean, d): ([f32x16<S>; 3], [f32x16<S>; 3]),
        g: [f32x16<S>; 9],
        sums: &mut [Block<12>],
    ) {
        let mut b = mean;
        if !self.are_cells {
            for row in 0..3 {
                b[row] = mean[row] - g[row].times_plus(d[0], g[3 + row].times_plus(d[1], g[6 + row] * d[2]));
            }
        }
        let motions = [b[0], b[1], b[2], g[0], g[1], g[2], g[3], g[4], g[5], g[6], g[7], g[8]];
        let motions = split_two(simd, motions);
        for half in [1, 0] {
            store(motions[half], &mut sums[indices[half]]);
            if let Some(factors) = self.factors
                && (half == 0 || blocks[0] != blocks[1])
            {
                scale(simd, factors.of_regions(blocks[half]), &mut sums[indices[half]]);
            }
        }
    }
}

/// Computes 2 tr(Rᵀ A).
#[inline(always)]
pub(super) fn twice_trace<S: Simd>(a: &[f32x16<S>; 9], r: &[f32x16<S>; 9]) -> f32x16<S> {
    let mut trace = r[0] * a[0];
    for i in 1..9 {
        trace = r[i].times_plus(a[i], trace);
    }
    trace + trace
}

/// Multiplies the motion of each region of a block by the stiffness factor of the region.
#[inline(always)]
pub(crate) fn scale<S: Simd>(simd: S, factors: &Block<1>, motions: &mut Block<12>) {
    let ([factor], zero) = (load(simd, factors), f32x8::splat(simd, 0.0));
    // Lanes without a region can have any numbers.
    let is_region = factor.simd_gt(zero);
    for row in motions {
        is_region.select(f32x8::load_array_ref(simd, row) * factor, zero).store_array(row);
    }
}

/// The vertex update that writes the goal positions: g is the mean of the rigid motions of the regions that contain
/// the vertex, weighted by their stiffness factors.
pub(super) struct WriteGoals<'a> {
    /// As [`Regions::mean_weights`](super::Regions::mean_weights).
    pub(super) weights: &'a Lanes<2>,
}

impl VertexUpdate for WriteGoals<'_> {
    type Memory = Block<3>;
    type Tally = ();

    #[inline(always)]
    fn apply<S: Simd>(
        &self,
        simd: S,
        first: usize,
        region_sums: &[Block<3>],
        goals: &mut [Block<3>],
        _: &mut [()],
    ) {
        for ((block, region_sums), goals) in (first..).zip(region_sums).zip(goals) {
            let [_, inverse] = load(simd, &self.weights.blocks()[block]);
            let [x, y, z] = load(simd, region_sums);
            store([x * inverse, y * inverse, z * inverse], goals);
        }
    }
}

/// Sums of the elastic potential of the fit, in f64: one sum for each block of eight regions. One thread
/// writes each sum.
#[derive(Debug)]
pub(crate) struct PotentialSums(Vec<AtomicU64>);

impl PotentialSums {
    /// Creates sums for `blocks` blocks.
    pub(crate) fn new(blocks: usize) -> Self {
        Self((0..blocks).map(|_| AtomicU64::new(0)).collect())
    }

    /// Returns the memory in bytes.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(self.0.as_slice())
    }

    /// Stores, for each of two blocks, Σ s M (|c|² + u) over the regions of the block. `mean` is c, and `u` is
    /// 2 tr(Rᵀ A); s is the factor of a region in `fit`.
    #[inline(always)]
    pub(super) fn store<S: Simd>(
        &self,
        fit: &FitRotations,
        pair: Pair,
        inverse_mass: f32x16<S>,
        mean: [f32x16<S>; 3],
        u: f32x16<S>,
    ) {
        let center_squared = mean[0].times_plus(mean[0], mean[1].times_plus(mean[1], mean[2] * mean[2]));
        let values = (center_squared + u).to_array();
        let inverse_masses = inverse_mass.to_array();
        // The first block is stored last, as in the fit.
        for half in [1, 0] {
            let (mut sum, block) = (0.0, pair.blocks[half]);
            for lane in (0..LANES).filter(|lane| fit.occupied[block] >> lane & 1 != 0) {
                let index = half * LANES + lane;
                let factor = fit.factors.map_or(1.0, |factors| factors.of_regions(block)[0][lane].into());
                sum += factor * f64::from(values[index]) / f64::from(inverse_masses[index]);
            }
            self.0[block].store(sum.to_bits(), Ordering::Relaxed);
        }
    }

    /// Returns the sum over all blocks.
    pub(crate) fn sum(&self) -> f64 {
        self.0.iter().map(|sum| f64::from_bits(sum.load(Ordering::Relaxed))).sum()
    }
}
