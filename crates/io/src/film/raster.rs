//! Fills triangles into a grid of samples with depths. Written here, because a frame fills the same triangles into the
//! picture and into dozens of small depth maps, of which most need neither clipping nor interpolation; the crates for
//! rasterizers on the processor draw one picture with shaders.

/// Rows of samples, each with the largest height of what covers it and the index of that.
#[derive(Clone, Debug, Default)]
pub(super) struct Samples {
    width: usize,
    /// First row.
    first: usize,
    heights: Vec<f32>,
    /// Indices; empty if only heights are needed.
    items: Vec<u32>,
}

/// Index of a sample that nothing covers.
pub(super) const NOTHING: u32 = u32::MAX;

impl Samples {
    /// Clears the samples: rows `first` to `first + rows`, of which nothing is above `height`.
    pub(super) fn clear(&mut self, [width, rows]: [usize; 2], first: usize, height: f32, with_items: bool) {
        (self.width, self.first) = (width, first);
        self.heights.clear();
        self.heights.resize(width * rows, height);
        self.items.clear();
        self.items.resize(if with_items { width * rows } else { 0 }, NOTHING);
    }

    /// Returns the heights, row by row.
    pub(super) fn heights(&self) -> &[f32] {
        &self.heights
    }

    /// Returns the heights and the indices of `count` samples of a row, from a column on.
    pub(super) fn row(&self, x: usize, y: usize, count: usize) -> (&[f32], &[u32]) {
        let at = (y - self.first) * self.width + x;
        (&self.heights[at..at + count], &self.items[at..at + count])
    }

    /// Fills a triangle: columns, rows and heights of its corners, which are linear between them. A sample is at the
    /// middle of its column and row. Of equal heights the first one stays.
    pub(super) fn fill(&mut self, corners: [[f32; 3]; 3], item: u32) {
        let [[ax, ay, az], [bx, by, bz], [cx, cy, cz]] = corners;
        let area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay);
        if area.is_nan() || area.abs() <= 1e-12 {
            return;
        }
        let rows = self.heights.len() / self.width.max(1);
        // Whole numbers without `ceil` and `floor`, which are calls on some processors.
        let range = |low: f32, high: f32, first: usize, count: usize| {
            let (low, high) = ((low - 0.5).max(first as f32), (high - 0.5).min((first + count) as f32 - 1.0));
            let start = low as usize + usize::from(low as usize as f32 != low);
            (low <= high && start <= high as usize).then_some((start, high as usize))
        };
        let columns = range(ax.min(bx).min(cx), ax.max(bx).max(cx), 0, self.width);
        let lines = range(ay.min(by).min(cy), ay.max(by).max(cy), self.first, rows);
        let (Some((left, right)), Some((top, bottom))) = (columns, lines) else { return };
        let inverse = area.recip();
        // Weights of b and c are linear: w = w0 + x dx + y dy.
        let (b_dx, b_dy) = ((cy - ay) * inverse, -(cx - ax) * inverse);
        let (c_dx, c_dy) = (-(by - ay) * inverse, (bx - ax) * inverse);
        let has_items = !self.items.is_empty();
        for y in top..=bottom {
            let dy = y as f32 + 0.5 - ay;
            let start = (y - self.first) * self.width;
            for x in left..=right {
                let dx = x as f32 + 0.5 - ax;
                let b = dx * b_dx + dy * b_dy;
                let c = dx * c_dx + dy * c_dy;
                if b < 0.0 || c < 0.0 || b + c > 1.0 {
                    continue;
                }
                let height = az + b * (bz - az) + c * (cz - az);
                let sample = &mut self.heights[start + x];
                if height > *sample {
                    *sample = height;
                    if has_items {
                        self.items[start + x] = item;
                    }
                }
            }
        }
    }
}
