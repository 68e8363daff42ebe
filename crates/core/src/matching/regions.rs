//! Computes the constants of the regions: the region weight m/n of each vertex, and the mass, rest centroid
//! and rest inertia of each region.

use super::bulk::{RestVolumes, VolumeRatios};
use super::covariances::InverseCovariances;
use super::factors::Factors;
use super::half_width::HalfWidth;
use super::line_windows::LineWindows;
use crate::lattice::{Lattice, Layout, Masses};
use crate::simd::lanes::{Block, Lanes, Row, block_and_lane};

/// The regions of a lattice: one around each vertex, its center vertex. The module
/// [`cascade`](super::cascade) defines which vertices a region contains.
///
/// Masses are in units of a full cell's mass: m is an eighth of the filled shares of the cells of the vertex. A vertex
/// of mass m has the region weight m/n in each region that contains it, where n is the number of these regions.
/// So Σ m g = Σ m x for the positions x and the goal positions g, and shape matching conserves linear
/// momentum.
///
/// The regions of half-width 1/2 are the cells: a corner has the weight 1 in its cell, and a cell of the filled share
/// f the factor f/8. So n of a vertex is its mass, the sum of the factors of its cells, and Σ m g = Σ m x here too.
///
/// Arrays are indexed by slot, the index of a vertex in the storage order ([`Lanes`]).
#[derive(Clone, Debug)]
pub(crate) struct Regions {
    /// m and 1/n of each vertex. The product m/n is the region weight ([`Weighted`](super::Weighted)); 1/n
    /// turns a sum over the regions that contain the vertex into a mean. Zero in lanes without a vertex.
    pub weights: Lanes<2>,
    /// 1/M and d of the region around each vertex: M = Σ m/n is the mass of the region, and d its rest
    /// centroid relative to its center vertex, in cells. Zero in lanes without a region.
    pub constants: Lanes<4>,
    /// `None` if the stiffness does not vary.
    factors: Option<Factors>,
    /// `None` unless the regions are cells.
    cells: Option<Cells>,
    /// Factor of the yield strain of each region, 1 in lanes without a region; `None` if all are 1.
    pub(super) yield_factors: Option<Lanes<1>>,
    /// `None` if the body is neither plastic nor can break, and has no volume term.
    pub inverse_covariances: Option<InverseCovariances>,
    /// k of the [volume term](super::bulk); 0 without one.
    pub bulk: f32,
    /// σ of each region: see [`bulk`](super::bulk). 1 in lanes without a region. `None` if no region is inflated.
    pub(super) inflation: Option<Lanes<1>>,
    half_width: HalfWidth,
}

/// 1/M and d of a cell.
const CELL: [f32; 4] = [0.125, 0.0, 0.0, 0.0];

/// The data of regions that are cells, beside the constants.
#[derive(Clone, Debug)]
struct Cells {
    /// The mask of each block: bit `l` is set iff lane `l` has a cell.
    occupied: Vec<u8>,
    /// f/8 of each cell with the filled share f.
    shares: Factors,
}

impl Regions {
    /// Creates the regions of half-width `half_width`.
    pub(super) fn new(lattice: &Lattice, masses: &Masses, layout: &Layout, half_width: HalfWidth) -> Self {
        match half_width.is_cell() {
            true => Self::of_cells(lattice, masses, layout),
            false => Self::of_windows(masses, layout, half_width),
        }
    }

    /// Creates the regions of the windows of all vertices. `masses` has the mass of each lattice vertex in units of a
    /// full cell's mass.
    fn of_windows(masses: &[f32], layout: &Layout, half_width: HalfWidth) -> Self {
        let windows = LineWindows::new(layout, half_width);
        let mass = layout.by_slot(masses.iter().map(|&m| f64::from(m)));
        let region_counts = windows.region_counts(&mass);

        let mut regions = Self::empty(layout, half_width);
        for &slot in layout.slots() {
            let inverse_count = (1.0 / region_counts[slot as usize]) as f32;
            regions.weights.set(slot, [mass[slot as usize] as f32, inverse_count]);
        }
        let [masses, sx, sy, sz] = windows.first_moments(&regions.region_weights(layout));
        for &slot in layout.slots() {
            let i = slot as usize;
            let [x, y, z] = [sx[i], sy[i], sz[i]].map(|moment| (moment / masses[i]) as f32);
            regions.constants.set(slot, [(1.0 / masses[i]) as f32, x, y, z]);
        }
        regions
    }

