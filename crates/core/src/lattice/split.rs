//! Splits the vertices of a lattice along broken joints.
//!
//! While all joints hold, each grid index has one lattice vertex. Where joints break, a vertex splits: a lattice vertex
//! is the class of the pairs (cell, corner) at one grid index that unbroken joints unite (Rivers & James 2007, section
//! 6, break links between cells in the same way). Cells that touch at an edge or a corner only stay connected.

use super::Lattice;
use super::blocks::{BlockKey, fewest_blocks, key_and_lane};
use super::broken::{Broken, Joint, Whole};
use super::charts::NO_NEIGHBOR;
use super::vertex_classes::Classes;
use crate::mesh::{UnionFind, distinct};

impl Lattice {
    /// Returns the lattice in which exactly the given joints are broken, sorted and without repetition.
    ///
    /// The vertices keep their numbers. Copies have the numbers from [`Lattice::whole_len`] on.
    ///
    /// # Panics
    ///
    /// If a joint is none of the lattice.
    pub(crate) fn with_broken_joints(&self, joints: &[Joint]) -> Self {
        let mut whole = self.clone();
        whole.mend();
        if joints.is_empty() {
            return whole;
        }
        let neighbors = whole.neighbor_table();
        let corners = whole.corners_by(&neighbors);
        let offset = fewest_blocks(&whole.vertex_set);
        let classes = Classes::of(&whole, corners.clone(), joints, (&[], &[]));
        let mut lattice = classes.lattice(whole.clone(), (&neighbors, offset), joints);
        let mut unsplit = lattice.loose_copies(&[]);
        if unsplit.is_empty() {
            return lattice;
        }
        let pieces: Vec<u32> =
            (0..whole.cells.len() as u32).map(|cell| lattice.component_of_cell(cell)).collect();
        loop {
            let classes = Classes::of(&whole, corners.clone(), joints, (&unsplit, &pieces));
            lattice = classes.lattice(whole.clone(), (&neighbors, offset), joints);
            let loose = lattice.loose_copies(&unsplit);
            if loose.is_empty() {
                return lattice;
            }
            unsplit.extend(loose);
            unsplit.sort_unstable();
        }
    }

    /// Returns vertices of the lattice without broken joints that should not split, because no links connect one of
    /// their copies with its component. At the front of a crack, some edges of cells are no links: see `split_links`
    /// and `charts`. Such a copy would have no links. Sorted; without the copies in `unsplit`.
    ///
    /// In each component, these are the copies of one block: a block without copies has all links. With more of them, a
    /// crack whose last joint has no link across it would close along its whole length.
    fn loose_copies(&self, unsplit: &[u32]) -> Vec<u32> {
        let Some(broken) = &self.broken else { return Vec::new() };
        let mut sets = UnionFind::new(self.len());
        for (vertex, neighbors) in (0..).zip(&broken.neighbors) {
            for &next in neighbors.iter().skip(1).step_by(2).filter(|next| **next != NO_NEIGHBOR) {
                sets.unite(vertex, next);
            }
        }
        let (count, set_of) = sets.labels();
        if count == self.components.count {
            return Vec::new();
        }
        let mut has_copies = vec![false; broken.whole_len];
        broken.sources.iter().for_each(|&source| has_copies[source as usize] = true);
        let mut vertices: Vec<(u32, BlockKey, u32)> = (0..self.len() as u32)
            .map(|vertex| {
                let (key, _) = key_and_lane(broken.chart.offset, self.indices[vertex as usize]);
                (self.components.of_vertex[vertex as usize], key, vertex)
            })
            .collect();
        vertices.sort_unstable();
        let mut loose: Vec<u32> = Vec::new();
        for component in vertices.chunk_by(|a, b| a.0 == b.0) {
            // The new vertices with copies of a block that has vertices of several sets.
            let copies_of = |block: &[(u32, BlockKey, u32)]| {
                let set = |&(_, _, vertex): &(u32, BlockKey, u32)| set_of[vertex as usize];
                let is_divided = block.iter().any(|vertex| set(vertex) != set(&block[0]));
                let sources = block.iter().map(|&(_, _, vertex)| self.source(vertex));
                let is_new = |&source: &u32| {
                    is_divided && has_copies[source as usize] && unsplit.binary_search(&source).is_err()
                };
                distinct(sources.filter(is_new))
            };
            let blocks = component.chunk_by(|a, b| a.1 == b.1).map(copies_of);
            loose.extend(
                blocks.filter(|copies| !copies.is_empty()).min_by_key(Vec::len).into_iter().flatten(),
            );
        }
        if loose.is_empty() {
            let sources = vertices.iter().map(|&(_, _, vertex)| self.source(vertex));
            loose.extend(
                sources
                    .filter(|source| has_copies[*source as usize] && unsplit.binary_search(source).is_err()),
            );
        }
        distinct(loose)
    }

