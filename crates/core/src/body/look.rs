//! Looking at a body: goals, the corrected lattice, the surface, reports. Nothing here changes what follows.

use std::sync::{Mutex, MutexGuard, PoisonError};

use nalgebra::Point3;

use super::Body;
use super::view::{View, ViewTimes};
use crate::lanes::Lanes;
use crate::matching::cascade::Cascade;
use crate::parallel::Executor;
use crate::volume::{Push, VolumeReport};

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
        self.corrected(|view| view.lattice().collect())
    }

    /// The mesh as it is shown: moved by the lattice after the volume correction.
    pub fn surface(&self) -> ShownSurface {
        self.corrected(|view| {
            view.embed(self);
            view.turn_normals(self);
            ShownSurface { positions: view.surface().collect(), normals: view.normals().to_vec() }
        })
    }

    /// Writes the mesh as it is shown to `positions` (one per mesh vertex) and, where asked for, its unit normals to
    /// `normals`. Allocates nothing after the first time.
    ///
    /// # Panics
    ///
    /// If a slice has another length than the mesh has vertices.
    pub fn surface_into(&self, positions: &mut [[f32; 3]], normals: Option<&mut [[f32; 3]]>) -> ViewTimes {
        self.corrected(|view| {
            view.embed(self);
            assert_eq!(positions.len(), view.surface().len(), "one position per mesh vertex");
            for (position, shown) in positions.iter_mut().zip(view.surface()) {
                *position = shown.coords.map(|x| x as f32).into();
            }
            if let Some(normals) = normals {
                view.turn_normals(self);
                normals.copy_from_slice(view.normals());
            }
            view.times()
        })
    }

    /// The volumes by all measures, and what the correction does to them.
    pub fn volume_report(&self) -> VolumeReport {
        self.corrected(|view| view.report(self))
    }

    /// What `look` makes of the corrected lattice. The view is built at the first look and kept.
    fn corrected<R>(&self, look: impl FnOnce(&mut View) -> R) -> R {
        let mut view = locked(&self.view);
        view.correct(self, &mut locked(&self.cascade), &Executor::sequential());
        look(&mut view)
    }

    /// The lattice vertices that pins and handles hold now.
    pub(super) fn held(&self) -> impl Iterator<Item = u32> {
        let held = self.kinematics.as_ref().map_or(&[][..], |kinematics| kinematics.held());
        (0..).zip(held).filter(|(_, held)| **held).map(|(vertex, _)| vertex)
    }

    /// What contacts did to lattice vertices since the frame began.
    pub(super) fn pushes(&self) -> impl Iterator<Item = Push> {
        self.contacts.iter().flat_map(|contacts| contacts.pushes()).map(|(vertex, push)| {
            let offset = push.map(|v| v * self.push_scale);
            Push { vertex, offset }
        })
    }
}

/// A lock on scratch, which is as good as new whatever happened to those who held it.
pub(super) fn locked<T: ?Sized>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Scratch that nobody else can see.
pub(super) fn unlocked(mutex: &mut Mutex<Cascade>) -> &mut Cascade {
    mutex.get_mut().unwrap_or_else(PoisonError::into_inner)
}
