//! Runs all passes of the cascade except the adjoint x pass, plane by plane, in scratch memory that stays in
//! the cache.
//!
//! A plane contains the blocks with the same x. They form lines along z. The passes along y cross the lines: for each
//! line they read lines on either side from the output of the previous pass, up to half as many as the half-width of
//! the regions. A plane is divided into strips of at least this number of lines, and the passes form a pipeline: a pass
//! along y processes a strip after the previous pass has processed the next strip. The passes along z stay within a
//! strip.

use std::ops::Range;

use fearless_simd::Simd;

use super::loose::Loose;
use super::transform::{Purpose, RegionTransform};
use crate::lattice::Layout;
use crate::matching::windows::{RunningSums, Source, Weighted, Window};
use crate::parallel::Split;
use crate::simd::lanes::{Block, Lanes};

/// Minimum number of blocks in a strip. The data of all passes for three strips of this size fit in the L2
/// cache.
const STRIP: usize = 64;

/// Largest number of blocks of a plane that is not divided into strips.
const SMALL_PLANE: usize = 256;

/// The division of the planes of a layout into strips.
#[derive(Clone, Debug)]
pub(super) struct Strips {
    /// First block of each strip, then the number of blocks.
    starts: Vec<usize>,
    /// First strip of each plane, then the number of strips.
    planes: Vec<usize>,
    /// Numbers of blocks of the largest plane and of the largest strip.
    pub(super) largest: [usize; 2],
}

impl Strips {
    /// Divides the planes into strips for regions of half-width `half_width`. The last strip of a plane may have fewer
    /// lines than the others.
    pub(super) fn new(layout: &Layout, half_width: usize) -> Self {
        let min_lines = half_width.div_ceil(2);
        let (mut starts, mut planes) = (vec![0], vec![0]);
        for plane in 0..layout.planes() {
            let blocks = layout.blocks_of(plane..plane + 1);
            if blocks.len() > SMALL_PLANE {
                let (mut start, mut count) = (blocks.start, 0);
                for line in layout.lines(plane) {
                    count += 1;
                    if count >= min_lines && line.end - start >= STRIP && line.end < blocks.end {
                        starts.push(line.end);
                        (start, count) = (line.end, 0);
                    }
                }
            }
            starts.push(blocks.end);
            planes.push(starts.len() - 1);
        }
        let plane = planes.windows(2).map(|ends: &[usize]| starts[ends[1]] - starts[ends[0]]).max();
        let strip = starts.windows(2).map(|ends: &[usize]| ends[1] - ends[0]).max();
        let largest = [plane, strip].map(Option::unwrap_or_default);
        Self { starts, planes, largest }
    }

    /// Returns the first block of each strip of a plane, then the end of the plane.
    fn of_plane(&self, plane: usize) -> &[usize] {
        &self.starts[self.planes[plane]..=self.planes[plane + 1]]
    }

    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(self.starts.as_slice()) + size_of_val(self.planes.as_slice())
    }
}

/// The numbers of blocks that determine the sizes of the buffers of a cascade.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sizes {
    /// Number of all blocks.
    pub(super) blocks: usize,
    /// Number of blocks of the largest plane.
    pub(super) plane: usize,
    /// Number of blocks of the largest strip.
    pub(super) strip: usize,
    /// Whether there are running sums along x, y and z.
    pub(super) has_running: [bool; 3],
    /// Number of loose cells.
    pub(super) loose: usize,
}

impl Sizes {
    /// Returns sizes that are sufficient for both cascades.
    pub(super) fn max(self, other: Self) -> Self {
        Self {
            blocks: self.blocks.max(other.blocks),
            plane: self.plane.max(other.plane),
            strip: self.strip.max(other.strip),
            has_running: [0, 1, 2].map(|axis| self.has_running[axis] || other.has_running[axis]),
            loose: self.loose.max(other.loose),
        }
    }
}

/// Scratch memory of one thread: the outputs of the passes and the running sums.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    /// Output of the x pass for the blocks of a plane.
    after_x: Lanes<6>,
    /// Output of the y pass for the blocks of a strip.
    after_y: Lanes<9>,
    /// Output of the z pass for the blocks of a strip, which the transform replaces by its own output.
    after_z: Lanes<12>,
    /// Output of the adjoint z pass for the blocks of a plane.
    adjoint_z: Lanes<9>,
    /// Running sums of the x, y and z passes.
    running: (RunningSums<6>, RunningSums<9>, RunningSums<12>),
    /// Running sums of the adjoint z and y passes.
    running_adjoint: (RunningSums<12>, RunningSums<9>),
    /// Running sums of the adjoint x pass.
    pub(super) running_adjoint_x: RunningSums<6>,
}

