//! Chooses the links of a lattice with broken joints.

use super::Lattice;
use super::charts::NO_NEIGHBOR;
use crate::mesh::distinct;

/// A link that a vertex could have along an axis: the two vertices and the number of cells that have it as an edge.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Candidate {
    /// Counts down from the most cells, so that the first candidate in order is the one to keep.
    missing_cells: u8,
    lower: u32,
    upper: u32,
    axis: u8,
}

/// Finds the neighbors of each vertex. At the front of a crack, a vertex can have several neighbors along a link: the
/// one that shares the most cells is kept, and of several the one with the lowest number.
///
/// `before`: [`Lattice::neighbor_table`] of the whole lattice.
pub(super) fn links(
    (whole, before): (&Lattice, &[[u32; 6]]),
    corners: &[[u32; 8]],
    sources: &[u32],
    split: &[u32],
) -> Vec<[u32; 6]> {
    let count = whole.len() + sources.len();
    let mut is_split = vec![false; whole.len()];
    split.iter().for_each(|&vertex| is_split[vertex as usize] = true);
    let mut neighbors = vec![[NO_NEIGHBOR; 6]; count];
    for (vertex, others) in before.iter().enumerate().filter(|(vertex, _)| !is_split[*vertex]) {
        let kept = |other: u32| other as usize != vertex && !is_split[other as usize];
        neighbors[vertex] = others.map(|other| if kept(other) { other } else { NO_NEIGHBOR });
    }
    let cells_around = |&vertex: &u32| {
        (0..8).filter_map(move |octant| whole.cell_around(whole.indices[vertex as usize], octant))
    };
    let mut edges = Vec::new();
    for cell in distinct(split.iter().flat_map(cells_around)) {
        let corners = corners[cell as usize];
        let source = |vertex: u32| match (vertex as usize).checked_sub(whole.len()) {
            Some(copy) => sources[copy] as usize,
            None => vertex as usize,
        };
        for axis in 0..3 {
            for k in (0..8).filter(|k| k >> axis & 1 == 0) {
                let (lower, upper) = (corners[k], corners[k | 1 << axis]);
                if is_split[source(lower)] || is_split[source(upper)] {
                    edges.push((lower, upper, axis as u8));
                }
            }
        }
    }
    edges.sort_unstable();
    let mut candidates: Vec<Candidate> = edges
        .chunk_by(|a, b| a == b)
        .map(|equal| Candidate {
            missing_cells: u8::MAX - equal.len() as u8,
            lower: equal[0].0,
            upper: equal[0].1,
            axis: equal[0].2,
        })
        .collect();
    candidates.sort_unstable();
    for Candidate { lower, upper, axis, .. } in candidates {
        let side = 2 * usize::from(axis);
        if neighbors[lower as usize][side + 1] == NO_NEIGHBOR
            && neighbors[upper as usize][side] == NO_NEIGHBOR
        {
            neighbors[lower as usize][side + 1] = upper;
            neighbors[upper as usize][side] = lower;
        }
    }
    neighbors
}
