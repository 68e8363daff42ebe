//! Evaluates the displayed surface of a body. Nothing here feeds back into the dynamics.
//!
//! The volume correction moves the lattice vertices from their positions P^ to P~ = P^ + lambda V, with the
//! scale lambda and the field V (Takamatsu & Kanai 2009, Eq. (1); module `volume`). The mesh update then
//! interpolates the mesh in the cells of P~, trilinearly or smoothly, and computes its normals (module `skin`).

use nalgebra::Point3;
use web_time::{Duration, Instant};

use super::body_limits::BodyLimits;
use super::reference::BodyRef;
use super::untangling::Untangling;
use super::{Body, Surface};
use crate::lattice::{Slopes, Trust};
use crate::matching::{Purpose, Workspace};
use crate::parallel::Executor;
use crate::simd::Coordinate;
use crate::simd::lanes::Lanes;
use crate::simd::xyzx::{Xyzx, xyzx};
use crate::skin::{Outputs, Pose, SkinBuffers};
use crate::untangle::{UntanglingReport, may_be_inverted};
use crate::volume::{
    ComponentReport, Correction, CorrectionWorkspace, ExternalForce, VolumeMeasures, VolumeReport,
};

/// The displayed surface. For many frames, reusing one [`Display`] is faster.
impl BodyRef<'_> {
    /// Evaluates the displayed surface: the mesh, deformed by the lattice after the volume correction. For
    /// many frames, reusing one [`Display`] is faster.
    pub fn surface(self) -> DisplayedSurface {
        Display::new().evaluate(self).surface()
    }

    /// Returns the lattice positions after the volume correction, shape `(n, 3)`. Without a correction they
    /// equal the positions before the correction.
    pub fn corrected_positions(self) -> Vec<Point3<f64>> {
        Display::new().evaluate(self).positions().collect()
    }

    /// Returns the volumes by all measures, before and after the correction.
    pub fn volume_report(self) -> VolumeReport {
        Display::new().evaluate(self).volume_report()
    }

    /// Returns the volume after the correction, in cubed scene units, by the measure of the correction.
    /// Without a correction, uses the measure that `auto` would choose.
    pub fn volume(self) -> f64 {
        self.volume_report().after
    }
}

/// The displayed surface: the mesh after the volume correction, in the vertex order of the input.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct DisplayedSurface {
    /// Positions in world space, one per mesh vertex; empty for a bare lattice.
    pub positions: Vec<Point3<f64>>,
    /// Unit normals, one per mesh vertex; zero if all faces of the vertex are degenerate.
    pub normals: Vec<[f32; 3]>,
}

/// Evaluates displayed surfaces, and owns the buffers of the evaluation.
///
/// A `Display` that always evaluates the same body allocates in the first frame, when the constrained vertices
/// change, and in frames in which cells of the lattice are inside out.
/// [`Displayed::surface`] also allocates its result in each call; [`Displayed::surface_into`] does not. A `Display` can
/// evaluate several bodies, but one `Display` per body is faster.
#[derive(Debug, Default)]
pub struct Display {
    matching_workspace: Workspace,
    correction: CorrectionWorkspace,
    skin: SkinBuffers,
    /// P^: lattice positions before the correction, in cells from the origin of the body, in vertex order.
    deformed: Vec<[f32; 3]>,
    /// P~: lattice positions after the correction, in the units and the order of `deformed`.
    corrected: Vec<[f32; 3]>,
    /// P~, or P^ without a correction, as the mesh update reads it: (x, y, z, x) of each vertex.
    xyzx: Vec<Xyzx>,
    /// Slopes of `xyzx` along the axes, if the skin is smooth.
    slopes: Vec<[Xyzx; 3]>,
    /// Trust in the slopes of `deformed`, if the skin is smooth. It also holds for `corrected`.
    trust: Trust,
    /// Rotations fitted to the current positions, by slot (see [`Lanes`]). The rotations of the state are
    /// fitted to the positions one step earlier.
    slot_rotations: Lanes<4>,
    /// `slot_rotations` in vertex order.
    rotations: Vec<[f32; 4]>,
    external_forces: Vec<ExternalForce>,
    /// Finds the limits of the correction at other bodies.
    body_limits: BodyLimits,
    components: Vec<ComponentReport>,
    /// Present after the first frame in which a cell of the lattice was inside out.
    untangling: Option<Box<Untangling>>,
    times: DisplayTimes,
}

