//! Computes the constants of the regions: the region weight m/n of each vertex, and the mass, rest centroid
//! and rest inertia of each region.

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

use super::bulk::{RestVolumes, VolumeRatios};
use super::covariances::InverseCovariances;
use super::factors::Factors;
use super::half_width::HalfWidth;
use crate::lattice::{Lattice, Layout, LooseCell, Masses};
use crate::simd::lanes::{Block, LANES, Lanes, Row};

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
    pub(crate) weights: Lanes<2>,
    /// 1/M and d of the region around each vertex: M = Σ m/n is the mass of the region, and d its rest
    /// centroid relative to its center vertex, in cells. Zero in lanes without a region.
    pub(crate) constants: Lanes<4>,
    /// `None` if the stiffness does not vary.
    factors: Option<Factors>,
    /// `None` unless the regions are cells.
    cells: Option<Cells>,
    /// `None` if the body is neither plastic nor can break, and has no volume term.
    pub(crate) inverse_covariances: Option<InverseCovariances>,
    /// k of the [volume term](super::bulk); 0 without one.
    pub(crate) bulk: f32,
    /// σ of each region: see [`bulk`](super::bulk). 1 in lanes without a region. `None` if no region is inflated.
    inflation: Option<Lanes<1>>,
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
    pub(crate) fn new(lattice: &Lattice, masses: &Masses, layout: &Layout, half_width: HalfWidth) -> Self {
        match half_width.is_cell() {
            true => Self::of_cells(lattice, masses, layout),
            false => Self::of_windows(masses, layout, half_width),
        }
    }

    /// Creates the regions of the windows of all vertices. `masses` has the mass of each lattice vertex in units of a
    /// full cell's mass.
    fn of_windows(masses: &[f32], layout: &Layout, half_width: HalfWidth) -> Self {
        let windows = LineWindows::new(layout, half_width);
        let mut mass = vec![0.0; layout.blocks() * LANES];
        for (&slot, &m) in layout.slots().iter().zip(masses) {
            mass[slot as usize] = f64::from(m);
        }
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
            occupied[slot as usize / LANES] |= 1 << (slot as usize % LANES);
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
        let (factors, inflation) = (self.factors.take(), self.inflation.take());
        *self = Self { factors, inflation, ..Self::of_windows(masses, layout, self.half_width) };
    }

    /// Sets the stiffness factors. `factors` has the factor of the region around each vertex; the factor of a cell is
    /// the mean over its corners. `None` removes them.
    pub(super) fn set_factors(&mut self, layout: &Layout, factors: Option<Lanes<1>>) {
        self.factors = factors.map(|mut factors| {
            if let Some(cells) = &self.cells {
                let windows = LineWindows::new(layout, self.half_width);
                let field = field_of(layout, |slot| factors.get(slot)[0].into());
                let sums = windows.sums(&field);
                for &slot in layout.slots() {
                    let mean = sums[slot as usize] / 8.0;
                    factors.set(slot, [(mean * f64::from(cells.shares.of_region(slot))) as f32]);
                }
            }
            self.factors_of(layout, factors)
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
            VolumeRatios::Uniform(ratio) => sigma.blocks_mut().fill([Row::all(ratio.cbrt() as f32)]),
            VolumeRatios::Vertices(ratio) => {
                sigma.blocks_mut().fill([Row::ZERO]);
                for (vertex, &slot) in layout.slots().iter().enumerate() {
                    let ratio = ratio(vertex) as f32;
                    match self.cells {
                        None => sigma.set(slot, [ratio]),
                        Some(_) => {
                            for cell in self.cells_around(layout, slot) {
                                sigma.set(cell, [sigma.get(cell)[0] + ratio / 8.0]);
                            }
                        }
                    }
                }
                for sigma in sigma.blocks_mut().iter_mut().flat_map(|[row]| row.iter_mut()) {
                    *sigma = if *sigma > 0.0 { sigma.cbrt() } else { 1.0 };
                }
            }
        }
        self.inflation = Some(sigma);
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
    pub(crate) fn occupied<'a>(&'a self, layout: &'a Layout) -> &'a [u8] {
        self.cells.as_ref().map_or(layout.occupied(), |cells| &cells.occupied)
    }

    /// Iterates over the slots of the cells around the vertex in a slot, if the regions are cells.
    pub(crate) fn cells_around<'a>(
        &'a self,
        layout: &'a Layout,
        slot: u32,
    ) -> impl Iterator<Item = u32> + 'a {
        let before = move |slot: u32, axis: usize| {
            layout.axis(axis).previous_slot(slot as usize).map(|slot| slot as u32)
        };
        // The order of the adjoint passes, from their last one back.
        let firsts = (0..8).filter_map(move |k| {
            (0..3)
                .try_fold(slot, |slot, axis| if k >> axis & 1 == 0 { Some(slot) } else { before(slot, axis) })
        });
        let is_linked =
            |&slot: &u32| is_set(self.occupied(layout), slot) && !layout.loose_cells().contains(slot);
        let linked = firsts.filter(is_linked);
        let loose = layout.loose_cells().around(slot).filter(move |_| self.cells.is_some());
        linked.chain(loose)
    }

    /// Returns, as the second number of each vertex, the weight of a mean over the regions that contain the vertex:
    /// 1/n, or 1/S with factors.
    pub(crate) fn mean_weights(&self) -> &Lanes<2> {
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
        let mut field = vec![0.0; layout.blocks() * LANES];
        for (&slot, &is_constrained) in layout.slots().iter().zip(constrained) {
            field[slot as usize] = f64::from(u8::from(is_constrained));
        }
        let counts = LineWindows::new(layout, self.half_width).sums_over_regions(field);
        let vertices = layout.slots().iter().zip(constrained).zip(&mut factors);
        for ((&slot, _), factor) in vertices.filter(|((_, is_constrained), _)| **is_constrained) {
            let regions = 1.0 / f64::from(self.weights.get(slot)[1]);
            let factor_of_layer = self.half_width.cells() * regions.powf(2.0 / 3.0) / counts[slot as usize];
            *factor = factor_of_layer.max(2.0) as f32;
        }
        factors
    }

    /// Returns the factor of the region around the vertex in a slot; 0 without a region.
    fn factor(&self, slot: u32) -> f64 {
        self.factors().map_or(1.0, |factors| f64::from(factors.of_region(slot)))
    }

    /// Returns the mass of the vertex in a slot in the fits, in units of a full cell's mass, times its stiffness
    /// factor: the strength with which its regions accelerate it to its goal position.
    pub(crate) fn goal_strength(&self, slot: u32) -> f64 {
        let factor = self.factors().map_or(1.0, |factors| f64::from(factors.vertices.get(slot)[0]));
        f64::from(self.weights.get(slot)[0]) * factor
    }

    /// Returns the memory in bytes.
    pub(crate) fn bytes(&self) -> usize {
        let factors = self.factors.as_ref().map_or(0, Factors::bytes)
            + self.cells.as_ref().map_or(0, |cells| cells.shares.bytes() + cells.occupied.len());
        let inverse_covariances = self.inverse_covariances.as_ref().map_or(0, InverseCovariances::bytes);
        let inflation = self.inflation.as_ref().map_or(0, Lanes::bytes);
        self.weights.bytes() + self.constants.bytes() + factors + inverse_covariances + inflation
    }

    /// Returns the half-width of the regions.
    pub(crate) fn half_width(&self) -> HalfWidth {
        self.half_width
    }

    /// Computes the sum, over all regions and the vertices of each region, of s m/n |y|², where y is the rest
    /// offset of the vertex from the rest centroid of the region, in cells, and s the factor of the region.
    pub(crate) fn rest_moment(&self, layout: &Layout) -> f64 {
        let [xx, yy, zz, ..] = self.second_moments(layout);
        let moments = self.slots(layout).map(|&slot| {
            let [inverse_mass, x, y, z] = self.constants.get(slot).map(f64::from);
            let i = slot as usize;
            self.factor(slot) * (xx[i] + yy[i] + zz[i] - (x * x + y * y + z * z) / inverse_mass)
        });
        moments.sum()
    }

    /// Computes the sum, over all regions and the vertices of each region, of s m/n |R y + c - x|², in f64. x is the
    /// position of a vertex, y its rest offset from the rest centroid of the region, c the center of mass of the
    /// region, R its rotation, all in cells, and s the factor of the region.
    ///
    /// `position` returns x of a slot, and `rotation` the quaternion (x, y, z, w) of R of the region around a slot. An
    /// error of the quaternion has an effect of second order if it is the fitted one, so f32 is enough. `strains` are
    /// S - 1 of the plastic shapes S of the regions; S y then takes the place of y, and σ y in an inflated region.
    /// With a volume term, 2 M σ² k W/t of each region is added, times s.
    pub(crate) fn misfit(
        &self,
        layout: &Layout,
        position: impl Fn(u32) -> Vector3<f64>,
        rotation: impl Fn(u32) -> [f32; 4],
        strains: Option<&Lanes<6>>,
    ) -> f64 {
        let m_over_n = self.region_weights(layout);
        let weighted = |value: &dyn Fn(Vector3<f64>) -> f64| {
            let mut field = vec![0.0; m_over_n.len()];
            for &slot in layout.slots() {
                field[slot as usize] = m_over_n[slot as usize] * value(position(slot));
            }
            field
        };
        let windows = LineWindows::new(layout, self.half_width);
        let [mass, rest @ ..] = windows.first_moments(&m_over_n);
        let second = windows.second_moments(&m_over_n);
        let [yy0, yy1, yy2, ..] = &second;
        let [x, y, z] = [0, 1, 2].map(|c| windows.first_moments(&weighted(&|x| x[c])));
        let xx = windows.sums(&weighted(&|x| x.norm_squared()));
        let misfit_of = |&slot: &u32| {
            let i = slot as usize;
            let moment = |k: usize| Vector3::new(x[k][i], y[k][i], z[k][i]);
            let (sum, d) = (moment(0), Vector3::new(rest[0][i], rest[1][i], rest[2][i]) / mass[i]);
            let rest_moment = yy0[i] + yy1[i] + yy2[i] - mass[i] * d.norm_squared();
            let central = xx[i] - sum.norm_squared() / mass[i];
            let [qx, qy, qz, qw] = rotation(slot).map(f64::from);
            let r = UnitQuaternion::new_normalize(Quaternion::new(qw, qx, qy, qz)).to_rotation_matrix();
            // Σ m/n (x - c) · R y, the trace of Rᵀ Σ m/n (x - c) yᵀ.
            let product: f64 = (0..3).map(|k| r.matrix().column(k).dot(&(moment(k + 1) - sum * d[k]))).sum();
            let c = || self::covariance(second.each_ref().map(|moment| moment[i] / mass[i]), d);
            let a = || Matrix3::from_fn(|row, k| (moment(k + 1) - sum * d[k])[row] / mass[i]);
            let sigma = self.inflation.as_ref().map_or(1.0, |sigma| f64::from(sigma.get(slot)[0]));
            let change = strains.map_or(0.0, |strains| {
                let t = symmetric(strains.get(slot));
                let of_shape = (c() * (t * 2.0 + t * t)).trace() * (sigma * sigma);
                of_shape - 2.0 * sigma * (r.matrix().transpose() * a() * t).trace()
            });
            let volume = match self.bulk {
                0.0 => 0.0,
                bulk => 2.0 * f64::from(bulk) * volume_energy(a() / sigma, c()) * (sigma * sigma),
            };
            let misfit = central + rest_moment * (sigma * sigma) - 2.0 * sigma * product;
            self.factor(slot) * (misfit + mass[i] * (change + volume))
        };
        self.slots(layout).map(misfit_of).sum()
    }

    /// Iterates over the slots that have a region.
    fn slots<'a>(&'a self, layout: &'a Layout) -> impl Iterator<Item = &'a u32> {
        let occupied = self.occupied(layout);
        layout.slots().iter().filter(move |&&slot| is_set(occupied, slot))
    }

    /// Computes the second moments of each region, by slot of its center vertex: Σ m/n times xx, yy, zz, xy,
    /// xz and yz, where (x, y, z) is the rest offset of a vertex from the center vertex.
    fn second_moments(&self, layout: &Layout) -> [Vec<f64>; 6] {
        LineWindows::new(layout, self.half_width).second_moments(&self.region_weights(layout))
    }

    /// Returns the region weight m/n of the vertex in each slot, or 1 in cells. The product is rounded to f32, as in
    /// the window sums of a step.
    fn region_weights(&self, layout: &Layout) -> Vec<f64> {
        let is_cell = self.half_width.is_cell();
        field_of(layout, |slot| {
            let [m, inverse_count] = self.weights.get(slot);
            if is_cell { 1.0 } else { f64::from(m * inverse_count) }
        })
    }

    /// Computes, for each region, the inverse of M⁻¹ Σ m/n ((y·y) I - y yᵀ): the rest inertia divided by the
    /// mass. y is the rest offset of a vertex from the rest centroid, in cells, and I is the identity. The
    /// entries of a matrix are in the order xx, yy, zz, xy, xz, yz.
    pub(crate) fn inverse_inertia(&self, layout: &Layout) -> Lanes<6> {
        self.inverses(layout, |covariance| Matrix3::identity() * covariance.trace() - covariance)
    }

    /// Computes [`Regions::inverse_covariances`]. Numbers at the level of rounding errors become zero, so that most
    /// blocks with the same covariances have the same bits.
    pub(super) fn inverse_covariances(&self, layout: &Layout) -> InverseCovariances {
        let mut covariances = self.inverses(layout, |covariance| covariance);
        for &slot in layout.slots() {
            let covariance = covariances.get(slot);
            let noise = (covariance[0] + covariance[1] + covariance[2]) * f32::EPSILON;
            covariances.set(slot, covariance.map(|number| if number.abs() > noise { number } else { 0.0 }));
        }
        InverseCovariances::new(&covariances)
    }

    /// Computes, for each region, the inverse of a matrix that depends on its rest covariance; zero if it has none.
    /// In a whole body every region contains the corners of a cell, so that its covariance and its inertia have an
    /// inverse. At the front of a crack, where links are left out, a region can be planar, and its covariance has
    /// none.
    fn inverses(&self, layout: &Layout, matrix: impl Fn(Matrix3<f64>) -> Matrix3<f64>) -> Lanes<6> {
        let second = self.second_moments(layout);
        let mut lanes = Lanes::zeros(layout.blocks());
        for &slot in self.slots(layout) {
            let [inverse_mass, x, y, z] = self.constants.get(slot).map(f64::from);
            let moments = second.each_ref().map(|moment| moment[slot as usize] * inverse_mass);
            let covariance = covariance(moments, Vector3::new(x, y, z));
            let inverse = matrix(covariance).try_inverse().unwrap_or_else(Matrix3::zeros);
            lanes.set(slot, SYMMETRIC.map(|at| inverse[at] as f32));
        }
        lanes
    }
}

