//! Stores the one-rings of all vertices of a surface in blocks of eight, as offsets in a tile.
//!
//! A *tile* is a small buffer of rows, one row per position or normal. An *offset* addresses a row by 16
//! bits; see `simd::tile`. An *entry* is one vertex in a one-ring.

use std::collections::HashMap;
use std::ops::Range;

use super::one_ring::OneRings;
use crate::simd::tile::{ROWS, offset};

/// Number of vertices in a chunk, the unit of work of a thread. Large enough that most blocks get eight
/// one-rings of similar length.
pub(super) const CHUNK: usize = 512;

/// Row of the tile of normals that contains the zero normal, for vertices without triangles.
pub(super) const NO_NORMAL: usize = CHUNK;

/// Assigns vertices to the rows of a tile.
pub(super) trait TileLayout {
    /// Returns the row of each of `vertices`, which must be in ascending order.
    fn rows(&self, vertices: &[u32]) -> Vec<usize>;

    /// Appends the tile of the next chunk, with the given vertices.
    fn add(&mut self, vertices: &[u32]);
}

/// The one-rings of all vertices, chunk by chunk.
///
/// A chunk is evaluated with two tiles. The first tile has the positions of the welded vertices of the chunk
/// and of their neighbors. The normals of the chunk are written to the second tile, block by block.
#[derive(Clone, Debug, Default)]
pub(super) struct OneRingBlocks {
    blocks: Vec<Block>,
    /// Pairs of entries, block by block. A pair has two entries for each of the eight one-rings of a block.
    pairs: Vec<[[u16; 8]; 2]>,
    /// End of each chunk in `blocks`.
    ends: Vec<usize>,
    /// Tile offsets of each vertex.
    offsets: Vec<TileOffsets>,
    /// The vertices whose one-rings do not fit in a tile.
    pub(super) oversized: Vec<OversizedRing>,
}

/// Offsets of a vertex in the tile of positions and in the tile of normals.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct TileOffsets {
    pub(super) position: u16,
    pub(super) normal: u16,
}

/// Eight one-rings, one per lane, as offsets in the tile of positions.
#[derive(Clone, Debug)]
struct Block {
    /// The vertex that each one-ring surrounds.
    centers: [u16; 8],
    /// First entry of each one-ring.
    first: [u16; 8],
    /// Index in `pairs` of the block's first pair of entries.
    pairs: u32,
}

/// A vertex whose one-ring does not fit in the tile of its chunk.
#[derive(Clone, Debug)]
pub(super) struct OversizedRing {
    pub(super) vertex: u32,
    /// The vertex to which it is welded.
    pub(super) center: u32,
    /// One-ring of `center`.
    pub(super) ring: Vec<u32>,
}

/// Eight vertices and their one-rings, as offsets in the tile of positions.
///
/// All one-rings of a block have the same length: one entry, then pairs of entries. Shorter one-rings are
/// padded with the vertex that they surround, which adds zero to the normal.
pub(super) struct OneRingBlock<'a> {
    pub(super) centers: &'a [u16; 8],
    pub(super) first: &'a [u16; 8],
    pub(super) pairs: &'a [[[u16; 8]; 2]],
}

impl OneRingBlocks {
    /// Builds the one-rings of all vertices.
    ///
    /// `weld`: for each vertex, the vertex to which it is welded. `layout`: assigns the rows of the tiles.
    pub(super) fn new(triangles: &[[u32; 3]], weld: &[u32], layout: &mut impl TileLayout) -> Self {
        let welded = triangles.iter().map(|triangle| triangle.map(|corner| weld[corner as usize]));
        let mut one_rings = OneRings::new(welded, weld.len());
        let mut this = Self { offsets: Vec::with_capacity(weld.len()), ..Self::default() };
        for first in (0..weld.len()).step_by(CHUNK) {
            let range = first..weld.len().min(first + CHUNK);
            let mut chunk = Chunk::new(&mut one_rings, &weld[range.clone()]);
            let (vertices, rows) = loop {
                let vertices = chunk.vertices();
                let rows = layout.rows(&vertices);
                if rows.iter().all(|&row| row < ROWS) {
                    break (vertices, rows);
                }
                let longest = chunk.take_longest();
                for (center, ring) in longest {
                    let around = range.clone().filter(|&vertex| weld[vertex] == center);
                    this.oversized.extend(around.map(|vertex| OversizedRing {
                        vertex: vertex as u32,
                        center,
                        ring: ring.clone(),
                    }));
                }
            };
            layout.add(&vertices);
            let row_of = |vertex: u32| rows[vertices.binary_search(&vertex).expect("each vertex has a row")];
            this.add(&chunk, &weld[range], |vertex| offset(row_of(vertex)));
        }
        this
    }

