//! Positions of the vertices of a mesh at several times.

use std::sync::Arc;

use nalgebra::Point3;

use super::fault::ColliderFault;

/// Positions of the vertices of a mesh at equal intervals of time. Between two samples the positions are linear in time; before
/// the first and after the last one they are constant. Cloning is cheap: the positions are shared.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshAnimation {
    /// Positions of all vertices, sample by sample.
    positions: Arc<[[f32; 3]]>,
    /// Number of vertices.
    vertices: usize,
    start: f64,
    interval: f64,
}

impl MeshAnimation {
    /// Creates an animation.
    ///
    /// * `positions`: positions of all vertices, sample by sample, in the coordinates of the mesh; shape `(samples * vertices, 3)`.
    /// * `vertices`: number of vertices of the mesh.
    /// * `start`: time of the first sample in seconds.
    /// * `interval`: seconds between samples, > 0.
    ///
    /// # Errors
    /// [`ColliderFault::Animation`] for a number that is not finite or out of range, or if the number of positions is not a
    /// multiple of the number of vertices, at least one sample.
    pub fn new(
        positions: Vec<[f32; 3]>,
        vertices: usize,
        start: f64,
        interval: f64,
    ) -> Result<Self, ColliderFault> {
        let fault = |problem: String| Err(ColliderFault::Animation(problem));
        if positions.is_empty() || vertices == 0 || !positions.len().is_multiple_of(vertices) {
            let positions = positions.len();
            return fault(format!("{positions} positions are not whole samples of {vertices} vertices"));
        }
        if let Some(index) = positions.iter().flatten().position(|x| !x.is_finite()) {
            let (sample, vertex) = (index / 3 / vertices, index / 3 % vertices);
            return fault(format!("sample {sample}: the position of vertex {vertex} is not finite"));
        }
        if !(start.is_finite() && interval.is_finite() && interval > 0.0) {
            return fault(format!(
                "samples from {start} s on, every {interval} s; the interval must be above 0"
            ));
        }
        Ok(Self { positions: positions.into(), vertices, start, interval })
    }

    /// Returns the number of samples.
    pub fn samples(&self) -> usize {
        self.positions.len() / self.vertices
    }

    /// Returns the positions of all vertices, sample by sample.
    pub fn positions(&self) -> &[[f32; 3]] {
        &self.positions
    }

    /// Returns the number of vertices.
    pub fn vertices(&self) -> usize {
        self.vertices
    }

    /// Returns the time of the first sample in seconds.
    pub fn start(&self) -> f64 {
        self.start
    }

    /// Returns the seconds between samples.
    pub fn interval(&self) -> f64 {
        self.interval
    }

    /// Computes the positions of all vertices at a time in seconds, and replaces the contents of `positions`.
    pub fn positions_at_time(&self, time: f64, positions: &mut Vec<Point3<f64>>) {
        self.positions_at(self.phase(time), positions);
    }

    /// Returns the time in samples, between zero and the last one.
    pub(super) fn phase(&self, time: f64) -> f64 {
        ((time - self.start) / self.interval).clamp(0.0, (self.samples() - 1) as f64)
    }

    /// Computes the positions at a time in samples.
    pub(super) fn positions_at(&self, phase: f64, out: &mut Vec<Point3<f64>>) {
        let sample = (phase as usize).min(self.samples() - 1);
        let (next, share) = ((sample + 1).min(self.samples() - 1), phase - sample as f64);
        let at = |sample: usize| self.positions[sample * self.vertices..(sample + 1) * self.vertices].iter();
        let between = |(a, b): (&[f32; 3], &[f32; 3])| {
            Point3::from(std::array::from_fn(|c| {
                let (a, b) = (f64::from(a[c]), f64::from(b[c]));
                a + share * (b - a)
            }))
        };
        out.clear();
        out.extend(at(sample).zip(at(next)).map(between));
    }

    /// Returns the greatest displacement of a vertex from one sample to the next, divided by the interval.
    pub(crate) fn greatest_speed(&self) -> f64 {
        let pairs = self.positions.iter().zip(&self.positions[self.vertices..]);
        let squared = pairs.map(|(a, b)| (0..3).map(|c| f64::from(b[c] - a[c]).powi(2)).sum::<f64>());
        squared.fold(0.0, f64::max).sqrt() / self.interval
    }
}
