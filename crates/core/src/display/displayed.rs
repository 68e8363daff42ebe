//! The results of an evaluation: the lattice, the mesh and its normals, the volumes.

use nalgebra::Point3;
use web_time::Instant;

use super::buffers::{Display, DisplayTimes};
use super::untangle::UntanglingReport;
use crate::body::{Body, Surface};
use crate::parallel::Executor;
use crate::simd::Coordinate;
use crate::skin::{Outputs, Pose};
use crate::volume::{ComponentReport, VolumeReport};

/// The displayed surface: the mesh after the volume correction, in the vertex order of the input.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct DisplayedSurface {
    /// Positions in world space, one per mesh vertex; empty for a bare lattice.
    pub positions: Vec<Point3<f64>>,
    /// Unit normals, one per mesh vertex; zero if all faces of the vertex are degenerate.
    pub normals: Vec<[f32; 3]>,
}

/// A body evaluated by a [`Display`].
#[derive(Debug)]
pub struct Displayed<'a> {
    pub(super) display: &'a mut Display,
    pub(super) body: &'a Body,
    pub(super) executor: Executor,
}

impl Displayed<'_> {
    /// Returns the lattice positions after the volume correction, in vertex order, in world space.
    pub fn positions(&self) -> impl ExactSizeIterator<Item = Point3<f64>> {
        let frame = self.body.state().frame;
        self.display
            .lattice
            .displayed(self.body)
            .iter()
            .map(move |&point| frame.to_world(point.map(f64::from).into()))
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
            let Display { lattice, correcting, skin: buffers, .. } = &mut *self.display;
            let (lattice, slopes) = lattice.for_mesh(self.body, embedding.smoothing());
            let correction = self.body.correction();
            let motion = correction.and_then(|correction| correction.surface_motion(&correcting.workspace));
            let frame = &self.body.frame();
            let pose = Pose { mesh, embedding, lattice, slopes, motion, frame };
            skin.evaluate(&self.executor, pose, outputs, buffers);
        }
        self.display.times.mesh_update = start.elapsed();
    }

    /// Returns the volumes by all measures, before and after the correction. The first call for a body builds
    /// the measures.
    pub fn volume_report(&self) -> VolumeReport {
        let (measures, correction) = (self.body.measures(), self.body.correction());
        let Display { lattice, correcting, untangling, .. } = &*self.display;
        let (start, corrected) = (&lattice.deformed, &lattice.corrected);
        let deformed = untangling.as_ref().and_then(|untangling| untangling.deformed()).unwrap_or(start);
        let ratios = self.body.component_ratios();
        match correction {
            None => measures.report_displayed(deformed, start, ratios),
            Some(correction) => {
                let displayed = (start.as_slice(), corrected.as_slice());
                measures.report_corrected_from(
                    correction,
                    &correcting.components,
                    deformed,
                    displayed,
                    ratios,
                )
            }
        }
    }

    /// Returns the results of the volume correction, one per component of the lattice; empty if the volume is
    /// not preserved.
    pub fn corrections(&self) -> &[ComponentReport] {
        if self.body.correction().is_some() { &self.display.correcting.components } else { &[] }
    }

    /// Returns the report on the untangling of cells that are inside out; empty in a frame without such cells.
    pub fn untangling(&self) -> UntanglingReport {
        self.display
            .untangling
            .as_ref()
            .map_or_else(UntanglingReport::default, |untangling| untangling.untangler.report())
    }

    /// Returns the run times of the volume correction and of the last mesh update of this evaluation.
    pub fn times(&self) -> DisplayTimes {
        self.display.times
    }
}
