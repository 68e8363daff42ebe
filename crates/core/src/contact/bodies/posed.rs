//! The deformed lattice of a body at one time, and the cell and local coordinates of a point in it.

use nalgebra::Point3;

use super::bounds::Bounds;
use super::deformed_cell::{DeformedCell, Gradient, LinearMap, MARGIN};
use super::grid::Grid;
use super::surface::ContactSurface;
use crate::contact::memory::buffer_bytes;

/// A lattice at one time: the world positions of its vertices, and a grid of its deformed cells.
#[derive(Clone, Debug, Default)]
pub(super) struct PosedLattice {
    /// Position of each lattice vertex.
    positions: Vec<Point3<f64>>,
    /// For each vertex, the sides of the region on which it is outside: one bit for each of the six sides.
    sides: Vec<u8>,
    /// The cells that are near other bodies, in increasing order, and their boxes with a margin.
    pub(super) cells: Vec<(u32, Bounds)>,
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

    /// Returns the geometry of a cell of a lattice.
    fn cell(
        &mut self,
        lattice: &PosedLattice,
        surface: &ContactSurface,
        found: &Candidate,
    ) -> &(DeformedCell, LinearMap) {
        let place = &mut self.places[found.index as usize];
        if *place == 0 {
            let cell = lattice.deformed_cell(surface.corners[found.cell as usize]);
            self.cells.push((cell, LinearMap::new(&cell, found.continued_sides)));
            *place = self.cells.len() as u32;
        }
        &self.cells[*place as usize - 1]
    }
}

/// A cell whose box contains a point.
struct Candidate {
    /// Index in `PosedLattice::cells`.
    index: u32,
    cell: u32,
    /// Its sides in `ContactSurface::continued_sides`.
    continued_sides: u8,
}

/// A point in a cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Located {
    pub(super) cell: u32,
    pub(super) local: [f64; 3],
    pub(super) gradient: Gradient,
}

impl PosedLattice {
    /// Poses the lattice of a body with the given positions of its vertices, and prepares the search of points in
    /// `region`. Points within `thickness` of the cells can be found too. `cells`: those in which points are searched, in
    /// increasing order.
    pub(super) fn pose(
        &mut self,
        positions: impl Iterator<Item = Point3<f64>>,
        surface: &ContactSurface,
        (cell_size, thickness): (f64, f64),
        region: &Bounds,
        cells: impl Iterator<Item = u32>,
    ) {
        self.positions.clear();
        self.positions.extend(positions);
        let margin = MARGIN * cell_size + thickness;
        let region = region.enlarged(margin);
        self.sides.clear();
        self.sides.extend(self.positions.iter().map(|position| region.sides_of(position)));
        self.cells.clear();
        for cell in cells {
            let corners = &surface.corners[cell as usize];
            let continued_sides = surface.continued_sides_of(cell);
            if continued_sides != 0 {
                let bounds = continued(&self.at(*corners), continued_sides).enlarged(margin);
                if bounds.intersects(&region) {
                    self.cells.push((cell, bounds));
                }
                continue;
            }
            // A cell is outside the region if all its corners are outside on one side of it.
            let common = corners.iter().fold(u8::MAX, |common, &vertex| common & self.sides[vertex as usize]);
            if common == 0 {
                self.cells.push((cell, Bounds::of(self.at(*corners)).enlarged(margin)));
            }
        }
        self.all = self.cells.iter().fold(Bounds::EMPTY, |all, (_, bounds)| all.union(bounds));
        self.grid.fill(&self.cells, &region, cell_size + thickness);
    }

    /// Returns the positions of vertices.
    fn at(&self, vertices: [u32; 8]) -> [Point3<f64>; 8] {
        vertices.map(|vertex| self.positions[vertex as usize])
    }

    /// Returns the geometry of the cell with vertices at its corners.
    pub(super) fn deformed_cell(&self, corners: [u32; 8]) -> DeformedCell {
        DeformedCell::new(&self.at(corners))
    }

    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        let Self { positions, sides, cells, grid, .. } = self;
        buffer_bytes(positions) + buffer_bytes(sides) + buffer_bytes(cells) + grid.bytes()
    }

    /// Returns whether a box intersects the box of a cell that `accepts` takes, so that a point of it may be located.
    pub(super) fn is_near(&self, bounds: &Bounds, accepts: impl Fn(u32) -> bool) -> bool {
        self.all.intersects(bounds)
            && self.grid.any_within(bounds, |index| {
                let (cell, own) = &self.cells[index as usize];
                own.intersects(bounds) && accepts(*cell)
            })
    }

    /// Calls `visit` for the cells whose boxes intersect a box.
    pub(super) fn for_each_near(&self, bounds: &Bounds, mut visit: impl FnMut(u32)) {
        self.grid.any_within(bounds, |index| {
            let (cell, own) = &self.cells[index as usize];
            if own.intersects(bounds) {
                visit(*cell);
            }
            false
        });
    }

    /// Returns the cell that contains a point. If several do, because the lattice overlaps itself, it is the first one
    /// that `accepts` takes; one that contains it without being continued comes before others. Cells that are inside
    /// out contain no point.
    ///
    /// If no cell contains the point, and `is_thick`, it is the cell that is nearest within the thickness of
    /// [`pose`](Self::pose), and the local coordinates continue those of the cell linearly.
    ///
    /// `surface` is the one of `pose`, and `cache` belongs to this pose.
    pub(super) fn locate(
        &self,
        surface: &ContactSurface,
        point: &Point3<f64>,
        is_thick: bool,
        accepts: impl Fn(u32) -> bool,
        cache: &mut CellCache,
    ) -> Option<Located> {
        let mut locate_within = |is_continued: bool| {
            self.candidates(surface, point, &accepts).find_map(|found| {
                let continued_sides = if is_continued { found.continued_sides } else { 0 };
                if is_continued && continued_sides == 0 {
                    return None;
                }
                let (deformed, map) = cache.cell(self, surface, &found);
                let (local, gradient) = deformed.locate(point, map.local(point)?, continued_sides)?;
                Some(Located { cell: found.cell, local, gradient })
            })
        };
        let has_continued = !surface.continued_sides.is_empty();
        let inside = locate_within(false).or_else(|| has_continued.then(|| locate_within(true)).flatten());
        if inside.is_some() || !is_thick {
            return inside;
        }
        let mut nearest: Option<(f64, Located)> = None;
        for found in self.candidates(surface, point, &accepts) {
            let (deformed, _) = cache.cell(self, surface, &found);
            if let Some((distance, local, gradient)) = deformed.locate_outside(point)
                && nearest.is_none_or(|(least, _)| distance < least)
            {
                nearest = Some((distance, Located { cell: found.cell, local, gradient }));
            }
        }
        nearest.map(|(_, located)| located)
    }

    /// Returns the cells that `accepts` takes and whose boxes contain a point.
    fn candidates(
        &self,
        surface: &ContactSurface,
        point: &Point3<f64>,
        accepts: impl Fn(u32) -> bool,
    ) -> impl Iterator<Item = Candidate> {
        self.grid.at(point).filter_map(move |index| {
            let (cell, bounds) = self.cells[index as usize];
            let is_found = bounds.contains(point) && accepts(cell);
            is_found.then(|| Candidate { index, cell, continued_sides: surface.continued_sides_of(cell) })
        })
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
