//! Counts how often the mesh winds around corners of the grid.

use super::map::Map;
use super::planes::Cell;
use super::points::{on_line, winding};
use super::refine::Triangle;
use super::space::Point;

/// Crossings of the mesh with the lines of the grid along x through given corners.
pub(super) struct Windings {
    /// For each line, by y and z: the cell of each crossing, and +1 where the mesh ends, -1 where it begins.
    lines: Map<(i32, i32), Vec<(i32, i32)>>,
}

impl Windings {
    /// Finds the crossings on the lines through corners.
    pub(super) fn new(points: &[Point], triangles: &[Triangle], corners: impl Iterator<Item = Cell>) -> Self {
        let mut lines: Map<_, Vec<_>> = corners.map(|[_, y, z]| ((y, z), Vec::new())).collect();
        let (mut low, mut high) = ([i32::MAX; 2], [i32::MIN; 2]);
        for &(y, z) in lines.keys() {
            (low, high) = ([low[0].min(y), low[1].min(z)], [high[0].max(y), high[1].max(z)]);
        }
        for triangle in triangles {
            let corners = triangle.corners.map(|corner| &points[corner as usize]);
            let range = |a: usize| {
                let [p, q, r] = corners.map(|corner| corner.k[a]);
                (p.min(q).min(r) + 1).max(low[a - 1])..=p.max(q).max(r).min(high[a - 1])
            };
            for z in range(2) {
                for y in range(1) {
                    let Some(line) = lines.get_mut(&(y, z)) else { continue };
                    let numbered = [0, 1, 2].map(|c| (triangle.corners[c], corners[c]));
                    let sign = winding(numbered, 0, y, z);
                    if sign != 0 {
                        let (point, _) = on_line(corners, (1, y), (2, z));
                        line.push((point.k[0], sign));
                    }
                }
            }
        }
        Self { lines }
    }

    /// Returns the winding number of a corner: 1 inside a mesh whose faces are counter-clockwise seen from outside.
    pub(super) fn at(&self, [x, y, z]: Cell) -> i32 {
        let crossings = self.lines.get(&(y, z)).into_iter().flatten();
        crossings.filter(|&&(cell, _)| cell >= x).map(|(_, sign)| sign).sum()
    }
}