    /// Appends a chunk in blocks of eight one-rings, the shortest one-rings first.
    ///
    /// `weld`: for each vertex of the chunk, the vertex to which it is welded. `offset_of`: returns the
    /// offset of a welded vertex in the tile of positions.
    fn add(&mut self, chunk: &Chunk, weld: &[u32], offset_of: impl Fn(u32) -> u16) {
        for eight in chunk.rings.chunks(8) {
            // The last one-ring is repeated in the remaining lanes.
            let lane = |lane: usize| &eight[lane.min(eight.len() - 1)];
            let entry = |at: usize| {
                std::array::from_fn(|k| {
                    let (center, ring) = lane(k);
                    offset_of(*chunk.entries[ring.clone()].get(at).unwrap_or(center))
                })
            };
            let centers = std::array::from_fn(|k| offset_of(lane(k).0));
            self.blocks.push(Block { centers, first: entry(0), pairs: self.pairs.len() as u32 });
            let longest = lane(7).1.len();
            self.pairs.extend((1..longest).step_by(2).map(|at| [entry(at), entry(at + 1)]));
        }
        self.ends.push(self.blocks.len());
        let normals: HashMap<u32, usize> =
            (0..).zip(&chunk.rings).map(|(row, (vertex, _))| (*vertex, row)).collect();
        self.offsets.extend(weld.iter().map(|vertex| TileOffsets {
            position: offset_of(*vertex),
            normal: offset(normals.get(vertex).copied().unwrap_or(NO_NORMAL)),
        }));
    }

    /// Returns the number of vertices.
    pub(super) fn len(&self) -> usize {
        self.offsets.len()
    }

    /// Returns the blocks of a chunk.
    pub(super) fn blocks(&self, chunk: usize) -> Range<usize> {
        (if chunk == 0 { 0 } else { self.ends[chunk - 1] })..self.ends[chunk]
    }

    /// Returns the one-rings of a block.
    #[inline]
    pub(super) fn block(&self, block: usize) -> OneRingBlock<'_> {
        let end = self.blocks.get(block + 1).map_or(self.pairs.len(), |next| next.pairs as usize);
        let Block { centers, first, pairs } = &self.blocks[block];
        OneRingBlock { centers, first, pairs: &self.pairs[*pairs as usize..end] }
    }

    /// Returns the tile offsets of the vertices of a chunk.
    pub(super) fn offsets(&self, chunk: usize) -> &[TileOffsets] {
        &self.offsets[chunk * CHUNK..self.offsets.len().min((chunk + 1) * CHUNK)]
    }

    /// Returns the memory of the tables, in bytes.
    pub(super) fn bytes(&self) -> usize {
        let Self { blocks, pairs, ends, offsets, oversized } = self;
        let ring = |oversized: &OversizedRing| size_of::<OversizedRing>() + size_of_val(&*oversized.ring);
        let tables = size_of_val(&**ends) + size_of_val(&**offsets);
        tables + size_of_val(&**blocks) + size_of_val(&**pairs) + oversized.iter().map(ring).sum::<usize>()
    }
}

impl OneRingBlock<'_> {
    /// Iterates over the entries of the one-ring in a lane.
    pub(super) fn ring(&self, lane: usize) -> impl Iterator<Item = u16> {
        std::iter::once(self.first[lane]).chain(self.pairs.iter().flatten().map(move |entry| entry[lane]))
    }
}

/// The one-rings of a chunk during construction.
struct Chunk {
    /// The welded vertices of the chunk, in ascending order.
    welded: Vec<u32>,
    /// Vertices with a one-ring, and the range of the one-ring in `entries`. The shortest one-ring comes
    /// first.
    rings: Vec<(u32, Range<usize>)>,
    entries: Vec<u32>,
}

