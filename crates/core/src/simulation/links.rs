//! Links between bodies: their ties, and the impulses of a step.
//!
//! Each lattice vertex of the part of a link is tied to a point of the other body: a mean of the corners of a cell, with
//! weights w that may lie beyond it. The impulse J on the vertex and -w J on the corners keep the momentum, and the
//! angular momentum also, because J is along the distance d between the two points. With the velocity u of d, the step
//! length h and the mass m that resists J:
//!
//! * Glue: J = -m (u + d/h), in sweeps over the ties, so that d vanishes at the end of the step.
//! * A spring of the frequency ω = √(k/m) with the rest length L: J = -m (c (|d| - L)/h + (1 - exp(-2 ζ ω h)) u), along d,
//!   where c = 2 (1 - cos(ω h)) gives the frequency exactly, at most 1: see `dynamics::goal`.

use std::f64::consts::FRAC_PI_3;

use nalgebra::{Point3, Vector3};

use super::world::Simulation;
use crate::body::{Anchor, Body};
use crate::dynamics::Link;
use crate::error::Error;

/// Sweeps over the ties of glue in a step.
const SWEEPS: usize = 8;

/// Greatest distance in cells of the other body at which glue holds a vertex: its place is extrapolated from a cell.
const GLUE_REACH: f64 = 1.0;

/// The links of a simulation.
#[derive(Debug, Default)]
pub(super) struct Links {
    list: Vec<Joined>,
}

/// A link and its ties.
#[derive(Debug)]
struct Joined {
    link: Link,
    bodies: (usize, Option<usize>),
    ties: Vec<Tie>,
    /// The corners of the cells of the ties, each once, in increasing order.
    corners: Vec<u32>,
    is_broken: bool,
    /// The force on the part of the body in the last step.
    force: Vector3<f64>,
    /// Velocity changes in a step: of the vertices of the ties, and of the corners.
    changes: (Vec<Vector3<f64>>, Vec<Vector3<f64>>),
    /// Forces of the last step on the body and on the other one.
    forces: (Vec<(u32, [f64; 3])>, Vec<(u32, [f64; 3])>),
}

/// A vertex that is tied to a point.
#[derive(Clone, Copy, Debug)]
struct Tie {
    vertex: u32,
    point: TiePoint,
    /// The distance at frame 0; 0 for glue.
    rest_length: f64,
}

/// What a vertex is tied to.
#[derive(Clone, Copy, Debug)]
enum TiePoint {
    /// A place in the world.
    Place(Point3<f64>),
    /// A mean of corners: indices in `Joined::corners`, and weights.
    Corners([u32; 8], [f64; 8]),
}

/// A link of a simulation, and its state after the last step.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct LinkRef<'a> {
    /// The description.
    pub link: &'a Link,
    /// The force of the link on its body in the last step, in kg x length / s^2. The other body has the opposite one.
    pub force: Vector3<f64>,
    /// Whether the link is broken.
    pub is_broken: bool,
}

impl Links {
    /// Joins bodies at frame 0.
    ///
    /// # Errors
    ///
    /// A body that does not exist, an invalid link, an empty part, or glue over a distance.
    pub(super) fn new(links: Vec<Link>, bodies: &[Body]) -> Result<Self, Error> {
        let list = links.into_iter().map(|link| Joined::new(link, bodies));
        Ok(Self { list: list.collect::<Result<_, _>>()? })
    }

    /// Returns the links, in the order in which they were added.
    pub(super) fn iter(&self) -> impl ExactSizeIterator<Item = LinkRef<'_>> {
        self.list.iter().map(|joined| LinkRef {
            link: &joined.link,
            force: joined.force,
            is_broken: joined.is_broken,
        })
    }

    /// Returns which links are broken.
    pub(super) fn broken(&self) -> Vec<bool> {
        self.list.iter().map(|joined| joined.is_broken).collect()
    }

    /// Sets which links are broken. A missing one is whole.
    pub(super) fn set_broken(&mut self, broken: &[bool]) {
        for (index, joined) in self.list.iter_mut().enumerate() {
            joined.is_broken = broken.get(index).copied().unwrap_or_default();
            joined.force = Vector3::zeros();
        }
    }

    /// Applies the forces of all links in a step of `dt` seconds.
    pub(super) fn apply(&mut self, bodies: &mut [Body], dt: f64) {
        for joined in self.list.iter_mut().filter(|joined| !joined.is_broken) {
            joined.apply(bodies, dt);
        }
    }
}

impl Joined {
    fn new(link: Link, bodies: &[Body]) -> Result<Self, Error> {
        link.validate()?;
        let find = |name: &String| {
            bodies.iter().position(|body| body.name() == name).ok_or_else(|| Error::NoSuchBody {
                what: "link",
                name: name.clone(),
                bodies: bodies.iter().map(|body| body.name().to_owned()).collect(),
            })
        };
        let body = find(&link.body)?;
        let other = link.other.as_ref().map(find).transpose()?;
        let vertices = bodies[body].select(&link.selection)?;
        let places: Vec<Point3<f64>> = vertices.iter().map(|&vertex| bodies[body].start_of(vertex)).collect();
        let is_glue = link.stiffness.is_none();
        let anchors = match other {
            None => places.iter().map(|_| None).collect(),
            Some(other) => bodies[other].anchors_at_start(&places, !is_glue),
        };
        let mut corners: Vec<u32> =
            anchors.iter().flatten().flat_map(|Anchor { corners, .. }| *corners).collect();
        corners.sort_unstable();
        corners.dedup();
        let mut ties = Vec::new();
        for ((&vertex, place), anchor) in vertices.iter().zip(places).zip(anchors) {
            let (point, rest_length) = match anchor {
                None => (TiePoint::Place(place), 0.0),
                Some(anchor) => {
                    if is_glue && anchor.beyond > GLUE_REACH {
                        let (body, other) = (link.body.clone(), link.other.clone().unwrap_or_default());
                        return Err(Error::LinkTooLong { body, other, cells: anchor.beyond });
                    }
                    let index = |corner: u32| corners.partition_point(|&other| other < corner) as u32;
                    let point = TiePoint::Corners(anchor.corners.map(index), anchor.weights);
                    (point, if is_glue { 0.0 } else { (place - anchor.place).norm() })
                }
            };
            ties.push(Tie { vertex, point, rest_length });
        }
        let (bodies, is_broken, force) = ((body, other), false, Vector3::zeros());
        let (changes, forces) = Default::default();
        Ok(Self { link, bodies, ties, corners, is_broken, force, changes, forces })
    }

