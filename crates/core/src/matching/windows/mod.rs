//! Sums values over windows of linked vertices along one axis (Rivers & James 2007, section 4, in separable
//! form).
//!
//! A window has a center vertex. It contains the vertices that are connected to the center by up to
//! `half_width` links along the axis, in both directions. So a window ends at a missing link. Let f be the
//! value of a vertex in the window, and i the signed number of links from the center to this vertex. A pass
//! computes, for the window of each vertex, the plain sum W(f) = Σ f and the offset-weighted sum
//! W'(f) = Σ i f.
//!
//! Values are stored in blocks of eight vertices, one vertex in each lane. The axis of a pass is either
//! *along the lanes*, if the eight vertices of a block are consecutive on this axis, or *across the lanes*,
//! if the next vertex on this axis is in the same lane of another block.
//!
//! | file | contents |
//! |---|---|
//! | `terms` | the sums that forward and adjoint passes compute, and how a vertex is added to them |
//! | `direct` | sums vertex by vertex: narrow windows, and windows of thin shapes across the lanes |
//! | `running` | running sums: wide windows across the lanes |
//! | `wide` | differences of prefix sums: wide windows along the lanes |

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

/// Largest half-width of a narrow window across the lanes.
const NARROW_ACROSS: usize = 2;

/// Largest half-width of a narrow window along the lanes.
const NARROW_ALONG: usize = 5;

/// The windows of a pass along one axis.
#[derive(Clone, Copy)]
pub(super) struct Window<'a> {
    /// Links between vertices along the axis.
    pub(super) axis: &'a AxisLinks,
    /// Largest number of links from the center of a window, in each direction.
    pub(super) half_width: usize,
    /// For each block, the bit mask of the lanes with a vertex.
    pub(super) occupied: &'a [u8],
    /// For each block, the vertices that enter and leave its running sums. `None` if there are no running
    /// sums.
    pub(super) slides: Option<&'a [Slide]>,
}

/// Buffers for the sums of wide windows, which have `N` numbers for each vertex. Empty for direct sums.
#[derive(Clone, Debug, Default)]
pub(super) struct RunningSums<const N: usize> {
    history: Option<History<N>>,
    block_sums: Option<BlockSums>,
}

impl<const N: usize> RunningSums<N> {
    /// Allocates the buffers for planes of up to `blocks` blocks. `across_planes` is whether the pass is
    /// along x, so that the previous vertex is in another plane.
    pub(super) fn new(window: &Window, blocks: usize, across_planes: bool) -> Self {
        let is_across_lanes = window.axis.across.is_some();
        let is_running = window.slides.is_some();
        let is_wide = !is_across_lanes && window.half_width > NARROW_ALONG;
        Self {
            history: is_running.then(|| History::new(blocks, if across_planes { 2 } else { 1 })),
            block_sums: is_wide.then(|| BlockSums::new(blocks)),
        }
    }

    /// Prepares for the plane whose first block is `first`.
    pub(super) fn begin_plane(&mut self, first: usize) {
        if let Some(history) = &mut self.history {
            history.begin_plane(first);
        }
    }

    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        self.history.as_ref().map_or(0, History::bytes) + self.block_sums.as_ref().map_or(0, BlockSums::bytes)
    }
}

/// The input of a pass: `N` components for each vertex of consecutive blocks.
#[derive(Clone, Copy)]
pub(super) struct Source<'a, const N: usize> {
    /// Index of the first block of `blocks` in the layout.
    pub(super) first: usize,
    pub(super) blocks: &'a [Block<N>],
}

impl<const N: usize> Source<'_, N> {
    /// Returns component `c` of the eight vertices of a block.
    #[inline(always)]
    fn row<S: Simd>(self, simd: S, block: usize, c: usize) -> f32x8<S> {
        f32x8::load_array_ref(simd, &self.blocks[block - self.first][c])
    }
}

/// The input of the first pass: f = (m/n) p, where p is a vector of the vertex, m is the mass of the vertex,
/// and n is the number of regions that contain the vertex.
#[derive(Clone, Copy)]
pub(crate) struct Weighted<'a> {
    /// m and 1/n of each vertex.
    pub(crate) weights: &'a [Block<2>],
    /// p of each vertex, such as its position or its velocity.
    pub(crate) vectors: &'a [Block<3>],
}

impl Weighted<'_> {
    /// Returns component `c` of f of the eight vertices of a block.
    #[inline(always)]
    fn row<S: Simd>(self, simd: S, block: usize, c: usize) -> f32x8<S> {
        let [mass, inverse_count] = load(simd, &self.weights[block]);
        f32x8::load_array_ref(simd, &self.vectors[block][c]) * (mass * inverse_count)
    }
}

