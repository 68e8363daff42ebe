//! What is shown of a body: the volume correction and the mesh update. Nothing here feeds back into the dynamics.

use std::time::{Duration, Instant};

use nalgebra::Point3;

use super::state::Frame;
use super::{Body, Surface};
use crate::contact::{Clearance, Obstacles, SampleCells};
use crate::lattice::Lattice;
use crate::matching::cascade::Cascade;
use crate::parallel::Executor;
use crate::simd::Coordinate;
use crate::simd::lanes::Lanes;
use crate::simd::padded::{Padded, padded};
use crate::skin::{Asked, MeshUpdate, Shown};
use crate::volume::{
    self, ComponentReport, Correction, CorrectionWorkspace, Push, VolumeError, VolumeMeasure, VolumeMeasures,
    VolumeOptions, VolumeReport,
};

/// How often limits are looked for: the first time, where others then go farther, and where the corrected surface enters
/// a curved collider all the same. One or two rounds are common.
const ROUNDS: usize = 16;

/// How much farther than vertices go limits are looked for, so that it need not be done again where they go farther.
const MARGIN: f64 = 1.25;

/// The stages that run only where somebody looks, and their buffers. One value per lattice vertex or per mesh
/// vertex, in cells from the body's origin.
#[derive(Debug)]
pub(crate) struct View {
    options: VolumeOptions,
    correction: Option<Correction>,
    workspace: CorrectionWorkspace,
    /// All measures; built when a report is first asked for.
    measures: Option<VolumeMeasures>,
    mesh: MeshUpdate,
    turned: Lanes<4>,
    deformed: Vec<[f32; 3]>,
    rotations: Vec<[f32; 4]>,
    pushes: Vec<Push>,
    clearance: Clearance,
    corrected: Vec<[f32; 3]>,
    components: Vec<ComponentReport>,
    /// The lattice as it is shown.
    shown: Vec<Padded>,
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
            options: *volume,
            correction: Correction::new(lattice, borrowed, volume)?,
            workspace: CorrectionWorkspace::default(),
            measures: None,
            mesh: MeshUpdate::default(),
            turned: Lanes::default(),
            deformed: Vec::new(),
            rotations: Vec::new(),
            pushes: Vec::new(),
            clearance: Clearance::default(),
            corrected: Vec::new(),
            components: Vec::new(),
            shown: Vec::new(),
            frame,
            times: ViewTimes::default(),
        })
    }

    /// Corrects in another way from now on, or not at all.
    ///
    /// # Errors
    ///
    /// A correction that the body cannot have; nothing is changed then.
    pub(super) fn set_volume(
        &mut self,
        lattice: &Lattice,
        surface: Option<volume::Surface<'_>>,
        options: &VolumeOptions,
    ) -> Result<(), VolumeError> {
        self.correction = Correction::new(lattice, surface, options)?;
        self.options = *options;
        // No correction needs no memory.
        (self.workspace, self.pushes, self.components) =
            (CorrectionWorkspace::default(), Vec::new(), Vec::new());
        (self.rotations, self.corrected) = (Vec::new(), Vec::new());
        (self.turned, self.clearance) = (Lanes::default(), Clearance::default());
        Ok(())
    }

    /// Corrects the volume of the body as it is now.
    pub(super) fn correct(&mut self, body: &Body, cascade: &mut Cascade) {
        let start = Instant::now();
        let executor = &body.surroundings.executor;
        let slots = body.matching.layout.slots();
        self.frame = body.state.frame;
        self.deformed.clear();
        self.deformed.extend(slots.iter().map(|&slot| body.state.positions.get(slot)));
        let Some(correction) = &self.correction else { return };
        // The field turns with the positions shown, which are a step ahead of the state's rotations.
        self.turned.copy_from(&body.state.rotations);
        body.matching.turn(cascade, executor, &body.state.positions, &mut self.turned);
        self.rotations.clear();
        self.rotations.extend(slots.iter().map(|&slot| self.turned.get(slot)));
        correction.hold(&mut self.workspace, body.held());
        self.pushes.clear();
        self.pushes.extend(body.pushes());
        self.corrected.resize(slots.len(), [0.0; 3]);
        correction.solve(&mut self.workspace, executor, &self.deformed, &self.rotations, &self.pushes);
        if let (Some(contacts), Some(colliders)) = (&body.contacts, &body.surroundings.colliders) {
            let (time, frame) = (body.surroundings.time, self.frame.body_frame());
            self.keep_out(executor, contacts.samples(), &Obstacles { colliders, time, frame });
        }
        self.components.clear();
        if let Some(correction) = &self.correction {
            let components = correction.write(&self.workspace, &self.deformed, &mut self.corrected);
            self.components.extend_from_slice(components);
        }
        self.times.volume = start.elapsed();
    }

    /// What would enter a collider by the correction stops before it.
    fn keep_out(&mut self, executor: &Executor, samples: &SampleCells, obstacles: &Obstacles<'_>) {
        let Self { correction: Some(correction), workspace, clearance, deformed, corrected, .. } = self
        else {
            return;
        };
        let mut searched = 0.0;
        let curved = obstacles.are_curved();
        for _ in 0..ROUNDS {
            let reach = correction.reach(workspace);
            if reach > searched {
                searched = MARGIN * reach;
                clearance.find(samples, deformed, obstacles, searched);
                if clearance.limits().is_empty() {
                    return;
                }
            } else if searched > 0.0 && curved {
                correction.write(workspace, deformed, corrected);
                if !clearance.cut(samples, corrected, obstacles) {
                    return;
                }
            } else {
                return;
            }
            correction.limit(workspace, executor, clearance.limits());
        }
    }

    /// Moves the mesh with the corrected lattice and writes what is asked for; nothing for a bare lattice.
    pub(super) fn show<P: Coordinate, N: Coordinate>(
        &mut self,
        body: &Body,
        executor: &Executor,
        asked: Asked<P, N>,
    ) {
        let start = Instant::now();
        if let Some(surface) = &body.surface {
            let lattice = if self.correction.is_some() { &self.corrected } else { &self.deformed };
            self.shown.clear();
            self.shown.extend(lattice.iter().map(|&point| padded(point)));
            let (mesh, embedding, frame) = (&surface.mesh, &surface.embedding, &self.frame.body_frame());
            self.mesh.show(executor, Shown { mesh, embedding, lattice: &self.shown, frame }, asked);
        }
        self.times.embed = start.elapsed();
    }

    /// The lattice as it is shown, in the world.
    pub(super) fn lattice(&self) -> impl ExactSizeIterator<Item = Point3<f64>> {
        let shown = if self.correction.is_some() { &self.corrected } else { &self.deformed };
        shown.iter().map(|&point| self.frame.to_world(point.map(f64::from).into()))
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

    /// Whether and how the volume is kept, as asked for.
    pub(super) fn options(&self) -> VolumeOptions {
        self.options
    }

    /// The measure that is kept, if any is.
    pub(super) fn measure(&self) -> Option<VolumeMeasure> {
        self.correction.as_ref().map(Correction::measure)
    }

    /// Memory that the correction takes, and what it works on.
    pub(super) fn correction_bytes(&self) -> usize {
        let Self { turned, deformed, rotations, pushes, clearance, corrected, .. } = self;
        let lattice = size_of_val(&**deformed) + size_of_val(&**rotations) + size_of_val(&**corrected);
        let correction = self.correction.as_ref().map_or(0, Correction::bytes) + self.workspace.bytes();
        correction + turned.bytes() + lattice + size_of_val(&**pushes) + clearance.bytes()
    }

    /// Memory that the mesh update takes; none before the first look at a mesh.
    pub(super) fn update_bytes(&self) -> usize {
        self.mesh.bytes() + size_of_val(&*self.shown)
    }

    /// How long the stages took.
    pub(super) fn times(&self) -> ViewTimes {
        self.times
    }
}
