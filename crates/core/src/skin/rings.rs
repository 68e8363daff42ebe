//! The one-rings of all vertices of a surface, in blocks of eight.

use std::collections::HashMap;
use std::ops::Range;

use super::one_ring::OneRings;
use crate::simd::tile::{ROWS, offset};

/// Vertices in a chunk: what one thread works on at a time, and enough to find eight whose rings are of one length.
pub(super) const CHUNK: usize = 512;

/// The row of vertices without a normal, among the normals of a chunk.
pub(super) const NO_NORMAL: usize = CHUNK;

/// Where vertices lie in a tile.
pub(super) trait TileLayout {
    /// The row of each of `vertices`, which rise.
    fn rows(&self, vertices: &[u32]) -> Vec<usize>;

    /// Keeps the vertices of the next tile.
    fn add(&mut self, vertices: &[u32]);
}

/// The one-rings of vertices, chunk by chunk in their order.
///
/// A chunk is worked on in a tile that holds its vertices and those around them, welded. Their normals are found in
/// another tile, block by block.
#[derive(Clone, Debug, Default)]
pub(super) struct Rings {
    blocks: Vec<Block>,
    pairs: Vec<[[u16; 8]; 2]>,
    /// Where the blocks of each chunk end.
    ends: Vec<usize>,
    places: Vec<Place>,
    singles: Vec<Single>,
}

/// Where a vertex and its normal are in the tiles, as offsets.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Place {
    pub(super) position: u16,
    pub(super) normal: u16,
}

/// Eight rings, side by side.
#[derive(Clone, Debug)]
struct Block {
    centers: [u16; 8],
    /// The first entry of each ring.
    first: [u16; 8],
    /// Where the pairs begin that follow it.
    pairs: u32,
}

/// A vertex whose ring finds no room in the tile of its chunk, and the welded one that has this ring.
#[derive(Clone, Debug)]
pub(super) struct Single {
    pub(super) vertex: u32,
    pub(super) center: u32,
    pub(super) ring: Vec<u32>,
}

/// Eight vertices and their rings, as offsets in the tile. All rings of a block have one entry and some pairs more;
/// shorter ones end with the vertex.
pub(super) struct EightRings<'a> {
    pub(super) centers: &'a [u16; 8],
    pub(super) first: &'a [u16; 8],
    pub(super) pairs: &'a [[[u16; 8]; 2]],
}

impl Rings {
    /// The rings of vertices that are welded as `weld` says.
    pub(super) fn new(triangles: &[[u32; 3]], weld: &[u32], layout: &mut impl TileLayout) -> Self {
        let welded = triangles.iter().map(|triangle| triangle.map(|corner| weld[corner as usize]));
        let mut one_rings = OneRings::new(welded, weld.len());
        let mut this = Self { places: Vec::with_capacity(weld.len()), ..Self::default() };
        for first in (0..weld.len()).step_by(CHUNK) {
            let own = first..weld.len().min(first + CHUNK);
            let mut chunk = Chunk::new(&mut one_rings, &weld[own.clone()]);
            let (vertices, rows) = loop {
                let vertices = chunk.vertices();
                let rows = layout.rows(&vertices);
                if rows.iter().all(|&row| row < ROWS) {
                    break (vertices, rows);
                }
                let longest = chunk.take_longest();
                for (center, ring) in longest {
                    let of_ring = own.clone().filter(|&vertex| weld[vertex] == center);
                    this.singles.extend(of_ring.map(|vertex| Single {
                        vertex: vertex as u32,
                        center,
                        ring: ring.clone(),
                    }));
                }
            };
            layout.add(&vertices);
            let row_of = |vertex: u32| rows[vertices.binary_search(&vertex).expect("it is one of them")];
            this.add(&chunk, &weld[own], |vertex| offset(row_of(vertex)));
        }
        this
    }

    /// Adds a chunk: eight rings at a time, the shortest first.
    fn add(&mut self, chunk: &Chunk, own: &[u32], offset_of: impl Fn(u32) -> u16) {
        for eight in chunk.rings.chunks(8) {
            // The last of them fills the lanes that are left.
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
        self.places.extend(own.iter().map(|vertex| Place {
            position: offset_of(*vertex),
            normal: offset(normals.get(vertex).copied().unwrap_or(NO_NORMAL)),
        }));
    }

    /// How many vertices there are.
    pub(super) fn len(&self) -> usize {
        self.places.len()
    }

    /// The blocks of a chunk.
    pub(super) fn blocks(&self, chunk: usize) -> Range<usize> {
        (if chunk == 0 { 0 } else { self.ends[chunk - 1] })..self.ends[chunk]
    }

    /// Eight of the rings.
    #[inline]
    pub(super) fn block(&self, block: usize) -> EightRings<'_> {
        let end = self.blocks.get(block + 1).map_or(self.pairs.len(), |next| next.pairs as usize);
        let Block { centers, first, pairs } = &self.blocks[block];
        EightRings { centers, first, pairs: &self.pairs[*pairs as usize..end] }
    }

    /// Where the vertices of a chunk are.
    pub(super) fn places(&self, chunk: usize) -> &[Place] {
        &self.places[chunk * CHUNK..self.places.len().min((chunk + 1) * CHUNK)]
    }

    /// The vertices whose rings find no room.
    pub(super) fn singles(&self) -> &[Single] {
        &self.singles
    }

