//! What is shown of a body: the volume correction and the mesh update. Nothing here feeds back into the dynamics.

use std::ops::Deref;
use std::time::{Duration, Instant};

use nalgebra::Point3;

use super::{Body, Surface};
use crate::contact::{Colliders, Contacts};
use crate::lattice::Lattice;
use crate::matching::{Purpose, Workspace};
use crate::mesh::Mesh;
use crate::parallel::Executor;
use crate::simd::Coordinate;
use crate::simd::lanes::Lanes;
use crate::simd::xyzx::{Xyzx, xyzx};
use crate::skin::{Outputs, Pose, SkinBuffers};
use crate::volume::{
    ComponentReport, Correction, CorrectionWorkspace, ExternalForce, Obstacles, VolumeMeasures, VolumeReport,
};

/// A body together with its simulation: what is shown depends on the colliders, the time and the threads.
///
/// [`Simulation::body`](crate::Simulation::body) gives it. All of [`Body`] can be called on it; [`BodyRef::get`] is the
/// body itself.
#[derive(Clone, Copy, Debug)]
pub struct BodyRef<'a> {
    body: &'a Body,
    scene: Option<Scene<'a>>,
}

/// What a simulation adds to a body that is shown.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scene<'a> {
    pub(crate) colliders: &'a Colliders,
    /// In seconds.
    pub(crate) time: f64,
    /// Length of a step in seconds.
    pub(crate) dt: f64,
    pub(crate) executor: &'a Executor,
}

impl Deref for BodyRef<'_> {
    type Target = Body;

    fn deref(&self) -> &Body {
        self.body
    }
}

impl<'a> BodyRef<'a> {
    pub(crate) fn new(body: &'a Body, scene: Scene<'a>) -> Self {
        Self { body, scene: Some(scene) }
    }

    /// The body itself, for as long as the simulation is borrowed.
    pub fn get(self) -> &'a Body {
        self.body
    }

    /// The mesh in the model's frame; `None` for a bare lattice.
    pub fn mesh(self) -> Option<&'a Mesh> {
        self.body.mesh()
    }

    /// The lattice, in the model's frame.
    pub fn lattice(self) -> &'a Lattice {
        self.body.lattice()
    }

    /// The mesh as it is shown: moved by the lattice after the volume correction. A [`Display`] that is kept evaluates
    /// many frames faster.
    pub fn surface(self) -> DisplayedSurface {
        Display::new().evaluate(self).surface()
    }

    /// The lattice after the volume correction, shape `(n, 3)`; without a correction the positions.
    pub fn corrected_positions(self) -> Vec<Point3<f64>> {
        Display::new().evaluate(self).positions().collect()
    }

    /// The volumes by all measures, and the effect of the correction on them.
    pub fn volume_report(self) -> VolumeReport {
        Display::new().evaluate(self).volume_report()
    }

    /// The volume as it is shown, in cubed scene units: by the measure that is kept, or without a correction by the best
    /// measure of the body.
    pub fn volume(self) -> f64 {
        self.volume_report().after
    }
}

/// A body by itself.
impl<'a> From<&'a Body> for BodyRef<'a> {
    fn from(body: &'a Body) -> Self {
        Self { body, scene: None }
    }
}

impl Body {
    /// The body by itself, to show it without a simulation: no collider limits its volume correction.
    pub fn alone(&self) -> BodyRef<'_> {
        self.into()
    }
}

/// A mesh as it is shown: after the volume correction, in the order of the input.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct DisplayedSurface {
    /// One per mesh vertex, in the world; empty for a bare lattice.
    pub positions: Vec<Point3<f64>>,
    /// Unit normals, one per mesh vertex; zero where no face has area.
    pub normals: Vec<[f32; 3]>,
}

