//! Finds the samples of one body that touch another body, or another part of the same body.
//!
//! A sample at the world point x is located in a cell of the other body, and so at a point X of its rest shape. The
//! closest point Y of the surface at rest has the normal N (distances at rest that the deformed lattice carries: Fisher
//! & Lin 2001; McAdams et al. 2011). With the world position y of Y, and the derivative F of world positions by rest
//! coordinates, the contact has the normal n = F⁻ᵀN/|F⁻ᵀN| and the gap n · (x - y). So contacts act at the visible
//! surface, between the sample and the point Y of the surface. A sample that slides along the surface keeps Y for a short
//! distance, and the contact acts at the point under the sample.
//!
//! With a thickness of the bodies, a sample is also located outside of the cells, in the linear continuation of the
//! nearest one, and the gap is less by the sum of the thicknesses.

use nalgebra::{Point3, Vector3};

use super::deformed_cell::{DeformedCell, Gradient};
use super::joined_cells::TouchableCells;
use super::posed::{CellCache, Located, PosedLattice};
use super::touched_point::{
    FACING, MAX_SHELL_DEPTH, RANGE, RestPoint, SAME_SIDE, SurfaceQuery, cell_of, closest_on_closed,
    closest_on_shell, rest_point, touching_distance,
};
use super::view::BodyView;
use crate::contact::SKIN;
use crate::contact::memory::buffer_bytes;
use crate::lattice::trilinear_weights;
use crate::simd::vector::wide;
use crate::state::{SampleTouch, TouchedPoint};

/// Greatest depth in cells.
const MAX_DEPTH: f64 = 8.0;

/// Depth that a sample may have when it first touches: this multiple of its displacement in the step, plus
/// [`FIRST_DEPTH`]. A deeper sample came from another side, and the closest surface would pull it through.
const FIRST_DISPLACEMENT: f64 = 1.5;

/// Depth in cells that a sample may have when it first touches, in addition.
const FIRST_DEPTH: f64 = 0.1;

/// Distance in cells by which a sample may slide along the other body until its closest point is searched again. The normal
/// of a round surface of the radius r, in cells, is then off by up to 0.05/r, and a contact ends 0.05 cells beyond an edge.
const SLIDE: f64 = 0.05;

/// Depth in cells from which on the closest point is searched in each step: in a thin part the surface on the other side may
/// be nearer. Contacts that last are less deep.
const SHALLOW: f64 = 0.1;

/// A sample that touches a body.
#[derive(Clone, Copy, Debug)]
pub(super) struct Touch {
    pub(super) sample: u32,
    /// Cell of the sample.
    pub(super) cell: u32,
    /// The touched point of the other body.
    pub(super) touched: TouchedPoint,
    /// Local coordinates in the touched cell of the point under the sample, at which the forces act. They differ from those
    /// of the touched point if the sample slid.
    pub(super) under: [f32; 3],
    pub(super) point: Point3<f64>,
    /// Unit normal of the surface of the other body, to its outside.
    pub(super) normal: Vector3<f64>,
    /// Distance to this surface in scene units, negative inside.
    pub(super) gap: f64,
    /// Time from the contact to the end of the step, in seconds.
    pub(super) past: f64,
}

/// The search of the samples of `body` that touch `other`.
#[derive(Clone, Debug, Default)]
pub(super) struct Search {
    pub(super) body: u32,
    pub(super) other: u32,
    /// Number of times in a step at which the bodies are searched: a power of two.
    pub(super) times: u32,
    /// Sum of the thicknesses of both bodies, in scene units.
    pub(super) thickness: f64,
    /// The samples that touch, in increasing order.
    pub(super) touches: Vec<Touch>,
    /// Whether the step follows the samples that touched at the last search, and does not search.
    pub(super) follows: bool,
    /// Samples that touched at the last search and do not touch now.
    pub(super) separated: Vec<Touch>,
    /// The samples that touch at the current time.
    found: Vec<Touch>,
    cells: CellCache,
}

impl Search {
    /// Begins a search. Keeps the buffer.
    pub(super) fn begin(&mut self, [body, other]: [u32; 2], times: u32, thickness: f64) {
        self.touches.clear();
        self.separated.clear();
        self.follows = false;
        (self.body, self.other) = (body, other);
        (self.times, self.thickness) = (times, thickness);
    }

