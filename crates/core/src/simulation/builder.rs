//! The builder of a simulation.

use nalgebra::Vector3;

use super::clock::Clock;
use super::groups::{self, ContactSettings, Groups};
use super::links::Links;
use super::settings::{check_dt, check_fields, check_gravity, check_substeps, check_threads};
use super::substeps::Substeps;
use super::world::Simulation;
use crate::body::Body;
use crate::contact::{Collider, Colliders};
use crate::dynamics::{Field, Link};
use crate::error::Error;
use crate::matching::Workspaces;
use crate::motion::Curve;
use crate::parallel::Executor;
use crate::range::Range;
use crate::state::PairSupports;

/// Builds a [`Simulation`] from bodies, colliders and settings. [`build`](Self::build) checks the colliders
/// and settings.
#[derive(Debug)]
pub struct SimulationBuilder {
    bodies: Vec<Body>,
    gravity: Curve<[f64; 3]>,
    dt: f64,
    fps: Option<f64>,
    colliders: Vec<Collider>,
    fields: Vec<Field>,
    links: Vec<Link>,
    substeps: Substeps,
    contact: ContactSettings,
    sleep: bool,
    threads: usize,
}

impl Default for SimulationBuilder {
    fn default() -> Self {
        Self {
            bodies: Vec::new(),
            gravity: [0.0, -9.81, 0.0].into(),
            dt: 1.0 / 60.0,
            fps: None,
            colliders: Vec::new(),
            fields: Vec::new(),
            links: Vec::new(),
            substeps: Substeps::Fixed(1),
            contact: ContactSettings { between: true, with_itself: false },
            sleep: true,
            threads: 0,
        }
    }
}

impl Simulation {
    /// Creates a builder without bodies.
    pub fn builder() -> SimulationBuilder {
        SimulationBuilder::default()
    }
}

impl SimulationBuilder {
    /// Adds a body.
    #[must_use]
    pub fn body(mut self, body: Body) -> Self {
        self.bodies.push(body);
        self
    }

    /// Sets gravity in scene units per second squared, each component at most 1e12 in magnitude: a vector, or a
    /// [`Curve`] of vectors. Default: (0, -9.81, 0). A step has gravity at its start. For the regions of a material and
    /// the automatic number of steps, the greatest gravity of a keyframe counts.
    #[must_use]
    pub fn gravity(mut self, gravity: impl Into<Curve<[f64; 3]>>) -> Self {
        self.gravity = gravity.into();
        self
    }

    /// Sets the length of a step in seconds, from 1e-12 to 1e6; default 1/60.
    #[must_use]
    pub fn dt(mut self, dt: f64) -> Self {
        self.dt = dt;
        self
    }

    /// Adds a collider.
    #[must_use]
    pub fn collider(mut self, collider: Collider) -> Self {
        self.colliders.push(collider);
        self
    }

    /// Adds an acceleration field: wind, drag, a vortex, an attraction.
    #[must_use]
    pub fn field(mut self, field: Field) -> Self {
        self.fields.push(field);
        self
    }

    /// Adds a link: glue or springs between a part of a body and another body or the world.
    #[must_use]
    pub fn link(mut self, link: Link) -> Self {
        self.links.push(link);
        self
    }

    /// Sets the number of frames per second, > 0. The length of a step is then 1/(fps x steps per frame), and
    /// [`dt`](Self::dt) has no effect.
    #[must_use]
    pub fn fps(mut self, fps: f64) -> Self {
        self.fps = Some(fps);
        self
    }

    /// Sets the number of steps per frame; default 1. [`Substeps::Auto`] needs [`fps`](Self::fps). The volume
    /// correction of the displayed surface uses the contacts and external forces of all steps since the frame began.
    #[must_use]
    pub fn substeps(mut self, substeps: Substeps) -> Self {
        self.substeps = substeps;
        self
    }

    /// Sets whether bodies touch each other; default true. Without it, contact between bodies takes no time and no
    /// memory.
    #[must_use]
    pub fn contact(mut self, contact: bool) -> Self {
        self.contact.between = contact;
        self
    }

    /// Sets whether the parts of a body touch each other; default false. A body can have
    /// [a setting of its own](crate::BodyBuilder::self_contact).
    #[must_use]
    pub fn self_contact(mut self, self_contact: bool) -> Self {
        self.contact.with_itself = self_contact;
        self
    }

    /// Sets whether bodies at rest fall asleep: they are then not stepped until something moves them; default true.
    #[must_use]
    pub fn sleep(mut self, sleep: bool) -> Self {
        self.sleep = sleep;
        self
    }

    /// Sets the number of threads, at most 1024; 0, the default, means one per processor. Without the feature
    /// `rayon` one thread is used.
    #[must_use]
    pub fn threads(mut self, threads: usize) -> Self {
        self.threads = threads;
        self
    }

    /// Builds the simulation, at time zero.
    ///
    /// # Errors
    ///
    /// No body, a number out of range, an invalid collider, a field or a link of a body that does not exist, or a
    /// link whose part is empty or, without a stiffness, too far from the other body.
    pub fn build(self) -> Result<Simulation, Error> {
        let colliders = self.checked_colliders()?;
        if self.bodies.is_empty() {
            return Err(Error::NoBody);
        }
        check_fields(&self.fields, &self.bodies)?;
        let links = Links::new(self.links.clone(), &self.bodies)?;
        let greatest = Vector3::from(self.gravity.longest());
        let (dt, steps) = (self.step_length(), self.fixed_substeps());
        let mut bodies = self.bodies;
        bodies.iter_mut().for_each(|body| body.join(&colliders, greatest.norm(), dt));
        let contacts = groups::create(&mut bodies, self.contact);
        let mut simulation = Simulation {
            bodies,
            contacts,
            contact: self.contact,
            pair_supports: PairSupports::default(),
            restored_contacts: Vec::new(),
            groups: Groups::default(),
            gravity: self.gravity.value(0.0).into(),
            gravity_curve: self.gravity,
            clock: Clock::new(dt),
            colliders,
            fields: self.fields,
            links,
            fps: self.fps,
            substeps: steps.into(),
            chosen: None,
            choose_at_next_step: self.substeps == Substeps::Auto,
            sleep: self.sleep,
            workspaces: Workspaces::default(),
            executor: Executor::new(self.threads),
        };
        if self.substeps == Substeps::Auto {
            simulation.choose_substeps();
        }
        Ok(simulation)
    }

    /// Returns the number of steps per frame, or 1 if it is automatic.
    fn fixed_substeps(&self) -> u32 {
        match self.substeps {
            Substeps::Fixed(steps) => steps,
            Substeps::Auto => 1,
        }
    }

    /// Returns the length of a step in seconds.
    fn step_length(&self) -> f64 {
        self.fps.map_or(self.dt, |fps| 1.0 / (fps * f64::from(self.fixed_substeps())))
    }

    /// Checks the settings and colliders, but not the bodies.
    ///
    /// # Errors
    ///
    /// A number out of range, or an invalid collider.
    pub fn validate(&self) -> Result<(), Error> {
        self.checked_colliders().map(drop)
    }

    fn checked_colliders(&self) -> Result<Colliders, Error> {
        if let Some(fps) = self.fps {
            Range::FPS.check("fps", fps)?;
        }
        check_substeps(self.substeps, self.fps)?;
        check_dt(self.step_length())?;
        check_threads(self.threads)?;
        check_gravity(&self.gravity)?;
        Ok(Colliders::new(&self.colliders)?)
    }
}
