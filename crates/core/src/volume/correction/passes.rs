//! Restores the volume of a component in several passes, where a single cubic has no root within the cap.
//!
//! The field that is rotated with the shape matching has the lengths of the rest shape: it can move thin parts
//! of a stretched body beyond their medial axis while parts beside constrained vertices still have too much
//! volume, and it moves folded parts against each other. Each pass therefore turns the field to the present
//! shape, which the passes before have corrected. There are two turned fields, with the field `V` at rest and
//! the deformation gradient `F_i` at a vertex, from the differences of its neighbors:
//!
//! ```text
//! Material:  v_i = F_i V_i, shortened to |V_i|
//! Normals:   v_i = u_i / max_j |u_j|,  u_i = cof(F_i) V_i,  cof(F) = det(F) F^-T
//! ```
//!
//! The field `Material` moves the vertices as if the rest shape had been moved along `V` before it was
//! deformed, so that thin parts move less than thick parts, and sections of a body are not turned inside out
//! while the scale is less than the thickness. Vectors in directions in which the body is stretched are
//! shortened, because they would grow with the stretch. It cannot restore the volume of a body of which large
//! parts are inside out, and hardly where the cells beside constrained vertices are stretched the most.
//!
//! The field `Normals` is used for the rest. It consists of the area vectors of the deformed body (Nanson's
//! formula), which exist for every shape. They approximate the gradient of the volume.

use nalgebra::Vector3;

use super::evaluate::{Correction, VOLUME_TOLERANCE};
use super::workspace::{Component, CorrectionWorkspace, Passes};
use crate::parallel::Executor;
use crate::simd::vector::wide;
use crate::volume::adjacency::Adjacency;
use crate::volume::cubic::smallest_root;
use crate::volume::external_forces::{self, ExternalForce};
use crate::volume::line::Moving;

/// Greatest scale of a pass, relative to the thickness: a pass with the field `Material` reduces free parts to half of
/// their thickness at most.
const PASS_CAP: f64 = 0.5;

/// Volume that one pass with the field `Normals` removes at most, relative to the greater of the present volume
/// and the rest volume. If half of the volume is constrained, the free half keeps 0.4 of its volume.
const SHRINKING: f64 = 0.3;

/// Volume that one pass with the field `Normals` adds at most, relative to the greater of the present volume and
/// the rest volume.
const GROWTH: f64 = 0.5;

/// Volume, relative to the rest volume, up to which a body is left to the single cubic: it is flat or inside
/// out, so that its shape does not determine where the volume belongs.
const FLAT: f64 = 1e-3;

/// Magnitude to which components of directions are clamped, so that they stay finite in f32.
const MAX_DIRECTION: f64 = 1e37;

/// Turned field; see the module.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Turned {
    Material,
    Normals,
}

impl Turned {
    /// Returns the maximum number of passes. Free parts keep at least 1/256 of their thickness in eight passes
    /// with [`PASS_CAP`], and 16 passes with [`SHRINKING`] reduce the volume to 1/300.
    fn passes(self) -> usize {
        match self {
            Self::Material => 8,
            Self::Normals => 16,
        }
    }
}

impl Correction {
    /// Restores the volume of the components whose single cubic has not restored it.
    ///
    /// On return the points are at the start of the last pass, with the field of this pass, and
    /// `workspace.lambdas` has its scale. The displacement before the last pass is added to
    /// `workspace.offsets`. A component whose error the passes do not reduce keeps the result of the single
    /// cubic.
    #[cold]
    pub(super) fn solve_in_passes(
        &self,
        workspace: &mut CorrectionWorkspace,
        executor: &Executor,
        forces: &[ExternalForce],
    ) {
        workspace.has_surface = false;
        self.begin_passes(workspace);
        for field in [Turned::Material, Turned::Normals] {
            if !workspace.passes.components.iter().any(|component| component.unsolved) {
                break;
            }
            self.restart(workspace);
            for pass in 1..=field.passes() {
                if !workspace.passes.components.iter().any(|component| component.active) {
                    break;
                }
                self.turn_field(workspace, forces, field);
                self.measure.evaluate(executor, &mut workspace.scratch);
                for component in 0..self.rest.len() {
                    self.solve_pass(workspace, component, field, pass == field.passes());
                }
            }
        }
        self.end_passes(workspace);
    }

