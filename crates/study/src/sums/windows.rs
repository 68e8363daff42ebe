//! TimeWindow sums along one axis of a block, one number a vertex: plain and weighted by the offset.

use nalgebra::RealField;

/// f32 or f64.
pub(super) trait Number: RealField + Copy + Into<f64> {
    /// Its name in tables.
    const NAME: &'static str;

    /// The nearest one.
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

/// How a window is summed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Summing {
    /// Each window anew.
    Direct,
    /// Each window from the one before it: what comes in is added, what goes out subtracted. Rounding stays in the sum
    /// to the end of the line.
    Running,
}

impl Summing {
    /// What it is called.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Direct => "direct",
            Self::Running => "running",
        }
    }
}

/// Windows of half-width `half_width` along one axis of a block of `side` vertices along each edge, x fastest.
#[derive(Clone, Copy, Debug)]
pub(super) struct Windows {
    pub(super) side: usize,
    pub(super) half_width: usize,
    pub(super) summing: Summing,
}

impl Windows {
    /// For each vertex i the sum of f over the window around it.
    pub(super) fn plain<T: Number>(&self, axis: usize, f: &[T], out: &mut [T]) {
        let line = Line::along(self, axis);
        for (f, out) in f.chunks_exact(line.len()).zip(out.chunks_exact_mut(line.len())) {
            line.plain(f, out);
        }
    }

    /// For each vertex i the sum of (j - i) f over the window around it. `sums` are the plain ones of the same f.
    pub(super) fn weighted<T: Number>(&self, axis: usize, f: &[T], sums: &[T], out: &mut [T]) {
        let line = Line::along(self, axis);
        let sums = sums.chunks_exact(line.len());
        for ((f, sums), out) in f.chunks_exact(line.len()).zip(sums).zip(out.chunks_exact_mut(line.len())) {
            line.weighted(f, sums, out);
        }
    }
}

/// A line of rows along an axis; the numbers of a row do not meet.
struct Line<'a> {
    windows: &'a Windows,
    /// Numbers in a row.
    rows: usize,
}

impl<'a> Line<'a> {
    /// One along an axis: 0, 1, 2 are x, y, z.
    fn along(windows: &'a Windows, axis: usize) -> Self {
        Self { windows, rows: windows.side.pow(axis as u32) }
    }

    /// Numbers in the line.
    fn len(&self) -> usize {
        self.rows * self.windows.side
    }

    fn plain<T: Number>(&self, f: &[T], out: &mut [T]) {
        let Windows { side, half_width: w, summing } = *self.windows;
        for i in 0..side {
            let (before, own) = self.split(out, i);
            if summing == Summing::Direct || i == 0 {
                self.anew(f, i, own, |sum, f, _| sum + f);
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
                self.anew(f, i, own, |sum, f, offset| sum + offset * f);
                continue;
            }
            // All offsets of the window before are one less now.
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

    /// Sums the window around i from nothing: `fold` takes the sum so far, a number and its offset.
    fn anew<T: Number>(&self, f: &[T], i: usize, own: &mut [T], fold: impl Fn(T, T, T) -> T) {
        let Windows { side, half_width: w, .. } = *self.windows;
        own.fill(T::of(0.0));
        for j in i.saturating_sub(w)..=(i + w).min(side - 1) {
            let offset = T::of(j as f64 - i as f64);
            add(own, self.row(f, j), |sum, f| fold(sum, f, offset));
        }
    }

    fn row<'t, T>(&self, f: &'t [T], i: usize) -> &'t [T] {
        &f[i * self.rows..(i + 1) * self.rows]
    }

    /// The row before the i-th, empty before the first, and the i-th.
    fn split<'t, T>(&self, out: &'t mut [T], i: usize) -> (&'t [T], &'t mut [T]) {
        let (before, from) = out.split_at_mut(i * self.rows);
        (&before[before.len().saturating_sub(self.rows)..], &mut from[..self.rows])
    }
}

/// Folds a row into another.
fn add<T: Number>(sums: &mut [T], row: &[T], fold: impl Fn(T, T) -> T) {
    for (sum, &f) in sums.iter_mut().zip(row) {
        *sum = fold(*sum, f);
    }
}
