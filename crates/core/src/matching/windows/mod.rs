//! Window sums along one axis, which end at missing links (Rivers & James 2007, section 4, in separable
//! form).
//!
//! The window of a vertex along an axis contains the vertices that are connected to it by up to `half_width`
//! links in either direction. For values f and the signed number of links i from the center, a pass computes
//! the plain sums W(f) = Σ f and the offset-weighted sums W'(f) = Σ i f.
//!
//! | file | contents |
//! |---|---|
//! | `terms` | the sums of forward and adjoint passes, and how a vertex is added |
//! | `direct` | narrow windows, summed vertex by vertex |
//! | `running` | wide windows across the lanes, as running sums |
//! | `wide` | wide windows along the lanes, from prefix sums |

mod direct;
mod running;
mod terms;
mod wide;

pub(super) use running::{Slide, slides};

use std::ops::Range;

use fearless_simd::{Select, Simd, SimdBase, SimdMask, f32x8, mask32x8};

use crate::lattice::AxisLinks;
use crate::simd::lanes::{Block, Row, load};
use running::History;
use terms::{Adjoint, Forward, Running, RunningAdjoint, Windows};
use wide::{BlockSums, WideWindows};

/// Largest half-widths that are summed vertex by vertex, across the lanes and along the lanes.
const NARROW_ACROSS: usize = 2;
const NARROW_ALONG: usize = 5;

/// The windows of a pass along one axis.
#[derive(Clone, Copy)]
pub(super) struct Window<'a> {
    pub(super) axis: &'a AxisLinks,
    pub(super) half_width: usize,
    /// Bit mask of the lanes with a vertex, for each block.
    pub(super) occupied: &'a [u8],
    /// Steps of the running sums, by block; `None` where windows are summed directly.
    pub(super) slides: Option<&'a [Slide]>,
}

/// Buffers for wide windows, `N` numbers by block; empty for narrow windows.
#[derive(Clone, Debug, Default)]
pub(super) struct RunningSums<const N: usize> {
    history: Option<History<N>>,
    block_sums: Option<BlockSums>,
}

impl<const N: usize> RunningSums<N> {
    /// Allocates the buffers for planes of up to `blocks` blocks. `outer` is whether the pass is along x,
    /// from plane to plane.
    pub(super) fn new(window: &Window, blocks: usize, outer: bool) -> Self {
        let across = window.axis.across.is_some();
        let is_running = window.slides.is_some();
        let is_wide = !across && window.half_width > NARROW_ALONG;
        Self {
            history: is_running.then(|| History::new(blocks, if outer { 2 } else { 1 })),
            block_sums: is_wide.then(|| BlockSums::new(blocks)),
        }
    }

    /// Begins the plane whose first block is `first`.
    pub(super) fn begin_plane(&mut self, first: usize) {
        if let Some(history) = &mut self.history {
            history.begin_plane(first);
        }
    }

    /// Memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        self.history.as_ref().map_or(0, History::bytes) + self.block_sums.as_ref().map_or(0, BlockSums::bytes)
    }
}

/// The input of a pass, `N` numbers for each vertex of the blocks from `first` on.
#[derive(Clone, Copy)]
pub(super) struct Source<'a, const N: usize> {
    pub(super) first: usize,
    pub(super) blocks: &'a [Block<N>],
}

impl<const N: usize> Source<'_, N> {
    /// Component `c` of a block.
    #[inline(always)]
    fn row<S: Simd>(self, simd: S, block: usize, c: usize) -> f32x8<S> {
        f32x8::load_array_ref(simd, &self.blocks[block - self.first][c])
    }
}

/// The input of the first pass: a vector p of each vertex times its region weight, f = (m/n) p.
#[derive(Clone, Copy)]
pub(crate) struct Weighted<'a> {
    /// m and 1/n of each vertex.
    pub(crate) weights: &'a [Block<2>],
    pub(crate) vectors: &'a [Block<3>],
}

impl Weighted<'_> {
    /// Component `c` of a block.
    #[inline(always)]
    fn row<S: Simd>(self, simd: S, block: usize, c: usize) -> f32x8<S> {
        let [mass, inverse_count] = load(simd, &self.weights[block]);
        f32x8::load_array_ref(simd, &self.vectors[block][c]) * (mass * inverse_count)
    }
}

impl Window<'_> {
    /// Runs the first pass of the cascade, 3 → 6: W and W' of the weighted field.
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
                self.sum_windows::<S, Forward<S, 3>, Forward<S, 3>, 6, 6>(
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

    /// Runs a forward pass: W of all `N` components, and W' of the first three; `M = N + 3`.
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
                self.sum_windows::<S, Forward<S, N>, Forward<S, N>, M, M>(
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

    /// Runs an adjoint pass: W of the first `M` of `N = M + 3` components; the first three are reduced by W'
    /// of the last three.
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
                self.sum_windows::<S, Adjoint<S, N, M>, RunningAdjoint<S, N, M>, N, M>(
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

    /// Sums the windows around the vertices of some blocks; `row(block, c)` is component `c` of the input.
    /// `T` has the sums of the pass, `C` the sums that a running sum continues from.
    #[inline(always)]
    fn sum_windows<S: Simd, T: Windows<S>, C: Running<S> + Into<T>, const N: usize, const M: usize>(
        self,
        simd: S,
        blocks: Range<usize>,
        row: impl Fn(usize, usize) -> f32x8<S>,
        running: &mut RunningSums<N>,
        out: &mut [Block<M>],
    ) {
        let Self { axis: AxisLinks { links, across }, half_width, occupied, slides } = self;
        match (across, &mut running.history, slides, &mut running.block_sums) {
            (Some(neighbors), Some(history), Some(slides), _) => {
                for (block, out) in blocks.zip(out) {
                    let slide = (half_width, slides[block]);
                    let sums: C = running::across(simd, links, neighbors, slide, block, &row, history);
                    sums.into().store(out);
                }
            }
            (Some(neighbors), ..) => {
                for (block, out) in blocks.zip(out) {
                    direct::across::<S, T>(simd, links, neighbors, half_width, block, &row).store(out);
                }
            }
            (None, _, _, Some(block_sums)) => {
                let first = blocks.start;
                let wide = WideWindows { links, occupied, half_width, blocks };
                T::wide(
                    simd,
                    block_sums,
                    wide,
                    &row,
                    #[inline(always)]
                    |block, lanes, sums| {
                        let lower = (1_u8 << lanes.trailing_zeros()) - 1;
                        let are_first = occupied[block] & lower == 0;
                        store_lanes(simd, lanes, are_first, sums, &mut out[block - first]);
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

/// Writes the sums of some lanes of a block. The other lanes keep their values, or become zero if
/// `are_first`: if these are the first lanes of the block that are written.
#[inline(always)]
fn store_lanes<S: Simd, T: Windows<S>, const M: usize>(
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