impl Scratch {
    /// Allocates missing memory.
    pub(super) fn grow(&mut self, Sizes { plane, strip, has_running, .. }: Sizes) {
        let Self { after_x, after_y, after_z, adjoint_z, running, running_adjoint, running_adjoint_x } = self;
        after_x.grow(plane);
        after_y.grow(strip);
        after_z.grow(strip);
        adjoint_z.grow(plane);
        let [has_x, has_y, has_z] = has_running;
        if has_x {
            running.0.grow(plane, 2);
            running_adjoint_x.grow(plane, 2);
        }
        if has_y {
            running.1.grow(plane, 1);
            running_adjoint.1.grow(plane, 1);
        }
        if has_z {
            running.2.grow(strip, 1);
            running_adjoint.0.grow(strip, 1);
        }
    }

    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        let (x, y, z) = &self.running;
        let (adjoint_z, adjoint_y) = &self.running_adjoint;
        let outputs =
            self.after_x.bytes() + self.after_y.bytes() + self.after_z.bytes() + self.adjoint_z.bytes();
        let forward = x.bytes() + y.bytes() + z.bytes();
        outputs + forward + adjoint_z.bytes() + adjoint_y.bytes() + self.running_adjoint_x.bytes()
    }

    /// Prepares for the plane whose first block is `first`.
    fn begin_plane(&mut self, first: usize) {
        self.running.0.begin_plane(first);
        self.running.1.begin_plane(first);
        self.running_adjoint.1.begin_plane(first);
    }
}

/// The windows of the passes along x, y and z.
pub(super) type Windows<'a> = (Window<'a, 0>, Window<'a, 1>, Window<'a, 2>);

/// All passes from the x pass to the adjoint y pass.
pub(super) struct PlanePasses<'a, T> {
    pub(super) layout: &'a Layout,
    pub(super) strips: &'a Strips,
    pub(super) windows: Windows<'a>,
    /// Input of the x pass.
    pub(super) field: Weighted<'a>,
    pub(super) transform: &'a T,
    /// `None` if there are no loose cells.
    pub(super) loose: Option<Loose<'a>>,
    pub(super) purpose: Purpose,
}

impl<T> PlanePasses<'_, T> {
    /// Runs the passes over `planes`. `memory` has one entry for each block of these planes. `out` receives
    /// the output of the adjoint y pass for these blocks; it is empty for [`Purpose::Regions`].
    #[inline(always)]
    pub(super) fn run<S: Simd, M: Split>(
        &self,
        simd: S,
        planes: Range<usize>,
        scratch: &mut Scratch,
        mut memory: M,
        out: &mut [Block<6>],
    ) where
        T: RegionTransform<M>,
    {
        let (x, y, z) = self.windows;
        let first = self.layout.blocks_of(planes.clone()).start;
        for plane in planes {
            let strips = self.strips.of_plane(plane);
            let base = strips[0];
            scratch.begin_plane(base);
            // The lag of a pass behind the x pass, in strips, increases by 1 with each pass that crosses the lines.
            for front in 0..strips.len() + 1 {
                let Scratch { after_x, after_y, after_z, adjoint_z, running, running_adjoint, .. } =
                    &mut *scratch;
                let ((running_x, running_y, running_z), (running_adjoint_z, running_adjoint_y)) =
                    (running, running_adjoint);
                let strip = |lag: usize| {
                    let index = front.checked_sub(lag)?;
                    Some(*strips.get(index)?..*strips.get(index + 1)?)
                };
                if let Some(blocks) = strip(0) {
                    x.forward(simd, blocks.clone(), self.field, running_x, output(after_x, blocks, base));
                }
                if let Some(blocks) = strip(1) {
                    let start = blocks.start;
                    let out = output(after_y, blocks.clone(), start);
                    y.forward(simd, blocks.clone(), source(after_x, base), running_y, out);
                    let sums = output(after_z, blocks.clone(), start);
                    running_z.begin_plane(start);
                    z.forward(simd, blocks.clone(), source(after_y, start), running_z, sums);
                    if let Some(loose) = &self.loose {
                        loose.gather(self.field, start, sums);
                    }
                    self.transform.apply(simd, start, sums, memory.take_front(blocks.len()));
                    if let Some(loose) = &self.loose {
                        loose.take(start, sums);
                    }
                    if self.purpose == Purpose::Vertices {
                        let out = output(adjoint_z, blocks.clone(), base);
                        running_adjoint_z.begin_plane(start);
                        z.adjoint(simd, blocks, source(after_z, start), running_adjoint_z, out);
                    }
                }
                if let Some(blocks) = strip(2)
                    && self.purpose == Purpose::Vertices
                {
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
