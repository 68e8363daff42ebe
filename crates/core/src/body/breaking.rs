//! Bodies that break: the stage that finds breaking joints, cuts, and the event in which the topology changes.
//!
//! An event rebuilds what depends on the topology: the lattice, the regions and the samples of contacts. What is
//! displayed follows when it is needed: see `pieces`.

use std::borrow::Cow;
use std::sync::OnceLock;

use nalgebra::{Matrix3, Point3, Vector3};

use super::context::StepContext;
use super::parts::{Breaking, Pipeline, Settings, Shape};
use super::soft_body::Body;
use super::transfer::{Parents, transfer};
use crate::contact::Parts;
use crate::dynamics::{Constraints, Quantity, StiffnessFactors};
use crate::error::Error;
use crate::fracture::{CrackPlane, Cracks, Deformation, Fracture, FractureOptions};
use crate::lattice::{Lattice, Masses, cell_shares, dense_shares, masses_of_shares};
use crate::matching::Matching;
use crate::parallel::Executor;
use crate::range::in_range;

impl Body {
    /// Prepares the body to break. `shares`: the filled share of each cell, which the masses of the body have.
    pub(super) fn arm(&mut self, options: FractureOptions, shares: Vec<f64>) {
        self.breaking = Some(Box::new(self.create_breaking(Some(options), shares)));
        self.pipeline.matching.set_covariances(true);
    }

    /// Returns the share of each cell that a body that breaks divides its masses by: the filled share, times the factor of
    /// the density. `whole` is the lattice before the body broke.
    fn breaking_shares(&self, whole: &Lattice) -> Vec<f64> {
        let shares = cell_shares(whole, self.whole_mesh());
        match self.settings.parts.of(Quantity::Density) {
            Some(factors) => dense_shares(whole, shares, factors),
            None => shares,
        }
    }

    /// Gives the body its masses anew, for other factors of the density. Positions, velocities and plastic shapes are
    /// unchanged.
    pub(super) fn update_masses(&mut self) {
        let whole = self.whole().0;
        let shares = self.breaking.is_some().then(|| self.breaking_shares(&whole));
        let masses = match (&shares, self.settings.parts.of(Quantity::Density)) {
            (Some(shares), _) => Masses::of_shares(&whole, shares),
            (None, Some(factors)) => Masses::new(&whole, self.mesh()).denser(&whole, factors),
            (None, None) => Masses::new(&whole, self.mesh()),
        };
        let lattice = &self.shape.lattice;
        let masses = match (&mut self.breaking, shares) {
            (Some(breaking), Some(shares)) => {
                let of_pieces = masses.with_vertices(divided_masses(lattice, &shares, &masses));
                (breaking.shares, breaking.whole_masses) = (shares, masses);
                of_pieces
            }
            _ => masses,
        };
        let mut matching = Matching::new(lattice, &masses, self.half_width());
        matching.set_terms_of(&self.pipeline.matching);
        self.shape.masses = masses;
        self.pipeline.matching = matching;
        self.state.fitted = false;
        self.state.momenta.fill(None);
        self.forget_elastic_measures();
        self.rebuild_stages();
    }

    /// Prepares the body to be cut.
    fn prepare_cut(&mut self) {
        if self.breaking.is_none() {
            let shares = self.breaking_shares(&self.shape.lattice);
            self.breaking = Some(Box::new(self.create_breaking(None, shares)));
        }
    }

    fn create_breaking(&self, options: Option<FractureOptions>, shares: Vec<f64>) -> Breaking {
        Breaking {
            fracture: Fracture::new(options, &self.shape.lattice, &self.pipeline.matching.layout),
            shares,
            whole: self.mesh().cloned(),
            whole_masses: self.shape.masses.clone(),
            weakest: (0.0, 1.0),
            has_gradients: false,
            is_due: false,
            has_new_pieces: false,
        }
    }

    /// Returns the options of fracture; `None` if the body does not break by itself.
    pub fn fracture(&self) -> Option<&FractureOptions> {
        self.breaking.as_ref().and_then(|breaking| breaking.fracture.options())
    }

