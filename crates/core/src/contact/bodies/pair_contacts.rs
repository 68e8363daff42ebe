//! Adds the contacts between bodies to the contact problem of an island.

use nalgebra::{Point3, Vector3};

use super::island::{GREATEST_RATIO, Island, PairContact, PatchBuffers, PatchKey};
use super::search::{Search, Touch};
use super::surface::side;
use super::view::{BodyView, ContactStep};
use crate::contact::SKIN;
use crate::contact::constraint::TouchedSurface;
use crate::contact::stage::MIN_BOUNCE_STEPS;
use crate::contact::vec4::narrow;
use crate::lattice::trilinear_weights;
use crate::state::ContactKey;

/// Weight up to which a vertex does not take part in a contact.
const LEAST_WEIGHT: f64 = 1e-6;

/// Least sum of the weights of the vertices of a contact between parts of a body that are not constrained. With less,
/// the constrained vertices nearly determine the motion of the contact point, and the impulse that corrects it would
/// throw the other vertices away, for example where parts overlap at a pin.
const LEAST_FREE_WEIGHT: f64 = 0.3;

/// Returns the coefficient of friction between two bodies, from those of each.
pub(crate) fn mean_friction([a, b]: [f64; 2]) -> f64 {
    (a * b).sqrt()
}

impl Island {
    /// Adds the contacts of a search. Touching samples form one contact if they have in common the nearest point of a
    /// grid of half the cell size, the dominant axis and sign of the normal, and the components of both bodies. With
    /// one contact for each lattice vertex, the gaps of the samples of a contact would differ too much.
    pub(super) fn add_search<'a>(
        &mut self,
        view: &impl Fn(u32) -> BodyView<'a>,
        search: &Search,
        step: ContactStep,
    ) {
        let (body, other) = (view(search.body), view(search.other));
        let mut buffers = std::mem::take(&mut self.patches);
        buffers.keys.clear();
        buffers.keys.extend((0..).zip(&search.touches).map(|(index, touch)| {
            let sample = &body.contact.surface().samples[touch.sample as usize];
            let node = half_grid_node(body.lattice.cells()[touch.cell as usize], sample.local);
            let components = (component_of(&other, touch.touched.cell), component_of(&body, touch.cell));
            (node, side(&touch.normal) as u8, components, index)
        }));
        buffers.keys.sort_unstable();
        let PatchBuffers { keys, links } = &mut buffers;
        let skin = SKIN * body.lesser_cell_size(&other);
        for keys in keys.chunk_by(|a, b| (a.0, a.1, a.2) == (b.0, b.1, b.2)) {
            let (node, axis, (component, own), _) = keys[0];
            let key = ContactKey::Body { other: search.other, components: [own, component], node, axis };
            let group = TouchGroup::new(search, keys, skin);
            self.add_group([&body, &other], (key, [own, component]), &group, links, step);
        }
        self.patches = buffers;
    }

    /// Adds the contact of some touching samples. `links` is a buffer.
    fn add_group(
        &mut self,
        [body, other]: [&BodyView; 2],
        (key, components): (ContactKey, [u32; 2]),
        group: &TouchGroup<'_>,
        links: &mut [Vec<(u32, f64)>; 2],
        step: ContactStep,
    ) {
        let (length, mass) = self.units;
        let (search, dt) = (group.search, step.dt);
        let Some(mut mean) = group.mean() else { return };
        if search.body != search.other && search.thickness > 0.0 {
            // Where the layers around both surfaces meet.
            mean.point -= mean.normal * body.properties.thickness;
        }
        group.write_links([body, other], links);
        let fit_together = search.body == search.other && !body.lattice.broken_joints().is_empty();
        if fit_together && body.free_weight(&links[0]) + other.free_weight(&links[1]) < LEAST_FREE_WEIGHT {
            return;
        }
        let friction_factor =
            mean_friction([body.friction_factor(&links[0]), other.friction_factor(&links[1])]);
        let touched = mean.surface([body, other], links, friction_factor, step);
        let gap_before = touched.distance_before;
        let contact =
            touched.contact(group.skin, length, |approach| approach.min(0.0).max(-gap_before.max(0.0) / dt));
        let sides = [(body, search.body, 1.0), (other, search.other, -1.0)];
        let offsets = sides.map(|(_, index, _)| self.member(index).offset);
        let rigid = sides.map(|(body, index, _)| self.member(index).rigid.zip(body.rigid));
        for (links, _) in links.iter_mut().zip(rigid).filter(|(_, rigid)| rigid.is_some()) {
            links.clear();
        }
        let rows = links.iter().zip(sides).zip(offsets).flat_map(|((links, (body, _, sign)), offset)| {
            links.iter().map(move |&(vertex, w)| {
                let mobility = (body.inverse_mass(vertex) * mass).min(GREATEST_RATIO);
                (offset + vertex, (sign * w) as f32, mobility as f32)
            })
        });
        self.solver.add(contact, rows);
        for ((body, _, sign), (index, mobility)) in sides.iter().zip(rigid).filter_map(|(s, r)| Some((s, r?)))
        {
            let center = body.state.frame.to_world(mobility.center);
            let constraint = self.solver.len() - 1;
            let arm = narrow((mean.point - center) / length);
            self.solver.rigid.link(constraint, index, *sign as f32, arm);
        }
        self.begin.push(narrow(body.state.touches.force(key) * (dt / (length * mass))));
        self.pairs.push(PairContact {
            bodies: [search.body, search.other],
            components,
            key,
            point: mean.point,
            normal: mean.normal,
            friction_factor,
            // Without the impulses, until they are known.
            depth: mean.depth - mean.past * touched.velocity.dot(&mean.normal),
            impulse: Vector3::zeros(),
            displacement: Vector3::zeros(),
            cell_size: body.lesser_cell_size(other) / length,
        });
    }
}

