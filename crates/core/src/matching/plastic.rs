//! Plastic shapes of regions: the rest shape of a region changes where the region is strained beyond a limit (Müller et
//! al. 2005).
//!
//! The plastic shape S of a region is a symmetric matrix with positive eigenvalues and the determinant 1. The region is
//! fitted with the rest offsets S y in place of y = x⁰ - c⁰: R is the rotation of A Sᵀ, and the motion of the region moves
//! a vertex to R S y + c. The sums over the regions stay the same, and so do the momenta: Σ m/n S y is zero, and R is
//! optimal for the moments of x and S y. S does not change the volume of the region.
//!
//! C = M⁻¹ Σ m/n y yᵀ is the rest spread of a region, and F = A C⁻¹ its deformation gradient, the matrix for which F y is
//! closest to x - c. F S⁻¹ is its elastic part, and E = sym(Rᵀ F S⁻¹) the stretch of this part. The strain is the
//! deviatoric part D of E, relative to the mean stretch e = tr E/3. Without it, |D| is zero, also for a region that is
//! only compressed or expanded. Where |D| exceeds the yield strain, S moves towards the present shape:
//!
//! ```text
//! k = c (1 - yield/|D|)      H = k D/2      S ← (1 + H) S (1 + H)
//! ```
//!
//! with c = 1 - exp(-creep h), at most 1/2, and |k D| at most 1/2. Then S is scaled to the determinant 1, and pulled back
//! to |S - 1| <= max. |·| is the Frobenius norm.
//!
//! Müller et al. replace S by (1 + k D) S, which is not symmetric, and divide E by the cube root of its determinant. The
//! product with 1 + H on both sides agrees with the symmetric part of theirs to first order, and is positive definite for
//! every S. Dividing by the mean stretch agrees to first order as well, needs no root, and is safe for inverted regions.
//!
//! The state stores T = S - 1, which is exactly zero in a region that has never yielded.

use fearless_simd::{Select, Simd, SimdBase, SimdFloat, SimdMask, f32x16, mask32x16};

use super::cascade::RegionTransform;
use super::goals::{FitRotations, Means, Pair, twice_trace};
use super::rotation::columns;
use crate::simd::lanes::{Block, Lanes, load_two, split_two, store};

/// Least mean stretch: strains of regions that are crushed below it, or inverted, are relative to it. It is the mean
/// stretch of a cube that is compressed evenly to a twentieth of its volume.
const LEAST_STRETCH: f32 = 0.37;

/// Greatest |k D| of a step. The eigenvalues of 1 + H are then at least 3/4, so that S stays positive definite.
const GREATEST_CHANGE: f32 = 0.5;

/// Parameters of the plastic flow in a step. With a flow of `None`, the plastic shapes stay as they are.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Flow {
    /// c, the part of the strain beyond the yield strain that becomes plastic.
    pub(crate) fraction: f32,
    /// The strain |D| beyond which a region flows.
    pub(crate) yield_strain: f32,
    /// Greatest |S - 1|.
    pub(crate) max: f32,
}

/// The region transform that fits a rotation to each region in its plastic shape. Its memory is the quaternion of the
/// rotation, which is first the warm start and then the result.
pub(super) struct FitPlastic<'a> {
    pub(super) fit: FitRotations<'a>,
    /// C⁻¹ of each region.
    pub(super) inverse_spreads: &'a Lanes<6>,
    /// T of each region.
    pub(super) strains: &'a Lanes<6>,
}

/// The region transform that fits rotations as [`FitPlastic`], and then lets the plastic shapes flow. The second part of
/// its memory is T of each region.
pub(super) struct FitFlowing<'a> {
    pub(super) fit: FitRotations<'a>,
    /// C⁻¹ of each region.
    pub(super) inverse_spreads: &'a Lanes<6>,
    pub(super) flow: Flow,
}