    /// Creates regions that are cells.
    fn of_cells(lattice: &Lattice, masses: &Masses, layout: &Layout) -> Self {
        let mut regions = Self::empty(layout, HalfWidth::CELL);
        for (&slot, &mass) in layout.slots().iter().zip(&**masses) {
            regions.weights.set(slot, [mass, (1.0 / f64::from(mass)) as f32]);
        }
        let (mut shares, mut occupied) = (Lanes::zeros(layout.blocks()), vec![0; layout.blocks()]);
        for cell in 0..lattice.cells().len() as u32 {
            let slot = layout.slots()[lattice.first_corner(cell) as usize];
            shares.set(slot, [masses.share(cell) / 8.0]);
            regions.constants.set(slot, CELL);
            let (block, lane) = block_and_lane(slot);
            occupied[block] |= 1 << lane;
        }
        regions.cells = Some(Cells { occupied, shares: regions.factors_of(layout, shares) });
        regions
    }

    /// Returns regions without weights and constants.
    fn empty(layout: &Layout, half_width: HalfWidth) -> Self {
        Self {
            weights: Lanes::zeros(layout.blocks()),
            constants: Lanes::zeros(layout.blocks()),
            factors: None,
            cells: None,
            yield_factors: None,
            inverse_covariances: None,
            bulk: 0.0,
            inflation: None,
            half_width,
        }
    }

    /// Changes the masses of the vertices in the fits, and keeps the stiffness factors. Cells have no other masses than
    /// their own.
    pub(super) fn set_masses(&mut self, masses: &[f32], layout: &Layout) {
        if self.cells.is_some() {
            return;
        }
        let Self { factors, inflation, yield_factors, .. } = self;
        let (factors, inflation, yield_factors) = (factors.take(), inflation.take(), yield_factors.take());
        *self =
            Self { factors, inflation, yield_factors, ..Self::of_windows(masses, layout, self.half_width) };
    }

    /// Sets the stiffness factors. `factors` has the factor of the region around each vertex; the factor of a cell is
    /// the mean over its corners. `None` removes them.
    pub(super) fn set_factors(&mut self, layout: &Layout, factors: Option<&[f32]>) {
        self.factors = factors.map(|factors| {
            let mut of_regions = layout.by_slot(factors.iter().map(|&factor| f64::from(factor)));
            if let Some(cells) = &self.cells {
                let sums = LineWindows::new(layout, self.half_width).sums(&of_regions);
                for &slot in layout.slots() {
                    let mean = sums[slot as usize] / 8.0;
                    of_regions[slot as usize] = mean * f64::from(cells.shares.of_region(slot));
                }
            }
            let mut regions = Lanes::zeros(layout.blocks());
            layout.slots().iter().for_each(|&slot| regions.set(slot, [of_regions[slot as usize] as f32]));
            self.factors_of(layout, regions)
        });
    }

    /// Sets s of each vertex, the ratio of the rest volume around it. σ³ of a region is s of its center vertex,
    /// and of a cell the mean over its corners. `None` removes the ratios.
    pub(super) fn set_inflation(&mut self, layout: &Layout, ratios: Option<VolumeRatios>) {
        let Some(ratios) = ratios else {
            self.inflation = None;
            return;
        };
        let mut sigma = self.inflation.take().unwrap_or_else(|| Lanes::zeros(layout.blocks()));
        match ratios {
            VolumeRatios::Uniform(ratio) => sigma.blocks_mut().fill([Row::all(libm::cbrt(ratio) as f32)]),
            VolumeRatios::Vertices(ratio) => self.set_means(layout, &mut sigma, ratio, libm::cbrtf),
        }
        self.inflation = Some(sigma);
    }

    /// Sets the factor of the yield strain around each vertex; that of a cell is the mean over its corners. `None`
    /// removes the factors.
    pub(super) fn set_yield_factors(&mut self, layout: &Layout, factor: Option<impl Fn(u32) -> f64>) {
        self.yield_factors = factor.map(|factor| {
            let mut factors = Lanes::zeros(layout.blocks());
            self.set_means(layout, &mut factors, |vertex| factor(vertex as u32), |factor| factor);
            factors
        });
    }

