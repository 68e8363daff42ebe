//! Finds the boxes that a triangle enters, and adds them to a set.

use super::bricks::Bricks;
use super::grid::step;
use super::triangle_box::TriangleAxes;

/// A range with at most this number of boxes is tested box by box. A larger range is halved first.
const SMALL_RANGE: i64 = 16;

/// A range with at most this number of boxes is skipped if all its boxes are marked. In a larger range, the test
/// could take longer than the search that it saves.
const SKIPPED_RANGE: i64 = 4096;

/// A search for the boxes that a triangle enters.
///
/// A *box* is a single cell, or for a triangle in a grid plane the two cells on both sides of the plane.
pub(super) struct Boxes<'a> {
    pub(super) corners: &'a [[f64; 3]; 3],
    /// Axis to which the plane is perpendicular. `None` if the triangle does not lie in a grid plane.
    pub(super) flat: Option<usize>,
}

/// The boxes that all searches have marked, and the boxes that this search has found.
struct Marks<'a> {
    /// The marked boxes. A box of two cells is marked by its upper cell.
    marked: &'a mut Bricks,
    /// Whether the triangle enters a box. From then on, marked boxes are skipped: the search adds nothing there.
    entered: bool,
}

impl Boxes<'_> {
    /// Marks each box that the triangle enters. Returns whether it enters any box, marked before or not.
    ///
    /// `low..high` is the range of the cells that the bounding box of the triangle overlaps. The search ends when the
    /// set is too large.
    pub(super) fn mark(&self, low: [i32; 3], high: [i32; 3], marked: &mut Bricks) -> bool {
        if self.count(low, high) == 1 {
            // The bounding box of the triangle is within this one box, so the triangle enters the box.
            marked.insert(self.upper_cell(low));
            return true;
        }
        let mut marks = Marks { marked, entered: false };
        self.mark_recursively(&TriangleAxes::new(self.corners), low, high, &mut marks);
        marks.entered
    }

    /// Returns the upper cell of a box, given its lower cell.
    fn upper_cell(&self, cell: [i32; 3]) -> [i32; 3] {
        self.flat.map_or(cell, |axis| step(cell, axis, 1))
    }

    /// Returns the size of a box, in cells.
    fn step(&self) -> [i32; 3] {
        std::array::from_fn(|axis| if self.flat == Some(axis) { 2 } else { 1 })
    }

    /// Returns the number of boxes along an axis.
    fn extent(&self, low: [i32; 3], high: [i32; 3], axis: usize) -> i64 {
        if self.flat == Some(axis) { 1 } else { i64::from(high[axis] - low[axis]) }
    }

    /// Returns the number of boxes in `low..high`.
    fn count(&self, low: [i32; 3], high: [i32; 3]) -> i64 {
        (0..3).map(|axis| self.extent(low, high, axis)).fold(1, i64::saturating_mul)
    }

    /// Does the work of [`Boxes::mark`] by recursive halving of the range `low..high`.
    fn mark_recursively(&self, axes: &TriangleAxes, low: [i32; 3], high: [i32; 3], marks: &mut Marks<'_>) {
        let count = self.count(low, high);
        if count > SMALL_RANGE {
            if marks.marked.is_too_large() || !axes.enters(low.map(f64::from), high.map(f64::from)) {
                return;
            }
            if marks.entered
                && count <= SKIPPED_RANGE
                && marks.marked.contains_all(self.upper_cell(low), high)
            {
                return;
            }
            // A range inside a triangle in a grid plane needs no test of each box.
            if self.flat.is_some()
                && axes.enters_all(low.map(f64::from), high.map(f64::from), self.step().map(f64::from))
            {
                marks.marked.insert_all(self.upper_cell(low), high);
                marks.entered = true;
                return;
            }
            let axis = (0..3).max_by_key(|&axis| self.extent(low, high, axis)).unwrap_or(0);
            let middle = low[axis] + (high[axis] - low[axis]) / 2;
            let (mut lower_high, mut upper_low) = (high, low);
            lower_high[axis] = middle;
            upper_low[axis] = middle;
            self.mark_recursively(axes, low, lower_high, marks);
            self.mark_recursively(axes, upper_low, high, marks);
            return;
        }
        let step = self.step();
        for z in (low[2]..high[2]).step_by(step[2] as usize) {
            for y in (low[1]..high[1]).step_by(step[1] as usize) {
                for x in (low[0]..high[0]).step_by(step[0] as usize) {
                    let end = [x + step[0], y + step[1], z + step[2]];
                    let upper = self.upper_cell([x, y, z]);
                    let is_skipped = marks.entered && marks.marked.contains(upper);
                    if !is_skipped && axes.enters([x, y, z].map(f64::from), end.map(f64::from)) {
                        marks.marked.insert(upper);
                        marks.entered = true;
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::testing::Random;
    use crate::voxel::grid_set::GridSet;

    /// Size of the space around the triangles. A search of the whole grid has ranges above and below [`SKIPPED_RANGE`].
    const SIZE: [usize; 3] = [70, 40, 30];

    /// Marks a triangle as `voxelize` does. `flat` as in [`Boxes`].
    fn mark(corners: &[[f64; 3]; 3], flat: Option<usize>, marked: &mut Bricks) -> bool {
        let ends = |pick: fn(f64, f64) -> f64| -> [f64; 3] {
            std::array::from_fn(|a| corners.iter().map(|corner| corner[a]).reduce(pick).unwrap())
        };
        let mut low = ends(f64::min).map(|x| x.floor() as i32);
        let mut high = ends(f64::max).map(|x| x.ceil() as i32);
        if let Some(axis) = flat {
            (low[axis], high[axis]) = (low[axis] - 1, high[axis] + 1);
        }
        Boxes { corners, flat }.mark(low, high, marked)
    }

    #[test]
    fn triangles_on_marked_boxes_mark_and_return_the_same_as_alone() {
        let mut random = Random(1);
        for flat in [None, Some(0), Some(1), Some(2)] {
            let (mut shared, mut union) = (Bricks::new(u64::MAX), GridSet::default());
            for index in 0..400 {
                // Most triangles are large; some are small, thin, or degenerate to a line in a grid plane.
                let share = [1.0, 0.7, 0.1][index % 3];
                let mut corners: [[f64; 3]; 3] = std::array::from_fn(|_| {
                    std::array::from_fn(|a| SIZE[a] as f64 * (0.5 + share * (random.next() - 0.5)))
                });
                if index % 5 == 0 {
                    corners[2] = corners[1].map(|x| x.floor());
                    corners[1] = std::array::from_fn(|a| corners[0][a].floor() * 0.5 + corners[2][a] * 0.5);
                    corners[0] = corners[0].map(f64::floor);
                }
                if let Some(axis) = flat {
                    let plane = corners[0][axis].floor();
                    corners.iter_mut().for_each(|corner| corner[axis] = plane);
                }
                let mut alone = Bricks::new(u64::MAX);
                let entered = mark(&corners, flat, &mut alone);
                let alone = alone.into_set();
                assert_eq!(entered, alone.len() > 0, "{corners:?}");
                assert_eq!(mark(&corners, flat, &mut shared), entered, "{corners:?}");
                union = union.union(&alone);
                assert_eq!(shared.clone().into_set(), union, "{flat:?}, triangle {index}: {corners:?}");
            }
        }
    }
}
