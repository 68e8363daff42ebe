//! Finds the cells that a surface passes through or encloses.
//!
//! The *trace* of the triangles consists of the cells that they enter, and of the faces of cells on which
//! they lie. The result is the cells of the trace, the cells that it encloses, the cells inside a surface with
//! openings, and the cells to which its faces belong.

use nalgebra::Vector3;

use super::boxes::Boxes;
use super::bricks::Bricks;
use super::fill::{self, Walls};
use super::grid::{Grid, step};
use super::grid_set::GridSet;
use super::inside::inside;
use crate::mesh::{Mesh, signed_volume};

/// Magnitude of the signed volume, as a fraction of the volume of the grid, below which a surface counts as
/// having no orientation.
const MIN_VOLUME: f64 = 1e-9;

/// The result of [`voxelize`].
pub(crate) struct Voxels {
    /// The cells that the surface passes through or encloses.
    pub cells: GridSet,
    /// Number of cells that the surface passes through, or to which a face in a grid plane belongs.
    pub surface_cells: usize,
}

/// Largest numbers of cells and faces that [`voxelize`] accepts.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Maxima {
    /// Number of cells of the result, at most 2^31.
    pub cells: u64,
    /// Number of faces in grid planes on which a triangle lies, at most 2^31. Counts faces of opposite orientation in
    /// the same place as two.
    pub faces: u64,
}

/// A number exceeds its maximum. Contains a lower bound of the number.
#[derive(Debug, PartialEq)]
pub(crate) enum TooMany {
    Cells(u64),
    Faces(u64),
}

/// Finds the cells that a surface passes through or encloses.
///
/// Time and memory are proportional to the trace of the triangles and the number of runs of the result. They do not
/// depend on the extent of the grid.
///
/// # Errors
///
/// If there are more cells or faces than the maxima allow.
pub(crate) fn voxelize(mesh: &Mesh, grid: &Grid, maxima: Maxima) -> Result<Voxels, TooMany> {
    let positions: Vec<[f64; 3]> = mesh.vertices().iter().map(|vertex| grid.cell_space(vertex)).collect();
    let mut builder = TraceBuilder::new(maxima);
    let mut untraced = Vec::new();
    let mut previous = None;
    for triangle in mesh.triangles() {
        // A repeated triangle has the same trace.
        if previous.replace(triangle) == Some(triangle) {
            continue;
        }
        let corners = triangle.map(|vertex| positions[vertex as usize]);
        if !builder.add(&corners)? {
            untraced.extend(corners);
        }
    }
    let Trace { entered, faces } = builder.into_trace();
    let faces_of_axes = faces.each_ref().map(|Faces { up, down }| up.union(down));
    let walls = Walls { cells: &entered, faces: faces_of_axes.each_ref() };
    let enclosed = fill::enclosed(&walls, maxima.cells).map_err(TooMany::Cells)?;
    let enclosed = match mesh.open_surface().and_then(|open| open.solid.as_ref()) {
        None => enclosed,
        Some(solid) => {
            let inside = inside(solid, grid, (&entered, &enclosed), walls.faces, maxima.cells);
            enclosed.with(inside.map_err(TooMany::Cells)?)
        }
    };
    let flipped = faces.iter().any(|faces| !faces.is_empty()) && is_inside_out(mesh, &positions, grid);
    let is_outside = |cell: [i32; 3]| entered.find(cell).is_none() && enclosed.find(cell).is_none();
    let behind_faces = cells_behind_faces(&faces, is_outside, flipped, grid);
    let surface = entered.with(behind_faces);
    let cells = surface.union(&enclosed);
    let free_cell = |corner: &[f64; 3]| free_cell_at(corner, &cells, grid);
    let free_cells: Vec<_> = untraced.iter().filter_map(free_cell).collect();
    let (surface, cells) = (surface.with(free_cells.clone()), cells.with(free_cells));
    check(cells.len() as u64, maxima.cells).map_err(TooMany::Cells)?;
    Ok(Voxels { surface_cells: surface.len(), cells })
}

/// Returns the cells that triangles enter. `triangles`: the corners of each triangle in cells; no coordinate is
/// negative.
pub(crate) fn entered_cells(triangles: impl Iterator<Item = [[f64; 3]; 3]>) -> GridSet {
    let mut builder = TraceBuilder::new(Maxima { cells: u64::MAX, faces: u64::MAX });
    for corners in triangles {
        // Without maxima there is no error.
        _ = builder.add(&corners);
    }
    builder.into_trace().entered
}

