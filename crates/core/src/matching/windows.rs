//! Sums over the windows of one axis, broken at missing links (Rivers & James 2007, section 4, made separable).
//!
//! The window of a vertex along an axis: the vertices reached from it by up to `half_width` links either way. For
//! values `f` and the signed number of links `i` from the centre, a pass gives the plain sums W(f) = Σ f and the
//! offset-weighted sums W'(f) = Σ i f.

use fearless_simd::{Select, Simd, SimdBase, SimdFloat, SimdMask, f32x8, mask32x8};

use super::layout::AxisLinks;
use crate::lanes::LANES;

/// The sums of a window for the eight vertices of a block.
pub(super) struct Sums<S: Simd, const PLAIN: usize> {
    /// W of the first `PLAIN` components.
    pub(super) plain: [f32x8<S>; PLAIN],
    /// W' of three components.
    pub(super) weighted: [f32x8<S>; 3],
}

/// A pass along one axis.
#[derive(Clone, Copy)]
pub(super) struct Window<'a> {
    pub(super) axis: &'a AxisLinks,
    pub(super) half_width: usize,
}

impl Window<'_> {
    /// W of the components `0..PLAIN` and W' of the components `FIRST..FIRST + 3` of the `N` that `load` gives
    /// for a block.
    #[inline(always)]
    pub(super) fn sums<S: Simd, const N: usize, const PLAIN: usize, const FIRST: usize>(
        self,
        simd: S,
        block: usize,
        load: impl Fn(usize) -> [f32x8<S>; N],
    ) -> Sums<S, PLAIN> {
        let centre = load(block);
        let zero = f32x8::splat(simd, 0.0);
        let mut sums = Sums { plain: [zero; PLAIN], weighted: [zero; 3] };
        sums.plain.copy_from_slice(&centre[..PLAIN]);
        if self.axis.along_lanes {
            self.lanes_after::<S, N, PLAIN, FIRST>(simd, block, centre, &load, &mut sums);
            self.lanes_before::<S, N, PLAIN, FIRST>(simd, block, centre, &load, &mut sums);
        } else {
            self.blocks_after::<S, N, PLAIN, FIRST>(simd, block, &load, &mut sums);
            self.blocks_before::<S, N, PLAIN, FIRST>(simd, block, &load, &mut sums);
        }
        sums
    }

    #[inline(always)]
    fn blocks_after<S: Simd, const N: usize, const PLAIN: usize, const FIRST: usize>(
        self,
        simd: S,
        block: usize,
        load: &impl Fn(usize) -> [f32x8<S>; N],
        sums: &mut Sums<S, PLAIN>,
    ) {
        let (mut reach, mut at) = (0xff, block);
        for offset in 1..=self.half_width {
            reach &= self.axis.links[at];
            if reach == 0 {
                return;
            }
            at = self.axis.next[at] as usize;
            sums.add::<N, FIRST>(simd, load(at), reach, offset as f32);
        }
    }

    #[inline(always)]
    fn blocks_before<S: Simd, const N: usize, const PLAIN: usize, const FIRST: usize>(
        self,
        simd: S,
        block: usize,
        load: &impl Fn(usize) -> [f32x8<S>; N],
        sums: &mut Sums<S, PLAIN>,
    ) {
        let (mut reach, mut at) = (0xff, block);
        for offset in 1..=self.half_width {
            let before = self.axis.previous[at] as usize;
            if before == at {
                return;
            }
            at = before;
            reach &= self.axis.links[at];
            if reach == 0 {
                return;
            }
            sums.add::<N, FIRST>(simd, load(at), reach, -(offset as f32));
        }
    }

    /// Lane `l` adds lanes `l + 1`, `l + 2`, … : a window over two neighbouring blocks slides along the line.
    #[inline(always)]
    fn lanes_after<S: Simd, const N: usize, const PLAIN: usize, const FIRST: usize>(
        self,
        simd: S,
        block: usize,
        centre: [f32x8<S>; N],
        load: &impl Fn(usize) -> [f32x8<S>; N],
        sums: &mut Sums<S, PLAIN>,
    ) {
        let zero = [f32x8::splat(simd, 0.0); N];
        let (mut reach, mut at, mut near) = (0xff_u32, block, centre);
        for turn in (0..self.half_width).step_by(LANES) {
            let links = u32::from(self.axis.links[at]);
            let next = if links >> (LANES - 1) == 0 { None } else { Some(self.axis.next[at] as usize) };
            let line = match next {
                Some(next) => links | u32::from(self.axis.links[next]) << LANES,
                None => links,
            };
            let far = match next {
                Some(next) => load(next),
                None => zero,
            };
            for shift in 1..=LANES.min(self.half_width - turn) {
                reach &= line >> (shift - 1);
                if reach & 0xff == 0 {
                    return;
                }
                let shifted = slide(simd, shift, near, far);
                sums.add::<N, FIRST>(simd, shifted, reach as u8, (turn + shift) as f32);
            }
            let Some(next) = next else { return };
            (at, near) = (next, far);
        }
    }

    /// Lane `l` adds lanes `l - 1`, `l - 2`, …
    #[inline(always)]
    fn lanes_before<S: Simd, const N: usize, const PLAIN: usize, const FIRST: usize>(
        self,
        simd: S,
        block: usize,
        centre: [f32x8<S>; N],
        load: &impl Fn(usize) -> [f32x8<S>; N],
        sums: &mut Sums<S, PLAIN>,
    ) {
        let zero = [f32x8::splat(simd, 0.0); N];
        let (mut reach, mut at, mut near) = (0xff_u32, block, centre);
        for turn in (0..self.half_width).step_by(LANES) {
            let before = self.axis.previous[at] as usize;
            let linked = before != at && self.axis.links[before] >> (LANES - 1) != 0;
            let before = if linked { Some(before) } else { None };
            let links = match before {
                Some(before) => u32::from(self.axis.links[before]),
                None => 0,
            };
            let line = links | u32::from(self.axis.links[at]) << LANES;
            let far = match before {
                Some(before) => load(before),
                None => zero,
            };
            for shift in 1..=LANES.min(self.half_width - turn) {
                reach &= line >> (LANES - shift);
                if reach & 0xff == 0 {
                    return;
                }
                let shifted = slide(simd, LANES - shift, far, near);
                sums.add::<N, FIRST>(simd, shifted, reach as u8, -((turn + shift) as f32));
            }
            let Some(before) = before else { return };
            (at, near) = (before, far);
        }
    }
}

