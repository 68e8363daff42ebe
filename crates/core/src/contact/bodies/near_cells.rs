//! The cells of a body that may touch other cells of the same body. Most cells have only their neighbors near, which they do
//! not touch. While the body deforms little, only the cells of a list are searched.

use super::posed::PosedLattice;
use super::surface::ContactSurface;
use crate::contact::memory::buffer_bytes;
use crate::lattice::Lattice;
use crate::simd::bounds::difference_bounds;
use crate::simd::lanes::Lanes;

/// Distance in cells by which vertices may move, beside a common translation, until the cells are listed again. With a
/// greater one, lists are rarer and longer. At rest, cells that can touch are a cell apart or more: with less than half of
/// that, a body that is hardly deformed has an empty list.
const MOTION: f64 = 0.45;

/// Additional distance in cells in a list, for the rounding of displacements in f32: those of up to 10,000 cells have errors
/// below 1e-3.
const ROUNDING: f64 = 4e-3;

/// The cells of a body that may touch other cells of the body.
#[derive(Debug, Default)]
pub(crate) struct NearCells {
    /// The positions for which the cells were listed; no blocks before the first list.
    positions: Lanes<3>,
    /// Whether parts touch themselves, and the distance at which cells are near: those of the list.
    listed_for: (bool, f64),
    cells: Vec<u32>,
    /// Buffer: the lattice in these positions.
    posed: PosedLattice,
    /// Buffer: whether each cell of the lattice is in the list.
    is_near: Vec<bool>,
}

impl NearCells {
    /// Returns the cells in increasing order; `None` if all may touch.
    pub(super) fn list(&self) -> Option<&[u32]> {
        (!self.positions.blocks().is_empty()).then_some(&self.cells)
    }

    /// Lists the cells, unless the last list has all that may touch in the present positions. There is no list for a body with
    /// cracks: some of their smooth surfaces lies outside of its cells.
    ///
    /// * `thickness`: of the body, in scene units. `with_itself`: whether a part of it touches itself.
    /// * `positions`, `occupied`: in cells, and the bit mask of the lanes with a vertex, for each block.
    /// * `pose`: poses the lattice, and enlarges the boxes of its cells by a distance.
    pub(super) fn update(
        &mut self,
        (surface, lattice): (&ContactSurface, &Lattice),
        (thickness, with_itself): (f64, bool),
        (positions, occupied): (&Lanes<3>, &[u8]),
        pose: impl FnOnce(&mut PosedLattice, f64),
    ) {
        let reach = 2.0 * thickness + (MOTION + ROUNDING) * lattice.cell_size();
        let list_for = (with_itself, reach);
        if !surface.continued_sides.is_empty() {
            self.positions.clear();
        } else if list_for != self.listed_for || !self.is_valid_at(positions, occupied) {
            self.listed_for = list_for;
            self.positions.copy_from(positions);
            pose(&mut self.posed, reach);
            self.fill(surface, lattice, with_itself);
        }
    }

    /// Returns whether the list has all cells that may touch in other positions.
    fn is_valid_at(&self, positions: &Lanes<3>, occupied: &[u8]) -> bool {
        if self.positions.blocks().is_empty() {
            return false;
        }
        let (low, high) = difference_bounds(positions, &self.positions, occupied);
        // A vertex moves by at most half the diagonal of the box of all displacements, beside that of its center.
        let squares = (0..3).map(|a| (0.5 * f64::from(high[a] - low[a])).powi(2));
        squares.sum::<f64>() <= MOTION * MOTION
    }

