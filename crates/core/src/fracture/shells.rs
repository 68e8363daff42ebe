//! Lets each shell of a cut mesh follow one piece of the lattice.
//!
//! Where a smooth crack meets a thin part, a point of the mesh can be nearer to a cell of a sliver of the lattice than
//! to the piece whose surface it belongs to. The faces around it would stretch when the sliver moves away.
//!
//! Copies of a vertex at a seam are welded, and follow the same cell.

use super::cut::CutMesh;
use crate::lattice::Lattice;

/// Greatest share of the vertices of a shell that may follow cells of other pieces, in a mesh with
/// openings. There the cut is open as well, and a shell with a greater share lies in several pieces. In a closed mesh
/// each shell belongs to one piece.
const GREATEST_SHARE: f64 = 0.2;

/// Assigns the vertices of each shell, a connected part of the mesh, that follow cells of other pieces than most of its
/// vertices to the nearest of the cells that vertices of the same face follow.
pub(super) fn follow_one_piece(cut: &mut CutMesh, lattice: &Lattice) {
    let CutMesh { mesh, hosts, .. } = cut;
    let greatest_share = if mesh.is_closed() { 1.0 } else { GREATEST_SHARE };
    let welded = |vertex: u32| mesh.weld()[vertex as usize];
    let (count, shell_of) = mesh.face_components();
    let piece = |hosts: &[u32], vertex: u32| lattice.component_of_cell(hosts[vertex as usize]);
    let member = |(vertex, &shell): (u32, &u32)| (shell, piece(hosts, vertex));
    let mut members: Vec<(u32, u32)> =
        (0..).zip(&shell_of).filter(|&(vertex, _)| welded(vertex) == vertex).map(member).collect();
    members.sort_unstable();
    // The piece of each shell, and the shells with vertices that follow others.
    let mut pieces = vec![None; count];
    for shell in members.chunk_by(|a, b| a.0 == b.0) {
        let most = shell.chunk_by(|a, b| a == b).max_by_key(|group| group.len());
        if let Some(most) = most.filter(|most| (most.len() as f64) < shell.len() as f64)
            && most.len() as f64 >= (1.0 - greatest_share) * shell.len() as f64
        {
            pieces[most[0].0 as usize] = Some(most[0].1);
        }
    }
    if pieces.iter().all(Option::is_none) {
        return;
    }
    let center = |cell: u32| {
        let index = nalgebra::Vector3::from(lattice.cells()[cell as usize].map(|i| f64::from(i) + 0.5));
        lattice.origin() + index * lattice.cell_size()
    };
    // Each round reaches the vertices one edge further.
    loop {
        let mut found: Vec<(u32, f64, u32)> = Vec::new();
        for face in mesh.faces() {
            let Some(wanted) = pieces[shell_of[welded(face[0]) as usize] as usize] else { continue };
            let corners = || face.iter().map(|&vertex| welded(vertex));
            for vertex in corners().filter(|&vertex| piece(hosts, vertex) != wanted) {
                let position = mesh.vertices()[vertex as usize];
                found.extend(corners().filter(|&other| piece(hosts, other) == wanted).map(|other| {
                    let cell = hosts[other as usize];
                    (vertex, (center(cell) - position).norm_squared(), cell)
                }));
            }
        }
        if found.is_empty() {
            break;
        }
        found.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
        found.dedup_by_key(|(vertex, ..)| *vertex);
        found.into_iter().for_each(|(vertex, _, cell)| hosts[vertex as usize] = cell);
    }
    for vertex in 0..hosts.len() {
        if pieces[shell_of[welded(vertex as u32) as usize] as usize].is_some() {
            hosts[vertex] = hosts[welded(vertex as u32) as usize];
        }
    }
}
