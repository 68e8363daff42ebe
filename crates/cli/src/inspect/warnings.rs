//! Finds probable mistakes in a scene: bodies that begin inside a collider, bodies that overlap, bodies
//! that positions in `f32` cannot represent, bodies that are softer than specified, bodies that break with wide
//! regions, and bodies that break and formats with the same faces in all frames.

use supple::{Body, Collider, Shape};
use supple_io::run::{Prepared, Softened};
use supple_io::scene::Scene;

use super::placed::Placed;
use crate::terminal::number;

/// Length below which positions are equal, in cells: the spacing of `f32` at the coordinates of a body, and
/// its depth in a collider.
///
/// A position that is off by this length strains a cell by 0.1 %, the relative error from which on `run`
/// reports a volume as not kept.
const TOLERANCE: f64 = 1e-3;

/// Distance from the origin, in extents of the body, beyond which its position is reported as a mistake. The
/// spacing of `f32` is then more than a twentieth of the body.
const FAR: f64 = 1e6;

/// Greatest half-width of the regions with which cracks begin at notches.
const CRACK_HALF_WIDTH: usize = 2;

/// Returns the warnings about a scene, one per body and kind.
pub(super) fn warnings(scene: &Scene, prepared: &Prepared) -> Vec<String> {
    let simulation = &prepared.simulation;
    let mut warnings = Vec::new();
    for (index, data) in scene.bodies.iter().enumerate() {
        let body = simulation.body(index);
        let placed = Placed::new(data, &body);
        warnings.extend(precision(&placed, &body));
        let colliders =
            (0..simulation.collider_count()).map(|index| simulation.collider(index).description());
        let overlaps =
            colliders.enumerate().filter_map(|(index, collider)| overlap(&placed, &body, index, collider));
        warnings.extend(overlaps);
        let softened = Softened::of(body, prepared.substeps, simulation.dt());
        warnings.extend(softened.map(|softened| format!("body {}: {softened}", data.name)));
        warnings.extend(wide_regions(&body));
    }
    let refused = prepared.check_topologies(&scene.output.format).err();
    warnings.extend(refused.map(|error| format!("`supple run` refuses the scene: {error}")));
    warnings.extend(prepared.overlaps.iter().map(ToString::to_string));
    warnings
}

/// Returns a warning if a body breaks and its regions are wider than [`CRACK_HALF_WIDTH`].
fn wide_regions(body: &Body) -> Option<String> {
    let (half_width, name) = (body.half_width(), body.name());
    let is_wide = body.fracture().is_some() && half_width > CRACK_HALF_WIDTH;
    is_wide.then(|| {
        format!(
            "body {name}: its regions reach {half_width} cells to each side, which smooths the strain at notches and at the \
             fronts of cracks: it breaks at higher loads, and cracks can miss a notch or stop. With up to \
             {CRACK_HALF_WIDTH} cells they do not: raise simulation.substeps, lower the stiffness or lattice_vertices, or \
             set half_width"
        )
    })
}

/// Returns a warning if the spacing of `f32` at the greatest coordinate of a body exceeds [`TOLERANCE`]
/// cells.
fn precision(placed: &Placed<'_>, body: &Body) -> Option<String> {
    let (low, high) = placed.bounds();
    let greatest = low.iter().chain(&high).fold(0.0, |greatest: f64, x| greatest.max(x.abs()));
    let (spacing, cell_size) = (spacing(greatest), body.lattice().cell_size());
    if spacing <= TOLERANCE * cell_size {
        return None;
    }
    let extent = (0..3).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max);
    let from_origin = (0..3).map(|axis| low[axis].max(-high[axis]).max(0.0).powi(2)).sum::<f64>().sqrt();
    let problem = if from_origin > FAR * extent {
        format!(
            "it is {} from the origin, {} times its extent; check `translate` and the unit of the mesh",
            number(from_origin),
            number(from_origin / extent)
        )
    } else if from_origin > extent {
        "move it nearer to the origin with `translate`".to_owned()
    } else {
        "its cells are too small for its size; choose a larger `cell_size` or fewer `lattice_vertices`"
            .to_owned()
    };
    Some(format!(
        "body {}: frames have 32-bit numbers, which are {} apart at the coordinate {}, and a cell has the size {}: \
         {problem}",
        body.name(),
        number(spacing),
        number(greatest),
        number(cell_size)
    ))
}

/// Returns the distance of the magnitude `value` to the next greater `f32`.
fn spacing(value: f64) -> f64 {
    let value = (value as f32).min(f32::MAX / 2.0);
    f64::from(f32::from_bits(value.to_bits() + 1) - value)
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
    Some(format!(
        "body {}: it begins {place} collider.{index}, up to {} deep; the first steps push it out; \
         change its `translate`, or move the collider",
        body.name(),
        number(depth)
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_spacing_of_f32_is_a_power_of_two() {
        assert_eq!([1.0, 1.9, 1000.0, 1e6].map(spacing), [-23, -23, -14, -4].map(|power| 2_f64.powi(power)));
        assert!(spacing(1e300).is_finite() && spacing(0.0) > 0.0);
    }
}