    /// Mends all joints, which removes the copies.
    fn mend(&mut self) {
        let Some(broken) = self.broken.take() else { return };
        let Broken { whole_len, whole: Whole { links, occupied_cells, components }, .. } = *broken;
        self.indices.truncate(whole_len);
        (self.links, self.occupied_cells, self.components) = (links, occupied_cells, components);
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Point3, Vector3};

    use super::*;
    use crate::matching::{HalfWidth, Matching, Purpose, RegionFit, Shapes, Workspace};
    use crate::mesh::testing::Random;
    use crate::parallel::Executor;
    use crate::reference::{Naive, Regions};
    use crate::simd::lanes::Lanes;

    fn block(size: [i32; 3]) -> Lattice {
        let [nx, ny, nz] = size;
        let cells: Vec<_> = (0..nx * ny * nz).map(|k| [k % nx, k / nx % ny, k / nx / ny]).collect();
        Lattice::from_cells(&cells, 1.0, Point3::origin(), false).unwrap()
    }

    /// Returns the joints along x between the cells at `x` and `x + 1` whose cells `accepts`.
    fn section(lattice: &Lattice, x: i32, accepts: impl Fn([i32; 3]) -> bool) -> Vec<Joint> {
        let is_on = |joint: &Joint| {
            let index = lattice.cells()[joint.cell as usize];
            joint.axis == 0 && index[0] == x && accepts(index)
        };
        lattice.joints().map(|(joint, _)| joint).filter(is_on).collect()
    }

    /// Checks that the corners, sources, components and links of a lattice fit together.
    fn check(lattice: &Lattice) {
        let mut cells = vec![0; lattice.len()];
        for cell in 0..lattice.cells().len() as u32 {
            let index = lattice.cells()[cell as usize];
            for (k, corner) in lattice.cell_corners(cell).into_iter().enumerate() {
                let offset: [i32; 3] = std::array::from_fn(|a| index[a] + (k as i32 >> a & 1));
                assert_eq!(lattice.indices()[corner as usize], offset);
                assert_eq!(lattice.vertex_at(offset), Some(lattice.source(corner)));
                cells[corner as usize] += 1;
            }
            for side in 0..6 {
                let Some(other) = lattice.joined_cell(cell, side) else { continue };
                let (own, other) = (lattice.cell_corners(cell), lattice.cell_corners(other));
                // A joint that holds keeps the four vertices of its face in common.
                assert_eq!(own.iter().filter(|corner| other.contains(corner)).count(), 4);
            }
        }
        assert_eq!(cells, lattice.occupied_cells());
        let mut sets = UnionFind::new(lattice.len());
        for vertex in 0..lattice.len() as u32 {
            let neighbors = lattice.neighbors(vertex);
            for (side, other) in neighbors.into_iter().enumerate() {
                let Some(other) = other else { continue };
                assert_eq!(lattice.neighbors(other)[side ^ 1], Some(vertex));
                let components = &lattice.components().of_vertex;
                assert_eq!(components[vertex as usize], components[other as usize]);
                sets.unite(vertex, other);
            }
        }
        assert_eq!(sets.labels().0, lattice.components().count, "links connect each component");
    }

    #[test]
    fn a_broken_section_divides_a_bar() {
        let whole = block([6, 3, 3]);
        let broken = whole.with_broken_joints(&section(&whole, 2, |_| true));
        check(&broken);
        assert_eq!((broken.components().count, broken.len()), (2, whole.len() + 16));
        assert_eq!(broken.with_broken_joints(&[]), whole);
        let again = broken.with_broken_joints(broken.broken_joints());
        assert_eq!(again, broken);
    }

    #[test]
    fn vertices_at_the_front_of_a_slit_have_no_copies() {
        let whole = block([6, 4, 3]);
        let slit = whole.with_broken_joints(&section(&whole, 2, |[_, y, _]| y < 2));
        check(&slit);
        // Rows at y = 0 and y = 1 open, the row at y = 2 is the front.
        assert_eq!((slit.components().count, slit.len()), (1, whole.len() + 2 * 4));
    }

