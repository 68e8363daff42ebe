//! Runs the local-moment cascade, which sums the vectors of the vertices over each region, and its adjoint.
//! Each region defines a field on its vertices; the adjoint sums, at each vertex, the fields of the regions
//! that contain the vertex.
//!
//! The region of half-width w around a center vertex contains the vertices that are connected to the center
//! vertex by up to w links along z, then up to w links along y, then up to w links along x. (i, j, k) is the
//! offset of a vertex from the center vertex, in links. The sums of a region are S = Σ f, Sx = Σ i f,
//! Sy = Σ j f and Sz = Σ k f, where f is the region weight times the vector of a vertex.
//!
//! The regions of half-width 1/2 are the cells. The sums of a cell have the place of its first corner; in place of
//! the center vertex stands the center of the cell, so that i, j and k of its corners are -1/2 and 1/2. A window of a
//! forward pass has the vertex in its place and the next one, and one of an adjoint pass the vertex before it.
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
//! At the front of a crack, links do not join all corners of a cell. If the regions are cells, the sums of such a
//! cell have its eight corners nevertheless ([`loose`]).
//!
//! A plane is the set of blocks with the same x. Only the passes along x read other planes. So all passes
//! except the adjoint x pass run plane by plane, in scratch memory that stays in the cache ([`plane`]). The
//! output of the adjoint y pass, six numbers per vertex, is stored for the adjoint x pass.

mod adjoint_x;
mod loose;
mod plane;
mod transform;
mod workspace;

pub(crate) use transform::{Purpose, RegionTransform, VertexUpdate};
pub(crate) use workspace::{Workspace, Workspaces};

use fearless_simd::dispatch;

use super::half_width::HalfWidth;
use super::windows::{Method, Weighted, Window};
use crate::lattice::Layout;
use crate::parallel::{Executor, LEAST_TASK, Split, is_one_task};
use crate::simd::level;
use adjoint_x::AdjointX;
use loose::Loose;
use plane::{PlanePasses, Sizes, Strips, Windows};

/// The interval, in planes, at which running sums along x restart with a direct sum, which limits their rounding
/// errors. Running sums within a plane restart at an interval of twice as many blocks.
const RESTART_INTERVAL: usize = 4;

/// The local-moment cascade for regions of one half-width, and its division into tasks. A [`Workspace`] has
/// the buffers of the cascade.
#[derive(Clone, Debug)]
pub(crate) struct Cascade {
    half_width: HalfWidth,
    /// How the windows along x, y and z are summed.
    methods: [Method; 3],
    strips: Strips,
    /// First plane of each task, then the number of planes. A task consists of whole planes.
    task_planes: Vec<usize>,
    /// First block of each task, then the number of blocks.
    task_blocks: Vec<usize>,
    /// Number of loose cells; 0 unless the regions are cells.
    loose: usize,
}

impl Cascade {
    /// Creates the cascade for regions of half-width `half_width`.
    pub(super) fn new(layout: &Layout, half_width: HalfWidth) -> Self {
        let plane_of = plane_of(layout);
        let methods = [0, 1, 2].map(|axis| {
            let restart = |block: usize, position: usize| match axis {
                0 => plane_of[block].is_multiple_of(RESTART_INTERVAL),
                _ => position.is_multiple_of(2 * RESTART_INTERVAL),
            };
            Method::new(layout, axis, half_width, restart)
        });
        // With running sums along x, a task ends only before a plane at which these sums restart. So no task
        // reads the sums of another task.
        let planes_per_group = if methods[0].is_running() { RESTART_INTERVAL } else { 1 };
        let least = if is_one_task(layout.blocks()) { layout.blocks() } else { LEAST_TASK };
        let (mut task_planes, mut task_blocks) = (vec![0], vec![0]);
        for plane in 0..layout.planes() {
            let blocks = layout.blocks_of(plane..plane + 1);
            let is_full = blocks.end - task_blocks[task_blocks.len() - 1] >= least
                && (plane + 1).is_multiple_of(planes_per_group);
            if is_full || blocks.end == layout.blocks() {
                task_planes.push(plane + 1);
                task_blocks.push(blocks.end);
            }
        }
        let strips = Strips::new(layout, half_width.links());
        let loose = if half_width.is_cell() { layout.loose_cells().all().len() } else { 0 };
        Self { half_width, methods, strips, task_planes, task_blocks, loose }
    }

    /// Returns the sizes of the buffers of the cascade.
    pub(crate) fn sizes(&self) -> Sizes {
        let blocks = self.task_blocks[self.tasks()];
        let [plane, strip] = self.strips.largest;
        let has_running = self.methods.each_ref().map(Method::is_running);
        Sizes { blocks, plane, strip, has_running, loose: self.loose }
    }

    /// Returns the loose cells with their motions, if there are any.
    fn loose<'a>(&self, layout: &'a Layout, workspace: &'a Workspace) -> Option<Loose<'a>> {
        (self.loose > 0).then(|| Loose { cells: layout.loose_cells(), motions: &workspace.loose })
    }

    /// Returns buffers for one thread.
    pub(crate) fn workspace(&self) -> Workspace {
        let mut workspace = Workspace::default();
        workspace.reserve(self.sizes(), Purpose::Vertices, 1);
        workspace
    }

    /// Returns the windows of the passes along x, y and z.
    fn windows<'a>(&'a self, layout: &'a Layout) -> Windows<'a> {
        (self.window(layout), self.window(layout), self.window(layout))
    }

    fn window<'a, const AXIS: usize>(&'a self, layout: &'a Layout) -> Window<'a, AXIS> {
        Window { axis: layout.axis(AXIS), half_width: self.half_width.links(), method: &self.methods[AXIS] }
    }

    /// Returns the memory of the strips and of the tables of the windows, in bytes.
    pub(super) fn bytes(&self) -> usize {
        self.strips.bytes() + self.methods.iter().map(Method::bytes).sum::<usize>()
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
    pub(crate) fn forward<M: Split, T: RegionTransform<M>>(
        &self,
        layout: &Layout,
        executor: &Executor,
        workspace: &mut Workspace,
        field: Weighted,
        (transform, memory): (&T, M),
        purpose: Purpose,
    ) {
        // A single task runs on one thread, and needs the scratch memory of one.
        let threads = if self.tasks() == 1 { 1 } else { executor.threads() };
        workspace.reserve(self.sizes(), purpose, threads);
        let mut adjoint_y = std::mem::take(&mut workspace.adjoint_y);
        let passes = PlanePasses {
            layout,
            strips: &self.strips,
            windows: self.windows(layout),
            field,
            transform,
            loose: self.loose(layout, workspace),
            purpose,
        };
        let out = match purpose {
            Purpose::Vertices => adjoint_y.blocks_mut(),
            Purpose::Regions => &mut [],
        };
        executor.tasks(&self.task_blocks, (out, memory, &mut []), |task, out, memory: M, _: &mut [()]| {
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
        let loose = self.loose(layout, workspace);
        let pass = AdjointX { layout, x: self.window(layout), source, loose, update };
        executor.tasks(&self.task_blocks, (memory, (), tallies), |task, memory, (), tallies| {
            let mut scratch = workspace.scratch(executor);
            let planes = self.task_planes[task]..self.task_planes[task + 1];
            dispatch!(level(), simd => pass.run(simd, planes, &mut scratch, memory, tallies));
        });
    }
}

/// Returns, for each block, the index of its plane.
fn plane_of(layout: &Layout) -> Vec<usize> {
    (0..layout.planes()).flat_map(|plane| layout.blocks_of(plane..plane + 1).map(move |_| plane)).collect()
}
