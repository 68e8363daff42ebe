//! Meshes as shapes of colliders: solids if they are closed, thin shells if they are open.

use std::sync::Arc;

use nalgebra::{Matrix3, Point3, Vector3};

use super::distance::SignedDistance;
use super::fault::ColliderFault;
use crate::mesh::{ClosestPoint, Mesh, MeshAnimation, MeshError, Scale, SurfaceTree};

/// Half of the thickness of a shell, in cells: samples stay at this distance from an open mesh.
///
/// A sample that rests on a shell is at this distance from the surface, so that rounding and the tolerated depth of a
/// contact leave it on its side.
pub(super) const SHELL: f64 = 0.05;

/// A mesh with a search tree, as the shape of a collider. Cloning is cheap: the data are shared.
///
/// A closed mesh ([`Mesh::is_closed`]) is a solid; faces that are clockwise seen from outside have the same effect. An
/// open mesh is a thin shell: bodies may lie on either side of it. The solid can also be all that is outside of a
/// closed mesh: see [`inverted`](Self::inverted).
#[derive(Clone, Debug)]
pub struct CollisionMesh(Arc<Data>);

#[derive(Debug)]
struct Data {
    mesh: Mesh,
    surface: CollisionSurface,
    animation: Option<MeshAnimation>,
}

/// The surface of a collision mesh, in the coordinates of the mesh.
#[derive(Clone, Debug)]
pub(super) struct CollisionSurface {
    tree: SurfaceTree,
    /// 1 if the faces are counter-clockwise seen from the free side, and -1 if they are clockwise; `None` if the mesh
    /// is open.
    outward: Option<f64>,
    /// Whether the solid is all that is outside of the mesh.
    is_inverted: bool,
}

impl CollisionMesh {
    /// Builds the search tree of a mesh.
    ///
    /// # Errors
    /// [`ColliderFault::NoArea`] if no triangle has an area.
    pub fn new(mesh: Mesh) -> Result<Self, ColliderFault> {
        Self::with(mesh, None)
    }

    /// Builds a mesh whose vertices move. The mesh itself is the shape before the first step, and determines whether
    /// it is closed. [`Shape::signed_distance`](super::Shape::signed_distance) uses the mesh itself.
    ///
    /// # Errors
    /// As [`new`](Self::new). Also if the animation has another number of vertices.
    pub fn animated(mesh: Mesh, animation: MeshAnimation) -> Result<Self, ColliderFault> {
        animation.check_vertices(mesh.vertices().len())?;
        Self::with(mesh, Some(animation))
    }

    fn with(mesh: Mesh, animation: Option<MeshAnimation>) -> Result<Self, ColliderFault> {
        let outward = mesh.is_closed().then(|| if mesh.signed_volume() < 0.0 { -1.0 } else { 1.0 });
        let tree = tree(&mesh, mesh.vertices());
        let tree = tree.ok_or(ColliderFault::NoArea { faces: mesh.face_count() })?;
        let surface = CollisionSurface { tree, outward, is_inverted: false };
        Ok(Self(Arc::new(Data { mesh, surface, animation })))
    }

    /// Returns a room: bodies stay inside the closed mesh, and all that is outside of it is solid. It has the same
    /// effect whether the faces point inwards or outwards.
    ///
    /// # Errors
    /// [`ColliderFault::OpenRoom`] if the mesh is open. A shell holds bodies on either side.
    pub fn inverted(&self) -> Result<Self, ColliderFault> {
        let Data { mesh, surface, animation } = &*self.0;
        let Some(outward) = surface.outward else {
            return Err(ColliderFault::OpenRoom { open_edges: mesh.topology().open_edges });
        };
        let surface = CollisionSurface {
            tree: surface.tree.clone(),
            outward: Some(-outward),
            is_inverted: !surface.is_inverted,
        };
        Ok(Self(Arc::new(Data { mesh: mesh.clone(), surface, animation: animation.clone() })))
    }

