//! The deformed lattice of a body at one time, and the cell and local coordinates of a point in it.

use nalgebra::Point3;

use super::bounds::Bounds;
use super::deformed_cell::{DeformedCell, Gradient, LinearMap, MARGIN};
use super::grid::Grid;
use crate::contact::memory::buffer_bytes;

/// A lattice at one time: the world positions of its vertices, and a grid of its deformed cells.
#[derive(Clone, Debug, Default)]
pub(super) struct PosedLattice {
    /// Position of each lattice vertex.
    positions: Vec<Point3<f64>>,
    /// For each vertex, the sides of the region on which it is outside: one bit for each of the six sides.
    sides: Vec<u8>,
    /// The cells that are near other bodies, in increasing order, and their boxes with a margin.
    cells: Vec<(u32, Bounds)>,
    /// The box of all of them.
    all: Bounds,
    grid: Grid,
}

/// The geometry of the cells in which a search looks for points. Each cell is computed once.
#[derive(Clone, Debug, Default)]
pub(super) struct CellCache {
    /// For each of `PosedLattice::cells`, 1 plus the index in `cells`, or 0.
    places: Vec<u32>,
    cells: Vec<(DeformedCell, LinearMap)>,
}

impl CellCache {
    /// Removes all cells, for a lattice that was posed again.
    pub(super) fn reset(&mut self, lattice: &PosedLattice) {
        self.cells.clear();
        self.places.clear();
        self.places.resize(lattice.cells.len(), 0);
    }

    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        buffer_bytes(&self.places) + buffer_bytes(&self.cells)
    }

    /// Returns the cell with the given index in `PosedLattice::cells` and the given corners.
    fn cell(
        &mut self,
        index: u32,
        corners: impl FnOnce() -> [Point3<f64>; 8],
        continued_sides: u8,
    ) -> &(DeformedCell, LinearMap) {
        let place = &mut self.places[index as usize];
        if *place == 0 {
            let cell = DeformedCell::new(&corners());
            self.cells.push((cell, LinearMap::new(&cell, continued_sides)));
            *place = self.cells.len() as u32;
        }
        &self.cells[*place as usize - 1]
    }
}

/// A point in a cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Located {
    pub(super) cell: u32,
    pub(super) local: [f64; 3],
    pub(super) gradient: Gradient,
}

impl PosedLattice {
    /// Poses a lattice with the given positions of its vertices, and prepares the search of points in `region`. `cells`
    /// has the vertices at the corners of each cell, and `continued_sides` the sides beyond which it is continued;
    /// empty if none is. Points within `thickness` of the cells can be found too.
    pub(super) fn pose(
        &mut self,
        positions: impl Iterator<Item = Point3<f64>>,
        (cells, continued_sides): (&[[u32; 8]], &[u8]),
        (cell_size, thickness): (f64, f64),
        region: &Bounds,
    ) {
        self.positions.clear();
        self.positions.extend(positions);
        let margin = MARGIN * cell_size + thickness;
        let region = region.enlarged(margin);
        self.sides.clear();
        self.sides.extend(self.positions.iter().map(|position| region.sides_of(position)));
        self.cells.clear();
        for (cell, corners) in (0..).zip(cells) {
            if let Some(&sides) = continued_sides.get(cell as usize).filter(|sides| **sides != 0) {
                let bounds = continued(&corners.map(|v| self.positions[v as usize]), sides).enlarged(margin);
                if bounds.intersects(&region) {
                    self.cells.push((cell, bounds));
                }
                continue;
            }
            // A cell is outside the region if all its corners are outside on one side of it.
            let common = corners.iter().fold(u8::MAX, |common, &vertex| common & self.sides[vertex as usize]);
            if common == 0 {
                let corners = corners.map(|v| self.positions[v as usize]);
                self.cells.push((cell, Bounds::of(corners).enlarged(margin)));
            }
        }
        self.all = self.cells.iter().fold(Bounds::EMPTY, |all, (_, bounds)| all.union(bounds));
        self.grid.fill(&self.cells, &region, cell_size + thickness);
    }

