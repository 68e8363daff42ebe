//! Bodies that break: the stage that finds breaking joints, cuts, and the event in which the topology changes.
//!
//! An event rebuilds what depends on the topology: the lattice, the regions and the samples of contacts. What is
//! displayed follows when it is needed: see `pieces`.

use std::borrow::Cow;
use std::sync::OnceLock;

use nalgebra::{Point3, Unit, Vector3};

use super::transfer::{Parents, transfer};
use super::{Body, StepContext};
use crate::contact::Contacts;
use crate::dynamics::{ElasticDamper, MomentumTracker, RegionDamper, StiffnessFactors};
use crate::error::Error;
use crate::fracture::{Cracks, Fracture, FractureOptions, Stretch};
use crate::lattice::{Lattice, cell_shares, masses_of_shares};
use crate::matching::{Matching, Workspace};
use crate::mesh::Mesh;
use crate::parallel::Executor;
use crate::range::in_range;

/// The stage of a body that can break or was cut.
#[derive(Debug)]
pub(super) struct Breaking {
    pub(super) fracture: Fracture,
    /// Filled share of each cell.
    shares: Vec<f64>,
    /// The mesh of the whole body.
    pub(super) whole: Option<Mesh>,
    /// The masses of the vertices of the whole body.
    whole_masses: Vec<f32>,
    /// Whether joints were found that break at the end of the step.
    is_due: bool,
    /// Whether the contacts of the simulation have to learn of new pieces.
    has_new_pieces: bool,
}

impl Body {
    /// Prepares the body to break. `shares`: the filled share of each cell, which the masses of the body have.
    pub(super) fn arm(&mut self, options: FractureOptions, shares: Vec<f64>) {
        self.breaking = Some(Box::new(self.create_breaking(Some(options), shares)));
    }

    /// Prepares the body to be cut.
    fn prepare_cut(&mut self) {
        if self.breaking.is_none() {
            let shares = cell_shares(&self.lattice, self.mesh());
            self.breaking = Some(Box::new(self.create_breaking(None, shares)));
        }
    }

    fn create_breaking(&self, options: Option<FractureOptions>, shares: Vec<f64>) -> Breaking {
        Breaking {
            fracture: Fracture::new(options, &self.lattice, &self.matching.layout),
            shares,
            whole: self.mesh().cloned(),
            whole_masses: self.masses.clone(),
            is_due: false,
            has_new_pieces: false,
        }
    }

    /// Returns the options of fracture; `None` if the body does not break by itself.
    pub fn fracture(&self) -> Option<&FractureOptions> {
        self.breaking.as_ref().and_then(|breaking| breaking.fracture.options())
    }

    /// Returns whether the body breaks by itself.
    pub(super) fn is_armed(&self) -> bool {
        self.breaking.as_ref().is_some_and(|breaking| breaking.fracture.is_armed())
    }

    /// Returns the number of pieces: of connected components of the lattice.
    pub fn pieces(&self) -> usize {
        self.lattice.components().count
    }

    /// Returns the number of broken joints: common faces of two cells along which the body is cut.
    pub fn broken_joints(&self) -> usize {
        self.breaking.as_ref().map_or(0, |breaking| breaking.fracture.cracks().broken_count())
    }

    /// Returns the number of events so far in which joints broke. While it stays the same, so do the faces of the
    /// displayed mesh and the lattice. A state that is restored restores it.
    pub fn topology_version(&self) -> u64 {
        self.breaking.as_ref().map_or(0, |breaking| breaking.fracture.cracks().event_count())
    }

    /// Returns the lattice and the masses that the body had before it broke.
    pub(super) fn whole(&self) -> (Cow<'_, Lattice>, &[f32]) {
        match &self.breaking {
            Some(breaking) if !self.lattice.broken_joints().is_empty() => {
                (Cow::Owned(self.lattice.with_broken_joints(&[])), &breaking.whole_masses)
            }
            _ => (Cow::Borrowed(&self.lattice), &self.masses),
        }
    }

    /// Returns the memory of the stage in bytes.
    pub(super) fn breaking_bytes(&self) -> usize {
        self.breaking.as_ref().map_or(0, |breaking| {
            let Breaking { fracture, shares, whole_masses, .. } = &**breaking;
            fracture.bytes() + size_of_val(&**shares) + size_of_val(&**whole_masses)
        })
    }

