//! The local-moment cascade and its adjoint: sums of a vertex field over all regions, and back.
//!
//! Region r of half-width w holds the vertices reached from its centre vertex r by up to w links in z, then in y,
//! then in x. FastLSM (Rivers & James 2007, section 4) sums global moments; here the moments are taken about each
//! window's own centre, which needs 54 window sums in place of 72 and cancels nothing. With (i, j, k) the offset
//! from the centre, W and W' the plain and the offset-weighted window sum of a pass:
//!
//! ```text
//! x   S = W(f)                          Sx = W'(f)              3 → 6
//! y   S = W(S)  Sx = W(Sx)              Sy = W'(S)              6 → 9
//! z   S = W(S)  Sx = W(Sx)  Sy = W(Sy)  Sz = W'(S)              9 → 12
//!     a transform of each region:  (S, Sx, Sy, Sz) → (b, X, Y, Z), the field b + i X + j Y + k Z on the region
//! z   b = W(b) - W'(Z)  X = W(X)  Y = W(Y)                     12 → 9
//! y   b = W(b) - W'(Y)  X = W(X)                                9 → 6
//! x   b = W(b) - W'(X)                                          6 → 3
//! ```
//!
//! The second half is the exact adjoint of the first: vertex i gathers from the regions that hold i.

use fearless_simd::{Simd, dispatch, f32x8};

use super::layout::Layout;
use super::windows::Window;
use crate::lanes::{Lanes, load, store};
use crate::parallel::{Executor, level};

/// A vector for each lattice vertex, weighted: what the regions sum.
pub(crate) trait VertexField: Sync {
    /// The field in a block.
    fn load<S: Simd>(&self, simd: S, block: usize) -> [f32x8<S>; 3];
}

/// What is done with the sums of a region.
pub(crate) trait RegionTransform: Sync {
    /// What the transform keeps for a block of regions.
    type Memory: Send;
    /// (S, Sx, Sy, Sz) → (b, X, Y, Z), three components each.
    fn apply<S: Simd>(
        &self,
        simd: S,
        block: usize,
        sums: [f32x8<S>; 12],
        memory: &mut Self::Memory,
    ) -> [f32x8<S>; 12];
}

/// What is done with the value that a vertex gathers from its regions.
pub(crate) trait VertexUpdate: Sync {
    /// What the update writes for a block of vertices.
    type Memory: Send;
    /// Takes Σ (b + i X + j Y + k Z) over the regions that hold the vertex.
    fn apply<S: Simd>(&self, simd: S, block: usize, gathered: [f32x8<S>; 3], memory: &mut Self::Memory);
}

/// The buffers of the cascade: 84 bytes for each stored lane.
#[derive(Clone, Debug)]
pub(crate) struct Cascade {
    half_width: usize,
    /// Sums after x, then transforms; on the way back sums after y.
    odd: Lanes<12>,
    /// Sums after y; on the way back sums after z.
    even: Lanes<9>,
}

impl Cascade {
    /// The cascade over regions of half-width `half_width` in cells, at least 1.
    pub(crate) fn new(layout: &Layout, half_width: usize) -> Self {
        Self { half_width, odd: Lanes::zeros(layout.blocks()), even: Lanes::zeros(layout.blocks()) }
    }

    /// Memory that the buffers take.
    pub(crate) fn bytes(&self) -> usize {
        self.odd.bytes() + self.even.bytes()
    }

    /// Sums `field` over each region and transforms the sums.
    pub(crate) fn gather<F: VertexField, T: RegionTransform>(
        &mut self,
        layout: &Layout,
        executor: &Executor,
        field: &F,
        transform: &T,
        memory: &mut [T::Memory],
    ) {
        let [x, y, z] = self.windows(layout);
        let Self { odd, even, .. } = self;
        executor.chunks(odd.blocks_mut(), even.blocks_mut(), |first, out, _| {
            dispatch!(level(), simd => field_sums(simd, x, field, first, out));
        });
        let source = odd.blocks();
        executor.chunks(even.blocks_mut(), &mut *memory, |first, out, _| {
            dispatch!(level(), simd => deeper_sums(simd, y, source, first, out));
        });
        let source = even.blocks();
        executor.chunks(odd.blocks_mut(), memory, |first, out, memory| {
            dispatch!(level(), simd => region_sums(simd, z, source, transform, first, out, memory));
        });
    }

