//! The tables of a body that its flattening reads.

use nalgebra::{Point3, Vector3};

use crate::lattice::{CellPoints, Embedding, Lattice, Stencil, trilinear_weights};
use crate::mesh::Mesh;
use crate::skin::vertex_normals;

/// Greatest number of mesh vertices of a cell that are used: it bounds the run time for dense meshes.
const MOST_POINTS: usize = 12;

/// Number of entries of the upper triangle of an 8 x 8 matrix.
const TRIANGLE: usize = 36;

/// Normals, stencils and weights of the mesh of a body in its lattice.
#[derive(Clone, Debug)]
pub(crate) struct FlattenTable {
    /// Outward unit normal of each mesh vertex at rest, in the frame of the lattice.
    pub(super) normals: Vec<[f32; 3]>,
    /// The neighbors of each lattice vertex.
    pub(super) stencils: Vec<Stencil>,
    /// The corners of the cells with mesh vertices, in the order of [`Embedding::by_cell`].
    pub(super) corners: Vec<[u32; 8]>,
    /// The mesh vertices of each of these cells that are used, in increasing order.
    points: Vec<u32>,
    /// First entry of each cell in `points`, then the number of entries.
    first: Vec<u32>,
    /// For each of these cells: the mean of w wᵀ over the vertices that are used with the weights w, as the rows of its upper
    /// triangle.
    products: Vec<[f32; TRIANGLE]>,
    /// Component of each lattice vertex.
    pub(super) components: Vec<u32>,
    /// Number of components.
    pub(super) count: usize,
}

impl FlattenTable {
    pub(crate) fn new(mesh: &Mesh, embedding: &Embedding, lattice: &Lattice) -> Self {
        let rest = |point: &Point3<f64>| <[f64; 3]>::from((point - lattice.origin()) / lattice.cell_size());
        let rest: Vec<_> = mesh.vertices().iter().map(|point| rest(point).map(|x| x as f32)).collect();
        let mut normals = vec![[0.0; 3]; rest.len()];
        vertex_normals(mesh.triangles(), &rest, mesh.weld(), &mut normals);
        if mesh.topology().is_flipped() {
            normals.as_flattened_mut().iter_mut().for_each(|x| *x = -*x);
        }
        let product = |points: &[u32]| {
            let mut sums = [0.0; TRIANGLE];
            for &point in points {
                let w = trilinear_weights(embedding.local(point as usize)).map(f64::from);
                let mut entries = sums.iter_mut();
                for i in 0..8 {
                    w[i..].iter().zip(&mut entries).for_each(|(wj, sum)| *sum += w[i] * wj);
                }
            }
            sums.map(|sum| (sum / points.len() as f64) as f32)
        };
        let (mut used, mut first, mut products) = (Vec::new(), vec![0], Vec::new());
        for CellPoints { points, .. } in embedding.by_cell() {
            let count = points.len().min(MOST_POINTS);
            used.extend((0..count).map(|k| points[k * points.len() / count]));
            products.push(product(&used[first[first.len() - 1] as usize..]));
            first.push(used.len() as u32);
        }
        Self {
            normals,
            stencils: (0..lattice.len() as u32).map(|vertex| Stencil::new(lattice, vertex)).collect(),
            corners: embedding.by_cell().map(|cell| *cell.corners).collect(),
            points: used,
            first,
            products,
            components: lattice.components().of_vertex.clone(),
            count: lattice.components().count,
        }
    }

    /// Returns the memory in bytes.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&*self.normals)
            + size_of_val(&*self.stencils)
            + size_of_val(&*self.corners)
            + size_of_val(&*self.points)
            + size_of_val(&*self.first)
            + size_of_val(&*self.products)
            + size_of_val(&*self.components)
    }

    /// Returns the mesh vertices of a cell that are used, in increasing order; at least one.
    pub(super) fn points(&self, cell: u32) -> &[u32] {
        &self.points[self.first[cell as usize] as usize..self.first[cell as usize + 1] as usize]
    }

    /// Returns the derivatives of the positions of a lattice, in cells, along the axes of its rest shape at a vertex.
    pub(super) fn derivatives(&self, vertex: u32, positions: &[[f32; 3]]) -> [Vector3<f32>; 3] {
        self.stencils[vertex as usize].slopes(|vertex| Vector3::from(positions[vertex as usize]))
    }

    /// Multiplies the mean of w wᵀ of a cell by the vectors at its corners.
    #[inline]
    pub(super) fn multiply(&self, cell: usize, vectors: &[[f32; 4]; 8]) -> [[f32; 4]; 8] {
        let mut sums = [[0.0; 4]; 8];
        let mut entries = self.products[cell].iter();
        for i in 0..8 {
            for (j, entry) in (i..8).zip(&mut entries) {
                for k in 0..4 {
                    sums[i][k] += entry * vectors[j][k];
                    if j != i {
                        sums[j][k] += entry * vectors[i][k];
                    }
                }
            }
        }
        sums
    }

    /// Returns the diagonal of the mean of w wᵀ of a cell.
    pub(super) fn diagonal(&self, cell: usize) -> [f32; 8] {
        let mut first = 0;
        std::array::from_fn(|i| {
            let entry = self.products[cell][first];
            first += 8 - i;
            entry
        })
    }
}
