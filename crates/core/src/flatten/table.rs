//! The tables of a body that its flattening reads.

use nalgebra::Point3;

use crate::lattice::{Embedding, Lattice, Stencil};
use crate::mesh::{Csr, Mesh};
use crate::skin::vertex_normals;

/// Ranks, normals, stencils and triangles of the mesh of a body in its lattice.
#[derive(Clone, Debug)]
pub(crate) struct FlattenTable {
    /// Rank of each mesh vertex.
    pub(crate) ranks: Vec<u32>,
    /// Mesh vertex of each rank.
    pub(crate) vertices: Vec<u32>,
    /// Local coordinates of the mesh vertex of each rank in its cell.
    pub(super) local: Vec<[f32; 3]>,
    /// Outward unit normal of the mesh vertex of each rank at rest, in the frame of the lattice.
    pub(super) normals: Vec<[f32; 3]>,
    /// Least and greatest components of the normals in each cell of [`Embedding::by_cell`].
    pub(super) normal_ranges: Vec<[[f32; 3]; 2]>,
    /// The neighbors of each lattice vertex.
    pub(super) stencils: Vec<Stencil>,
    /// Component of each lattice vertex.
    pub(crate) components: Vec<u32>,
    /// Number of components.
    pub(super) component_count: usize,
    /// Distance in cells by which mesh vertices may be outside the boxes of their cells if the skin is linear.
    pub(super) outside: f32,
    /// Ranks of the corners of each triangle of the mesh, with welded vertices as one.
    pub(crate) corners: Vec<[u32; 3]>,
    /// The triangles at the mesh vertex of each rank, as indices into `corners`.
    pub(crate) triangles: Csr<u32>,
}

impl FlattenTable {
    pub(crate) fn new(mesh: &Mesh, embedding: &Embedding, lattice: &Lattice) -> Self {
        let vertices: Vec<u32> = embedding.by_cell().flat_map(|cell| cell.points).copied().collect();
        let mut ranks = vec![0; vertices.len()];
        (0..).zip(&vertices).for_each(|(rank, &vertex)| ranks[vertex as usize] = rank);
        let rest = |point: &Point3<f64>| <[f64; 3]>::from((point - lattice.origin()) / lattice.cell_size());
        let rest: Vec<_> = mesh.vertices().iter().map(|point| rest(point).map(|x| x as f32)).collect();
        let mut normals = vec![[0.0; 3]; rest.len()];
        vertex_normals(mesh.surface(), &rest, mesh.weld(), &mut normals);
        if mesh.topology().is_flipped() {
            normals.as_flattened_mut().iter_mut().for_each(|x| *x = -*x);
        }
        let rank = |corner: u32| ranks[mesh.weld()[corner as usize] as usize];
        let corners: Vec<_> = mesh.surface().iter().map(|triangle| triangle.map(rank)).collect();
        let at_ranks = (0..).zip(&corners).flat_map(|(triangle, ranks)| ranks.map(|rank| (rank, triangle)));
        // The position continues linearly outside a cell; along each axis, the lattice is stretched to less than twice
        // its size.
        let outside = (0..ranks.len()).map(|point| {
            embedding.local(point).iter().map(|x| 2.0 * (x - x.clamp(0.0, 1.0)).abs()).sum::<f32>()
        });
        let normals: Vec<_> = vertices.iter().map(|&vertex| normals[vertex as usize]).collect();
        let mut first = 0;
        let normal_range = |points: usize| {
            let group = &normals[first..first + points];
            first += points;
            [f32::min, f32::max].map(|either| {
                group
                    .iter()
                    .copied()
                    .reduce(|a, b| std::array::from_fn(|k| either(a[k], b[k])))
                    .unwrap_or_default()
            })
        };
        Self {
            normal_ranges: embedding.by_cell().map(|cell| cell.points.len()).map(normal_range).collect(),
            triangles: Csr::sorted(ranks.len(), at_ranks),
            local: vertices.iter().map(|&vertex| embedding.local(vertex as usize)).collect(),
            outside: outside.fold(0.0, f32::max),
            normals,
            stencils: (0..lattice.len() as u32).map(|vertex| Stencil::new(lattice, vertex)).collect(),
            components: lattice.components().of_vertex.clone(),
            component_count: lattice.components().count,
            corners,
            ranks,
            vertices,
        }
    }

    /// Returns the memory in bytes.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&*self.ranks)
            + size_of_val(&*self.vertices)
            + size_of_val(&*self.local)
            + size_of_val(&*self.normals)
            + size_of_val(&*self.normal_ranges)
            + size_of_val(&*self.stencils)
            + size_of_val(&*self.components)
            + size_of_val(&*self.corners)
            + self.triangles.bytes()
    }
}
