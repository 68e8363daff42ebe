//! Finds the lattice vertices that a shape in world space selects.

use nalgebra::{Point3, Vector3};

use super::soft_body::Body;
use super::surface::Surface;
use crate::dynamics::{Map, Selection, SelectionError, SelectionPose, valid_weights};
use crate::lattice::carried;
use crate::mesh::distinct;

/// Greatest distance from its start, in lengths of the lattice, of a vertex that has not moved: positions are rounded.
const UNMOVED: f64 = 1e-6;
/// Least weight of a map at which a vertex belongs to a part that has no weights.
const LEAST_OF_WHOLE: f64 = 0.5;
/// Least weight with which a pin or a handle pulls a vertex: a tenth of the frequency of a weight of 1/2.
const LEAST_OF_GOAL: f64 = 0.01;

impl Body {
    /// Returns the lattice vertices of a selection, in increasing order, with the body at frame 0: see
    /// [`select_at`](Self::select_at).
    ///
    /// # Errors
    ///
    /// An empty selection, with the distance to the nearest vertex, or an invalid one.
    pub fn select(&self, selection: &Selection) -> Result<Vec<u32>, SelectionError> {
        self.select_at(selection, SelectionPose::Start)
    }

    /// Returns the lattice vertices of a selection, in increasing order.
    ///
    /// A shape selects the corners of every cell that contains a mesh vertex inside the shape. On a bare
    /// lattice a shape selects the lattice vertices inside the shape. Shapes are in world space. A list of mesh vertices
    /// and a group select the corners of every cell that contains one of them. A map selects the lattice vertices with a
    /// [weight](Self::weights) of at least 0.5.
    ///
    /// # Errors
    ///
    /// An empty selection, with the distance to the nearest vertex, or an invalid one.
    pub fn select_at(&self, selection: &Selection, pose: SelectionPose) -> Result<Vec<u32>, SelectionError> {
        if let Some(weights) = self.weights(selection)? {
            return weighted(&weights, LEAST_OF_WHOLE).map(|(vertices, _)| vertices);
        }
        if let Some(part) = self.mesh_part(selection)? {
            let Some(Surface { embedding, .. }) = self.surface() else { return Err(SelectionError::NoMesh) };
            return Ok(distinct(part.iter().flat_map(|&point| embedding.corners(point as usize))));
        }
        let (count, pose) = (self.shape.lattice.len(), self.pose_of(pose));
        let selected = match self.surface() {
            None => selection.lattice_vertices(self.lattice_at(pose), count, |vertex| [vertex]),
            Some(surface) => {
                let vertices = |point: u32| surface.embedding.corners(point as usize);
                selection.lattice_vertices(self.mesh_at(surface, pose), count, vertices)
            }
        };
        selected.map_err(|error| error.at(pose))
    }

    /// Returns the positions of the mesh vertices in the cells of the lattice, in world space.
    pub(super) fn mesh_at(&self, surface: &Surface, pose: SelectionPose) -> Vec<Point3<f64>> {
        let Surface { mesh, embedding, .. } = surface;
        match pose {
            SelectionPose::Start => {
                mesh.vertices().iter().map(|point| self.shape.model_to_world * point).collect()
            }
            SelectionPose::Now => {
                let lattice = self.positions();
                let point = |point: usize| {
                    let corners = embedding.corners(point).into_iter().zip(embedding.weights(point));
                    let part = |(corner, weight)| lattice[corner as usize].coords * f64::from(weight);
                    Point3::from(corners.map(part).sum::<Vector3<f64>>())
                };
                (0..mesh.vertices().len()).map(point).collect()
            }
        }
    }

    /// Returns the weight in [0, 1] of each lattice vertex for a selection that is a map; `None` for another one.
    ///
    /// A vertex of a cell that the surface meets has the mean of the map over the surface around it, with the area and
    /// the trilinear weight of the vertex in its cell; in a face the map is linear. Any other vertex has the mean of its
    /// neighbors, so that a map that is linear in space stays linear inside. The weights depend on neither the size nor the
    /// order of the faces. The vertices of the map are those of the mesh of the body before it broke.
    ///
    /// # Errors
    ///
    /// A map that the mesh does not have, or with another number of weights than vertices, a weight out of range, or a
    /// bare lattice.
    pub fn weights(&self, selection: &Selection) -> Result<Option<Vec<f64>>, SelectionError> {
        let Selection::Map(map) = selection else { return Ok(None) };
        let mesh = self.whole_mesh().ok_or(SelectionError::NoMesh)?;
        let weights = match map {
            Map::Weights(weights) => &weights[..],
            Map::Name(name) => mesh.map(name).ok_or_else(|| SelectionError::NoSuchMap {
                name: name.clone(),
                known: mesh.maps().iter().map(|(map, _)| map.clone()).collect(),
            })?,
        };
        let (count, expected) = (weights.len(), mesh.vertices().len());
        if count != expected {
            return Err(SelectionError::WeightCount { count, expected });
        }
        valid_weights(weights)?;
        Ok(Some(carried(&self.shape.lattice, mesh, weights)))
    }

