//! From a surface to the cells that it passes through or encloses.
//!
//! The *trace* of the triangles is found first: the cells that they enter, and the faces of cells that they lie on. What no way from
//! outside leads to past this trace is the inside.

use nalgebra::Vector3;

use super::bitmap::Bitmap;
use super::fill::{self, Walls};
use super::grid::Grid;
use super::grid_set::GridSet;
use super::triangle_box::TriangleAxes;
use crate::mesh::{Mesh, signed_volume};

/// A relative volume below which a surface has no inside, so that its orientation says nothing.
const NO_VOLUME: f64 = 1e-9;

/// Bitmaps that voxelizing takes at most: cells entered, cells reached, and three for each axis with faces in grid planes.
const BITMAPS: f64 = 11.0;

/// Bytes of a row that waits for the flood.
const ROW_BYTES: f64 = 17.0;

/// Boxes of cells up to this number are tested cell by cell; larger ones are halved first.
const SMALL_BOX: i64 = 16;

/// The cells of a surface.
pub(crate) struct Voxels {
    /// The cells that the surface passes through, and those that it encloses.
    pub(crate) cells: GridSet,
    /// How many of them the surface passes through, or bounds by a face in a grid plane.
    pub(crate) surface_cells: usize,
}

/// Bytes that voxelizing takes in a grid of so many cells along each axis.
pub(crate) fn bytes(counts: [f64; 3]) -> f64 {
    BITMAPS * Bitmap::bytes(counts) + ROW_BYTES * Bitmap::row_count_of(counts)
}

/// The cells that a surface passes through or encloses.
pub(crate) fn voxelize(mesh: &Mesh, grid: &Grid) -> Voxels {
    let placed: Vec<[f64; 3]> = mesh.vertices().iter().map(|vertex| grid.place(vertex)).collect();
    let mut trace = Trace::new(grid.size);
    let mut traceless = Vec::new();
    for triangle in mesh.triangles() {
        let corners = triangle.map(|vertex| placed[vertex as usize]);
        if !trace.add(&corners) {
            traceless.extend(corners);
        }
    }
    let walls = [0, 1, 2].map(|a| trace.walls(a));
    let mut outside =
        fill::outside(&Walls { cells: &trace.entered, faces: walls.each_ref().map(Option::as_ref) });
    let flipped = trace.faces.iter().any(Option::is_some) && is_inside_out(mesh, &placed, grid);
    for cell in trace.cells_behind_faces(&outside, flipped) {
        trace.entered.set(cell);
    }
    let stray = |corner: &[f64; 3]| cell_of_stray(corner, &outside, &trace.entered);
    for cell in traceless.iter().filter_map(stray).collect::<Vec<_>>() {
        trace.entered.set(cell);
    }
    outside.remove(&trace.entered);
    Voxels { cells: outside.unset(), surface_cells: trace.entered.count() }
}

/// Whether the normals of a surface point inwards on the whole: its signed volume is negative.
fn is_inside_out(mesh: &Mesh, placed: &[[f64; 3]], grid: &Grid) -> bool {
    let center = Vector3::from(grid.size.map(|n| 0.5 * n as f64));
    let volume = signed_volume(mesh.triangles(), |vertex| Vector3::from(placed[vertex as usize]) - center);
    let box_volume: f64 = grid.size.iter().map(|n| *n as f64).product();
    volume < -NO_VOLUME * box_volume
}

/// The cell of a corner of a triangle that left no trace, unless an occupied cell has it.
fn cell_of_stray(corner: &[f64; 3], outside: &Bitmap, entered: &Bitmap) -> Option<[i32; 3]> {
    let upper = corner.map(|x| x.floor() as i32);
    let lower = corner.map(|x| x.ceil() as i32 - 1);
    let around = (0..8).map(|k| std::array::from_fn(|a| if k >> a & 1 == 0 { lower[a] } else { upper[a] }));
    let mut around = around.filter(|cell| outside.within(*cell));
    let first = around.next()?;
    let occupied = |cell: &[i32; 3]| entered.get(*cell) || !outside.get(*cell);
    let free = !occupied(&first) && !around.any(|cell| occupied(&cell));
    free.then_some(first)
}

/// What the triangles leave in the grid.
struct Trace {
    /// Cells whose inside some triangle enters.
    entered: Bitmap,
    /// For each axis, where a triangle lies in a grid plane across it.
    faces: [Option<Faces>; 3],
}

/// Faces of cells, across one axis, on which a triangle lies; each is kept with the upper of its two cells.
struct Faces {
    /// The normal of the triangle points up the axis.
    up: Bitmap,
    /// The normal of the triangle points down the axis.
    down: Bitmap,
}

impl Trace {
    fn new(size: [usize; 3]) -> Self {
        Self { entered: Bitmap::new(size), faces: [None, None, None] }
    }

