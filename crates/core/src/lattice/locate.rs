//! The cell that holds a point.

use super::run_tree::RunTree;
use super::runs::Runs;

/// How far outside a cell, in cells, a point may lie and still count as in it: more than a surface was moved into grid planes.
const REACH: f64 = 2.0 * super::grid::FARTHEST_MOVE;

/// The cell of a set that holds a point, given in cells. A point between several cells goes to the one that begins there, or else
/// to the first that the set holds.
pub(crate) fn locate(cells: &Runs, point: [f64; 3]) -> Option<u32> {
    let middle = point.map(|x| x.floor());
    // On each axis the cell of the point, and the one beyond the face near which it lies.
    let beside: [f64; 3] = std::array::from_fn(|a| match point[a] - middle[a] {
        depth if depth <= REACH => middle[a] - 1.0,
        depth if depth >= 1.0 - REACH => middle[a] + 1.0,
        _ => middle[a],
    });
    let choices =
        (0..8).map(|k| std::array::from_fn(|a| if k >> a & 1 == 0 { middle[a] } else { beside[a] }));
    let mut last = None;
    for cell in choices {
        if last != Some(cell) {
            // Saturates: no cell has such an index.
            if let Some(cell) = cells.find(cell.map(|x| x as i32)) {
                return Some(cell);
            }
        }
        last = Some(cell);
    }
    None
}

/// The cell of a set that is nearest to a point, given in cells; the set is not empty.
pub(crate) fn nearest(cells: &Runs, tree: &RunTree, point: [f64; 3]) -> u32 {
    let found = tree.nearest(f64::INFINITY, |bounds| bounds.distance_squared(point), |_| false, |_| true);
    let Some((_, run)) = found else { return 0 };
    let span = cells.span(run as usize);
    let x = (point[0].floor() as i32).clamp(span.start, span.end - 1);
    cells.first(run as usize) + (x - span.start) as u32
}