    /// Stores the points and the results of the single cubic, and selects the components.
    fn begin_passes(&self, workspace: &mut CorrectionWorkspace) {
        let CorrectionWorkspace { rest, passes, reports, lambdas, scratch, .. } = workspace;
        passes.start.clear();
        passes.start.extend_from_slice(&scratch.points);
        passes.components.clear();
        let coefficients = scratch.coefficients.iter().zip(&self.caps);
        let results = reports.iter().zip(lambdas).zip(rest.iter().zip(coefficients));
        passes.components.extend(results.map(|((report, lambda), (rest, (c, cap)))| Component {
            unsolved: report.capped && *cap > 0.0 && c[0] > FLAT * rest,
            single: [*lambda, report.residual * rest],
            excess: f64::INFINITY,
            ..Component::default()
        }));
    }

    /// Moves the points of the unsolved components back to their start, and activates these components.
    fn restart(&self, workspace: &mut CorrectionWorkspace) {
        let CorrectionWorkspace { passes, scratch, lambdas, .. } = workspace;
        for (component, (cap, lambda)) in passes.components.iter_mut().zip(self.caps.iter().zip(lambdas)) {
            component.active = component.unsolved;
            if component.active {
                // A correction that is limited to less than the thickness is limited as a whole.
                component.budget = if self.max_correction < 1.0 { *cap } else { f64::INFINITY };
                (component.excess, *lambda) = (f64::INFINITY, 0.0);
            }
        }
        let starts = passes.start.iter().zip(&self.adjacency.component_of_vertex);
        for (point, (start, &component)) in scratch.points.iter_mut().zip(starts) {
            if passes.components[component as usize].active {
                *point = *start;
            }
        }
    }

    /// Turns the field of the active components to the present shape.
    fn turn_field(&self, workspace: &mut CorrectionWorkspace, forces: &[ExternalForce], field: Turned) {
        let CorrectionWorkspace { passes, scratch, order, ramp, .. } = workspace;
        let (points, ramp) = (&mut scratch.points, self.ramp_of(ramp));
        for (vertex, &component) in self.adjacency.component_of_vertex.iter().enumerate() {
            let component = &passes.components[component as usize];
            if component.active {
                let factor = ramp.map_or(1.0, |ramp| f64::from(ramp.factors[vertex]));
                let v = self.field.directions[vertex].map(|v| f64::from(v) * factor);
                // Directions do not enter the directions of other vertices.
                let direction = turned(&self.adjacency, vertex, points, v, field);
                let direction = direction.map(|v| v.clamp(-MAX_DIRECTION, MAX_DIRECTION) as f32);
                points[vertex].set_direction(direction.into());
            }
        }
        if field == Turned::Normals {
            self.normalize_directions(passes, points);
        }
        let acts =
            |force: &ExternalForce| passes.components[self.adjacency.component(force.vertex as usize)].active;
        external_forces::remove_force_directions(forces, acts, order, points);
    }

    /// Divides the directions of each active component by the greatest length of a direction.
    fn normalize_directions(&self, passes: &mut Passes, points: &mut [Moving]) {
        let vertices = || self.adjacency.component_of_vertex.iter().map(|&component| component as usize);
        passes.components.iter_mut().for_each(|component| component.greatest = 0.0);
        for (point, component) in points.iter().zip(vertices()) {
            let component = &mut passes.components[component];
            component.greatest = component.greatest.max(length(point));
        }
        for (point, component) in points.iter_mut().zip(vertices()) {
            let Component { active, greatest, .. } = passes.components[component];
            if active && greatest > 0.0 {
                point.set_direction(point.direction().map(|v| (f64::from(v) / greatest) as f32));
            }
        }
    }

