//! Computes running sums: sums over wide windows across the lanes. A running sum follows from the sum of the
//! previous vertex on the axis, the vertex that enters the window, and the vertex that leaves it.
//!
//! ```text
//! S[i]  = S[i-1]           +           f[i+w] -           f[i-1-w]
//! S'[i] = S'[i-1] - S[i-1] + w         f[i+w] + (w + 1)   f[i-1-w]
//! ```
//!
//! S[i] and S'[i] are the plain and the offset-weighted sum of the window around vertex i of a line of linked
//! vertices, f[i] is the value of vertex i, and w is the half-width. A term is omitted if its vertex is not
//! linked to the window. Running sums restart with a direct sum at missing links, and at a fixed interval to
//! limit the accumulation of rounding errors.

use fearless_simd::{Simd, f32x8};

use super::terms::Running;
use super::{NARROW_ACROSS, direct};
use crate::lattice::{AxisLinks, Neighbors};
use crate::simd::lanes::{Block, Lanes};

/// The vertices that enter and leave the windows when the running sums move from the previous block along an
/// axis to a block. Each of the eight lanes is a separate line of vertices.
#[derive(Clone, Copy, Debug)]
pub(in crate::matching) struct Slide {
    /// Block of the vertices that enter the windows.
    pub(super) entering: u32,
    /// Block of the vertices that leave the windows.
    pub(super) leaving: u32,
    /// Bit mask of the lanes in which a vertex enters.
    pub(super) entering_lanes: u8,
    /// Bit mask of the lanes in which a vertex leaves.
    pub(super) leaving_lanes: u8,
    /// Whether the sums restart with a direct sum at this block.
    pub(super) restarts: bool,
}

/// Computes the [`Slide`] of each block along an axis. Returns `None` if the axis is along the lanes or the
/// windows are narrow. Also returns `None` if the sums would restart at half of the blocks or more, as in
/// thin shapes: direct sums are then faster.
///
/// `occupied` has, for each block, the bit mask of the lanes with a vertex. `restart(block, position)`
/// returns whether the sums must restart at a block even if it is linked to the previous block; `position` is
/// the number of blocks before it on its line.
pub(in crate::matching) fn slides(
    axis: &AxisLinks,
    half_width: usize,
    occupied: &[u8],
    restart: impl Fn(usize, usize) -> bool,
) -> Option<Vec<Slide>> {
    let Neighbors { next, previous } = axis.across.as_ref().filter(|_| half_width > NARROW_ACROSS)?;
    let links = &axis.links;
    let mut positions = vec![0; occupied.len()];
    let slide = |block: usize| {
        let before = previous[block] as usize;
        let linked = if before == block { 0 } else { links[before] };
        positions[block] = if before == block { 0 } else { positions[before] + 1 };
        let (mut entering, mut entering_lanes) = (block, 0xff);
        for _ in 0..half_width {
            entering_lanes &= links[entering];
            if entering_lanes == 0 {
                break;
            }
            entering = next[entering] as usize;
        }
        let (mut leaving, mut leaving_lanes) = (before, linked);
        for _ in 0..half_width {
            let earlier = previous[leaving] as usize;
            leaving_lanes &= if earlier == leaving { 0 } else { links[earlier] };
            if leaving_lanes == 0 {
                break;
            }
            leaving = earlier;
        }
        Slide {
            entering: entering as u32,
            leaving: leaving as u32,
            entering_lanes,
            leaving_lanes,
            restarts: linked & occupied[block] != occupied[block] || restart(block, positions[block]),
        }
    };
    let slides: Vec<_> = (0..occupied.len()).map(slide).collect();
    let restarts = slides.iter().filter(|slide| slide.restarts).count();
    (2 * restarts < slides.len()).then_some(slides)
}

/// The running sums of the current plane and of the previous plane, `N` numbers for each vertex.
#[derive(Clone, Debug)]
pub(in crate::matching) struct History<const N: usize> {
    /// Sums of the current plane, then of the previous plane.
    planes: [Lanes<N>; 2],
    /// Index of the first block of each of the two planes.
    first: [usize; 2],
}

impl<const N: usize> History<N> {
    /// Allocates sums for planes of up to `blocks` blocks. `planes` is 1 if the previous vertex on the axis
    /// is in the same plane, and 2 if it is in the previous plane.
    pub(in crate::matching) fn new(blocks: usize, planes: usize) -> Self {
        let sums = |plane| Lanes::zeros(if plane < planes { blocks } else { 0 });
        Self { planes: [sums(0), sums(1)], first: [0; 2] }
    }

    /// Prepares for the plane whose first block is `first`: the current plane becomes the previous plane.
    pub(in crate::matching) fn begin_plane(&mut self, first: usize) {
        if !self.planes[1].blocks().is_empty() {
            self.planes.swap(0, 1);
        }
        self.first = [first, self.first[0]];
    }

    /// Returns the memory in bytes.
    pub(in crate::matching) fn bytes(&self) -> usize {
        self.planes.iter().map(Lanes::bytes).sum()
    }

    /// Returns the sums of a block of the current or the previous plane.
    #[inline(always)]
    fn at(&self, block: usize) -> &Block<N> {
        let plane = usize::from(block < self.first[0]);
        &self.planes[plane].blocks()[block - self.first[plane]]
    }
}

/// Computes the sums of a block from the sums of the previous block, or directly if the sums restart. Stores
/// them in `history`.
#[inline(always)]
pub(super) fn across<S: Simd, T: Running<S>, const N: usize>(
    simd: S,
    links: &[u8],
    neighbors: &Neighbors,
    (half_width, slide): (usize, Slide),
    block: usize,
    row: &impl Fn(usize, usize) -> f32x8<S>,
    history: &mut History<N>,
) -> T {
    let sums = if slide.restarts {
        direct::across(simd, links, neighbors, half_width, block, row)
    } else {
        let mut sums = T::load(simd, history.at(neighbors.previous[block] as usize)).recentered();
        let (entering, leaving, w) = (slide.entering as usize, slide.leaving as usize, half_width as f32);
        sums.add(
            simd,
            slide.entering_lanes,
            w,
            #[inline(always)]
            |c| row(entering, c),
        );
        sums.add(
            simd,
            slide.leaving_lanes,
            -(w + 1.0),
            #[inline(always)]
            |c| -row(leaving, c),
        );
        sums
    };
    let index = block - history.first[0];
    sums.store(&mut history.planes[0].blocks_mut()[index]);
    sums
}
