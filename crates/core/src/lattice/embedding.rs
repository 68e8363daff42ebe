//! Points embedded in the cells of a lattice, which carry them along.

use nalgebra::Point3;

use super::Lattice;
use super::nearest::RunTree;
use super::trilinear;
use crate::mesh::Csr;
use crate::simd::xyzx::{Xyzx, xyzx};

/// Points embedded in the cells of a lattice: each is a weighted mean of the eight corners of its cell.
///
/// A point belongs to an occupied cell that holds it, boundary included. A point that no occupied cell holds, such as a vertex of a mesh
/// that no face uses, belongs to the nearest one, whose motion it follows from outside.
#[derive(Clone, Debug, PartialEq)]
pub struct Embedding {
    /// Coordinates within the cell of each point.
    local: Vec<[f32; 3]>,
    /// Group of each point.
    group: Vec<u32>,
    /// The cells that hold points, in order.
    groups: Vec<Group>,
    /// The points of each of them, rising.
    members: Csr<u32>,
}

/// A cell that holds points.
#[derive(Clone, Debug, PartialEq)]
struct Group {
    cell: u32,
    corners: [u32; 8],
}

/// The points of one cell.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct CellPoints<'a> {
    /// Number of the cell.
    pub cell: u32,
    /// The lattice vertices at its corners, in their order.
    pub corners: &'a [u32; 8],
    /// Numbers of the points, rising; at least one.
    pub points: &'a [u32],
}

impl Embedding {
    /// Embeds points given in the model frame, at rest.
    ///
    /// A point with a coordinate that is not finite belongs to some cell, and its coordinates there are not finite either.
    pub fn new(lattice: &Lattice, points: &[Point3<f64>]) -> Self {
        let cells = &lattice.cell_set;
        let mut tree = None;
        let mut cell_of = Vec::with_capacity(points.len());
        let mut local = Vec::with_capacity(points.len());
        for point in points {
            let place: [f64; 3] = ((point - lattice.origin) / lattice.cell_size).into();
            let cell = cells.locate(place).unwrap_or_else(|| {
                tree.get_or_insert_with(|| RunTree::new(cells)).nearest_cell(cells, place)
            });
            let corner = lattice.cells[cell as usize];
            local.push(std::array::from_fn(|a| (place[a] - f64::from(corner[a])) as f32));
            cell_of.push(cell);
        }
        Self::grouped(lattice, &cell_of, local)
    }

    fn grouped(lattice: &Lattice, cell_of: &[u32], local: Vec<[f32; 3]>) -> Self {
        let order = Csr::sorted(lattice.cells.len(), cell_of.iter().copied().zip(0..)).into_items();
        let (mut group, mut groups, mut starts) = (vec![0; cell_of.len()], Vec::new(), vec![0]);
        for members in order.chunk_by(|&a, &b| cell_of[a as usize] == cell_of[b as usize]) {
            members.iter().for_each(|&point| group[point as usize] = groups.len() as u32);
            let cell = cell_of[members[0] as usize];
            groups.push(Group { cell, corners: lattice.cell_corners(cell) });
            starts.push(starts[starts.len() - 1] + members.len() as u32);
        }
        Self { local, group, groups, members: Csr::from_parts(starts, order) }
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.local.len()
    }

    /// Whether there is no point.
    pub fn is_empty(&self) -> bool {
        self.local.is_empty()
    }

    /// The cell of a point.
    ///
    /// # Panics
    ///
    /// If there is no such point, as all that take one.
    pub fn cell(&self, point: usize) -> u32 {
        self.group_of(point).cell
    }

    /// Where a point lies in its cell, in cells from corner 0: between 0 and 1, or up to 0.002 outside where the surface all but lay in
    /// a grid plane, or anywhere for a point that no occupied cell holds.
    pub fn local(&self, point: usize) -> [f32; 3] {
        self.local[point]
    }

    /// The lattice vertices at the corners of a point's cell.
    pub fn corners(&self, point: usize) -> [u32; 8] {
        self.group_of(point).corners
    }

    /// The weights of the eight corners of a point's cell; their sum is 1. Trilinear within the cell, continued linearly outside, so
    /// that a point far away is not thrown about by the third power of its distance.
    pub fn weights(&self, point: usize) -> [f32; 8] {
        trilinear::weights(self.local[point])
    }

    fn group_of(&self, point: usize) -> &Group {
        &self.groups[self.group[point] as usize]
    }

    /// The cells that hold points, in the order of the cells, each with its points.
    pub fn by_cell(&self) -> impl ExactSizeIterator<Item = CellPoints<'_>> {
        let groups = self.groups.iter().zip(self.members.rows());
        groups.map(|(Group { cell, corners }, points)| CellPoints { cell: *cell, corners, points })
    }

    /// Where the points are, given where the lattice vertices are, in any frame and unit.
    ///
    /// * `vertices`: one per lattice vertex, in vertex order, shape `(n, 3)`.
    /// * `points`: one per embedded point, written to, shape `(k, 3)`.
    ///
    /// # Panics
    ///
    /// If `vertices` is shorter than the lattice's, or `points` has another length than the embedding.
    pub fn interpolate(&self, vertices: &[[f32; 3]], points: &mut [[f32; 3]]) {
        assert_eq!(points.len(), self.len(), "one output per embedded point");
        for CellPoints { corners, points: inside, .. } in self.by_cell() {
            let map = trilinear::CellMap::new(corners.map(|corner| vertices[corner as usize]));
            for &point in inside {
                points[point as usize] = map.at(self.local[point as usize]);
            }
        }
    }

    /// Where one point is.
    pub(crate) fn extrapolated(&self, point: usize, lattice: &[Xyzx]) -> Xyzx {
        extrapolate(&self.group_of(point).corners, lattice, self.local[point])
    }

    /// Bytes of memory that the embedding takes.
    pub fn memory(&self) -> usize {
        let point = size_of::<[f32; 3]>() + 2 * size_of::<u32>();
        let group = size_of::<Group>() + size_of::<u32>();
        self.len() * point + self.groups.len() * group + size_of::<Self>()
    }
}

/// Where a place in a cell with these corners is taken, within or outside.
pub(crate) fn extrapolate(corners: &[u32; 8], lattice: &[Xyzx], place: [f32; 3]) -> Xyzx {
    let corners = corners.map(|corner| {
        let [x, y, z, _] = lattice[corner as usize];
        [x, y, z]
    });
    xyzx(trilinear::CellMap::new(corners).at(place))
}