/// Returns whether the bit of a slot is set in the masks of the blocks.
fn is_set(masks: &[u8], slot: u32) -> bool {
    masks[slot as usize / LANES] >> (slot as usize % LANES) & 1 != 0
}

/// Returns an array by slot with a value in each slot that has a vertex, and 0 elsewhere.
fn field_of(layout: &Layout, value: impl Fn(u32) -> f64) -> Vec<f64> {
    let mut field = vec![0.0; layout.blocks() * LANES];
    layout.slots().iter().for_each(|&slot| field[slot as usize] = value(slot));
    field
}

/// Returns W/t of the [volume term](super::bulk) of a region, from A and the rest covariance C; 0 if C has no inverse.
fn volume_energy(a: Matrix3<f64>, c: Matrix3<f64>) -> f64 {
    let Some(inverse) = c.try_inverse() else { return 0.0 };
    let (f, t) = (a * inverse, inverse.trace() / 3.0);
    let column = |k: usize| f.column((k + 1) % 3).cross(&f.column((k + 2) % 3));
    let cofactors = Matrix3::from_columns(&[column(0), column(1), column(2)]);
    let (d, q) = (f.determinant() - 1.0, cofactors.dot(&(cofactors * inverse)) / t);
    d * d / (2.0 * (q + 4.0 * d * d)) / t
}

