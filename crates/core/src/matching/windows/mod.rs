//! Sums values over windows of linked vertices along one axis (Rivers & James 2007, section 4, in separable
//! form).
//!
//! A window has a center vertex. It contains the vertices that are connected to the center by up to
//! `half_width` links along the axis, in both directions. So a window ends at a missing link. Let f be the
//! value of a vertex in the window, and i the signed number of links from the center to this vertex. A pass
//! computes, for the window of each vertex, the plain sum W(f) = Σ f and the offset-weighted sum
//! W'(f) = Σ i f.
//!
//! The windows of a cell have two vertices, at i = -1/2 and i = 1/2 from their center: see [`cascade`](super::cascade).
//!
//! Values are stored in blocks of 2 × 2 × 2 vertices, one vertex in each lane. So the vertices at an even offset from
//! those of a block are another block, and the vertices at an odd offset are the upper half of a block and the lower
//! half of the next one.
//!
//! | file | contents |
//! |---|---|
//! | `terms` | the sums that forward and adjoint passes compute, and how a vertex is added to them |
//! | `narrow` | sums of narrow windows, vertex by vertex |
//! | `running` | running sums: wide windows |
//! | `direct` | sums of wide windows, vertex by vertex: in thin shapes, and where running sums restart |

mod direct;
mod narrow;
mod running;
mod terms;

pub(super) use running::RunningSums;

use std::ops::Range;

use fearless_simd::{Simd, SimdBase, f32x8};

use super::half_width::HalfWidth;
use crate::lattice::{AxisLinks, Layout};
use crate::simd::lanes::{Block, load};
use narrow::{NARROW, NarrowWindows};
use running::Slide;
use terms::{Adjoint, Forward, PairTerms, Running, RunningAdjoint};

/// How the windows along an axis are summed.
#[derive(Clone, Debug)]
pub(super) enum Method {
    /// Windows of the two vertices of a cell.
    Pairs(Vec<NarrowWindows>),
    /// Narrow windows, vertex by vertex.
    Narrow(Vec<NarrowWindows>),
    /// Wide windows, by running sums: for each block, the vertices that enter and leave them.
    Running(Vec<Slide>),
    /// Wide windows of thin shapes, vertex by vertex.
    Direct,
}

impl Method {
    /// Chooses the method for the windows of half-width `half_width` along an axis. `restart` as in
    /// [`running::slides`].
    pub(super) fn new(
        layout: &Layout,
        axis: usize,
        half_width: HalfWidth,
        restart: impl Fn(usize, usize) -> bool,
    ) -> Self {
        let links = layout.axis(axis);
        if half_width.is_cell() {
            return Self::Pairs(narrow::windows(axis, links, 1));
        }
        let half_width = half_width.links();
        if half_width <= NARROW {
            return Self::Narrow(narrow::windows(axis, links, half_width));
        }
        running::slides((axis, links), half_width, layout.occupied(), restart)
            .map_or(Self::Direct, Self::Running)
    }

    /// Returns whether the sums are running sums.
    pub(super) fn is_running(&self) -> bool {
        matches!(self, Self::Running(_))
    }

    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        match self {
            Self::Pairs(windows) | Self::Narrow(windows) => size_of_val(windows.as_slice()),
            Self::Running(slides) => size_of_val(slides.as_slice()),
            Self::Direct => 0,
        }
    }
}

/// The windows of a pass along one axis.
#[derive(Clone, Copy)]
pub(super) struct Window<'a, const AXIS: usize> {
    /// Links between vertices along the axis.
    pub(super) axis: &'a AxisLinks,
    /// Largest number of links from the place of a window to its vertices.
    pub(super) half_width: usize,
    pub(super) method: &'a Method,
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
    /// m and 1/n of each vertex; `None` in cells, where f = p.
    pub(crate) weights: Option<&'a [Block<2>]>,
    /// p of each vertex, such as its position or its velocity.
    pub(crate) vectors: &'a [Block<3>],
}

impl Weighted<'_> {
    /// Returns component `c` of f of the eight vertices of a block.
    #[inline(always)]
    fn row<S: Simd>(self, simd: S, block: usize, c: usize) -> f32x8<S> {
        let vector = f32x8::load_array_ref(simd, &self.vectors[block][c]);
        match self.weights {
            Some(weights) => {
                let [mass, inverse_count] = load(simd, &weights[block]);
                vector * (mass * inverse_count)
            }
            None => vector,
        }
    }
}

impl<const AXIS: usize> Window<'_, AXIS> {
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
        Sums: PairTerms<S>,
        Continued: Running<S> + Into<Sums>,
    {
        let Self { axis, half_width, method } = self;
        match method {
            Method::Pairs(windows) => {
                for (block, out) in blocks.zip(out) {
                    narrow::pair_sums::<S, Sums, AXIS>(simd, windows, block, &row).store(out);
                }
            }
            Method::Narrow(windows) => {
                for (block, out) in blocks.zip(out) {
                    narrow::sums::<S, Sums, AXIS>(simd, windows, half_width, block, &row).store(out);
                }
            }
            Method::Running(slides) => {
                for (block, out) in blocks.zip(out) {
                    let slide = (half_width, slides[block]);
                    let sums =
                        running::sums::<S, Continued, AXIS, STORED>(simd, axis, slide, block, &row, running);
                    sums.into().store(out);
                }
            }
            Method::Direct => {
                for (block, out) in blocks.zip(out) {
                    direct::sums::<S, Sums, AXIS>(simd, axis, half_width, block, &row).store(out);
                }
            }
        }
    }
}
