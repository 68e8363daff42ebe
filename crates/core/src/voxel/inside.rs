//! Finds the cells inside a surface that is not closed.

use std::collections::HashSet;

use super::grid::{Grid, beside, step};
use super::grid_set::GridSet;
use crate::mesh::WindingTree;

/// Returns the cells whose centers the surface encloses, without the cells in `walls` and `enclosed`.
///
/// * `walls`: the cells that the surface enters. `faces`: for each axis, the cells with a part of the surface on the
///   face to the lower neighbor along the axis. A space that the surface encloses is beside one of them, because the
///   winding number is a harmonic function elsewhere; the search goes from there to the cells beside those found.
///
/// Returns a lower bound of the number of cells as an error if it exceeds `max`.
pub(super) fn inside(
    surface: &WindingTree,
    grid: &Grid,
    (walls, enclosed): (&GridSet, &GridSet),
    faces: [&GridSet; 3],
    max: u64,
) -> Result<Vec<[i32; 3]>, u64> {
    let neighbors = |cell: [i32; 3]| (0..6).map(move |side| beside(cell, side));
    let mut is_tested: HashSet<[i32; 3]> = HashSet::new();
    let mut found: Vec<[i32; 3]> = Vec::new();
    let mut test = |cell: [i32; 3], found: &mut Vec<[i32; 3]>| {
        let is_free = || walls.find(cell).is_none() && enclosed.find(cell).is_none();
        if grid.contains(cell)
            && is_free()
            && is_tested.insert(cell)
            && surface.encloses(&grid.center_of(cell))
        {
            found.push(cell);
        }
    };
    for cell in walls.positions().into_iter().flat_map(neighbors) {
        test(cell, &mut found);
    }
    for (axis, set) in faces.into_iter().enumerate() {
        for upper in set.positions() {
            test(upper, &mut found);
            test(step(upper, axis, -1), &mut found);
        }
    }
    let mut next = 0;
    while next < found.len() {
        if found.len() as u64 > max {
            return Err(found.len() as u64);
        }
        for cell in neighbors(found[next]) {
            test(cell, &mut found);
        }
        next += 1;
    }
    Ok(found)
}
