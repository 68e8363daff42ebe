//! The broken faces of the cells, and their continuation through empty cells to the surface of the mesh.

use std::collections::VecDeque;

use nalgebra::Vector3;

use super::map::Map;
use super::planes::{Cell, Face, Planes, staircase_neighbors};
use crate::lattice::Lattice;
use crate::mesh::distinct;
use crate::voxel::step;

/// A broken joint of a lattice: the face between a cell and the next cell along an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct BrokenJoint {
    /// Index of the cell, in [`Lattice::cells`].
    pub cell: u32,
    /// Axis, 0 to 2.
    pub axis: u8,
    /// Index of the crack that broke the joint. The cells should be on opposite sides of its plane, by
    /// [`CrackPlane::is_positive`](super::CrackPlane::is_positive); otherwise the pieces are still closed, but the
    /// cut is not smooth there.
    pub crack: u32,
}

/// Shape of the surface of a cut.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CutSurface {
    /// The plane of the crack.
    #[default]
    Smooth,
    /// The faces of the cells.
    Cells,
}

impl CutSurface {
    /// All values with their names, as in a scene file.
    pub const NAMED: [(&'static str, Self); 2] = [("smooth", Self::Smooth), ("cells", Self::Cells)];

    /// Returns the name of the value in [`CutSurface::NAMED`].
    pub fn name(self) -> &'static str {
        Self::NAMED[self as usize].0
    }
}

/// Marks a face that is not broken.
const NONE: u32 = u32::MAX;

/// Edge of the blocks of cells that list the cracks near them.
const BLOCK: i32 = 4;

/// Distance in cells from a broken face within which a block lists its crack. Points move by at most one cell.
const NEAR: i32 = 2;

/// The broken faces.
pub(super) struct BrokenFaces {
    /// The cracks of the faces between a cell and the next cells along x, y and z.
    cracks: Map<Cell, [u32; 3]>,
    /// All faces, sorted.
    sorted: Vec<(Face, u32)>,
    /// The cracks near each block of cells.
    blocks: Map<Cell, Vec<u32>>,
    /// The lowest and the highest cell beside a broken face.
    bounds: (Cell, Cell),
}

impl BrokenFaces {
    pub(super) fn new(
        lattice: &Lattice,
        joints: &[BrokenJoint],
        planes: &Planes,
        surface: CutSurface,
    ) -> Self {
        let mut faces = Self {
            cracks: Map::default(),
            sorted: Vec::new(),
            blocks: Map::default(),
            bounds: ([i32::MAX; 3], [i32::MIN; 3]),
        };
        for joint in joints {
            let cell = lattice.cells()[joint.cell as usize];
            faces.insert((cell, joint.axis as usize), joint.crack);
        }
        faces.continue_outside(lattice, planes, surface);
        faces.sorted.sort_unstable();
        faces.sorted.dedup();
        for index in 0..faces.sorted.len() {
            let ((cell, axis), crack) = faces.sorted[index];
            faces.list_near(cell, step(cell, axis, 1), crack);
        }
        faces
    }

    fn insert(&mut self, (cell, axis): Face, crack: u32) {
        let slot = &mut self.cracks.entry(cell).or_insert([NONE; 3])[axis];
        if *slot == NONE {
            *slot = crack;
            self.sorted.push(((cell, axis), crack));
            for a in 0..3 {
                self.bounds.0[a] = self.bounds.0[a].min(cell[a]);
                self.bounds.1[a] = self.bounds.1[a].max(cell[a] + i32::from(a == axis));
            }
        }
    }

