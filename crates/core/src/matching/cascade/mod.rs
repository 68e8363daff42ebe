//! The local-moment cascade and its adjoint: sums of a vertex field over all regions, and back.
//!
//! Region r of half-width w holds the vertices reached from its center vertex r by up to w links in z, then in y,
//! then in x. FastLSM (Rivers & James 2007, section 4) sums global moments; here the moments are taken about each
//! window's own center, which needs 54 window sums in place of 72 and cancels nothing. With (i, j, k) the offset
//! from the center, W and W' the plain and the offset-weighted window sum of a pass:
//!
//! ```text
//! x   S = W(f)                          Sx = W'(f)              3 → 6
//! y   S = W(S)  Sx = W(Sx)              Sy = W'(S)              6 → 9
//! z   S = W(S)  Sx = W(Sx)  Sy = W(Sy)  Sz = W'(S)              9 → 12
//!     a transform of each region:  (S, Sx, Sy, Sz) → (b, X, Y, Z), the field b + i X + j Y + k Z on the region
//! z   b = W(b) - W'(Z)  X = W(X)  Y = W(Y)                     12 → 9
//! y   b = W(b) - W'(Y)  X = W(X)                                9 → 6
//! x   b = W(b) - W'(X)                                          6 → 3
//! ```
//!
//! The second half is the exact adjoint of the first: vertex i gathers from the regions that hold i.
//!
//! Only the passes along x lead from plane to plane. So all from the first to the last but one run plane by plane
//! in scratch that stays in the cache ([`plane`]), and one array of six numbers is all that is kept between.

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

/// A function of the sums of each region.
pub(crate) trait RegionTransform: Sync {
    /// What the transform keeps for a block of regions.
    type Memory: Send;
    /// (S, Sx, Sy, Sz) → (b, X, Y, Z), three components each, of the blocks from `first` on.
    fn apply<S: Simd>(&self, simd: S, first: usize, sums: &mut [Block<12>], memory: &mut [Self::Memory]);
}

/// A function of the values that each vertex gathers from its regions.
pub(crate) trait VertexUpdate: Sync {
    /// What the update writes for a block of vertices.
    type Memory: Send;
    /// What is summed over the vertices of a task.
    type Tally: Send;
    /// Takes Σ (b + i X + j Y + k Z) over the regions that hold a vertex, of the blocks from `first` on.
    fn apply<S: Simd>(
        &self,
        simd: S,
        first: usize,
        region_sums: &[Block<3>],
        memory: &mut [Self::Memory],
        tallies: &mut [Self::Tally],
    );
}

/// Planes after which running sums begin anew, as do those within a plane after twice as many lines. To begin a wide
/// window costs more, and its own sums round more.
fn planes_of_a_run(half_width: usize) -> usize {
    if half_width < 8 { 4 } else { 8 }
}

/// How far [`Cascade::forward`] goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Purpose {
    /// On to the adjoint z and y passes.
    Adjoint,
    /// Up to the transform, whose memory is the result.
    Transform,
}

/// The window sums over the regions of one half-width: how they are cut into tasks. Its buffers are a
/// [`Workspace`].
#[derive(Clone, Debug)]
pub(crate) struct Cascade {
    half_width: usize,
    /// Of running sums: the terms that enter and leave, along x and along the axis across the lines of a plane.
    slides: [Option<Vec<Slide>>; 2],
    /// Tasks are whole planes: the first of each, and the end.
    tasks: Vec<usize>,
    /// The first block of each task, and the end.
    bounds: Vec<usize>,
    /// The most blocks in a plane.
    largest_plane: usize,
}

/// The buffers of a cascade, made at the first use and again for a cascade of another shape. Every use overwrites
/// them.
#[derive(Debug, Default)]
pub(crate) struct Workspace {
    shape: Option<Shape>,
    /// The fields of the regions after the adjoint y pass, by block.
    adjoint_y: Lanes<6>,
    /// One for each thread.
    scratch: Vec<Mutex<Scratch>>,
}

/// All that the sizes of the buffers depend on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Shape {
    half_width: usize,
    lane_axis: usize,
    /// Whether there are running sums along x, and across the lines of a plane.
    runs: [bool; 2],
    blocks: usize,
    largest_plane: usize,
}

impl Workspace {
    /// Memory that the buffers take.
    pub(crate) fn bytes(&self) -> usize {
        let scratch = self.scratch.iter().map(|scratch| locked(scratch).bytes());
        self.adjoint_y.bytes() + scratch.sum::<usize>()
    }

    /// The scratch of the calling thread.
    fn scratch(&self, executor: &Executor) -> MutexGuard<'_, Scratch> {
        locked(&self.scratch[executor.worker() % self.scratch.len()])
    }
}