impl RegionTransform<&mut [Block<4>]> for FitPlastic<'_> {
    #[inline(always)]
    fn apply<S: Simd>(&self, simd: S, first: usize, sums: &mut [Block<12>], quaternions: &mut [Block<4>]) {
        for index in (0..sums.len()).step_by(2) {
            let pair = Pair::new(first, index, sums.len());
            let strains = self.strains.blocks();
            let t = load_two(simd, [&strains[pair.blocks[0]], &strains[pair.blocks[1]]]);
            fit(simd, &self.fit, self.inverse_spreads, pair, t, sums, quaternions);
        }
    }
}

impl RegionTransform<(&mut [Block<4>], &mut [Block<6>])> for FitFlowing<'_> {
    #[inline(always)]
    fn apply<S: Simd>(
        &self,
        simd: S,
        first: usize,
        sums: &mut [Block<12>],
        (quaternions, strains): (&mut [Block<4>], &mut [Block<6>]),
    ) {
        for index in (0..sums.len()).step_by(2) {
            let pair = Pair::new(first, index, sums.len());
            let t = load_two(simd, [&strains[pair.indices[0]], &strains[pair.indices[1]]]);
            let Fitted { a, r, inverse_spread } =
                fit(simd, &self.fit, self.inverse_spreads, pair, t, sums, quaternions);
            let strain = Strain::new(simd, elastic_stretch(&a, &r, inverse_spread));
            let yields = strain.exceeds(simd, self.flow.yield_strain);
            if yields.any_true() {
                let flowed = strain.flow(simd, t, self.flow);
                let mut new = t;
                for i in 0..6 {
                    new[i] = yields.select(flowed[i], t[i]);
                }
                let halves = split_two(simd, new);
                store(halves[1], &mut strains[pair.indices[1]]);
                store(halves[0], &mut strains[pair.indices[0]]);
            }
        }
    }
}

/// The fit of regions in their plastic shapes.
struct Fitted<S: Simd> {
    /// A S, column by column.
    a: [f32x16<S>; 9],
    /// The rotation R of A S, column by column.
    r: [f32x16<S>; 9],
    /// (S C S)⁻¹ = S⁻¹ C⁻¹ S⁻¹.
    inverse_spread: [f32x16<S>; 6],
}

/// Fits the regions of two blocks in their plastic shapes 1 + `t`, as [`FitRotations`] fits regions in their rest shapes.
#[inline(always)]
fn fit<S: Simd>(
    simd: S,
    fit: &FitRotations,
    inverse_spreads: &Lanes<6>,
    pair: Pair,
    t: [f32x16<S>; 6],
    sums: &mut [Block<12>],
    quaternions: &mut [Block<4>],
) -> Fitted<S> {
    let (inverse_mass, means): (_, Means<f32x16<S>>) = fit.means(simd, pair, sums);
    let inverse_spreads = inverse_spreads.blocks();
    let mut inverse_spread =
        load_two(simd, [&inverse_spreads[pair.blocks[0]], &inverse_spreads[pair.blocks[1]]]);
    // Most regions of a body have never yielded. Without this branch, they would get the same results.
    let is_shaped = is_any(simd, t);
    let mut a = means.central;
    if is_shaped {
        a = shaped(&a, t);
        inverse_spread = between_inverses(simd, inverse_spread, t);
    }
    let r = columns(simd, fit.rotate(simd, pair, (means.mean, a), quaternions));
    if let Some(potential) = fit.potential {
        let change = spread_change(simd, inverse(simd, inverse_spread), t);
        let u = twice_trace(&a, &r) - change;
        potential.store(pair.blocks, fit.occupied(pair), (inverse_mass, fit.factors), means.mean, u);
    }
    let mut g = r;
    if is_shaped {
        g = shaped(&r, t);
    }
    fit.store(simd, pair, (means.mean, means.d), g, sums);
    Fitted { a, r, inverse_spread }
}

