//! Selects the lattice vertices that a pin, a handle or a force acts on.

use std::borrow::Borrow;

use nalgebra::{Point3, Vector3};
use thiserror::Error;

use crate::mesh::{RefinedMesh, distinct, refined_map};
use crate::motion::direction;

/// A selection of lattice vertices: a shape in world space, a list of lattice vertices, or a part of the mesh. Points on
/// the boundary of a shape are selected.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Selection {
    /// A box with faces perpendicular to the world axes. `min <= max` along each axis.
    Box {
        /// Corner with the smallest coordinates, in scene units.
        min: [f64; 3],
        /// Corner with the largest coordinates, in scene units.
        max: [f64; 3],
    },
    /// A ball.
    Sphere {
        /// Center, in scene units.
        center: [f64; 3],
        /// Radius in scene units, > 0.
        radius: f64,
    },
    /// A half-space: the side of a plane that the normal points to.
    Plane {
        /// Any point of the plane, in scene units.
        point: [f64; 3],
        /// Normal of the plane, of any length > 0.
        normal: [f64; 3],
    },
    /// Indices of lattice vertices, in any order.
    Vertices(Vec<u32>),
    /// Indices of mesh vertices, in any order: the corners of their cells.
    MeshVertices(Vec<u32>),
    /// A named [group](crate::Mesh::with_groups) of mesh vertices: the corners of their cells.
    Group(String),
    /// A weight of each mesh vertex, which the vertices of the lattice take over: see
    /// [`Body::weights`](crate::Body::weights). What takes whole parts only takes the lattice vertices with at least 0.5.
    Map(Map),
}

/// Weights in [0, 1] of the vertices of a mesh.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Map {
    /// The name of a [map](crate::Mesh::with_maps) of the mesh, such as a color of its vertices.
    Name(String),
    /// One for each vertex.
    Weights(Vec<f32>),
}

impl From<&str> for Map {
    fn from(name: &str) -> Self {
        Self::Name(name.to_owned())
    }
}

impl From<Vec<f32>> for Map {
    fn from(weights: Vec<f32>) -> Self {
        Self::Weights(weights)
    }
}

/// The error that a selection is invalid or empty.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum SelectionError {
    /// A number is NaN or infinite.
    #[error("{name} is {value}; it must be finite")]
    NotFinite {
        /// Name of the number.
        name: &'static str,
        /// Value of the number.
        value: f64,
    },
    /// A box has min > max along an axis.
    #[error(
        "the box has min {min} > max {max} along {}; swap the two",
        ["x", "y", "z"][*axis]
    )]
    EmptyBox {
        /// The axis: 0 is x, 1 is y, 2 is z.
        axis: usize,
        /// `min` along this axis.
        min: f64,
        /// `max` along this axis.
        max: f64,
    },
    /// The radius of a sphere is not greater than 0.
    #[error("the sphere's radius is {radius}; it must be greater than 0")]
    Radius {
        /// The radius.
        radius: f64,
    },
    /// The normal of a plane is zero.
    #[error("the plane's normal is zero; give the direction of the side to select")]
    ZeroNormal,
    /// The list of vertices is empty.
    #[error("the list of vertices is empty; name at least one vertex")]
    NoVertices,
    /// A list of vertices, a group or a map in place of a part of space.
    #[error("a list of vertices, a group or a map is no part of space; give a box, a sphere or a plane")]
    NoShape,
    /// A part of the mesh of a body without one.
    #[error("a bare lattice has no mesh of which a part could be selected; give a shape or lattice vertices")]
    NoMesh,
    /// The index of a mesh vertex is out of range.
    #[error("vertex {vertex} is out of range: the mesh has {count} vertices, 0 to {}", *count as i64 - 1)]
    MeshVertexOutOfRange {
        /// The index.
        vertex: u32,
        /// Number of mesh vertices.
        count: usize,
    },
    /// The mesh has no group with this name.
    #[error("the mesh has no group {name:?}; {}", match &known[..] {
        [] => "it has no named groups".to_owned(),
        known => format!("it has {known:?}"),
    })]
    NoSuchGroup {
        /// The name.
        name: String,
        /// The names of the groups of the mesh.
        known: Vec<String>,
    },
    /// The mesh has no map with this name.
    #[error("the mesh has no map {name:?}; {}", match &known[..] {
        [] => "it has no colors or other numbers of its vertices".to_owned(),
        known => format!("it has {known:?}"),
    })]
    NoSuchMap {
        /// The name.
        name: String,
        /// The names of the maps of the mesh.
        known: Vec<String>,
    },
    /// There is another number of weights than mesh vertices.
    #[error("there are {count} weights, and the mesh has {expected} vertices; give a weight for each vertex")]
    WeightCount {
        /// Number of weights.
        count: usize,
        /// Number of mesh vertices.
        expected: usize,
    },
    /// A weight is not in [0, 1].
    #[error("the weight of mesh vertex {vertex} is {value}; its range is 0 to 1")]
    Weight {
        /// The mesh vertex.
        vertex: usize,
        /// The weight.
        value: f32,
    },
    /// All weights are 0, or below the least one that is used.
    #[error(
        "no lattice vertex has a weight of at least {least}, by the mean around it; paint a larger part, or select another map"
    )]
    NoWeight {
        /// The least weight.
        least: f32,
    },
    /// A torque on vertices that no forces can turn about its axis.
    #[error(
        "the selected lattice vertices lie on a line or at a point, about which no torque acts; select a part that is wider"
    )]
    NoTorque,
    /// The index of a vertex is out of range.
    #[error("vertex {vertex} is out of range: the lattice has {count} vertices, 0 to {}", *count as i64 - 1)]
    VertexOutOfRange {
        /// The index.
        vertex: u32,
        /// Number of lattice vertices.
        count: usize,
    },
    /// No point lies inside the shape.
    #[error(
        "the {shape} selects nothing of the body {pose}: the nearest vertex is at ({:.6}, {:.6}, {:.6}), {distance:.6} outside; \
         move the {shape}{}",
        nearest[0], nearest[1], nearest[2], if *shape == "plane" { "" } else { " or make it larger" }
    )]
    Nothing {
        /// `box`, `sphere` or `plane`.
        shape: &'static str,
        /// The point nearest to the shape, in scene units.
        nearest: [f64; 3],
        /// Distance of the nearest point from the shape, in scene units.
        distance: f64,
        /// Pose of the body.
        pose: SelectionPose,
    },
}

