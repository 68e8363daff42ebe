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
//! | `rows` | the input of a pass |
//! | `terms` | the sums that forward and adjoint passes compute, and how a vertex is added to them |
//! | `reach` | the vertices to which links lead from a block |
//! | `narrow` | sums of narrow windows, vertex by vertex |
//! | `running` | running sums: wide windows |
//! | `direct` | sums of wide windows, vertex by vertex: in thin shapes, and where running sums restart |

mod direct;
mod narrow;
mod reach;
mod rows;
mod running;
mod terms;

pub(super) use rows::Source;
pub(crate) use rows::Weighted;
pub(super) use running::RunningSums;

use std::ops::Range;

use fearless_simd::Simd;

use super::half_width::HalfWidth;
use crate::lattice::{AxisLinks, Layout};
use crate::simd::lanes::Block;
use narrow::{NARROW, NarrowWindows};
use rows::{Input, Rows};
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
            return Self::Pairs(narrow::windows(links, 1));
        }
        let half_width = half_width.links();
        if half_width <= NARROW {
            return Self::Narrow(narrow::windows(links, half_width));
        }
        running::slides(links, half_width, layout.occupied(), restart).map_or(Self::Direct, Self::Running)
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

impl<const AXIS: usize> Window<'_, AXIS> {
    /// Runs a forward pass: computes W of all `IN` components of the input, and W' of the first three. The
    /// output has `OUT = IN + 3` components.
    #[inline(always)]
    pub(super) fn forward<S: Simd, const IN: usize, const OUT: usize>(
        self,
        simd: S,
        blocks: Range<usize>,
        rows: impl Rows<IN>,
        running: &mut RunningSums<OUT>,
        out: &mut [Block<OUT>],
    ) {
        simd.vectorize(
            #[inline(always)]
            || {
                self.sum_windows::<S, Forward<S, IN>, Forward<S, IN>, _, IN, _, _>(
                    simd, blocks, rows, running, out,
                )
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
        rows: impl Rows<IN>,
        running: &mut RunningSums<IN>,
        out: &mut [Block<OUT>],
    ) {
        simd.vectorize(
            #[inline(always)]
            || {
                self.sum_windows::<S, Adjoint<S, IN, OUT>, RunningAdjoint<S, IN, OUT>, _, IN, _, _>(
                    simd, blocks, rows, running, out,
                );
            },
        );
    }

    /// Computes the sums of a pass for the windows around the vertices of `blocks`.
    ///
    /// `Sums` are the sums that the pass writes, `OUT` numbers for each vertex. `Continued` are the running
    /// sums, which need `STORED` numbers for each vertex to continue at the next vertex.
    #[inline(always)]
    fn sum_windows<S, Sums, Continued, R, const IN: usize, const STORED: usize, const OUT: usize>(
        self,
        simd: S,
        blocks: Range<usize>,
        rows: R,
        running: &mut RunningSums<STORED>,
        out: &mut [Block<OUT>],
    ) where
        S: Simd,
        Sums: PairTerms<S>,
        Continued: Running<S> + Into<Sums>,
        R: Rows<IN>,
    {
        let Self { axis, half_width, method } = self;
        let input: Input<S, R, AXIS, IN> = Input { simd, rows };
        match method {
            Method::Pairs(windows) => {
                for (block, out) in blocks.zip(out) {
                    narrow::pair_sums::<_, Sums, _, _>(input, windows, block).store(out);
                }
            }
            Method::Narrow(windows) => {
                for (block, out) in blocks.zip(out) {
                    narrow::sums::<_, Sums, _, _>(input, windows, half_width, block).store(out);
                }
            }
            Method::Running(slides) => {
                for (block, out) in blocks.zip(out) {
                    let slide = (half_width, slides[block]);
                    let sums: Continued = running::sums(input, axis, slide, block, running);
                    sums.into().store(out);
                }
            }
            Method::Direct => {
                for (block, out) in blocks.zip(out) {
                    direct::sums::<_, Sums, _, _>(input, axis, half_width, block).store(out);
                }
            }
        }
    }
}
