//! Sums over the windows of one axis, broken at missing links (Rivers & James 2007, section 4, made separable).
//!
//! The window of a vertex along an axis: the vertices reached from it by up to `half_width` links either way. For
//! values `f` and the signed number of links `i` from the center, a pass needs the plain sums W(f) = Σ f and the
//! offset-weighted sums W'(f) = Σ i f.

mod direct;
mod running;
mod terms;
mod wide;

pub(super) use running::{Slide, slides};

use std::ops::Range;

use fearless_simd::{Select, Simd, SimdBase, SimdMask, f32x8, mask32x8};

use crate::lattice::AxisLinks;
use crate::simd::lanes::{Block, Row, load};
use running::Trail;
use terms::{Adjoint, Forward, Running, RunningAdjoint, Windows};
use wide::{BlockSums, WideWindows};

/// The widest windows that are summed vertex by vertex, across the lanes and along them.
const NARROW_ACROSS: usize = 2;
const NARROW_ALONG: usize = 5;

/// A pass along one axis.
#[derive(Clone, Copy)]
pub(super) struct Window<'a> {
    pub(super) axis: &'a AxisLinks,
    pub(super) half_width: usize,
    /// The lanes of each block that hold a vertex, as bits.
    pub(super) occupied: &'a [u8],
    /// Of running sums.
    pub(super) slides: Option<&'a [Slide]>,
}

/// What wide windows carry from vertex to vertex, `N` numbers by block; nothing where windows are narrow.
#[derive(Clone, Debug, Default)]
pub(super) struct RunningSums<const N: usize> {
    trail: Option<Trail<N>>,
    within: Option<BlockSums>,
}

impl<const N: usize> RunningSums<N> {
    /// For a pass over planes of up to `blocks` blocks. A pass along the outer axis goes from plane to plane.
    pub(super) fn new(window: &Window, blocks: usize, outer: bool) -> Self {
        let across = window.axis.across.is_some();
        let runs = window.slides.is_some();
        let is_wide = !across && window.half_width > NARROW_ALONG;
        Self {
            trail: runs.then(|| Trail::new(blocks, if outer { 2 } else { 1 })),
            within: is_wide.then(|| BlockSums::new(blocks)),
        }
    }

    /// Goes on to the plane with the first block `first`.
    pub(super) fn enter(&mut self, first: usize) {
        if let Some(trail) = &mut self.trail {
            trail.enter(first);
        }
    }

    /// Memory that it takes.
    pub(super) fn bytes(&self) -> usize {
        self.trail.as_ref().map_or(0, Trail::bytes) + self.within.as_ref().map_or(0, BlockSums::bytes)
    }
}

/// The numbers of blocks from `first` on.
#[derive(Clone, Copy)]
pub(super) struct Source<'a, const N: usize> {
    pub(super) first: usize,
    pub(super) blocks: &'a [Block<N>],
}

impl<const N: usize> Source<'_, N> {
    #[inline(always)]
    fn row<S: Simd>(self, simd: S, block: usize, c: usize) -> f32x8<S> {
        f32x8::load_array_ref(simd, &self.blocks[block - self.first][c])
    }
}

/// A vector of each vertex times its weight m/n: f = (m/n) p.
#[derive(Clone, Copy)]
pub(crate) struct Weighted<'a> {
    /// m and 1/n.
    pub(crate) weights: &'a [Block<2>],
    pub(crate) vectors: &'a [Block<3>],
}

impl Weighted<'_> {
    #[inline(always)]
    fn row<S: Simd>(self, simd: S, block: usize, c: usize) -> f32x8<S> {
        let [mass, share] = load(simd, &self.weights[block]);
        f32x8::load_array_ref(simd, &self.vectors[block][c]) * (mass * share)
    }
}

