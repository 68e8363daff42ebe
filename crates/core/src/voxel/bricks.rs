//! A set of cells to which cells are added in any order.

use std::collections::HashMap;
use std::ops::Range;

use super::grid_set::GridSet;

/// Binary logarithm of the number of cells of a brick along each axis.
const SHIFT: u32 = 3;

/// Number of cells of a brick along each axis.
const SIDE: i32 = 1 << SHIFT;

/// The bricks with a slot of their own in a [`Bricks::recent`] are a cube with this number of bricks along each axis.
const RECENT_SIDE: i32 = 4;

/// The cells of a brick: a word for each z, in it a byte for each y, in it a bit for each x.
type Brick = [u64; SIDE as usize];

/// A set of cells with a maximum size, stored in bricks of 8 by 8 by 8 cells.
///
/// Only bricks with a cell of the set exist, so the memory does not depend on the extent of the grid. A brick takes
/// about 100 bytes. A surface enters about 64 cells of a brick, and a line about 10.
#[derive(Clone, Debug)]
pub(super) struct Bricks {
    bricks: Vec<Brick>,
    /// Index of each brick, by the position `[z, y, x]` of the brick in the grid of bricks.
    indices: HashMap<[i32; 3], u32>,
    /// Position and index of bricks that were found lately, so that most accesses need no hashing. The slot of a brick
    /// follows from its position. The position of an empty slot is `[i32::MAX; 3]`, which no brick has.
    recent: [([i32; 3], u32); RECENT_SIDE.pow(3) as usize],
    /// Number of cells.
    count: u64,
    /// Maximum number of cells.
    max: u64,
}

impl Bricks {
    /// Creates an empty set that is to have at most `max` cells.
    pub(super) fn new(max: u64) -> Self {
        let recent = [([i32::MAX; 3], 0); RECENT_SIDE.pow(3) as usize];
        Self { bricks: Vec::new(), indices: HashMap::new(), recent, count: 0, max }
    }

    /// Returns the number of cells.
    pub(super) fn len(&self) -> u64 {
        self.count
    }

    /// Returns whether there are more cells than the maximum. Further cells are then ignored.
    pub(super) fn is_too_large(&self) -> bool {
        self.count > self.max
    }

    /// Adds a cell.
    pub(super) fn insert(&mut self, cell: [i32; 3]) {
        if self.is_too_large() {
            return;
        }
        let index = self.find(position_of(cell)).unwrap_or_else(|| self.add_brick(position_of(cell)));
        let [x, y, z] = cell.map(|i| i & (SIDE - 1));
        let word = &mut self.bricks[index as usize][z as usize];
        let bit = 1 << (y * SIDE + x);
        self.count += u64::from(*word & bit == 0);
        *word |= bit;
    }

    /// Returns whether a cell is in the set.
    pub(super) fn contains(&mut self, cell: [i32; 3]) -> bool {
        let Some(index) = self.find(position_of(cell)) else { return false };
        let [x, y, z] = cell.map(|i| i & (SIDE - 1));
        self.bricks[index as usize][z as usize] >> (y * SIDE + x) & 1 == 1
    }

    /// Adds all cells of the range `low..high`.
    pub(super) fn insert_all(&mut self, low: [i32; 3], high: [i32; 3]) {
        for part in parts(low, high) {
            if self.is_too_large() {
                return;
            }
            let index = self.find(part.position).unwrap_or_else(|| self.add_brick(part.position));
            for word in &mut self.bricks[index as usize][part.words] {
                self.count += u64::from((part.bits & !*word).count_ones());
                *word |= part.bits;
            }
        }
    }

    /// Returns whether all cells of the range `low..high` are in the set.
    pub(super) fn contains_all(&mut self, low: [i32; 3], high: [i32; 3]) -> bool {
        parts(low, high).all(|part| {
            self.find(part.position).is_some_and(|index| {
                self.bricks[index as usize][part.words].iter().all(|word| word & part.bits == part.bits)
            })
        })
    }

    /// Returns the index of the brick at a position, if there is one.
    #[inline]
    fn find(&mut self, position: [i32; 3]) -> Option<u32> {
        let (recent, index) = self.recent[slot_of(position)];
        if recent == position { Some(index) } else { self.look_up(position) }
    }

    /// Does the work of [`Bricks::find`] by hashing.
    #[cold]
    fn look_up(&mut self, position: [i32; 3]) -> Option<u32> {
        let index = *self.indices.get(&position)?;
        self.recent[slot_of(position)] = (position, index);
        Some(index)
    }

    /// Adds an empty brick and returns its index.
    fn add_brick(&mut self, position: [i32; 3]) -> u32 {
        let index = self.bricks.len() as u32;
        self.bricks.push(Brick::default());
        self.indices.insert(position, index);
        self.recent[slot_of(position)] = (position, index);
        index
    }

    /// Converts the set to runs.
    pub(super) fn into_set(self) -> GridSet {
        let mut order: Vec<_> = self.indices.into_iter().collect();
        order.sort_unstable();
        let mut set = GridSet::default();
        for layer in order.chunk_by(|a, b| a.0[0] == b.0[0]) {
            for z in 0..SIDE {
                for line in layer.chunk_by(|a, b| a.0[1] == b.0[1]) {
                    for y in 0..SIDE {
                        for (position, index) in line {
                            let bits = self.bricks[*index as usize][z as usize] >> (y * SIDE);
                            let [bz, by, bx] = position.map(|i| i << SHIFT);
                            push_runs(&mut set, bits as u8, [bx, by + y, bz + z]);
                        }
                    }
                }
            }
        }
        set
    }
}