/// The pose of a body in which a shape selects a part of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SelectionPose {
    /// The pose at frame 0, the initial placement.
    #[default]
    Start,
    /// The current pose.
    Now,
}

impl SelectionPose {
    /// The values and their names.
    pub const NAMED: [(&'static str, Self); 2] = [("start", Self::Start), ("now", Self::Now)];
}

impl std::fmt::Display for SelectionPose {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Start => "at frame 0",
            Self::Now => "as it is now",
        })
    }
}

impl SelectionError {
    /// Returns the error with the pose in which the body was.
    pub(crate) fn at(mut self, now: SelectionPose) -> Self {
        if let Self::Nothing { pose, .. } = &mut self {
            *pose = now;
        }
        self
    }
}

impl Selection {
    /// Checks the selection without a lattice.
    ///
    /// # Errors
    /// If a number is not finite, min > max along an axis, the radius is not positive, the normal is zero, or
    /// the list of vertices is empty.
    pub fn validate(&self) -> Result<(), SelectionError> {
        match self {
            Self::Box { min, max } => {
                finite("min", min)?;
                finite("max", max)?;
                match (0..3).find(|&axis| min[axis] > max[axis]) {
                    Some(axis) => Err(SelectionError::EmptyBox { axis, min: min[axis], max: max[axis] }),
                    None => Ok(()),
                }
            }
            Self::Sphere { center, radius } => {
                finite("center", center)?;
                finite("radius", &[*radius])?;
                if *radius > 0.0 { Ok(()) } else { Err(SelectionError::Radius { radius: *radius }) }
            }
            Self::Plane { point, normal } => {
                finite("point", point)?;
                finite("normal", normal)?;
                direction(*normal).map(drop).ok_or(SelectionError::ZeroNormal)
            }
            Self::Vertices(list) | Self::MeshVertices(list) if list.is_empty() => {
                Err(SelectionError::NoVertices)
            }
            Self::Map(Map::Weights(weights)) => valid_weights(weights),
            Self::Vertices(_) | Self::MeshVertices(_) | Self::Group(_) | Self::Map(_) => Ok(()),
        }
    }

    /// Returns whether the selection has a weight for each mesh vertex.
    pub fn is_map(&self) -> bool {
        matches!(self, Self::Map(_))
    }

    /// Gives the new vertices of a refined mesh their weights, if the selection has one for each vertex of the mesh before.
    pub fn refine(&mut self, refined: &RefinedMesh) {
        if let Self::Map(Map::Weights(weights)) = self
            && weights.len() + refined.points.len() == refined.mesh.vertices().len()
        {
            *weights = refined_map(weights, &refined.points);
        }
    }

