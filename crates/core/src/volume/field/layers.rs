//! The interior of a field, layer by layer from the boundary inwards (Takamatsu & Kanai 2009).

use nalgebra::Vector3;

use super::normals::unit;
use crate::volume::adjacency::Adjacency;

/// Gives each inner vertex the mean direction of its neighbours in the layer before. The length falls from 1 at the
/// boundary to 0 at the centre.
///
/// * `depth`: layers from the boundary to each vertex; `greatest`: the most in each component.
/// * `directions`: unit vectors at depth 0.
pub(super) fn fill(
    adjacency: &Adjacency,
    depth: &[u32],
    greatest: &[u32],
    mut directions: Vec<Vector3<f64>>,
) -> Vec<Vector3<f64>> {
    let mut inwards: Vec<usize> = (0..adjacency.len()).filter(|&i| depth[i] > 0).collect();
    inwards.sort_by_key(|&i| depth[i]);
    for i in inwards {
        let before = adjacency.linked(i).filter(|&j| depth[j] < depth[i]);
        // Opposite walls can cancel: such a vertex stays where it is.
        directions[i] = unit(before.map(|j| directions[j]).sum()).unwrap_or_else(Vector3::zeros);
    }
    for (i, direction) in directions.iter_mut().enumerate() {
        let greatest = f64::from(greatest[adjacency.component(i)].max(1));
        *direction *= 1.0 - f64::from(depth[i]) / greatest;
    }
    directions
}
