//! The nodes of a scene and their places.

use ::gltf::scene::Transform;
use ::gltf::{Document, Node};
use nalgebra::{Matrix4, Quaternion, Translation3, UnitQuaternion, Vector3};

use super::super::error::Fault;
use crate::collider::COLLIDERS;

/// Returns the transformation of each node to the axes of the scene.
pub(super) fn places(document: &Document) -> Result<Vec<Matrix4<f64>>, Fault> {
    let count = document.nodes().len();
    let mut parents = vec![None; count];
    for node in document.nodes() {
        for child in node.children() {
            if parents[child.index()].replace(node.index()).is_some() {
                return Err(Fault(format!("node {} has two parents; export it again", child.index())));
            }
        }
    }
    let mut places: Vec<Option<Matrix4<f64>>> = vec![None; count];
    let roots = document.nodes().filter(|node| parents[node.index()].is_none());
    let mut next: Vec<(Node<'_>, Matrix4<f64>)> = roots.map(|node| (node, Matrix4::identity())).collect();
    while let Some((node, parent)) = next.pop() {
        let place = parent * matrix(node.transform());
        places[node.index()] = Some(place);
        next.extend(node.children().map(|child| (child, place)));
    }
    // A node without a place has no root above it.
    let cyclic = |node: usize| Fault(format!("node {node} is its own ancestor; export it again"));
    places.into_iter().enumerate().map(|(node, place)| place.ok_or_else(|| cyclic(node))).collect()
}

/// Returns the nodes of the default scene, or else of the first one, in depth-first order; all nodes of a file without
/// scenes. The nodes have [`places`].
pub(super) fn of_scene(document: &Document) -> Vec<Node<'_>> {
    let Some(scene) = document.default_scene().or_else(|| document.scenes().next()) else {
        return document.nodes().collect();
    };
    let mut next: Vec<Node<'_>> = scene.nodes().collect();
    next.reverse();
    let (mut nodes, mut visited) = (Vec::new(), vec![false; document.nodes().len()]);
    while let Some(node) = next.pop() {
        // The colliders of a run of this program are not those of its bodies.
        if node.name() == Some(COLLIDERS) {
            continue;
        }
        if std::mem::replace(&mut visited[node.index()], true) {
            continue;
        }
        let first = next.len();
        next.extend(node.children());
        next[first..].reverse();
        nodes.push(node);
    }
    nodes
}

fn matrix(transform: Transform) -> Matrix4<f64> {
    match transform {
        Transform::Matrix { matrix } => Matrix4::from(matrix).cast(),
        Transform::Decomposed { translation, rotation: [x, y, z, w], scale } => {
            let rotation = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z).cast::<f64>());
            let translation = Translation3::from(Vector3::from(translation).cast::<f64>());
            let scale = Matrix4::new_nonuniform_scaling(&Vector3::from(scale).cast());
            translation.to_homogeneous() * rotation.to_homogeneous() * scale
        }
    }
}
