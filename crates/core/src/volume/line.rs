//! Points that move along straight lines, and determinants of them: cubics in the distance moved.

/// A point `p + lambda v`. The fourth lane is padding: a point is then one register of eight lanes.
///
/// Units: cells. `p` is relative to a centre near the body, so that single precision is fine enough.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(32))]
pub(super) struct Moving {
    pub(super) p: [f32; 4],
    pub(super) v: [f32; 4],
}

impl Moving {
    #[cfg(test)]
    pub(super) fn new(p: [f32; 3], v: [f32; 3]) -> Self {
        Self { p: [p[0], p[1], p[2], 0.0], v: [v[0], v[1], v[2], 0.0] }
    }

    /// `self += weight * other`, in position and direction.
    #[inline]
    pub(super) fn add_weighted(&mut self, other: &Self, weight: f32) {
        for k in 0..4 {
            self.p[k] += weight * other.p[k];
        }
        for k in 0..4 {
            self.v[k] += weight * other.v[k];
        }
    }

    #[inline]
    pub(super) fn line(&self) -> Line {
        let wide = |x: &[f32; 4]| [f64::from(x[0]), f64::from(x[1]), f64::from(x[2])];
        Line { p: wide(&self.p), v: wide(&self.v) }
    }
}

/// A vector `p + lambda v` in double precision.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Line {
    p: [f64; 3],
    v: [f64; 3],
}

impl Line {
    #[inline]
    pub(super) fn plus(self, other: Self) -> Self {
        Self { p: add(self.p, other.p), v: add(self.v, other.v) }
    }

    #[inline]
    pub(super) fn minus(self, other: Self) -> Self {
        let negated = |x: [f64; 3]| x.map(|x| -x);
        Self { p: add(self.p, negated(other.p)), v: add(self.v, negated(other.v)) }
    }

    #[inline]
    pub(super) fn times(self, factor: f64) -> Self {
        Self { p: self.p.map(|x| factor * x), v: self.v.map(|x| factor * x) }
    }
}

/// The coefficients of `det[a, b, c]`, that of `lambda^k` at index `k`.
#[inline]
pub(super) fn determinant(a: Line, b: Line, c: Line) -> [f64; 4] {
    let n0 = cross(b.p, c.p);
    let n1 = add(cross(b.p, c.v), cross(b.v, c.p));
    let n2 = cross(b.v, c.v);
    [dot(a.p, n0), dot(a.p, n1) + dot(a.v, n0), dot(a.p, n2) + dot(a.v, n1), dot(a.v, n2)]
}

#[inline]
fn add(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

#[inline]
fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline]
fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