/// Returns whether any of some numbers is not zero.
#[inline(always)]
fn is_any<S: Simd>(simd: S, numbers: [f32x16<S>; 6]) -> bool {
    let mut greatest = numbers[0].abs();
    for i in 1..6 {
        greatest = greatest.max(numbers[i].abs());
    }
    greatest.simd_gt(f32x16::splat(simd, 0.0)).any_true()
}

/// Computes S⁻¹ X S⁻¹ of a symmetric matrix X and the plastic shape S = 1 + `t`, whose inverse is its adjugate.
#[inline(always)]
fn between_inverses<S: Simd>(simd: S, x: [f32x16<S>; 6], t: [f32x16<S>; 6]) -> [f32x16<S>; 6] {
    let inverse = adjugate(shape(simd, t));
    symmetric_product(&times(&full(inverse), x), inverse)
}

/// Returns all nine entries of a symmetric matrix.
#[inline(always)]
pub(crate) fn full<V: Copy>([xx, yy, zz, xy, xz, yz]: [V; 6]) -> [V; 9] {
    [xx, xy, xz, xy, yy, yz, xz, yz, zz]
}

/// Computes X T of a matrix X, column by column, and a symmetric matrix T, where the product is symmetric.
#[inline(always)]
fn symmetric_product<S: Simd>(
    x: &[f32x16<S>; 9],
    [xx, yy, zz, xy, xz, yz]: [f32x16<S>; 6],
) -> [f32x16<S>; 6] {
    [
        x[0].mul_add(xx, x[3].mul_add(xy, x[6] * xz)),
        x[1].mul_add(xy, x[4].mul_add(yy, x[7] * yz)),
        x[2].mul_add(xz, x[5].mul_add(yz, x[8] * zz)),
        x[0].mul_add(xy, x[3].mul_add(yy, x[6] * yz)),
        x[0].mul_add(xz, x[3].mul_add(yz, x[6] * zz)),
        x[1].mul_add(xz, x[4].mul_add(yz, x[7] * zz)),
    ]
}

/// Computes X (1 + T) of a matrix X, column by column, and a symmetric matrix T with the entries xx, yy, zz, xy, xz, yz.
/// If T is zero, the result is exactly X.
#[inline(always)]
pub(crate) fn shaped<S: Simd, V: SimdFloat<S, Element = f32>>(x: &[V; 9], t: [V; 6]) -> [V; 9] {
    let product = times(x, t);
    let mut shaped = *x;
    for i in 0..9 {
        shaped[i] = x[i] + product[i];
    }
    shaped
}

/// Computes X T of a matrix X, column by column, and a symmetric matrix T with the entries xx, yy, zz, xy, xz, yz.
#[inline(always)]
pub(crate) fn times<S: Simd, V: SimdFloat<S, Element = f32>>(
    x: &[V; 9],
    [xx, yy, zz, xy, xz, yz]: [V; 6],
) -> [V; 9] {
    let mut product = *x;
    for row in 0..3 {
        let [p, q, r] = [x[row], x[3 + row], x[6 + row]];
        product[row] = p.mul_add(xx, q.mul_add(xy, r * xz));
        product[3 + row] = p.mul_add(xy, q.mul_add(yy, r * yz));
        product[6 + row] = p.mul_add(xz, q.mul_add(yz, r * zz));
    }
    product
}

/// Computes the adjugate of a symmetric matrix with the entries xx, yy, zz, xy, xz, yz.
#[inline(always)]
pub(crate) fn adjugate<S: Simd, V: SimdFloat<S, Element = f32>>([xx, yy, zz, xy, xz, yz]: [V; 6]) -> [V; 6] {
    [
        yy.mul_add(zz, -(yz * yz)),
        xx.mul_add(zz, -(xz * xz)),
        xx.mul_add(yy, -(xy * xy)),
        xz.mul_add(yz, -(xy * zz)),
        xy.mul_add(yz, -(xz * yy)),
        xy.mul_add(xz, -(yz * xx)),
    ]
}

