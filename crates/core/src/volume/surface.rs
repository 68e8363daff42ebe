//! The measure of a surface mesh: which of its parts count, and where they hang.

use super::VolumeError;
use super::adjacency::Adjacency;
use super::mesh_measure::{MeshMeasure, Parts, Patch, WORTHWHILE};
use super::shells::{self, Shell};
use crate::lattice::{Embedding, Lattice};
use crate::mesh::{Mesh, UnionFind};

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

    let mut parts = Parts::default();
    for component in 0..adjacency.components {
        let own = shells.iter().zip(&signs).filter(|(shell, _)| shell.component as usize == component);
        let turned = own.filter(|(_, sign)| **sign != 0.0).flat_map(|(shell, &sign)| {
            shell.triangles.iter().map(move |&[a, b, c]| if sign < 0.0 { [a, c, b] } else { [a, b, c] })
        });
        gather(surface.embedding, turned.collect(), &mut parts);
    }
    let points = number_points(surface.embedding, &mut parts.triangles);
    Ok(MeshMeasure::new(parts, &points, surface.embedding))
}

/// Adds the triangles of one component: patches of cells that hold many, the others one by one, cell by cell.
fn gather(embedding: &Embedding, mut triangles: Vec<[u32; 3]>, parts: &mut Parts) {
    let cell = |corner: u32| embedding.cell(corner as usize);
    // Those that cross from cell to cell, or leave theirs, go with the last of their cells, after those that lie in it.
    let outside = |corner: &u32| embedding.local(*corner as usize).iter().any(|x| !(0.0..=1.0).contains(x));
    let place = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(cell);
        (a.max(b).max(c), a != b || b != c || triangle.iter().any(outside))
    };
    triangles.sort_by_cached_key(place);
    let (patches, others) = (parts.patches.len(), parts.triangles.len());
    for group in triangles.chunk_by(|a, b| place(a) == place(b)) {
        let (_, leaves) = place(&group[0]);
        if leaves || group.len() < WORTHWHILE {
            parts.triangles.extend_from_slice(group);
        } else {
            let places = group.iter().map(|triangle| triangle.map(|corner| embedding.local(corner as usize)));
            parts.patches.push(Patch::new(embedding.corners(group[0][0] as usize), places));
        }
    }
    parts.patch_counts.push(parts.patches.len() - patches);
    parts.triangle_counts.push(parts.triangles.len() - others);
}

/// Renumbers the corners of single triangles. Returns the mesh vertices that they are, in the order of their cells.
fn number_points(embedding: &Embedding, triangles: &mut [[u32; 3]]) -> Vec<u32> {
    let mut used: Vec<u32> = triangles.iter().flatten().copied().collect();
    used.sort_unstable();
    used.dedup();
    used.sort_by_key(|&vertex| embedding.cell(vertex as usize));
    let mut number = vec![0_u32; embedding.len()];
    for (new, &vertex) in used.iter().enumerate() {
        number[vertex as usize] = new as u32;
    }
    for corner in triangles.iter_mut().flatten() {
        *corner = number[*corner as usize];
    }
    used
}

/// The connected parts of the welded surface, degenerate triangles left out.
fn split(surface: Surface<'_>, adjacency: &Adjacency) -> Result<Vec<Shell>, VolumeError> {
    let (mesh, weld) = (surface.mesh, surface.mesh.weld());
    let triangles = mesh.triangles().iter().map(|triangle| triangle.map(|corner| weld[corner as usize]));
    let triangles: Vec<[u32; 3]> = triangles.filter(|[a, b, c]| a != b && b != c && c != a).collect();
    let mut sets = UnionFind::new(weld.len());
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
    let mut enclosed = vec![0.0; adjacency.components];
    for (shell, sign) in shells.iter().zip(signs) {
        enclosed[shell.component as usize] += sign * shell.volume;
    }
    let cell_volume = lattice.cell_size().powi(3);
    let mut cells = vec![0.0; adjacency.components];
    for cell in 0..lattice.cells().len() as u32 {
        cells[adjacency.component(lattice.cell_corners(cell)[0] as usize)] += cell_volume;
    }
    for (component, (&mesh, &cells)) in enclosed.iter().zip(&cells).enumerate() {
        if mesh <= LEAST_SHARE * cells {
            return Err(VolumeError::Flat { component, mesh, cells });
        }
    }
    Ok(())
}