/// Evaluates what is shown of a body, and owns the buffers of that. Kept over many frames it allocates nothing after
/// the first; it may serve different bodies, but is fastest with one.
#[derive(Debug, Default)]
pub struct Display {
    sums: Workspace,
    correction: CorrectionWorkspace,
    skin: SkinBuffers,
    /// The lattice in cells from the origin of the body, in vertex order: before and after the correction, and as the
    /// mesh update reads it.
    deformed: Vec<[f32; 3]>,
    corrected: Vec<[f32; 3]>,
    displayed: Vec<Xyzx>,
    /// The rotations of the positions shown, which are a step ahead of those of the state.
    turned: Lanes<4>,
    rotations: Vec<[f32; 4]>,
    pushes: Vec<ExternalForce>,
    components: Vec<ComponentReport>,
    times: DisplayTimes,
}

/// The time that the stages of a display took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct DisplayTimes {
    /// The volume correction, with the rotations that turn its field.
    pub volume: Duration,
    /// The mesh update, with its normals.
    pub embed: Duration,
}

impl Display {
    /// Empty buffers.
    pub fn new() -> Self {
        Self::default()
    }

    /// Corrects the volume of a body as it is now: P~ = P^ + lambda V (Takamatsu & Kanai 2009, eq. 1).
    pub fn evaluate<'a>(&'a mut self, body: impl Into<BodyRef<'a>>) -> Displayed<'a> {
        let body = body.into();
        let start = Instant::now();
        let executor = body.scene.map_or_else(Executor::sequential, |scene| scene.executor.clone());
        let Body { state, matching, correction, .. } = body.body;
        let slots = matching.layout.slots();
        self.deformed.clear();
        self.deformed.extend(slots.iter().map(|&slot| state.positions.get(slot)));
        self.times = DisplayTimes::default();
        if let Some(correction) = correction {
            self.turned.copy_from(&state.rotations);
            let fitted = (&state.positions, &mut self.turned);
            matching.fit(&mut self.sums, &executor, fitted, None, Purpose::Transform);
            self.rotations.clear();
            self.rotations.extend(slots.iter().map(|&slot| self.turned.get(slot)));
            self.correct(body, correction, &executor);
            self.times.volume = start.elapsed();
        }
        Displayed { display: self, body: body.body, executor }
    }

    fn correct(&mut self, body: BodyRef<'_>, correction: &Correction, executor: &Executor) {
        let Self { correction: workspace, deformed, corrected, rotations, pushes, .. } = self;
        correction.hold(workspace, body.held());
        pushes.clear();
        pushes.extend(body.scene.into_iter().flat_map(|scene| body.body.pushes(scene.dt)));
        correction.solve(workspace, executor, deformed, rotations, pushes);
        corrected.resize(deformed.len(), [0.0; 3]);
        if let Some(Scene { colliders, time, .. }) = body.scene.filter(|scene| !scene.colliders.is_empty()) {
            let obstacles = Obstacles { colliders, time, frame: body.state.frame.body_frame() };
            // A body that has not stepped in this simulation yet may have no contact stage.
            let sampled = body.contacts.is_none().then(|| body.samples());
            let samples = body.contacts.as_ref().map(Contacts::samples).or(sampled.as_ref());
            if let Some(samples) = samples {
                correction.keep_out(workspace, executor, samples, &obstacles, deformed, corrected);
            }
        }
        self.components.clear();
        self.components.extend_from_slice(correction.write(workspace, deformed, corrected));
    }

    /// Memory of the buffers.
    pub fn bytes(&self) -> usize {
        let lattice =
            size_of_val(&*self.deformed) + size_of_val(&*self.corrected) + size_of_val(&*self.displayed);
        let correction = self.correction.bytes() + size_of_val(&*self.pushes);
        let rotations = self.sums.bytes() + self.turned.bytes() + size_of_val(&*self.rotations);
        lattice + correction + rotations + self.skin.bytes()
    }
}

/// A body as a [`Display`] shows it.
#[derive(Debug)]
pub struct Displayed<'a> {
    display: &'a mut Display,
    body: &'a Body,
    executor: Executor,
}

