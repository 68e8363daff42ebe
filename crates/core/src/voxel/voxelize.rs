//! Finds the cells that a surface passes through or encloses.
//!
//! The *trace* of the triangles consists of the cells that they enter, and of the faces of cells on which
//! they lie. A flood fill from outside stops at the trace. The result is the cells that the flood fill does
//! not reach.

use nalgebra::Vector3;

use super::bitmap::Bitmap;
use super::boxes::Boxes;
use super::fill::{self, Walls};
use super::grid::Grid;
use super::grid_set::GridSet;
use crate::mesh::{Mesh, signed_volume};

/// Magnitude of the signed volume, as a fraction of the volume of the grid, below which a surface counts as
/// having no orientation.
const MIN_VOLUME: f64 = 1e-9;

/// Maximum number of bitmaps: entered cells, outside cells, and three bitmaps for the faces across each axis.
const BITMAPS: f64 = 11.0;

/// Bytes that the queue of the flood fill needs per row.
const ROW_BYTES: f64 = 17.0;

/// The result of [`voxelize`].
pub(crate) struct Voxels {
    /// The cells that the surface passes through or encloses.
    pub(crate) cells: GridSet,
    /// Number of cells that the surface passes through, or to which a face in a grid plane belongs.
    pub(crate) surface_cells: usize,
}

/// Returns the bytes that [`voxelize`] needs for a grid with `counts` cells along each axis.
pub(crate) fn bytes(counts: [f64; 3]) -> f64 {
    BITMAPS * Bitmap::bytes(counts) + ROW_BYTES * Bitmap::row_count_of(counts)
}

/// Finds the cells that a surface passes through or encloses.
pub(crate) fn voxelize(mesh: &Mesh, grid: &Grid) -> Voxels {
    let positions: Vec<[f64; 3]> = mesh.vertices().iter().map(|vertex| grid.cell_space(vertex)).collect();
    let mut trace = Trace::new(grid.size);
    let mut untraced = Vec::new();
    let mut previous = None;
    for triangle in mesh.triangles() {
        // A repeated triangle has the same trace.
        if previous.replace(triangle) == Some(triangle) {
            continue;
        }
        let corners = triangle.map(|vertex| positions[vertex as usize]);
        if !trace.add(&corners) {
            untraced.extend(corners);
        }
    }
    let walls = [0, 1, 2].map(|a| trace.walls(a));
    let mut outside =
        fill::outside(&Walls { cells: &trace.entered, faces: walls.each_ref().map(Option::as_ref) });
    let flipped = trace.faces.iter().any(Option::is_some) && is_inside_out(mesh, &positions, grid);
    for cell in trace.cells_behind_faces(&outside, flipped) {
        trace.entered.set(cell);
    }
    let free_cell = |corner: &[f64; 3]| free_cell_at(corner, &outside, &trace.entered);
    for cell in untraced.iter().filter_map(free_cell).collect::<Vec<_>>() {
        trace.entered.set(cell);
    }
    outside.remove(&trace.entered);
    Voxels { cells: outside.unset(), surface_cells: trace.entered.count() }
}

/// Returns whether the signed volume of a surface is negative, because its normals mostly point inwards.
///
/// `positions`: positions of the mesh vertices in cells.
fn is_inside_out(mesh: &Mesh, positions: &[[f64; 3]], grid: &Grid) -> bool {
    let center = Vector3::from(grid.size.map(|n| 0.5 * n as f64));
    let volume = signed_volume(mesh.triangles(), |vertex| Vector3::from(positions[vertex as usize]) - center);
    let box_volume: f64 = grid.size.iter().map(|n| *n as f64).product();
    volume < -MIN_VOLUME * box_volume
}

/// Returns a cell that contains `corner`, a corner of a triangle without a trace.
///
/// Returns `None` if an occupied cell contains the corner.
fn free_cell_at(corner: &[f64; 3], outside: &Bitmap, entered: &Bitmap) -> Option<[i32; 3]> {
    let upper = corner.map(|x| x.floor() as i32);
    let lower = corner.map(|x| x.ceil() as i32 - 1);
    let around = (0..8).map(|k| std::array::from_fn(|a| if k >> a & 1 == 0 { lower[a] } else { upper[a] }));
    let mut around = around.filter(|cell| outside.in_grid(*cell));
    let first = around.next()?;
    let occupied = |cell: &[i32; 3]| entered.get(*cell) || !outside.get(*cell);
    let free = !occupied(&first) && !around.any(|cell| occupied(&cell));
    free.then_some(first)
}

/// The cells and faces of the grid that the triangles occupy.
struct Trace {
    /// Cells whose interior a triangle enters.
    entered: Bitmap,
    /// Faces perpendicular to each axis. `None` if no triangle lies in a grid plane perpendicular to the
    /// axis.
    faces: [Option<Faces>; 3],
}

/// Faces of cells, perpendicular to one axis, on which a triangle lies. A face is stored with its upper cell:
/// of the two cells at the face, the one with the higher index along the axis.
struct Faces {
    /// Faces of triangles whose normal points up the axis.
    up: Bitmap,
    /// Faces of triangles whose normal points down the axis.
    down: Bitmap,
}

impl Trace {
    fn new(size: [usize; 3]) -> Self {
        Self { entered: Bitmap::new(size), faces: [None, None, None] }
    }

    /// Adds a triangle. Returns false if the triangle leaves no trace because its area is zero or too small.
    fn add(&mut self, corners: &[[f64; 3]; 3]) -> bool {
        let [a, b, c] = corners;
        // No coordinate is negative, so truncation is `floor`.
        let mut low: [i32; 3] = std::array::from_fn(|k| a[k].min(b[k]).min(c[k]) as i32);
        let mut high: [i32; 3] = std::array::from_fn(|k| {
            let highest = a[k].max(b[k]).max(c[k]);
            highest as i32 + i32::from(f64::from(highest as i32) < highest)
        });
        let mut flat = (0..3).filter(|&k| low[k] == high[k]);
        let Some(axis) = flat.next() else {
            return Boxes { corners, flat: None }.mark(low, high, &mut self.entered);
        };
        if flat.next().is_some() {
            return false;
        }
        // A triangle in a grid plane overlaps a face in the plane iff it enters the box of the two cells at
        // the face.
        low[axis] -= 1;
        high[axis] += 1;
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let area = (b[u] - a[u]) * (c[v] - a[v]) - (b[v] - a[v]) * (c[u] - a[u]);
        let size = self.entered.size();
        let faces =
            self.faces[axis].get_or_insert_with(|| Faces { up: Bitmap::new(size), down: Bitmap::new(size) });
        let side = if area < 0.0 { &mut faces.down } else { &mut faces.up };
        Boxes { corners, flat: Some(axis) }.mark(low, high, side)
    }

    /// Returns all faces perpendicular to an axis on which a triangle lies.
    fn walls(&self, axis: usize) -> Option<Bitmap> {
        let faces = self.faces[axis].as_ref()?;
        let mut walls = faces.up.clone();
        walls.insert(&faces.down);
        Some(walls)
    }

    /// Returns the cells to which the faces in the trace belong.
    ///
    /// A face lies between two cells. If only one of them is outside, the face belongs to the other cell. If
    /// both are outside, the face belongs to the cell behind the normal of the triangle (to the lower cell if
    /// triangles with both normals lie on the face). If neither is outside, no cell is returned for the face.
    /// `flipped`: whether the normals of the triangles point inwards.
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
                    (true, true) => cells.extend(preferred.into_iter().find(|cell| outside.in_grid(*cell))),
                }
            }
        }
        cells
    }
}
