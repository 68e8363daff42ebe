//! A body together with the data of its simulation.

use std::ops::Deref;

use nalgebra::Vector3;

use super::elasticity::Softened;
use super::soft_body::Body;
use crate::contact::Colliders;
use crate::contact::bodies::BodyContacts;
use crate::lattice::Lattice;
use crate::mesh::Mesh;
use crate::parallel::Executor;

/// A reference to a body, with the data of its simulation that the displayed surface, the elasticity in force and the
/// energies depend on: colliders, time, step length, gravity and threads.
///
/// [`Simulation::body`](crate::Simulation::body) returns a `BodyRef` of a body in a simulation, and
/// [`Body::alone`] one of a body outside a simulation. A `BodyRef` dereferences to [`Body`]. [`BodyRef::get`]
/// returns the body itself.
#[derive(Clone, Copy, Debug)]
pub struct BodyRef<'a> {
    body: &'a Body,
    /// `None` outside a simulation.
    context: Option<DisplayContext<'a>>,
}

/// The data of a simulation that a [`BodyRef`] needs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DisplayContext<'a> {
    pub(crate) colliders: &'a Colliders,
    /// Time in seconds.
    pub(crate) time: f64,
    /// Length of a step in seconds.
    pub(crate) dt: f64,
    /// Gravity in scene units per second squared.
    pub(crate) gravity: Vector3<f64>,
    pub(crate) executor: &'a Executor,
    /// The bodies around the body; `None` if no body can touch another one or itself.
    pub(crate) near: Option<NearBodies<'a>>,
}

/// The bodies of a simulation, from the point of view of one of them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NearBodies<'a> {
    pub(crate) bodies: &'a [Body],
    /// Index of the body.
    pub(crate) index: u32,
    pub(crate) contacts: &'a BodyContacts,
}

impl Deref for BodyRef<'_> {
    type Target = Body;

    fn deref(&self) -> &Body {
        self.body
    }
}

impl<'a> BodyRef<'a> {
    pub(crate) fn new(body: &'a Body, context: DisplayContext<'a>) -> Self {
        Self { body, context: Some(context) }
    }

    /// Returns the data of the simulation, or `None` outside a simulation.
    pub(crate) fn context(self) -> Option<DisplayContext<'a>> {
        self.context
    }

    /// Returns the body, with the lifetime of the simulation's borrow.
    pub fn get(self) -> &'a Body {
        self.body
    }

    /// Returns the mesh in the model's frame, or `None` for a bare lattice.
    pub fn mesh(self) -> Option<&'a Mesh> {
        self.body.mesh()
    }

    /// Returns the lattice in the model's frame.
    pub fn lattice(self) -> &'a Lattice {
        self.body.lattice()
    }

    /// Returns a reference that evaluates the displayed surface on the threads of another executor. A program that
    /// evaluates several bodies at once gives each of them [`Executor::sequential`], because handing out the parts of
    /// one body costs more than it gains then.
    pub fn with_executor(self, executor: &'a Executor) -> Self {
        Self { context: self.context.map(|context| DisplayContext { executor, ..context }), ..self }
    }

    /// Returns Young's modulus, in scene units of force per area. In a simulation it is the modulus in force: the
    /// modulus of the material, or less if steps of this length cannot reach it. Outside a simulation it is the
    /// modulus that was set, or `None` if none was set. `None` for a rigid body.
    pub fn youngs_modulus(self) -> Option<f64> {
        match self.context {
            _ if self.body.is_rigid() => None,
            Some(context) => Some(self.body.modulus_in_force(context.dt)),
            None => self.body.material_modulus(),
        }
    }

    /// Returns whether and how the body is softer than its material, because its steps are too long. `None` outside
    /// a simulation.
    pub fn softened(self) -> Option<Softened> {
        self.context.and_then(|context| self.body.softened(context.dt))
    }

    /// Returns the frequency of the lowest elastic mode of the body without pins, handles and colliders, in Hz, to 2 %.
    /// The first call computes the mode. `None` outside a simulation, and for a rigid body.
    pub fn lowest_frequency(self) -> Option<f64> {
        let context = self.context.filter(|_| !self.body.is_rigid());
        let angular = context.map(|context| self.body.lowest_angular_frequency(context.dt, context.executor));
        angular.map(|angular| angular / std::f64::consts::TAU)
    }
}

/// A body outside a simulation.
impl<'a> From<&'a Body> for BodyRef<'a> {
    fn from(body: &'a Body) -> Self {
        Self { body, context: None }
    }
}

impl Body {
    /// Returns a reference for evaluating the displayed surface outside a simulation, on the calling thread.
    /// Colliders, contacts and external forces then have no effect on the volume correction.
    pub fn alone(&self) -> BodyRef<'_> {
        self.into()
    }
}
