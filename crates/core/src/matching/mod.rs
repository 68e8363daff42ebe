//! Computes lattice shape matching: fits a rigid motion to the region around each vertex, and averages these
//! motions to the goal position of each vertex (Rivers & James 2007).
//!
//! | file | contents |
//! |---|---|
//! | `half_width` | the half-width of the regions |
//! | `line_windows` | window sums in f64, for constants of the regions |
//! | `regions` | the region weight m/n of each vertex; mass and rest centroid of a region |
//! | `moments` | rest moments, inverse inertia and covariances of the regions |
//! | `factors` | the stiffness factors of the regions, for a body whose stiffness varies |
//! | `windows` | sums over windows of linked vertices along one axis |
//! | `cascade` | sums over the vertices of each region, and sums over the regions of each vertex |
//! | `rotation` | the rotation of a region, by Newton's method with an eigenvalue test, or else an eigenvalue problem |
//! | `goals` | the rigid motion of each region, and the goal position g of each vertex |
//! | `bulk` | the volume term of the fit of regions, which gives a body its Poisson's ratio |
//! | `plastic` | the fit of regions in plastic shapes |
//! | `flow` | the flow of plastic shapes |
//! | `covariances` | the inverse rest covariances of the regions, for plastic shapes and deformation gradients |
//! | `algebra` | products, inverses and norms of symmetric matrices |
//! | `gradients` | the deformation gradients of the regions |

mod algebra;
mod bulk;
mod cascade;
mod covariances;
mod factors;
mod flow;
mod goals;
mod gradients;
mod half_width;
mod line_windows;
mod moments;
mod plastic;
mod regions;
mod rotation;
mod windows;

pub(crate) use algebra::{full, inverse, times};
pub(crate) use bulk::{VolumeRatios, bulk_of};
pub(crate) use cascade::{Purpose, RegionTransform, VertexUpdate, Workspace, Workspaces};
pub(crate) use covariances::InverseCovariances;
pub(crate) use factors::Factors;
pub(crate) use flow::{Flow, shape};
pub(crate) use goals::{Means, PotentialSums, scale};
pub(crate) use gradients::Gradients;
pub use half_width::HalfWidth;
pub(crate) use moments::symmetric;
pub(crate) use regions::Regions;
pub(crate) use rotation::columns;
pub use rotation::rotations;
pub(crate) use rotation::{ROTATIONS, rotations_near};
pub(crate) use windows::Weighted;

use std::sync::atomic::AtomicUsize;

use nalgebra::Vector4;

use crate::lattice::{Lattice, Layout, Masses};
use crate::parallel::{Executor, Split};
use crate::simd::lanes::Lanes;
use bulk::FitBulk;
use cascade::Cascade;
use goals::{FitRotations, WriteGoals};
use gradients::{MeasureGradients, Unfitted};
use plastic::{FitFlowing, FitPlastic};

/// The shapes in which regions are fitted. Plastic shapes are given as T = S - 1: see [`plastic`].
#[derive(Debug)]
pub(crate) enum Shapes<'a> {
    /// The rest shapes.
    Rest,
    /// Plastic shapes.
    Plastic(&'a Lanes<6>),
    /// Plastic shapes that flow after the fit.
    Flowing(&'a mut Lanes<6>, Flow),
}

impl<'a> Shapes<'a> {
    /// Returns the plastic shapes if there are any.
    pub(crate) fn of(strains: Option<&'a Lanes<6>>) -> Self {
        strains.map_or(Self::Rest, Self::Plastic)
    }
}

/// The arrays of a fit of rigid motions to the regions.
pub(crate) struct RegionFit<'a> {
    pub positions: &'a Lanes<3>,
    /// The warm start, which receives the fitted rotations.
    pub rotations: &'a mut Lanes<4>,
    pub shapes: Shapes<'a>,
}

/// The shape-matching stage: the regions of a lattice, and the cascade that sums over them. A [`Workspace`]
/// has the buffers of the stage.
#[derive(Clone, Debug)]
pub(crate) struct Matching {
    pub layout: Layout,
    pub regions: Regions,
    pub cascade: Cascade,
}

impl Matching {
    /// Creates the stage for regions of half-width `half_width`.
    pub(crate) fn new(lattice: &Lattice, masses: &Masses, half_width: HalfWidth) -> Self {
        Self::with_layout((lattice, masses), Layout::new(lattice), half_width)
    }

