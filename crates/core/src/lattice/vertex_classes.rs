//! The classes of pairs (cell, corner) that unbroken joints unite, which are the vertices of a broken lattice.

use super::Lattice;
use super::broken::{Broken, Joint, Whole};
use super::charts::{Chart, NO_NEIGHBOR};
use super::components::Components;
use super::split_links::links;
use crate::mesh::{UnionFind, distinct};

/// The classes of (cell, corner) after joints broke.
pub(super) struct Classes {
    /// Vertices at the corners of each cell.
    corners: Vec<[u32; 8]>,
    /// For each copy, the vertex of the whole lattice at its grid index.
    sources: Vec<u32>,
    /// The vertices of the whole lattice at the corners of broken joints, sorted, but for those that stay whole.
    split: Vec<u32>,
}

impl Classes {
    /// Finds the classes at the corners of the broken joints. `corners`: of the whole lattice. `unsplit`:
    /// vertices that have one class in each piece, sorted. `pieces`: the piece of each cell.
    pub(super) fn of(
        whole: &Lattice,
        mut corners: Vec<[u32; 8]>,
        joints: &[Joint],
        (unsplit, pieces): (&[u32], &[u32]),
    ) -> Self {
        let at_joints = distinct(joints.iter().flat_map(|joint| joint.corners(corners[joint.cell as usize])));
        let (mut split, mut sources) = (Vec::with_capacity(at_joints.len()), Vec::new());
        for vertex in at_joints {
            let cells =
                std::array::from_fn(|octant| whole.cell_around(whole.indices[vertex as usize], octant));
            let mut classes = classes_around(&cells, |joint| joints.binary_search(&joint).is_err());
            // Cells that touch at an edge or a corner only, and that no joints connect around the vertex, stay
            // connected: the lowest cells of the classes that the whole lattice has.
            let before = classes_around(&cells, |_| true);
            let lowest_of = |label: u8| (0..8).find(|&k| before[k] == label && cells[k].is_some());
            let firsts: Vec<usize> = (0..8).filter_map(|label| lowest_of(label as u8)).collect();
            for &other in firsts.iter().skip(1) {
                let (kept, united) = (classes[firsts[0]], classes[other]);
                classes.iter_mut().filter(|class| **class == united).for_each(|class| *class = kept);
            }
            let is_unsplit = unsplit.binary_search(&vertex).is_ok();
            if is_unsplit {
                // The lowest cell of each piece is the label of its class.
                let piece = cells.map(|cell| cell.map(|cell| pieces[cell as usize]));
                classes = piece.map(|own| piece.iter().position(|other| *other == own).unwrap_or(0) as u8);
            }
            let copies = sources.len();
            // The class of the lowest cell keeps the number of the vertex. Octants are in the order of the cells.
            let mut numbers = [u32::MAX; 8];
            let mut is_first = true;
            for k in 0..8 {
                let Some(cell) = cells[k] else { continue };
                let number = &mut numbers[usize::from(classes[k])];
                if *number == u32::MAX {
                    *number = if is_first { vertex } else { (whole.len() + sources.len()) as u32 };
                    if !is_first {
                        sources.push(vertex);
                    }
                    is_first = false;
                }
                corners[cell as usize][7 - k] = *number;
            }
            if !is_unsplit || sources.len() > copies {
                split.push(vertex);
            }
        }
        Self { corners, sources, split }
    }

    /// Builds the lattice of the classes. `neighbors`: [`Lattice::neighbor_table`] of the whole lattice. `offset`:
    /// of its blocks.
    pub(super) fn lattice(
        self,
        mut whole: Lattice,
        (neighbors, offset): (&[[u32; 6]], [i32; 3]),
        joints: &[Joint],
    ) -> Lattice {
        let Self { corners, sources, split } = self;
        let whole_len = whole.len();
        let neighbors = links((&whole, neighbors), &corners, &sources, &split);
        whole
            .indices
            .extend(sources.iter().map(|&source| whole.indices[source as usize]).collect::<Vec<_>>());
        let (chart, neighbors) = Chart::new(&whole.indices, offset, &split, neighbors);
        let links = neighbors.iter().map(|neighbors| {
            neighbors
                .iter()
                .enumerate()
                .fold(0, |links, (side, &n)| links | u8::from(n != NO_NEIGHBOR) << side)
        });
        let links = links.collect();
        let mut occupied_cells = vec![0; whole.indices.len()];
        let mut sets = UnionFind::new(whole.indices.len());
        for cell in &corners {
            for &corner in cell {
                occupied_cells[corner as usize] += 1;
                sets.unite(cell[0], corner);
            }
        }
        let (count, of_vertex) = sets.labels();
        let before = Whole {
            links: std::mem::replace(&mut whole.links, links),
            occupied_cells: std::mem::replace(&mut whole.occupied_cells, occupied_cells),
            components: std::mem::replace(&mut whole.components, Components { count, of_vertex }),
        };
        let joints = joints.to_vec();
        let broken = Broken { joints, whole: before, whole_len, sources, corners, neighbors, chart };
        whole.broken = Some(Box::new(broken));
        whole
    }
}

/// Returns a label of each of the eight cells around a vertex. Two cells have the same label iff joints that `holds`
/// accepts connect them around the vertex.
fn classes_around(cells: &[Option<u32>; 8], holds: impl Fn(Joint) -> bool) -> [u8; 8] {
    let mut labels = [0, 1, 2, 3, 4, 5, 6, 7];
    for axis in 0..3 {
        for k in (0..8).filter(|k| k >> axis & 1 == 0) {
            let next = k | 1 << axis;
            if let (Some(cell), Some(_)) = (cells[k], cells[next])
                && holds(Joint { cell, axis: axis as u8 })
            {
                let (from, to) = (labels[k].max(labels[next]), labels[k].min(labels[next]));
                labels.iter_mut().filter(|label| **label == from).for_each(|label| *label = to);
            }
        }
    }
    labels
}
