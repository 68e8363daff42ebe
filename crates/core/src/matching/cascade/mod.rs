//! The local-moment cascade, which sums a vertex field over all regions, and its adjoint, which sums region
//! fields over the regions of each vertex.
//!
//! Region r of half-width w contains the vertices that are connected to its center vertex r by up to w links
//! in z, then up to w links in y, then up to w links in x. FastLSM (Rivers & James 2007, section 4) sums
//! moments about the origin. Here the moments are about the center of each window, which takes 54 window sums
//! per vertex instead of 72 and avoids cancellation. (i, j, k) is the offset from the center in links; W is
//! the plain and W' the offset-weighted window sum along the axis of a pass. The numbers of components before
//! and after each pass are on the right:
//!
//! ```text
//! x   S = W(f)                          Sx = W'(f)              3 → 6
//! y   S = W(S)  Sx = W(Sx)              Sy = W'(S)              6 → 9
//! z   S = W(S)  Sx = W(Sx)  Sy = W(Sy)  Sz = W'(S)              9 → 12
//!     transform of each region:  (S, Sx, Sy, Sz) → (b, X, Y, Z), the field b + i X + j Y + k Z on the region
//! z   b = W(b) - W'(Z)  X = W(X)  Y = W(Y)                     12 → 9
//! y   b = W(b) - W'(Y)  X = W(X)                                9 → 6
//! x   b = W(b) - W'(X)                                          6 → 3
//! ```
//!
//! The last three passes are the exact adjoint of the first three: each vertex sums over the regions that
//! contain it.
//!
//! Only the passes along x read other planes. So all passes except the adjoint x pass run plane by plane, in
//! scratch memory that stays in the cache ([`plane`]). Between them and the adjoint x pass, six numbers per
//! vertex are stored.

mod adjoint_x;
mod plane;

use std::sync::{Mutex, MutexGuard, PoisonError};

use fearless_simd::{Simd, dispatch};

use super::windows::{self, Slide, Weighted, Window};
use crate::lattice::Layout;
use crate::parallel::{CHUNK, Executor};
use crate::simd::lanes::{Block, Lanes};
use crate::simd::level;
use adjoint_x::AdjointX;
use plane::{PlanePasses, Scratch};

/// A function that is applied to the sums of each region: the fit of the rotations, or region damping.
pub(crate) trait RegionTransform: Sync {
    /// Data that the transform reads and writes, per block of regions.
    type Memory: Send;
    /// Replaces (S, Sx, Sy, Sz) by (b, X, Y, Z), three components each, in the blocks from `first` on.
    fn apply<S: Simd>(&self, simd: S, first: usize, sums: &mut [Block<12>], memory: &mut [Self::Memory]);
}

/// A function that is applied to the sum over the regions of each vertex.
pub(crate) trait VertexUpdate: Sync {
    /// Data that the update reads and writes, per block of vertices.
    type Memory: Send;
    /// Sum over the vertices of a task.
    type Tally: Send;
    /// Updates the vertices of the blocks from `first` on. `region_sums` is Σ (b + i X + j Y + k Z) over the
    /// regions that contain each vertex.
    fn apply<S: Simd>(
        &self,
        simd: S,
        first: usize,
        region_sums: &[Block<3>],
        memory: &mut [Self::Memory],
        tallies: &mut [Self::Tally],
    );
}

/// Interval in planes at which running sums along x restart. Running sums within a plane restart at twice as
/// many lines. Wide windows restart less often: a restart costs more, and their direct sums have larger
/// rounding errors.
fn restart_interval(half_width: usize) -> usize {
    if half_width < 8 { 4 } else { 8 }
}

/// The last pass of [`Cascade::forward`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Purpose {
    /// Prepares the adjoint, which evaluates the goals: runs up to the adjoint y pass.
    Goals,
    /// Computes the memory of the transform, such as the rotations: runs up to the z pass.
    Regions,
}