    /// Returns the lattice vertices that a pin or a handle takes, in increasing order, and their weights if the selection
    /// is a map.
    pub(super) fn held_part(
        &self,
        selection: &Selection,
    ) -> Result<(Vec<u32>, Option<Vec<f64>>), SelectionError> {
        match self.weights(selection)? {
            Some(weights) => weighted(&weights, LEAST_OF_GOAL).map(|(vertices, some)| (vertices, Some(some))),
            None => Ok((self.select(selection)?, None)),
        }
    }

    /// Returns the mesh vertices of a selection that is a part of the mesh, in increasing order; `None` for another one.
    pub(super) fn mesh_part(&self, selection: &Selection) -> Result<Option<Vec<u32>>, SelectionError> {
        let mesh = || self.surface().map(|surface| &surface.mesh).ok_or(SelectionError::NoMesh);
        selection.validate()?;
        match selection {
            Selection::MeshVertices(list) => {
                let count = mesh()?.vertices().len();
                match list.iter().find(|vertex| **vertex as usize >= count) {
                    Some(&vertex) => Err(SelectionError::MeshVertexOutOfRange { vertex, count }),
                    None => Ok(Some(distinct(list.clone()))),
                }
            }
            Selection::Group(name) => {
                let mesh = mesh()?;
                let known = || mesh.groups().iter().map(|(group, _)| group.clone()).collect();
                let missing = || SelectionError::NoSuchGroup { name: name.clone(), known: known() };
                mesh.group(name).map(|vertices| Some(vertices.to_vec())).ok_or_else(missing)
            }
            _ => Ok(None),
        }
    }

    /// Returns the positions of the lattice vertices, in vertex order, in world space.
    pub(super) fn lattice_at(&self, pose: SelectionPose) -> Vec<Point3<f64>> {
        match pose {
            SelectionPose::Start => {
                (0..self.shape.lattice.len() as u32).map(|vertex| self.start_of(vertex)).collect()
            }
            SelectionPose::Now => self.positions(),
        }
    }

    /// Returns whether the body has not moved.
    pub(super) fn is_at_start(&self) -> bool {
        self.pose_of(SelectionPose::Now) == SelectionPose::Start
    }

    /// Returns the pose, or [`SelectionPose::Start`] if the body has not moved, so that rounded positions do not decide
    /// whether a point on the boundary of a shape is inside.
    pub(super) fn pose_of(&self, pose: SelectionPose) -> SelectionPose {
        if pose == SelectionPose::Start {
            return pose;
        }
        let starts = self.lattice_at(SelectionPose::Start);
        let farthest = starts.iter().map(|start| (start - starts[0]).norm()).fold(0.0, f64::max);
        let mut steps = self.positions().into_iter().zip(starts).map(|(now, start)| (now - start).norm());
        if steps.all(|step| step <= UNMOVED * farthest) { SelectionPose::Start } else { pose }
    }

    /// Returns the position of a lattice vertex at frame 0, in world space.
    pub(crate) fn start_of(&self, vertex: u32) -> Point3<f64> {
        self.shape.model_to_world * self.shape.lattice.rest_position(vertex)
    }
}

/// Returns the vertices with a weight of at least `least`, in increasing order, and their weights.
fn weighted(weights: &[f64], least: f64) -> Result<(Vec<u32>, Vec<f64>), SelectionError> {
    let some = (0..).zip(weights.iter().copied()).filter(|(_, weight)| *weight >= least);
    let (vertices, weights): (Vec<u32>, Vec<f64>) = some.unzip();
    match vertices.is_empty() {
        true => Err(SelectionError::NoWeight { least: least as f32 }),
        false => Ok((vertices, weights)),
    }
}