/// Returns the number as an error if it exceeds its maximum.
fn check(number: u64, max: u64) -> Result<(), u64> {
    if number <= max { Ok(()) } else { Err(number) }
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
fn free_cell_at(corner: &[f64; 3], occupied: &GridSet, grid: &Grid) -> Option<[i32; 3]> {
    let upper = corner.map(|x| x.floor() as i32);
    let lower = corner.map(|x| x.ceil() as i32 - 1);
    let around = (0..8).map(|k| std::array::from_fn(|a| if k >> a & 1 == 0 { lower[a] } else { upper[a] }));
    let mut around = around.filter(|cell| grid.contains(*cell));
    let first = around.next()?;
    let is_occupied = |cell| occupied.find(cell).is_some();
    let free = !is_occupied(first) && !around.any(is_occupied);
    free.then_some(first)
}

/// The cells and faces of the grid that the triangles occupy.
struct Trace {
    /// Cells whose interior a triangle enters.
    entered: GridSet,
    /// Faces perpendicular to each axis.
    faces: [Faces<GridSet>; 3],
}

/// Faces of cells, perpendicular to one axis, on which a triangle lies. A face is stored with its upper cell:
/// of the two cells at the face, the one with the higher index along the axis.
struct Faces<Set> {
    /// Faces of triangles whose normal points up the axis.
    up: Set,
    /// Faces of triangles whose normal points down the axis.
    down: Set,
}

impl Faces<GridSet> {
    fn is_empty(&self) -> bool {
        self.up.len() + self.down.len() == 0
    }
}

/// Builds a [`Trace`].
struct TraceBuilder {
    entered: Bricks,
    faces: [Faces<Bricks>; 3],
    maxima: Maxima,
}

impl TraceBuilder {
    fn new(maxima: Maxima) -> Self {
        let faces = || Bricks::new(maxima.faces);
        let faces = [0, 1, 2].map(|_| Faces { up: faces(), down: faces() });
        Self { entered: Bricks::new(maxima.cells), faces, maxima }
    }

    /// Adds a triangle. Returns false if the triangle leaves no trace because its area is zero or too small.
    fn add(&mut self, corners: &[[f64; 3]; 3]) -> Result<bool, TooMany> {
        let [a, b, c] = corners;
        // No coordinate is negative, so truncation is `floor`.
        let mut low: [i32; 3] = std::array::from_fn(|k| a[k].min(b[k]).min(c[k]) as i32);
        let mut high: [i32; 3] = std::array::from_fn(|k| {
            let highest = a[k].max(b[k]).max(c[k]);
            highest as i32 + i32::from(f64::from(highest as i32) < highest)
        });
        let mut flat = (0..3).filter(|&k| low[k] == high[k]);
        let Some(axis) = flat.next() else {
            let is_traced = Boxes { corners, flat: None }.mark(low, high, &mut self.entered);
            check(self.entered.len(), self.maxima.cells).map_err(TooMany::Cells)?;
            return Ok(is_traced);
        };
        if flat.next().is_some() {
            return Ok(false);
        }
        // A triangle in a grid plane overlaps a face in the plane iff it enters the box of the two cells at
        // the face.
        low[axis] -= 1;
        high[axis] += 1;
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let area = (b[u] - a[u]) * (c[v] - a[v]) - (b[v] - a[v]) * (c[u] - a[u]);
        let faces = &mut self.faces[axis];
        let side = if area < 0.0 { &mut faces.down } else { &mut faces.up };
        let is_traced = Boxes { corners, flat: Some(axis) }.mark(low, high, side);
        let number = self.faces.iter().map(|faces| faces.up.len() + faces.down.len()).sum();
        check(number, self.maxima.faces).map_err(TooMany::Faces)?;
        Ok(is_traced)
    }

    fn into_trace(self) -> Trace {
        let faces = self.faces.map(|Faces { up, down }| Faces { up: up.into_set(), down: down.into_set() });
        Trace { entered: self.entered.into_set(), faces }
    }
}

/// Returns the cells to which the faces in the trace belong.
///
/// A face lies between two cells. If only one of them is outside, the face belongs to the other cell. If
/// both are outside, the face belongs to the cell behind the normal of the triangle (to the lower cell if
/// triangles with both normals lie on the face). If neither is outside, no cell is returned for the face.
/// `flipped`: whether the normals of the triangles point inwards.
fn cells_behind_faces(
    faces: &[Faces<GridSet>; 3],
    is_outside: impl Fn([i32; 3]) -> bool,
    flipped: bool,
    grid: &Grid,
) -> Vec<[i32; 3]> {
    let mut cells = Vec::new();
    for (axis, Faces { up, down }) in faces.iter().enumerate() {
        let (front, back) = if flipped { (down, up) } else { (up, down) };
        let only_back = back.positions().into_iter().filter(|cell| front.find(*cell).is_none());
        let front = front.positions().into_iter().map(|cell| (cell, true));
        for (upper, faces_up) in front.chain(only_back.map(|cell| (cell, false))) {
            let lower = step(upper, axis, -1);
            let preferred = if faces_up { [lower, upper] } else { [upper, lower] };
            match (is_outside(upper), is_outside(lower)) {
                (false, false) => {}
                (false, true) => cells.push(upper),
                (true, false) => cells.push(lower),
                (true, true) => cells.extend(preferred.into_iter().find(|cell| grid.contains(*cell))),
            }
        }
    }
    cells
}
