//! Computes how far a point of the surface moves towards a collider.

/// Gap in cells that is closed, for each unit of compression.
const GAP: f32 = 0.75;

/// Greatest gap in cells that is closed.
const GREATEST_GAP: f32 = 0.3;

/// Length over which the remaining gap rounds the rim of the contact, as a multiple of the gap that is closed.
const CORNER: f32 = 0.5;

/// Greatest length of a displacement, in cells.
pub(super) const GREATEST_LENGTH: f32 = (1.0 + 0.5 * CORNER) * GREATEST_GAP;

/// Length over which the displacement fades out beyond the corner, as a multiple of the gap that is closed. The longer
/// it is, the less a motion of the surface is enlarged: see [`approach`].
const SPAN: f32 = 14.0;

/// Gap from which on points do not move, as a multiple of the gap that is closed.
const END: f32 = 1.0 + CORNER + SPAN;

/// Distance in cells between a component and a collider at which the effect has faded out.
pub(super) const FADED: f32 = 0.5;

/// Distance in cells up to which a component touches a collider. A search for the nearest point can end there.
pub(super) const TOUCHING: f32 = 0.01;

/// Cosines of the angle at rest between the outward normal of the surface and the direction to the collider between
/// which the effect fades in. The walls of a body that stands on a plane do not move.
pub(super) const FACING: [f32; 2] = [0.1, 0.4];

/// Compression up to which the flattened surface follows the volume correction in part.
const HELD: f32 = 0.01;

/// How a point of the surface comes closer to a collider.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Approach {
    /// Displacement towards the collider, in cells; at least 0.
    pub(super) length: f32,
    /// Share of a later displacement along the normal of the collider that is held back, from 0 to 1: 1 minus the
    /// derivative of the remaining gap.
    pub(super) hold: f32,
}

/// Returns how a point comes closer to a collider.
///
/// The component of the body is at a distance `least` from the collider, and gaps are measured from there: a point at
/// this distance does not move. Gaps up to `c`, the gap that is closed, become 0. From there to `END c` they rise to
/// their own value, with continuous derivatives, and in the same order. The derivative is at most
/// 1 + 1.5 (1 + CORNER / 2) / SPAN = 1.13.
///
/// * `gap`: distance from the collider, in cells. Points nearer than `least` do not move.
/// * `least`: distance of the component, at least 0; see [`least_gap`].
/// * `compression`: 1 minus the derivative of the gap along the rest shape; without effect below 0.
/// * `cosine`: of the angle at rest between the outward normal and the direction to the collider.
pub(super) fn approach(gap: f32, least: f32, compression: f32, cosine: f32) -> Approach {
    let closed = (GAP * compression).min(GREATEST_GAP) * (1.0 - least / FADED);
    let gap = gap - least;
    if !(closed > 0.0 && gap < END * closed && cosine > FACING[0]) {
        return Approach::default();
    }
    let weight = smooth_step(cosine, FACING);
    let x = gap / closed - 1.0;
    let (length, slope) = if x <= 0.0 {
        (gap, 0.0)
    } else if x < CORNER {
        (gap - closed * x * x / (2.0 * CORNER), x / CORNER)
    } else {
        let t = (x - CORNER) / SPAN;
        ((1.0 + 0.5 * CORNER) * closed * (1.0 - t * t * (3.0 - 2.0 * t)), 1.0)
    };
    let hold = weight * (1.0 - slope) * (compression / HELD).min(1.0);
    Approach { length: weight * length.max(0.0), hold }
}

/// Returns the distance from which gaps are measured, for the nearest point of a component.
pub(super) fn least_gap(nearest: f32) -> f32 {
    (nearest - TOUCHING).clamp(0.0, FADED)
}

/// Returns the distance beyond `least` from which on points do not move, for a compression of at most `compression`.
pub(super) fn greatest_reach(compression: f32, least: f32) -> f32 {
    END * (GAP * compression).min(GREATEST_GAP) * (1.0 - least / FADED)
}

/// Returns the smooth step from 0 to 1 between two values.
fn smooth_step(x: f32, [from, to]: [f32; 2]) -> f32 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn remaining_gap_is_monotonic_and_continuous() {
        for compression in [0.01, 0.2, 0.4, 2.0] {
            for least in [0.0, 0.1, 0.4] {
                let remaining = |gap: f32| gap - approach(gap, least, compression, 1.0).length;
                let step = 1e-3;
                for k in 0..5_000 {
                    let (a, b) = (remaining(step * k as f32), remaining(step * (k + 1) as f32));
                    let bound = (1.0 + 1.5 * (1.0 + CORNER / 2.0) / SPAN) * step + 1e-6;
                    assert!((-1e-6..=bound).contains(&(b - a)), "{compression} {least} {k}: {a} {b}");
                }
            }
        }
        // A compression of 0.2 closes a gap of 0.15, and has no effect from END times that on.
        assert_eq!(approach(0.14, 0.0, 0.2, 1.0), Approach { length: 0.14, hold: 1.0 });
        assert_eq!(approach(END * 0.1501, 0.0, 0.2, 1.0), Approach::default());
    }

    #[test]
    fn nearest_point_and_surface_that_is_not_compressed_or_does_not_face_the_collider_do_not_move() {
        for gap in [-0.1, 0.0, 1e-6, 0.1] {
            assert_eq!(approach(gap, 0.0, 0.0, 1.0).length, 0.0);
            assert_eq!(approach(gap, 0.0, -0.5, 1.0).length, 0.0);
            assert_eq!(approach(gap, 0.0, 0.5, 0.0).length, 0.0);
            assert_eq!(approach(gap, gap.max(0.0), 0.5, 1.0).length, 0.0);
            assert_eq!(approach(gap, FADED, 0.5, 1.0).length, 0.0);
        }
    }

    #[test]
    fn hold_is_one_minus_the_derivative_of_the_remaining_gap() {
        for k in 1..900 {
            let (gap, step) = (1e-3 * k as f32, 1e-3);
            let [before, after] =
                [gap - step, gap + step].map(|gap| gap - approach(gap, 0.0, 0.4, 1.0).length);
            let expected = (1.0 - (after - before) / (2.0 * step)).max(0.0);
            let hold = approach(gap, 0.0, 0.4, 1.0).hold;
            assert!((hold - expected).abs() < 0.02, "{gap}: {hold} {expected}");
        }
    }
}