    /// Adds a triangle; false if it enters no cell and lies in no single grid plane: it has no area, or too little.
    fn add(&mut self, corners: &[[f64; 3]; 3]) -> bool {
        let [a, b, c] = corners;
        // No coordinate is negative, so that whole numbers come from cutting off.
        let mut low: [i32; 3] = std::array::from_fn(|k| a[k].min(b[k]).min(c[k]) as i32);
        let mut high: [i32; 3] = std::array::from_fn(|k| {
            let highest = a[k].max(b[k]).max(c[k]);
            highest as i32 + i32::from(f64::from(highest as i32) < highest)
        });
        let mut flat = (0..3).filter(|&k| low[k] == high[k]);
        let Some(axis) = flat.next() else {
            return Boxes { corners, flat: None }.visit(low, high, &mut |cell| self.entered.set(cell));
        };
        if flat.next().is_some() {
            return false;
        }
        // A triangle in a plane overlaps the squares of the plane as it does boxes of two cells about the plane.
        low[axis] -= 1;
        high[axis] += 1;
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let area = (b[u] - a[u]) * (c[v] - a[v]) - (b[v] - a[v]) * (c[u] - a[u]);
        let size = self.entered.size();
        let faces =
            self.faces[axis].get_or_insert_with(|| Faces { up: Bitmap::new(size), down: Bitmap::new(size) });
        let side = if area < 0.0 { &mut faces.down } else { &mut faces.up };
        Boxes { corners, flat: Some(axis) }.visit(low, high, &mut |mut cell| {
            cell[axis] += 1;
            side.set(cell);
        })
    }

    /// All faces across an axis on which a triangle lies.
    fn walls(&self, axis: usize) -> Option<Bitmap> {
        let faces = self.faces[axis].as_ref()?;
        let mut walls = faces.up.clone();
        walls.insert(&faces.down);
        Some(walls)
    }

    /// The cells to which faces in grid planes belong: those on the inner side, by the flood; where both sides are open, by the
    /// normal, and for a sheet with two sides the lower one.
    fn cells_behind_faces(&self, outside: &Bitmap, flipped: bool) -> Vec<[i32; 3]> {
        let mut cells = Vec::new();
        for (axis, faces) in self.faces.iter().enumerate() {
            let Some(Faces { up, down }) = faces else { continue };
            let (front, back) = if flipped { (down, up) } else { (up, down) };
            let only_back = back.cells().filter(|cell| !front.get(*cell)).map(|cell| (cell, false));
            for (upper, faces_up) in front.cells().map(|cell| (cell, true)).chain(only_back) {
                let mut lower = upper;
                lower[axis] -= 1;
                let preferred = if faces_up { [lower, upper] } else { [upper, lower] };
                match (outside.get(upper), outside.get(lower)) {
                    (false, false) => {}
                    (false, true) => cells.push(upper),
                    (true, false) => cells.push(lower),
                    (true, true) => cells.extend(preferred.into_iter().find(|cell| outside.within(*cell))),
                }
            }
        }
        cells
    }
}

/// The boxes that a triangle enters: single cells, or, for a triangle in a plane across the axis `flat`, pairs of cells about it.
struct Boxes<'a> {
    corners: &'a [[f64; 3]; 3],
    flat: Option<usize>,
}

impl Boxes<'_> {
    /// Visits, by their lower cell, the boxes that the triangle enters between two corners of the grid, around its own extent; false
    /// if there are none.
    fn visit(&self, low: [i32; 3], high: [i32; 3], emit: &mut impl FnMut([i32; 3])) -> bool {
        if self.count(low, high) == 1 {
            // A triangle within one cell that lies in no plane of it enters it.
            emit(low);
            return true;
        }
        self.visit_part(&TriangleAxes::new(self.corners), low, high, emit)
    }

    fn extent(&self, low: [i32; 3], high: [i32; 3], axis: usize) -> i64 {
        if self.flat == Some(axis) { 1 } else { i64::from(high[axis] - low[axis]) }
    }

    fn count(&self, low: [i32; 3], high: [i32; 3]) -> i64 {
        (0..3).map(|axis| self.extent(low, high, axis)).fold(1, i64::saturating_mul)
    }

    fn visit_part(
        &self,
        axes: &TriangleAxes,
        low: [i32; 3],
        high: [i32; 3],
        emit: &mut impl FnMut([i32; 3]),
    ) -> bool {
        let count = self.count(low, high);
        if count > SMALL_BOX {
            if !axes.enter(low.map(f64::from), high.map(f64::from)) {
                return false;
            }
            let axis = (0..3).max_by_key(|&axis| self.extent(low, high, axis)).unwrap_or(0);
            let middle = low[axis] + (high[axis] - low[axis]) / 2;
            let (mut lower_high, mut upper_low) = (high, low);
            lower_high[axis] = middle;
            upper_low[axis] = middle;
            return self.visit_part(axes, low, lower_high, emit)
                | self.visit_part(axes, upper_low, high, emit);
        }
        let step: [i32; 3] = std::array::from_fn(|axis| if self.flat == Some(axis) { 2 } else { 1 });
        let mut entered = false;
        for z in (low[2]..high[2]).step_by(step[2] as usize) {
            for y in (low[1]..high[1]).step_by(step[1] as usize) {
                for x in (low[0]..high[0]).step_by(step[0] as usize) {
                    let end = [x + step[0], y + step[1], z + step[2]];
                    if axes.enter([x, y, z].map(f64::from), end.map(f64::from)) {
                        emit([x, y, z]);
                        entered = true;
                    }
                }
            }
        }
        entered
    }
}
