//! Computes window sums along one axis of a block, one number per vertex: plain, and weighted by the offset
//! from the center of the window.

use nalgebra::RealField;

/// Floating-point type: f32 or f64.
pub(super) trait Number: RealField + Copy + Into<f64> {
    /// Name in tables.
    const NAME: &'static str;

    /// Converts to the nearest number.
    fn of(value: f64) -> Self {
        nalgebra::convert(value)
    }
}

impl Number for f32 {
    const NAME: &'static str = "f32";
}

impl Number for f64 {
    const NAME: &'static str = "f64";
}

/// Method of summing windows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Summing {
    /// Each window is summed independently.
    Direct,
    /// Each window is computed from the previous window: the number that enters is added, and the number that
    /// leaves is subtracted. Rounding errors remain in the sum until the end of the line.
    Running,
}

impl Summing {
    /// Returns the name in tables.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Direct => "direct",
            Self::Running => "running",
        }
    }
}

/// The windows of half-width `half_width` in a block of `side` vertices along each edge. Numbers are ordered
/// by z, then y, then x.
#[derive(Clone, Copy, Debug)]
pub(super) struct Windows {
    pub(super) side: usize,
    pub(super) half_width: usize,
    pub(super) summing: Summing,
}

impl Windows {
    /// Computes for each vertex i the sum of f over the window around i.
    pub(super) fn plain<T: Number>(&self, axis: usize, f: &[T], out: &mut [T]) {
        let line = Line::along(self, axis);
        for (f, out) in f.chunks_exact(line.len()).zip(out.chunks_exact_mut(line.len())) {
            line.plain(f, out);
        }
    }

    /// Computes for each vertex i the sum of (j - i) f[j] over the vertices j in the window around i. `sums`
    /// are the plain sums of f.
    pub(super) fn weighted<T: Number>(&self, axis: usize, f: &[T], sums: &[T], out: &mut [T]) {
        let line = Line::along(self, axis);
        let sums = sums.chunks_exact(line.len());
        for ((f, sums), out) in f.chunks_exact(line.len()).zip(sums).zip(out.chunks_exact_mut(line.len())) {
            line.weighted(f, sums, out);
        }
    }
}

/// Consecutive numbers of the block that are summed together along an axis: a sequence of rows, one for each
/// coordinate of the axis. Numbers in different columns of the rows are independent.
struct Line<'a> {
    windows: &'a Windows,
    /// Number of elements in a row.
    row_len: usize,
}

impl<'a> Line<'a> {
    /// Returns the line along an axis: 0, 1, 2 are x, y, z.
    fn along(windows: &'a Windows, axis: usize) -> Self {
        Self { windows, row_len: windows.side.pow(axis as u32) }
    }

    /// Returns the number of elements in the line.
    fn len(&self) -> usize {
        self.row_len * self.windows.side
    }

    fn plain<T: Number>(&self, f: &[T], out: &mut [T]) {
        let Windows { side, half_width: w, summing } = *self.windows;
        for i in 0..side {
            let (previous, current) = self.split(out, i);
            if summing == Summing::Direct || i == 0 {
                self.sum_window(f, i, current, |sum, f, _| sum + f);
                continue;
            }
            current.copy_from_slice(previous);
            if i + w < side {
                add(current, self.row(f, i + w), |sum, f| sum + f);
            }
            if i > w {
                add(current, self.row(f, i - 1 - w), |sum, f| sum - f);
            }
        }
    }

    fn weighted<T: Number>(&self, f: &[T], sums: &[T], out: &mut [T]) {
        let Windows { side, half_width: w, summing } = *self.windows;
        for i in 0..side {
            let (previous, current) = self.split(out, i);
            if summing == Summing::Direct || i == 0 {
                self.sum_window(f, i, current, |sum, f, offset| sum + offset * f);
                continue;
            }
            // The offset of a vertex relative to i is smaller by 1 than its offset relative to i - 1.
            current.copy_from_slice(previous);
            add(current, self.row(sums, i - 1), |sum, plain| sum - plain);
            let (entering, leaving) = (T::of(w as f64), T::of(w as f64 + 1.0));
            if i + w < side {
                add(current, self.row(f, i + w), |sum, f| sum + entering * f);
            }
            if i > w {
                add(current, self.row(f, i - 1 - w), |sum, f| sum + leaving * f);
            }
        }
    }

    /// Sums the window around i directly into the row `sums`. The arguments of `fold` are the sum so far, a
    /// number and its offset from i.
    fn sum_window<T: Number>(&self, f: &[T], i: usize, sums: &mut [T], fold: impl Fn(T, T, T) -> T) {
        let Windows { side, half_width: w, .. } = *self.windows;
        sums.fill(T::of(0.0));
        for j in i.saturating_sub(w)..=(i + w).min(side - 1) {
            let offset = T::of(j as f64 - i as f64);
            add(sums, self.row(f, j), |sum, f| fold(sum, f, offset));
        }
    }

    /// Returns row i.
    fn row<'t, T>(&self, f: &'t [T], i: usize) -> &'t [T] {
        &f[i * self.row_len..(i + 1) * self.row_len]
    }

    /// Returns row i - 1 (empty for i = 0) and row i.
    fn split<'t, T>(&self, out: &'t mut [T], i: usize) -> (&'t [T], &'t mut [T]) {
        let (before, rest) = out.split_at_mut(i * self.row_len);
        (&before[before.len().saturating_sub(self.row_len)..], &mut rest[..self.row_len])
    }
}

/// Folds `row` into `sums`, element by element.
fn add<T: Number>(sums: &mut [T], row: &[T], fold: impl Fn(T, T) -> T) {
    for (sum, &f) in sums.iter_mut().zip(row) {
        *sum = fold(*sum, f);
    }
}
