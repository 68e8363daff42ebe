//! Points that are embedded in the cells of a lattice and move with the cells.

use nalgebra::{Point3, Vector3};

use super::Lattice;
use super::nearest::RunTree;
use super::slopes::{Slopes, Smoothing};
use super::smooth::SmoothCell;
use super::trilinear;
use crate::mesh::Csr;
use crate::simd::xyzx::{Xyzx, xyzx};

/// Points embedded in the cells of a lattice, whose positions follow from the positions of the lattice vertices.
///
/// A point belongs to an occupied cell that contains it, boundary included. A point outside all occupied
/// cells, such as a mesh vertex that no face uses, belongs to the nearest cell and follows its motion by
/// extrapolation.
///
/// By default the position of a point is trilinear in its cell: a weighted mean of the eight corners. After
/// [`Embedding::smoothed`] it is smooth across the faces of the cells.
#[derive(Clone, Debug, PartialEq)]
pub struct Embedding {
    /// Local coordinates of each point: relative to corner 0 of its cell, in cells.
    local: Vec<[f32; 3]>,
    /// Index in `groups` of the cell of each point.
    group: Vec<u32>,
    /// The cells that contain points, in ascending order.
    groups: Vec<Group>,
    /// The points in the cell of each group, in ascending order.
    members: Csr<u32>,
    /// `None` if positions are trilinear.
    smoothing: Option<Smoothing>,
}

/// A cell that contains points.
#[derive(Clone, Debug, PartialEq)]
struct Group {
    cell: u32,
    corners: [u32; 8],
}

/// The points of one cell.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct CellPoints<'a> {
    /// Index of the cell.
    pub cell: u32,
    /// The lattice vertices at the corners of the cell, in the order of [`Lattice::cell_corners`].
    pub corners: &'a [u32; 8],
    /// Indices of the points, in ascending order; at least one.
    pub points: &'a [u32],
}

/// Finds the cell of a point.
pub(crate) struct Locator<'a> {
    lattice: &'a Lattice,
    /// Search tree for points outside all occupied cells. Built for the first such point.
    tree: Option<RunTree>,
}

impl<'a> Locator<'a> {
    pub(crate) fn new(lattice: &'a Lattice) -> Self {
        Self { lattice, tree: None }
    }

    /// Returns the cell of a point, given in the model frame, and its local coordinates: relative to corner 0
    /// of the cell, in cells. See [`Embedding`] for points outside all occupied cells.
    pub(crate) fn locate(&mut self, point: &Point3<f64>) -> (u32, [f32; 3]) {
        let Self { lattice, tree } = self;
        let cells = &lattice.cell_set;
        let position = ((point - lattice.origin) / lattice.cell_size).into();
        let cell = cells
            .locate(position)
            .unwrap_or_else(|| tree.get_or_insert_with(|| RunTree::new(cells)).nearest_cell(cells, position));
        (cell, local_in(lattice, cell, point))
    }
}

/// Returns the local coordinates of a point in a cell.
fn local_in(lattice: &Lattice, cell: u32, point: &Point3<f64>) -> [f32; 3] {
    let (position, corner) = ((point - lattice.origin) / lattice.cell_size, lattice.cells[cell as usize]);
    std::array::from_fn(|a| (position[a] - f64::from(corner[a])) as f32)
}

impl Embedding {
    /// Embeds points, given by their rest positions in the model frame.
    ///
    /// A point with a coordinate that is not finite is assigned to some cell; its local coordinates are not
    /// finite.
    pub fn new(lattice: &Lattice, points: &[Point3<f64>]) -> Self {
        let mut locator = Locator::new(lattice);
        let (cell_of, local): (Vec<u32>, Vec<_>) = points.iter().map(|point| locator.locate(point)).unzip();
        Self::grouped(lattice, &cell_of, local)
    }

