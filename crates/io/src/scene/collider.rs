//! Defines `[[collider]]`: a shape, which may be a mesh file, with friction, restitution and keyframes.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::keys::{
    direction, extents, fraction, has_no_thickness, interpolation, keyframes, mesh, not_negative, positive,
    scale, switch,
};
use supple::{Collider, ColliderFault, CollisionMesh, Interpolation, Key, Scale, Shape, Switch};

/// `[[collider]]`: shape, friction, restitution and keyframes of a collider.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ColliderData {
    /// Keys `plane`, `sphere`, `box`, `capsule` or `mesh`.
    #[serde(rename = "@shape")]
    pub shape: ColliderShape,
    /// Scale of a mesh, applied first, about its origin: a factor above 0, or one for each axis, not 0; default 1.
    #[serde(default, with = "scale", skip_serializing_if = "is_one")]
    pub scale: Scale,
    /// Rotation of a mesh about the origin: degrees about the fixed axes x, then y, then z.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub rotate: [f64; 3],
    /// Displacement of a mesh, applied last.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub translate: [f64; 3],
    /// Whether bodies stay inside a closed mesh, as in a room.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub inside: bool,
    /// PC2 file with the positions of the vertices of a mesh, relative to the scene file; `None` for a rigid mesh.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub animation: Option<PathBuf>,
    /// Coulomb coefficient of friction, at least 0; default 0.5.
    #[serde(default = "friction", deserialize_with = "not_negative")]
    pub friction: f64,
    /// Coefficient of restitution, in [0, 1]; default 0.
    #[serde(default, deserialize_with = "fraction")]
    pub restitution: f64,
    /// Coefficient of rolling resistance, at least 0; `None` for that of the body.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "not_negative")]
    pub rolling_resistance: Option<f64>,
    /// Distance outside of the surface at which bodies touch, at least 0; default 0.
    #[serde(default, skip_serializing_if = "has_no_thickness", deserialize_with = "not_negative")]
    pub thickness: f64,
    /// Keyframes; without them the collider is at rest.
    #[serde(default, with = "keyframes", skip_serializing_if = "Vec::is_empty")]
    pub keys: Vec<Key>,
    /// Interpolation between the keyframes.
    #[serde(default, with = "interpolation", skip_serializing_if = "Interpolation::is_linear")]
    pub interpolation: Interpolation,
    /// Whether the collider is enabled: true, the default, or false, or keyframes. A disabled collider touches nothing.
    #[serde(default = "enabled", with = "switch", skip_serializing_if = "Switch::is_always_on")]
    pub enabled: Switch,
}

/// Shape of a collider of a scene: see [`Shape`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum ColliderShape {
    /// Half space below a plane.
    Plane {
        /// Any point of the plane.
        point: [f64; 3],
        /// Direction of the free side, not zero.
        #[serde(deserialize_with = "direction")]
        normal: [f64; 3],
    },
    /// Ball.
    Sphere {
        /// Center.
        center: [f64; 3],
        /// Radius, above 0.
        #[serde(deserialize_with = "positive")]
        radius: f64,
    },
    /// Box.
    Box {
        /// Center.
        center: [f64; 3],
        /// Half of the edge lengths, above 0.
        #[serde(deserialize_with = "extents")]
        half_extents: [f64; 3],
        /// Degrees about the fixed axes x, then y, then z.
        #[serde(default)]
        rotate: [f64; 3],
    },
    /// All points within a radius of a segment.
    Capsule {
        /// First end of the segment.
        a: [f64; 3],
        /// Second end of the segment.
        b: [f64; 3],
        /// Radius, above 0.
        #[serde(deserialize_with = "positive")]
        radius: f64,
    },
    /// Model file, relative to the scene file: a solid if the mesh is closed, a thin shell if it is open.
    Mesh(#[serde(deserialize_with = "mesh")] PathBuf),
}

impl ColliderData {
    /// Returns the file of a mesh.
    pub fn mesh(&self) -> Option<&PathBuf> {
        match &self.shape {
            ColliderShape::Mesh(path) => Some(path),
            _ => None,
        }
    }

    /// Returns the keys and the paths of the files, to change them.
    pub(crate) fn files_mut(&mut self) -> impl Iterator<Item = (&'static str, &mut PathBuf)> {
        let mesh = match &mut self.shape {
            ColliderShape::Mesh(path) => Some(("mesh", path)),
            _ => None,
        };
        mesh.into_iter().chain(self.animation.as_mut().map(|path| ("animation", path)))
    }

    /// Returns the collider. `read` returns the mesh of a file.
    ///
    /// # Errors
    ///
    /// The error of `read`, or the path of a mesh that can't be scaled.
    pub fn collider<E>(
        &self,
        read: impl FnOnce(&PathBuf) -> Result<CollisionMesh, E>,
        failed: impl FnOnce(&PathBuf, ColliderFault) -> E,
    ) -> Result<Collider, E> {
        let shape = match &self.shape {
            &ColliderShape::Plane { point, normal } => Shape::Plane { point, normal },
            &ColliderShape::Sphere { center, radius } => Shape::Sphere { center, radius },
            &ColliderShape::Box { center, half_extents, rotate } => {
                Shape::Box { center, half_extents, rotate }
            }
            &ColliderShape::Capsule { a, b, radius } => Shape::Capsule { a, b, radius },
            ColliderShape::Mesh(path) => {
                let &Self { scale, rotate, translate, .. } = self;
                Shape::mesh(read(path)?, scale, rotate, translate).map_err(|fault| failed(path, fault))?
            }
        };
        let &Self { friction, restitution, rolling_resistance, thickness, interpolation, .. } = self;
        let (keys, enabled) = (self.keys.clone(), self.enabled.clone());
        Ok(Collider {
            shape,
            friction,
            restitution,
            rolling_resistance,
            thickness,
            keys,
            interpolation,
            enabled,
        })
    }

    /// Returns a key that has a value although only a mesh has it.
    pub(super) fn key_of_mesh(&self) -> Option<&'static str> {
        let keys = [
            ("scale", is_one(&self.scale)),
            ("rotate", is_zero(&self.rotate)),
            ("translate", is_zero(&self.translate)),
            ("inside", !self.inside),
            ("animation", self.animation.is_none()),
        ];
        let given = keys.into_iter().find(|(_, is_default)| !is_default);
        given.filter(|_| self.mesh().is_none()).map(|(key, _)| key)
    }
}

/// The half space below a plane, with the defaults of the other keys.
impl ColliderData {
    pub(super) fn plane(point: [f64; 3], normal: [f64; 3]) -> Self {
        let shape = ColliderShape::Plane { point, normal };
        let (scale, rotate, translate) = (Scale::default(), [0.0; 3], [0.0; 3]);
        Self {
            shape,
            scale,
            rotate,
            translate,
            inside: false,
            animation: None,
            friction: friction(),
            restitution: 0.0,
            rolling_resistance: None,
            thickness: 0.0,
            keys: Vec::new(),
            interpolation: Interpolation::Linear,
            enabled: enabled(),
        }
    }
}

/// Returns the default friction of a collider.
fn friction() -> f64 {
    Collider::plane([0.0; 3], [0.0, 1.0, 0.0]).friction
}

/// Returns that a collider is enabled by default.
fn enabled() -> Switch {
    true.into()
}

fn is_one(scale: &Scale) -> bool {
    *scale == Scale::default()
}

fn is_zero(vector: &[f64; 3]) -> bool {
    *vector == [0.0; 3]
}
