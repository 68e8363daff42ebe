//! Builds the measure `mesh` from a surface mesh: validation, shells, orientation, patches.
//!
//! A shell is a connected component of the welded surface, that is, the surface in which vertices at equal
//! positions are merged.

use super::VolumeError;
use super::adjacency::{Adjacency, Corners};
use super::mesh_measure::{MeshMeasure, MeshTerms};
use super::patch::{MIN_PATCH_TRIANGLES, Patch};
use super::shells::{self, Shell};
use crate::lattice::{Embedding, Lattice};
use crate::mesh::{Csr, Mesh, UnionFind};

/// The surface in a component must enclose more than this fraction of the volume of the component's cells. Otherwise it
/// counts as enclosing nothing.
pub(crate) const MIN_VOLUME_FRACTION: f64 = 0.01;

/// Surface mesh and its embedding in the lattice.
#[derive(Clone, Copy, Debug)]
pub struct Surface<'a> {
    /// Mesh at rest, in the frame of the lattice.
    pub mesh: &'a Mesh,
    /// Embedding of the mesh vertices: one entry per vertex, in vertex order.
    pub embedding: &'a Embedding,
}

/// Creates the measure `mesh`.
///
/// # Errors
/// Returns an error without a surface, if the welded surface is not closed, if a shell lies in several
/// components of the lattice, or if the surface encloses too little volume; see [`MIN_VOLUME_FRACTION`].
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
    let shells = split_into_shells(surface, adjacency)?;
    let signs = shells::signs(surface.mesh.vertices(), &shells);
    let is_flat = check_volumes(&shells, &signs, lattice, adjacency)?;

    let mut terms = MeshTerms::default();
    let numbered = (0..).zip(&shells).map(|(index, shell)| (shell.component, index));
    let of_component = Csr::sorted(adjacency.component_count, numbered);
    for component in 0..adjacency.component_count {
        let component_shells =
            of_component.row(component).iter().map(|&index: &usize| (&shells[index], signs[index]));
        let counts = |sign: f64| sign != 0.0 && !is_flat[component];
        let oriented = component_shells.filter(|(_, sign)| counts(*sign)).flat_map(|(shell, sign)| {
            shell.triangles.iter().map(move |&[a, b, c]| if sign < 0.0 { [a, c, b] } else { [a, b, c] })
        });
        add_component(surface.embedding, &oriented.collect::<Vec<_>>(), &mut terms);
    }
    let points = surface_points(surface.embedding, &terms.quads);
    renumber_corners(surface.embedding, &points, &mut terms.quads);
    Ok(MeshMeasure::new(terms, &points, surface.embedding))
}

/// Adds the triangles of one component to `terms`: as a patch for each cell with many triangles, and as quads for other
/// cells and for triangles that cross cells. With smooth positions there are no patches.
fn add_component(embedding: &Embedding, triangles: &[[u32; 3]], terms: &mut MeshTerms) {
    let cell = |corner: u32| embedding.cell(corner as usize);
    // Sort key: the cell, whether the triangle leaves the cell, and the index of the triangle. A triangle that crosses
    // cells is sorted into the last of its cells, after the triangles that lie inside this cell.
    let is_outside =
        |corner: &u32| embedding.local(*corner as usize).iter().any(|x| !(0.0..=1.0).contains(x));
    let key = |(index, triangle): (u32, &[u32; 3])| {
        let [a, b, c] = triangle.map(cell);
        (a.max(b).max(c), a != b || b != c || triangle.iter().any(is_outside), index)
    };
    let mut keys: Vec<(u32, bool, u32)> = (0..).zip(triangles).map(key).collect();
    keys.sort_unstable();
    let (previous_patches, previous_quads) = (terms.patches.len(), terms.quads.len());
    let mut others = Vec::new();
    for group in keys.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        let (_, leaves_cell, first) = group[0];
        let group_triangles = group.iter().map(|&(.., index)| triangles[index as usize]);
        if leaves_cell || group.len() < MIN_PATCH_TRIANGLES || embedding.smoothing().is_some() {
            others.extend(group_triangles);
        } else {
            let local =
                group_triangles.map(|triangle| triangle.map(|corner| embedding.local(corner as usize)));
            terms.patches.push(Patch::new(embedding.corners(triangles[first as usize][0] as usize), local));
        }
    }
    terms.quads.extend(quads(&others));
    terms.patch_counts.push(terms.patches.len() - previous_patches);
    terms.quad_counts.push(terms.quads.len() - previous_quads);
}