    /// Where the last joint of a section has no link across it, the copies of one block stay whole: a block has four
    /// places in a section, one of them at the joint.
    #[test]
    fn sections_of_which_one_joint_holds_stay_open() {
        for (size, last) in
            [([6, 3, 3], [1, 1]), ([6, 4, 4], [1, 1]), ([6, 5, 5], [2, 2]), ([6, 5, 5], [1, 3])]
        {
            let whole = block(size);
            let open = |[_, y, z]: [i32; 3]| [y, z] != last;
            let broken = whole.with_broken_joints(&section(&whole, 2, open));
            check(&broken);
            let [_, y, z] = size.map(|cells| (cells + 1) as usize);
            assert_eq!(broken.components().count, 1);
            let copies = broken.len() - whole.len();
            assert!((y * z - 4 - 3..=y * z - 4).contains(&copies), "{size:?} {last:?}: {copies}");
        }
    }

    #[test]
    fn cells_that_touch_at_an_edge_stay_connected() {
        let cells = [[0, 0, 0], [1, 0, 0], [2, 1, 0], [3, 1, 0]];
        let whole = Lattice::from_cells(&cells, 1.0, Point3::origin(), false).unwrap();
        let broken = whole.with_broken_joints(&section(&whole, 0, |_| true));
        check(&broken);
        assert_eq!(broken.components().count, 2);
    }

    #[test]
    fn pieces_are_those_that_joints_connect_and_never_unite_again() {
        let (mut random, mut count) = (Random(5), 1);
        let whole = block([7, 6, 5]);
        let mut joints: Vec<(f64, Joint)> = whole.joints().map(|(joint, _)| (random.next(), joint)).collect();
        joints.sort_by(|a, b| a.0.total_cmp(&b.0));
        for broken in (0..=joints.len()).step_by(20) {
            let mut broken: Vec<Joint> = joints[..broken].iter().map(|(_, joint)| *joint).collect();
            broken.sort_unstable();
            let lattice = whole.with_broken_joints(&broken);
            check(&lattice);
            let mut cells = UnionFind::new(whole.cells().len());
            for (joint, other) in lattice.joints().filter(|(joint, _)| !lattice.is_broken(*joint)) {
                cells.unite(joint.cell, other);
            }
            assert_eq!(lattice.components().count, cells.labels().0);
            assert!(lattice.components().count >= count);
            count = lattice.components().count;
        }
        assert!(count > 100, "{count}");
    }

    #[test]
    fn goals_of_lattices_with_random_broken_joints_are_those_of_the_reference() {
        let mut random = Random(7);
        for (trial, share) in [0.02, 0.1, 0.3, 0.6, 0.1, 0.3, 0.2, 0.4].into_iter().enumerate() {
            let whole = block([7, 6, 5]);
            let joints: Vec<_> =
                whole.joints().map(|(joint, _)| joint).filter(|_| random.next() < share).collect();
            let lattice = whole.with_broken_joints(&joints);
            check(&lattice);
            let masses: Vec<f32> =
                lattice.occupied_cells().iter().map(|&cells| f32::from(cells) / 8.0).collect();
            let positions: Vec<Point3<f64>> = (0..lattice.len() as u32)
                .map(|vertex| {
                    let shift = Vector3::from_fn(|_, _| f64::from((0.3 * random.next()) as f32));
                    (lattice.rest_position(vertex) + shift).map(|x| f64::from(x as f32))
                })
                .collect();
            for half_width in std::iter::once(HalfWidth::CELL).chain((1..=7).map(HalfWidth::from)) {
                let matching = Matching::new(&lattice, &masses.clone().into(), half_width);
                let mut local = Lanes::zeros(matching.layout.blocks());
                for (&slot, position) in matching.layout.slots().iter().zip(&positions) {
                    local.set(slot, position.coords.map(|x| x as f32).into());
                }
                let mut rotations = Lanes::filled(matching.layout.blocks(), crate::state::IDENTITIES);
                let (mut workspace, executor) = (Workspace::default(), Executor::sequential());
                let fitted = RegionFit { positions: &local, rotations: &mut rotations, shapes: Shapes::Rest };
                matching.fit(&mut workspace, &executor, fitted, None, Purpose::Vertices);
                let goals = matching.goals(&workspace, &executor);
                let naive = Naive::new(&lattice, half_width, Regions::Staircase);
                let vectors: Vec<Vector3<f64>> = positions.iter().map(|position| position.coords).collect();
                let expected = naive.goals(&naive.motions(&vectors));
                for (vertex, (&slot, expected)) in matching.layout.slots().iter().zip(&expected).enumerate() {
                    let goal = Vector3::from(goals.get(slot).map(f64::from));
                    assert!(
                        (goal - expected).norm() < 2e-4,
                        "{trial} {half_width} {vertex}: {goal} {expected}"
                    );
                }
            }
        }
    }
}