    /// Changes the half-width of the regions, which removes their stiffness factors. `lattice` and `masses` must be
    /// those of [`Matching::new`].
    pub(crate) fn set_half_width(&mut self, lattice: &Lattice, masses: &Masses, half_width: HalfWidth) {
        let renewed = Self::with_layout((lattice, masses), self.layout.clone(), half_width);
        let before = std::mem::replace(self, renewed);
        self.set_terms_of(&before);
    }

    /// Changes the masses of the vertices in the fits of the regions, in units of a full cell's mass.
    pub(crate) fn set_masses(&mut self, masses: &[f32]) {
        let (has_covariances, bulk) = (self.has_covariances(), self.regions.bulk);
        self.regions.set_masses(masses, &self.layout);
        self.set_terms(has_covariances, bulk);
    }

    /// Copies the volume term from another stage, and creates or removes the rest covariances as there.
    pub(crate) fn set_terms_of(&mut self, other: &Self) {
        self.set_terms(other.has_covariances(), other.regions.bulk);
    }

    fn set_terms(&mut self, has_covariances: bool, bulk: f32) {
        self.set_covariances(has_covariances);
        self.set_bulk(bulk);
    }

    /// Creates or removes the rest covariances of the regions, which plastic shapes, [`Gradients`] and the volume
    /// term need.
    pub(crate) fn set_covariances(&mut self, has_covariances: bool) {
        self.regions.inverse_covariances =
            has_covariances.then(|| self.regions.inverse_covariances(&self.layout));
    }

    /// Sets k of the volume term: see [`bulk`]. If it is not 0, the matching must have the rest covariances.
    pub(crate) fn set_bulk(&mut self, bulk: f32) {
        self.regions.bulk = bulk;
    }

    /// Sets s of each lattice vertex, the ratio of the rest volume around it to its volume in the lattice: see
    /// [`bulk`]. `None` removes the ratios. With them, the matching must have the rest covariances.
    pub(crate) fn set_inflation(&mut self, ratios: Option<VolumeRatios>) {
        self.regions.set_inflation(&self.layout, ratios);
    }

    /// Sets the stiffness factor of the region around each lattice vertex. `None` removes the factors.
    pub(crate) fn set_factors(&mut self, factors: Option<&[f32]>) {
        self.regions.set_factors(&self.layout, factors);
    }

    /// Sets the factor of the yield strain around each lattice vertex. `None` removes the factors.
    pub(crate) fn set_yield_factors(&mut self, factor: Option<impl Fn(u32) -> f64>) {
        self.regions.set_yield_factors(&self.layout, factor);
    }

    /// Returns whether the regions have their rest covariances: see [`Matching::set_covariances`].
    pub(crate) fn has_covariances(&self) -> bool {
        self.regions.inverse_covariances.is_some()
    }

    fn with_layout((lattice, masses): (&Lattice, &Masses), layout: Layout, half_width: HalfWidth) -> Self {
        let regions = Regions::new(lattice, masses, &layout, half_width);
        let cascade = Cascade::new(&layout, half_width);
        Self { layout, regions, cascade }
    }

    /// Fits a rigid motion to each region. `potential` receives the sums of the elastic potential. With
    /// [`Purpose::Vertices`], [`Matching::goals`] can then compute the goal positions.
    ///
    /// Returns the number of rotations for which Newton's method did not converge. They are computed by the
    /// fallback: an eigenvalue problem in f64.
    pub(crate) fn fit(
        &self,
        workspace: &mut Workspace,
        executor: &Executor,
        arrays: RegionFit<'_>,
        potential: Option<&PotentialSums>,
        purpose: Purpose,
    ) -> usize {
        self.fit_regions((workspace, executor), arrays, (potential, None), purpose)
    }

    /// As [`Matching::fit`] with [`Purpose::Vertices`], and measures the deformation gradient of each region. The
    /// matching must have the [rest covariances](Matching::set_covariances).
    pub(crate) fn fit_and_measure(
        &self,
        workspace: &mut Workspace,
        executor: &Executor,
        arrays: RegionFit<'_>,
        gradients: Gradients,
    ) -> usize {
        self.fit_regions((workspace, executor), arrays, (None, Some(gradients)), Purpose::Vertices)
    }

    /// Measures the deformation gradient of each region at `positions`. The results are the same as by
    /// [`Matching::fit_and_measure`].
    pub(crate) fn measure(
        &self,
        workspace: &mut Workspace,
        executor: &Executor,
        positions: &Lanes<3>,
        gradients: Gradients,
    ) {
        let unfitted = (&Unfitted, ());
        self.forward((workspace, executor), positions, unfitted, Some(gradients), Purpose::Regions);
    }