/// The order of the entries of a symmetric matrix: xx, yy, zz, xy, xz, yz.
const SYMMETRIC: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];

/// Computes the covariance of a region. The arguments are the second moments about the center vertex, divided by the
/// mass, and the rest centroid `d` relative to the center vertex.
fn covariance([xx, yy, zz, xy, xz, yz]: [f64; 6], d: Vector3<f64>) -> Matrix3<f64> {
    Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz) - d * d.transpose()
}

/// Returns the symmetric matrix with the entries xx, yy, zz, xy, xz, yz.
pub(crate) fn symmetric([xx, yy, zz, xy, xz, yz]: [f32; 6]) -> Matrix3<f64> {
    Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz).map(f64::from)
}

/// Window sums in f64 over arrays by slot, for constants that are computed once.
///
/// The window of a vertex along an axis contains the vertices that are connected to it by up to `half_width`
/// links along this axis; the window of a cell has the vertex and the next one. A line is a maximal sequence of
/// linked vertices along an axis.
struct LineWindows<'a> {
    /// Lines of each axis, the result of [`lines`].
    axes: [(Vec<u32>, Vec<usize>); 3],
    half_width: HalfWidth,
    /// The loose cells; empty unless the regions are cells.
    loose: &'a [LooseCell],
}

impl<'a> LineWindows<'a> {
    /// Finds the lines along each axis.
    fn new(layout: &'a Layout, half_width: HalfWidth) -> Self {
        let loose = if half_width.is_cell() { layout.loose_cells().all() } else { &[] };
        Self { axes: [0, 1, 2].map(|axis| lines(layout, axis)), half_width, loose }
    }

