//! Assigns the vertices of a lattice with broken joints to blocks of 2 × 2 × 2 vertices.
//!
//! In a lattice without broken joints, the grid index of a vertex determines its block. Where a vertex has copies, a
//! place in the grid has several blocks. The sums over windows read one next and one previous block along each axis, so
//! a block must have all links of a side to one other block. At the front of a crack, where the two sides meet, no
//! assignment has all links; links that an assignment does not have are removed from the lattice. Each vertex keeps
//! links to its side of the crack.

use std::collections::BTreeSet;

use super::blocks::{BlockKey, key_and_lane};
use crate::mesh::{UnionFind, distinct};
use crate::voxel::beside;

/// Marks a missing neighbor.
pub(super) const NO_NEIGHBOR: u32 = u32::MAX;

/// The blocks of a lattice with broken joints.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Chart {
    /// The offset of the blocks: see `layout`.
    pub(super) offset: [i32; 3],
    /// Number of the block of each vertex among the blocks with the same place in the grid.
    pub(super) sheets: Vec<u32>,
}

impl Chart {
    /// Assigns the vertices to blocks. Returns the chart and the links that it has.
    ///
    /// * `indices`: grid indices of the vertices.
    /// * `offset`: the offset of the blocks.
    /// * `split`: the vertices that have copies or could have them.
    /// * `neighbors`: neighbors of each vertex.
    pub(super) fn new(
        indices: &[[i32; 3]],
        offset: [i32; 3],
        split: &[u32],
        mut neighbors: Vec<[u32; 6]>,
    ) -> (Self, Vec<[u32; 6]>) {
        let places: Vec<(BlockKey, usize)> =
            indices.iter().map(|&index| key_and_lane(offset, index)).collect();
        let is_divided = divided(&places, split);
        let blocks = sheets(&places, &is_divided, &mut neighbors);
        drop_ambiguous(&places, (&is_divided, &blocks), &mut neighbors);
        (Self { offset, sheets: blocks }, neighbors)
    }

    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.sheets)
    }
}

/// Returns, for each vertex, whether its place in the grid can have several blocks: places of split vertices, and the
/// places beside them.
fn divided(places: &[(BlockKey, usize)], split: &[u32]) -> Vec<bool> {
    let keys = distinct(split.iter().flat_map(|&vertex| {
        let key = places[vertex as usize].0;
        (0..6).map(move |side| beside(key, side)).chain([key])
    }));
    places.iter().map(|(key, _)| keys.binary_search(key).is_ok()).collect()
}

/// Divides the vertices of each divided place into blocks: connected by links within the place, each lane once. Links
/// within a place that would connect two vertices of one lane are removed.
fn sheets(places: &[(BlockKey, usize)], is_divided: &[bool], neighbors: &mut [[u32; 6]]) -> Vec<u32> {
    let mut sets = UnionFind::new(places.len());
    let mut lanes: Vec<u8> = places.iter().map(|(_, lane)| 1 << lane).collect();
    for vertex in (0..places.len()).filter(|&vertex| is_divided[vertex]) {
        for side in [1, 3, 5] {
            let other = neighbors[vertex][side];
            if other == NO_NEIGHBOR || places[other as usize].0 != places[vertex].0 {
                continue;
            }
            let (a, b) = (sets.find(vertex as u32), sets.find(other));
            if a == b {
                continue;
            }
            if lanes[a as usize] & lanes[b as usize] != 0 {
                unlink(neighbors, vertex, side);
                continue;
            }
            let united = lanes[a as usize] | lanes[b as usize];
            sets.unite(a, b);
            lanes[sets.find(a) as usize] = united;
        }
    }
    let vertices = (0..places.len() as u32).filter(|&vertex| is_divided[vertex as usize]);
    let roots = distinct(vertices.map(|vertex| (places[vertex as usize].0, sets.find(vertex))));
    (0..places.len() as u32)
        .map(|vertex| {
            if !is_divided[vertex as usize] {
                return 0;
            }
            let key = places[vertex as usize].0;
            let first = roots.partition_point(|(other, _)| *other < key);
            let root = sets.find(vertex);
            roots[first..]
                .iter()
                .take_while(|(other, _)| *other == key)
                .position(|(_, r)| *r == root)
                .unwrap_or(0) as u32
        })
        .collect()
}

/// Removes links between blocks so that each block has one next and one previous block along each axis at most. The
/// pair of blocks with the most links is kept.
fn drop_ambiguous(
    places: &[(BlockKey, usize)],
    (is_divided, sheets): (&[bool], &[u32]),
    neighbors: &mut [[u32; 6]],
) {
    let block = |vertex: usize| (places[vertex].0, sheets[vertex]);
    for side in [1, 3, 5] {
        let mut crossing: Vec<_> = (0..places.len())
            .filter(|&vertex| {
                let other = neighbors[vertex][side];
                other != NO_NEIGHBOR && (is_divided[vertex] || is_divided[other as usize])
            })
            .map(|vertex| (block(vertex), block(neighbors[vertex][side] as usize), vertex))
            .filter(|(from, to, _)| from.0 != to.0)
            .collect();
        crossing.sort_unstable();
        let mut pairs: Vec<&[_]> = crossing.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)).collect();
        // The sort is stable: of pairs with equally many links, the first one in order stays first.
        pairs.sort_by_key(|links| std::cmp::Reverse(links.len()));
        let (mut has_next, mut has_previous) = (BTreeSet::new(), BTreeSet::new());
        for links in pairs {
            let (from, to, _) = links[0];
            if !has_next.contains(&from) && !has_previous.contains(&to) {
                has_next.insert(from);
                has_previous.insert(to);
            } else {
                links.iter().for_each(|&(_, _, vertex)| unlink(neighbors, vertex, side));
            }
        }
    }
}

/// Removes the link of a vertex to its next vertex along an axis. `side`: 1, 3 or 5 for x, y or z.
fn unlink(neighbors: &mut [[u32; 6]], vertex: usize, side: usize) {
    let other = std::mem::replace(&mut neighbors[vertex][side], NO_NEIGHBOR);
    neighbors[other as usize][side - 1] = NO_NEIGHBOR;
}