    /// Scales the mesh and its animation about the origin of the mesh, along each axis.
    ///
    /// # Errors
    /// [`ColliderFault::Scale`] if the scale or the scaled mesh is out of range, and [`ColliderFault::NoArea`] if the
    /// scaled triangles have no area.
    pub fn scaled(&self, scale: impl Into<Scale>) -> Result<Self, ColliderFault> {
        let scale = scale.into();
        let failed = |source: MeshError| ColliderFault::Scale { scale, reason: source.to_string() };
        let mesh = self.mesh().scaled(scale).map_err(failed)?;
        let animation = self.animation().map(|animation| animation.scaled(scale)).transpose()?;
        let scaled = Self::with(mesh, animation)?;
        if self.is_inverted() { scaled.inverted() } else { Ok(scaled) }
    }

    /// Returns whether the solid is all that is outside of the mesh.
    pub fn is_inverted(&self) -> bool {
        self.0.surface.is_inverted
    }

    /// Returns the animation, or `None` if the mesh is rigid.
    pub fn animation(&self) -> Option<&MeshAnimation> {
        self.0.animation.as_ref()
    }

    /// Returns the surface with other positions of the vertices, or `None` if no triangle has an area.
    pub(super) fn surface_at(&self, points: &[Point3<f64>]) -> Option<CollisionSurface> {
        Some(CollisionSurface { tree: tree(&self.0.mesh, points)?, ..self.0.surface })
    }

    /// Returns the mesh.
    pub fn mesh(&self) -> &Mesh {
        &self.0.mesh
    }

    /// Returns whether the mesh is a solid. Otherwise it is a shell.
    pub fn is_closed(&self) -> bool {
        self.0.surface.outward.is_some()
    }

    pub(super) fn surface(&self) -> &CollisionSurface {
        &self.0.surface
    }

    /// Returns the center of the bounding box, in the coordinates of the mesh.
    pub(super) fn center(&self) -> Point3<f64> {
        let (low, high) = self.0.mesh.bounds();
        nalgebra::center(&low, &high)
    }
}

/// Builds the search tree of a mesh with these positions of its vertices. Equal positions of the mesh stay welded.
fn tree(mesh: &Mesh, points: &[Point3<f64>]) -> Option<SurfaceTree> {
    let weld = mesh.weld();
    SurfaceTree::new(points, mesh.surface().iter().map(|triangle| triangle.map(|v| weld[v as usize])))
}

/// Compares the vertices, the faces and the animation.
impl PartialEq for CollisionMesh {
    fn eq(&self, other: &Self) -> bool {
        let (a, b) = (self.mesh(), other.mesh());
        let is_same_mesh = || a.vertices() == b.vertices() && a.faces().eq(b.faces());
        let is_same_side = self.is_inverted() == other.is_inverted();
        Arc::ptr_eq(&self.0, &other.0)
            || (is_same_side && is_same_mesh() && self.animation() == other.animation())
    }
}

/// A collision mesh at one time in the local frame of a body, with lengths in cells.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PosedMesh<'a> {
    pub(super) surface: &'a CollisionSurface,
    /// Position of the origin of the mesh.
    pub(super) origin: Point3<f64>,
    pub(super) rotation: Matrix3<f64>,
    /// Cells per unit of the mesh.
    pub(super) scale: f64,
    /// Distance of the shape from the mesh if it is open. Zero if it is closed.
    pub(super) shell: f64,
    /// Distance by which the surface is outside of that of the shape, whose `shell` is included.
    pub(super) thickness: f64,
}

/// Compares the surfaces by identity.
impl PartialEq for PosedMesh<'_> {
    fn eq(&self, other: &Self) -> bool {
        let pose = |mesh: &Self| (mesh.origin, mesh.rotation, mesh.scale, mesh.shell, mesh.thickness);
        std::ptr::eq(self.surface, other.surface) && pose(self) == pose(other)
    }
}

