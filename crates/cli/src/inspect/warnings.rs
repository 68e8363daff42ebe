//! Finds probable mistakes in a scene: bodies that begin inside a collider, bodies that are softer than specified, bodies
//! that break with wide regions, bodies that break and formats with the same faces in all frames, and the cautions of a
//! run.

use supple::{Body, Collider, Shape};
use supple_io::run::{Caution, Prepared, Softened};
use supple_io::scene::Scene;

use super::placed::Placed;
use crate::terminal::number;

/// Depth in a collider, in cells, up to which a body only touches it.
const TOLERANCE: f64 = 1e-3;

/// Greatest half-width of the regions with which cracks begin at notches.
const CRACK_HALF_WIDTH: usize = 2;

/// Returns the warnings about a scene, one per body and kind.
pub(super) fn warnings(scene: &Scene, prepared: &Prepared) -> Vec<String> {
    let simulation = &prepared.simulation;
    let mut warnings = Vec::new();
    for (index, data) in scene.bodies.iter().enumerate() {
        let body = simulation.body(index);
        let placed = Placed::new(data, &body);
        let colliders =
            (0..simulation.collider_count()).map(|index| simulation.collider(index).description());
        let overlaps = colliders.enumerate().filter(|(_, collider)| collider.enabled.value(0.0));
        let overlaps = overlaps.filter_map(|(index, collider)| overlap(&placed, &body, index, collider));
        warnings.extend(overlaps);
        let softened = Softened::of(body, prepared.substeps, simulation.dt());
        warnings.extend(softened.map(|softened| format!("body {}: {softened}", data.name)));
        warnings.extend(wide_regions(&body));
    }
    let refused = prepared.check_topologies(&scene.output.format).err();
    warnings.extend(refused.map(|error| format!("`supple run` refuses the scene: {error}")));
    // Here `overlap` finds the bodies inside a collider, with their depth.
    let is_new = |caution: &&Caution| caution.is_warning() && !matches!(caution, Caution::InCollider { .. });
    warnings.extend(prepared.cautions.iter().filter(is_new).map(ToString::to_string));
    warnings
}

/// Returns a warning if a body breaks and its regions are wider than [`CRACK_HALF_WIDTH`].
fn wide_regions(body: &Body) -> Option<String> {
    let (half_width, name) = (body.half_width(), body.name());
    let is_wide = body.fracture().is_some() && half_width > CRACK_HALF_WIDTH.into();
    is_wide.then(|| {
        format!(
            "body {name}: its regions reach {half_width} cells to each side, which smooths the strain at notches and at the \
             fronts of cracks: it breaks at higher loads, and cracks can miss a notch or stop. With up to \
             {CRACK_HALF_WIDTH} cells they do not: raise simulation.substeps, lower the stiffness or lattice_vertices, or \
             set half_width"
        )
    })
}

/// Returns a warning if vertices or face centers of a body are more than [`TOLERANCE`] cells inside a
/// collider at the start.
fn overlap(placed: &Placed<'_>, body: &Body, index: usize, collider: &Collider) -> Option<String> {
    let (mut inside, mut count, mut depth) = (0_usize, 0_usize, 0.0_f64);
    let distance = collider.signed_distance_at(0.0).ok()?;
    for point in placed.surface_points() {
        let point_depth = -distance(point);
        count += 1;
        if point_depth > TOLERANCE * body.lattice().cell_size() {
            inside += 1;
            depth = depth.max(point_depth);
        }
    }
    let place = match (inside, &collider.shape) {
        (0, _) => return None,
        (_, Shape::Plane { .. }) if inside == count => "under",
        _ if inside == count => "inside",
        _ => "partly inside",
    };
    let room = match &collider.shape {
        Shape::Mesh { .. } if inside == count => "; if the collider is a room, set `inside = true` of it",
        _ => "",
    };
    Some(format!(
        "body {}: it begins {place} collider.{index}, up to {} deep; the first steps push it out; \
         change its `translate`, or move the collider{room}",
        body.name(),
        number(depth)
    ))
}
