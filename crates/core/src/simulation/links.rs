//! Links between bodies: their ties, and the impulses of a step.
//!
//! Each lattice vertex of the part of a link is tied to a point of the other body: a mean of the corners of a cell, with
//! weights w that may lie beyond it. The impulse J on the vertex and -w J on the corners keep the momentum, and the
//! angular momentum also, because J is along the distance d between the two points. With the velocity u of d, the step
//! length h and the mass m that resists J:
//!
//! * Glue: J = -m (u/2 + d/h), in sweeps over the ties: a distance vanishes within some steps without other forces. An
//!   acceleration g of a body of the mass M, of which the tied vertices have the mass m, moves them by g h² M/m.
//! * A spring of the frequency ω = √(k/m) with the rest length L: J = -m (s (|d| - L)/h + c u), along d,
//!   with the shares s and c of `dynamics::goal::spring_shares`, which give the frequency exactly.

use nalgebra::{Matrix3, Point3, SymmetricEigen, Vector3};

use crate::body::{Anchor, Body};
use crate::dynamics::{Link, LinkError, spring_shares};
use crate::error::Error;
use crate::mesh::distinct;

/// Sweeps over the ties of glue in a step.
const SWEEPS: usize = 8;

/// Least mobility, as a fraction of the greatest of the three directions, in which a point can be moved.
const LEAST_MOBILITY: f64 = 1e-9;

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
    buffers: Buffers,
}

/// Buffers of a step.
#[derive(Debug, Default)]
struct Buffers {
    /// Impulses on the vertices of the ties.
    impulses: Vec<Vector3<f64>>,
    /// Impulses on the corners, with the opposite sign.
    of_corners: Vec<Vector3<f64>>,
    /// Forces on the vertices of the body and of the other one.
    forces: [Vec<(u32, [f64; 3])>; 2],
}

/// A vertex that is tied to a point.
#[derive(Clone, Copy, Debug)]
struct Tie {
    vertex: u32,
    point: TiePoint,
    /// The distance at frame 0; 0 for glue.
    rest_length: f64,
}

