//! Places of the texels of the vertices.

/// Largest width and height of an image, which all graphics hardware of the last ten years reads.
pub(crate) const MAX_SIZE: usize = 8192;

/// Places of the texels of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct TexelLayout {
    /// Width and height, powers of two.
    pub(super) width: usize,
    pub(super) height: usize,
    /// Number of vertices.
    pub(super) vertices: usize,
    /// Number of frames: rows of a block.
    pub(super) frames: usize,
}

impl TexelLayout {
    /// Returns the layout with the smallest image, and of these the one nearest to a square; `None` if none is small
    /// enough.
    pub(crate) fn new(vertices: usize, frames: usize) -> Option<Self> {
        let of_width = |width: usize| {
            let height = (vertices.div_ceil(width) * frames).next_power_of_two();
            (height <= MAX_SIZE).then_some(Self { width, height, vertices, frames })
        };
        let widths = (0..=MAX_SIZE.ilog2()).map(|power| 1 << power);
        widths.filter_map(of_width).min_by_key(|layout| {
            let Self { width, height, .. } = layout;
            (width * height, width.abs_diff(*height))
        })
    }

    /// Returns the texture coordinates of the texel of a vertex in the first frame, with the origin at the upper left.
    pub(super) fn coordinates(self, vertex: usize) -> [f32; 2] {
        let (column, row) = (vertex % self.width, vertex / self.width * self.frames);
        [(column, self.width), (row, self.height)].map(|(texel, size)| (texel as f32 + 0.5) / size as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texels_of_all_frames_of_all_vertices_are_different_ones_within_the_image() {
        for (vertices, frames) in [(1, 1), (8, 24), (100, 7), (1000, 241), (60_000, 120)] {
            let layout = TexelLayout::new(vertices, frames).unwrap();
            let TexelLayout { width, height, .. } = layout;
            assert!(width.is_power_of_two() && height.is_power_of_two() && width.max(height) <= MAX_SIZE);
            let mut is_used = vec![false; width * height];
            for vertex in 0..vertices {
                let [u, v] = layout.coordinates(vertex).map(f64::from);
                let (column, row) = ((u * width as f64) as usize, (v * height as f64) as usize);
                for frame in 0..frames {
                    let texel = &mut is_used[(row + frame) * width + column];
                    assert!(!*texel);
                    *texel = true;
                }
            }
            // Rounding up to a power of two costs at most a factor of 4: one in each direction.
            assert!(width * height <= 4 * (vertices * frames).next_power_of_two());
        }
    }

    #[test]
    fn more_texels_than_an_image_has_are_refused() {
        assert_eq!(TexelLayout::new(MAX_SIZE + 1, MAX_SIZE), None);
        assert_eq!(TexelLayout::new(1, MAX_SIZE + 1), None);
        assert!(TexelLayout::new(MAX_SIZE, MAX_SIZE).is_some());
    }
}