/// Greatest number of times that the corrected lattice is untangled, and corrected again.
const ROUNDS: usize = 8;

/// Run times of the evaluation of the displayed surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct DisplayTimes {
    /// Time of the volume correction, including the fit of the region rotations, by which the field V is
    /// rotated, and of the untangling of a lattice with cells inside out.
    pub volume: Duration,
    /// Time of the last mesh update (interpolation, and normals if they were requested). Zero
    /// before the first mesh update of an evaluation.
    pub mesh_update: Duration,
}

impl Display {
    /// Creates a display with empty buffers.
    pub fn new() -> Self {
        Self::default()
    }

    /// Corrects the volume of a body at its current positions: P~ = P^ + lambda V (Takamatsu & Kanai 2009,
    /// Eq. (1)).
    pub fn evaluate<'a>(&'a mut self, body: impl Into<BodyRef<'a>>) -> Displayed<'a> {
        let body = body.into();
        let start = Instant::now();
        let executor = body.context().map_or_else(Executor::sequential, |context| context.executor.clone());
        let Body { state, matching, .. } = body.get();
        let correction = body.get().correction();
        let slots = matching.layout.slots();
        self.deformed.clear();
        self.deformed.extend(slots.iter().map(|&slot| state.positions.get(slot)));
        self.times = DisplayTimes::default();
        if let Some(correction) = correction {
            body.get().set_rest_volumes(correction, &mut self.correction);
        }
        if let Some(untangling) = &mut self.untangling {
            untangling.begin(self.deformed.len());
        }
        if may_be_inverted(&matching.layout, &state.positions) {
            self.untangle_deformed(body, &executor);
        }
        self.update_trust(body);
        if let Some(correction) = correction {
            // The field V is rotated by the region rotations at the current positions.
            self.slot_rotations.copy_from(&state.rotations);
            let fitted = (&state.positions, &mut self.slot_rotations, body.get().shapes());
            let workspace = &mut self.matching_workspace;
            matching.fit(workspace, &executor, fitted, None, Purpose::Regions);
            matching.rotations_at_vertices(&self.slot_rotations, &mut self.rotations);
            self.correct(body, correction, &executor);
            // The scales of the scope `regional` would lead back to the same inverted cells.
            if !correction.is_regional() {
                self.untangle_corrected(body, correction, &executor);
            }
            if let Some(untangling) = &self.untangling {
                for (component, before) in self.components.iter_mut().zip(untangling.volumes()) {
                    component.before = *before;
                }
            }
        }
        if body.get().correction().is_some()
            || self.untangling.as_ref().is_some_and(|untangling| untangling.is_present())
        {
            self.times.volume = start.elapsed();
        }
        Displayed { display: self, body: body.get(), executor }
    }

    /// Runs the volume correction: sets the constrained vertices, removes the directions of external forces
    /// from the field (Eq. (2)), solves for lambda (Eq. (1)) and limits the correction at colliders.
    fn correct(&mut self, body: BodyRef<'_>, correction: &Correction, executor: &Executor) {
        let Self {
            correction: workspace,
            deformed,
            corrected,
            rotations,
            external_forces,
            body_limits,
            trust,
            ..
        } = self;
        correction.set_constrained(workspace, body.constrained_vertices());
        external_forces.clear();
        external_forces
            .extend(body.context().into_iter().flat_map(|context| body.get().external_forces(context.dt)));
        correction.solve(workspace, executor, deformed, rotations, external_forces, trust.values());
        corrected.resize(deformed.len(), [0.0; 3]);
        if let Some(surroundings) = body.surroundings() {
            correction.limit_at_obstacles(
                workspace,
                executor,
                (surroundings.samples(), &surroundings.obstacles),
                &mut body_limits.finder(body),
                deformed,
                corrected,
            );
        }
        self.components.clear();
        self.components.extend_from_slice(correction.write(workspace, deformed, corrected));
    }