/// The local-moment cascade for regions of one half-width, and its division into tasks. Its buffers are in a
/// [`Workspace`].
#[derive(Clone, Debug)]
pub(crate) struct Cascade {
    half_width: usize,
    /// Steps of the running sums along x, and along the axis across the lines of a plane. `None` where
    /// windows are summed directly.
    slides: [Option<Vec<Slide>>; 2],
    /// First plane of each task, then the number of planes. Tasks are whole planes.
    tasks: Vec<usize>,
    /// First block of each task, then the number of blocks.
    bounds: Vec<usize>,
    /// Number of blocks of the largest plane.
    largest_plane: usize,
}

/// The buffers of a cascade. They are allocated at the first use, and again for a cascade of another
/// [`Shape`]. Every use overwrites them.
#[derive(Debug, Default)]
pub(crate) struct Workspace {
    shape: Option<Shape>,
    /// Output of the adjoint y pass, by block.
    adjoint_y: Lanes<6>,
    /// Scratch memory of each thread.
    scratch: Vec<Mutex<Scratch>>,
}

/// The parameters that determine the sizes of the buffers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Shape {
    half_width: usize,
    lane_axis: usize,
    /// Whether there are running sums along x, and across the lines of a plane.
    running: [bool; 2],
    blocks: usize,
    largest_plane: usize,
}

impl Workspace {
    /// Memory of the buffers in bytes.
    pub(crate) fn bytes(&self) -> usize {
        let scratch = self.scratch.iter().map(|scratch| locked(scratch).bytes());
        self.adjoint_y.bytes() + scratch.sum::<usize>()
    }

    /// Locks the scratch memory of the calling thread.
    fn scratch(&self, executor: &Executor) -> MutexGuard<'_, Scratch> {
        locked(&self.scratch[executor.worker() % self.scratch.len()])
    }
}

impl Cascade {
    /// Creates the cascade for regions of half-width `half_width` in cells, at least 1.
    pub(crate) fn new(layout: &Layout, half_width: usize) -> Self {
        let interval = restart_interval(half_width);
        let plane_of = plane_of(layout);
        let slides = [
            windows::slides(layout.axis(0), half_width, layout.occupied(), |block, _| {
                plane_of[block].is_multiple_of(interval)
            }),
            windows::slides(
                layout.axis(3 - layout.lane_axis()),
                half_width,
                layout.occupied(),
                |_, place| place.is_multiple_of(2 * interval),
            ),
        ];
        // Running sums along x restart at the first plane of each task.
        let group = if slides[0].is_some() { interval } else { 1 };
        let (mut tasks, mut bounds, mut largest_plane) = (vec![0], vec![0], 0);
        for plane in 0..layout.planes() {
            let blocks = layout.blocks_of(plane..plane + 1);
            largest_plane = largest_plane.max(blocks.len());
            let full = blocks.end - bounds[bounds.len() - 1] >= CHUNK && (plane + 1).is_multiple_of(group);
            if full || blocks.end == layout.blocks() {
                tasks.push(plane + 1);
                bounds.push(blocks.end);
            }
        }
        Self { half_width, slides, tasks, bounds, largest_plane }
    }

    /// Allocates the buffers of all passes, for one thread.
    pub(crate) fn workspace(&self, layout: &Layout) -> Workspace {
        let mut workspace = Workspace::default();
        self.reserve(&mut workspace, layout, Purpose::Goals, 1);
        workspace
    }

    /// Allocates the buffers that are missing or have another shape.
    fn reserve(&self, workspace: &mut Workspace, layout: &Layout, purpose: Purpose, threads: usize) {
        let Self { half_width, largest_plane, .. } = *self;
        let running = [0, 1].map(|axis| self.slides[axis].is_some());
        let (lane_axis, blocks) = (layout.lane_axis(), layout.blocks());
        let shape = Some(Shape { half_width, lane_axis, running, blocks, largest_plane });
        if workspace.shape != shape {
            *workspace = Workspace { shape, ..Workspace::default() };
        }
        let Workspace { adjoint_y, scratch, .. } = workspace;
        if purpose == Purpose::Goals && adjoint_y.blocks().is_empty() {
            *adjoint_y = Lanes::zeros(layout.blocks());
        }
        if scratch.len() < threads {
            let windows = self.windows(layout);
            scratch.resize_with(threads, || Mutex::new(Scratch::new(&windows, self.largest_plane)));
        }
    }