impl<S: Simd, const PLAIN: usize> Sums<S, PLAIN> {
    /// Adds the values of a vertex `offset` links away, in the lanes that reach it.
    #[inline(always)]
    fn add<const N: usize, const FIRST: usize>(
        &mut self,
        simd: S,
        values: [f32x8<S>; N],
        reach: u8,
        offset: f32,
    ) {
        let zero = f32x8::splat(simd, 0.0);
        let mask = mask32x8::from_bitmask(simd, u64::from(reach));
        let offset = f32x8::splat(simd, offset);
        let mut reached = values;
        for c in 0..N {
            reached[c] = mask.select(values[c], zero);
        }
        for c in 0..PLAIN {
            self.plain[c] += reached[c];
        }
        for c in 0..3 {
            self.weighted[c] = reached[FIRST + c].mul_add(offset, self.weighted[c]);
        }
    }
}

/// Eight lanes from lane `shift` on of two neighbouring blocks.
#[inline(always)]
fn slide<S: Simd, const N: usize>(
    simd: S,
    shift: usize,
    a: [f32x8<S>; N],
    b: [f32x8<S>; N],
) -> [f32x8<S>; N] {
    macro_rules! by {
        ($($shift:literal)*) => {
            match shift {
                0 => a,
                $($shift => {
                    let mut slid = a;
                    for c in 0..N {
                        slid[c] = simd.slide_f32x8::<$shift>(a[c], b[c]);
                    }
                    slid
                })*
                _ => b,
            }
        };
    }
    by!(1 2 3 4 5 6 7)
}
