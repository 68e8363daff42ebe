//! Runs the local-moment cascade, which sums the vectors of the vertices over each region, and its adjoint.
//! Each region defines a field on its vertices; the adjoint sums, at each vertex, the fields of the regions
//! that contain the vertex.
//!
//! The region of half-width w around a center vertex contains the vertices that are connected to the center
//! vertex by up to w links along z, then up to w links along y, then up to w links along x. (i, j, k) is the
//! offset of a vertex from the center vertex, in links. The sums of a region are S = Σ f, Sx = Σ i f,
//! Sy = Σ j f and Sz = Σ k f, where f is the region weight times the vector of a vertex.
//!
//! FastLSM (Rivers & James 2007, section 4) sums moments about the origin. Here moments are about the center
//! of each window. This avoids cancellation, and needs 54 window sums per vertex instead of 72. Each line
//! below that begins with x, y or z is a pass along this axis. W is the plain and W' the offset-weighted
//! window sum along the axis of the pass ([`windows`](super::windows)). The numbers on the right count the
//! components of the input and the output of a pass:
//!
//! ```text
//! x   S = W(f)                          Sx = W'(f)              3 → 6
//! y   S = W(S)  Sx = W(Sx)              Sy = W'(S)              6 → 9
//! z   S = W(S)  Sx = W(Sx)  Sy = W(Sy)  Sz = W'(S)              9 → 12
//!     transform of each region:  (S, Sx, Sy, Sz) → (b, X, Y, Z), for the field b + i X + j Y + k Z
//! z   b = W(b) - W'(Z)  X = W(X)  Y = W(Y)                     12 → 9
//! y   b = W(b) - W'(Y)  X = W(X)                                9 → 6
//! x   b = W(b) - W'(X)                                          6 → 3
//! ```
//!
//! The first three passes are the forward passes. The last three passes are their exact adjoint: at each
//! vertex, they compute the sum of the fields of all regions that contain the vertex.
//!
//! A plane is the set of vertices with the same x. Only the passes along x read other planes. So all passes
//! except the adjoint x pass run plane by plane, in scratch memory that stays in the cache ([`plane`]). The
//! output of the adjoint y pass, six numbers per vertex, is stored for the adjoint x pass.

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

/// The function that is applied to the sums of each region: the fit of a rotation or of a rigid velocity.
pub(crate) trait RegionTransform: Sync {
    /// Data that the transform reads and writes, for each block of eight regions.
    type Memory: Send;
    /// Replaces (S, Sx, Sy, Sz) by (b, X, Y, Z), three components each, in consecutive blocks. `first` is the
    /// index of the first block in the layout.
    fn apply<S: Simd>(&self, simd: S, first: usize, sums: &mut [Block<12>], memory: &mut [Self::Memory]);
}

/// The function that is applied to the sum over the regions that contain each vertex.
pub(crate) trait VertexUpdate: Sync {
    /// Data that the update reads and writes, for each block of eight vertices.
    type Memory: Send;
    /// Result that is accumulated over the vertices of a task, such as sums of momenta.
    type Tally: Send;
    /// Updates the vertices of consecutive blocks. `first` is the index of the first block in the layout.
    /// `region_sums` is, for each vertex, Σ (b + i X + j Y + k Z) over the regions that contain the vertex.
    fn apply<S: Simd>(
        &self,
        simd: S,
        first: usize,
        region_sums: &[Block<3>],
        memory: &mut [Self::Memory],
        tallies: &mut [Self::Tally],
    );
}

/// Returns the interval, in planes, at which running sums along x restart with a direct sum. Running sums
/// within a plane restart at an interval of twice as many lines. Sums over wide windows restart less often,
/// because their direct sums cost more and have larger rounding errors.
fn restart_interval(half_width: usize) -> usize {
    if half_width < 8 { 4 } else { 8 }
}

/// The purpose of a call of [`Cascade::forward`], which determines the last pass that it runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Purpose {
    /// To evaluate each vertex with [`Cascade::adjoint`] afterwards, for example its goal position. All
    /// passes up to the adjoint y pass run.
    Vertices,
    /// To compute only the memory of the transform, for example the rotation of each region. The last pass is
    /// the z pass.
    Regions,
}

/// The local-moment cascade for regions of one half-width, and its division into tasks. A [`Workspace`] has
/// the buffers of the cascade.
#[derive(Clone, Debug)]
pub(crate) struct Cascade {
    half_width: usize,
    /// For each block, the vertices that enter and leave its running sums: along x, then along the axis
    /// across the lines of a plane. `None` if windows are summed directly.
    slides: [Option<Vec<Slide>>; 2],
    /// First plane of each task, then the number of planes. A task consists of whole planes.
    task_planes: Vec<usize>,
    /// First block of each task, then the number of blocks.
    task_blocks: Vec<usize>,
    /// Number of blocks of the largest plane.
    largest_plane: usize,
}

/// The buffers of a cascade. They are allocated at the first use, and allocated again for a cascade of
/// another [`Shape`]. Every use overwrites the buffers.
#[derive(Debug, Default)]
pub(crate) struct Workspace {
    shape: Option<Shape>,
    /// Output of the adjoint y pass for each vertex.
    adjoint_y: Lanes<6>,
    /// Scratch memory of each thread.
    scratch: Vec<Mutex<Scratch>>,
}