    /// Memory that they take.
    pub(super) fn bytes(&self) -> usize {
        let Self { blocks, pairs, ends, places, singles } = self;
        let single = |single: &Single| size_of::<Single>() + size_of_val(&*single.ring);
        let tables = size_of_val(&**ends) + size_of_val(&**places);
        tables + size_of_val(&**blocks) + size_of_val(&**pairs) + singles.iter().map(single).sum::<usize>()
    }
}

impl EightRings<'_> {
    /// The entries of one of the rings.
    pub(super) fn ring(&self, lane: usize) -> impl Iterator<Item = u16> {
        std::iter::once(self.first[lane]).chain(self.pairs.iter().flatten().map(move |entry| entry[lane]))
    }
}

/// The rings of a chunk while they are built.
struct Chunk {
    /// Welded vertices.
    own: Vec<u32>,
    /// Those that have a ring, and where that is among the entries; the shortest first.
    rings: Vec<(u32, Range<usize>)>,
    entries: Vec<u32>,
}

impl Chunk {
    fn new(one_rings: &mut OneRings, welded: &[u32]) -> Self {
        let mut own = welded.to_vec();
        own.sort_unstable();
        own.dedup();
        let (mut rings, mut entries) = (Vec::new(), Vec::new());
        for &vertex in &own {
            let begin = entries.len();
            one_rings.append(vertex, &mut entries);
            if entries.len() > begin {
                rings.push((vertex, begin..entries.len()));
            }
        }
        rings.sort_by_key(|(_, ring)| ring.len());
        Self { own, rings, entries }
    }

    /// The vertices and those around them, rising.
    fn vertices(&self) -> Vec<u32> {
        let entries = self.rings.iter().flat_map(|(_, ring)| &self.entries[ring.clone()]);
        let mut vertices: Vec<u32> = self.own.iter().chain(entries).copied().collect();
        vertices.sort_unstable();
        vertices.dedup();
        vertices
    }

    /// Takes out an eighth of the rings, at least one.
    fn take_longest(&mut self) -> Vec<(u32, Vec<u32>)> {
        let longest = self.rings.split_off(self.rings.len() * 7 / 8);
        longest.into_iter().map(|(vertex, ring)| (vertex, self.entries[ring].to_vec())).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The vertices of each tile, in every other row.
    #[derive(Default)]
    struct Apart(Vec<Vec<u32>>);

    impl TileLayout for Apart {
        fn rows(&self, vertices: &[u32]) -> Vec<usize> {
            (0..vertices.len()).map(|k| 2 * k).collect()
        }

        fn add(&mut self, vertices: &[u32]) {
            self.0.push(vertices.to_vec());
        }
    }

    /// The ring of a vertex as it is stored.
    fn stored(rings: &Rings, tiles: &Apart, weld: &[u32], vertex: usize) -> Vec<u32> {
        if let Some(single) = rings.singles.iter().find(|single| single.vertex as usize == vertex) {
            assert_eq!(single.center, weld[vertex]);
            return single.ring.clone();
        }
        let chunk = vertex / CHUNK;
        let at = |offset: u16| tiles.0[chunk][usize::from(offset) / 32];
        let place = rings.places(chunk)[vertex % CHUNK];
        assert_eq!(at(place.position), weld[vertex]);
        let normal = usize::from(place.normal) / 16;
        if normal == NO_NORMAL {
            return Vec::new();
        }
        let eight = rings.block(rings.blocks(chunk).start + normal / 8);
        assert_eq!(at(eight.centers[normal % 8]), weld[vertex]);
        eight.ring(normal % 8).map(at).collect()
    }

    #[test]
    fn each_triangle_is_in_three_rings() {
        // Fans of all lengths, so that blocks hold rings of different ones; one that no tile holds; seams.
        let fan = |v: u32| (1..2 + v % 7).map(move |k| [v, 100 + v * 9 + k, 101 + v * 9 + k]);
        let mut triangles: Vec<_> = (0..100).flat_map(fan).collect();
        triangles.extend((2000..8000).map(|k| [1500, k, k + 1]));
        let mut weld: Vec<u32> = (0..9000).collect();
        (weld[5], weld[8999]) = (3, 3);
        let mut tiles = Apart::default();
        let rings = Rings::new(&triangles, &weld, &mut tiles);
        assert!(rings.singles.iter().any(|single| single.vertex == 1500));
        let mut found = Vec::new();
        for (vertex, &v) in weld.iter().enumerate() {
            let ring = stored(&rings, &tiles, &weld, vertex);
            let around = ring.windows(2).map(|edge| [v, edge[0], edge[1]]);
            found.extend(around.filter(|[a, b, c]| a != b && b != c && c != a));
        }
        let welded = triangles.iter().map(|t| t.map(|corner| weld[corner as usize]));
        let at_corners = welded.flat_map(|[a, b, c]| [[a, b, c], [b, c, a], [c, a, b]]);
        // Vertices 3, 5 and 8999 are one, and each has its ring.
        let mut expected: Vec<_> =
            at_corners.flat_map(|t| std::iter::repeat_n(t, if t[0] == 3 { 3 } else { 1 })).collect();
        expected.sort_unstable();
        found.sort_unstable();
        assert_eq!(found, expected);
    }
}