/// The touching samples of one contact.
struct TouchGroup<'a> {
    search: &'a Search,
    keys: &'a [PatchKey],
    /// Thickness of the contact skin, in scene units.
    skin: f64,
    /// Sum of the weights of the samples.
    total_weight: f64,
}

impl<'a> TouchGroup<'a> {
    /// `keys`: of the touches of the search that belong to the contact.
    fn new(search: &'a Search, keys: &'a [PatchKey], skin: f64) -> Self {
        let mut group = Self { search, keys, skin, total_weight: 0.0 };
        group.total_weight = group.touches().map(|touch| group.weight(touch)).sum();
        group
    }

    fn touches(&self) -> impl Iterator<Item = &'a Touch> {
        let touches = &self.search.touches;
        self.keys.iter().map(|&(.., index)| &touches[index as usize])
    }

    /// Returns the depth of a sample below the outer bound of the skin. At this bound it is small in place of zero.
    fn weight(&self, touch: &Touch) -> f64 {
        (self.skin - touch.gap).max(1e-3 * self.skin)
    }

    /// Returns the samples with their shares in the contact, by weight.
    fn shares(&self) -> impl Iterator<Item = (&'a Touch, f64)> {
        self.touches().map(|touch| (touch, self.weight(touch) / self.total_weight))
    }

    /// Returns the contact point of the group; `None` if the normals cancel each other.
    fn mean(&self) -> Option<MeanTouch> {
        let normal: Vector3<f64> = self.shares().map(|(touch, share)| touch.normal * share).sum();
        let normal = normal.try_normalize(1e-6)?;
        let first = self.touches().next().map_or_else(Point3::origin, |touch| touch.point);
        Some(MeanTouch {
            point: first
                + self.shares().map(|(touch, share)| (touch.point - first) * share).sum::<Vector3<f64>>(),
            normal,
            gap: self.shares().map(|(touch, share)| touch.gap * share).sum(),
            past: self.shares().map(|(touch, share)| touch.past * share).sum(),
            depth: self.touches().map(|touch| -touch.gap).fold(f64::NEG_INFINITY, f64::max),
        })
    }

    /// Replaces `links` by the contact point as a weighted mean of the vertices of each body.
    fn write_links(&self, [body, other]: [&BodyView; 2], links: &mut [Vec<(u32, f64)>; 2]) {
        links.iter_mut().for_each(Vec::clear);
        for (touch, share) in self.shares() {
            let sample = &body.contact.surface().samples[touch.sample as usize];
            let sides = [(body, touch.cell, sample.local), (other, touch.touched.cell, touch.under)];
            for (links, (body, cell, local)) in links.iter_mut().zip(sides) {
                // A smooth surface of a crack leaves the cells of its part, where weights can be negative or great.
                let weights = trilinear_weights(local.map(|u| u.clamp(0.0, 1.0)));
                let corners = body.corners(cell).into_iter().zip(weights);
                links.extend(corners.map(|(vertex, w)| (vertex, f64::from(w) * share)));
            }
        }
        links.iter_mut().for_each(merge);
    }
}

