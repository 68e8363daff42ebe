//! Handles that follow an animated mesh.
//!
//! | file | contents |
//! |---|---|
//! | `neighbors` | the mesh vertices that each lattice vertex follows |
//! | `fits` | rigid fits of the lattice vertices to the samples of an animation |
//! | `mod` | [`Follow`]: the target positions during a step |

mod fits;
mod neighbors;

use std::sync::Arc;

use nalgebra::{Point3, Vector3};

pub(crate) use fits::BodyMesh;
pub(super) use fits::Fits;

use super::Selection;
use crate::mesh::MeshAnimation;
use crate::parallel::Executor;
use crate::state::Interval;

/// The motion of a handle that follows an animated mesh. Like the mesh, the target positions are linear in time between
/// two samples.
///
/// A serialized state has only the identity of the fits: [`Follow::resolve`] finds them again.
#[derive(Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Follow {
    identity: u64,
    #[cfg_attr(feature = "serde", serde(skip))]
    fits: Option<Arc<Fits>>,
    #[cfg_attr(feature = "serde", serde(skip))]
    targets: Targets,
}

/// Positions of the lattice vertices in the model's frame. The buffers are filled when they are needed.
#[derive(Debug, Default)]
struct Targets {
    /// Positions in two samples.
    samples: [At<usize>; 2],
    /// Positions at the start and at the end of a step; the times are in samples.
    ends: [At<f64>; 2],
    /// Buffer of the fits.
    sums: Vec<Vector3<f64>>,
}

/// Positions at a time.
#[derive(Debug)]
struct At<T> {
    time: Option<T>,
    positions: Vec<Point3<f64>>,
}

impl<T> Default for At<T> {
    fn default() -> Self {
        Self { time: None, positions: Vec::new() }
    }
}

/// A copy has empty buffers.
impl Clone for Follow {
    fn clone(&self) -> Self {
        Self { identity: self.identity, fits: self.fits.clone(), targets: Targets::default() }
    }
}

impl PartialEq for Follow {
    fn eq(&self, other: &Self) -> bool {
        self.identity == other.identity
    }
}

impl Follow {
    /// Creates the motion of the lattice vertices of the fits.
    pub(super) fn new(fits: Fits) -> Self {
        Self { identity: fits.identity, fits: Some(Arc::new(fits)), targets: Targets::default() }
    }

    /// Returns the animation and the selection that the handle was created with.
    pub(super) fn source(&self) -> Option<(&MeshAnimation, &Selection)> {
        self.fits.as_ref().map(|fits| (&fits.animation, &fits.selection))
    }

    /// Takes the fits of another motion if they fit this one and are missing here.
    pub(super) fn resolve(&mut self, other: &Self) {
        if self.fits.is_none() && self.identity == other.identity {
            self.fits.clone_from(&other.fits);
        }
    }

    /// Returns whether the fits are there, for `count` lattice vertices.
    pub(super) fn is_resolved(&self, count: usize) -> bool {
        self.fits.as_ref().is_some_and(|fits| fits.len() == count)
    }

    /// Returns the memory in bytes, without the samples of the animation.
    pub(super) fn bytes(&self) -> usize {
        let Targets { samples, ends, sums } = &self.targets;
        let buffers = samples.iter().map(|at| &at.positions).chain(ends.iter().map(|at| &at.positions));
        let buffers: usize = buffers.map(|positions| size_of_val(&**positions)).sum();
        buffers + size_of_val(&**sums) + self.fits.as_ref().map_or(0, |fits| fits.bytes())
    }

    /// Returns whether the targets move in a step.
    pub(super) fn moves(&self, step: Interval) -> bool {
        self.fits.as_ref().is_some_and(|fits| fits.moves(phases(fits, step)))
    }

    /// Returns the greatest speed in scene units per second.
    pub(super) fn greatest_speed(&self) -> f64 {
        self.fits.as_ref().map_or(0.0, |fits| fits.greatest_speed())
    }

    /// Returns the greatest displacement from the rest pose along a direction in world space.
    pub(super) fn greatest_displacement(&self, direction: &Vector3<f64>) -> f64 {
        self.fits.as_ref().map_or(0.0, |fits| fits.greatest_displacement(direction))
    }

    /// Computes the targets of a step.
    pub(super) fn begin(&mut self, step: Interval, executor: &Executor) {
        let Self { fits: Some(fits), targets: Targets { samples, ends: [before, after], sums }, .. } = self
        else {
            return;
        };
        let [start, end] = phases(fits, step);
        // A step begins where the step before it ended.
        if before.time != Some(start) {
            std::mem::swap(before, after);
        }
        for (at, phase) in [(before, start), (after, end)] {
            if at.time == Some(phase) {
                continue;
            }
            let (pair, share) = fits.animation.samples_at(phase);
            let [a, b] = place(samples, pair);
            for (slot, sample) in [(a, pair[0]), (b, pair[1])] {
                if samples[slot].time != Some(sample) {
                    let At { time, positions } = &mut samples[slot];
                    positions.resize(fits.len(), Point3::origin());
                    sums.resize(fits.len(), Vector3::zeros());
                    fits.fit(sample, (positions, sums), executor);
                    *time = Some(sample);
                }
            }
            let [a, b] = [a, b].map(|slot| &samples[slot].positions);
            at.positions.clear();
            at.positions.extend(a.iter().zip(b).map(|(a, b)| a + (b - a) * share));
            at.time = Some(phase);
        }
    }

    /// Returns the target position of each lattice vertex at the end of the step that began last, in world space, and
    /// its change during the step.
    pub(super) fn targets(&self) -> impl Iterator<Item = (Point3<f64>, Vector3<f64>)> {
        let [before, after] = &self.targets.ends;
        self.fits.iter().flat_map(move |fits| {
            let to_world = fits.model_to_world;
            let pairs = before.positions.iter().zip(&after.positions);
            // Differences in the model's frame keep the digits of small steps far from the origin of world space.
            pairs.map(move |(before, after)| (to_world * after, to_world * (after - before)))
        })
    }
}

/// Returns the times of the start and the end of a step in samples.
fn phases(fits: &Fits, step: Interval) -> [f64; 2] {
    [step.start, step.end].map(|time| fits.animation.phase(time))
}

/// Returns which of two buffers are for a pair of samples: those that have them, as far as possible.
fn place(samples: &[At<usize>; 2], [first, second]: [usize; 2]) -> [usize; 2] {
    let holds = |slot: usize, sample| samples[slot].time == Some(sample);
    let slot = usize::from(holds(1, first) || holds(0, second) && !holds(0, first));
    [slot, if first == second { slot } else { 1 - slot }]
}