/// The lowest bit of each byte.
const FIRST_OF_BYTES: u64 = u64::MAX / u8::MAX as u64;

/// Returns the position `[z, y, x]` of the brick that contains a cell.
fn position_of([x, y, z]: [i32; 3]) -> [i32; 3] {
    [z, y, x].map(|i| i >> SHIFT)
}

/// Returns the slot of a brick in `recent`.
fn slot_of(position: [i32; 3]) -> usize {
    let [z, y, x] = position.map(|i| i & (RECENT_SIDE - 1));
    ((z * RECENT_SIDE + y) * RECENT_SIDE + x) as usize
}

/// The part of a range of cells that is in one brick.
struct Part {
    /// Position of the brick.
    position: [i32; 3],
    /// The words with cells of the range.
    words: Range<usize>,
    /// The bits of the range in each of these words.
    bits: u64,
}

/// Iterates over the bricks that contain a part of the range `low..high`.
fn parts(low: [i32; 3], high: [i32; 3]) -> impl Iterator<Item = Part> {
    let [z, y, x] = [2, 1, 0].map(|a| low[a] >> SHIFT..(high[a] + SIDE - 1) >> SHIFT);
    let positions = z.flat_map(move |z| {
        let x = x.clone();
        y.clone().flat_map(move |y| x.clone().map(move |x| [z, y, x]))
    });
    let is_empty = (0..3).any(|a| low[a] >= high[a]);
    positions.filter(move |_| !is_empty).map(move |position| {
        let [z, y, x] = position.map(|i| i << SHIFT);
        let from = |a: usize, start: i32| (low[a] - start).max(0);
        let to = |a: usize, start: i32| (high[a] - start).min(SIDE);
        let columns = ones(from(0, x), to(0, x));
        let lines = ones(from(1, y) * SIDE, to(1, y) * SIDE) & FIRST_OF_BYTES;
        Part { position, words: from(2, z) as usize..to(2, z) as usize, bits: columns * lines }
    })
}

/// Returns a word whose bits `from..to` are set. The range is not empty and within the word.
fn ones(from: i32, to: i32) -> u64 {
    u64::MAX >> (64 - (to - from)) << from
}

/// Appends the cells of eight bits along x. `start`: the cell of the lowest bit.
fn push_runs(set: &mut GridSet, mut bits: u8, [x, y, z]: [i32; 3]) {
    while bits != 0 {
        let first = bits.trailing_zeros();
        let count = (bits >> first).trailing_ones();
        set.push([x + first as i32, y, z], count);
        // Adding the lowest bit carries through the run and clears it.
        bits &= bits.wrapping_add(1 << first);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::voxel::step;

    #[test]
    fn cells_are_contained_and_listed_in_order() {
        let cells =
            [[0, 0, 0], [130, 3, 2], [7, 1, 0], [8, 1, 0], [9, 1, 0], [1 << 30, 0, 1 << 30], [7, 2, 9]];
        let mut bricks = Bricks::new(100);
        for cell in cells.into_iter().chain(cells) {
            bricks.insert(cell);
        }
        assert_eq!(bricks.len(), cells.len() as u64);
        for cell in cells {
            assert!(bricks.contains(cell));
            assert!(!bricks.contains([cell[0], cell[1] + 3, cell[2]]));
        }
        assert_eq!(bricks.into_set(), GridSet::new(cells.to_vec()));
    }

    #[test]
    fn a_range_is_contained_iff_each_of_its_cells_is() {
        let (low, high) = ([5, 6, 7], [18, 17, 16]);
        let mut bricks = Bricks::new(u64::MAX);
        let all = || (7..16).flat_map(|z| (6..17).flat_map(move |y| (5..18).map(move |x| [x, y, z])));
        all().for_each(|cell| bricks.insert(cell));
        let mut at_once = Bricks::new(u64::MAX);
        at_once.insert_all(low, high);
        at_once.insert_all([3; 3], [3, 9, 9]);
        assert_eq!((at_once.len(), at_once.clone().into_set()), (bricks.len(), bricks.clone().into_set()));
        at_once.insert_all([10; 3], [30; 3]);
        let clipped = 13 * 11 * 9 - 8 * 7 * 6;
        assert_eq!(at_once.len(), clipped + 20_u64.pow(3));
        assert!(bricks.contains_all(low, high) && bricks.contains_all([8; 3], [16; 3]));
        assert!(bricks.contains_all([0; 3], [0, 9, 9]), "an empty range");
        for axis in 0..3 {
            let (below, above) = (step(low, axis, -1), step(high, axis, 1));
            assert!(!bricks.contains_all(below, high) && !bricks.contains_all(low, above));
        }
        for missing in [[5, 6, 7], [17, 16, 15], [8, 8, 8], [7, 15, 8], [12, 7, 15]] {
            let mut without = Bricks::new(u64::MAX);
            all().filter(|cell| *cell != missing).for_each(|cell| without.insert(cell));
            assert!(!without.contains_all(low, high), "{missing:?}");
            let above = missing.map(|i| i + 1);
            assert!(!without.contains_all(missing, above) && without.contains_all(low, missing));
        }
    }

    #[test]
    fn more_cells_than_the_maximum_are_too_many() {
        let mut bricks = Bricks::new(2);
        for x in [4, 5, 4] {
            bricks.insert([x, 0, 0]);
        }
        assert!(!bricks.is_too_large());
        (0..100).for_each(|x| bricks.insert([100 * x, 0, 0]));
        assert!(bricks.is_too_large());
        assert_eq!(bricks.into_set().len(), 3);
    }
}
