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
    /// Outward unit normal of the mesh vertex of each rank at rest, in the frame of the lattice.
    pub(super) normals: Vec<[f32; 3]>,
    /// The neighbors of each lattice vertex.
    pub(super) stencils: Vec<Stencil>,
    /// Component of each lattice vertex.
    pub(crate) components: Vec<u32>,
    /// Number of components.
    pub(super) component_count: usize,
    /// The triangles at the mesh vertex of each rank, as indices into [`Mesh::triangles`]. Those of welded vertices are
    /// at the vertex to which they are welded.
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
        vertex_normals(mesh.triangles(), &rest, mesh.weld(), &mut normals);
        if mesh.topology().is_flipped() {
            normals.as_flattened_mut().iter_mut().for_each(|x| *x = -*x);
        }
        let corner = |&corner: &u32| ranks[mesh.weld()[corner as usize] as usize];
        let corners = (0..)
            .zip(mesh.triangles())
            .flat_map(|(triangle, corners)| corners.iter().map(move |vertex| (corner(vertex), triangle)));
        Self {
            triangles: Csr::sorted(ranks.len(), corners),
            normals: vertices.iter().map(|&vertex| normals[vertex as usize]).collect(),
            stencils: (0..lattice.len() as u32).map(|vertex| Stencil::new(lattice, vertex)).collect(),
            components: lattice.components().of_vertex.clone(),
            component_count: lattice.components().count,
            ranks,
            vertices,
        }
    }

    /// Returns the memory in bytes.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&*self.ranks)
            + size_of_val(&*self.vertices)
            + size_of_val(&*self.normals)
            + size_of_val(&*self.stencils)
            + size_of_val(&*self.components)
            + self.triangles.bytes()
    }
}
