//! Wide windows across the lanes, as running sums: what a step along the axis brings in and what it leaves behind.
//!
//! ```text
//! S[i]  = S[i-1]           +           f[i+w] -           f[i-1-w]
//! S'[i] = S'[i-1] - S[i-1] + w         f[i+w] + (w + 1)   f[i-1-w]
//! ```
//!
//! each term only where the links reach so far. Rounding would pile up, so they begin anew, vertex by vertex, at
//! missing links and at a fixed interval.

use fearless_simd::{Simd, f32x8};

use super::terms::Running;
use super::{NARROW_ACROSS, direct};
use crate::lattice::{AxisLinks, Neighbours};
use crate::simd::lanes::{Block, Lanes};

/// What enters and leaves the windows of a block, seen from those of the block before it.
#[derive(Clone, Copy, Debug)]
pub(in crate::matching) struct Slide {
    pub(super) entering: u32,
    pub(super) leaving: u32,
    /// The lanes in which a vertex enters, as bits.
    pub(super) entering_lanes: u8,
    /// The lanes in which a vertex leaves, as bits.
    pub(super) leaving_lanes: u8,
    /// Whether the sums begin anew.
    pub(super) begins: bool,
}

/// The slides of all blocks along an axis across the lanes. `occupied` are the lanes that hold a vertex, `anew` says
/// of a block, and of how far it is along its line, whether its sums begin anew whatever is linked. `None` if narrow
/// windows, or most of those of a thin shape, are better summed vertex by vertex.
pub(in crate::matching) fn slides(
    axis: &AxisLinks,
    half_width: usize,
    occupied: &[u8],
    anew: impl Fn(usize, usize) -> bool,
) -> Option<Vec<Slide>> {
    let Neighbours { next, previous } = axis.across.as_ref().filter(|_| half_width > NARROW_ACROSS)?;
    let links = &axis.links;
    let mut place = vec![0; occupied.len()];
    let slide = |block: usize| {
        let before = previous[block] as usize;
        let linked = if before == block { 0 } else { links[before] };
        place[block] = if before == block { 0 } else { place[before] + 1 };
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
            begins: linked & occupied[block] != occupied[block] || anew(block, place[block]),
        }
    };
    let slides: Vec<_> = (0..occupied.len()).map(slide).collect();
    let begin = slides.iter().filter(|slide| slide.begins).count();
    (2 * begin < slides.len()).then_some(slides)
}

/// The running sums of the plane at hand and of the one before it, `N` numbers by block.
#[derive(Clone, Debug)]
pub(in crate::matching) struct Trail<const N: usize> {
    planes: [Lanes<N>; 2],
    first: [usize; 2],
}

impl<const N: usize> Trail<N> {
    /// For planes of up to `blocks` blocks. Sums within a plane need `planes` = 1, from plane to plane 2.
    pub(in crate::matching) fn new(blocks: usize, planes: usize) -> Self {
        let held = |plane| Lanes::zeros(if plane < planes { blocks } else { 0 });
        Self { planes: [held(0), held(1)], first: [0; 2] }
    }

    /// Goes on to the plane with the first block `first`.
    pub(in crate::matching) fn enter(&mut self, first: usize) {
        if !self.planes[1].blocks().is_empty() {
            self.planes.swap(0, 1);
        }
        self.first = [first, self.first[0]];
    }

    /// Memory that it takes.
    pub(in crate::matching) fn bytes(&self) -> usize {
        self.planes.iter().map(Lanes::bytes).sum()
    }

    #[inline(always)]
    fn at(&self, block: usize) -> &Block<N> {
        let plane = usize::from(block < self.first[0]);
        &self.planes[plane].blocks()[block - self.first[plane]]
    }
}

/// The windows of a block, from those of the block before it.
#[inline(always)]
pub(super) fn across<S: Simd, T: Running<S>, const N: usize>(
    simd: S,
    links: &[u8],
    neighbours: &Neighbours,
    (half_width, slide): (usize, Slide),
    block: usize,
    row: &impl Fn(usize, usize) -> f32x8<S>,
    trail: &mut Trail<N>,
) -> T {
    let sums = if slide.begins {
        direct::across(simd, links, neighbours, half_width, block, row)
    } else {
        let mut sums = T::load(simd, trail.at(neighbours.previous[block] as usize)).recenterd();
        let (entering, leaving, reach) = (slide.entering as usize, slide.leaving as usize, half_width as f32);
        sums.add(
            simd,
            slide.entering_lanes,
            reach,
            #[inline(always)]
            |c| row(entering, c),
        );
        sums.add(
            simd,
            slide.leaving_lanes,
            -(reach + 1.0),
            #[inline(always)]
            |c| -row(leaving, c),
        );
        sums
    };
    let at = block - trail.first[0];
    sums.store(&mut trail.planes[0].blocks_mut()[at]);
    sums
}
