//! Parts of a surface that share no vertex.

use super::{Mesh, measure};

/// A part of a surface that shares no (welded) vertex with the rest.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Component {
    /// Its first face, from 0.
    pub first_face: usize,
    /// How many faces it has.
    pub faces: usize,
    /// Whether it encloses a volume.
    pub closed: bool,
    /// Volume that it encloses, about the centre of the whole mesh; negative if its faces look inwards.
    pub signed_volume: f64,
}

/// The components, most faces first; `open` holds a vertex of each open edge.
pub(super) fn find(mesh: &Mesh, open: &[u32]) -> Vec<Component> {
    let mut parents: Vec<u32> = (0..mesh.vertices().len() as u32).collect();
    let weld = mesh.weld();
    for face in mesh.faces() {
        for edge in face.windows(2) {
            let [a, b] = [edge[0], edge[1]].map(|corner| root(&mut parents, weld[corner as usize]));
            // The lower one stays root, whatever the order of the faces.
            parents[a.max(b) as usize] = a.min(b);
        }
    }
    let mut number = vec![u32::MAX; parents.len()];
    let mut components: Vec<Component> = Vec::new();
    let mut triangles: Vec<Vec<[u32; 3]>> = Vec::new();
    let mut remaining = mesh.triangles();
    for (index, face) in mesh.faces().enumerate() {
        let Some(&corner) = face.first() else { continue };
        let label = &mut number[root(&mut parents, weld[corner as usize]) as usize];
        if *label == u32::MAX {
            *label = components.len() as u32;
            components.push(Component { first_face: index, faces: 0, closed: true, signed_volume: 0.0 });
            triangles.push(Vec::new());
        }
        components[*label as usize].faces += 1;
        let (own, rest) = remaining.split_at(face.len().saturating_sub(2));
        triangles[*label as usize].extend_from_slice(own);
        remaining = rest;
    }
    for &vertex in open {
        let label = number[root(&mut parents, vertex) as usize];
        components[label as usize].closed = false;
    }
    for (component, triangles) in components.iter_mut().zip(&triangles) {
        component.signed_volume = measure::signed_volume(mesh.vertices(), triangles, mesh.centre());
    }
    components.sort_by_key(|component| (usize::MAX - component.faces, component.first_face));
    components
}

/// The root of a vertex's tree, halving the path to it.
fn root(parents: &mut [u32], mut vertex: u32) -> u32 {
    while parents[vertex as usize] != vertex {
        let grandparent = parents[parents[vertex as usize] as usize];
        parents[vertex as usize] = grandparent;
        vertex = grandparent;
    }
    vertex
}