    /// Embeds points in given cells, which need not contain them: a point outside its cell follows the cell by
    /// extrapolation.
    pub(crate) fn in_cells(lattice: &Lattice, points: &[Point3<f64>], cells: &[u32]) -> Self {
        let local = |(point, &cell): (&Point3<f64>, &u32)| local_in(lattice, cell, point);
        Self::grouped(lattice, cells, points.iter().zip(cells).map(local).collect())
    }

    /// Builds the embedding from the cell and the local coordinates of each point.
    fn grouped(lattice: &Lattice, cell_of: &[u32], local: Vec<[f32; 3]>) -> Self {
        let of_cells = Csr::sorted(lattice.cells.len(), cell_of.iter().copied().zip(0..));
        let (mut group, mut groups) = (vec![0; cell_of.len()], Vec::new());
        let mut members = Csr::with_capacity(0, cell_of.len());
        for (cell, points) in (0..).zip(of_cells.rows()).filter(|(_, points)| !points.is_empty()) {
            points.iter().for_each(|&point: &u32| group[point as usize] = groups.len() as u32);
            groups.push(Group { cell, corners: lattice.cell_corners(cell) });
            members.push(points.iter().copied());
        }
        Self { local, group, groups, members, smoothing: None }
    }

    /// Makes the positions of the points smooth: their first derivatives are continuous across the faces of the cells,
    /// except where the lattice is bent so strongly that smooth positions could fold the mesh.
    #[must_use]
    pub fn smoothed(mut self, lattice: &Lattice) -> Self {
        self.smoothing = Some(Smoothing::new(lattice, self.groups.iter().map(|group| group.corners)));
        self
    }

    /// Returns the stencils of smooth positions, or `None` if positions are trilinear.
    pub(crate) fn smoothing(&self) -> Option<&Smoothing> {
        self.smoothing.as_ref()
    }

    /// Returns the number of points.
    pub fn len(&self) -> usize {
        self.local.len()
    }

    /// Returns whether there are no points.
    #[cfg(feature = "internals")]
    pub fn is_empty(&self) -> bool {
        self.local.is_empty()
    }

    /// Returns the cell of a point.
    ///
    /// # Panics
    ///
    /// If the point does not exist. Every function with a `point` argument panics in this case.
    pub fn cell(&self, point: usize) -> u32 {
        self.group_of(point).cell
    }

    /// Returns the local coordinates of a point: relative to corner 0 of its cell, in cells.
    ///
    /// They are between 0 and 1. They can be outside this range by up to 0.002 for points near a grid plane,
    /// and by any amount for points outside all occupied cells.
    pub fn local(&self, point: usize) -> [f32; 3] {
        self.local[point]
    }

    /// Returns the lattice vertices at the corners of a point's cell.
    pub fn corners(&self, point: usize) -> [u32; 8] {
        self.group_of(point).corners
    }

    /// Returns the trilinear weights of the eight corners of a point's cell; their sum is 1.
    ///
    /// The weights are trilinear in the cell and continue linearly outside it, so that the position of a
    /// distant point does not depend on the cube of its distance.
    pub fn weights(&self, point: usize) -> [f32; 8] {
        trilinear::weights(self.local[point])
    }

    fn group_of(&self, point: usize) -> &Group {
        &self.groups[self.group[point] as usize]
    }