    /// Continues the staircase of each crack through faces of empty cells, because the mesh need not end exactly where
    /// the occupied cells end. A face of an empty cell is broken if the nearest face between occupied cells, counted in
    /// faces of the staircase, is broken.
    fn continue_outside(&mut self, lattice: &Lattice, planes: &Planes, surface: CutSurface) {
        let occupied = |cell: Cell| lattice.cell_at(cell).is_some();
        let count = planes.count();
        let mut of_crack = vec![Vec::new(); count as usize];
        self.sorted.iter().for_each(|&(face, crack)| of_crack[crack as usize].push(face));
        for (crack, broken) in (0..count).zip(of_crack) {
            if planes.normal(crack) == Vector3::zeros() {
                continue;
            }
            let is_joint = |(cell, axis): Face| occupied(cell) && occupied(step(cell, axis, 1));
            let is_near = |(cell, _): Face| {
                (0..27).any(|k| occupied([cell[0] + k % 3 - 1, cell[1] + k / 3 % 3 - 1, cell[2] + k / 9 - 1]))
            };
            // The faces of empty cells that are connected with the crack, and the joints beside them.
            let mut depth: Map<Face, (u32, bool)> = Map::default();
            let mut queue: VecDeque<Face> = VecDeque::new();
            let mut sources = Vec::new();
            for &face in &broken {
                depth.insert(face, (0, true));
                queue.push_back(face);
                sources.push(face);
            }
            while let Some(face) = queue.pop_front() {
                let (level, _) = depth[&face];
                if surface == CutSurface::Cells && level == 1 {
                    continue;
                }
                for next in staircase_neighbors(planes, crack, face) {
                    if depth.contains_key(&next) {
                        continue;
                    }
                    if self.crack(next).is_some() {
                        // Another crack broke it.
                        depth.insert(next, (0, true));
                        queue.push_back(next);
                        sources.push(next);
                        continue;
                    }
                    let joint = is_joint(next);
                    // From a joint of the crack the front of the crack does not advance into other joints.
                    if joint && level == 0 {
                        continue;
                    }
                    if joint {
                        depth.insert(next, (0, false));
                        sources.push(next);
                    } else if is_near(next) {
                        depth.insert(next, (level + 1, false));
                        queue.push_back(next);
                    }
                }
            }
            // The nearest joint of each face decides.
            let mut done: Map<Face, bool> = sources.iter().map(|&face| (face, depth[&face].1)).collect();
            let mut queue: VecDeque<Face> = sources.into();
            while let Some(face) = queue.pop_front() {
                let is_broken = done[&face];
                for next in staircase_neighbors(planes, crack, face) {
                    if !done.contains_key(&next) && depth.contains_key(&next) {
                        done.insert(next, is_broken);
                        queue.push_back(next);
                        if is_broken {
                            self.insert(next, crack);
                        }
                    }
                }
            }
        }
    }

    /// Adds a crack to the blocks near a face.
    fn list_near(&mut self, low: Cell, high: Cell, crack: u32) {
        let first = low.map(|x| (x - NEAR).div_euclid(BLOCK));
        let last = high.map(|x| (x + NEAR).div_euclid(BLOCK));
        for z in first[2]..=last[2] {
            for y in first[1]..=last[1] {
                for x in first[0]..=last[0] {
                    let cracks = self.blocks.entry([x, y, z]).or_default();
                    if let Err(at) = cracks.binary_search(&crack) {
                        cracks.insert(at, crack);
                    }
                }
            }
        }
    }

    /// Returns the cracks with a broken face near a cell, in ascending order.
    pub(super) fn near(&self, cell: Cell) -> &[u32] {
        let (low, high) = &self.bounds;
        if (0..3).any(|a| cell[a] < low[a].saturating_sub(8) || cell[a] > high[a].saturating_add(8)) {
            return &[];
        }
        self.blocks.get(&cell.map(|x| x.div_euclid(BLOCK))).map_or(&[], Vec::as_slice)
    }

    /// Returns whether a crack is near a box of cells.
    pub(super) fn is_near_box(&self, low: Cell, high: Cell) -> bool {
        let first: Cell = std::array::from_fn(|a| low[a].max(self.bounds.0[a] - 8).div_euclid(BLOCK));
        let last: Cell = std::array::from_fn(|a| high[a].min(self.bounds.1[a] + 8).div_euclid(BLOCK));
        (first[2]..=last[2]).any(|z| {
            (first[1]..=last[1]).any(|y| (first[0]..=last[0]).any(|x| self.blocks.contains_key(&[x, y, z])))
        })
    }

    /// Returns the crack of a face, if it is broken.
    pub(super) fn crack(&self, (cell, axis): Face) -> Option<u32> {
        if (0..3).any(|a| cell[a] < self.bounds.0[a] || cell[a] > self.bounds.1[a]) {
            return None;
        }
        self.cracks.get(&cell).map(|cracks| cracks[axis]).filter(|&crack| crack != NONE)
    }