/// The contact point of a group of touching samples. Means are weighted by the shares of the samples.
struct MeanTouch {
    point: Point3<f64>,
    /// Unit normal.
    normal: Vector3<f64>,
    gap: f64,
    past: f64,
    /// Greatest depth of a sample.
    depth: f64,
}

impl MeanTouch {
    /// Returns the touched surface of the other body. `links`: as [`TouchGroup::write_links`] writes them.
    fn surface(
        &self,
        [body, other]: [&BodyView; 2],
        links: &[Vec<(u32, f64)>; 2],
        friction_factor: f64,
        ContactStep { dt, gravity }: ContactStep,
    ) -> TouchedSurface {
        let velocity = mean(&links[0], |v| body.velocity(v)) - mean(&links[1], |v| other.velocity(v));
        let velocity_before =
            mean(&links[0], |v| body.velocity_before(v)) - mean(&links[1], |v| other.velocity_before(v));
        let end_gap = self.gap + self.past * velocity.dot(&self.normal);
        let frictions = [body.properties.friction, other.properties.friction];
        TouchedSurface {
            normal: self.normal,
            distance_before: end_gap - dt * velocity.dot(&self.normal),
            velocity,
            velocity_before,
            friction: mean_friction(frictions) * friction_factor,
            restitution: body.properties.restitution.max(other.properties.restitution),
            min_bounce: MIN_BOUNCE_STEPS * gravity * dt,
        }
    }
}

impl BodyView<'_> {
    fn is_constrained(&self, vertex: u32) -> bool {
        self.constrained.get(vertex as usize) == Some(&true)
    }

    /// Returns the sum of the weights of the vertices that are not constrained.
    fn free_weight(&self, links: &[(u32, f64)]) -> f64 {
        let free = links.iter().filter(|(vertex, _)| !self.is_constrained(*vertex));
        free.map(|(_, weight)| weight).sum()
    }

    /// Returns the factor of the coefficient of friction at a contact.
    fn friction_factor(&self, links: &[(u32, f64)]) -> f64 {
        let factor = |factors: &[f64], vertex| factors[self.lattice.source(vertex) as usize];
        self.friction_factors.map_or(1.0, |factors| {
            let total: f64 = links.iter().map(|(_, weight)| weight).sum();
            links.iter().map(|&(vertex, weight)| factor(factors, vertex) * weight).sum::<f64>() / total
        })
    }

    /// Returns the inverse mass of a vertex; zero if it is constrained.
    fn inverse_mass(&self, vertex: u32) -> f64 {
        match self.is_constrained(vertex) {
            true => 0.0,
            false => 1.0 / (self.cell_mass * f64::from(self.masses[vertex as usize])),
        }
    }
}

/// Returns the connected component of a cell.
fn component_of(body: &BodyView, cell: u32) -> u32 {
    body.lattice.components().of_vertex[body.corners(cell)[0] as usize]
}

/// Returns the indices of the point nearest to a sample in the grid of half the cell size.
fn half_grid_node(cell: [i32; 3], local: [f32; 3]) -> [i32; 3] {
    std::array::from_fn(|a| 2 * cell[a] + (2.0 * local[a]).round() as i32)
}

/// Returns the weighted mean of vectors of vertices.
fn mean(links: &[(u32, f64)], vector: impl Fn(u32) -> Vector3<f64>) -> Vector3<f64> {
    links.iter().map(|&(vertex, weight)| vector(vertex) * weight).sum()
}

/// Sorts weights by vertex, and adds the weights of the same vertex. Leaves out weights at rounding level, such as
/// the weights of inner vertices for samples on a face of a cell.
fn merge(links: &mut Vec<(u32, f64)>) {
    links.retain(|(_, weight)| *weight > LEAST_WEIGHT);
    links.sort_unstable_by_key(|(vertex, _)| *vertex);
    links.dedup_by(|next, first| {
        let is_same = next.0 == first.0;
        if is_same {
            first.1 += next.1;
        }
        is_same
    });
}
