//! Axis-aligned boxes.

use nalgebra::{Point3, Vector3};

/// Axis-aligned box in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounds {
    pub(super) low: Point3<f64>,
    pub(super) high: Point3<f64>,
}

impl Default for Bounds {
    fn default() -> Self {
        Self::EMPTY
    }
}

impl Bounds {
    /// Contains no point.
    pub(super) const EMPTY: Self = Self {
        low: Point3::new(f64::INFINITY, f64::INFINITY, f64::INFINITY),
        high: Point3::new(f64::NEG_INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY),
    };

    /// Contains all points.
    pub(super) const ALL: Self = Self { low: Self::EMPTY.high, high: Self::EMPTY.low };

    /// Contains the origin only.
    pub(super) const ZERO: Self = Self { low: Point3::new(0.0, 0.0, 0.0), high: Point3::new(0.0, 0.0, 0.0) };

    /// Returns the smallest box that contains the points.
    pub(super) fn of(points: impl IntoIterator<Item = Point3<f64>>) -> Self {
        points.into_iter().fold(Self::EMPTY, |Self { low, high }, point| Self {
            low: low.inf(&point),
            high: high.sup(&point),
        })
    }

    /// Returns the length of the longest side.
    pub(crate) fn longest_side(&self) -> f64 {
        (self.high - self.low).max()
    }

    /// Returns the box enlarged by `margin` on all sides.
    pub(crate) fn enlarged(self, margin: f64) -> Self {
        let margin = Vector3::repeat(margin);
        Self { low: self.low - margin, high: self.high + margin }
    }

    /// Returns the greatest distance between a point of this box and one of the other.
    pub(super) fn greatest_difference(&self, other: &Self) -> f64 {
        (self.high - other.low).sup(&(other.high - self.low)).norm()
    }

    /// Returns the center and the radius of the sphere through the corners.
    pub(super) fn sphere(&self) -> (Vector3<f32>, f32) {
        let (center, half) = (nalgebra::center(&self.low, &self.high), (self.high - self.low) * 0.5);
        (center.coords.map(|x| x as f32), half.norm() as f32)
    }

    /// Returns the intersection, which may be empty.
    pub(super) fn intersection(&self, other: &Self) -> Self {
        Self { low: self.low.sup(&other.low), high: self.high.inf(&other.high) }
    }

    /// Returns the smallest box that contains both.
    pub(super) fn union(&self, other: &Self) -> Self {
        Self { low: self.low.inf(&other.low), high: self.high.sup(&other.high) }
    }

    /// Returns whether the box contains no point. A box with a NaN is empty.
    pub(super) fn is_empty(&self) -> bool {
        !(0..3).all(|a| self.low[a] <= self.high[a])
    }

    /// Returns whether the boxes have a common point.
    pub(crate) fn intersects(&self, other: &Self) -> bool {
        (0..3).all(|a| self.low[a] <= other.high[a] && other.low[a] <= self.high[a])
    }

    /// Calls `visit` for each pair of boxes that have a common point, the one with the lesser lower x coordinate first,
    /// and for each box and itself if `with_itself`. `order` is a buffer.
    pub(super) fn for_each_pair(
        count: u32,
        bounds: impl Fn(u32) -> Self,
        with_itself: bool,
        order: &mut Vec<u32>,
        mut visit: impl FnMut(u32, u32),
    ) {
        order.clear();
        order.extend((0..count).filter(|&index| !bounds(index).is_empty()));
        order.sort_unstable_by(|&a, &b| bounds(a).low.x.total_cmp(&bounds(b).low.x).then(a.cmp(&b)));
        for (place, &a) in order.iter().enumerate() {
            let own = bounds(a);
            let later = order[place + usize::from(!with_itself)..].iter();
            let later = later.take_while(|&&b| bounds(b).low.x <= own.high.x);
            later.filter(|&&b| bounds(b).intersects(&own)).for_each(|&b| visit(a, b));
        }
    }

    /// Returns on which sides of the box a point is outside: one bit for each of the six sides.
    pub(super) fn sides_of(&self, point: &Point3<f64>) -> u8 {
        let side = |a: usize| u8::from(point[a] < self.low[a]) | u8::from(point[a] > self.high[a]) << 1;
        side(0) | side(1) << 2 | side(2) << 4
    }

    pub(super) fn contains(&self, point: &Point3<f64>) -> bool {
        (0..3).all(|a| self.low[a] <= point[a] && point[a] <= self.high[a])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_pair_of_boxes_that_intersect_is_found_once() {
        let cube = |x: f64| Bounds::of([Point3::new(x, 0.0, 0.0), Point3::new(x + 1.0, 1.0, 1.0)]);
        let boxes = [cube(2.5), cube(0.0), Bounds::EMPTY, cube(0.5), cube(3.5)];
        let pairs = |with_itself: bool| {
            let mut pairs = Vec::new();
            Bounds::for_each_pair(
                5,
                |k| boxes[k as usize],
                with_itself,
                &mut Vec::new(),
                |a, b| {
                    pairs.push((a, b));
                },
            );
            pairs
        };
        assert_eq!(pairs(false), [(1, 3), (0, 4)]);
        assert_eq!(pairs(true), [(1, 1), (1, 3), (3, 3), (0, 0), (0, 4), (4, 4)]);
    }
}
