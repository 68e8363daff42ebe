//! Lattice shape matching: regions, window sums, the local-moment cascade and its adjoint, rotations, goal
//! positions.
//!
//! | file | contents |
//! |---|---|
//! | `regions` | the region weights m/n, and the mass, rest centroid and rest inertia of each region |
//! | `windows` | plain and offset-weighted window sums along one axis |
//! | `cascade` | sums over all regions by window sums along x, y and z, and their adjoint |
//! | `rotation` | the rotation of a region: Newton's method with an eigenvalue test, and the robust path |
//! | `goals` | the rigid motion of each region, and the goal positions g |

mod cascade;
mod goals;
mod regions;
mod rotation;
mod windows;

pub(crate) use cascade::{Cascade, Purpose, RegionTransform, VertexUpdate, Workspace};
pub(crate) use goals::{Means, PotentialSums};
pub(crate) use regions::Regions;
pub(crate) use rotation::columns;
pub use rotation::rotations;
pub(crate) use windows::Weighted;

use std::sync::atomic::AtomicUsize;

use crate::lattice::{Lattice, Layout};
use crate::parallel::Executor;
use crate::simd::lanes::Lanes;
use goals::{FitRotations, WriteGoals};

/// The shape-matching stage: the regions of a lattice and the sums over them. Its buffers are in a
/// [`Workspace`].
#[derive(Clone, Debug)]
pub(crate) struct Matching {
    pub(crate) layout: Layout,
    pub(crate) regions: Regions,
    pub(crate) cascade: Cascade,
}

impl Matching {
    /// Creates the stage for regions of half-width `half_width` in cells, at least 1.
    pub(crate) fn new(lattice: &Lattice, half_width: usize) -> Self {
        Self::with_layout(lattice, Layout::new(lattice), half_width)
    }

    /// Changes the half-width of the regions; `lattice` is unchanged.
    pub(crate) fn set_half_width(&mut self, lattice: &Lattice, half_width: usize) {
        *self = Self::with_layout(lattice, self.layout.clone(), half_width);
    }

    fn with_layout(lattice: &Lattice, layout: Layout, half_width: usize) -> Self {
        let regions = Regions::new(lattice, &layout, half_width);
        let cascade = Cascade::new(&layout, half_width);
        Self { layout, regions, cascade }
    }

    /// Fits a rigid motion to each region at `positions`. `rotations` is the warm start and receives the
    /// result; `potential` receives the elastic potential. [`Purpose::Goals`] prepares the evaluation of
    /// goal positions.
    ///
    /// Returns the number of rotations that did not converge in Newton's method and went through the robust
    /// path.
    pub(crate) fn fit(
        &self,
        workspace: &mut Workspace,
        executor: &Executor,
        (positions, rotations): (&Lanes<3>, &mut Lanes<4>),
        potential: Option<&PotentialSums>,
        purpose: Purpose,
    ) -> usize {
        let unconverged = AtomicUsize::new(0);
        let field = Weighted { weights: self.regions.weights.blocks(), vectors: positions.blocks() };
        let fit = FitRotations {
            constants: &self.regions.constants,
            occupied: self.layout.occupied(),
            half_width: self.regions.half_width() as f32,
            unconverged: &unconverged,
            potential,
        };
        let memory = rotations.blocks_mut();
        self.cascade.forward(&self.layout, executor, workspace, field, (&fit, memory), purpose);
        unconverged.into_inner()
    }

    /// Computes the goal positions g from the last fit.
    pub(crate) fn goals(&self, workspace: &Workspace, executor: &Executor) -> Lanes<3> {
        let mut goals = Lanes::zeros(self.layout.blocks());
        let update = WriteGoals { weights: &self.regions.weights };
        self.cascade.adjoint(&self.layout, executor, workspace, &update, goals.blocks_mut(), &mut []);
        goals
    }

    /// Memory of the layout, the regions and the tables, in bytes.
    pub(crate) fn bytes(&self) -> usize {
        self.layout.bytes() + self.regions.bytes() + self.cascade.bytes()
    }
}