    /// Solves the cubic of a pass for one component. Moves its points, unless this is the last pass of the
    /// component.
    fn solve_pass(
        &self,
        workspace: &mut CorrectionWorkspace,
        component: usize,
        field: Turned,
        is_last: bool,
    ) {
        let CorrectionWorkspace { passes, scratch, lambdas, .. } = workspace;
        let state = &mut passes.components[component];
        if !state.active {
            return;
        }
        let ([c0, c1, c2, c3], rest) = (scratch.coefficients[component], workspace.rest[component]);
        let target = match field {
            Turned::Material => rest,
            Turned::Normals => pass_volume(c0, rest),
        };
        let cap = (PASS_CAP * self.field.thickness[component]).min(state.budget);
        let root = smallest_root([c0 - target, c1, c2, c3], cap);
        let excess = root.residual + (target - rest);
        let is_better = excess.abs() < state.excess.abs();
        (lambdas[component], state.excess) = (root.lambda, excess);
        state.budget -= root.lambda.abs();
        state.unsolved = excess.is_nan() || excess.abs() > VOLUME_TOLERANCE * rest;
        state.active = state.unsolved && !is_last && is_better && state.budget > 0.0;
        if state.active {
            lambdas[component] = 0.0;
            let vertices = self.adjacency.component_of_vertex.iter().zip(&mut scratch.points);
            for (_, point) in vertices.filter(|(of, _)| **of as usize == component) {
                point.advance(root.lambda as f32);
            }
        }
    }

    /// Adds the displacements to `workspace.offsets`, and reports the components. Resets the components that
    /// the passes have not improved.
    fn end_passes(&self, workspace: &mut CorrectionWorkspace) {
        let CorrectionWorkspace { passes, scratch, offsets, lambdas, .. } = workspace;
        for (state, lambda) in passes.components.iter_mut().zip(lambdas) {
            state.active = state.excess.abs() < state.single[1].abs();
            if !state.active {
                [*lambda, state.excess] = state.single;
            }
        }
        offsets.resize(scratch.points.len(), [0.0; 3]);
        let vertices = self.adjacency.component_of_vertex.iter().zip(&passes.start);
        for ((&component, start), (point, offset)) in vertices.zip(scratch.points.iter_mut().zip(offsets)) {
            if passes.components[component as usize].active {
                let (p, from) = (point.position(), start.position());
                *offset = std::array::from_fn(|k| offset[k] + (p[k] - from[k]));
            } else {
                *point = *start;
            }
        }
        for component in 0..self.rest.len() {
            let excess = workspace.passes.components[component].excess;
            self.report(workspace, component, excess);
        }
    }
}

/// Returns the volume for which a pass with the field `Normals` solves. `volume`: present volume.
fn pass_volume(volume: f64, rest: f64) -> f64 {
    let scale = volume.abs().max(rest);
    rest.max(volume - SHRINKING * scale).min(volume + GROWTH * scale)
}

/// Returns the turned vector at a vertex: `F v`, shortened to the length of `v`, or `cof(F) v`, which is the
/// sum of `v_x f_y × f_z`, `v_y f_z × f_x` and `v_z f_x × f_y` with the columns `f` of `F`. Along each axis every
/// vertex has a neighbor.
fn turned(
    adjacency: &Adjacency,
    vertex: usize,
    points: &[Moving],
    v: [f64; 3],
    field: Turned,
) -> Vector3<f64> {
    let neighbors = &adjacency.neighbors[vertex];
    let position = |side: usize| wide(points[neighbors[side] as usize].position());
    let [x, y, z] = [0, 1, 2].map(|axis| {
        let sides = [2 * axis, 2 * axis + 1];
        let links = sides.iter().filter(|&&side| adjacency.has_neighbor(vertex, side)).count();
        (position(sides[1]) - position(sides[0])) / links.max(1) as f64
    });
    match field {
        Turned::Material => (x * v[0] + y * v[1] + z * v[2]).cap_magnitude(Vector3::from(v).norm()),
        Turned::Normals => y.cross(&z) * v[0] + z.cross(&x) * v[1] + x.cross(&y) * v[2],
    }
}

/// Returns the length of the direction of a point.
fn length(point: &Moving) -> f64 {
    point.direction().iter().map(|&v| f64::from(v).powi(2)).sum::<f64>().sqrt()
}