    /// Returns whether the body breaks by itself.
    pub(crate) fn is_armed(&self) -> bool {
        self.breaking.as_ref().is_some_and(|breaking| breaking.fracture.is_armed())
    }

    /// Returns the number of pieces: of connected components of the lattice.
    pub fn pieces(&self) -> usize {
        self.shape.lattice.components().count
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
    pub(super) fn whole(&self) -> (Cow<'_, Lattice>, &Masses) {
        match &self.breaking {
            Some(breaking) if !self.shape.lattice.broken_joints().is_empty() => {
                (Cow::Owned(self.shape.lattice.with_broken_joints(&[])), &breaking.whole_masses)
            }
            _ => (Cow::Borrowed(&self.shape.lattice), &self.shape.masses),
        }
    }

    /// Returns the memory of the stage in bytes.
    pub(super) fn breaking_bytes(&self) -> usize {
        self.breaking.as_ref().map_or(0, |breaking| {
            let Breaking { fracture, shares, whole_masses, .. } = &**breaking;
            fracture.bytes() + size_of_val(&**shares) + whole_masses.bytes()
        })
    }

    /// Cuts the body along a plane: breaks all joints between cells on different sides of it. Returns the number of
    /// joints that broke.
    ///
    /// The plane is in world space. It is carried back to the rest shape of each connected piece by the affine motion
    /// that fits the piece best, so that it is met exactly where the piece is not bent.
    ///
    /// * `point`: a point of the plane.
    /// * `normal`: a normal, of any length > 0.
    ///
    /// # Errors
    ///
    /// A point or normal that is not finite, or a normal of length 0. The body is then unchanged.
    pub fn cut(&mut self, point: [f64; 3], normal: [f64; 3]) -> Result<usize, Error> {
        self.check_deforms("a cut")?;
        for x in point {
            in_range("cut", x, x.abs() <= self.coordinate_limit(), "finite and at most 1e15 cells")?;
        }
        // Divided by the greatest coordinate first, so that no square overflows.
        let greatest = normal
            .into_iter()
            .fold(0.0, |greatest: f64, x| if x.abs() <= greatest { greatest } else { x.abs() });
        in_range(
            "length of the normal of a cut",
            greatest,
            greatest > 0.0 && greatest.is_finite(),
            "finite and greater than 0",
        )?;
        let normal = (Vector3::from(normal) / greatest).normalize();
        let planes = self.planes_at_rest(point.into(), normal);
        self.prepare_cut();
        let before = self.broken_joints();
        let Self { shape: Shape { lattice, .. }, breaking: Some(breaking), .. } = self else { return Ok(0) };
        if breaking.fracture.cut(lattice, &planes) {
            self.change_topology();
        }
        Ok(self.broken_joints() - before)
    }

    /// Returns a plane of world space in the rest shape of each component: see [`Body::cut`]. `None` for a component
    /// that is flattened, so that no plane at rest has this normal.
    fn planes_at_rest(&self, point: Point3<f64>, normal: Vector3<f64>) -> Vec<Option<CrackPlane>> {
        let components = self.shape.lattice.components();
        let mut sums = vec![AffineSums::default(); components.count];
        let origin = self.state.frame.to_world(Vector3::zeros());
        let vertices = || {
            (0..).zip(&components.of_vertex).zip(&*self.shape.masses).map(|((vertex, &component), &mass)| {
                let slot = self.pipeline.matching.layout.slots()[vertex as usize];
                let position = self.state.frame.to_world(self.state.local(slot)) - origin;
                (
                    component as usize,
                    f64::from(mass),
                    position,
                    self.shape.lattice.rest_position(vertex).coords,
                )
            })
        };
        for (component, mass, position, rest) in vertices() {
            let sums = &mut sums[component];
            sums.mass += mass;
            sums.center += position * mass;
            sums.rest_center += rest * mass;
        }
        for AffineSums { mass, center, rest_center, .. } in &mut sums {
            *center /= *mass;
            *rest_center /= *mass;
        }
        for (component, mass, position, rest) in vertices() {
            let sums = &mut sums[component];
            let arm = rest - sums.rest_center;
            sums.moment += (position - sums.center) * arm.transpose() * mass;
            sums.rest_moment += arm * arm.transpose() * mass;
        }
        sums.iter().map(|sums| sums.plane_at_rest(point - origin, normal)).collect()
    }

    /// Returns the greatest Young's modulus in force in steps of `dt` seconds, and the least factor of the limits.
    pub(super) fn weakest(&self, dt: f64) -> (f64, f64) {
        let greatest = self.stiffness_factors.as_ref().map_or(1.0, StiffnessFactors::greatest_of_modulus);
        (self.modulus_in_force(dt) * greatest, self.settings.parts.least(Quantity::Strength))
    }

    /// Finds the joints that break in this step.
    pub(super) fn find_breaking(&mut self, context: &StepContext, executor: &Executor) {
        let modulus = self.modulus_in_force(context.interval.dt);
        let half_width = self.half_width();
        let is_one_task = self.is_one_task();
        let Self {
            pipeline: Pipeline { matching, workspace, .. },
            shape: Shape { lattice, .. },
            breaking: Some(breaking),
            state,
            constraints,
            stiffness_factors,
            settings: Settings { parts, .. },
            ..
        } = self
        else {
            return;
        };
        if !breaking.has_gradients && breaking.fracture.needs_gradients() {
            let mut shared = is_one_task.then(|| context.workspaces.lock(executor));
            let workspace = shared.as_deref_mut().unwrap_or(workspace);
            if let Some(gradients) = breaking.fracture.gradients(breaking.weakest, true) {
                matching.measure(workspace, executor, &state.positions, gradients);
            }
        }
        if let Some(strains) = &state.strains
            && let Some(gradients) = breaking.fracture.gradients(breaking.weakest, true)
        {
            gradients.take_elastic_parts(strains, executor, matching.cascade.task_blocks());
        }
        let factors = stiffness_factors.as_ref().map(|factors| |vertex: u32| factors.of_modulus(vertex));
        let strengths = parts.on(lattice, Quantity::Strength);
        let deformation = Deformation {
            lattice,
            layout: &matching.layout,
            rotations: &state.rotations,
            half_width,
            modulus,
            factors: factors.as_ref().map(|factor| factor as &dyn Fn(u32) -> f64),
            strengths: strengths.as_ref().map(|strength| strength as &dyn Fn(u32) -> f64),
            held: Constraints::constrained_by(constraints.as_ref()),
        };
        breaking.is_due = breaking.fracture.find_breaking(&deformation);
    }

    /// Breaks the joints that the step found.
    pub(crate) fn break_joints(&mut self) {
        let Some(breaking) = self.breaking.as_mut().filter(|breaking| breaking.is_due) else { return };
        breaking.is_due = false;
        breaking.fracture.break_found();
        self.change_topology();
    }

    /// Returns whether the body has pieces that the contacts of the simulation have not registered, and resets this
    /// mark.
    pub(crate) fn take_new_pieces(&mut self) -> bool {
        self.breaking.as_mut().is_some_and(|breaking| std::mem::take(&mut breaking.has_new_pieces))
    }

    /// Returns whether the body broke into pieces, which touch each other.
    pub(crate) fn is_in_pieces(&self) -> bool {
        Parts::new(&self.shape.lattice).are_several()
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
    pub(super) fn restore_cracks(&mut self, cracks: Option<&Cracks>) {
        if self.cracks().as_ref() == cracks {
            return;
        }
        self.prepare_cut();
        if let Some(breaking) = &mut self.breaking {
            breaking.fracture.set_cracks(cracks.cloned().unwrap_or_default());
        }
        self.change_topology();
    }

    /// Returns the lattice with the cracks of a snapshot, if they differ from the cracks of the body. `Err` if they
    /// do not fit it.
    pub(super) fn lattice_with(&self, cracks: Option<&Cracks>) -> Result<Option<Lattice>, ()> {
        if self.cracks().as_ref() == cracks {
            return Ok(None);
        }
        let cracks = cracks.cloned().unwrap_or_default();
        if !cracks.fits(&self.shape.lattice) {
            return Err(());
        }
        Ok(Some(cracks.broken_lattice(&self.shape.lattice)))
    }

    /// Rebuilds the body after its cracks changed.
    fn change_topology(&mut self) {
        let Some(breaking) = &mut self.breaking else { return };
        breaking.has_new_pieces = true;
        let lattice = breaking.fracture.cracks().broken_lattice(&self.shape.lattice);
        let parents = Parents::new(&self.shape.lattice, &lattice, &breaking.shares);
        let masses = divided_masses(&lattice, &breaking.shares, &breaking.whole_masses);
        let masses = breaking.whole_masses.with_vertices(masses);
        let mut matching = Matching::new(&lattice, &masses, self.pipeline.matching.regions.half_width());
        matching.set_terms_of(&self.pipeline.matching);
        breaking.fracture.prepare(&lattice, &matching.layout);

        self.state = transfer(&self.state, &parents, (&self.pipeline.matching, &matching), &lattice);
        self.display.correction = OnceLock::new();
        self.display.measures = OnceLock::new();
        self.pipeline.fast_vertex = 0;
        self.contact.leaving.clear();
        self.shape.lattice = lattice;
        self.shape.masses = masses;
        self.pipeline.matching = matching;
        self.shape.surface = self.shape.surface.as_ref().map(|_| OnceLock::new());
        self.follow_in_stages(&parents);
        self.rebuild_stages();
        self.wake();
    }
}

/// Returns the masses of the vertices of a broken lattice: copies share the mass of their vertex in proportion to the
/// filled shares of their cells.
fn divided_masses(lattice: &Lattice, shares: &[f64], whole_masses: &[f32]) -> Vec<f32> {
    if lattice.broken_joints().is_empty() {
        return whole_masses.to_vec();
    }
    let parts = masses_of_shares(lattice, shares);
    let source = |vertex: usize| lattice.source(vertex as u32) as usize;
    let mut sums = vec![0.0; whole_masses.len()];
    parts.iter().enumerate().for_each(|(vertex, &part)| sums[source(vertex)] += f64::from(part));
    // The masses of an armed body are made of the same shares, so that this factor is exactly 1.
    let factor = |source: usize| f64::from(whole_masses[source]) / sums[source];
    let part = |(vertex, &part): (usize, &f32)| (f64::from(part) * factor(source(vertex))) as f32;
    parts.iter().enumerate().map(part).collect()
}

/// Sums over the vertices of a component, for the affine motion from its rest shape that fits it best.
#[derive(Clone, Debug, Default)]
struct AffineSums {
    mass: f64,
    center: Vector3<f64>,
    rest_center: Vector3<f64>,
    /// Σ m (x - center) (x⁰ - rest center)ᵀ
    moment: Matrix3<f64>,
    /// Σ m (x⁰ - rest center) (x⁰ - rest center)ᵀ
    rest_moment: Matrix3<f64>,
}

impl AffineSums {
    /// Returns the plane at rest that the motion moves to a plane through `point`.
    fn plane_at_rest(&self, point: Vector3<f64>, normal: Vector3<f64>) -> Option<CrackPlane> {
        let affine = self.moment * self.rest_moment.try_inverse()?;
        // The points X with normal . (affine (X - rest_center) + center - point) = 0.
        let direction = affine.transpose() * normal;
        let squared = direction.norm_squared();
        let offset = normal.dot(&(point - self.center)) / squared;
        let point = Point3::from(self.rest_center + direction * offset);
        let is_finite = squared > 0.0 && point.iter().all(|x| x.is_finite());
        is_finite.then(|| CrackPlane { point, normal: direction.normalize() })
    }
}