    /// Untangles the deformed lattice, if a cell is inside out.
    #[cold]
    fn untangle_deformed(&mut self, body: BodyRef<'_>, executor: &Executor) {
        let Self { untangling, deformed, body_limits, correction: workspace, trust, .. } = self;
        let untangling = Untangling::prepared(untangling, body.get());
        if !untangling.is_inverted(deformed) {
            return;
        }
        if let Some(correction) = body.get().correction() {
            if let Some(smoothing) = body.get().smoothing() {
                smoothing.update_trust(deformed, trust);
            }
            untangling.set_volumes(correction.volumes(workspace, executor, deformed, trust.values()));
        }
        untangling.set_deformed(deformed);
        untangling.limit_if_crushed(deformed);
        untangling.untangle(body.surroundings(), &mut body_limits.finder(body), deformed);
    }

    /// Untangles the corrected lattice, if a cell is inside out, and corrects the volume again, until no cell is inside
    /// out. If the volume cannot be restored without such a cell, the corrected lattice stays as it was.
    fn untangle_corrected(&mut self, body: BodyRef<'_>, correction: &Correction, executor: &Executor) {
        for round in 1..=ROUNDS {
            let layout = &body.matching.layout;
            // The rotations by slot are not needed any more.
            for (&slot, &[x, y, z]) in layout.slots().iter().zip(&self.corrected) {
                self.slot_rotations.set(slot, [x, y, z, 0.0]);
            }
            if !may_be_inverted(layout, &self.slot_rotations) || !self.untangle_once(body) {
                break;
            }
            let is_stuck = self.deformed == self.corrected;
            self.deformed.clone_from(&self.corrected);
            self.update_trust(body);
            if is_stuck || round == ROUNDS {
                self.evaluate_corrected(correction, executor);
                break;
            }
            self.correct(body, correction, executor);
            if let Some(untangling) = &mut self.untangling {
                untangling.first.add_scales(&self.components);
            }
        }
        let Some(untangling) = &self.untangling else { return };
        if untangling.first.is_better_than(&self.components, correction.caps()) {
            self.restore_first_correction(body, correction, executor);
        } else {
            untangling.first.write_scales(&mut self.components);
        }
    }

    /// Replaces the corrected lattice by that of the first correction of the frame.
    #[cold]
    fn restore_first_correction(&mut self, body: BodyRef<'_>, correction: &Correction, executor: &Executor) {
        let Some(untangling) = &self.untangling else { return };
        self.deformed.copy_from_slice(&untangling.first.start);
        self.corrected.copy_from_slice(&untangling.first.corrected);
        self.update_trust(body);
        self.evaluate_corrected(correction, executor);
        if let Some(untangling) = &self.untangling {
            self.components.clone_from(&untangling.first.components);
        }
    }

    /// Updates the trust in the slopes of the deformed lattice, if the skin is smooth.
    fn update_trust(&mut self, body: BodyRef<'_>) {
        if let Some(smoothing) = body.get().smoothing() {
            smoothing.update_trust(&self.deformed, &mut self.trust);
        }
    }

    /// Evaluates the volumes of the corrected lattice, after it was changed.
    fn evaluate_corrected(&mut self, correction: &Correction, executor: &Executor) {
        let trust = self.trust.values();
        let reports = correction.replace(&mut self.correction, executor, &self.corrected, trust);
        self.components.clear();
        self.components.extend_from_slice(reports);
    }