/// The parameters that determine the sizes of the buffers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Shape {
    half_width: usize,
    lane_axis: usize,
    /// Whether there are running sums along x, and whether there are running sums across the lines of a
    /// plane.
    running: [bool; 2],
    blocks: usize,
    largest_plane: usize,
}

impl Workspace {
    /// Returns the memory of the buffers, in bytes.
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
    /// Creates the cascade for regions of half-width `half_width`, in cells, at least 1.
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
                |_, position| position.is_multiple_of(2 * interval),
            ),
        ];
        // With running sums along x, a task ends only before a plane at which these sums restart. So no task
        // reads the sums of another task.
        let planes_per_group = if slides[0].is_some() { interval } else { 1 };
        let (mut task_planes, mut task_blocks, mut largest_plane) = (vec![0], vec![0], 0);
        for plane in 0..layout.planes() {
            let blocks = layout.blocks_of(plane..plane + 1);
            largest_plane = largest_plane.max(blocks.len());
            let is_full = blocks.end - task_blocks[task_blocks.len() - 1] >= CHUNK
                && (plane + 1).is_multiple_of(planes_per_group);
            if is_full || blocks.end == layout.blocks() {
                task_planes.push(plane + 1);
                task_blocks.push(blocks.end);
            }
        }
        Self { half_width, slides, task_planes, task_blocks, largest_plane }
    }

    /// Creates a workspace with the buffers of all passes, for one thread.
    pub(crate) fn workspace(&self, layout: &Layout) -> Workspace {
        let mut workspace = Workspace::default();
        self.reserve(&mut workspace, layout, Purpose::Vertices, 1);
        workspace
    }

    /// Allocates missing buffers for `purpose` and `threads` threads. Replaces the buffers of a cascade of
    /// another [`Shape`].
    fn reserve(&self, workspace: &mut Workspace, layout: &Layout, purpose: Purpose, threads: usize) {
        let Self { half_width, largest_plane, .. } = *self;
        let running = [0, 1].map(|axis| self.slides[axis].is_some());
        let (lane_axis, blocks) = (layout.lane_axis(), layout.blocks());
        let shape = Some(Shape { half_width, lane_axis, running, blocks, largest_plane });
        if workspace.shape != shape {
            *workspace = Workspace { shape, ..Workspace::default() };
        }
        let Workspace { adjoint_y, scratch, .. } = workspace;
        if purpose == Purpose::Vertices && adjoint_y.blocks().is_empty() {
            *adjoint_y = Lanes::zeros(layout.blocks());
        }
        if scratch.len() < threads {
            let windows = self.windows(layout);
            scratch.resize_with(threads, || Mutex::new(Scratch::new(&windows, self.largest_plane)));
        }
    }

    /// Returns the windows of the passes along x, y and z.
    fn windows<'a>(&'a self, layout: &'a Layout) -> [Window<'a>; 3] {
        [0, 1, 2].map(|axis| {
            let slides = self.slides[usize::from(axis != 0)].as_deref();
            let slides = slides.filter(|_| axis != layout.lane_axis());
            let (half_width, occupied) = (self.half_width, layout.occupied());
            Window { axis: layout.axis(axis), half_width, occupied, slides }
        })
    }

    /// Returns the memory of the tables of running sums, in bytes.
    pub(crate) fn bytes(&self) -> usize {
        self.slides.iter().flatten().map(|slides| size_of_val(slides.as_slice())).sum()
    }

    /// Returns the number of tasks.
    pub(crate) fn tasks(&self) -> usize {
        self.task_planes.len() - 1
    }

    /// Returns the first block of each task, then the number of blocks.
    pub(crate) fn task_blocks(&self) -> &[usize] {
        &self.task_blocks
    }

    /// Sums `field` over each region and transforms the sums. With [`Purpose::Vertices`], also runs the adjoint
    /// z and y passes, so that [`Cascade::adjoint`] can run the adjoint x pass. `memory` has one entry for
    /// each block of eight regions.
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
            Purpose::Vertices => adjoint_y.blocks_mut(),
            Purpose::Regions => &mut [],
        };
        executor.tasks(&self.task_blocks, (out, memory, &mut []), |task, out, memory, _: &mut [()]| {
            let mut scratch = workspace.scratch(executor);
            let planes = self.task_planes[task]..self.task_planes[task + 1];
            dispatch!(level(), simd => passes.run(simd, planes, &mut scratch, memory, out));
        });
        workspace.adjoint_y = adjoint_y;
    }

    /// Runs the adjoint x pass, which completes the sum over the regions that contain each vertex, and
    /// updates the vertices. `memory` has one entry for each block of eight vertices. `tallies` is divided
    /// equally between the tasks.
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
        executor.tasks(
            &self.task_blocks,
            (memory, &mut [], tallies),
            |task, memory, _: &mut [()], tallies| {
                let mut scratch = workspace.scratch(executor);
                let planes = self.task_planes[task]..self.task_planes[task + 1];
                dispatch!(level(), simd => pass.run(simd, planes, &mut scratch, memory, tallies));
            },
        );
    }
}

/// Locks scratch memory. Ignores poisoning, because every use overwrites the scratch memory.
fn locked(scratch: &Mutex<Scratch>) -> MutexGuard<'_, Scratch> {
    scratch.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Returns, for each block, the index of its plane.
fn plane_of(layout: &Layout) -> Vec<usize> {
    (0..layout.planes()).flat_map(|plane| layout.blocks_of(plane..plane + 1).map(move |_| plane)).collect()
}
