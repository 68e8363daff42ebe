//! The frames in which colliders are shown.

use std::io;
use std::ops::Range;

use super::{ColliderSurface, Samples};
use crate::collider::posed_frames;

/// Samples whose vectors are numbers in all frames: in frames in which a collider is disabled it has those of another frame.
pub(super) struct ShownSamples<'a> {
    samples: &'a mut dyn Samples,
    hidden: Vec<HiddenFrames>,
}

/// A collider that is not shown in all frames.
struct HiddenFrames {
    /// Its vectors in a sample.
    vectors: Range<usize>,
    is_shown: Vec<bool>,
    /// For each frame, the one whose vectors it has.
    posed: Vec<usize>,
}

impl<'a> ShownSamples<'a> {
    /// Also returns the colliders that are shown in any frame.
    pub(super) fn new<'b>(
        samples: &'a mut dyn Samples,
        colliders: &'b [ColliderSurface],
    ) -> io::Result<(Self, Vec<&'b ColliderSurface>)> {
        let (mut hidden, mut shown) = (Vec::new(), Vec::new());
        let mut found = Vec::new();
        for collider in colliders {
            let vectors = collider.vectors();
            let mut is_shown = Vec::new();
            for frame in 0..samples.frames() {
                samples.read(frame, vectors.start..vectors.start + 1, &mut found)?;
                is_shown.push(!found[0][0].is_nan());
            }
            let Some(posed) = posed_frames(&is_shown) else { continue };
            shown.push(collider);
            if is_shown.contains(&false) {
                hidden.push(HiddenFrames { vectors, is_shown, posed });
            }
        }
        Ok((Self { samples, hidden }, shown))
    }

    fn hidden(&self, point: usize) -> Option<&HiddenFrames> {
        self.hidden.iter().find(|hidden| hidden.vectors.contains(&point))
    }
}

impl Samples for ShownSamples<'_> {
    fn frames(&self) -> usize {
        self.samples.frames()
    }

    fn read(&mut self, frame: usize, points: Range<usize>, out: &mut Vec<[f32; 3]>) -> io::Result<()> {
        let frame = self.hidden(points.start).map_or(frame, |hidden| hidden.posed[frame]);
        self.samples.read(frame, points, out)
    }

    fn is_shown(&self, frame: usize, point: usize) -> bool {
        self.hidden(point).is_none_or(|hidden| hidden.is_shown[frame])
    }
}
