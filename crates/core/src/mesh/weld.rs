//! Welding: vertices at exactly equal positions are one vertex to topology and normals.

use nalgebra::Point3;

const EMPTY: u32 = u32::MAX;

/// For each vertex the first vertex at exactly the same position (`-0.0` equals `0.0`).
///
/// A hash table with open addressing: linear time, and the answer does not depend on the table's order. By hand, since it is in the
/// way of every mesh: for 500,000 vertices sorting takes 4 times as long, `HashMap` 16 times, and 6 times with this hash.
pub(super) fn weld(vertices: &[Point3<f64>]) -> Vec<u32> {
    let mask = (2 * vertices.len()).next_power_of_two().max(2) - 1;
    let mut table = vec![EMPTY; mask + 1];
    let mut representative = Vec::with_capacity(vertices.len());
    for (index, vertex) in vertices.iter().enumerate() {
        let mut slot = hash(vertex) as usize & mask;
        loop {
            let found = table[slot];
            if found == EMPTY {
                table[slot] = index as u32;
                representative.push(index as u32);
                break;
            }
            // Comparison of floats, so that zeros of both signs are equal; NaN is refused before.
            if vertices[found as usize] == *vertex {
                representative.push(found);
                break;
            }
            slot = (slot + 1) & mask;
        }
    }
    representative
}

/// Mixes the bits of the three coordinates; equal positions have equal hashes.
fn hash(vertex: &Point3<f64>) -> u64 {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    for &coordinate in vertex.coords.iter() {
        // Adding zero turns -0.0 into 0.0.
        state = (state ^ (coordinate + 0.0).to_bits()).wrapping_mul(0xff51_afd7_ed55_8ccd);
        state ^= state >> 32;
    }
    state
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_of_equal_positions_represents_them() {
        let p = |x: f64| Point3::new(x, 0.0, -0.0);
        let vertices = [p(1.0), p(0.0), p(-0.0), p(1.0), p(1.0 + f64::EPSILON), Point3::new(0.0, -0.0, 0.0)];
        assert_eq!(weld(&vertices), [0, 1, 1, 0, 4, 1]);
        assert!(weld(&[]).is_empty());
    }
}
