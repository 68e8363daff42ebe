//! The cells of a body that a cell of it can touch: those of other parts, and of its own part all but its neighbors.

use crate::lattice::Lattice;

/// Greatest distance of cells of one body, in cells along an axis, that are connected and do not touch each other.
const NEIGHBORHOOD: i32 = 2;

/// For each cell with samples, the cells that are joined to it: itself, and those that at most [`NEIGHBORHOOD`] steps through
/// cells with common corners lead to. A bit for each place in the cube of 5 x 5 x 5 cells around it, x fastest.
#[derive(Debug)]
pub(super) struct JoinedCells(Vec<u128>);

impl JoinedCells {
    /// Finds the cells that are joined to `cells`.
    pub(super) fn new(lattice: &Lattice, cells: impl Iterator<Item = u32>) -> Self {
        Self(cells.map(|cell| joined(lattice, cell)).collect())
    }

    /// Returns those of the `index`-th cell.
    pub(super) fn of(&self, index: usize) -> u128 {
        self.0[index]
    }

    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.0)
    }
}

/// The cells of a body that a cell with samples can touch.
#[derive(Clone, Copy)]
pub(super) struct TouchableCells<'a> {
    pub(super) lattice: &'a Lattice,
    /// The part of each cell; empty if there is one part.
    pub(super) parts: &'a [u32],
    pub(super) cell: u32,
    /// The cells of its own part that it does not touch, as in [`JoinedCells`]; `None` for all.
    pub(super) joined: Option<u128>,
}

impl TouchableCells<'_> {
    /// Returns whether the cell can touch another one of the body.
    #[inline]
    pub(super) fn contains(&self, other: u32) -> bool {
        let Self { lattice, parts, cell, joined } = *self;
        let [a, b] = [cell, other].map(|cell| lattice.cells()[cell as usize]);
        let offset: [i32; 3] = std::array::from_fn(|axis| b[axis] - a[axis]);
        let is_far = offset.iter().any(|distance| distance.abs() > NEIGHBORHOOD);
        joined.is_some_and(|joined| is_far || joined >> place(offset) & 1 == 0)
            || are_of_two_parts(parts, [cell, other])
    }
}

/// Returns whether two cells are of different parts. `parts`: the part of each cell; empty if there is one part.
pub(super) fn are_of_two_parts(parts: &[u32], [a, b]: [u32; 2]) -> bool {
    parts.get(a as usize) != parts.get(b as usize)
}

/// Returns the bit of the place at an offset, of up to [`NEIGHBORHOOD`] cells.
fn place([x, y, z]: [i32; 3]) -> i32 {
    62 + x + 5 * y + 25 * z
}

/// Returns the cells that are joined to a cell.
fn joined(lattice: &Lattice, cell: u32) -> u128 {
    let cube = || (0..27).map(|k| [k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1]);
    let around = cube().fold(0_u128, |around, offset| around | 1 << place(offset));
    let index = lattice.cells()[cell as usize];
    let present =
        cube().filter(|offset| lattice.cell_at(std::array::from_fn(|a| index[a] + offset[a])).is_some());
    present.fold(0, |joined, offset| {
        let shift = place(offset) - place([0; 3]);
        joined | if shift < 0 { around >> -shift } else { around << shift }
    })
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;

    use super::super::surface::ContactSurface;
    use super::*;
    use crate::contact::sampler::RestSurface;
    use crate::mesh::testing::Random;

    /// Two plates with a gap of a cell that are joined at one end.
    #[test]
    fn cells_that_two_steps_join_do_not_touch() {
        let cells: Vec<_> = (0..6)
            .flat_map(|x| [0, 1, 2].map(|y| [x, y, 0]))
            .filter(|[x, y, _]| *x == 0 || *y != 1)
            .collect();
        let lattice = Lattice::from_cells(&cells, 1.0, Point3::origin(), false).unwrap();
        let surface = ContactSurface::new(RestSurface::of_lattice(&lattice)).unwrap();
        let touches = |a: [i32; 3], b: [i32; 3], with_itself: bool| {
            let [a, b] = [a, b].map(|index| lattice.cell_at(index).unwrap());
            let group = surface.cells.iter().position(|group| group.cell == a).unwrap();
            surface.touchable_cells(&lattice, with_itself, group).contains(b)
        };
        assert!(!touches([0, 0, 0], [0, 0, 0], true) && !touches([0, 0, 0], [0, 2, 0], true));
        // Over the joining cell with a common corner, and not beyond it.
        assert!(!touches([1, 0, 0], [1, 2, 0], true) && !touches([1, 2, 0], [1, 0, 0], true));
        assert!(touches([2, 0, 0], [2, 2, 0], true) && touches([2, 0, 0], [1, 2, 0], true));
        // Along a plate.
        assert!(!touches([3, 0, 0], [1, 0, 0], true) && touches([3, 0, 0], [0, 0, 0], true));
        assert!(!touches([5, 0, 0], [5, 2, 0], false), "no part touches itself");
    }

    /// Whether two cells are the same or joined by at most two steps through cells with common corners, one by one.
    fn are_joined(lattice: &Lattice, [a, b]: [[i32; 3]; 2]) -> bool {
        let distance = |a: [i32; 3], b: [i32; 3]| (0..3).map(|axis| (a[axis] - b[axis]).abs()).max().unwrap();
        let steps = |c: [i32; 3]| distance(a, c) <= 1 && distance(c, b) <= 1;
        lattice.cells().iter().any(|&cell| steps(cell))
    }

    #[test]
    fn cells_touch_if_they_are_not_joined_in_any_shape() {
        let mut random = Random(3);
        for _ in 0..5 {
            let cells: Vec<_> =
                (0..6 * 6 * 6).map(|k| [k % 6, k / 6 % 6, k / 36]).filter(|_| random.next() < 0.4).collect();
            let lattice = Lattice::from_cells(&cells, 1.0, Point3::origin(), false).unwrap();
            let surface = ContactSurface::new(RestSurface::of_lattice(&lattice)).unwrap();
            for (group, sampled) in surface.cells.iter().enumerate() {
                let touchable = surface.touchable_cells(&lattice, true, group);
                for other in 0..lattice.cells().len() as u32 {
                    let indices = [sampled.cell, other].map(|cell| lattice.cells()[cell as usize]);
                    let touches =
                        !are_joined(&lattice, indices) || surface.are_of_two_parts([sampled.cell, other]);
                    assert_eq!(touchable.contains(other), touches, "{indices:?}");
                }
            }
        }
    }
}
