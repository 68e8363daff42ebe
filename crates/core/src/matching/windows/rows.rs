//! The input of a pass, read for eight vertices at a time.

use fearless_simd::{Simd, SimdBase, f32x8};

use crate::simd::lanes::{Block, between, load};

/// The input of a pass: `N` components for each vertex.
pub(in crate::matching) trait Rows<const N: usize>: Copy {
    /// Returns component `c` of the eight vertices of a block.
    fn row<S: Simd>(self, simd: S, block: usize, c: usize) -> f32x8<S>;
}

/// The components of consecutive blocks.
#[derive(Clone, Copy)]
pub(in crate::matching) struct Source<'a, const N: usize> {
    /// Index of the first block of `blocks` in the layout.
    pub(in crate::matching) first: usize,
    pub(in crate::matching) blocks: &'a [Block<N>],
}

impl<const N: usize> Rows<N> for Source<'_, N> {
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
    pub weights: Option<&'a [Block<2>]>,
    /// p of each vertex, such as its position or its velocity.
    pub vectors: &'a [Block<3>],
}

impl Rows<3> for Weighted<'_> {
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

/// The input of a pass along an axis. A function that it returns gives component `c` of eight vertices.
#[derive(Clone, Copy)]
pub(super) struct Input<S, R, const AXIS: usize, const N: usize> {
    pub(super) simd: S,
    pub(super) rows: R,
}

impl<S: Simd, R: Rows<N>, const AXIS: usize, const N: usize> Input<S, R, AXIS, N> {
    /// Returns the vertices of a block.
    #[inline(always)]
    pub(super) fn of(self, block: usize) -> impl Fn(usize) -> f32x8<S> {
        #[inline(always)]
        move |c| self.rows.row(self.simd, block, c)
    }

    /// Returns the vertices halfway between two consecutive blocks: see [`between`].
    #[inline(always)]
    pub(super) fn between(self, before: usize, after: usize) -> impl Fn(usize) -> f32x8<S> {
        let Self { simd, rows } = self;
        #[inline(always)]
        move |c| between::<S, AXIS>(simd, rows.row(simd, before, c), rows.row(simd, after, c))
    }
}

/// Returns the negatives of the components.
#[inline(always)]
pub(super) fn negative<S: Simd>(row: impl Fn(usize) -> f32x8<S>) -> impl Fn(usize) -> f32x8<S> {
    #[inline(always)]
    move |c| -row(c)
}
