//! Computes the frequency of the lowest elastic mode of a free body, by the Lanczos method (Lanczos 1950).
//!
//! For small displacements u, a step accelerates the vertices by -(alpha/dt²) K u with K = 1 - S, where S u is the
//! mean of the rigid displacements of the regions at each vertex ([`RegionDamper`]). With stiffness factors up to 1,
//! K is F (1 - S), with the factor F of each vertex and a mean that is weighted by the factors of the regions. K is
//! symmetric in the scalar product Σ m u·v. Its eigenvalues are in [0, 1], and 0 only for rigid displacements of a
//! component, which are projected out. The angular frequency of the mode of the eigenvalue λ is √(λ alpha)/dt.

use super::damping::{MovingRegions, RegionDamper};
use super::integration::add_rigid;
use super::momentum::MomentumTracker;
use crate::lattice::Lattice;
use crate::matching::{Matching, Workspace};
use crate::parallel::Executor;
use crate::simd::lanes::{LANES, Lanes};
use crate::state::{IDENTITIES, Momentum};

/// Greatest number of iterations. Bodies up to about a hundred times as long as thick need fewer.
const MAX_ITERATIONS: usize = 400;

/// Number of iterations between two tests of the convergence.
const TEST_INTERVAL: usize = 8;

/// The iteration ends when the eigenvalue changes by less than this fraction between two tests. The frequency is its
/// square root.
const TOLERANCE: f64 = 5e-3;

/// Least eigenvalue that the f32 fields resolve.
const LEAST_EIGENVALUE: f64 = 1e-7;

/// Computes the smallest eigenvalue of K that does not belong to a rigid displacement.
pub(crate) fn lowest_eigenvalue(
    lattice: &Lattice,
    matching: &Matching,
    damper: &RegionDamper,
    tracker: &mut MomentumTracker,
    executor: &Executor,
) -> f64 {
    let Matching { layout, regions, cascade } = matching;
    let (slots, weights, blocks) = (layout.slots(), &regions.weights, layout.blocks());
    let rotations = Lanes::filled(blocks, IDENTITIES);
    let (low, high) = crate::state::index_bounds(lattice.indices());
    let mut positions = Lanes::zeros(blocks);
    for (&slot, index) in slots.iter().zip(lattice.indices()) {
        let offset = |c: usize| f64::from(index[c]) - 0.5 * (f64::from(low[c]) + f64::from(high[c]));
        positions.set(slot, [0, 1, 2].map(|c| offset(c) as f32));
    }
    let mut workspace = Workspace::default();
    let rest = vec![Some(Momentum::default()); tracker.states().len()];
    let mut remove_rigid = |field: &mut Lanes<3>| {
        tracker.measure_fields(executor, cascade.task_blocks(), weights, &positions, field);
        let (components, corrections) = tracker.corrections(&rest);
        add_rigid(components, corrections, (layout.occupied(), None), &positions, field);
    };
    let mut current = random_field(slots, blocks);
    remove_rigid(&mut current);
    let norm = product(weights, &current, &current).sqrt();
    scale(&mut current, 1.0 / norm);

    let (mut previous, mut next) = (Lanes::zeros(blocks), Lanes::zeros(blocks));
    // The symmetric tridiagonal matrix of K in the Lanczos vectors.
    let (mut diagonal, mut off_diagonal) = (Vec::new(), Vec::new());
    let (mut beta, mut eigenvalue) = (0.0, 1.0);
    while diagonal.len() < MAX_ITERATIONS {
        next.copy_from(&current);
        // The result is (1 - K) current.
        let all = (1.0, regions.factors());
        let moving = MovingRegions { rotations: &rotations, strains: None, velocities: &mut next };
        damper.apply(matching, &mut workspace, executor, moving, all);
        // K current = current - (1 - K) current. Rigid displacements are removed from (1 - K) current and not from the
        // difference, so that the eigenvalue of those that rounding adds is 1. It would be 0, and Lanczos' method
        // would find it.
        remove_rigid(&mut next);
        combine(&mut next, -1.0, &current, 1.0);
        let alpha = product(weights, &next, &current);
        combine(&mut next, 1.0, &current, -alpha);
        combine(&mut next, 1.0, &previous, -beta);
        diagonal.push(alpha);
        beta = product(weights, &next, &next).sqrt();
        if beta.is_nan() || beta <= f64::from(f32::EPSILON) {
            break;
        }
        if diagonal.len().is_multiple_of(TEST_INTERVAL) {
            let smallest = smallest_eigenvalue(&diagonal, &off_diagonal);
            let has_converged = (eigenvalue - smallest).abs() <= TOLERANCE * smallest;
            eigenvalue = smallest;
            if has_converged {
                break;
            }
        }
        off_diagonal.push(beta);
        scale(&mut next, 1.0 / beta);
        std::mem::swap(&mut previous, &mut current);
        std::mem::swap(&mut current, &mut next);
    }
    off_diagonal.truncate(diagonal.len() - 1);
    smallest_eigenvalue(&diagonal, &off_diagonal).max(LEAST_EIGENVALUE)
}