    /// Computes n, the number of regions that contain each vertex. `mass` is positive in slots with a vertex.
    ///
    /// A region contains the vertices that links connect to its center vertex: first along z, then along y,
    /// then along x. So each center vertex counts as 1, and window sums of these counts along z, then y, then
    /// x give the number of regions that contain each vertex.
    fn region_counts(&self, mass: &[f64]) -> Vec<f64> {
        self.sums_over_regions(mass.iter().map(|&m| if m > 0.0 { 1.0 } else { 0.0 }).collect())
    }

    /// Computes, for each vertex, the sum over the regions that contain it of the value of `field` at the center vertex
    /// of the region.
    fn sums_over_regions(&self, mut field: Vec<f64>) -> Vec<f64> {
        let is_cell = self.half_width.is_cell();
        let links = if is_cell { [1, 0] } else { [self.half_width.links(); 2] };
        let taken: Vec<f64> =
            self.loose.iter().map(|cell| std::mem::take(&mut field[cell.slot as usize])).collect();
        let mut sums =
            (0..3).rev().fold(field, |field, axis| self.moment_within(links, 0.0, (axis, 0), &field));
        for (cell, value) in self.loose.iter().zip(taken) {
            cell.corners.iter().for_each(|&corner| sums[corner as usize] += value);
        }
        sums
    }