impl PosedMesh<'_> {
    /// Returns the mesh with its surface `thickness` cells farther outwards. The thickness of an open mesh is at least
    /// that of a shell, which is part of it.
    pub(super) fn thickened(self, thickness: f64) -> Self {
        let shell = if self.is_closed() { 0.0 } else { SHELL };
        Self { shell, thickness: (thickness - shell).max(0.0), ..self }
    }

    pub(super) fn is_closed(&self) -> bool {
        self.surface.outward.is_some()
    }

    /// Converts a point of the mesh to the frame of the body.
    pub(super) fn point_in_body(&self, q: &Point3<f64>) -> Point3<f64> {
        self.origin + self.rotation * (q.coords * self.scale)
    }

    pub(super) fn point_in_mesh(&self, p: &Point3<f64>) -> Point3<f64> {
        Point3::from(self.rotation.tr_mul(&(p - self.origin)) / self.scale)
    }

    /// Returns an upper bound of the distance of a point from all points of the mesh, in cells.
    pub(super) fn greatest_distance(&self, p: &Point3<f64>) -> f64 {
        self.surface.tree.greatest_distance(&self.point_in_mesh(p)) * self.scale
    }

    /// Returns the signed distance of a point, in cells. For an open mesh it is negative only within the shell and the
    /// thickness.
    pub(super) fn signed_distance(&self, p: &Point3<f64>) -> SignedDistance {
        self.distance_below(p, f64::INFINITY)
            .unwrap_or(SignedDistance { distance: f64::INFINITY, normal: Vector3::x() })
    }

    /// Returns the signed distance of a point, or `None` if it is at least `limit` from the surface or NaN. `limit` is
    /// in cells.
    pub(super) fn distance_below(&self, p: &Point3<f64>, limit: f64) -> Option<SignedDistance> {
        let q = self.point_in_mesh(p);
        let closest = self.surface.tree.closest(&q, limit / self.scale, |_| true)?;
        let normal = self.rotation * self.surface.direction(&closest, &q);
        let distance = closest.distance * self.scale;
        Some(match self.surface.is_inside(&closest, &q) {
            true => SignedDistance { distance: -distance - self.thickness, normal },
            false => SignedDistance { distance: distance - self.shell - self.thickness, normal },
        })
    }

    /// Returns false only if no point of the AABB `center ± half` is within `skin`, in cells.
    pub(super) fn may_touch(&self, center: &Point3<f64>, half: &Vector3<f64>, skin: f64) -> bool {
        let reach = half.norm() + skin + self.shell + self.thickness;
        let (q, limit) = (self.point_in_mesh(center), reach / self.scale);
        let tree = &self.surface.tree;
        if tree.bounds_distance(&q) > limit {
            return self.surface.is_inverted;
        }
        if tree.closest(&q, limit * (1.0 + 1e-9), |_| true).is_some() {
            return true;
        }
        // Far from the surface, but perhaps deep inside.
        self.is_closed() && self.signed_distance(center).distance < 0.0
    }

    /// Returns where the segment from `a` to `b` first meets the mesh: the fraction of the segment, and the unit normal
    /// of the triangle on the side of `a`.
    pub(super) fn first_hit(&self, a: &Point3<f64>, b: &Point3<f64>) -> Option<(f64, Vector3<f64>)> {
        let (start, end) = (self.point_in_mesh(a), self.point_in_mesh(b));
        let (fraction, triangle) = self.surface.tree.cast(&start, &(end - start))?;
        let normal = self.rotation * self.surface.tree.triangle_normal(triangle);
        Some((fraction, if normal.dot(&(b - a)) > 0.0 { -normal } else { normal }))
    }

    /// Adds the intervals of t for which `point` + t `direction` is inside the mesh, longer by `margin` at both ends;
    /// of an open mesh, intervals of the half length `margin`, at least the thickness of the shell, around its
    /// triangles. A point that is nearer than `margin` but does not leave the mesh in this direction never leaves it.
    pub(super) fn add_overlaps(
        &self,
        point: &Point3<f64>,
        direction: &Vector3<f64>,
        margin: f64,
        intervals: &mut Vec<[f64; 2]>,
    ) {
        let first = intervals.len();
        self.add_crossings(point, direction, margin, intervals);
        let is_in_one = intervals[first..].iter().any(|[start, end]| *start <= 0.0 && *end >= 0.0);
        let least = if self.is_closed() { margin } else { margin.max(0.0) };
        if !is_in_one && self.signed_distance(point).distance < least {
            intervals.push([f64::NEG_INFINITY, f64::INFINITY]);
        }
    }

    /// Adds the intervals along a line: see [`add_overlaps`](Self::add_overlaps).
    fn add_crossings(
        &self,
        point: &Point3<f64>,
        direction: &Vector3<f64>,
        margin: f64,
        intervals: &mut Vec<[f64; 2]>,
    ) {
        let (q, along) = (self.point_in_mesh(point), self.rotation.tr_mul(direction));
        let mut crossings = self.surface.tree.crossings(&q, &along);
        let Some(outward) = self.surface.outward else {
            let half = margin.max(self.shell);
            let around = |(t, _)| [t * self.scale - half, t * self.scale + half];
            intervals.extend(crossings.into_iter().map(around));
            return;
        };
        crossings.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        // A line through an edge or a corner crosses several triangles at once.
        let size = crossings.last().map_or(0.0, |last| last.0.abs().max(crossings[0].0.abs()));
        let is_same = |a: &(f64, u32), b: &(f64, u32)| {
            let faces = |triangle| self.surface.tree.triangle_normal(triangle).dot(&along) > 0.0;
            a.0 - b.0 <= 1e-9 * size && faces(a.1) == faces(b.1)
        };
        crossings.dedup_by(|a, b| is_same(a, b));
        // A line begins and ends in the solid that is all outside of the mesh.
        let is_inverted = self.surface.is_inverted;
        let (mut winding, mut entered) = if is_inverted { (1, f64::NEG_INFINITY) } else { (0, 0.0) };
        for (t, triangle) in crossings {
            let leaves = self.surface.tree.triangle_normal(triangle).dot(&along) * outward > 0.0;
            let before = winding;
            winding += if leaves { -1 } else { 1 };
            if before <= 0 && winding > 0 {
                entered = t * self.scale - margin;
            } else if before > 0 && winding <= 0 && entered <= t * self.scale + margin {
                intervals.push([entered, t * self.scale + margin]);
            }
        }
        if is_inverted && winding > 0 {
            intervals.push([entered, f64::INFINITY]);
        }
    }

    /// Returns the axes of the mesh.
    pub(super) fn axes(&self) -> [Vector3<f64>; 3] {
        [0, 1, 2].map(|axis| self.rotation.column(axis).into_owned())
    }
}

