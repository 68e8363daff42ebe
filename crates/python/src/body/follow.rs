//! The handles of pickles that follow animations.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyTuple};
use supple::{Handle, HandleMotion, MeshAnimation, Selection, TimeWindow};

use super::{Body, SharedBody};
use crate::animation::{array, positions};
use crate::error;
use crate::pickle::{decode, encode};

/// A handle that follows an animation, in a pickle: encoded selection, positions, time of the first sample, and
/// interval.
pub(crate) type Arguments<'py> = (Bound<'py, PyBytes>, Bound<'py, PyAny>, f64, f64);

/// The arrays of a pickle. Handles of the same animation share them.
#[derive(Default)]
pub(crate) struct Arrays<'py>(HashMap<usize, Bound<'py, PyAny>>);

impl<'py> Arrays<'py> {
    /// Returns the handles of a body that follow animations, as tuples of [`Arguments`].
    pub(crate) fn of(&mut self, py: Python<'py>, body: &SharedBody) -> PyResult<Vec<Bound<'py, PyTuple>>> {
        let followed = body.read(py, |body| {
            let followed = body.constraints().filter_map(|constraint| constraint.followed());
            followed.map(|(animation, selection)| (animation.clone(), selection.clone())).collect::<Vec<_>>()
        })?;
        let arguments = followed.iter().map(|(animation, selection)| {
            let positions = match self.0.entry(animation.positions().as_ptr().addr()) {
                Entry::Occupied(entry) => entry.get().clone(),
                Entry::Vacant(entry) => entry.insert(array(py, animation)?).clone(),
            };
            (encode(py, selection)?, positions, animation.start(), animation.interval()).into_pyobject(py)
        });
        arguments.collect()
    }
}

/// The animations of a pickle that were restored, by the addresses of their arrays.
#[derive(Default)]
pub(crate) struct Restored(HashMap<usize, MeshAnimation>);

impl Restored {
    /// Adds the handles of a pickle to a body, so that the body has their animations when its state is restored.
    pub(crate) fn add(&mut self, body: &Bound<'_, Body>, handles: Vec<Arguments<'_>>) -> PyResult<()> {
        let py = body.py();
        for (selection, array, start, interval) in handles {
            let selection: Selection = decode(py, selection.as_bytes())?;
            let animation = match self.0.get(&array.as_ptr().addr()) {
                Some(animation) => animation.clone(),
                None => {
                    let vertices =
                        body.get().read(py, |body| body.mesh().map_or(0, |m| m.vertices().len()))?;
                    let positions = positions(&array, "follow", vertices)?;
                    let animation =
                        MeshAnimation::new(positions, vertices, start, interval).map_err(error::value)?;
                    self.0.insert(array.as_ptr().addr(), animation.clone());
                    animation
                }
            };
            let animation = animation.timed(start, interval).map_err(error::value)?;
            let (motion, window) = (HandleMotion::Follow(animation), TimeWindow::default());
            let handle = Handle { goal: None, selection, motion, window };
            body.get().with(py, |body| body.handle(&handle))?.map_err(error::from_core)?;
        }
        Ok(())
    }
}
