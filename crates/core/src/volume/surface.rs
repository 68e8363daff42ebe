//! Construction of the measure `mesh` from a surface mesh: validation, shells, orientation, patches.

use super::VolumeError;
use super::adjacency::Adjacency;
use super::mesh_measure::{MIN_PATCH_TRIANGLES, MeshMeasure, Parts, Patch};
use super::shells::{self, Shell};
use crate::lattice::{Embedding, Lattice};
use crate::mesh::{Mesh, UnionFind};

/// Least volume that a surface must enclose, as a fraction of the volume of the cells.
const MIN_VOLUME_FRACTION: f64 = 0.01;

/// Surface mesh and its embedding in the lattice.
#[derive(Clone, Copy, Debug)]
pub struct Surface<'a> {
    /// Mesh at rest, in the frame of the lattice.
    pub mesh: &'a Mesh,
    /// Embedding of the mesh vertices: one entry per vertex, in vertex order.
    pub embedding: &'a Embedding,
}

/// Creates the measure `mesh`. The welded surface must be closed, and must not be flat.
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
        let oriented = own.filter(|(_, sign)| **sign != 0.0).flat_map(|(shell, &sign)| {
            shell.triangles.iter().map(move |&[a, b, c]| if sign < 0.0 { [a, c, b] } else { [a, b, c] })
        });
        add_component(surface.embedding, oriented.collect(), &mut parts);
    }
    let points = number_points(surface.embedding, &mut parts.triangles);
    Ok(MeshMeasure::new(parts, &points, surface.embedding))
}

/// Adds the triangles of one component: patches for cells with many triangles, the other triangles by cell.
fn add_component(embedding: &Embedding, mut triangles: Vec<[u32; 3]>, parts: &mut Parts) {
    let cell = |corner: u32| embedding.cell(corner as usize);
    // Sort key: the cell, and whether the triangle leaves it. A triangle that crosses cells has the key of
    // the last of its cells, after the triangles inside that cell.
    let outside = |corner: &u32| embedding.local(*corner as usize).iter().any(|x| !(0.0..=1.0).contains(x));
    let key = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(cell);
        (a.max(b).max(c), a != b || b != c || triangle.iter().any(outside))
    };
    triangles.sort_by_cached_key(key);
    let (patches, others) = (parts.patches.len(), parts.triangles.len());
    for group in triangles.chunk_by(|a, b| key(a) == key(b)) {
        let (_, leaves) = key(&group[0]);
        if leaves || group.len() < MIN_PATCH_TRIANGLES {
            parts.triangles.extend_from_slice(group);
        } else {
            let places = group.iter().map(|triangle| triangle.map(|corner| embedding.local(corner as usize)));
            parts.patches.push(Patch::new(embedding.corners(group[0][0] as usize), places));
        }
    }
    parts.patch_counts.push(parts.patches.len() - patches);
    parts.triangle_counts.push(parts.triangles.len() - others);
}

/// Renumbers the triangles' corners in the order of their cells; returns the mesh vertex of each new number.
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

/// Returns the connected components of the welded surface, without degenerate triangles.
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
    let component_of =
        |corner: u32| adjacency.component(surface.embedding.corners(corner as usize)[0] as usize);
    let mut shells = Vec::new();
    for part in parts.into_iter().filter(|part| !part.is_empty()) {
        let component = component_of(part[0][0]);
        if part.iter().flatten().any(|&corner| component_of(corner) != component) {
            return Err(VolumeError::AcrossComponents);
        }
        shells.push(Shell::new(mesh.vertices(), part, component as u32));
    }
    Ok(shells)
}

/// Checks that the surface of each component encloses enough volume; see [`MIN_VOLUME_FRACTION`].
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
        if mesh <= MIN_VOLUME_FRACTION * cells {
            return Err(VolumeError::Flat { component, mesh, cells });
        }
    }
    Ok(())
}
