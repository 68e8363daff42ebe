//! What changes from one picture to the next.

use super::Picture;

/// Largest difference of a color, of 255, that counts as unchanged. It does not grow: pictures are compared with what is
/// shown, and not with the picture before.
const UNCHANGED: u8 = 1;

/// The part of a picture that changes.
#[derive(Clone, Debug)]
pub(super) struct Patch {
    /// Column and row of the upper left pixel, both even, as WebP needs them.
    pub(super) start: [u32; 2],
    pub(super) size: [u32; 2],
    /// Red, green, blue, and 255 where the picture changes, 0 elsewhere, row by row.
    pub(super) pixels: Vec<[u8; 4]>,
}

/// The picture that is shown.
#[derive(Debug, Default)]
pub(super) struct Canvas(Vec<[u8; 3]>);

impl Canvas {
    /// Shows a picture. Returns what changes; a pixel that does not, if nothing does.
    pub(super) fn show(&mut self, picture: &Picture) -> Patch {
        let [width, height] = picture.size.map(|side| side as usize);
        let canvas = &mut self.0;
        if canvas.is_empty() {
            canvas.clone_from(&picture.pixels);
            let pixels = canvas.iter().map(|&[r, g, b]| [r, g, b, 255]).collect();
            return Patch { start: [0; 2], size: picture.size, pixels };
        }
        let is_changed =
            |(old, new): (&[u8; 3], &[u8; 3])| old.iter().zip(new).any(|(a, b)| a.abs_diff(*b) > UNCHANGED);
        let changed: Vec<bool> = canvas.iter().zip(&picture.pixels).map(is_changed).collect();
        let (mut low, mut high) = ([usize::MAX; 2], [0; 2]);
        for (y, row) in changed.chunks(width).enumerate() {
            let Some(first) = row.iter().position(|&is_changed| is_changed) else { continue };
            let last = row.iter().rposition(|&is_changed| is_changed).unwrap_or(first);
            low = [low[0].min(first), low[1].min(y)];
            high = [high[0].max(last + 1), y + 1];
        }
        if high == [0; 2] {
            (low, high) = ([0; 2], [1; 2]);
        }
        let low = low.map(|side| side / 2 * 2);
        let mut pixels = Vec::with_capacity((high[0] - low[0]) * (high[1] - low[1]));
        for y in low[1]..high[1].min(height) {
            for at in y * width + low[0]..y * width + high[0] {
                let [r, g, b] = if changed[at] { picture.pixels[at] } else { canvas[at] };
                canvas[at] = [r, g, b];
                pixels.push([r, g, b, if changed[at] { 255 } else { 0 }]);
            }
        }
        let size = [0, 1].map(|axis| (high[axis] - low[axis]) as u32);
        Patch { start: low.map(|side| side as u32), size, pixels }
    }
}