    fn fit_regions(
        &self,
        (workspace, executor): (&mut Workspace, &Executor),
        RegionFit { positions, rotations, shapes }: RegionFit<'_>,
        (potential, gradients): (Option<&PotentialSums>, Option<Gradients>),
        purpose: Purpose,
    ) -> usize {
        let unconverged = AtomicUsize::new(0);
        let fit = FitRotations {
            constants: &self.regions.constants,
            are_cells: self.regions.half_width().is_cell(),
            factors: self.regions.factors(),
            occupied: self.regions.occupied(&self.layout),
            half_width: self.regions.half_width().cells() as f32,
            unconverged: &unconverged,
            potential,
        };
        let (parallel, quaternions) = ((workspace, executor), rotations.blocks_mut());
        match (shapes, self.regions.rest_volumes()) {
            (Shapes::Rest, Some(volumes)) if volumes.bulk != 0.0 || volumes.inflation.is_some() => {
                let fit = FitBulk { fit, volumes };
                self.forward(parallel, positions, (&fit, quaternions), gradients, purpose);
            }
            (Shapes::Rest, _) | (_, None) => {
                self.forward(parallel, positions, (&fit, quaternions), gradients, purpose);
            }
            (Shapes::Plastic(strains), Some(volumes)) => {
                let fit = FitPlastic { fit, volumes, strains };
                self.forward(parallel, positions, (&fit, quaternions), gradients, purpose);
            }
            (Shapes::Flowing(strains, flow), Some(volumes)) => {
                let yield_factors = self.regions.yield_factors.as_ref();
                let fit = FitFlowing { fit, volumes, flow, yield_factors };
                let memory = (quaternions, strains.blocks_mut());
                self.forward(parallel, positions, (&fit, memory), gradients, purpose);
            }
        }
        unconverged.into_inner()
    }

    /// Sums the positions over each region, and transforms the sums by `fit`, after the deformation gradients are
    /// measured.
    fn forward<M: Split, T: RegionTransform<M>>(
        &self,
        (workspace, executor): (&mut Workspace, &Executor),
        positions: &Lanes<3>,
        (fit, memory): (&T, M),
        gradients: Option<Gradients>,
        purpose: Purpose,
    ) {
        let Self { layout, regions, cascade } = self;
        let constants = &regions.constants;
        let field = Weighted { weights: regions.vector_weights(), vectors: positions.blocks() };
        match (gradients, regions.rest_volumes()) {
            (Some(Gradients { values, stretched, least }), Some(volumes)) => {
                let fit = MeasureGradients { fit, constants, volumes, least };
                let memory = (memory, (stretched, values));
                cascade.forward(layout, executor, workspace, field, (&fit, memory), purpose);
            }
            _ => cascade.forward(layout, executor, workspace, field, (fit, memory), purpose),
        }
    }

    /// Writes, for each lattice vertex, the quaternion of the rotation of its region: of the cells around it their
    /// mean.
    pub(crate) fn rotations_at_vertices(&self, rotations: &Lanes<4>, vertices: &mut Vec<[f32; 4]>) {
        let Self { layout, regions, .. } = self;
        vertices.clear();
        vertices.extend(layout.slots().iter().map(|&slot| match regions.half_width().is_cell() {
            false => rotations.get(slot),
            true => mean_rotation(regions.cells_around(layout, slot).map(|cell| rotations.get(cell))),
        }));
    }

    /// Computes the goal positions g from the last fit with [`Purpose::Vertices`].
    pub(crate) fn goals(&self, workspace: &Workspace, executor: &Executor) -> Lanes<3> {
        let mut goals = Lanes::zeros(self.layout.blocks());
        let update = WriteGoals { weights: self.regions.mean_weights() };
        self.cascade.adjoint(&self.layout, executor, workspace, &update, goals.blocks_mut(), &mut []);
        goals
    }

    /// Returns the memory of the layout, the regions and the cascade's tables, in bytes.
    pub(crate) fn bytes(&self) -> usize {
        self.layout.bytes() + self.regions.bytes() + self.cascade.bytes()
    }
}

/// Returns the mean of quaternions of which none is far from the others; the identity without any.
fn mean_rotation(mut quaternions: impl Iterator<Item = [f32; 4]>) -> [f32; 4] {
    let Some(first) = quaternions.next().map(Vector4::from) else { return [0.0, 0.0, 0.0, 1.0] };
    // q and -q are the same rotation.
    let sum = quaternions.map(Vector4::from).fold(first, |sum, q| sum + q * q.dot(&first).signum());
    sum.try_normalize(0.0).unwrap_or(first).into()
}