    /// Returns all broken faces with their cracks, sorted.
    pub(super) fn sorted(&self) -> &[(Face, u32)] {
        &self.sorted
    }

    /// Calls `visit` for each broken face between two cells of a box.
    pub(super) fn visit_inside(&self, low: Cell, high: Cell, mut visit: impl FnMut(Face)) {
        let first: Cell = std::array::from_fn(|a| low[a].max(self.bounds.0[a]));
        let last: Cell = std::array::from_fn(|a| high[a].min(self.bounds.1[a]));
        if (0..3).any(|a| first[a] > last[a]) {
            return;
        }
        let volume: i64 =
            (0..3).map(|a| i64::from(last[a]) - i64::from(first[a]) + 1).fold(1, i64::saturating_mul);
        let mut face = |cell: Cell, axis: usize| {
            if cell[axis] < last[axis] {
                visit((cell, axis));
            }
        };
        if volume > self.sorted.len() as i64 {
            let inside = |cell: &Cell| (0..3).all(|a| (first[a]..=last[a]).contains(&cell[a]));
            for &((cell, axis), _) in self.sorted.iter().filter(|((cell, _), _)| inside(cell)) {
                face(cell, axis);
            }
            return;
        }
        for z in first[2]..=last[2] {
            for y in first[1]..=last[1] {
                for x in first[0]..=last[0] {
                    let Some(cracks) = self.cracks.get(&[x, y, z]) else { continue };
                    (0..3).filter(|&axis| cracks[axis] != NONE).for_each(|axis| face([x, y, z], axis));
                }
            }
        }
    }

    /// Returns the class of a cell around a point: the cells that contain the point are united over faces that are not
    /// broken. A class is the lowest of its cells, as a bit mask of the axes on which the cell is the upper one.
    ///
    /// * `on`: bit mask of the axes on whose plane of index `k` the point is.
    pub(super) fn class(&self, k: Cell, on: u8, cell: Cell) -> u8 {
        let own = (0..3).filter(|&a| on >> a & 1 != 0 && cell[a] == k[a]).fold(0_u8, |mask, a| mask | 1 << a);
        let mut joined = [(0, 0); 12];
        let mut count = 0;
        for mask in (0..8_u8).filter(|mask| mask & !on == 0) {
            for axis in (0..3).filter(|&axis| on >> axis & 1 != 0 && mask >> axis & 1 == 0) {
                let is_lower = |a: usize| on >> a & 1 != 0 && mask >> a & 1 == 0;
                if self.crack((std::array::from_fn(|a| k[a] - i32::from(is_lower(a))), axis)).is_none() {
                    joined[count] = (mask as usize, (mask | 1 << axis) as usize);
                    count += 1;
                }
            }
        }
        // Passes until nothing changes: at most eight cells.
        let mut classes: [u8; 8] = std::array::from_fn(|mask| mask as u8);
        loop {
            let before = classes;
            for &(a, b) in &joined[..count] {
                let lowest = classes[a].min(classes[b]);
                (classes[a], classes[b]) = (lowest, lowest);
            }
            if classes == before {
                return classes[own as usize];
            }
        }
    }

    /// Returns the lowest crack of the broken faces that contain a point, if there is one.
    pub(super) fn crack_at(&self, k: Cell, on: u8) -> Option<u32> {
        let masks = (0..8_u8).filter(|mask| mask & !on == 0);
        let cells = masks.flat_map(|mask| {
            let lower = |a: usize| i32::from(on >> a & 1 != 0 && mask >> a & 1 == 0);
            let cell = std::array::from_fn(|a| k[a] - lower(a));
            (0..3)
                .filter(move |&axis| on >> axis & 1 != 0 && mask >> axis & 1 == 0)
                .map(move |axis| (cell, axis))
        });
        cells.filter_map(|face| self.crack(face)).min()
    }

    /// Returns the cracks of the broken faces at a corner of the grid, in ascending order.
    pub(super) fn cracks_at(&self, corner: Cell) -> Vec<u32> {
        let mut cracks = Vec::new();
        for k in 0..8 {
            let cell: Cell = std::array::from_fn(|a| corner[a] - (k >> a & 1));
            cracks.extend((0..3).filter(|&a| cell[a] < corner[a]).filter_map(|a| self.crack((cell, a))));
        }
        distinct(cracks)
    }
}