    /// Finds the samples that touch `past` seconds before the end of a step of `dt` seconds, among those that did not
    /// touch at an earlier time of the step. `posed` has the lattices of both bodies at this time.
    pub(super) fn run(
        &mut self,
        [body, other]: [&BodyView; 2],
        posed: [&PosedLattice; 2],
        past: f64,
        dt: f64,
    ) {
        let mut remembered = body.state.touches.of(self.other).iter().peekable();
        let (is_same, thickness) = (self.body == self.other, self.thickness);
        let pair = Pair { body, other, posed: posed[1], is_same, thickness, past, dt };
        let surface = body.contact.surface();
        let mut known = self.touches.iter().map(|touch| touch.sample).peekable();
        self.found.clear();
        self.cells.reset(posed[1]);
        let mut near = posed[0].cells.iter().peekable();
        let mut last_touched = None;
        for (index, group) in surface.cells.iter().enumerate() {
            while near.next_if(|(cell, _)| *cell < group.cell).is_some() {}
            let Some((_, bounds)) = near.peek().filter(|(cell, _)| *cell == group.cell) else { continue };
            let touchable = || surface.touchable_cells(body.lattice, body.touches_itself, index);
            let touchable = is_same.then(touchable);
            if !posed[1].is_near(bounds, |found| accepts(touchable, found)) {
                continue;
            }
            let geometry = posed[0].deformed_cell(body.corners(group.cell));
            let own = OwnCell { cell: group.cell, geometry: &geometry, touchable };
            for sample in group.samples.clone() {
                while known.next_if(|known| *known < sample).is_some() {}
                while remembered.next_if(|memory| memory.sample < sample).is_some() {}
                if known.peek() != Some(&sample) {
                    let memory = remembered.peek().copied();
                    let memory = memory.filter(|memory| memory.sample == sample && memory.is_touching);
                    let kept = memory.and_then(|memory| pair.keep_point(memory, own, &mut last_touched));
                    self.found.extend(kept.or_else(|| pair.touch(sample, own, memory, &mut self.cells)));
                }
            }
        }
        if !self.found.is_empty() {
            self.touches.append(&mut self.found);
            self.touches.sort_unstable_by_key(|touch| touch.sample);
        }
    }

    /// Follows the samples that touched at the last search: each is compared with the point of the other surface that
    /// it touched. In the time since, the bodies moved by a small part of a cell.
    pub(super) fn update_touches(&mut self, body: &BodyView, other: &BodyView) {
        let surface = body.contact.surface();
        let layer = self.thickness / other.lattice.cell_size();
        let mut groups = surface.cells.iter().peekable();
        let mut last_own: Option<(u32, DeformedCell)> = None;
        let mut last_touched: Option<(u32, DeformedCell)> = None;
        for memory in body.state.touches.of(self.other) {
            while groups.next_if(|group| group.samples.end <= memory.sample).is_some() {}
            let Some(group) = groups.peek() else { break };
            let TouchedPoint { cell, shell, .. } = memory.touched;
            if cell as usize >= other.lattice.cells().len() {
                continue;
            }
            let sample = &surface.samples[memory.sample as usize];
            let own = current(&mut last_own, group.cell, |cell| body.deformed_cell(cell));
            let point = own.position(sample.local.map(f64::from));
            let touched_cell = current(&mut last_touched, cell, |cell| other.deformed_cell(cell));
            let (gradient, offset) = offset_from(&memory.touched, touched_cell, &point);
            let normal = gradient.normal(&wide(memory.touched.normal));
            let normal = normal.unwrap_or_else(|| wide(memory.normal));
            let distance = offset.dot(&normal);
            let shell = match self.body == self.other {
                true => remaining(shell.into(), distance / other.lattice.cell_size()),
                // That of the present thickness, as it is stored.
                false => f64::from(touching_distance(other.contact.surface().is_closed, layer) as f32),
            };
            let gap = distance - shell * other.lattice.cell_size();
            let (sample, touched) = (memory.sample, TouchedPoint { shell: shell as f32, ..memory.touched });
            let under = touched.local;
            let touch = Touch { sample, cell: group.cell, touched, under, point, normal, gap, past: 0.0 };
            match gap <= SKIN * body.lesser_cell_size(other) {
                true => self.touches.push(touch),
                false => self.separated.push(touch),
            }
        }
    }

    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        buffer_bytes(&self.touches)
            + buffer_bytes(&self.separated)
            + buffer_bytes(&self.found)
            + self.cells.bytes()
    }
}