/// The point to which a vertex is tied.
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
    /// A body that does not exist, an invalid link, an empty part, or glue over a distance, as [`Error::InLink`].
    pub(super) fn new(links: Vec<Link>, bodies: &[Body]) -> Result<Self, Error> {
        let list = links.into_iter().enumerate().map(|(index, link)| {
            Joined::new(link, bodies).map_err(|source| Error::InLink { index, source: Box::new(source) })
        });
        Ok(Self { list: list.collect::<Result<_, _>>()? })
    }

    /// Returns whether there are no links.
    pub(super) fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// Returns whether a link ties a body.
    pub(super) fn ties(&self, body: usize) -> bool {
        self.list.iter().any(|joined| joined.bodies.0 == body || joined.bodies.1 == Some(body))
    }

    /// Follows the removal of a body that no link ties: lowers the indices above its own.
    pub(super) fn remove_body(&mut self, removed: usize) {
        for Joined { bodies: (body, other), .. } in &mut self.list {
            for index in std::iter::once(body).chain(other) {
                *index -= usize::from(*index > removed);
            }
        }
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
        let body = Body::index_of(bodies, "link", &link.body)?;
        let other = link.other.as_ref().map(|name| Body::index_of(bodies, "link", name)).transpose()?;
        let vertices = bodies[body].select(&link.selection)?;
        let places: Vec<Point3<f64>> = vertices.iter().map(|&vertex| bodies[body].start_of(vertex)).collect();
        let is_glue = link.stiffness.is_none();
        let anchors = other.map(|other| bodies[other].anchors_at_start(&places, !is_glue));
        let all = || anchors.iter().flatten();
        let corners = distinct(all().flat_map(|anchor| anchor.corners));
        if let (Some(anchor), true) = (all().find(|anchor| anchor.beyond > GLUE_REACH), is_glue) {
            let (body, other) = (link.body.clone(), link.other.clone().unwrap_or_default());
            return Err(LinkError::TooLong { body, other, cells: anchor.beyond }.into());
        }
        let ties = match &anchors {
            None => {
                let tie = |(&vertex, place)| Tie { vertex, point: TiePoint::Place(place), rest_length: 0.0 };
                vertices.iter().zip(places).map(tie).collect()
            }
            Some(anchors) => {
                let index = |corner: u32| corners.partition_point(|&other| other < corner) as u32;
                let tie = |((&vertex, place), anchor): ((&u32, Point3<f64>), &Anchor)| {
                    let point = TiePoint::Corners(anchor.corners.map(index), anchor.weights);
                    let rest_length = if is_glue { 0.0 } else { (place - anchor.place).norm() };
                    Tie { vertex, point, rest_length }
                };
                vertices.iter().zip(places).zip(anchors).map(tie).collect()
            }
        };
        let (bodies, is_broken, force) = ((body, other), false, Vector3::zeros());
        Ok(Self { link, bodies, ties, corners, is_broken, force, buffers: Buffers::default() })
    }

    /// Computes the impulses of a step from the state before it, and applies them as forces in the step.
    fn apply(&mut self, bodies: &mut [Body], dt: f64) {
        self.compute_impulses(bodies, dt);
        let Self { bodies: (body, other), ties, corners, buffers, .. } = self;
        let Buffers { impulses, of_corners, forces: [of_body, of_other] } = buffers;
        of_body.clear();
        of_body.extend(ties.iter().zip(&*impulses).map(|(tie, impulse)| (tie.vertex, (impulse / dt).into())));
        of_other.clear();
        of_other.extend(
            corners.iter().zip(&*of_corners).map(|(&corner, impulse)| (corner, (-impulse / dt).into())),
        );
        self.force = of_body.iter().map(|(_, force)| Vector3::from(*force)).sum();
        if self.link.break_force.is_some_and(|limit| self.force.norm() > limit) {
            self.is_broken = true;
            self.force = Vector3::zeros();
            return;
        }
        bodies[*body].add_step_forces(of_body);
        if let Some(other) = *other {
            bodies[other].add_step_forces(of_other);
        }
    }

    /// Computes the impulses of a step on the vertices of the ties and on the corners.
    fn compute_impulses(&mut self, bodies: &[Body], dt: f64) {
        let Self { link, bodies: (index, other), ties, corners, buffers, .. } = self;
        let Buffers { impulses, of_corners, .. } = buffers;
        let (body, other_body) = (&bodies[*index], other.map(|other| &bodies[other]));
        let of_body: f64 = ties.iter().map(|tie| body.mass_of(tie.vertex)).sum();
        impulses.clear();
        impulses.resize(ties.len(), Vector3::zeros());
        of_corners.clear();
        of_corners.resize(corners.len(), Vector3::zeros());
        let mut rigid = body.rigid_linked();
        let mut other_rigid = other_body.and_then(Body::rigid_linked);
        let sweeps = if link.stiffness.is_none() { SWEEPS } else { 1 };
        // Springs do not respond to each other: each of n ties of a rigid body has an n-th of its mass.
        let share = if link.stiffness.is_none() { 1.0 } else { ties.len() as f64 };
        for _ in 0..sweeps {
            for (tie, total) in ties.iter().zip(&mut *impulses) {
                let mass = body.mass_of(tie.vertex);
                let (place, velocity) = body.vertex_motion(tie.vertex);
                let (change, mut mobility) = match &rigid {
                    Some(rigid) => (rigid.velocity_change(&place), rigid.mobility_at(&place) * share),
                    None => (*total / mass, Matrix3::from_diagonal_element(1.0 / mass)),
                };
                let (mut distance, mut relative, mut before) =
                    (Vector3::zeros(), velocity + change, velocity);
                match (&tie.point, other_body) {
                    (TiePoint::Corners(indices, weights), Some(other)) => {
                        // Differences to the place keep the accuracy far from the origin of world space.
                        for (&index, &weight) in indices.iter().zip(weights) {
                            let corner = corners[index as usize];
                            let (point, velocity) = other.vertex_motion(corner);
                            distance += (place - point) * weight;
                            relative -= velocity * weight;
                            before -= velocity * weight;
                            if other_rigid.is_none() {
                                let mass = other.mass_of(corner);
                                relative += of_corners[index as usize] * (weight / mass);
                                mobility += Matrix3::from_diagonal_element(weight * weight / mass);
                            }
                        }
                        if let Some(rigid) = &other_rigid {
                            let point = place - distance;
                            relative -= rigid.velocity_change(&point);
                            mobility += rigid.mobility_at(&point) * share;
                        }
                    }
                    (TiePoint::Place(point), _) => distance = place - point,
                    (TiePoint::Corners(..), None) => continue,
                }
                let impulse = match link.stiffness {
                    // Half of the velocity remains: see `spring_shares`.
                    None => -solve(&mobility, relative - before * 0.5 + distance / dt),
                    Some(stiffness) => {
                        let spring = (stiffness * mass / of_body, tie.rest_length, link.damping_ratio);
                        spring_impulse(spring, (distance, relative), &mobility, dt)
                    }
                };
                *total += impulse;
                if let Some(rigid) = &mut rigid {
                    rigid.add(&place, &impulse);
                }
                if let Some(rigid) = &mut other_rigid {
                    rigid.add(&(place - distance), &-impulse);
                }
                if let TiePoint::Corners(indices, weights) = &tie.point {
                    for (&index, &weight) in indices.iter().zip(weights) {
                        of_corners[index as usize] += impulse * weight;
                    }
                }
            }
        }
    }
}

