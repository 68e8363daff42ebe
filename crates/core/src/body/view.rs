//! What is shown of a body: the volume correction and the mesh update. Nothing here feeds back into the dynamics.

use std::time::{Duration, Instant};

use nalgebra::Point3;

use super::state::Frame;
use super::{Body, Surface};
use crate::lanes::Lanes;
use crate::lattice::Lattice;
use crate::matching::cascade::Cascade;
use crate::mesh::VertexNormals;
use crate::parallel::Executor;
use crate::volume::{
    ComponentReport, Correction, Push, VolumeError, VolumeMeasure, VolumeMeasures, VolumeOptions,
    VolumeReport,
};

/// The stages that run only where somebody looks, and their buffers. One value per lattice vertex or per mesh
/// vertex, in cells from the body's origin.
#[derive(Debug)]
pub(crate) struct View {
    correction: Option<Correction>,
    /// All measures; built when a report is first asked for.
    measures: Option<VolumeMeasures>,
    normals: Option<VertexNormals>,
    turned: Lanes<4>,
    deformed: Vec<[f32; 3]>,
    rotations: Vec<[f32; 4]>,
    held: Vec<u32>,
    pushes: Vec<Push>,
    corrected: Vec<[f32; 3]>,
    components: Vec<ComponentReport>,
    points: Vec<[f32; 3]>,
    directions: Vec<[f32; 3]>,
    frame: Frame,
    times: ViewTimes,
}

/// How long the stages of the last look took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ViewTimes {
    /// The volume correction, with the rotations that turn its field.
    pub volume: Duration,
    /// The mesh update, with its normals.
    pub embed: Duration,
}

impl View {
    /// The stages that a body needs, not yet run.
    ///
    /// # Errors
    ///
    /// A correction that the body cannot have.
    pub(super) fn new(
        lattice: &Lattice,
        surface: Option<&Surface>,
        volume: &VolumeOptions,
        frame: Frame,
    ) -> Result<Self, VolumeError> {
        let borrowed = surface.map(Surface::borrowed);
        Ok(Self {
            correction: Correction::new(lattice, borrowed, volume)?,
            measures: None,
            normals: None,
            turned: Lanes::default(),
            deformed: Vec::new(),
            rotations: Vec::new(),
            held: Vec::new(),
            pushes: Vec::new(),
            corrected: Vec::new(),
            components: Vec::new(),
            points: Vec::new(),
            directions: Vec::new(),
            frame,
            times: ViewTimes::default(),
        })
    }

    /// Corrects the volume of the body as it is now.
    pub(super) fn correct(&mut self, body: &Body, cascade: &mut Cascade, executor: &Executor) {
        let start = Instant::now();
        let slots = body.matching.layout.slots();
        self.frame = body.state.frame;
        self.deformed.clear();
        self.deformed.extend(slots.iter().map(|&slot| body.state.positions.get(slot)));
        let Some(correction) = &mut self.correction else { return };
        // The field turns with the positions shown, which are a step ahead of the state's rotations.
        self.turned.clone_from(&body.state.rotations);
        body.matching.turn(cascade, executor, &body.state.positions, &mut self.turned);
        self.rotations.clear();
        self.rotations.extend(slots.iter().map(|&slot| self.turned.get(slot)));
        if !body.held().eq(self.held.iter().copied()) {
            self.held.clear();
            self.held.extend(body.held());
            correction.hold(&self.held);
        }
        self.pushes.clear();
        self.pushes.extend(body.pushes());
        self.corrected.resize(slots.len(), [0.0; 3]);
        let (rotations, pushes) = (&self.rotations, &self.pushes);
        let reports = correction.apply_with(executor, &self.deformed, rotations, pushes, &mut self.corrected);
        self.components.clear();
        self.components.extend_from_slice(reports);
        self.times.volume = start.elapsed();
    }

    /// Moves the mesh with the corrected lattice.
    pub(super) fn embed(&mut self, body: &Body) {
        let start = Instant::now();
        if let Some(surface) = &body.surface {
            let lattice = if self.correction.is_some() { &self.corrected } else { &self.deformed };
            self.points.resize(surface.mesh.vertices().len(), [0.0; 3]);
            surface.embedding.interpolate(lattice, &mut self.points);
        }
        self.times.embed = start.elapsed();
    }

    /// Vertex normals of the mesh, after [`View::embed`].
    pub(super) fn turn_normals(&mut self, body: &Body) {
        let start = Instant::now();
        if let Some(surface) = &body.surface {
            let normals = self.normals.get_or_insert_with(|| VertexNormals::new(&surface.mesh));
            self.directions.resize(self.points.len(), [0.0; 3]);
            normals.compute(&self.points, &mut self.directions);
        }
        self.times.embed += start.elapsed();
    }

    /// The lattice as it is shown, in the world.
    pub(super) fn lattice(&self) -> impl ExactSizeIterator<Item = Point3<f64>> {
        let shown = if self.correction.is_some() { &self.corrected } else { &self.deformed };
        shown.iter().map(|&point| self.world(point))
    }

    /// The mesh as it is shown, in the world.
    pub(super) fn surface(&self) -> impl ExactSizeIterator<Item = Point3<f64>> {
        self.points.iter().map(|&point| self.world(point))
    }

    /// The vertex normals of the mesh as it is shown.
    pub(super) fn normals(&self) -> &[[f32; 3]] {
        &self.directions
    }

    /// What the correction did, by all measures.
    pub(super) fn report(&mut self, body: &Body) -> VolumeReport {
        let surface = body.surface.as_ref().map(Surface::borrowed);
        let measures = self.measures.get_or_insert_with(|| VolumeMeasures::new(&body.lattice, surface));
        match &self.correction {
            None => measures.report(&self.deformed),
            Some(correction) => {
                measures.report_corrected(correction, &self.components, &self.deformed, &self.corrected)
            }
        }
    }

    /// The measure that is kept, if any is.
    pub(super) fn measure(&self) -> Option<VolumeMeasure> {
        self.correction.as_ref().map(Correction::measure)
    }

    /// Memory that the correction takes.
    pub(super) fn bytes(&self) -> usize {
        self.correction.as_ref().map_or(0, Correction::bytes)
    }

    /// How long the stages took.
    pub(super) fn times(&self) -> ViewTimes {
        self.times
    }

    fn world(&self, local: [f32; 3]) -> Point3<f64> {
        self.frame.to_world(local.map(f64::from).into())
    }
}