impl Displayed<'_> {
    fn lattice(&self) -> &[[f32; 3]] {
        let Display { deformed, corrected, .. } = &*self.display;
        if self.body.correction.is_some() { corrected } else { deformed }
    }

    /// The lattice after the volume correction, in vertex order, in the world.
    pub fn positions(&self) -> impl ExactSizeIterator<Item = Point3<f64>> {
        let frame = self.body.state.frame;
        self.lattice().iter().map(move |&point| frame.to_world(point.map(f64::from).into()))
    }

    /// The mesh and its normals.
    pub fn surface(&mut self) -> DisplayedSurface {
        let vertices = self.body.mesh().map_or(0, |mesh| mesh.vertices().len());
        let (mut positions, mut normals) = (vec![[0.0_f64; 3]; vertices], vec![[0.0_f32; 3]; vertices]);
        self.update_mesh(Outputs { positions: Some(&mut positions[..]), normals: Some(&mut normals[..]) });
        DisplayedSurface { positions: positions.into_iter().map(Point3::from).collect(), normals }
    }

    /// Writes the mesh to `positions` (one per mesh vertex, `f32` or `f64`) and, where asked for, its unit normals to
    /// `normals`. Writes nothing for a bare lattice.
    ///
    /// # Panics
    ///
    /// If a slice has another length than the mesh has vertices.
    pub fn surface_into<T: Coordinate>(&mut self, positions: &mut [[T; 3]], normals: Option<&mut [[T; 3]]>) {
        self.update_mesh(Outputs { positions: Some(positions), normals });
    }

    /// Writes the unit normals of the mesh, one per mesh vertex.
    ///
    /// # Panics
    ///
    /// If there is another number of normals than of mesh vertices.
    pub fn normals_into<T: Coordinate>(&mut self, normals: &mut [[T; 3]]) {
        self.update_mesh(Outputs::<T, T> { positions: None, normals: Some(normals) });
    }

    fn update_mesh<P: Coordinate, N: Coordinate>(&mut self, outputs: Outputs<'_, P, N>) {
        let start = Instant::now();
        if let Some(Surface { mesh, embedding, skin }) = &self.body.surface {
            let mut displayed = std::mem::take(&mut self.display.displayed);
            displayed.clear();
            displayed.extend(self.lattice().iter().map(|&point| xyzx(point)));
            let frame = &self.body.state.frame.body_frame();
            let pose = Pose { mesh, embedding, lattice: &displayed, frame };
            skin.evaluate(&self.executor, pose, outputs, &mut self.display.skin);
            self.display.displayed = displayed;
        }
        self.display.times.embed = start.elapsed();
    }

    /// The volumes by all measures, and the effect of the correction on them. The measures are built at the first call.
    pub fn volume_report(&self) -> VolumeReport {
        let Body { lattice, surface, measures, correction, .. } = self.body;
        let borrowed = || surface.as_ref().map(Surface::borrowed);
        let measures = measures.get_or_init(|| VolumeMeasures::new(lattice, borrowed()));
        let Display { deformed, corrected, components, .. } = &*self.display;
        match correction {
            None => measures.report(deformed),
            Some(correction) => measures.report_corrected(correction, components, deformed, corrected),
        }
    }

    /// The time that the stages took: the correction, and the last mesh update.
    pub fn times(&self) -> DisplayTimes {
        self.display.times
    }
}

impl Body {
    /// The lattice vertices that pins and handles hold now.
    fn held(&self) -> impl Iterator<Item = u32> + Clone {
        let held = self.constraints.as_ref().map_or(&[][..], |constraints| constraints.held());
        (0..).zip(held).filter(|(_, held)| **held).map(|(vertex, _)| vertex)
    }

    /// The displacements by contacts and forces since the frame began, divided by alpha: the softer the body, the more
    /// they weigh in the correction.
    fn pushes(&self, dt: f64) -> impl Iterator<Item = ExternalForce> {
        let scale = (1.0 / self.material.alpha(dt)) as f32;
        let contacts = self.contacts.iter().flat_map(|contacts| contacts.pushes());
        let forces = self.forces.iter().flat_map(|forces| forces.pushes());
        contacts
            .chain(forces)
            .map(move |(vertex, push)| ExternalForce { vertex, offset: push.map(|v| v * scale) })
    }
}
