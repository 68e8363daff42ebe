//! Moments of a motion at which something is looked at that takes long.

/// Whether a frame, from 1 on, is one of so many moments, spread evenly over all frames, the last among them. Of fewer
/// frames than moments each is one.
pub(crate) fn is_moment(frame: u32, frames: u32, moments: u32) -> bool {
    let before = |frame: u32| u64::from(frame) * u64::from(moments) / u64::from(frames);
    before(frame) != before(frame - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_are_spread_evenly() {
        let of = |frames, moments| -> Vec<u32> {
            (1..=frames).filter(|&frame| is_moment(frame, frames, moments)).collect()
        };
        assert_eq!(of(12, 4), [3, 6, 9, 12]);
        assert_eq!(of(10, 4), [3, 5, 8, 10]);
        assert_eq!(of(3, 12), [1, 2, 3]);
        assert!(is_moment(u32::MAX, u32::MAX, 12) && !is_moment(1, u32::MAX, 12));
    }
}
