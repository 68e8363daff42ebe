//! Runs all passes of the cascade except the adjoint x pass, plane by plane, in scratch memory that stays in
//! the cache.
//!
//! A plane contains the vertices with the same x. Its blocks of eight vertices form lines, which extend along
//! the lanes. A pass along the other axis of the plane crosses the lines: for each line it reads up to w
//! lines on either side from the output of the previous pass, where w is the half-width of the regions. So a
//! plane is divided into strips of at least w lines, and the passes form a pipeline: a pass that crosses the
//! lines processes a strip after the previous pass has processed the next strip.

use std::ops::Range;

use fearless_simd::Simd;

use super::{Purpose, RegionTransform};
use crate::lattice::Layout;
use crate::matching::windows::{RunningSums, Source, Weighted, Window};
use crate::simd::lanes::{Block, Lanes};

/// Minimum number of blocks in a strip. The data of all passes for three strips of this size fit in the L2
/// cache.
const STRIP: usize = 64;

/// Largest number of blocks of a plane that is not divided into strips.
const SMALL_PLANE: usize = 256;

/// Scratch memory of one thread: the outputs of the passes for the blocks of one plane, and the running sums.
#[derive(Clone, Debug)]
pub(super) struct Scratch {
    /// Output of the x pass.
    after_x: Lanes<6>,
    /// Output of the y pass.
    after_y: Lanes<9>,
    /// Output of the z pass, which the transform replaces by its own output.
    after_z: Lanes<12>,
    /// Output of the adjoint z pass.
    adjoint_z: Lanes<9>,
    /// Running sums of the x, y and z passes.
    running: (RunningSums<6>, RunningSums<9>, RunningSums<12>),
    /// Running sums of the adjoint z and y passes.
    running_adjoint: (RunningSums<12>, RunningSums<9>),
    /// Running sums of the adjoint x pass.
    pub(super) running_adjoint_x: RunningSums<6>,
    /// First block of each strip of the plane, then the end of the plane.
    strips: Vec<usize>,
}

impl Scratch {
    /// Allocates scratch memory for planes of up to `blocks` blocks. `[x, y, z]` are the windows of the
    /// passes along x, y and z.
    pub(super) fn new([x, y, z]: &[Window; 3], blocks: usize) -> Self {
        Self {
            running: (
                RunningSums::new(x, blocks, true),
                RunningSums::new(y, blocks, false),
                RunningSums::new(z, blocks, false),
            ),
            running_adjoint: (RunningSums::new(z, blocks, false), RunningSums::new(y, blocks, false)),
            running_adjoint_x: RunningSums::new(x, blocks, true),
            after_x: Lanes::zeros(blocks),
            after_y: Lanes::zeros(blocks),
            after_z: Lanes::zeros(blocks),
            adjoint_z: Lanes::zeros(blocks),
            strips: Vec::with_capacity(blocks + 1),
        }
    }

    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        let (x, y, z) = &self.running;
        let (adjoint_z, adjoint_y) = &self.running_adjoint;
        self.after_x.bytes()
            + self.after_y.bytes()
            + self.after_z.bytes()
            + self.adjoint_z.bytes()
            + (x.bytes()
                + y.bytes()
                + z.bytes()
                + adjoint_z.bytes()
                + adjoint_y.bytes()
                + self.running_adjoint_x.bytes())
            + self.strips.capacity() * size_of::<usize>()
    }

    /// Prepares for the plane whose first block is `first`.
    fn begin_plane(&mut self, first: usize) {
        self.running.0.begin_plane(first);
        self.running.1.begin_plane(first);
        self.running.2.begin_plane(first);
        self.running_adjoint.0.begin_plane(first);
        self.running_adjoint.1.begin_plane(first);
    }

    /// Divides a plane into strips of at least `min_lines` lines. The last strip may have fewer lines.
    fn divide(&mut self, layout: &Layout, plane: usize, min_lines: usize) {
        let blocks = layout.blocks_of(plane..plane + 1);
        self.strips.clear();
        self.strips.push(blocks.start);
        if blocks.len() > SMALL_PLANE {
            let (mut start, mut count) = (blocks.start, 0);
            for line in layout.lines(plane) {
                count += 1;
                if count >= min_lines && line.end - start >= STRIP {
                    self.strips.push(line.end);
                    (start, count) = (line.end, 0);
                }
            }
        }
        if self.strips.last() != Some(&blocks.end) {
            self.strips.push(blocks.end);
        }
    }
}