    /// Computes Σ f of each region, where f is the value of `field` at a vertex.
    fn sums(&self, field: &[f64]) -> Vec<f64> {
        self.moments([0; 3], field)
    }

    /// Computes Σ f, Σ i f, Σ j f and Σ k f of each region, where f is the value of `field` at a vertex and
    /// (i, j, k) is the offset of the vertex from the center vertex.
    fn first_moments(&self, field: &[f64]) -> [Vec<f64>; 4] {
        [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]].map(|powers| self.moments(powers, field))
    }

    /// Computes the sums of f times ii, jj, kk, ij, ik and jk of each region, with f and (i, j, k) as in
    /// [`Self::first_moments`].
    fn second_moments(&self, field: &[f64]) -> [Vec<f64>; 6] {
        [[2, 0, 0], [0, 2, 0], [0, 0, 2], [1, 1, 0], [1, 0, 1], [0, 1, 1]]
            .map(|powers| self.moments(powers, field))
    }

    /// Computes the sum of f times powers of i, j and k of each region.
    fn moments(&self, powers: [usize; 3], field: &[f64]) -> Vec<f64> {
        let mut moments = (0..3).fold(field.to_vec(), |field, axis| self.moment(axis, powers[axis], &field));
        for cell in self.loose {
            let term = |(k, &corner): (usize, &u32)| {
                let offset = |axis: usize| ((k >> axis & 1) as f64 - 0.5).powi(powers[axis] as i32);
                field[corner as usize] * offset(0) * offset(1) * offset(2)
            };
            moments[cell.slot as usize] = cell.corners.iter().enumerate().map(term).sum();
        }
        moments
    }

    /// Computes Σ iᵖ f over the window of each vertex along `axis`, where f is a value of `field`, i is the
    /// signed number of links from the center of the window, and p = `power` is 0, 1 or 2.
    fn moment(&self, axis: usize, power: usize, field: &[f64]) -> Vec<f64> {
        match self.half_width.is_cell() {
            true => self.moment_within([0, 1], 0.5, (axis, power), field),
            false => self.moment_within([self.half_width.links(); 2], 0.0, (axis, power), field),
        }
    }

    /// As [`Self::moment`], for windows that reach some numbers of links back and forth from a vertex, with their
    /// centers `shift` links further than the vertex.
    fn moment_within(
        &self,
        [back, forth]: [usize; 2],
        shift: f64,
        (axis, power): (usize, usize),
        field: &[f64],
    ) -> Vec<f64> {
        let (slots, starts) = &self.axes[axis];
        let mut out = vec![0.0; field.len()];
        // Prefix sums of f, j f and j² f along a line, where j is the index of a vertex in the line.
        let mut sums: Vec<[f64; 3]> = Vec::new();
        for line in starts.windows(2).map(|start_end| &slots[start_end[0]..start_end[1]]) {
            sums.clear();
            sums.push([0.0; 3]);
            let mut sum = [0.0; 3];
            for (j, &slot) in line.iter().enumerate() {
                let (j, f) = (j as f64, field[slot as usize]);
                sum = [sum[0] + f, sum[1] + j * f, sum[2] + j * j * f];
                sums.push(sum);
            }
            for (center, &slot) in line.iter().enumerate() {
                let before = sums[center.saturating_sub(back)];
                let up_to = sums[line.len().min(center + forth + 1)];
                let [s, sj, sjj] = [0, 1, 2].map(|p| up_to[p] - before[p]);
                let c = center as f64 + shift;
                out[slot as usize] = match power {
                    0 => s,
                    1 => sj - c * s,
                    _ => sjj - 2.0 * c * sj + c * c * s,
                };
            }
        }
        out
    }
}

/// Returns the lines of linked vertices along an axis: the slots of all lines, line by line, and the index of
/// the first slot of each line in this list, followed by the length of the list.
fn lines(layout: &Layout, axis: usize) -> (Vec<u32>, Vec<usize>) {
    let links = layout.axis(axis);
    let mut has_previous = vec![false; layout.blocks() * LANES];
    for &slot in layout.slots() {
        if let Some(next) = links.next_slot(slot as usize) {
            has_previous[next] = true;
        }
    }
    let (mut slots, mut starts) = (Vec::with_capacity(layout.slots().len()), vec![0]);
    for &start in layout.slots().iter().filter(|&&slot| !has_previous[slot as usize]) {
        let line = std::iter::successors(Some(start as usize), |&slot| links.next_slot(slot));
        slots.extend(line.map(|slot| slot as u32));
        starts.push(slots.len());
    }
    (slots, starts)
}