/// Returns a field of pseudo-random vectors, the same on every machine, with components in [-1, 1).
fn random_field(slots: &[u32], blocks: usize) -> Lanes<3> {
    let mut field = Lanes::zeros(blocks);
    let mut seed = 1_u32;
    let mut random = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (seed >> 8) as f32 / (1 << 23) as f32 - 1.0
    };
    for &slot in slots {
        field.set(slot, [random(), random(), random()]);
    }
    field
}

/// Computes Σ m a·b in f64, in storage order.
fn product(weights: &Lanes<2>, a: &Lanes<3>, b: &Lanes<3>) -> f64 {
    let mut sum = 0.0;
    for ((weights, a), b) in weights.blocks().iter().zip(a.blocks()).zip(b.blocks()) {
        for lane in 0..LANES {
            let dot: f64 = (0..3).map(|c| f64::from(a[c][lane]) * f64::from(b[c][lane])).sum();
            sum += f64::from(weights[0][lane]) * dot;
        }
    }
    sum
}

/// Replaces `field` by `factor` field + `other_factor` other.
fn combine(field: &mut Lanes<3>, factor: f64, other: &Lanes<3>, other_factor: f64) {
    let (factor, other_factor) = (factor as f32, other_factor as f32);
    let rows = field.blocks_mut().iter_mut().flatten().zip(other.blocks().iter().flatten());
    for (row, other) in rows {
        for (x, y) in row.iter_mut().zip(other.iter()) {
            *x = *x * factor + y * other_factor;
        }
    }
}

/// Multiplies a field by `factor`.
fn scale(field: &mut Lanes<3>, factor: f64) {
    field.blocks_mut().iter_mut().flatten().flat_map(|row| row.iter_mut()).for_each(|x| *x *= factor as f32);
}

/// Returns the smallest eigenvalue of a symmetric tridiagonal matrix with eigenvalues in about [0, 1], by bisection
/// with Sturm sequences.
fn smallest_eigenvalue(diagonal: &[f64], off_diagonal: &[f64]) -> f64 {
    // The number of negative pivots of the matrix minus x is the number of eigenvalues below x.
    let is_above_an_eigenvalue = |x: f64| {
        let mut pivot = f64::INFINITY;
        (0..diagonal.len()).any(|i| {
            let coupling = if i == 0 { 0.0 } else { off_diagonal[i - 1] * off_diagonal[i - 1] / pivot };
            pivot = diagonal[i] - x - coupling;
            pivot < 0.0
        })
    };
    let (mut low, mut high) = (-1.0, 2.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if is_above_an_eigenvalue(middle) { high = middle } else { low = middle }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_smallest_eigenvalue_of_a_chain_is_known() {
        // The matrix with 2 on the diagonal and -1 beside it, times 1/4, has the eigenvalues sin²(k π / (2 (n + 1))).
        for n in [1, 2, 10, 200] {
            let expected = libm::sin(std::f64::consts::PI / (2.0 * (n as f64 + 1.0))).powi(2);
            let found = smallest_eigenvalue(&vec![0.5; n], &vec![0.25; n - 1]);
            assert!((found - expected).abs() < 1e-12, "{n}: {found} for {expected}");
        }
    }
}