/// Returns the impulse with which a point changes its velocity by a vector, as far as it can: the mobility of a body that
/// is held has directions without any.
fn solve(mobility: &Matrix3<f64>, change: Vector3<f64>) -> Vector3<f64> {
    let SymmetricEigen { eigenvalues, eigenvectors } = SymmetricEigen::new(*mobility);
    let least = LEAST_MOBILITY * eigenvalues.max();
    let parts = eigenvalues.iter().zip(eigenvectors.column_iter()).filter(|(value, _)| **value > least);
    parts.map(|(value, axis)| axis * (axis.dot(&change) / value)).sum()
}

/// Returns the impulse of a spring (stiffness, rest length, damping ratio) on the first of two points with a distance and
/// a relative velocity. `mobility`: the matrix of the change of the relative velocity by an impulse.
fn spring_impulse(
    (stiffness, rest_length, damping_ratio): (f64, f64, f64),
    (distance, velocity): (Vector3<f64>, Vector3<f64>),
    mobility: &Matrix3<f64>,
    dt: f64,
) -> Vector3<f64> {
    let along = |inverse: f64| {
        let phase = (stiffness * inverse).sqrt() * dt;
        let [share, damping] = spring_shares(phase, 2.0 * damping_ratio * phase);
        (share / dt, damping)
    };
    if rest_length == 0.0 {
        let inverse = mobility.trace() / 3.0;
        if inverse <= 0.0 {
            return Vector3::zeros();
        }
        let (share, damping) = along(inverse);
        return -(distance * share + velocity * damping) / inverse;
    }
    // Points at one place: the spring has no direction.
    let Some(direction) = distance.try_normalize(1e-9 * rest_length) else { return Vector3::zeros() };
    let inverse = direction.dot(&(mobility * direction));
    if inverse <= 0.0 {
        return Vector3::zeros();
    }
    let (share, damping) = along(inverse);
    let stretch = distance.norm() - rest_length;
    -direction * ((stretch * share + velocity.dot(&direction) * damping) / inverse)
}
