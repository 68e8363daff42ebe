//! The measure of a surface mesh: which of its parts count, and where they hang.

use super::VolumeError;
use super::adjacency::Adjacency;
use super::mesh_measure::{MeshMeasure, SurfacePoint};
use super::shells::{self, Shell};
use crate::lattice::{DisjointSets, Embedding, Lattice};
use crate::mesh::Mesh;

/// The least part of the cells' volume that a surface must enclose to be a measure.
const LEAST_SHARE: f64 = 0.01;

/// A surface mesh and its place in the lattice.
#[derive(Clone, Copy, Debug)]
pub struct Surface<'a> {
    /// The mesh at rest, in the frame of the lattice.
    pub mesh: &'a Mesh,
    /// Where each of its vertices lies: one entry a vertex, in their order.
    pub embedding: &'a Embedding,
}

/// The measure `mesh`, if the surface is usable: closed once welded, and not flat.
pub(super) fn measure(
    surface: Option<Surface<'_>>,
    lattice: &Lattice,
    adjacency: &Adjacency,
) -> Result<MeshMeasure, VolumeError> {
    let surface = surface.ok_or(VolumeError::NoMesh)?;
    let open_edges = surface.mesh.topology().open_edges;
    if open_edges > 0 {
        return Err(VolumeError::Open { open_edges });
    }
    let shells = split(surface, adjacency)?;
    let signs = shells::signs(surface.mesh.vertices(), &shells);
    check_volumes(&shells, &signs, lattice, adjacency)?;

    let mut builder = Builder::new(surface);
    let mut counts = vec![0; adjacency.components()];
    for component in 0..adjacency.components() {
        let own = shells.iter().zip(&signs).filter(|(shell, _)| shell.component as usize == component);
        for (shell, &sign) in own.filter(|(_, sign)| **sign != 0.0) {
            counts[component] += shell.triangles.len();
            builder.add(&shell.triangles, sign < 0.0);
        }
    }
    Ok(builder.finish(&counts))
}

/// The connected parts of the welded surface, degenerate triangles left out.
fn split(surface: Surface<'_>, adjacency: &Adjacency) -> Result<Vec<Shell>, VolumeError> {
    let (mesh, weld) = (surface.mesh, surface.mesh.weld());
    let triangles = mesh.triangles().iter().map(|triangle| triangle.map(|corner| weld[corner as usize]));
    let triangles: Vec<[u32; 3]> = triangles.filter(|[a, b, c]| a != b && b != c && c != a).collect();
    let mut sets = DisjointSets::new(weld.len());
    for [a, b, c] in &triangles {
        sets.unite(*a, *b);
        sets.unite(*a, *c);
    }
    let (count, labels) = sets.labels();
    let mut parts = vec![Vec::new(); count];
    for triangle in triangles {
        parts[labels[triangle[0] as usize] as usize].push(triangle);
    }
    let carrier = |corner: u32| adjacency.component(surface.embedding.corners(corner as usize)[0] as usize);
    let mut shells = Vec::new();
    for part in parts.into_iter().filter(|part| !part.is_empty()) {
        let component = carrier(part[0][0]);
        if part.iter().flatten().any(|&corner| carrier(corner) != component) {
            return Err(VolumeError::AcrossComponents);
        }
        shells.push(Shell::new(mesh.vertices(), part, component as u32));
    }
    Ok(shells)
}

fn check_volumes(
    shells: &[Shell],
    signs: &[f64],
    lattice: &Lattice,
    adjacency: &Adjacency,
) -> Result<(), VolumeError> {
    let mut enclosed = vec![0.0; adjacency.components()];
    for (shell, sign) in shells.iter().zip(signs) {
        enclosed[shell.component as usize] += sign * shell.volume;
    }
    let cell_volume = lattice.cell_size().powi(3);
    let mut cells = vec![0.0; adjacency.components()];
    for cell in 0..lattice.cells().len() as u32 {
        cells[adjacency.component(lattice.cell_corners(cell)[0] as usize)] += cell_volume;
    }
    for (component, (&mesh, &cells)) in enclosed.iter().zip(&cells).enumerate() {
        // Also true of NaN.
        if !(mesh > LEAST_SHARE * cells) {
            return Err(VolumeError::Flat { component, mesh, cells });
        }
    }
    Ok(())
}

/// Collects triangles, and the vertices that they use in the order of the cells that hold them.
struct Builder<'a> {
    surface: Surface<'a>,
    triangles: Vec<[u32; 3]>,
}

impl<'a> Builder<'a> {
    fn new(surface: Surface<'a>) -> Self {
        Self { surface, triangles: Vec::new() }
    }

    fn add(&mut self, triangles: &[[u32; 3]], flipped: bool) {
        let turned = |&[a, b, c]: &[u32; 3]| if flipped { [a, c, b] } else { [a, b, c] };
        self.triangles.extend(triangles.iter().map(turned));
    }

    fn finish(mut self, counts: &[usize]) -> MeshMeasure {
        let embedding = self.surface.embedding;
        let mut used: Vec<u32> = self.triangles.iter().flatten().copied().collect();
        used.sort_unstable();
        used.dedup();
        used.sort_by_key(|&vertex| embedding.cell(vertex as usize));
        let mut place = vec![0_u32; self.surface.mesh.vertices().len()];
        for (new, &vertex) in used.iter().enumerate() {
            place[vertex as usize] = new as u32;
        }
        for corner in self.triangles.iter_mut().flatten() {
            *corner = place[*corner as usize];
        }
        let point = |&vertex: &u32| SurfacePoint {
            corners: embedding.corners(vertex as usize),
            local: embedding.local(vertex as usize),
        };
        MeshMeasure::new(used.iter().map(point).collect(), self.triangles, counts)
    }
}
