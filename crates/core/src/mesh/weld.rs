//! Welds vertices: vertices that differ by rounding only count as one vertex in topology and normals.

use nalgebra::Point3;

/// Greatest distance of welded vertices along an axis, in units in the last place of the greatest coordinate. Programs
/// that write a seam compute its two sides separately.
const UNITS: f64 = 4.0;

/// Greatest tolerance relative to the extent of the mesh, for a mesh that is far from the origin.
const GREATEST: f64 = 1e-6;

/// Edge of a cell of the hash table, in tolerances: few vertices are so near to a side of their cell that the next cell
/// must be searched as well.
const CELL: f64 = 64.0;

/// Marks an empty slot of the hash table.
const EMPTY: u32 = u32::MAX;

/// Returns the greatest distance of welded vertices along an axis: a few units in the last place of the greatest
/// coordinate, in `f32` if all coordinates are values of `f32`, else in `f64`. `extent`: longest side of the bounding
/// box.
pub(super) fn tolerance(vertices: &[Point3<f64>], extent: f64) -> f64 {
    let coordinates = || vertices.iter().flat_map(|vertex| vertex.coords.iter().copied());
    let farthest = coordinates().map(f64::abs).fold(0.0, f64::max);
    let unit = match coordinates().all(|x| f64::from(x as f32) == x) {
        true => f64::from(f32::EPSILON),
        false => f64::EPSILON,
    };
    (UNITS * unit * farthest).min(GREATEST * extent)
}

/// Returns, for each vertex, the first vertex that is within the tolerance along each axis, of those that are welded
/// with no vertex before them. `-0.0` equals `0.0`.
///
/// Uses a hash table of cells with open addressing. It takes linear time, and the result does not depend on the order
/// of the table. A table of our own is used because every mesh is welded: for 500,000 vertices at exactly equal
/// positions, sorting takes 4 times as long, `HashMap` 16 times as long, and `HashMap` with this hash function 6
/// times as long.
pub(super) fn weld(vertices: &[Point3<f64>], tolerance: f64) -> Vec<u32> {
    let mask = (2 * vertices.len()).next_power_of_two().max(2) - 1;
    let mut table = vec![EMPTY; mask + 1];
    let mut representative = Vec::with_capacity(vertices.len());
    // Below this tolerance cells would not be finite; then only equal positions are welded.
    let tolerance = if tolerance > 1e-290 { tolerance } else { 0.0 };
    let per_length = 1.0 / (CELL * tolerance);
    for (index, vertex) in vertices.iter().enumerate() {
        let scaled = vertex.coords * per_length;
        let cell = if tolerance > 0.0 { scaled.map(f64::floor) } else { vertex.coords };
        // The first vertex found in a cell, and the free slot after the vertices there.
        let search = |cell: [f64; 3]| {
            let mut slot = hash(cell) as usize & mask;
            let mut first = EMPTY;
            loop {
                let found = table[slot];
                if found == EMPTY {
                    return (first, slot);
                }
                let other = &vertices[found as usize];
                if other == vertex {
                    return (found, slot);
                }
                if (other - vertex).amax() <= tolerance {
                    first = first.min(found);
                }
                slot = (slot + 1) & mask;
            }
        };
        let (mut first, slot) = search(cell.into());
        let is_exact = first != EMPTY && vertices[first as usize] == *vertex;
        if !is_exact && tolerance > 0.0 {
            // Steps to the cells that the surroundings of the vertex overlap.
            let steps = (scaled - cell).map(|x| f64::from(x > 1.0 - 1.0 / CELL) - f64::from(x < 1.0 / CELL));
            for k in 1..8 {
                let step: [f64; 3] = std::array::from_fn(|a| if k >> a & 1 == 1 { steps[a] } else { 0.0 });
                if (0..3).all(|a| k >> a & 1 == 0 || steps[a] != 0.0) {
                    first = first.min(search(std::array::from_fn(|a| cell[a] + step[a])).0);
                }
            }
        }
        if first == EMPTY {
            table[slot] = index as u32;
            first = index as u32;
        }
        representative.push(first);
    }
    representative
}

/// Hashes a cell.
fn hash(cell: [f64; 3]) -> u64 {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    for coordinate in cell {
        // Adding 0.0 converts -0.0 to 0.0.
        state = (state ^ (coordinate + 0.0).to_bits()).wrapping_mul(0xff51_afd7_ed55_8ccd);
        state ^= state >> 32;
    }
    state
}

/// Returns whether a face has fewer than three distinct welded corners.
pub(super) fn is_degenerate(face: &[u32], weld: &[u32]) -> bool {
    let Some(&first) = face.first() else { return true };
    let first = weld[first as usize];
    let mut others = face.iter().map(|&corner| weld[corner as usize]).filter(|&corner| corner != first);
    let Some(second) = others.next() else { return true };
    others.all(|corner| corner == second)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weld_maps_equal_positions_to_the_first() {
        let p = |x: f64| Point3::new(x, 0.0, -0.0);
        let vertices = [p(1.0), p(0.0), p(-0.0), p(1.0), p(1.0 + f64::EPSILON), Point3::new(0.0, -0.0, 0.0)];
        assert_eq!(weld(&vertices, 0.0), [0, 1, 1, 0, 4, 1]);
        assert_eq!(weld(&vertices, tolerance(&vertices, 1.0)), [0, 1, 1, 0, 0, 1]);
        assert!(weld(&[], 0.0).is_empty());
    }

    #[test]
    fn weld_finds_vertices_within_the_tolerance_across_cells() {
        let tolerance = 1e-9;
        // Steps of a third of a cell, and beside each vertex one at 0.9 and one at 1.1 tolerances.
        let steps = || (0..60).map(|k| f64::from(k) * CELL * tolerance / 3.0);
        let vertices: Vec<_> = steps()
            .flat_map(|x| {
                [0.0, 0.9, -0.9, 1.1].map(|d| Point3::new(x + d * tolerance, 0.7 - x, -d * tolerance))
            })
            .collect();
        let expected: Vec<u32> = (0..60).flat_map(|k| [4 * k, 4 * k, 4 * k, 4 * k + 3]).collect();
        assert_eq!(weld(&vertices, tolerance), expected);
    }

    #[test]
    fn tolerance_follows_the_type_of_the_coordinates() {
        let p = |x: f64| [Point3::origin(), Point3::new(x, 0.0, 0.0)];
        assert_eq!(tolerance(&p(2.0), 2.0), 8.0 * f64::from(f32::EPSILON));
        assert_eq!(tolerance(&p(2.1), 2.1), 4.0 * 2.1 * f64::EPSILON);
        // Far from the origin, units in the last place are larger than the mesh.
        assert_eq!(tolerance(&[Point3::new(5_412_345.0, 0.0, 0.0)], 0.5), 0.5e-6);
    }
}
