//! Finds the point of a surface at rest that a sample touches, and its cell.

use nalgebra::{Point3, Vector3};

use super::surface::ContactSurface;
use crate::lattice::Lattice;

/// Greatest product of the normals of a surface and of a sample, at rest of the surface, for which they touch: they
/// have to face each other. The sides of a stack of boxes would otherwise push each other where the boxes are flush.
pub(super) const FACING: f64 = -0.25;

/// Greatest additional distance, in cells, of a point of the surface that faces the sample, if the closest one does
/// not.
const FACING_RANGE: f64 = 0.25;

/// Greatest additional distance, in cells, of the side of a surface that a sample touched in the last step, if another
/// side is closer. Before the impulses of a step, a sample that is pressed near an edge may be closer to the other side
/// of it.
const SIDE_RANGE: f64 = 0.6;

/// Distance in cells up to which a sample outside a surface at rest may touch it in the deformed lattice.
const OUTSIDE: f64 = 0.02;

/// Distance at rest up to which a surface is searched, as a multiple of the distance at which a sample may touch it:
/// the lattice may be compressed.
pub(super) const RANGE: f64 = 2.0;

/// Greatest depth in cells below an open surface and in self-contact.
pub(super) const MAX_SHELL_DEPTH: f64 = 1.0;

/// Distance in cells from an open surface at which a sample touches it. A sample moves by at most 0.5 cells between two
/// searches, up to a limit of searches in a step, so that it is seen before it is far on the other side.
const SHELL: f64 = 0.1;

/// Least product of the normals of a contact in two consecutive steps, if the sample did not change the side.
pub(super) const SAME_SIDE: f64 = 0.3;

/// Fraction of the distance to the center of a cell of the same part by which a point of the surface of a part is
/// moved to find its cell.
const INWARDS: f64 = 1e-3;

/// Distance in cells from a surface with a thickness from which on the normal is the direction from the closest point:
/// at edges and rims the layer around the surface is round.
const LEAST_OFFSET: f64 = 1e-3;

/// Least product of that direction and the normal of a triangle of an open surface, at which a sample is opposite to
/// the triangle, and not beyond the rim.
const OPPOSITE: f64 = 0.5;

/// The point of a surface at rest that a sample touches.
pub(super) struct RestPoint {
    /// Rest coordinates.
    pub(super) rest: Point3<f64>,
    /// Unit normal at rest.
    pub(super) normal: Vector3<f64>,
}

/// Returns the distance in cells at which samples touch a surface with the thickness `layer` in cells.
pub(super) fn touching_distance(is_closed: bool, layer: f64) -> f64 {
    if is_closed { layer } else { SHELL.max(layer) }
}

/// A sample for which the closest point of a closed surface is searched.
#[derive(Clone, Copy)]
pub(super) struct SurfaceQuery {
    /// The sample in the rest shape of the surface.
    pub(super) rest: Point3<f64>,
    /// The cell of this point.
    pub(super) cell: u32,
    /// Grid index of the cell.
    pub(super) index: [i32; 3],
    /// Direction at rest in which the surface of the sample faces.
    pub(super) facing: Option<Vector3<f64>>,
    /// Normal at rest with which the sample touched in the last step.
    pub(super) side: Option<Vector3<f64>>,
    /// Greatest distance in cells.
    pub(super) limit: f64,
    /// Distance in cells at which samples touch the surface.
    pub(super) thickness: f64,
    /// Whether the sample is of another part of the body, which fits together with this one where the body broke.
    pub(super) fit_together: bool,
}

