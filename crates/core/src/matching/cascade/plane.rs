//! The passes of the cascade that stay within a plane, in scratch that stays in the cache.
//!
//! A pass across the lines of a plane needs the lines before and after of the pass before it. So a plane is cut into
//! strips of lines, at least as many as a window reaches, and the passes follow one another like a wave: each works
//! on a strip when the one before it is done with the next strip.

use std::ops::Range;

use fearless_simd::Simd;

use super::{Purpose, RegionTransform};
use crate::lattice::Layout;
use crate::matching::windows::{RunningSums, Source, Weighted, Window};
use crate::simd::lanes::{Block, Lanes};

/// Blocks in a strip, where the windows do not ask for more: what all passes hold of three fits a second-level cache.
const STRIP: usize = 64;

/// A plane with at most this number of blocks is one strip.
const SMALL_PLANE: usize = 256;

/// What the passes hold of one plane, by block.
#[derive(Clone, Debug)]
pub(super) struct Scratch {
    after_x: Lanes<6>,
    after_y: Lanes<9>,
    /// Transformed as soon as it is there.
    after_z: Lanes<12>,
    adjoint_z: Lanes<9>,
    /// Of the passes x, y, z, and of the adjoint ones.
    running: (RunningSums<6>, RunningSums<9>, RunningSums<12>),
    running_adjoint: (RunningSums<12>, RunningSums<9>),
    /// Of the adjoint x pass.
    pub(super) running_adjoint_x: RunningSums<6>,
    /// The first block of each strip, and the end.
    strips: Vec<usize>,
}

impl Scratch {
    /// For the passes x, y, z over planes of up to `blocks` blocks.
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

    /// Memory that it takes.
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

    /// Goes on to the plane with the first block `first`.
    fn enter(&mut self, first: usize) {
        self.running.0.enter(first);
        self.running.1.enter(first);
        self.running.2.enter(first);
        self.running_adjoint.0.enter(first);
        self.running_adjoint.1.enter(first);
    }

    /// Cuts a plane into strips of at least `lines` lines; the last may have fewer.
    fn cut(&mut self, layout: &Layout, plane: usize, lines: usize) {
        let blocks = layout.blocks_of(plane..plane + 1);
        self.strips.clear();
        self.strips.push(blocks.start);
        if blocks.len() > SMALL_PLANE {
            let (mut from, mut held) = (blocks.start, 0);
            for line in layout.lines(plane) {
                held += 1;
                if held >= lines && line.end - from >= STRIP {
                    self.strips.push(line.end);
                    (from, held) = (line.end, 0);
                }
            }
        }
        if self.strips.last() != Some(&blocks.end) {
            self.strips.push(blocks.end);
        }
    }
}

/// All passes but the last: from a field to the adjoint y pass.
pub(super) struct PlanePasses<'a, T> {
    pub(super) layout: &'a Layout,
    /// x, y, z.
    pub(super) windows: [Window<'a>; 3],
    pub(super) field: Weighted<'a>,
    pub(super) transform: &'a T,
    pub(super) purpose: Purpose,
}

impl<T: RegionTransform> PlanePasses<'_, T> {
    /// All passes over some planes. `memory` and `out` are by block from the first of these planes on.
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
        // How many strips each pass is behind the first: one more with each pass across lines.
        let [behind_y, behind_z, behind_adjoint_z, behind_adjoint_y] =
            if self.layout.lane_axis() == 1 { [0, 1, 2, 2] } else { [1, 1, 1, 2] };
        for plane in planes {
            scratch.cut(self.layout, plane, x.half_width);
            let base = scratch.strips[0];
            scratch.enter(base);
            for wave in 0..scratch.strips.len() + 1 {
                let Scratch {
                    after_x, after_y, after_z, adjoint_z, running, running_adjoint, strips, ..
                } = &mut *scratch;
                let ((carry_x, carry_y, carry_z), (carry_adjoint_z, carry_adjoint_y)) =
                    (running, running_adjoint);
                let strip = |behind: usize| {
                    let at = wave.checked_sub(behind)?;
                    Some(*strips.get(at)?..*strips.get(at + 1)?)
                };
                if let Some(blocks) = strip(0) {
                    x.weighted(simd, blocks.clone(), self.field, carry_x, part(after_x, blocks, base));
                }
                if let Some(blocks) = strip(behind_y) {
                    let out = part(after_y, blocks.clone(), base);
                    y.forward(simd, blocks, all(after_x, base), carry_y, out);
                }
                if let Some(blocks) = strip(behind_z) {
                    let memory = &mut memory[blocks.start - first..blocks.end - first];
                    let sums = part(after_z, blocks.clone(), base);
                    z.forward(simd, blocks.clone(), all(after_y, base), carry_z, sums);
                    self.transform.apply(simd, blocks.start, sums, memory);
                }
                if self.purpose == Purpose::Transform {
                    continue;
                }
                if let Some(blocks) = strip(behind_adjoint_z) {
                    let out = part(adjoint_z, blocks.clone(), base);
                    z.adjoint(simd, blocks, all(after_z, base), carry_adjoint_z, out);
                }
                if let Some(blocks) = strip(behind_adjoint_y) {
                    let out = &mut out[blocks.start - first..blocks.end - first];
                    y.adjoint(simd, blocks, all(adjoint_z, base), carry_adjoint_y, out);
                }
            }
        }
    }
}

/// What a pass reads, of which `base` is the first block.
fn all<const N: usize>(lanes: &Lanes<N>, base: usize) -> Source<'_, N> {
    Source { first: base, blocks: lanes.blocks() }
}

/// What a pass writes.
fn part<const N: usize>(lanes: &mut Lanes<N>, blocks: Range<usize>, base: usize) -> &mut [Block<N>] {
    &mut lanes.blocks_mut()[blocks.start - base..blocks.end - base]
}