/// All passes from the x pass to the adjoint y pass.
pub(super) struct PlanePasses<'a, T> {
    pub(super) layout: &'a Layout,
    /// Windows of the passes along x, y and z.
    pub(super) windows: [Window<'a>; 3],
    /// Input of the x pass.
    pub(super) field: Weighted<'a>,
    pub(super) transform: &'a T,
    pub(super) purpose: Purpose,
}

impl<T: RegionTransform> PlanePasses<'_, T> {
    /// Runs the passes over `planes`. `memory` has one entry for each block of these planes. `out` receives
    /// the output of the adjoint y pass for these blocks; it is empty for [`Purpose::Regions`].
    #[inline(always)]
    pub(super) fn run<S: Simd>(
        &self,
        simd: S,
        planes: Range<usize>,
        scratch: &mut Scratch,
        memory: &mut [T::Memory],
        out: &mut [Block<6>],
    ) {
        let [x, y, z] = self.windows;
        let first = self.layout.blocks_of(planes.clone()).start;
        // Lag of each pass behind the x pass, in strips. The lag increases by 1 with each pass that crosses
        // the lines.
        let [lag_y, lag_z, lag_adjoint_z, lag_adjoint_y] =
            if self.layout.lane_axis() == 1 { [0, 1, 2, 2] } else { [1, 1, 1, 2] };
        for plane in planes {
            scratch.divide(self.layout, plane, x.half_width);
            let base = scratch.strips[0];
            scratch.begin_plane(base);
            for front in 0..scratch.strips.len() + 1 {
                let Scratch {
                    after_x, after_y, after_z, adjoint_z, running, running_adjoint, strips, ..
                } = &mut *scratch;
                let ((running_x, running_y, running_z), (running_adjoint_z, running_adjoint_y)) =
                    (running, running_adjoint);
                let strip = |lag: usize| {
                    let index = front.checked_sub(lag)?;
                    Some(*strips.get(index)?..*strips.get(index + 1)?)
                };
                if let Some(blocks) = strip(0) {
                    x.weighted(simd, blocks.clone(), self.field, running_x, output(after_x, blocks, base));
                }
                if let Some(blocks) = strip(lag_y) {
                    let out = output(after_y, blocks.clone(), base);
                    y.forward(simd, blocks, source(after_x, base), running_y, out);
                }
                if let Some(blocks) = strip(lag_z) {
                    let memory = &mut memory[blocks.start - first..blocks.end - first];
                    let sums = output(after_z, blocks.clone(), base);
                    z.forward(simd, blocks.clone(), source(after_y, base), running_z, sums);
                    self.transform.apply(simd, blocks.start, sums, memory);
                }
                if self.purpose == Purpose::Regions {
                    continue;
                }
                if let Some(blocks) = strip(lag_adjoint_z) {
                    let out = output(adjoint_z, blocks.clone(), base);
                    z.adjoint(simd, blocks, source(after_z, base), running_adjoint_z, out);
                }
                if let Some(blocks) = strip(lag_adjoint_y) {
                    let out = &mut out[blocks.start - first..blocks.end - first];
                    y.adjoint(simd, blocks, source(adjoint_z, base), running_adjoint_y, out);
                }
            }
        }
    }
}

/// Returns the input of a pass. `base` is the index in the layout of the first block of `lanes`.
fn source<const N: usize>(lanes: &Lanes<N>, base: usize) -> Source<'_, N> {
    Source { first: base, blocks: lanes.blocks() }
}

/// Returns the part of `lanes` that a pass writes. `base` is the index in the layout of the first block of
/// `lanes`.
fn output<const N: usize>(lanes: &mut Lanes<N>, blocks: Range<usize>, base: usize) -> &mut [Block<N>] {
    &mut lanes.blocks_mut()[blocks.start - base..blocks.end - base]
}