/// Returns the closest point of a closed surface that faces a sample, on the side that the sample touched in the last
/// step if that is near. Returns `None` if no point at a distance below `limit` faces it, or the
/// sample is outside.
pub(super) fn closest_on_closed(surface: &ContactSurface, query: &SurfaceQuery) -> Option<RestPoint> {
    let &SurfaceQuery { ref rest, cell, index, facing, side, limit, thickness, fit_together } = query;
    let tree = surface.tree_at(cell)?;
    let farthest_outside = OUTSIDE + RANGE * thickness;
    let [low, high] = surface.distance_bounds((cell, index), rest, tree);
    // The parts of an open surface have no side beyond their rims, and near the rims of cracks the side is decided below.
    if surface.is_closed && !fit_together && low > farthest_outside {
        return None;
    }
    let closest = tree.closest(rest, limit.min(high.max(-low)), |_| true)?;
    let is_inside = closest.is_inside(rest);
    if !is_inside && closest.distance > farthest_outside {
        return None;
    }
    // At small folds of the rims of cracks, the pseudonormals may belong to the inner side.
    if fit_together && side.is_none() && is_inside && closest.distance > OUTSIDE && !tree.encloses(rest) {
        return None;
    }
    let faces = |normal: &Vector3<f64>| facing.is_none_or(|facing| normal.dot(&facing) <= FACING);
    let is_same_side =
        |normal: &Vector3<f64>| faces(normal) && side.is_some_and(|side| normal.dot(&side) > SAME_SIDE);
    // The closest point of some triangles. The pseudonormal at an edge may belong to other triangles.
    let among = |range: f64, accepts: &dyn Fn(&Vector3<f64>) -> bool| {
        let found = tree
            .closest(rest, closest.distance + range, |triangle| accepts(&tree.triangle_normal(triangle)))?;
        let normal = if accepts(&found.normal) { found.normal } else { tree.triangle_normal(found.triangle) };
        Some(RestPoint { rest: found.point, normal })
    };
    // The parts fit together: where a sample is near a triangle that does not face it, it is no deeper behind others.
    let facing_range = match fit_together {
        true => FACING_RANGE.min(closest.distance),
        false => FACING_RANGE,
    };
    let as_before = side.filter(|_| !is_same_side(&closest.normal));
    if let Some(point) = as_before.and_then(|_| among(SIDE_RANGE, &is_same_side)) {
        return Some(point);
    }
    match faces(&closest.normal) {
        true if thickness > 0.0 && !is_inside && closest.distance > LEAST_OFFSET => {
            let normal = (rest - closest.point) / closest.distance;
            Some(RestPoint { rest: closest.point, normal })
        }
        true => Some(RestPoint { rest: closest.point, normal: closest.normal }),
        false => among(facing_range, &faces),
    }
}

/// Returns the closest point of an open surface, with the normal on the side of the sample. `side` is positive for the
/// normal of the side from which the sample came, and gets the sample's offset from the surface. `thickness`: distance
/// in cells at which samples touch the surface.
pub(super) fn closest_on_shell(
    surface: &ContactSurface,
    (rest, cell): (&Point3<f64>, u32),
    thickness: f64,
    side: impl Fn(&Vector3<f64>, &Vector3<f64>) -> f64,
) -> Option<RestPoint> {
    let closest = surface.tree_at(cell)?.closest(rest, MAX_SHELL_DEPTH + RANGE * thickness, |_| true)?;
    let offset = rest - closest.point;
    let normal = if side(&closest.normal, &offset) < 0.0 { -closest.normal } else { closest.normal };
    let (length, along) = (closest.distance, offset.dot(&normal));
    let is_beside = along > 0.0 || along.abs() < OPPOSITE * length;
    let normal = if thickness > 0.0 && length > LEAST_OFFSET && is_beside { offset / length } else { normal };
    Some(RestPoint { rest: closest.point, normal })
}

/// Returns the rest coordinates of a point with local coordinates in a cell.
pub(super) fn rest_point(lattice: &Lattice, cell: u32, local: [f64; 3]) -> Point3<f64> {
    let index = lattice.cells()[cell as usize];
    Point3::from(std::array::from_fn(|axis| f64::from(index[axis]) + local[axis]))
}

/// Returns the cell that contains a point of the surface at rest, and its local coordinates there. `near`: a cell that
/// is near; it is taken if no cell contains the point, as a surface may end at the boundary of the lattice.
pub(super) fn cell_of(lattice: &Lattice, rest: &Point3<f64>, near: u32) -> (u32, [f32; 3]) {
    let local = |cell: u32| {
        let index = lattice.cells()[cell as usize];
        std::array::from_fn::<f64, 3, _>(|a| rest[a] - f64::from(index[a]))
    };
    if !lattice.broken_joints().is_empty() {
        // The cell at the point may belong to another part, on the other side of a crack. Some of the smooth surface of
        // a crack lies outside the cells of its part.
        let index = lattice.cells()[near as usize];
        let inwards = |a: usize| f64::from(index[a]) + 0.5 - rest[a];
        let moved: [f64; 3] = std::array::from_fn(|a| rest[a] + INWARDS * inwards(a));
        let found = lattice.cell_at(moved.map(|x| x.floor() as i32));
        let part = lattice.component_of_cell(near);
        let cell = found.filter(|&cell| lattice.component_of_cell(cell) == part).unwrap_or(near);
        return (cell, local(cell).map(|u| u.clamp(-1.0, 2.0) as f32));
    }
    let is_inside = |local: &[f64; 3]| local.iter().all(|u| (0.0..=1.0).contains(u));
    let found =
        if is_inside(&local(near)) { None } else { lattice.cell_at(rest.map(|x| x.floor() as i32).into()) };
    let cell = found.unwrap_or(near);
    (cell, local(cell).map(|u| u.clamp(0.0, 1.0) as f32))
}
