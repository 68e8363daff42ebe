//! How a patch of the surface meets a collider.

use nalgebra::{Point3, Vector3};

use super::SKIN;
use super::exchange::Contact;
use super::links::Link;
use super::patch::Patch;
use super::quad::{Quad, add, difference, quad, vector};
use super::solver::Solver;
use crate::contact::colliders::PosedCollider;

/// How a lattice vertex moves in a step: its place at the end, local, in cells, its velocity, in cells per second, and
/// that with which the step began.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Motion {
    pub(super) place: Quad,
    pub(super) velocity: Quad,
    pub(super) came: Quad,
}

/// The contacts of a step, and the motions of the vertices that they touch.
#[derive(Clone, Debug)]
pub(super) struct Meeting {
    pub(super) solver: Solver,
    /// In the order of the solver's rows.
    motions: Vec<Motion>,
}

impl Meeting {
    /// For vertices in so many rows.
    pub(super) fn new(rows: usize) -> Self {
        Self { solver: Solver::new(rows), motions: Vec::new() }
    }

    /// Forgets all contacts.
    pub(super) fn clear(&mut self) {
        self.solver.clear();
        self.motions.clear();
    }

    /// Names the vertices of a patch to the solver, for the next contact; `motion` is that of the vertex in a row.
    /// Returns how the mean of the patch moves.
    pub(super) fn point(
        &mut self,
        patch: &Patch,
        mobilities: &[f32],
        motion: impl Fn(u32) -> Motion,
    ) -> SurfacePoint {
        self.solver.link(patch.vertices(), mobilities);
        self.motions.extend(self.solver.rows()[self.motions.len()..].iter().map(|&row| motion(row)));
        SurfacePoint::mean(self.solver.linked(), &self.motions)
    }
}

/// How a point of the surface moves in a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct SurfacePoint {
    place: Vector3<f64>,
    velocity: Vector3<f64>,
    came: Vector3<f64>,
}

impl SurfacePoint {
    /// The mean of some vertices; at least one.
    fn mean(links: &[Link], motions: &[Motion]) -> Self {
        // Of the way from one of them: a small number in f32, wherever the body is.
        let from = &motions[links[0].vertex as usize].place;
        let (mut way, mut velocity, mut came) = ([0.0; 4], [0.0; 4], [0.0; 4]);
        for link in links {
            let motion = &motions[link.vertex as usize];
            add(&mut way, &difference(&motion.place, from), link.weight);
            add(&mut velocity, &motion.velocity, link.weight);
            add(&mut came, &motion.came, link.weight);
        }
        Self { place: vector(from) + vector(&way), velocity: vector(&velocity), came: vector(&came) }
    }

    /// Where it is at the end of the step.
    pub(super) fn place(&self) -> Point3<f64> {
        self.place.into()
    }

    /// The contact with a collider in which it is, or nearly, at the end of a step of `dt` seconds.
    ///
    /// It is to leave as fast as restitution says, where it came from outside faster than `quiet`, in cells per
    /// second. Otherwise it stops. If it was leaving when the step began, and was turned back since, it may come back
    /// as fast as it left, which takes no energy from it and gives none, but not into the collider.
    ///
    /// * `depth`: of the deepest sample, in cells.
    pub(super) fn contact(&self, collider: &PosedCollider, depth: f64, dt: f64, quiet: f64) -> Contact {
        let normal = collider.shape.signed_distance(&self.place()).normal;
        let before = collider.before.signed_distance(&(self.place() - self.velocity * dt)).distance;
        let surface = collider.velocity_at(&self.place());
        let came = self.came - surface;
        let approach = -came.dot(&normal);
        let leave = if before > SKIN && approach > quiet {
            collider.restitution * approach
        } else {
            approach.min(0.0).max(-before.max(0.0) / dt)
        };
        Contact {
            normal: quad(normal),
            velocity: quad(self.velocity - surface),
            came: quad(came + normal * approach),
            leave: leave as f32,
            most: approach.max(leave) as f32,
            // Below infinity: of that and no impulse the product would be no number.
            friction: collider.friction.min(f64::from(f32::MAX)) as f32,
            depth: depth as f32,
        }
    }
}