/// Joins pairs of triangles with a common edge to quads, in the order of the triangles. A triangle `a, b, c` without a
/// partner becomes the quad `a, b, c, a`.
fn quads(triangles: &[[u32; 3]]) -> Vec<[u32; 4]> {
    // The vertices of a component mostly follow each other, so that those between its least and its greatest are few.
    let corners = || triangles.iter().flatten().copied();
    let (Some(low), Some(high)) = (corners().min(), corners().max()) else { return Vec::new() };
    let rows = (high - low) as usize + 1;
    // The directed edges of the triangles that start at each vertex: end, triangle, and the corner that is not on it.
    let edges = (0..).zip(triangles).flat_map(|(index, &[a, b, c]): (u32, &[u32; 3])| {
        [(a - low, (b, index, c)), (b - low, (c, index, a)), (c - low, (a, index, b))]
    });
    let mut edges = Csr::sorted(rows, edges);
    (0..rows).for_each(|start| edges.row_mut(start).sort_unstable());
    let mut is_used = vec![false; triangles.len()];
    let mut quads = Vec::with_capacity(triangles.len() / 2 + 1);
    for (index, &[a, b, c]) in triangles.iter().enumerate() {
        if std::mem::replace(&mut is_used[index], true) {
            continue;
        }
        let partner = [[a, b, c], [b, c, a], [c, a, b]].into_iter().find_map(|[a, b, c]| {
            // A triangle with the edge from `a` to `c` joins the edge from `c` to `a` of this one.
            let from_a = edges.row((a - low) as usize);
            let first = from_a.partition_point(|(end, ..)| *end < c);
            let mut same = from_a[first..].iter().take_while(|(end, ..)| *end == c);
            let found = same.find(|(_, other, _)| !is_used[*other as usize]);
            found.map(|&(_, other, d)| ([a, b, c, d], other as usize))
        });
        match partner {
            Some((quad, other)) => {
                is_used[other] = true;
                quads.push(quad);
            }
            None => quads.push([a, b, c, a]),
        }
    }
    quads
}

/// Returns the mesh vertices whose positions the measure computes, sorted by cell: those that the quads use, or with
/// smooth positions all of them, which the display reads.
fn surface_points(embedding: &Embedding, quads: &[[u32; 4]]) -> Vec<u32> {
    if embedding.smoothing().is_some() {
        return embedding.by_cell().flat_map(|cell| cell.points).copied().collect();
    }
    let mut is_used = vec![false; embedding.len()];
    quads.iter().flatten().for_each(|&vertex| is_used[vertex as usize] = true);
    let all = embedding.by_cell().flat_map(|cell| cell.points).copied();
    all.filter(|&vertex| is_used[vertex as usize]).collect()
}

/// Replaces the corners of the quads, which are mesh vertices, by indices into the list of surface points.
fn renumber_corners(embedding: &Embedding, points: &[u32], quads: &mut [[u32; 4]]) {
    let mut point_of_vertex = vec![0_u32; embedding.len()];
    for (point, &vertex) in points.iter().enumerate() {
        point_of_vertex[vertex as usize] = point as u32;
    }
    for corner in quads.iter_mut().flatten() {
        *corner = point_of_vertex[*corner as usize];
    }
}

/// Returns the shells, without degenerate triangles.
fn split_into_shells(surface: Surface<'_>, adjacency: &Adjacency) -> Result<Vec<Shell>, VolumeError> {
    let (mesh, weld) = (surface.mesh, surface.mesh.weld());
    let triangles = mesh.surface().iter().map(|triangle| triangle.map(|corner| weld[corner as usize]));
    let triangles: Vec<[u32; 3]> = triangles.filter(|[a, b, c]| a != b && b != c && c != a).collect();
    let mut sets = UnionFind::new(weld.len());
    for [a, b, c] in &triangles {
        sets.unite(*a, *b);
        sets.unite(*a, *c);
    }
    let (count, labels) = sets.labels();
    let mut triangles_of_shell = vec![Vec::new(); count];
    for triangle in triangles {
        triangles_of_shell[labels[triangle[0] as usize] as usize].push(triangle);
    }
    let component_of =
        |corner: u32| adjacency.component(surface.embedding.corners(corner as usize)[0] as usize);
    let mut shells = Vec::new();
    for triangles in triangles_of_shell.into_iter().filter(|triangles| !triangles.is_empty()) {
        let component = component_of(triangles[0][0]);
        if triangles.iter().flatten().any(|&corner| component_of(corner) != component) {
            return Err(VolumeError::AcrossComponents);
        }
        shells.push(Shell::new(mesh.vertices(), triangles, component as u32));
    }
    Ok(shells)
}

/// Checks that the surface in each component encloses enough volume; see [`MIN_VOLUME_FRACTION`]. `signs`:
/// result of [`shells::signs`].
fn check_volumes(
    shells: &[Shell],
    signs: &[f64],
    lattice: &Lattice,
    adjacency: &Adjacency,
) -> Result<Vec<bool>, VolumeError> {
    let mut enclosed = vec![0.0; adjacency.component_count];
    for (shell, sign) in shells.iter().zip(signs) {
        enclosed[shell.component as usize] += sign * shell.volume;
    }
    let cell_volume = lattice.cell_size().powi(3);
    let mut cells = vec![0.0; adjacency.component_count];
    for [first, ..] in Corners::new(lattice, adjacency).iter() {
        cells[adjacency.component(first as usize)] += cell_volume;
    }
    let is_flat = |component: usize| enclosed[component] <= MIN_VOLUME_FRACTION * cells[component];
    let flat: Vec<bool> = (0..enclosed.len()).map(is_flat).collect();
    match flat.iter().position(|is_flat| *is_flat) {
        Some(component) if lattice.broken_joints().is_empty() => {
            Err(VolumeError::Flat { component, mesh: enclosed[component], cells: cells[component] })
        }
        _ => Ok(flat),
    }
}