    /// The windows of the passes along x, y and z.
    fn windows<'a>(&'a self, layout: &'a Layout) -> [Window<'a>; 3] {
        [0, 1, 2].map(|axis| {
            let slides = self.slides[usize::from(axis != 0)].as_deref();
            let slides = slides.filter(|_| axis != layout.lane_axis());
            let (half_width, occupied) = (self.half_width, layout.occupied());
            Window { axis: layout.axis(axis), half_width, occupied, slides }
        })
    }

    /// Memory of the tables in bytes.
    pub(crate) fn bytes(&self) -> usize {
        self.slides.iter().flatten().map(|slides| size_of_val(slides.as_slice())).sum()
    }

    /// The number of tasks.
    pub(crate) fn tasks(&self) -> usize {
        self.tasks.len() - 1
    }

    /// The first block of each task, then the number of blocks.
    pub(crate) fn bounds(&self) -> &[usize] {
        &self.bounds
    }

    /// Sums `field` over each region and transforms the sums. With [`Purpose::Goals`] it also runs the
    /// adjoint z and y passes; [`Cascade::adjoint`] then runs the adjoint x pass.
    pub(crate) fn forward<T: RegionTransform>(
        &self,
        layout: &Layout,
        executor: &Executor,
        workspace: &mut Workspace,
        field: Weighted,
        (transform, memory): (&T, &mut [T::Memory]),
        purpose: Purpose,
    ) {
        self.reserve(workspace, layout, purpose, executor.threads());
        let mut adjoint_y = std::mem::take(&mut workspace.adjoint_y);
        let passes = PlanePasses { layout, windows: self.windows(layout), field, transform, purpose };
        let out = match purpose {
            Purpose::Goals => adjoint_y.blocks_mut(),
            Purpose::Regions => &mut [],
        };
        executor.tasks(&self.bounds, (out, memory, &mut []), |task, out, memory, _: &mut [()]| {
            let mut scratch = workspace.scratch(executor);
            let planes = self.tasks[task]..self.tasks[task + 1];
            dispatch!(level(), simd => passes.run(simd, planes, &mut scratch, memory, out));
        });
        workspace.adjoint_y = adjoint_y;
    }

    /// Runs the adjoint x pass, which completes the sums over the regions that contain each vertex, and
    /// updates the vertices. `tallies` has the same number of entries for each task.
    pub(crate) fn adjoint<U: VertexUpdate>(
        &self,
        layout: &Layout,
        executor: &Executor,
        workspace: &Workspace,
        update: &U,
        memory: &mut [U::Memory],
        tallies: &mut [U::Tally],
    ) {
        let source = workspace.adjoint_y.blocks();
        let pass = AdjointX { layout, x: self.windows(layout)[0], source, update };
        executor.tasks(&self.bounds, (memory, &mut [], tallies), |task, memory, _: &mut [()], tallies| {
            let mut scratch = workspace.scratch(executor);
            let planes = self.tasks[task]..self.tasks[task + 1];
            dispatch!(level(), simd => pass.run(simd, planes, &mut scratch, memory, tallies));
        });
    }
}

/// Ignores poisoning: every use overwrites the scratch.
fn locked(scratch: &Mutex<Scratch>) -> MutexGuard<'_, Scratch> {
    scratch.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Returns the index of the plane of each block.
fn plane_of(layout: &Layout) -> Vec<usize> {
    (0..layout.planes()).flat_map(|plane| layout.blocks_of(plane..plane + 1).map(move |_| plane)).collect()
}