impl Cascade {
    /// The cascade over regions of half-width `half_width` in cells, at least 1.
    pub(crate) fn new(layout: &Layout, half_width: usize) -> Self {
        let run = planes_of_a_run(half_width);
        let plane_of = plane_of(layout);
        let slides = [
            windows::slides(layout.axis(0), half_width, layout.occupied(), |block, _| {
                plane_of[block].is_multiple_of(run)
            }),
            windows::slides(
                layout.axis(3 - layout.lane_axis()),
                half_width,
                layout.occupied(),
                |_, place| place.is_multiple_of(2 * run),
            ),
        ];
        // Running sums along x begin anew with each task.
        let together = if slides[0].is_some() { run } else { 1 };
        let (mut tasks, mut bounds, mut largest_plane) = (vec![0], vec![0], 0);
        for plane in 0..layout.planes() {
            let blocks = layout.blocks_of(plane..plane + 1);
            largest_plane = largest_plane.max(blocks.len());
            let full = blocks.end - bounds[bounds.len() - 1] >= CHUNK && (plane + 1).is_multiple_of(together);
            if full || blocks.end == layout.blocks() {
                tasks.push(plane + 1);
                bounds.push(blocks.end);
            }
        }
        Self { half_width, slides, tasks, bounds, largest_plane }
    }

    /// Buffers of all passes, for one thread.
    pub(crate) fn workspace(&self, layout: &Layout) -> Workspace {
        let mut workspace = Workspace::default();
        self.reserve(&mut workspace, layout, Purpose::Adjoint, 1);
        workspace
    }

    /// Makes the buffers that are missing, or of another shape.
    fn reserve(&self, workspace: &mut Workspace, layout: &Layout, purpose: Purpose, threads: usize) {
        let Self { half_width, largest_plane, .. } = *self;
        let runs = [0, 1].map(|axis| self.slides[axis].is_some());
        let (lane_axis, blocks) = (layout.lane_axis(), layout.blocks());
        let shape = Some(Shape { half_width, lane_axis, runs, blocks, largest_plane });
        if workspace.shape != shape {
            *workspace = Workspace { shape, ..Workspace::default() };
        }
        let Workspace { adjoint_y, scratch, .. } = workspace;
        if purpose == Purpose::Adjoint && adjoint_y.blocks().is_empty() {
            *adjoint_y = Lanes::zeros(layout.blocks());
        }
        if scratch.len() < threads {
            let windows = self.windows(layout);
            scratch.resize_with(threads, || Mutex::new(Scratch::new(&windows, self.largest_plane)));
        }
    }

    /// The passes x, y, z.
    fn windows<'a>(&'a self, layout: &'a Layout) -> [Window<'a>; 3] {
        [0, 1, 2].map(|axis| {
            let slides = self.slides[usize::from(axis != 0)].as_deref();
            let slides = slides.filter(|_| axis != layout.lane_axis());
            let (half_width, occupied) = (self.half_width, layout.occupied());
            Window { axis: layout.axis(axis), half_width, occupied, slides }
        })
    }

    /// Memory that the tables take.
    pub(crate) fn bytes(&self) -> usize {
        self.slides.iter().flatten().map(|slides| size_of_val(slides.as_slice())).sum()
    }

    /// The number of tasks.
    pub(crate) fn tasks(&self) -> usize {
        self.tasks.len() - 1
    }

    /// The first block of each task, and the end.
    pub(crate) fn bounds(&self) -> &[usize] {
        &self.bounds
    }

    /// Sums `field` over each region and transforms the sums. With [`Purpose::Adjoint`] the adjoint passes z and y
    /// follow, for [`Cascade::adjoint`] to complete.
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
            Purpose::Adjoint => adjoint_y.blocks_mut(),
            Purpose::Transform => &mut [],
        };
        executor.tasks(&self.bounds, (out, memory, &mut []), |task, out, memory, _: &mut [()]| {
            let mut scratch = workspace.scratch(executor);
            let planes = self.tasks[task]..self.tasks[task + 1];
            dispatch!(level(), simd => passes.run(simd, planes, &mut scratch, memory, out));
        });
        workspace.adjoint_y = adjoint_y;
    }

    /// The adjoint x pass: each vertex gathers the fields of the regions that hold it, and is updated. `tallies`:
    /// equally many for each task.
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

/// The number of the plane of each block.
fn plane_of(layout: &Layout) -> Vec<usize> {
    (0..layout.planes()).flat_map(|plane| layout.blocks_of(plane..plane + 1).map(move |_| plane)).collect()
}
