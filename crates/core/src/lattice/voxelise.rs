//! From a surface to the cells that it passes through or encloses.

use nalgebra::{Point3, Vector3};

use super::bitmap::Bitmap;
use super::flood::{self, Walls};
use super::grid::Grid;
use super::runs::Runs;
use super::trace::Trace;

/// A relative volume below which a surface has no inside, so that its orientation says nothing.
const NO_VOLUME: f64 = 1e-9;

/// The cells of a surface.
pub(crate) struct Voxels {
    /// The cells that the surface passes through, and those that it encloses.
    pub(crate) cells: Runs,
    /// How many of them the surface passes through, or bounds by a face in a grid plane.
    pub(crate) surface_cells: usize,
}

/// The cells that a surface passes through or encloses.
pub(crate) fn voxelise(vertices: &[Point3<f64>], triangles: &[[u32; 3]], grid: &Grid) -> Voxels {
    let placed: Vec<[f64; 3]> = vertices.iter().map(|vertex| grid.place(vertex)).collect();
    let corners = |triangle: &[u32; 3]| triangle.map(|vertex| placed[vertex as usize]);
    let mut trace = Trace::new(grid.size);
    let mut traceless = Vec::new();
    for triangle in triangles {
        if !trace.add(&corners(triangle)) {
            traceless.push(corners(triangle));
        }
    }
    let walls = [0, 1, 2].map(|a| trace.walls(a));
    let mut outside =
        flood::outside(&Walls { cells: &trace.entered, faces: walls.each_ref().map(Option::as_ref) });
    let flipped = trace.faces.iter().any(Option::is_some) && is_inside_out(triangles, &corners, grid);
    for cell in trace.cells_behind_faces(&outside, flipped) {
        trace.entered.set(cell);
    }
    for cell in traceless
        .iter()
        .flatten()
        .filter_map(|corner| cell_of_stray(corner, &outside, &trace.entered))
        .collect::<Vec<_>>()
    {
        trace.entered.set(cell);
    }
    outside.remove(&trace.entered);
    Voxels { cells: outside.unset(), surface_cells: trace.entered.count() }
}

/// Whether the normals of a surface point inwards on the whole: its signed volume is negative.
fn is_inside_out(triangles: &[[u32; 3]], corners: &impl Fn(&[u32; 3]) -> [[f64; 3]; 3], grid: &Grid) -> bool {
    let centre = Vector3::from(grid.size.map(|n| 0.5 * n as f64));
    let six_volumes = triangles.iter().map(|triangle| {
        let [a, b, c] = corners(triangle).map(|corner| Vector3::from(corner) - centre);
        a.dot(&b.cross(&c))
    });
    let box_volume: f64 = grid.size.iter().map(|n| *n as f64).product();
    six_volumes.sum::<f64>() / 6.0 < -NO_VOLUME * box_volume
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