    /// Gathers at each vertex what [`Cascade::gather`] left on the regions that hold it.
    pub(crate) fn scatter<U: VertexUpdate>(
        &mut self,
        layout: &Layout,
        executor: &Executor,
        update: &U,
        memory: &mut [U::Memory],
    ) {
        let [x, y, z] = self.windows(layout);
        let Self { odd, even, .. } = self;
        let source = odd.blocks();
        executor.chunks(even.blocks_mut(), &mut *memory, |first, out, _| {
            dispatch!(level(), simd => region_gather(simd, z, source, first, out));
        });
        executor.chunks(odd.blocks_mut(), &mut *memory, |first, out, _| {
            dispatch!(level(), simd => deeper_gather(simd, y, even.blocks(), first, out));
        });
        let source = odd.blocks();
        executor.chunks(even.blocks_mut(), memory, |first, _, memory| {
            dispatch!(level(), simd => vertex_gather(simd, x, source, update, first, memory));
        });
    }

    fn windows<'a>(&self, layout: &'a Layout) -> [Window<'a>; 3] {
        [0, 1, 2].map(|axis| Window { axis: layout.axis(axis), half_width: self.half_width })
    }
}

/// x, 3 → 6.
#[inline(always)]
fn field_sums<S: Simd, F: VertexField>(
    simd: S,
    x: Window,
    field: &F,
    first: usize,
    out: &mut [[[f32; 8]; 12]],
) {
    for (block, out) in (first..).zip(out) {
        let sums = x.sums::<S, 3, 3, 0>(
            simd,
            block,
            #[inline(always)]
            |at| field.load(simd, at),
        );
        store(sums.plain, &mut out[..3]);
        store(sums.weighted, &mut out[3..6]);
    }
}

/// y, 6 → 9.
#[inline(always)]
fn deeper_sums<S: Simd>(
    simd: S,
    y: Window,
    source: &[[[f32; 8]; 12]],
    first: usize,
    out: &mut [[[f32; 8]; 9]],
) {
    for (block, out) in (first..).zip(out) {
        let sums = y.sums::<S, 6, 6, 0>(
            simd,
            block,
            #[inline(always)]
            |at| load(simd, &source[at]),
        );
        store(sums.plain, &mut out[..6]);
        store(sums.weighted, &mut out[6..9]);
    }
}

/// z, 9 → 12, and the transform of each region.
#[inline(always)]
fn region_sums<S: Simd, T: RegionTransform>(
    simd: S,
    z: Window,
    source: &[[[f32; 8]; 9]],
    transform: &T,
    first: usize,
    out: &mut [[[f32; 8]; 12]],
    memory: &mut [T::Memory],
) {
    for ((block, out), memory) in (first..).zip(out).zip(memory) {
        let sums = z.sums::<S, 9, 9, 0>(
            simd,
            block,
            #[inline(always)]
            |at| load(simd, &source[at]),
        );
        let [sz0, sz1, sz2] = sums.weighted;
        let s = sums.plain;
        let sums = [s[0], s[1], s[2], s[3], s[4], s[5], s[6], s[7], s[8], sz0, sz1, sz2];
        store(transform.apply(simd, block, sums, memory), out);
    }
}

/// z, 12 → 9.
#[inline(always)]
fn region_gather<S: Simd>(
    simd: S,
    z: Window,
    source: &[[[f32; 8]; 12]],
    first: usize,
    out: &mut [[[f32; 8]; 9]],
) {
    for (block, out) in (first..).zip(out) {
        let sums = z.sums::<S, 12, 9, 9>(
            simd,
            block,
            #[inline(always)]
            |at| load(simd, &source[at]),
        );
        store(less_weighted(sums.plain, sums.weighted), out);
    }
}

/// y, 9 → 6.
#[inline(always)]
fn deeper_gather<S: Simd>(
    simd: S,
    y: Window,
    source: &[[[f32; 8]; 9]],
    first: usize,
    out: &mut [[[f32; 8]; 12]],
) {
    for (block, out) in (first..).zip(out) {
        let sums = y.sums::<S, 9, 6, 6>(
            simd,
            block,
            #[inline(always)]
            |at| load(simd, &source[at]),
        );
        store(less_weighted(sums.plain, sums.weighted), &mut out[..6]);
    }
}

/// x, 6 → 3, and the update of each vertex.
#[inline(always)]
fn vertex_gather<S: Simd, U: VertexUpdate>(
    simd: S,
    x: Window,
    source: &[[[f32; 8]; 12]],
    update: &U,
    first: usize,
    memory: &mut [U::Memory],
) {
    for (block, memory) in (first..).zip(memory) {
        let sums = x.sums::<S, 6, 3, 3>(
            simd,
            block,
            #[inline(always)]
            |at| load(simd, &source[at]),
        );
        update.apply(simd, block, less_weighted(sums.plain, sums.weighted), memory);
    }
}

/// b = W(b) - W'(last): seen from the vertex, its offset from the region is the opposite of the region's from it.
#[inline(always)]
fn less_weighted<S: Simd, const N: usize>(
    mut plain: [f32x8<S>; N],
    weighted: [f32x8<S>; 3],
) -> [f32x8<S>; N] {
    for c in 0..3 {
        plain[c] -= weighted[c];
    }
    plain
}