impl CollisionSurface {
    /// Returns the nearest triangle of a point: the vertices of its corners, and the closest point with its barycentric
    /// weights. `None` for NaN.
    pub(super) fn feature(&self, q: &Point3<f64>) -> Option<([u32; 3], [f64; 3], Point3<f64>)> {
        let closest = self.tree.closest(q, f64::INFINITY, |_| true)?;
        let (corners, weights) = self.tree.barycentric(closest.triangle, &closest.point);
        Some((corners, weights, closest.point))
    }

    /// Returns whether a point, whose closest point is given, is inside a closed mesh.
    fn is_inside(&self, closest: &ClosestPoint, q: &Point3<f64>) -> bool {
        match self.outward {
            None => false,
            Some(outward) if outward > 0.0 => closest.is_inside(q),
            Some(_) => (q - closest.point).dot(&closest.normal) > 0.0,
        }
    }

    /// Returns the gradient of the distance: the direction from the closest point for a point outside. On the surface
    /// it is the normal there.
    fn direction(&self, closest: &ClosestPoint, q: &Point3<f64>) -> Vector3<f64> {
        let outward = self.outward.unwrap_or(1.0);
        let away = q - closest.point;
        let sign = if self.is_inside(closest, q) { -1.0 } else { 1.0 };
        // Below this length the direction is rounding.
        let least = 1e-9 * (1.0 + closest.point.coords.amax());
        if closest.distance > least { away * (sign / closest.distance) } else { closest.normal * outward }
    }
}