impl Chunk {
    /// Builds the one-rings of a chunk. `welded`: for each vertex of the chunk, the vertex to which it is
    /// welded.
    fn new(one_rings: &mut OneRings, welded: &[u32]) -> Self {
        let mut welded = welded.to_vec();
        welded.sort_unstable();
        welded.dedup();
        let (mut rings, mut entries) = (Vec::new(), Vec::new());
        for &vertex in &welded {
            let begin = entries.len();
            one_rings.append(vertex, &mut entries);
            if entries.len() > begin {
                rings.push((vertex, begin..entries.len()));
            }
        }
        rings.sort_by_key(|(_, ring)| ring.len());
        Self { welded, rings, entries }
    }

    /// Returns the welded vertices of the chunk and the vertices of the one-rings, in ascending order.
    fn vertices(&self) -> Vec<u32> {
        let entries = self.rings.iter().flat_map(|(_, ring)| &self.entries[ring.clone()]);
        let mut vertices: Vec<u32> = self.welded.iter().chain(entries).copied().collect();
        vertices.sort_unstable();
        vertices.dedup();
        vertices
    }

    /// Removes and returns the longest eighth of the one-rings, at least one.
    fn take_longest(&mut self) -> Vec<(u32, Vec<u32>)> {
        let longest = self.rings.split_off(self.rings.len() * 7 / 8);
        longest.into_iter().map(|(vertex, ring)| (vertex, self.entries[ring].to_vec())).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A layout that uses every other row. It stores the vertices of each tile.
    #[derive(Default)]
    struct EveryOtherRow(Vec<Vec<u32>>);

    impl TileLayout for EveryOtherRow {
        fn rows(&self, vertices: &[u32]) -> Vec<usize> {
            (0..vertices.len()).map(|k| 2 * k).collect()
        }

        fn add(&mut self, vertices: &[u32]) {
            self.0.push(vertices.to_vec());
        }
    }

    /// Returns the one-ring of a vertex, read back from the blocks.
    fn read_ring(rings: &OneRingBlocks, tiles: &EveryOtherRow, weld: &[u32], vertex: usize) -> Vec<u32> {
        if let Some(oversized) = rings.oversized.iter().find(|ring| ring.vertex as usize == vertex) {
            assert_eq!(oversized.center, weld[vertex]);
            return oversized.ring.clone();
        }
        let chunk = vertex / CHUNK;
        let at = |offset: u16| tiles.0[chunk][usize::from(offset) / 32];
        let offsets = rings.offsets(chunk)[vertex % CHUNK];
        assert_eq!(at(offsets.position), weld[vertex]);
        let normal = usize::from(offsets.normal) / 16;
        if normal == NO_NORMAL {
            return Vec::new();
        }
        let block = rings.block(rings.blocks(chunk).start + normal / 8);
        assert_eq!(at(block.centers[normal % 8]), weld[vertex]);
        block.ring(normal % 8).map(at).collect()
    }

    #[test]
    fn each_triangle_is_in_the_one_rings_of_its_three_corners() {
        // Fans of different lengths, so that blocks need padding; a fan that does not fit in a tile; seams.
        let fan = |v: u32| (1..2 + v % 7).map(move |k| [v, 100 + v * 9 + k, 101 + v * 9 + k]);
        let mut triangles: Vec<_> = (0..100).flat_map(fan).collect();
        triangles.extend((2000..8000).map(|k| [1500, k, k + 1]));
        let mut weld: Vec<u32> = (0..9000).collect();
        (weld[5], weld[8999]) = (3, 3);
        let mut tiles = EveryOtherRow::default();
        let rings = OneRingBlocks::new(&triangles, &weld, &mut tiles);
        assert!(rings.oversized.iter().any(|ring| ring.vertex == 1500));
        let mut found = Vec::new();
        for (vertex, &v) in weld.iter().enumerate() {
            let ring = read_ring(&rings, &tiles, &weld, vertex);
            let around = ring.windows(2).map(|edge| [v, edge[0], edge[1]]);
            found.extend(around.filter(|[a, b, c]| a != b && b != c && c != a));
        }
        let welded = triangles.iter().map(|t| t.map(|corner| weld[corner as usize]));
        let at_corners = welded.flat_map(|[a, b, c]| [[a, b, c], [b, c, a], [c, a, b]]);
        // Vertices 3, 5 and 8999 are welded, and each of them has the one-ring of vertex 3.
        let mut expected: Vec<_> =
            at_corners.flat_map(|t| std::iter::repeat_n(t, if t[0] == 3 { 3 } else { 1 })).collect();
        expected.sort_unstable();
        found.sort_unstable();
        assert_eq!(found, expected);
    }
}