/// Computes the inverse of a positive definite matrix with the entries xx, yy, zz, xy, xz, yz, and zero for zero, the
/// matrix of lanes without a vertex.
#[inline(always)]
pub(crate) fn inverse<S: Simd, V: SimdFloat<S, Element = f32>>(simd: S, m: [V; 6]) -> [V; 6]
where
    V::Mask: Select<V>,
{
    let zero = V::splat(simd, 0.0);
    let mut inverse = adjugate(m);
    let det = m[0].mul_add(inverse[0], m[3].mul_add(inverse[3], m[4] * inverse[4]));
    let factor = det.simd_gt(zero).select(V::splat(simd, 1.0) / det, zero);
    for i in 0..6 {
        inverse[i] *= factor;
    }
    inverse
}

/// Returns 1 + `t`.
#[inline(always)]
pub(crate) fn shape<S: Simd, V: SimdFloat<S, Element = f32>>(simd: S, mut t: [V; 6]) -> [V; 6] {
    for i in 0..3 {
        t[i] += V::splat(simd, 1.0);
    }
    t
}

/// Computes tr(X) - tr(S⁻¹ X S⁻¹) of the spread X = S C S of a region in its plastic shape S = 1 + `t`: the change of the
/// trace of its spread by the shape.
#[inline(always)]
fn spread_change<S: Simd>(simd: S, x: [f32x16<S>; 6], t: [f32x16<S>; 6]) -> f32x16<S> {
    let rest = between_inverses(simd, x, t);
    (x[0] - rest[0]) + (x[1] - rest[1]) + (x[2] - rest[2])
}

/// Computes E = sym(Rᵀ F S⁻¹). Rᵀ A S is symmetric, because R is the rotation of A S, and F S⁻¹ is A S (S C S)⁻¹.
#[inline(always)]
fn elastic_stretch<S: Simd>(
    a: &[f32x16<S>; 9],
    r: &[f32x16<S>; 9],
    inverse_spread: [f32x16<S>; 6],
) -> [f32x16<S>; 6] {
    let p = full([
        r[0].mul_add(a[0], r[1].mul_add(a[1], r[2] * a[2])),
        r[3].mul_add(a[3], r[4].mul_add(a[4], r[5] * a[5])),
        r[6].mul_add(a[6], r[7].mul_add(a[7], r[8] * a[8])),
        r[0].mul_add(a[3], r[1].mul_add(a[4], r[2] * a[5])),
        r[0].mul_add(a[6], r[1].mul_add(a[7], r[2] * a[8])),
        r[3].mul_add(a[6], r[4].mul_add(a[7], r[5] * a[8])),
    ]);
    let e = times(&p, inverse_spread);
    [e[0], e[4], e[8], (e[1] + e[3]) * 0.5, (e[2] + e[6]) * 0.5, (e[5] + e[7]) * 0.5]
}

/// The elastic strain of regions, not yet divided by the mean stretch.
struct Strain<S: Simd> {
    /// The deviatoric part of E.
    deviator: [f32x16<S>; 6],
    /// |D|² e².
    squared: f32x16<S>,
    /// e, at least [`LEAST_STRETCH`].
    stretch: f32x16<S>,
}

impl<S: Simd> Strain<S> {
    /// Computes the strain of regions with the elastic stretch E.
    #[inline(always)]
    fn new(simd: S, e: [f32x16<S>; 6]) -> Self {
        let mean = (e[0] + e[1] + e[2]) * (1.0 / 3.0);
        let mut deviator = e;
        for i in 0..3 {
            deviator[i] = e[i] - mean;
        }
        let squared = norm_squared(deviator);
        Self { deviator, squared, stretch: mean.max(f32x16::splat(simd, LEAST_STRETCH)) }
    }

    /// Returns the lanes in which |D| is above `limit`. A strain that is not a number is not.
    #[inline(always)]
    fn exceeds(&self, simd: S, limit: f32) -> mask32x16<S> {
        let limit = self.stretch * f32x16::splat(simd, limit);
        self.squared.simd_gt(limit * limit)
    }