    /// Untangles the corrected lattice. Returns whether a cell was inside out.
    #[cold]
    fn untangle_once(&mut self, body: BodyRef<'_>) -> bool {
        let Self { untangling, deformed, corrected, body_limits, components, .. } = self;
        let untangling = Untangling::prepared(untangling, body.get());
        if !untangling.is_inverted(corrected) {
            return false;
        }
        if !untangling.is_present() {
            untangling.set_volumes(components.iter().map(|component| component.before));
            untangling.set_deformed(deformed);
        }
        untangling.first.keep(deformed, corrected, components);
        if untangling.is_inverted(deformed) {
            untangling.untangle(body.surroundings(), &mut body_limits.finder(body), corrected);
        } else {
            untangling.shorten(deformed, corrected);
        }
        true
    }

    /// Returns the memory of the buffers, in bytes.
    pub fn bytes(&self) -> usize {
        let slopes = size_of_val(&*self.slopes) + self.trust.bytes();
        let lattice =
            size_of_val(&*self.deformed) + size_of_val(&*self.corrected) + size_of_val(&*self.xyzx) + slopes;
        let correction = self.correction.bytes() + size_of_val(&*self.external_forces);
        let correction = correction + self.body_limits.bytes();
        let rotations = self.slot_rotations.bytes() + size_of_val(&*self.rotations);
        let untangling = self.untangling.as_ref().map_or(0, |untangling| untangling.bytes());
        lattice + correction + self.matching_workspace.bytes() + rotations + self.skin.bytes() + untangling
    }
}

/// A body evaluated by a [`Display`].
#[derive(Debug)]
pub struct Displayed<'a> {
    display: &'a mut Display,
    body: &'a Body,
    executor: Executor,
}

