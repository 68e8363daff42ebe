//! The surface of an animated mesh during a step: its shape before and after, and its velocity.

use nalgebra::{Matrix3, Point3, Vector3};

use super::collision_mesh::{CollisionMesh, CollisionSurface, PosedMesh};

/// The surface of an animated mesh before and after a step.
#[derive(Clone, Debug)]
pub(super) struct AnimatedSurface {
    mesh: CollisionMesh,
    before: SurfaceAt,
    after: SurfaceAt,
    /// Greatest displacement of a vertex in the step, in the unit of the mesh.
    greatest: f64,
}

/// The surface at one time.
#[derive(Clone, Debug)]
struct SurfaceAt {
    phase: f64,
    points: Vec<Point3<f64>>,
    surface: CollisionSurface,
}

impl AnimatedSurface {
    /// Returns the surface at time 0, or `None` if the mesh is not animated.
    pub(super) fn new(mesh: &CollisionMesh) -> Option<Self> {
        mesh.animation()?;
        let points = mesh.mesh().vertices().to_vec();
        // No animation has this phase, so that the first call computes the positions.
        let rest = SurfaceAt { phase: f64::NAN, points, surface: mesh.surface().clone() };
        let mut surface = Self { mesh: mesh.clone(), before: rest.clone(), after: rest, greatest: 0.0 };
        surface.advance([0.0, 0.0]);
        Some(surface)
    }

    /// Computes the surfaces at two times in seconds.
    pub(super) fn advance(&mut self, times: [f64; 2]) {
        let Self { mesh, before, after, greatest } = self;
        let Some(animation) = mesh.animation() else { return };
        let phases = times.map(|time| animation.phase(time));
        if before.phase.to_bits() != phases[0].to_bits() {
            std::mem::swap(before, after);
        }
        for (at, phase) in [(&mut *before, phases[0]), (&mut *after, phases[1])] {
            if at.phase.to_bits() == phase.to_bits() {
                continue;
            }
            at.phase = phase;
            animation.positions_at(phase, &mut at.points);
            // A mesh that has collapsed to a line keeps its last surface.
            if let Some(surface) = mesh.surface_at(&at.points) {
                at.surface = surface;
            }
        }
        let distances = before.points.iter().zip(&after.points).map(|(a, b)| (b - a).norm());
        *greatest = distances.fold(0.0, f64::max);
    }

    /// Returns the surface at the end of the step if `is_after`, or else at its start. They are the same if no vertex
    /// moves.
    pub(super) fn surface(&self, is_after: bool) -> &CollisionSurface {
        if is_after || self.greatest == 0.0 { &self.after.surface } else { &self.before.surface }
    }

    /// Returns the deformation during the step, or `None` if no vertex moves. The meshes are those before and after the
    /// step.
    pub(super) fn deformation<'a>(
        &'a self,
        before: PosedMesh<'a>,
        after: PosedMesh<'a>,
    ) -> Option<Deformation<'a>> {
        let points = [&self.before.points[..], &self.after.points[..]];
        (self.greatest > 0.0).then_some(Deformation { before, after, points, greatest: self.greatest })
    }
}

/// The deformation of a mesh during a step, in the frame of a body.
#[derive(Clone, Copy, Debug)]
pub(super) struct Deformation<'a> {
    before: PosedMesh<'a>,
    after: PosedMesh<'a>,
    /// Vertices before and after the step, in the coordinates of the mesh.
    points: [&'a [Point3<f64>]; 2],
    greatest: f64,
}

impl Deformation<'_> {
    /// Returns the greatest displacement of a vertex, in cells, beside the motion of the pose.
    pub(super) fn greatest(&self) -> f64 {
        self.greatest * self.after.scale
    }

    /// Returns where a point that moves with the surface is after the step, if it is at `p` before it: at the same
    /// place beside its nearest triangle.
    pub(super) fn carried(&self, p: &Point3<f64>) -> Option<Point3<f64>> {
        let q = self.before.point_in_mesh(p);
        let (corners, weights, closest) = self.before.surface.feature(&q)?;
        let [before, after] = self.points.map(|points| corners.map(|v| points[v as usize]));
        let (offset, normals) = (q - closest, [before, after].map(normal));
        let height = offset.dot(&normals[0]);
        let moved = weighted(&after, &weights) + (offset + (normals[1] - normals[0]) * height);
        Some(self.after.point_in_body(&moved))
    }

    /// Returns the displacement in the step of the point of the surface that is nearest to `p` after the step, in
    /// cells.
    pub(super) fn displacement_at(&self, p: &Point3<f64>) -> Option<Vector3<f64>> {
        let (corners, weights, _) = self.after.surface.feature(&self.after.point_in_mesh(p))?;
        let [before, after] =
            self.points.map(|points| weighted(&corners.map(|v| points[v as usize]), &weights));
        Some(self.after.point_in_body(&after) - self.before.point_in_body(&before))
    }
}

/// Returns the unit normal of a triangle, zero if it has no area.
fn normal([a, b, c]: [Point3<f64>; 3]) -> Vector3<f64> {
    (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_default()
}

fn weighted(corners: &[Point3<f64>; 3], weights: &[f64; 3]) -> Point3<f64> {
    let columns = Matrix3::from_columns(&corners.map(|corner| corner.coords));
    Point3::from(columns * Vector3::from(*weights))
}