    /// Computes the impulses of a step from the state before it, and applies them as forces in the step.
    fn apply(&mut self, bodies: &mut [Body], dt: f64) {
        let Self { link, bodies: (index, other), ties, corners, changes, forces, .. } = self;
        let (body, other_body) = (&bodies[*index], other.map(|other| &bodies[other]));
        let of_body: f64 = ties.iter().map(|tie| body.mass_of(tie.vertex)).sum();
        let (of_vertices, of_corners) = changes;
        of_vertices.clear();
        of_vertices.resize(ties.len(), Vector3::zeros());
        of_corners.clear();
        of_corners.resize(corners.len(), Vector3::zeros());
        let sweeps = if link.stiffness.is_none() { SWEEPS } else { 1 };
        for _ in 0..sweeps {
            for (tie, change) in ties.iter().zip(&mut *of_vertices) {
                let mass = body.mass_of(tie.vertex);
                let (place, velocity) = body.vertex_motion(tie.vertex);
                let (mut inverse, mut distance, mut relative) =
                    (1.0 / mass, Vector3::zeros(), velocity + *change);
                match (&tie.point, other_body) {
                    (TiePoint::Corners(indices, weights), Some(other)) => {
                        // Differences to the place keep the accuracy far from the origin of world space.
                        for (&index, &weight) in indices.iter().zip(weights) {
                            let corner = corners[index as usize];
                            let (point, velocity) = other.vertex_motion(corner);
                            distance += (place - point) * weight;
                            relative -= (velocity + of_corners[index as usize]) * weight;
                            inverse += weight * weight / other.mass_of(corner);
                        }
                    }
                    (TiePoint::Place(point), _) => distance = place - point,
                    (TiePoint::Corners(..), None) => continue,
                }
                let impulse = match link.stiffness {
                    None => -(relative + distance / dt) / inverse,
                    Some(stiffness) => {
                        let spring = (stiffness * mass / of_body, tie.rest_length, link.damping_ratio);
                        spring_impulse(spring, (distance, relative), inverse, dt)
                    }
                };
                *change += impulse / mass;
                if let (TiePoint::Corners(indices, weights), Some(other)) = (&tie.point, other_body) {
                    for (&index, &weight) in indices.iter().zip(weights) {
                        let mass = other.mass_of(corners[index as usize]);
                        of_corners[index as usize] -= impulse * (weight / mass);
                    }
                }
            }
        }
        forces.0.clear();
        forces.0.extend(
            ties.iter()
                .zip(&*of_vertices)
                .map(|(tie, change)| (tie.vertex, (change * (body.mass_of(tie.vertex) / dt)).into())),
        );
        forces.1.clear();
        if let Some(other) = other_body {
            forces.1.extend(
                corners
                    .iter()
                    .zip(&*of_corners)
                    .map(|(&corner, change)| (corner, (change * (other.mass_of(corner) / dt)).into())),
            );
        }
        self.force = self.forces.0.iter().map(|(_, force)| Vector3::from(*force)).sum();
        if self.link.break_force.is_some_and(|limit| self.force.norm() > limit) {
            self.is_broken = true;
            self.force = Vector3::zeros();
            return;
        }
        bodies[self.bodies.0].add_step_forces(&self.forces.0);
        if let Some(other) = self.bodies.1 {
            bodies[other].add_step_forces(&self.forces.1);
        }
    }
}

/// Returns the impulse of a spring (stiffness, rest length, damping ratio) on the first of two points with a distance and
/// a relative velocity. `inverse`: the inverse of the mass that resists the impulse.
fn spring_impulse(
    (stiffness, rest_length, damping_ratio): (f64, f64, f64),
    (distance, velocity): (Vector3<f64>, Vector3<f64>),
    inverse: f64,
    dt: f64,
) -> Vector3<f64> {
    let phase = (stiffness * inverse).sqrt() * dt;
    let share = 2.0 * (1.0 - phase.min(FRAC_PI_3).cos());
    let damping = -(-2.0 * damping_ratio * phase).exp_m1();
    let length = distance.norm();
    if rest_length == 0.0 {
        return -(distance * (share / dt) + velocity * damping) / inverse;
    }
    // Points at one place: the spring has no direction.
    let Some(direction) = distance.try_normalize(1e-9 * rest_length) else { return Vector3::zeros() };
    -direction * (((length - rest_length) * share / dt + velocity.dot(&direction) * damping) / inverse)
}

impl Simulation {
    /// Returns the links, in the order in which they were added, with their forces in the last step.
    pub fn links(&self) -> impl ExactSizeIterator<Item = LinkRef<'_>> {
        self.links.iter()
    }
}
