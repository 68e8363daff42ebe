//! Named parts of a mesh: groups of vertices, and maps, which give each vertex a number.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::distinct::distinct;
use super::error::MeshError;
use super::polygons::{Mesh, Named};

impl Mesh {
    /// Returns the mesh with named groups of vertices, such as those of objects and materials of a file, which
    /// [`Selection::Group`](crate::Selection::Group) selects. Vertices that the mesh does not have are left out. Groups
    /// of one name are one group.
    #[must_use]
    pub fn with_groups(self, groups: impl IntoIterator<Item = (String, Vec<u32>)>) -> Self {
        let mut named = BTreeMap::<String, Vec<u32>>::new();
        for (name, vertices) in groups {
            let valid = vertices.into_iter().filter(|&vertex| (vertex as usize) < self.vertices.len());
            named.entry(name).or_default().extend(valid);
        }
        let groups = named.into_iter().map(|(name, vertices)| (name, distinct(vertices)));
        let named = Named { groups: groups.collect(), maps: self.named.maps.clone() };
        Self { named: Arc::new(named), ..self }
    }

    /// Returns the names of the groups and their vertices, in increasing order. Empty unless the mesh was made
    /// [with groups](Self::with_groups).
    pub fn groups(&self) -> &[(String, Vec<u32>)] {
        &self.named.groups
    }

    /// Returns the vertices of a group, in increasing order; `None` if no vertex is in a group with this name.
    pub fn group(&self, name: &str) -> Option<&[u32]> {
        let found = self.named.groups.iter().find(|(group, vertices)| group == name && !vertices.is_empty());
        found.map(|(_, vertices)| &vertices[..])
    }

    /// Returns the mesh with named maps, such as the colors of the vertices of a file, which
    /// [`Map::Name`](crate::Map::Name) takes as weights. A map has a number for each vertex. Of maps of one
    /// name the last one counts; those of the mesh before are replaced.
    ///
    /// # Errors
    ///
    /// A map with another number of values than the mesh has vertices.
    pub fn with_maps(self, maps: impl IntoIterator<Item = (String, Vec<f32>)>) -> Result<Self, MeshError> {
        let maps: BTreeMap<_, _> = maps.into_iter().collect();
        let expected = self.vertices.len();
        match maps.iter().find(|(_, values)| values.len() != expected) {
            Some((name, values)) => {
                Err(MeshError::MapLength { name: name.clone(), count: values.len(), expected })
            }
            None => {
                let named = Named { groups: self.named.groups.clone(), maps: maps.into_iter().collect() };
                Ok(Self { named: Arc::new(named), ..self })
            }
        }
    }

    /// Returns the names of the maps and their values, one for each vertex. Empty unless the mesh was made
    /// [with maps](Self::with_maps).
    pub fn maps(&self) -> &[(String, Vec<f32>)] {
        &self.named.maps
    }

    /// Returns the values of a map; `None` if no map has this name.
    pub fn map(&self, name: &str) -> Option<&[f32]> {
        self.named.maps.iter().find(|(map, _)| map == name).map(|(_, values)| &values[..])
    }
}

impl Named {
    /// Returns the parts of a mesh with more vertices: groups keep their vertices, and maps are linear in the triangles
    /// of the mesh before. `points`: see [`RefinedMesh::points`](super::RefinedMesh::points).
    pub(super) fn refined(&self, points: &[([u32; 3], [f64; 3])]) -> Self {
        let maps = self.maps.iter().map(|(name, values)| (name.clone(), refined_map(values, points)));
        Self { groups: self.groups.clone(), maps: maps.collect() }
    }
}

/// Returns the values of a map with those of the new vertices of a refined mesh: see
/// [`RefinedMesh::points`](super::RefinedMesh::points).
pub(crate) fn refined_map(values: &[f32], points: &[([u32; 3], [f64; 3])]) -> Vec<f32> {
    let new = points.iter().map(|(corners, weights)| {
        let part = |(&corner, &weight): (&u32, &f64)| f64::from(values[corner as usize]) * weight;
        corners.iter().zip(weights).map(part).sum::<f64>() as f32
    });
    values.iter().copied().chain(new).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_have_a_value_for_each_vertex_and_are_linear_in_refined_triangles() {
        let corners = vec![[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
        let mesh = Mesh::new(corners, &[[0, 1, 2]]).unwrap();
        let error = mesh.clone().with_maps([("paint".to_owned(), vec![0.0; 2])]).unwrap_err();
        assert!(error.to_string().contains("paint") && error.to_string().contains('3'), "{error}");
        let mesh = mesh.with_maps([("paint".to_owned(), vec![0.0, 1.0, 0.5])]).unwrap();
        assert_eq!(mesh.map("paint"), Some(&[0.0, 1.0, 0.5][..]));
        assert_eq!(mesh.map("other"), None);
        let refined = mesh.refined(1.0).unwrap().unwrap().mesh;
        assert!(refined.vertices().len() > 10);
        for (vertex, value) in refined.vertices().iter().zip(refined.map("paint").unwrap()) {
            assert!((f64::from(*value) - vertex.x / 4.0 - vertex.y / 8.0).abs() < 1e-6);
        }
    }
}
