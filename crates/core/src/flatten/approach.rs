//! By how much a point of the surface comes closer to a collider.

/// Gap in cells that is closed, for each unit of compression.
const GAP: f64 = 0.5;

/// Greatest gap in cells that is closed.
const GREATEST_GAP: f64 = 0.25;

/// Gap from which on points do not move, as a multiple of the gap that is closed.
const SPAN: f64 = 3.0;

/// Gap in cells from which on points do not move, whatever the compression is.
pub(super) const REACH: f64 = SPAN * GREATEST_GAP;

/// Gaps in cells between which a contact fades out, by the least gap of the component: up to the first one it has its full
/// effect, and from the second one on the component does not touch the collider. The first one is above the gaps of resting
/// bodies, which vibrate by less.
const TOUCHING: [f64; 2] = [0.02, 0.1];

/// Cosines of the angle between the surface and the collider between which the effect fades in. The walls of a body that
/// stands on a plane do not move.
const FACING: [f64; 2] = [0.3, 0.7];

/// Returns the smooth step from 0 to 1 between two values.
fn smooth_step(x: f64, [from, to]: [f64; 2]) -> f64 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Returns how much a component touches a collider, from 0 to 1. `gap`: the least gap of the component.
pub(super) fn touching(gap: f64) -> f64 {
    1.0 - smooth_step(gap, TOUCHING)
}

/// Returns the displacement of a point towards the collider, in cells; at most the gap.
///
/// Gaps up to `c`, the gap that is closed, become 0. From there to `SPAN c` they rise to their own value, with
/// continuous derivatives, and in the same order. Points inside the collider do not move.
///
/// * `gap`: distance from the collider, in cells.
/// * `compression`: 1 minus the stretch of the lattice along the normal of the collider; without effect below 0.
/// * `cosine`: of the angle between the normal of the surface and the opposite of the collider's normal.
pub(super) fn approach(gap: f64, compression: f64, cosine: f64) -> f64 {
    let closed = (GAP * compression).min(GREATEST_GAP);
    if gap <= 0.0 || gap >= SPAN * closed {
        return 0.0;
    }
    let weight = smooth_step(cosine, FACING);
    // The cubic with the values 0 and SPAN, and the derivatives 0 and 1, where the gap is `c` and `SPAN c`.
    let u = ((gap / closed - 1.0) / (SPAN - 1.0)).max(0.0);
    let rest = closed * u * u * ((2.0 * SPAN + 1.0) - (SPAN + 1.0) * u);
    weight * (gap - rest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn remaining_gap_is_monotonic_and_continuous() {
        for compression in [0.01, 0.2, 0.5, 2.0] {
            let remaining = |gap: f64| gap - approach(gap, compression, 1.0);
            let step = 1e-4;
            for k in 0..10_000 {
                let (a, b) = (remaining(step * f64::from(k)), remaining(step * f64::from(k + 1)));
                // The slope of the cubic is at most (2 SPAN + 1)² / (3 (SPAN + 1) (SPAN - 1)) = 49/24.
                assert!(
                    (-1e-12..=49.0 / 24.0 * step + 1e-12).contains(&(b - a)),
                    "{compression} {k}: {a} {b}"
                );
            }
        }
        assert!(approach(0.1, 0.2, 1.0) == 0.1 && approach(0.3, 0.2, 1.0) == 0.0);
    }

    #[test]
    fn surface_that_is_not_compressed_or_does_not_face_the_collider_does_not_move() {
        for gap in [-0.1, 0.0, 1e-6, 0.1] {
            assert_eq!(approach(gap, 0.0, 1.0), 0.0);
            assert_eq!(approach(gap, -0.5, 1.0), 0.0);
            assert_eq!(approach(gap, 0.5, 0.0), 0.0);
        }
        assert_eq!([touching(-0.1), touching(0.0), touching(0.1), touching(1.0)], [1.0, 1.0, 0.0, 0.0]);
    }
}