    /// Sets the number of each region: `of_mean` of the number of its center vertex, or of a cell of the mean over its
    /// corners. The numbers of the vertices are above 0. 1 in lanes without a region.
    fn set_means(
        &self,
        layout: &Layout,
        means: &mut Lanes<1>,
        number: impl Fn(usize) -> f64,
        of_mean: impl Fn(f32) -> f32,
    ) {
        means.blocks_mut().fill([Row::ZERO]);
        for (vertex, &slot) in layout.slots().iter().enumerate() {
            let number = number(vertex) as f32;
            match self.cells {
                None => means.set(slot, [number]),
                Some(_) => {
                    for cell in self.cells_around(layout, slot) {
                        means.set(cell, [means.get(cell)[0] + number / 8.0]);
                    }
                }
            }
        }
        for mean in means.blocks_mut().iter_mut().flat_map(|[row]| row.iter_mut()) {
            *mean = if *mean > 0.0 { of_mean(*mean) } else { 1.0 };
        }
    }

    /// Returns the constants of the volume term and of inflation, if the regions have rest covariances.
    pub(super) fn rest_volumes(&self) -> Option<RestVolumes<'_>> {
        let inverse_covariances = self.inverse_covariances.as_ref()?;
        Some(RestVolumes { inverse_covariances, bulk: self.bulk, inflation: self.inflation.as_ref() })
    }

    /// Returns the factors of regions with their sums at the vertices.
    fn factors_of(&self, layout: &Layout, regions: Lanes<1>) -> Factors {
        let field = field_of(layout, |slot| regions.get(slot)[0].into());
        let sums = LineWindows::new(layout, self.half_width).sums_over_regions(field);
        let mut vertices = Lanes::zeros(layout.blocks());
        for &slot in layout.slots() {
            let (sum, [_, inverse_count]) = (sums[slot as usize], self.weights.get(slot));
            vertices.set(slot, [(sum * f64::from(inverse_count)) as f32, (1.0 / sum) as f32]);
        }
        Factors { regions, vertices }
    }

    /// Returns m and 1/n of each vertex, the weights of vectors in sums over regions. `None` if the regions are
    /// cells, in which all weights are 1.
    pub(crate) fn vector_weights(&self) -> Option<&[Block<2>]> {
        self.cells.is_none().then(|| self.weights.blocks())
    }

    /// Returns the factors with which the regions count in goal positions: the stiffness factors, times f/8 of cells.
    /// `None` if all are 1.
    pub(crate) fn factors(&self) -> Option<&Factors> {
        self.factors.as_ref().or(self.shares())
    }

    /// Returns the factors with which the regions count where their stiffness does not: f/8 of cells. `None` if all
    /// are 1.
    pub(crate) fn shares(&self) -> Option<&Factors> {
        self.cells.as_ref().map(|cells| &cells.shares)
    }

    /// Returns the mask of the lanes with a region of each block.
    pub(super) fn occupied<'a>(&'a self, layout: &'a Layout) -> &'a [u8] {
        self.cells.as_ref().map_or(layout.occupied(), |cells| &cells.occupied)
    }

    /// Iterates over the slots of the cells around the vertex in a slot, if the regions are cells.
    pub(crate) fn cells_around<'a>(
        &'a self,
        layout: &'a Layout,
        slot: u32,
    ) -> impl Iterator<Item = u32> + 'a {
        // The order of the adjoint passes, from their last one back.
        let firsts = (0..8).filter_map(move |k| {
            (0..3).try_fold(slot, |slot, axis| match k >> axis & 1 {
                0 => Some(slot),
                _ => layout.axis(axis).previous_slot(slot),
            })
        });
        let is_linked =
            |&slot: &u32| is_set(self.occupied(layout), slot) && !layout.loose_cells().contains(slot);
        let linked = firsts.filter(is_linked);
        let loose = layout.loose_cells().around(slot).filter(move |_| self.cells.is_some());
        linked.chain(loose)
    }

    /// Returns, as the second number of each vertex, the weight of a mean over the regions that contain the vertex:
    /// 1/n, or 1/S with factors.
    pub(super) fn mean_weights(&self) -> &Lanes<2> {
        self.factors().map_or(&self.weights, |factors| &factors.vertices)
    }

    /// Returns the factor of the mass of each vertex in the fits: 1 of a free vertex, and of a constrained one
    /// w N^(2/3)/k, but at least 2, with the half-width w, the number N of regions that contain the vertex, and the
    /// number k of constrained ones among their center vertices.
    ///
    /// Let a layer of vertices be held, and the material beside it be strained evenly, so that the displacement of a
    /// layer is proportional to its distance. The region at the distance d <= w from the held layer has the layers 0 to
    /// d + w. Its mean displacement equals the displacement of its center if the held layer counts (d + w)(d + w +
    /// 1)/(2 d) - (d + w) times. The mean of this number over d = 1 to w is about w: 2 for w = 2, 4.5 for w = 4, 7.3
    /// for w = 6. With more the regions at the constraint would be stiffer than the others, and with less the body
    /// would slip out of the constraint. A layer of a region has about N^(2/3) vertices; fewer held ones weigh as
    /// much as a layer together. Cells need no such factor: a constraint acts on their corners.
    ///
    /// `constrained` has one entry per vertex, or none if no vertex is constrained.
    pub(crate) fn constraint_factors(&self, layout: &Layout, constrained: &[bool]) -> Vec<f32> {
        let mut factors = vec![1.0; layout.slots().len()];
        if !constrained.contains(&true) || self.half_width.is_cell() {
            return factors;
        }
        let field =
            layout.by_slot(constrained.iter().map(|&is_constrained| f64::from(u8::from(is_constrained))));
        let counts = LineWindows::new(layout, self.half_width).sums_over_regions(field);
        let vertices = layout.slots().iter().zip(constrained).zip(&mut factors);
        for ((&slot, _), factor) in vertices.filter(|((_, is_constrained), _)| **is_constrained) {
            let regions = 1.0 / f64::from(self.weights.get(slot)[1]);
            let factor_of_layer =
                self.half_width.cells() * libm::pow(regions, 2.0 / 3.0) / counts[slot as usize];
            *factor = factor_of_layer.max(2.0) as f32;
        }
        factors
    }

    /// Returns the factor of the region around the vertex in a slot; 0 without a region.
    pub(super) fn factor(&self, slot: u32) -> f64 {
        self.factors().map_or(1.0, |factors| f64::from(factors.of_region(slot)))
    }

    /// Returns the mass of the vertex in a slot in the fits, in units of a full cell's mass, times its stiffness
    /// factor: the strength with which its regions accelerate it to its goal position.
    pub(crate) fn goal_strength(&self, slot: u32) -> f64 {
        let factor = self.factors().map_or(1.0, |factors| f64::from(factors.vertices.get(slot)[0]));
        f64::from(self.weights.get(slot)[0]) * factor
    }

    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        let factors = self.factors.as_ref().map_or(0, Factors::bytes)
            + self.cells.as_ref().map_or(0, |cells| cells.shares.bytes() + cells.occupied.len());
        let inverse_covariances = self.inverse_covariances.as_ref().map_or(0, InverseCovariances::bytes);
        let inflation = self.inflation.as_ref().map_or(0, Lanes::bytes);
        let yields = self.yield_factors.as_ref().map_or(0, Lanes::bytes);
        self.weights.bytes() + self.constants.bytes() + factors + inverse_covariances + inflation + yields
    }

    /// Returns the half-width of the regions.
    pub(crate) fn half_width(&self) -> HalfWidth {
        self.half_width
    }

    /// Iterates over the slots that have a region.
    pub(super) fn slots<'a>(&'a self, layout: &'a Layout) -> impl Iterator<Item = &'a u32> {
        let occupied = self.occupied(layout);
        layout.slots().iter().filter(move |&&slot| is_set(occupied, slot))
    }
}

/// Returns whether the bit of a slot is set in the masks of the blocks.
fn is_set(masks: &[u8], slot: u32) -> bool {
    let (block, lane) = block_and_lane(slot);
    masks[block] >> lane & 1 != 0
}

/// Returns an array by slot with a value in each slot that has a vertex, and 0 elsewhere.
pub(super) fn field_of(layout: &Layout, value: impl Fn(u32) -> f64) -> Vec<f64> {
    layout.by_slot(layout.slots().iter().map(|&slot| value(slot)))
}