    /// Cuts the body along a plane: breaks all joints between cells on different sides of it. Returns the number of
    /// joints that broke.
    ///
    /// The plane is in world space. It is carried back to the rest shape by the affine motion that fits the body best,
    /// so that it is met exactly where the body is not bent.
    ///
    /// * `point`: a point of the plane.
    /// * `normal`: a normal, of any length > 0.
    ///
    /// # Errors
    ///
    /// A point or normal that is not finite, or a normal of length 0. The body is then unchanged.
    pub fn cut(&mut self, point: [f64; 3], normal: [f64; 3]) -> Result<usize, Error> {
        for x in point.into_iter().chain(normal) {
            in_range("cut", x, x.abs() <= self.coordinate_limit(), "finite and at most 1e15 cells")?;
        }
        let length = Vector3::from(normal).norm();
        in_range("length of the normal of a cut", length, length > 0.0, "greater than 0")?;
        let (point, normal) = self.plane_at_rest(point.into(), Vector3::from(normal) / length);
        self.prepare_cut();
        let before = self.broken_joints();
        let Self { breaking: Some(breaking), lattice, .. } = self else { return Ok(0) };
        if breaking.fracture.cut(lattice, point, normal) {
            self.change_topology()?;
        }
        Ok(self.broken_joints() - before)
    }

    /// Returns a plane of world space at rest, in the model's frame: see [`Body::cut`].
    fn plane_at_rest(&self, point: Point3<f64>, normal: Vector3<f64>) -> (Point3<f64>, Unit<Vector3<f64>>) {
        let mass: f64 = self.masses.iter().map(|&mass| f64::from(mass)).sum();
        let positions = self.positions();
        let rest = |vertex: usize| self.lattice.rest_position(vertex as u32).coords;
        let (mut center, mut rest_center) = (Vector3::zeros(), Vector3::zeros());
        for (vertex, position) in positions.iter().enumerate() {
            let share = f64::from(self.masses[vertex]) / mass;
            center += position.coords * share;
            rest_center += rest(vertex) * share;
        }
        let (mut moment, mut rest_moment) = (nalgebra::Matrix3::zeros(), nalgebra::Matrix3::zeros());
        for (vertex, position) in positions.iter().enumerate() {
            let m = f64::from(self.masses[vertex]);
            let arm = rest(vertex) - rest_center;
            moment += (position.coords - center) * arm.transpose() * m;
            rest_moment += arm * arm.transpose() * m;
        }
        // Each cell spans three dimensions, so that the moment at rest is regular.
        let affine =
            rest_moment.try_inverse().map_or_else(nalgebra::Matrix3::identity, |inverse| moment * inverse);
        let direction = affine.transpose() * normal;
        let squared = direction.norm_squared();
        if squared == 0.0 || !squared.is_finite() {
            return (Point3::from(rest_center), Unit::new_unchecked(normal));
        }
        // The points X with normal . (affine (X - rest_center) + center - point) = 0.
        let offset = normal.dot(&(point.coords - center)) / squared;
        (Point3::from(rest_center + direction * offset), Unit::new_normalize(direction))
    }

    /// Finds the joints that break in this step.
    pub(super) fn find_breaking(&mut self, context: &StepContext, executor: &Executor) {
        let modulus = self.modulus_in_force(context.interval.dt);
        let half_width = self.half_width();
        let shared = self.is_one_task().then(|| context.workspaces.lock(executor));
        let Self { breaking: Some(breaking), matching, workspace, lattice, state, constraints, .. } = self
        else {
            return;
        };
        let workspace = shared.as_deref().unwrap_or(workspace);
        matching.goals_into(workspace, executor, breaking.fracture.goals_mut());
        let held = constraints.as_ref().map_or(&[][..], |constraints| constraints.constrained());
        let (layout, rotations) = (&matching.layout, &state.rotations);
        let stretch = Stretch { lattice, layout, rotations, half_width, modulus, held };
        breaking.is_due = breaking.fracture.find_breaking(&stretch, executor, matching.cascade.task_blocks());
    }