    /// Returns T of the plastic shapes after a step of flow, in the lanes in which the regions yield.
    #[inline(always)]
    fn flow(&self, simd: S, t: [f32x16<S>; 6], flow: Flow) -> [f32x16<S>; 6] {
        let norm = self.squared.sqrt();
        // |k D| = fraction (|D| - yield), and H is half of k D = |k D| (E - e)/(e |D|), with e |D| = |E - e|.
        let excess = norm - self.stretch * flow.yield_strain;
        let change = (excess * flow.fraction).min(self.stretch * GREATEST_CHANGE);
        let scale = change * 0.5 / (norm * self.stretch);
        let mut h = self.deviator;
        for i in 0..6 {
            h[i] *= scale;
        }
        // (1 + H) S (1 + H) - 1 = T + W + Wᵀ + W H with W = H S.
        let w = shaped(&full(h), t);
        let wh = symmetric_product(&w, h);
        let flowed = [
            t[0] + (w[0] + w[0] + wh[0]),
            t[1] + (w[4] + w[4] + wh[1]),
            t[2] + (w[8] + w[8] + wh[2]),
            t[3] + (w[1] + w[3] + wh[3]),
            t[4] + (w[2] + w[6] + wh[4]),
            t[5] + (w[5] + w[7] + wh[5]),
        ];
        let mut t = of_volume_one(simd, flowed);
        let squared = norm_squared(t);
        let beyond = squared.simd_gt(f32x16::splat(simd, flow.max * flow.max));
        if beyond.any_true() {
            let share = f32x16::splat(simd, flow.max) / squared.sqrt();
            for i in 0..6 {
                t[i] = beyond.select(t[i] * share, t[i]);
            }
            // log det is concave, so that the determinant is at least 1 on the way back to 1, and the scaling to the
            // determinant 1 shrinks the shape further. Two times, because the determinant may be up to 2.
            t = of_volume_one(simd, of_volume_one(simd, t));
        }
        t
    }
}

/// Computes the square of the Frobenius norm of a symmetric matrix.
#[inline(always)]
fn norm_squared<S: Simd>([xx, yy, zz, xy, xz, yz]: [f32x16<S>; 6]) -> f32x16<S> {
    let off_diagonal = xy.mul_add(xy, xz.mul_add(xz, yz * yz));
    xx.mul_add(xx, yy.mul_add(yy, zz.mul_add(zz, off_diagonal + off_diagonal)))
}

/// Scales the shape 1 + `t` to the determinant 1, and returns it minus 1.
#[inline(always)]
fn of_volume_one<S: Simd>(simd: S, mut t: [f32x16<S>; 6]) -> [f32x16<S>; 6] {
    // det(1 + T) - 1 = tr T + tr adj T + det T.
    let adjugate = adjugate(t);
    let det_t = t[0].mul_add(adjugate[0], t[3].mul_add(adjugate[3], t[4] * adjugate[4]));
    let excess = (t[0] + t[1] + t[2]) + ((adjugate[0] + adjugate[1] + adjugate[2]) + det_t);
    // (1 + x)^(-1/3) - 1 by its series. After a step of flow, x is between -0.07 and 0, and the error below 2e-7.
    let mut series = f32x16::splat(simd, SERIES[3]);
    for i in [2, 1, 0] {
        series = series.mul_add(excess, f32x16::splat(simd, SERIES[i]));
    }
    let change = series * excess;
    for i in 0..6 {
        t[i] = change.mul_add(t[i], t[i]);
    }
    for i in 0..3 {
        t[i] += change;
    }
    t
}

/// Coefficients of x, x², x³ and x⁴ in the series of (1 + x)^(-1/3).
const SERIES: [f32; 4] = [-1.0 / 3.0, 2.0 / 9.0, -14.0 / 81.0, 35.0 / 243.0];