    /// Iterates over the cells that contain points, in ascending order, each with its points.
    pub fn by_cell(&self) -> impl ExactSizeIterator<Item = CellPoints<'_>> {
        let groups = self.groups.iter().zip(self.members.rows());
        groups.map(|(Group { cell, corners }, points)| CellPoints { cell: *cell, corners, points })
    }

    /// Writes the positions of the points to `points`, given the positions of the lattice vertices.
    ///
    /// The results are in the frame and unit of `vertices`.
    ///
    /// * `vertices`: one position per lattice vertex, in vertex order, shape `(n, 3)`.
    /// * `points`: output, one position per embedded point, shape `(k, 3)`.
    ///
    /// # Panics
    ///
    /// If `vertices` has fewer entries than the lattice, or if the length of `points` is not
    /// [`Embedding::len`].
    #[cfg(feature = "internals")]
    pub fn interpolate(&self, vertices: &[[f32; 3]], points: &mut [[f32; 3]]) {
        self.interpolate_rates(vertices, vertices, points);
    }

    /// Writes the velocities of the points to `points`: the derivative of their positions for the velocities `rates` of
    /// the lattice vertices at `vertices`. The weights of smooth positions are those at `vertices`, without their change.
    ///
    /// Shapes and panics are those of [`Embedding::interpolate`].
    pub(crate) fn interpolate_rates(
        &self,
        vertices: &[[f32; 3]],
        rates: &[[f32; 3]],
        points: &mut [[f32; 3]],
    ) {
        assert_eq!(points.len(), self.len(), "one output per embedded point");
        let rates: Vec<Xyzx> = rates.iter().copied().map(xyzx).collect();
        let (mut slopes, mut slope_weights) = (Vec::new(), super::slopes::SlopeWeights::default());
        if let Some(smoothing) = &self.smoothing {
            smoothing.update_slopes(&rates, &mut slopes);
            smoothing.update_slope_weights(vertices, &mut slope_weights);
        }
        let slopes = self
            .smoothing
            .as_ref()
            .map(|_| Slopes { slopes: &slopes, slope_weights: slope_weights.values() });
        for CellPoints { corners, points: members, .. } in self.by_cell() {
            let map = PointMap::new(corners, &rates, slopes);
            for &point in members {
                points[point as usize] = map.at(self.local[point as usize]);
            }
        }
    }

    /// Returns the position of one point. `lattice`: the positions of the lattice vertices; `slopes`: their slopes, or
    /// `None` for a trilinear position. The result is in the frame and unit of `lattice`.
    pub(crate) fn position(&self, point: usize, lattice: &[Xyzx], slopes: Option<Slopes<'_>>) -> Xyzx {
        xyzx(PointMap::new(&self.group_of(point).corners, lattice, slopes).at(self.local[point]))
    }

    /// Returns the memory of the embedding, in bytes.
    pub fn memory(&self) -> usize {
        let point = size_of::<[f32; 3]>() + 2 * size_of::<u32>();
        let group = size_of::<Group>() + size_of::<u32>();
        let smoothing = self.smoothing.as_ref().map_or(0, Smoothing::bytes);
        self.len() * point + self.groups.len() * group + smoothing + size_of::<Self>()
    }
}

/// The map from the local coordinates of one deformed cell to positions, in and outside the cell. Outside it is linear.
#[expect(clippy::large_enum_variant, reason = "a map is short-lived and stays on the stack")]
pub(crate) enum PointMap {
    Trilinear(trilinear::CellMap),
    Smooth(SmoothCell),
}

impl PointMap {
    /// Builds the map of a cell. `corners`: lattice vertices at the corners of the cell. `lattice`: the positions of
    /// the lattice vertices. `slopes`: their slopes, or `None` for the trilinear map.
    pub(crate) fn new(corners: &[u32; 8], lattice: &[Xyzx], slopes: Option<Slopes<'_>>) -> Self {
        let xyz = |[x, y, z, _]: Xyzx| [x, y, z];
        let positions = corners.map(|corner| xyz(lattice[corner as usize]));
        match slopes {
            None => Self::Trilinear(trilinear::CellMap::new(positions)),
            Some(Slopes { slopes, slope_weights }) => Self::Smooth(SmoothCell::new(
                positions.map(Vector3::from),
                corners.map(|corner| slopes[corner as usize].map(|slope| xyz(slope).into())),
                corners.map(|corner| slope_weights[corner as usize]),
            )),
        }
    }

    /// Returns the position at local coordinates.
    pub(crate) fn at(&self, local: [f32; 3]) -> [f32; 3] {
        match self {
            Self::Trilinear(map) => map.at(local),
            Self::Smooth(map) => map.at(local).into(),
        }
    }
}
