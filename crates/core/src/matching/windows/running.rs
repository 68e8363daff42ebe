//! Computes running sums: sums over wide windows. A running sum follows from the sum of the vertex in the same lane of
//! the previous block, the two vertices that enter the window, and the two vertices that leave it.
//!
//! ```text
//! S[i]  = S[i-2]            +          f[i+w] +         f[i+w-1] -           f[i-1-w] -           f[i-2-w]
//! S'[i] = S'[i-2] - 2 S[i-2] + w       f[i+w] + (w - 1) f[i+w-1] + (w + 1)   f[i-1-w] + (w + 2)   f[i-2-w]
//! ```
//!
//! S[i] and S'[i] are the plain and the offset-weighted sum of the window around vertex i of a line of linked
//! vertices, f[i] is the value of vertex i, and w is the half-width. A term is omitted if its vertex is not
//! linked to the window. Running sums restart with a direct sum at missing links, and at a fixed interval to
//! limit the accumulation of rounding errors.

use fearless_simd::Simd;

use super::direct;
use super::reach::{self, Reached};
use super::rows::{Input, Rows, negative};
use super::terms::Running;
use crate::lattice::AxisLinks;
use crate::simd::lanes::{Block, Lanes, bits_between};

/// The vertices that enter and leave the windows when the running sums move from the previous block along an
/// axis to a block. Each of the eight lanes is a separate line of vertices.
#[derive(Clone, Copy, Debug)]
pub(in crate::matching) struct Slide {
    entering: Change,
    leaving: Change,
    /// Whether the sums restart with a direct sum at this block.
    restarts: bool,
}

/// The vertices at two consecutive offsets from the centers of windows: see [`Reached`].
#[derive(Clone, Copy, Debug)]
struct Change {
    blocks: [u32; 2],
    /// For the nearer and the farther offset, the bit mask of the lanes with a vertex.
    lanes: [u8; 2],
}

/// Computes the [`Slide`] of each block along an axis. Returns `None` if the sums would restart at half of the blocks
/// or more, as in thin shapes: direct sums are then faster.
///
/// `occupied` has, for each block, the bit mask of the lanes with a vertex. `restart(block, position)`
/// returns whether the sums must restart at a block even if it is linked to the previous block; `position` is
/// the number of blocks before it on its line.
pub(super) fn slides(
    axis: &AxisLinks,
    half_width: usize,
    occupied: &[u8],
    restart: impl Fn(usize, usize) -> bool,
) -> Option<Vec<Slide>> {
    let mut positions = vec![0; occupied.len()];
    let slide = |block: usize| {
        let (previous, links) = axis.previous(block);
        positions[block] = if previous == block { 0 } else { positions[previous] + 1 };
        // The lanes that are linked to the previous block.
        let linked = bits_between(axis.number, links, axis.links[block]) & links;
        Slide {
            entering: Change::new(reach::after(axis, block), half_width, block, 0xff),
            leaving: Change::new(reach::before(axis, previous), half_width, block, linked),
            restarts: linked & occupied[block] != occupied[block] || restart(block, positions[block]),
        }
    };
    let slides: Vec<_> = (0..occupied.len()).map(slide).collect();
    let restarts = slides.iter().filter(|slide| slide.restarts).count();
    (2 * restarts < slides.len()).then_some(slides)
}

impl Change {
    /// Returns the vertices at the offsets w - 1 and w. `reached` are those at the offsets 1, 2, ..., and `linked` is the bit
    /// mask of the lanes that count. If there are none, the blocks are `block`, which is not read.
    fn new(mut reached: impl Iterator<Item = Reached>, half_width: usize, block: usize, linked: u8) -> Self {
        let nearer = reached.nth(half_width - 2).map_or(0, |nearer| nearer.lanes & linked);
        match reached.next() {
            Some(Reached { lanes, blocks }) if nearer != 0 => {
                Self { blocks: blocks.map(|block| block as u32), lanes: [nearer, lanes & linked] }
            }
            _ => Self { blocks: [block as u32; 2], lanes: [0; 2] },
        }
    }
}

/// The running sums of the current plane and of the previous plane, `N` numbers for each vertex. Empty for direct sums.
#[derive(Debug, Default)]
pub(in crate::matching) struct RunningSums<const N: usize> {
    /// Sums of the current plane, then of the previous plane.
    planes: [Lanes<N>; 2],
    /// Index of the first block of each of the two planes.
    first: [usize; 2],
}

impl<const N: usize> RunningSums<N> {
    /// Allocates missing sums for planes of up to `blocks` blocks. `planes` is 1 if the previous vertex on the axis is
    /// in the same plane, and 2 if it is in the previous plane.
    pub(in crate::matching) fn grow(&mut self, blocks: usize, planes: usize) {
        self.planes[..planes].iter_mut().for_each(|sums| sums.grow(blocks));
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
/// them in `running`.
#[inline(always)]
pub(super) fn sums<S: Simd, T: Running<S>, const AXIS: usize, const IN: usize, const N: usize>(
    input: Input<S, impl Rows<IN>, AXIS, IN>,
    axis: &AxisLinks,
    (half_width, slide): (usize, Slide),
    block: usize,
    running: &mut RunningSums<N>,
) -> T {
    let simd = input.simd;
    let sums = if slide.restarts {
        direct::sums(input, axis, half_width, block)
    } else {
        let (previous, w) = (axis.previous(block).0, half_width as f32);
        let mut sums = T::load(simd, running.at(previous)).recentered();
        // Of two consecutive offsets from -w, 1 - w on or from w - 1, w on, the odd one is halfway between two blocks.
        let Slide { entering, leaving, .. } = slide;
        let ([e0, e1], [l0, l1]) = (entering.blocks, leaving.blocks);
        let ([e0, e1], [l0, l1]) = ([e0 as usize, e1 as usize], [l0 as usize, l1 as usize]);
        let ([enters_first, enters_last], [leaves_first, leaves_last]) = (entering.lanes, leaving.lanes);
        let (enters_halfway, enters_at, leaves_halfway, leaves_at) = if half_width % 2 == 1 {
            (
                (enters_last, w),
                (e0, enters_first, w - 1.0),
                (leaves_last, w + 2.0),
                (l1, leaves_first, w + 1.0),
            )
        } else {
            (
                (enters_first, w - 1.0),
                (e1, enters_last, w),
                (leaves_first, w + 1.0),
                (l0, leaves_last, w + 2.0),
            )
        };
        let (lanes, offset) = enters_halfway;
        sums.add(simd, lanes, offset, input.between(e0, e1));
        let (at, lanes, offset) = enters_at;
        sums.add(simd, lanes, offset, input.of(at));
        let (lanes, offset) = leaves_halfway;
        sums.add(simd, lanes, -offset, negative(input.between(l0, l1)));
        let (at, lanes, offset) = leaves_at;
        sums.add(simd, lanes, -offset, negative(input.of(at)));
        sums
    };
    let index = block - running.first[0];
    sums.store(&mut running.planes[0].blocks_mut()[index]);
    sums
}