/// A body whose samples are tested, and the body that they may touch.
#[derive(Clone, Copy)]
struct Pair<'a> {
    body: &'a BodyView<'a>,
    other: &'a BodyView<'a>,
    /// The lattice of the other body `past` seconds before the end of the step.
    posed: &'a PosedLattice,
    is_same: bool,
    /// Sum of the thicknesses of both bodies, in scene units.
    thickness: f64,
    /// Time to the end of the step, in seconds.
    past: f64,
    dt: f64,
}

/// A cell with samples that are tested.
#[derive(Clone, Copy)]
struct OwnCell<'a> {
    cell: u32,
    geometry: &'a DeformedCell,
    /// The cells that it can touch, if the other body is the same.
    touchable: Option<TouchableCells<'a>>,
}

/// Returns whether samples may touch the surface in a cell of the other body: see [`OwnCell::touchable`].
fn accepts(touchable: Option<TouchableCells>, found: u32) -> bool {
    touchable.is_none_or(|cells| cells.contains(found))
}

impl Pair<'_> {
    /// Returns the contact of a sample in the cell `own` with the point of another closed surface that it
    /// touched in the last step. Returns `None` if the closest point must be searched: the sample slid far from there, is
    /// deep, has turned away, or the side is not known. `last`: the touched cell of another sample.
    fn keep_point(
        &self,
        memory: &SampleTouch,
        OwnCell { cell, geometry: own, .. }: OwnCell,
        last: &mut Option<(u32, DeformedCell)>,
    ) -> Option<Touch> {
        let Self { body, other, posed, is_same, thickness, past, .. } = *self;
        let surface = other.contact.surface();
        // Closed surfaces without a thickness touch at the distance 0.
        let touched = TouchedPoint { shell: 0.0, ..memory.touched };
        let are_new = body.state.touches.sides_unknown || other.state.touches.sides_unknown;
        let can_keep = surface.is_closed && !is_same && thickness == 0.0 && !are_new;
        if !can_keep || touched.cell as usize >= surface.corners.len() {
            return None;
        }
        let sample = &body.contact.surface().samples[memory.sample as usize];
        let own_local = sample.local.map(f64::from);
        let point = own.position(own_local);
        let touched_cell = current(last, touched.cell, |cell| posed.deformed_cell(other.corners(cell)));
        let (gradient, offset) = offset_from(&touched, touched_cell, &point);
        let normal = gradient.normal(&wide(touched.normal))?;
        let gap = offset.dot(&normal);
        let (slid, cell_size) = (offset - normal * gap, body.lesser_cell_size(other));
        let is_near = (-SHALLOW * cell_size..=SKIN * cell_size).contains(&gap)
            && slid.norm() <= SLIDE * cell_size
            && normal.dot(&wide(memory.normal)) > SAME_SIDE;
        let faces = || {
            let outward = own.gradient(own_local).normal(&wide(sample.normal));
            let facing = outward.and_then(|outward| gradient.rest_normal(&outward));
            !body.contact.surface().is_closed
                || facing.is_none_or(|facing| facing.dot(&wide(touched.normal)) <= FACING)
        };
        if !is_near || !faces() {
            return None;
        }
        // The forces act on both bodies at the same point.
        let slid = gradient.local_offset(&slid);
        let under = std::array::from_fn(|axis| touched.local[axis] + slid[axis] as f32);
        Some(Touch { sample: memory.sample, cell, touched, under, point, normal, gap, past })
    }

    /// Returns the contact of a sample in a cell. `memory`: of the sample in the last step, if it
    /// touched the other body. `cells` belongs to the other body.
    fn touch(
        &self,
        index: u32,
        OwnCell { cell, geometry: own, touchable }: OwnCell,
        memory: Option<&SampleTouch>,
        cells: &mut CellCache,
    ) -> Option<Touch> {
        let Self { body, other, posed, thickness, past, dt, .. } = *self;
        let sample = &body.contact.surface().samples[index as usize];
        let own_local = sample.local.map(f64::from);
        let point = own.position(own_local);
        let surface = other.contact.surface();
        let located =
            posed.locate(surface, &point, thickness > 0.0, |found| accepts(touchable, found), cells)?;
        let outward = own.gradient(own_local).normal(&wide(sample.normal));
        let shell_before = memory.map(|memory| f64::from(memory.touched.shell));
        let memory = memory.map(|memory| wide(memory.normal));
        let displacement = || {
            let own = velocity_in(body, cell, sample.local);
            (own - velocity_in(other, located.cell, located.local.map(|u| u.clamp(-1.0, 2.0) as f32))) * dt
        };
        let cell_size = body.lesser_cell_size(other);
        // An open surface has no outside, but the surfaces of a crack through it have one.
        let is_at_crack = self.is_same && surface.are_at_crack([cell, located.cell]);
        let facing = outward.filter(|_| body.contact.surface().is_closed || is_at_crack);
        let encounter = Encounter {
            located,
            facing: facing.and_then(|outward| located.gradient.rest_normal(&outward)),
            before: memory,
            is_closed: surface.is_closed || is_at_crack,
            fit_together: self.is_same && surface.are_of_two_parts([cell, located.cell]),
        };
        let Encounter { facing, is_closed, fit_together, .. } = encounter;
        let RestPoint { rest: touched_rest, normal: rest_normal } =
            self.closest(&encounter, cell_size, displacement)?;
        let (other_cell, other_local) = cell_of(other.lattice, &touched_rest, located.cell);
        // A sample that was located outside of a cell of the same body may be nearest to a part that it does not touch.
        if thickness > 0.0 && !accepts(touchable, other_cell) {
            return None;
        }
        let layer = self.layer((cell, own_local), &touched_rest);
        let touched_cell = posed.deformed_cell(other.corners(other_cell));
        let touched_local = other_local.map(f64::from);
        // Where the touched cell is inside out, the derivative at the sample replaces its derivative.
        let normal = touched_cell.gradient(touched_local).normal(&rest_normal);
        let normal = normal.or_else(|| located.gradient.normal(&rest_normal))?;
        let distance = (point - touched_cell.position(touched_local)).dot(&normal);
        let are_new = body.state.touches.sides_unknown || other.state.touches.sides_unknown;
        let shell = match fit_together && is_closed {
            true => self.fitting_distance(shell_before, distance, layer, are_new),
            false => touching_distance(is_closed, layer),
        };
        let gap = distance - shell * other.lattice.cell_size();
        let faces_away = facing.is_some() && outward.is_some_and(|outward| normal.dot(&outward) > 0.0);
        // A NaN, from positions that are not finite, is no contact.
        let is_near = gap <= SKIN * cell_size;
        if !is_near || faces_away {
            return None;
        }
        let is_known = memory.is_some_and(|before| before.dot(&normal) > SAME_SIDE);
        let counts = is_known
            || are_new
            || thickness > 0.0 && distance > 0.0
            || -gap - layer * other.lattice.cell_size()
                <= FIRST_DISPLACEMENT * displacement().dot(&normal).abs() + FIRST_DEPTH * cell_size;
        let rest_normal = rest_normal.map(|x| x as f32).into();
        let touched =
            TouchedPoint { cell: other_cell, local: other_local, normal: rest_normal, shell: shell as f32 };
        let under = other_local;
        counts.then_some(Touch { sample: index, cell, touched, under, point, normal, gap, past })
    }

    /// Returns the distance in cells at which a sample touches another part of the body, which fits together with its
    /// own: see [`remaining`]. `before`: in the last step. `distance`: from the surface, in scene units. `layer`: the
    /// sum of the thicknesses in cells. `are_new`: whether the parts may overlap because they have just come apart.
    fn fitting_distance(&self, before: Option<f64>, distance: f64, layer: f64, are_new: bool) -> f64 {
        let distance = distance / self.other.lattice.cell_size();
        match before {
            Some(before) if before < 0.0 || self.thickness == 0.0 => remaining(before, distance),
            None if are_new && distance < 0.0 => distance.max(-MAX_SHELL_DEPTH),
            _ => layer,
        }
    }

    /// Returns the closest point of the surface of the other body that a sample may touch. `cell_size`: the lesser one.
    /// `displacement`: of the sample relative to its cell of the other body, in the step.
    fn closest(
        &self,
        encounter: &Encounter,
        cell_size: f64,
        displacement: impl Fn() -> Vector3<f64>,
    ) -> Option<RestPoint> {
        let &Encounter { located: Located { cell, local, gradient }, facing, before, .. } = encounter;
        let fit_together = encounter.fit_together;
        let (surface, thickness) =
            (self.other.contact.surface(), self.thickness / self.other.lattice.cell_size());
        let rest = rest_point(self.other.lattice, cell, local);
        if !encounter.is_closed {
            return closest_on_shell(surface, (&rest, cell), thickness, |normal, offset| {
                match (facing, before) {
                    (Some(facing), _) => -facing.dot(normal),
                    (None, Some(before)) => gradient.normal(normal).map_or(0.0, |normal| normal.dot(&before)),
                    (None, None) => {
                        // In the layer around the surface a sample may also move away.
                        let start = if thickness > 0.0 { offset.dot(normal) } else { 0.0 };
                        start - gradient.local_offset(&displacement()).dot(normal)
                    }
                }
            });
        }
        let limit = match (self.is_same, before) {
            (false, _) => MAX_DEPTH + RANGE * thickness,
            (true, None) if fit_together => {
                RANGE * (FIRST_DISPLACEMENT * displacement().norm() / cell_size + FIRST_DEPTH + thickness)
            }
            (true, _) => MAX_SHELL_DEPTH + RANGE * thickness,
        };
        let side = before.and_then(|before| gradient.rest_normal(&before));
        let index = self.other.lattice.cells()[cell as usize];
        let query = SurfaceQuery { rest, cell, index, facing, side, limit, thickness, fit_together };
        closest_on_closed(surface, &query)
    }

    /// Returns the distance in cells of the other body at which a sample at `local` in `cell` touches a point of the
    /// surface at rest: the sum of the thicknesses. Within a body it is not more than the distance at rest, so that
    /// parts that are near at rest do not push each other.
    fn layer(&self, (cell, local): (u32, [f64; 3]), touched: &Point3<f64>) -> f64 {
        let thickness = self.thickness / self.other.lattice.cell_size();
        if !self.is_same || thickness == 0.0 {
            return thickness;
        }
        thickness.min((rest_point(self.body.lattice, cell, local) - touched).norm())
    }
}

