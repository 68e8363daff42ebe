//! Looking at a body: goals, the corrected lattice, the surface, reports. Nothing here changes what follows.

use std::sync::{Mutex, MutexGuard, PoisonError};

use nalgebra::Point3;

use super::Body;
use super::view::{View, ViewTimes};
use crate::parallel::Executor;
use crate::simd::Coordinate;
use crate::simd::lanes::Lanes;
use crate::skin::Asked;
use crate::volume::{Push, VolumeOptions, VolumeReport};

/// A body's mesh as it is shown: after the volume correction, in the order of the input.
#[derive(Clone, Debug, PartialEq)]
pub struct ShownSurface {
    /// One per mesh vertex, in the world; empty for a bare lattice.
    pub positions: Vec<Point3<f64>>,
    /// Unit normals, one per mesh vertex; zero where no face has area.
    pub normals: Vec<[f32; 3]>,
}

impl Body {
    /// The goal positions of the current positions, shape `(n, 3)`. No time passes.
    pub fn goals(&self) -> Vec<Point3<f64>> {
        let mut rotations = self.state.rotations.clone();
        let mut goals = Lanes::zeros(self.matching.layout.blocks());
        let (cascade, executor) = (&mut *locked(&self.cascade), Executor::sequential());
        self.matching.fit(cascade, &executor, &self.state.positions, &mut rotations);
        self.matching.goals(cascade, &executor, &mut goals);
        self.by_vertex(|slot| self.state.frame.to_world(goals.get(slot).map(f64::from).into()))
    }

    /// The lattice after the volume correction, shape `(n, 3)`; without one the same as the positions.
    pub fn corrected_positions(&self) -> Vec<Point3<f64>> {
        self.corrected(|view, _| view.lattice().collect())
    }

    /// The mesh as it is shown: moved by the lattice after the volume correction.
    pub fn surface(&self) -> ShownSurface {
        let vertices = self.mesh().map_or(0, |mesh| mesh.vertices().len());
        let (mut positions, mut normals) = (vec![[0.0_f64; 3]; vertices], vec![[0.0_f32; 3]; vertices]);
        let asked = Asked { positions: Some(&mut positions[..]), normals: Some(&mut normals[..]) };
        self.corrected(|view, executor| view.show(self, executor, asked));
        ShownSurface { positions: positions.into_iter().map(Point3::from).collect(), normals }
    }

    /// Writes the mesh as it is shown to `positions` (one per mesh vertex, `f32` or `f64`) and, where asked for, its
    /// unit normals to `normals`. Allocates nothing after the first time.
    ///
    /// # Panics
    ///
    /// If a slice has another length than the mesh has vertices.
    pub fn surface_into<T: Coordinate>(
        &self,
        positions: &mut [[T; 3]],
        normals: Option<&mut [[T; 3]]>,
    ) -> ViewTimes {
        self.corrected(|view, executor| {
            view.show(self, executor, Asked { positions: Some(positions), normals });
            view.times()
        })
    }

    /// Writes the unit normals of the mesh as it is shown, one per mesh vertex. Allocates nothing after the first time.
    ///
    /// # Panics
    ///
    /// If there is another number of normals than of mesh vertices.
    pub fn normals_into<T: Coordinate>(&self, normals: &mut [[T; 3]]) {
        let asked = Asked::<T, T> { positions: None, normals: Some(normals) };
        self.corrected(|view, executor| view.show(self, executor, asked));
    }

    /// Whether and how the volume is kept, as asked for.
    pub fn volume(&self) -> VolumeOptions {
        locked(&self.view).options()
    }

    /// The volumes by all measures, and what the correction does to them.
    pub fn volume_report(&self) -> VolumeReport {
        self.corrected(|view, _| view.report(self))
    }

    /// What `look` makes of the corrected lattice, on the threads of the simulation where that pays.
    fn corrected<R>(&self, look: impl FnOnce(&mut View, &Executor) -> R) -> R {
        let (mut view, mut cascade) = (locked(&self.view), locked(&self.cascade));
        view.correct(self, &mut cascade);
        look(&mut view, &self.surroundings.executor)
    }

    /// The lattice vertices that pins and handles hold now.
    pub(super) fn held(&self) -> impl Iterator<Item = u32> + Clone {
        let held = self.kinematics.as_ref().map_or(&[][..], |kinematics| kinematics.held());
        (0..).zip(held).filter(|(_, held)| **held).map(|(vertex, _)| vertex)
    }

    /// What contacts and forces did to lattice vertices since the frame began: the more, the less stiff the body is.
    pub(super) fn pushes(&self) -> impl Iterator<Item = Push> {
        let scale = (1.0 / self.material.alpha(self.surroundings.dt)) as f32;
        let contacts = self.contacts.iter().flat_map(|contacts| contacts.pushes());
        contacts
            .chain(self.forced())
            .map(move |(vertex, push)| Push { vertex, offset: push.map(|v| v * scale) })
    }
}

/// A lock on scratch, which is as good as new whatever happened to those who held it.
pub(super) fn locked<T: ?Sized>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Scratch that nobody else can see.
pub(super) fn unlocked<T>(mutex: &mut Mutex<T>) -> &mut T {
    mutex.get_mut().unwrap_or_else(PoisonError::into_inner)
}