impl Window<'_> {
    /// The first pass of the cascade, 3 → 6.
    #[inline(always)]
    pub(super) fn weighted<S: Simd>(
        self,
        simd: S,
        blocks: Range<usize>,
        field: Weighted,
        running: &mut RunningSums<6>,
        out: &mut [Block<6>],
    ) {
        simd.vectorize(
            #[inline(always)]
            || {
                self.each::<S, Forward<S, 3>, Forward<S, 3>, 6, 6>(
                    simd,
                    blocks,
                    #[inline(always)]
                    |block, c| field.row(simd, block, c),
                    running,
                    out,
                );
            },
        );
    }

    /// A forward pass: W of all `N` components, and W' of the first three; `M = N + 3`.
    #[inline(always)]
    pub(super) fn forward<S: Simd, const N: usize, const M: usize>(
        self,
        simd: S,
        blocks: Range<usize>,
        source: Source<N>,
        running: &mut RunningSums<M>,
        out: &mut [Block<M>],
    ) {
        simd.vectorize(
            #[inline(always)]
            || {
                self.each::<S, Forward<S, N>, Forward<S, N>, M, M>(
                    simd,
                    blocks,
                    #[inline(always)]
                    |block, c| source.row(simd, block, c),
                    running,
                    out,
                );
            },
        );
    }

    /// An adjoint pass: W of the first `M` of `N = M + 3` components, less W' of the last three
    /// in the first three.
    #[inline(always)]
    pub(super) fn adjoint<S: Simd, const N: usize, const M: usize>(
        self,
        simd: S,
        blocks: Range<usize>,
        source: Source<N>,
        running: &mut RunningSums<N>,
        out: &mut [Block<M>],
    ) {
        simd.vectorize(
            #[inline(always)]
            || {
                self.each::<S, Adjoint<S, N, M>, RunningAdjoint<S, N, M>, N, M>(
                    simd,
                    blocks,
                    #[inline(always)]
                    |block, c| source.row(simd, block, c),
                    running,
                    out,
                );
            },
        );
    }

    /// The windows around the vertices of some blocks; `row(block, c)` is component c of what is summed. `T` is what
    /// is wanted, `C` what is carried on for it.
    #[inline(always)]
    fn each<S: Simd, T: Windows<S>, C: Running<S> + Into<T>, const N: usize, const M: usize>(
        self,
        simd: S,
        blocks: Range<usize>,
        row: impl Fn(usize, usize) -> f32x8<S>,
        running: &mut RunningSums<N>,
        out: &mut [Block<M>],
    ) {
        let Self { axis: AxisLinks { links, across }, half_width, occupied, slides } = self;
        match (across, &mut running.trail, slides, &mut running.within) {
            (Some(neighbours), Some(trail), Some(slides), _) => {
                for (block, out) in blocks.zip(out) {
                    let slide = (half_width, slides[block]);
                    let sums: C = running::across(simd, links, neighbours, slide, block, &row, trail);
                    sums.into().store(out);
                }
            }
            (Some(neighbours), ..) => {
                for (block, out) in blocks.zip(out) {
                    direct::across::<S, T>(simd, links, neighbours, half_width, block, &row).store(out);
                }
            }
            (None, _, _, Some(within)) => {
                let first = blocks.start;
                let wide = WideWindows { links, occupied, half_width, blocks };
                T::wide(
                    simd,
                    within,
                    wide,
                    &row,
                    #[inline(always)]
                    |block, lanes, sums| {
                        let before = (1_u8 << lanes.trailing_zeros()) - 1;
                        let are_first = occupied[block] & before == 0;
                        put(simd, lanes, are_first, sums, &mut out[block - first]);
                    },
                );
            }
            (None, ..) => {
                for (block, out) in blocks.zip(out) {
                    direct::along::<S, T>(simd, links, half_width, block, &row).store(out);
                }
            }
        }
    }
}

/// Writes the windows of some lanes of a block. The others keep what they have, or if these are the first that are
/// written hold nothing.
#[inline(always)]
fn put<S: Simd, T: Windows<S>, const M: usize>(
    simd: S,
    lanes: u8,
    are_first: bool,
    sums: T,
    out: &mut Block<M>,
) {
    if lanes == 0xff {
        return sums.store(out);
    }
    let mask = mask32x8::from_bitmask(simd, u64::from(lanes));
    let mut rows = [Row::ZERO; M];
    sums.store(&mut rows);
    for (row, out) in rows.iter().zip(out) {
        let old = if are_first { Row::ZERO } else { *out };
        let (new, old) = (f32x8::load_array_ref(simd, row), f32x8::load_array_ref(simd, &old));
        mask.select(new, old).store_array(out);
    }
}
