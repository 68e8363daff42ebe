//! Window sums along one axis of a block, one number per vertex: plain, and weighted by the offset.

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
    /// Each window is computed from the previous one: the entering number is added, the leaving number
    /// subtracted. Rounding errors remain in the sum until the end of the line.
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

/// Windows of half-width `half_width` along one axis of a block of `side` vertices along each edge, x
/// fastest.
#[derive(Clone, Copy, Debug)]
pub(super) struct Windows {
    pub(super) side: usize,
    pub(super) half_width: usize,
    pub(super) summing: Summing,
}

impl Windows {
    /// Computes for each vertex i the sum of f over the window around it.
    pub(super) fn plain<T: Number>(&self, axis: usize, f: &[T], out: &mut [T]) {
        let line = Line::along(self, axis);
        for (f, out) in f.chunks_exact(line.len()).zip(out.chunks_exact_mut(line.len())) {
            line.plain(f, out);
        }
    }

    /// Computes for each vertex i the sum of (j - i) f over the window around it. `sums` are the plain sums
    /// of f.
    pub(super) fn weighted<T: Number>(&self, axis: usize, f: &[T], sums: &[T], out: &mut [T]) {
        let line = Line::along(self, axis);
        let sums = sums.chunks_exact(line.len());
        for ((f, sums), out) in f.chunks_exact(line.len()).zip(sums).zip(out.chunks_exact_mut(line.len())) {
            line.weighted(f, sums, out);
        }
    }
}

/// A line of rows along an axis. Numbers in different columns of the rows are independent.
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
            let (before, own) = self.split(out, i);
            if summing == Summing::Direct || i == 0 {
                self.sum_window(f, i, own, |sum, f, _| sum + f);
                continue;
            }
            own.copy_from_slice(before);
            if i + w < side {
                add(own, self.row(f, i + w), |sum, f| sum + f);
            }
            if i > w {
                add(own, self.row(f, i - 1 - w), |sum, f| sum - f);
            }
        }
    }

    fn weighted<T: Number>(&self, f: &[T], sums: &[T], out: &mut [T]) {
        let Windows { side, half_width: w, summing } = *self.windows;
        for i in 0..side {
            let (before, own) = self.split(out, i);
            if summing == Summing::Direct || i == 0 {
                self.sum_window(f, i, own, |sum, f, offset| sum + offset * f);
                continue;
            }
            // Relative to i, the offsets in the previous window are smaller by 1.
            own.copy_from_slice(before);
            add(own, self.row(sums, i - 1), |sum, plain| sum - plain);
            let (entering, leaving) = (T::of(w as f64), T::of(w as f64 + 1.0));
            if i + w < side {
                add(own, self.row(f, i + w), |sum, f| sum + entering * f);
            }
            if i > w {
                add(own, self.row(f, i - 1 - w), |sum, f| sum + leaving * f);
            }
        }
    }

    /// Sums the window around i directly. The arguments of `fold` are the sum so far, a number and its
    /// offset.
    fn sum_window<T: Number>(&self, f: &[T], i: usize, own: &mut [T], fold: impl Fn(T, T, T) -> T) {
        let Windows { side, half_width: w, .. } = *self.windows;
        own.fill(T::of(0.0));
        for j in i.saturating_sub(w)..=(i + w).min(side - 1) {
            let offset = T::of(j as f64 - i as f64);
            add(own, self.row(f, j), |sum, f| fold(sum, f, offset));
        }
    }

    fn row<'t, T>(&self, f: &'t [T], i: usize) -> &'t [T] {
        &f[i * self.row_len..(i + 1) * self.row_len]
    }

    /// Returns the row before row i (empty for row 0), and row i.
    fn split<'t, T>(&self, out: &'t mut [T], i: usize) -> (&'t [T], &'t mut [T]) {
        let (before, from) = out.split_at_mut(i * self.row_len);
        (&before[before.len().saturating_sub(self.row_len)..], &mut from[..self.row_len])
    }
}

/// Folds `row` into `sums`, element by element.
fn add<T: Number>(sums: &mut [T], row: &[T], fold: impl Fn(T, T) -> T) {
    for (sum, &f) in sums.iter_mut().zip(row) {
        *sum = fold(*sum, f);
    }
}