    /// Returns the positions of vertices.
    pub(super) fn at(&self, vertices: [u32; 8]) -> [Point3<f64>; 8] {
        vertices.map(|vertex| self.positions[vertex as usize])
    }

    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        let Self { positions, sides, cells, grid, .. } = self;
        buffer_bytes(positions) + buffer_bytes(sides) + buffer_bytes(cells) + grid.bytes()
    }

    /// Returns the cells that are near other bodies, in increasing order, and their boxes.
    pub(super) fn cells(&self) -> &[(u32, Bounds)] {
        &self.cells
    }

    /// Returns whether a box intersects the box of a cell that `accepts` takes, so that a point of it may be located.
    pub(super) fn is_near(&self, bounds: &Bounds, accepts: impl Fn(u32) -> bool) -> bool {
        self.all.intersects(bounds)
            && self.grid.bins(bounds).any(|bin| {
                self.grid.cells_of(bin).iter().any(|&index| {
                    let (cell, own) = &self.cells[index as usize];
                    accepts(*cell) && own.intersects(bounds)
                })
            })
    }

    /// Returns the cell that contains a point. If several do, because the lattice overlaps itself, it is the first one
    /// that `accepts` takes; one that contains it without being continued comes before others. Cells that are inside
    /// out contain no point. `corners` returns the corners of a cell, `continued_sides` is as in
    /// [`pose`](Self::pose), and `cache` belongs to this pose.
    pub(super) fn locate(
        &self,
        point: &Point3<f64>,
        corners: impl Fn(u32) -> [Point3<f64>; 8],
        continued_sides: &[u8],
        accepts: impl Fn(u32) -> bool,
        cache: &mut CellCache,
    ) -> Option<Located> {
        let mut locate_within = |is_continued: bool| {
            self.cells_at(point, continued_sides, &accepts).find_map(|(index, cell, continued_sides)| {
                if is_continued && continued_sides == 0 {
                    return None;
                }
                let (deformed, map) = cache.cell(index, || corners(cell), continued_sides);
                let start = map.local(point)?;
                let (local, gradient) =
                    deformed.locate(point, start, if is_continued { continued_sides } else { 0 })?;
                Some(Located { cell, local, gradient })
            })
        };
        locate_within(false).or_else(|| if continued_sides.is_empty() { None } else { locate_within(true) })
    }

    /// Returns the cells that `accepts` takes and whose boxes contain a point: index in the pose, cell, and the sides
    /// of the cell in `continued_sides`.
    fn cells_at<'a>(
        &'a self,
        point: &'a Point3<f64>,
        continued_sides: &'a [u8],
        accepts: &'a impl Fn(u32) -> bool,
    ) -> impl Iterator<Item = (u32, u32, u8)> + 'a {
        self.grid.bin(point).iter().filter_map(move |&index| {
            let (cell, bounds) = self.cells[index as usize];
            let continued = || continued_sides.get(cell as usize).copied().unwrap_or(0);
            (accepts(cell) && bounds.contains(point)).then(|| (index, cell, continued()))
        })
    }

    /// Returns the cell that is nearest to a point outside of all cells, and the local coordinates there, which
    /// continue those of the cell linearly. `None` if no cell is within the thickness of [`pose`](Self::pose). The
    /// other arguments are as in [`locate`](Self::locate).
    pub(super) fn locate_outside(
        &self,
        point: &Point3<f64>,
        corners: impl Fn(u32) -> [Point3<f64>; 8],
        continued_sides: &[u8],
        accepts: impl Fn(u32) -> bool,
        cache: &mut CellCache,
    ) -> Option<Located> {
        let mut nearest: Option<(f64, Located)> = None;
        for (index, cell, continued_sides) in self.cells_at(point, continued_sides, &accepts) {
            let (deformed, _) = cache.cell(index, || corners(cell), continued_sides);
            if let Some((distance, local, gradient)) = deformed.locate_outside(point)
                && nearest.is_none_or(|(least, _)| distance < least)
            {
                nearest = Some((distance, Located { cell, local, gradient }));
            }
        }
        nearest.map(|(_, located)| located)
    }
}

/// Returns the box of a cell that is continued beyond `continued_sides`: see [`DeformedCell::locate`].
fn continued(corners: &[Point3<f64>; 8], continued_sides: u8) -> Bounds {
    let beyond = (0..6).filter(|side| continued_sides >> side & 1 != 0).flat_map(|side| {
        let (bit, is_upper) = (1 << (side / 2), side % 2 == 1);
        let of_side = (0..8).filter(move |corner| (corner & bit != 0) == is_upper);
        of_side.map(move |corner| corners[corner] + (corners[corner] - corners[corner ^ bit]))
    });
    Bounds::of(corners.iter().copied().chain(beyond))
}