/// A sample in a cell of the other body.
#[derive(Clone, Copy)]
struct Encounter {
    located: Located,
    /// Direction at rest of the cell in which the surface of the sample faces; `None` if it has no outside.
    facing: Option<Vector3<f64>>,
    /// Normal with which the sample touched in the last step.
    before: Option<Vector3<f64>>,
    /// Whether the surface of the other body has an outside there.
    is_closed: bool,
    /// Whether sample and cell are of two parts of a body, which fit together where it broke.
    fit_together: bool,
}

/// Returns the depth in cells that a sample may keep in another part of the body, as a negative number. `before`: the
/// depth in the last step. `distance`: its distance from the surface of the other part.
///
/// Where a body breaks, its parts are stretched, each of them differently, so that they overlap a little at the
/// crack. This overlap must not push them apart: it remains until it ends by itself.
fn remaining(before: f64, distance: f64) -> f64 {
    if before < 0.0 { before.max(distance).min(0.0) } else { before }
}

/// Returns the derivative at a touched point, and the offset of `point` from it. `cell`: the geometry of the touched cell.
fn offset_from(touched: &TouchedPoint, cell: &DeformedCell, point: &Point3<f64>) -> (Gradient, Vector3<f64>) {
    let local = touched.local.map(f64::from);
    (cell.gradient(local), point - cell.position(local))
}

/// Returns the geometry of a cell. `last`: the geometry of the last cell, computed once.
fn current(
    last: &mut Option<(u32, DeformedCell)>,
    cell: u32,
    geometry: impl FnOnce(u32) -> DeformedCell,
) -> &DeformedCell {
    if last.is_none_or(|(found, _)| found != cell) {
        *last = Some((cell, geometry(cell)));
    }
    let (_, geometry) = last.as_ref().expect("set above");
    geometry
}

/// Returns the velocity of a point of a cell, in scene units per second.
fn velocity_in(body: &BodyView, cell: u32, local: [f32; 3]) -> Vector3<f64> {
    let corners = body.corners(cell).into_iter().zip(trilinear_weights(local));
    corners.map(|(vertex, weight)| body.velocity(vertex) * f64::from(weight)).sum()
}