    /// Fills the list with the cells that are near in the lattice of the buffer.
    fn fill(&mut self, surface: &ContactSurface, lattice: &Lattice, with_itself: bool) {
        let Self { cells, posed, is_near, .. } = self;
        is_near.clear();
        is_near.resize(lattice.cells().len(), false);
        for (index, group) in surface.cells.iter().enumerate() {
            let touchable = surface.touchable_cells(lattice, with_itself, index);
            let (_, bounds) = &posed.cells[group.cell as usize];
            posed.for_each_near(bounds, |found| {
                if touchable.contains(found) {
                    is_near[group.cell as usize] = true;
                    is_near[found as usize] = true;
                }
            });
        }
        cells.clear();
        cells.extend((0..).zip(&*is_near).filter(|(_, is_near)| **is_near).map(|(cell, _)| cell));
    }

    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        let Self { positions, cells, posed, is_near, .. } = self;
        positions.bytes() + buffer_bytes(cells) + posed.bytes() + buffer_bytes(is_near)
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Point3, Vector3};

    use super::super::bounds::Bounds;
    use super::super::contacts::TouchingBody;
    use super::*;
    use crate::Body;
    use crate::mesh::testing::Random;

    /// A horseshoe in the plane of x and y, whose arms are bent towards each other.
    fn bent_horseshoe(thickness: f64) -> Body {
        let in_shape = |[x, y, _]: &[i32; 3]| *x < 2 || *y < 2 || *y >= 6;
        let cells: Vec<_> = (0..10 * 8 * 2).map(|k| [k % 10, k / 10 % 8, k / 80]).filter(in_shape).collect();
        let lattice = Lattice::from_cells(&cells, 0.5, Point3::origin(), false).unwrap();
        let mut body = Body::from_lattice(lattice).thickness(thickness).build().unwrap();
        body.set_self_contact(true);
        body.update_body_contact(true);
        body.create_contact_surface();
        let bend = |p: Point3<f64>| Point3::new(p.x, p.y + 0.08 * (2.0 - p.y) * p.x.powi(2) / 2.0, p.z);
        body.set_positions(&body.positions().into_iter().map(bend).collect::<Vec<_>>()).unwrap();
        body
    }

    /// The cells that are nearer than the thickness of two surfaces to cells that they touch.
    fn intersecting(body: &Body) -> Vec<u32> {
        let view = body.contact_view().unwrap();
        let surface = view.contact.surface();
        let thickness = view.properties.thickness;
        let corners = |cell: u32| view.corners(cell).map(|vertex| view.position(vertex));
        let bounds = |cell: u32| Bounds::of(corners(cell)).enlarged(thickness);
        let groups = surface.cells.iter().enumerate();
        let near = groups.flat_map(|(index, group)| {
            let touchable = surface.touchable_cells(view.lattice, true, index);
            let own = bounds(group.cell);
            let all = 0..surface.corners.len() as u32;
            let others = all.filter(|&b| touchable.contains(b) && own.intersects(&bounds(b)));
            others.flat_map(|other| [group.cell, other]).collect::<Vec<_>>()
        });
        near.collect()
    }

    fn list(body: &mut Body) -> Vec<u32> {
        body.list_near_cells();
        body.contact_view().unwrap().contact.near_cells.list().unwrap().to_vec()
    }

    #[test]
    fn the_list_has_all_cells_that_come_near_while_the_body_deforms_little() {
        for thickness in [0.0, 0.06] {
            let mut body = bent_horseshoe(thickness);
            let (first, start) = (list(&mut body), body.positions());
            let all = body.lattice().cells().len();
            assert!(!first.is_empty() && first.len() < 2 * all / 3, "{} of {all} cells", first.len());
            let mut random = Random(11);
            let mut counts = [Vec::new(), Vec::new()];
            for k in 0..40 {
                // By up to 0.44 cells, with the arms towards each other and away, and anywhere.
                let towards = if k % 2 == 0 { 0.21 } else { -0.21 };
                let common = Vector3::new(3.0, -2.0, 1.0) * f64::from(k);
                let moved = start.iter().map(|p| {
                    let noise = Vector3::from([(); 3].map(|()| 0.02 * (random.next() - 0.5)));
                    let arm = if p.y > 2.0 { -1.0 } else { 1.0 };
                    p + common + noise + Vector3::new(0.0, arm * towards, 0.0)
                });
                body.set_positions(&moved.collect::<Vec<_>>()).unwrap();
                assert_eq!(list(&mut body), first, "the list is made again");
                let near = intersecting(&body);
                counts[k as usize % 2].push(near.len());
                assert!(near.iter().all(|cell| first.binary_search(cell).is_ok()), "{near:?} {first:?}");
            }
            let [towards, away] = counts;
            assert!(towards.iter().min() > away.iter().max(), "{towards:?} cells are near, or {away:?}");
        }
    }

    #[test]
    fn the_list_of_a_body_at_rest_is_empty_and_follows_whether_a_part_touches_itself() {
        let mut body = bent_horseshoe(0.0);
        assert!(!list(&mut body).is_empty());
        body.set_self_contact(false);
        assert_eq!(list(&mut body), []);
        body.set_self_contact(true);
        assert!(!list(&mut body).is_empty());
        let lattice = body.lattice();
        let rest = (0..lattice.len() as u32).map(|vertex| lattice.rest_position(vertex));
        body.set_positions(&rest.collect::<Vec<_>>()).unwrap();
        assert_eq!(list(&mut body), []);
    }
}