impl Displayed<'_> {
    /// Returns P~, or P^ without a correction, in cells from the origin of the body.
    fn lattice(&self) -> &[[f32; 3]] {
        let Display { deformed, corrected, .. } = &*self.display;
        if self.body.correction().is_some() { corrected } else { deformed }
    }

    /// Returns the lattice positions after the volume correction, in vertex order, in world space.
    pub fn positions(&self) -> impl ExactSizeIterator<Item = Point3<f64>> {
        let frame = self.body.state.frame;
        self.lattice().iter().map(move |&point| frame.to_world(point.map(f64::from).into()))
    }

    /// Evaluates the mesh and its normals, and returns them in new vectors. They are empty for a bare
    /// lattice.
    pub fn surface(&mut self) -> DisplayedSurface {
        let vertices = self.body.mesh().map_or(0, |mesh| mesh.vertices().len());
        let (mut positions, mut normals) = (vec![[0.0_f64; 3]; vertices], vec![[0.0_f32; 3]; vertices]);
        self.update_mesh(Outputs { positions: Some(&mut positions[..]), normals: Some(&mut normals[..]) });
        DisplayedSurface { positions: positions.into_iter().map(Point3::from).collect(), normals }
    }

    /// Writes the vertex positions of the mesh to `positions` (one row per mesh vertex, `f32` or `f64`), and
    /// the unit normals to `normals` if given. Writes nothing for a bare lattice.
    ///
    /// # Panics
    ///
    /// Panics if the length of a slice is not the number of mesh vertices.
    pub fn surface_into<T: Coordinate>(&mut self, positions: &mut [[T; 3]], normals: Option<&mut [[T; 3]]>) {
        self.update_mesh(Outputs { positions: Some(positions), normals });
    }

    /// Writes the unit normals of the mesh to `normals`, one row per mesh vertex.
    ///
    /// # Panics
    ///
    /// Panics if the length of `normals` is not the number of mesh vertices.
    pub fn normals_into<T: Coordinate>(&mut self, normals: &mut [[T; 3]]) {
        self.update_mesh(Outputs::<T, T> { positions: None, normals: Some(normals) });
    }

    /// Runs the mesh update: writes the mesh, its normals or both to `outputs`.
    fn update_mesh<P: Coordinate, N: Coordinate>(&mut self, outputs: Outputs<'_, P, N>) {
        let start = Instant::now();
        if let Some(Surface { mesh, embedding, skin, .. }) = self.body.surface() {
            let mut lattice = std::mem::take(&mut self.display.xyzx);
            lattice.clear();
            lattice.extend(self.lattice().iter().map(|&point| xyzx(point)));
            let frame = &self.body.state.frame.body_frame();
            let mut slopes = std::mem::take(&mut self.display.slopes);
            if let Some(smoothing) = embedding.smoothing() {
                smoothing.update_slopes(&lattice, &mut slopes);
            }
            let trust = self.display.trust.values();
            let smooth = embedding.smoothing().map(|_| Slopes { slopes: &slopes, trust });
            let correction = self.body.correction();
            let motion =
                correction.and_then(|correction| correction.surface_motion(&self.display.correction));
            let pose = Pose { mesh, embedding, lattice: &lattice, slopes: smooth, motion, frame };
            skin.evaluate(&self.executor, pose, outputs, &mut self.display.skin);
            (self.display.xyzx, self.display.slopes) = (lattice, slopes);
        }
        self.display.times.mesh_update = start.elapsed();
    }

    /// Returns the volumes by all measures, before and after the correction. The first call for a body builds
    /// the measures.
    pub fn volume_report(&self) -> VolumeReport {
        let Body { lattice, measures, .. } = self.body;
        let (surface, correction) = (self.body.surface(), self.body.correction());
        let volume_surface = || surface.map(Surface::volume_surface);
        let measures = measures.get_or_init(|| VolumeMeasures::new(lattice, volume_surface()));
        let Display { deformed: start, corrected, components, untangling, .. } = &*self.display;
        let deformed = untangling.as_ref().and_then(|untangling| untangling.deformed()).unwrap_or(start);
        let ratios = self.body.component_ratios();
        match correction {
            None => measures.report_displayed(deformed, start, ratios),
            Some(correction) => {
                let displayed = (start.as_slice(), corrected.as_slice());
                measures.report_corrected_from(correction, components, deformed, displayed, ratios)
            }
        }
    }

    /// Returns the results of the volume correction, one per component of the lattice; empty if the volume is
    /// not preserved.
    pub fn corrections(&self) -> &[ComponentReport] {
        if self.body.correction().is_some() { &self.display.components } else { &[] }
    }

    /// Returns the report on the untangling of cells that are inside out; empty in a frame without such cells.
    pub fn untangling(&self) -> UntanglingReport {
        self.display
            .untangling
            .as_ref()
            .map_or_else(UntanglingReport::default, |untangling| untangling.report())
    }

    /// Returns the run times of the volume correction and of the last mesh update of this evaluation.
    pub fn times(&self) -> DisplayTimes {
        self.display.times
    }
}

impl Body {
    /// Returns the lattice vertices that pins and handles constrained in the last step.
    pub(super) fn constrained_vertices(&self) -> impl Iterator<Item = u32> + Clone {
        let constrained = self.constraints.as_ref().map_or(&[][..], |constraints| constraints.constrained());
        (0..).zip(constrained).filter(|(_, constrained)| **constrained).map(|(vertex, _)| vertex)
    }

    /// Returns the external forces of Eq. (2): the displacements by contacts and forces since the frame
    /// began, divided by alpha. Because of the division, a displacement has more effect on the correction of
    /// a softer body, which has a smaller alpha.
    fn external_forces(&self, dt: f64) -> impl Iterator<Item = ExternalForce> {
        let scale = (1.0 / self.alpha(dt)) as f32;
        let contacts = self.contacts.iter().flat_map(|contacts| contacts.displacements());
        let forces = self.forces.iter().flat_map(|forces| forces.displacements());
        contacts
            .chain(forces)
            .map(move |(vertex, offset)| ExternalForce { vertex, force: offset.map(|x| x * scale) })
    }
}