    /// Breaks the joints that the step found. Returns whether there were any.
    pub(crate) fn break_joints(&mut self) -> bool {
        let Some(breaking) = self.breaking.as_mut().filter(|breaking| breaking.is_due) else { return false };
        breaking.is_due = false;
        breaking.fracture.break_found();
        // The mesh of the pieces has as many vertices as a mesh can have at most, or the body stays as it is displayed.
        self.change_topology().is_ok()
    }

    /// Returns whether the body has pieces of which the contacts of the simulation do not know yet, and forgets it.
    pub(crate) fn take_new_pieces(&mut self) -> bool {
        self.breaking.as_mut().is_some_and(|breaking| std::mem::take(&mut breaking.has_new_pieces))
    }

    /// Returns whether the body broke into pieces, which touch each other.
    pub(crate) fn is_in_pieces(&self) -> bool {
        self.pieces() > 1 && !self.lattice.broken_joints().is_empty()
    }

    /// Returns the state of fracture, for a snapshot; `None` while the body is whole.
    pub(super) fn cracks(&self) -> Option<Cracks> {
        self.breaking
            .as_ref()
            .map(|breaking| breaking.fracture.cracks())
            .filter(|cracks| cracks.event_count() > 0)
            .cloned()
    }

    /// Rebuilds the body with the cracks of a snapshot, if they differ from its own.
    pub(super) fn restore_cracks(&mut self, cracks: Option<&Cracks>) -> Result<(), Error> {
        if self.cracks().as_ref() == cracks {
            return Ok(());
        }
        self.prepare_cut();
        if let Some(breaking) = &mut self.breaking {
            breaking.fracture.set_cracks(cracks.cloned().unwrap_or_default());
        }
        self.change_topology()
    }

    /// Returns the lattice with the cracks of a snapshot, if they differ from those of the body. `Err` if they do not
    /// fit it.
    pub(super) fn lattice_with(&self, cracks: Option<&Cracks>) -> Result<Option<Lattice>, ()> {
        if self.cracks().as_ref() == cracks {
            return Ok(None);
        }
        let cracks = cracks.cloned().unwrap_or_default();
        if !cracks.fits(&self.lattice) {
            return Err(());
        }
        Ok(Some(cracks.broken_lattice(&self.lattice)))
    }

    /// Rebuilds the body after its cracks changed.
    fn change_topology(&mut self) -> Result<(), Error> {
        let Some(breaking) = &mut self.breaking else { return Ok(()) };
        breaking.has_new_pieces = true;
        let lattice = breaking.fracture.cracks().broken_lattice(&self.lattice);
        let parents = Parents::new(&self.lattice, &lattice);
        let masses = masses_of_shares(&lattice, &breaking.shares);
        let mut matching = Matching::new(&lattice, &masses, self.matching.regions.half_width());
        matching.set_plastic(self.matching.is_plastic());
        breaking.fracture.prepare(&lattice, &matching.layout);

        self.state = transfer(&self.state, &parents, &self.masses, (&self.matching, &matching), &lattice);
        self.momentum = MomentumTracker::new(&lattice, &masses, &matching.layout, matching.cascade.tasks());
        self.energy = None;
        self.region_damping = self.material.has_region_damping().then(|| RegionDamper::new(&matching));
        self.elastic_damping = self.material.is_damped().then(ElasticDamper::default);
        self.correction = OnceLock::new();
        self.measures = OnceLock::new();
        self.fast_vertex = 0;
        self.leaving.clear();
        self.lattice = lattice;
        self.masses = masses;
        self.matching = matching;
        self.surface = self.surface.as_ref().map(|_| OnceLock::new());
        self.workspace =
            if self.is_one_task() { Workspace::default() } else { self.matching.cascade.workspace() };
        if let Some(factors) = self.stiffness_factors.take() {
            let specified = factors.specified();
            let specified = parents.first.iter().map(|&parent| specified[parent as usize]).collect();
            self.replace_stiffness_factors(Some(StiffnessFactors::new(specified)?));
        }
        if let Some(constraints) = &mut self.constraints {
            constraints.transfer(&parents.first);
            self.track_constraints();
        }
        if let Some(spacing) = self.contacts.as_ref().map(Contacts::spacing) {
            self.contacts = Some(Contacts::within(spacing, self.create_samples(spacing)));
        }
        self.renew_body_contact();
        self.wake();
        Ok(())
    }
}