    /// Returns whether the selection is a shape in space.
    pub fn is_shape(&self) -> bool {
        matches!(self, Self::Box { .. } | Self::Sphere { .. } | Self::Plane { .. })
    }

    /// Returns the distance of `point` from the shape, in scene units. The distance is 0 inside the shape,
    /// and infinite for a list of vertices, a group and a map.
    pub fn distance(&self, point: &Point3<f64>) -> f64 {
        match self {
            Self::Box { min, max } => {
                let excess = |axis: usize| (min[axis] - point[axis]).max(point[axis] - max[axis]).max(0.0);
                Vector3::from_fn(|axis, _| excess(axis)).norm()
            }
            Self::Sphere { center, radius } => ((point - Point3::from(*center)).norm() - radius).max(0.0),
            Self::Plane { point: base, normal } => {
                let normal = direction(*normal).unwrap_or_else(Vector3::zeros);
                (-normal.dot(&(point - Point3::from(*base)))).max(0.0)
            }
            _ => f64::INFINITY,
        }
    }

    /// Resolves the selection to lattice vertices, in increasing order without duplicates.
    ///
    /// A shape is tested against `points`, in world space. The points are the mesh vertices, or
    /// the lattice vertices of a body without a mesh. If point `i` is inside the shape, the lattice vertices
    /// `vertices_of(i)` are selected: the corners of the cell that contains mesh vertex `i`, or lattice
    /// vertex `i` itself. `vertex_count` is the number of lattice vertices. A list of vertices does not use
    /// the points.
    ///
    /// # Errors
    /// The errors of [`validate`](Self::validate). Also an error if a vertex is out of range, or if no point
    /// lies inside the shape ([`SelectionError::Nothing`]).
    pub fn lattice_vertices<I: IntoIterator<Item = u32>>(
        &self,
        points: impl IntoIterator<Item: Borrow<Point3<f64>>>,
        vertex_count: usize,
        vertices_of: impl Fn(u32) -> I,
    ) -> Result<Vec<u32>, SelectionError> {
        self.validate()?;
        let vertices = distinct(match self {
            Self::Vertices(list) => list.clone(),
            _ => self.points_inside(points)?.into_iter().flat_map(vertices_of).collect(),
        });
        match vertices.last() {
            Some(&vertex) if vertex as usize >= vertex_count => {
                Err(SelectionError::VertexOutOfRange { vertex, count: vertex_count })
            }
            _ => Ok(vertices),
        }
    }

    /// Returns the indices of the points inside the shape, in increasing order. Returns an error if no point
    /// is inside.
    pub(crate) fn points_inside(
        &self,
        points: impl IntoIterator<Item: Borrow<Point3<f64>>>,
    ) -> Result<Vec<u32>, SelectionError> {
        let mut inside = Vec::new();
        let mut nearest = (f64::INFINITY, Point3::origin());
        for (index, point) in (0u32..).zip(points) {
            let point = point.borrow();
            let distance = self.distance(point);
            if distance <= 0.0 {
                inside.push(index);
            } else if distance < nearest.0 {
                nearest = (distance, *point);
            }
        }
        if inside.is_empty() {
            let (distance, point) = nearest;
            let (nearest, pose) = (point.into(), SelectionPose::Start);
            return Err(SelectionError::Nothing { shape: self.name(), nearest, distance, pose });
        }
        Ok(inside)
    }

    /// Returns the name of the kind of selection, for error messages.
    fn name(&self) -> &'static str {
        match self {
            Self::Box { .. } => "box",
            Self::Sphere { .. } => "sphere",
            Self::Plane { .. } => "plane",
            Self::Vertices(_) | Self::MeshVertices(_) => "list",
            Self::Group(_) => "group",
            Self::Map(_) => "map",
        }
    }
}

/// Checks the range of the weights of mesh vertices.
pub(crate) fn valid_weights(weights: &[f32]) -> Result<(), SelectionError> {
    match weights.iter().position(|weight| !(0.0..=1.0).contains(weight)) {
        Some(vertex) => Err(SelectionError::Weight { vertex, value: weights[vertex] }),
        None => Ok(()),
    }
}

/// Checks that all values are finite.
fn finite(name: &'static str, values: &[f64]) -> Result<(), SelectionError> {
    match values.iter().find(|v| !v.is_finite()) {
        Some(&value) => Err(SelectionError::NotFinite { name, value }),
        None => Ok(()),
    }
}