impl Window<'_> {
    /// Runs the first pass of the cascade: computes W and W' of the weighted field. The input has three
    /// components per vertex, the output six.
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

    /// Runs a forward pass: computes W of all `IN` components of the input, and W' of the first three. The
    /// output has `OUT = IN + 3` components.
    #[inline(always)]
    pub(super) fn forward<S: Simd, const IN: usize, const OUT: usize>(
        self,
        simd: S,
        blocks: Range<usize>,
        source: Source<IN>,
        running: &mut RunningSums<OUT>,
        out: &mut [Block<OUT>],
    ) {
        simd.vectorize(
            #[inline(always)]
            || {
                self.sum_windows::<S, Forward<S, IN>, Forward<S, IN>, OUT, OUT>(
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

    /// Runs an adjoint pass: computes W of the first `OUT` of the `IN = OUT + 3` components of the input, and
    /// subtracts W' of the last three from W of the first three. The output has `OUT` components.
    #[inline(always)]
    pub(super) fn adjoint<S: Simd, const IN: usize, const OUT: usize>(
        self,
        simd: S,
        blocks: Range<usize>,
        source: Source<IN>,
        running: &mut RunningSums<IN>,
        out: &mut [Block<OUT>],
    ) {
        simd.vectorize(
            #[inline(always)]
            || {
                self.sum_windows::<S, Adjoint<S, IN, OUT>, RunningAdjoint<S, IN, OUT>, IN, OUT>(
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

    /// Computes the sums of a pass for the windows around the vertices of `blocks`. `row(block, c)` is
    /// component `c` of the input for the eight vertices of a block.
    ///
    /// `Sums` are the sums that the pass writes, `OUT` numbers for each vertex. `Continued` are the running
    /// sums, which need `STORED` numbers for each vertex to continue at the next vertex.
    #[inline(always)]
    fn sum_windows<S, Sums, Continued, const STORED: usize, const OUT: usize>(
        self,
        simd: S,
        blocks: Range<usize>,
        row: impl Fn(usize, usize) -> f32x8<S>,
        running: &mut RunningSums<STORED>,
        out: &mut [Block<OUT>],
    ) where
        S: Simd,
        Sums: Windows<S>,
        Continued: Running<S> + Into<Sums>,
    {
        let Self { axis: AxisLinks { links, across }, half_width, occupied, slides } = self;
        match (across, &mut running.history, slides, &mut running.block_sums) {
            (Some(neighbors), Some(history), Some(slides), _) => {
                for (block, out) in blocks.zip(out) {
                    let slide = (half_width, slides[block]);
                    let sums: Continued =
                        running::across(simd, links, neighbors, slide, block, &row, history);
                    sums.into().store(out);
                }
            }
            (Some(neighbors), ..) => {
                for (block, out) in blocks.zip(out) {
                    direct::across::<S, Sums>(simd, links, neighbors, half_width, block, &row).store(out);
                }
            }
            (None, _, _, Some(block_sums)) => {
                let first = blocks.start;
                let wide = WideWindows { links, occupied, half_width, blocks };
                Sums::wide(
                    simd,
                    block_sums,
                    wide,
                    &row,
                    #[inline(always)]
                    |block, lanes, sums| {
                        let lower_lanes = (1_u8 << lanes.trailing_zeros()) - 1;
                        let is_first_run = occupied[block] & lower_lanes == 0;
                        store_lanes(simd, lanes, is_first_run, sums, &mut out[block - first]);
                    },
                );
            }
            (None, ..) => {
                for (block, out) in blocks.zip(out) {
                    direct::along::<S, Sums>(simd, links, half_width, block, &row).store(out);
                }
            }
        }
    }
}

/// Writes the sums of one run of linked vertices in a block: the lanes of the bit mask `lanes`.
///
/// The runs of a block are written one after the other. If `is_first_run`, no run of this block has been
/// written before, and all other lanes become zero. Otherwise all other lanes keep their values.
#[inline(always)]
fn store_lanes<S: Simd, Sums: Windows<S>, const OUT: usize>(
    simd: S,
    lanes: u8,
    is_first_run: bool,
    sums: Sums,
    out: &mut Block<OUT>,
) {
    if lanes == 0xff {
        return sums.store(out);
    }
    let mask = mask32x8::from_bitmask(simd, u64::from(lanes));
    let mut rows = [Row::ZERO; OUT];
    sums.store(&mut rows);
    for (row, out) in rows.iter().zip(out) {
        let old = if is_first_run { Row::ZERO } else { *out };
        let (new, old) = (f32x8::load_array_ref(simd, row), f32x8::load_array_ref(simd, &old));
        mask.select(new, old).store_array(out);
    }
}
