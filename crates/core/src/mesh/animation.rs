//! Positions of the vertices of a mesh at several times.

use std::sync::{Arc, OnceLock};

use nalgebra::{Point3, Vector3};
use thiserror::Error;

use super::{RefinedMesh, Scale};

/// Positions of the vertices of a mesh at equal intervals of time. Between two samples the positions are linear in
/// time; before the first and after the last one they are constant. Cloning is cheap: the positions are shared.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshAnimation {
    samples: Arc<Samples>,
    /// Number of vertices.
    vertices: usize,
    start: f64,
    interval: f64,
}

/// Positions of all vertices, sample by sample.
#[derive(Debug)]
struct Samples {
    positions: Box<[[f32; 3]]>,
    /// Greatest magnitude of a coordinate.
    greatest: f32,
    hash: OnceLock<u64>,
}

impl PartialEq for Samples {
    fn eq(&self, other: &Self) -> bool {
        self.positions == other.positions
    }
}

/// An invalid animation of a mesh.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum AnimationError {
    /// The number of positions is not a multiple of the number of vertices, or zero.
    #[error("{positions} positions are not whole samples of {vertices} vertices")]
    Samples {
        /// Number of positions.
        positions: usize,
        /// Number of vertices of a sample.
        vertices: usize,
    },
    /// A coordinate is NaN or infinite.
    #[error("sample {sample}: the position of vertex {vertex} is not finite")]
    NotFinite {
        /// Index of the sample, from 0.
        sample: usize,
        /// Index of the vertex, from 0.
        vertex: usize,
    },
    /// The time of the first sample is not finite, or the interval is not a finite number above 0.
    #[error("samples from {start} s on, every {interval} s; the interval must be above 0")]
    Times {
        /// Time of the first sample in seconds.
        start: f64,
        /// Seconds between samples.
        interval: f64,
    },
    /// The mesh has another number of vertices.
    #[error(
        "it has {found} vertices, and the mesh has {vertices}; export the animation with the vertices of the mesh, in \
         the same order"
    )]
    Vertices {
        /// Number of vertices of the animation.
        found: usize,
        /// Number of vertices of the mesh.
        vertices: usize,
    },
}

impl MeshAnimation {
    /// Creates an animation.
    ///
    /// * `positions`: positions of all vertices, sample by sample, in the coordinates of the mesh; shape
    ///   `(samples * vertices, 3)`.
    /// * `vertices`: number of vertices of the mesh.
    /// * `start`: time of the first sample in seconds.
    /// * `interval`: seconds between samples, > 0.
    ///
    /// # Errors
    /// A number that is not finite or out of range, or a number of positions that is not a multiple of the number of
    /// vertices, at least one sample.
    pub fn new(
        positions: Vec<[f32; 3]>,
        vertices: usize,
        start: f64,
        interval: f64,
    ) -> Result<Self, AnimationError> {
        if positions.is_empty() || vertices == 0 || !positions.len().is_multiple_of(vertices) {
            return Err(AnimationError::Samples { positions: positions.len(), vertices });
        }
        if let Some(index) = positions.iter().flatten().position(|x| !x.is_finite()) {
            let (sample, vertex) = (index / 3 / vertices, index / 3 % vertices);
            return Err(AnimationError::NotFinite { sample, vertex });
        }
        let greatest = positions.iter().flatten().fold(0.0, |greatest: f32, x| greatest.max(x.abs()));
        let samples = Arc::new(Samples { positions: positions.into(), greatest, hash: OnceLock::new() });
        Self { samples, vertices, start: 0.0, interval: 1.0 }.timed(start, interval)
    }

    /// Returns the animation at other times. The positions are shared.
    ///
    /// * `start`: time of the first sample in seconds.
    /// * `interval`: seconds between samples, > 0.
    ///
    /// # Errors
    /// A number that is not finite or out of range.
    pub fn timed(self, start: f64, interval: f64) -> Result<Self, AnimationError> {
        if !(start.is_finite() && interval.is_finite() && interval > 0.0) {
            return Err(AnimationError::Times { start, interval });
        }
        Ok(Self { start, interval, ..self })
    }

    /// Returns the animation of the mesh that is scaled about its origin.
    ///
    /// # Errors
    /// A position that leaves the range of `f32`.
    pub(crate) fn scaled(&self, scale: Scale) -> Result<Self, AnimationError> {
        let position = |p: &[f32; 3]| scale.apply(&Point3::from(p.map(f64::from))).map(|x| x as f32).into();
        let positions = self.positions().iter().map(position).collect();
        Self::new(positions, self.vertices, self.start, self.interval)
    }

    /// Returns the animation of the refined mesh: new vertices are where they lie on the given ones.
    ///
    /// # Errors
    /// A position that leaves the range of `f32`.
    pub fn refined(&self, refined: &RefinedMesh) -> Result<Self, AnimationError> {
        let vertices = self.vertices + refined.points.len();
        let mut positions = Vec::with_capacity(self.samples() * vertices);
        for sample in self.positions().chunks_exact(self.vertices) {
            positions.extend_from_slice(sample);
            positions.extend(refined.points.iter().map(|(corners, weights)| {
                let corner =
                    |k: usize| Vector3::from(sample[corners[k] as usize].map(f64::from)) * weights[k];
                <[f64; 3]>::from(corner(0) + corner(1) + corner(2)).map(|x| x as f32)
            }));
        }
        Self::new(positions, vertices, self.start, self.interval)
    }

    /// Checks that a mesh has as many vertices as the animation.
    pub(crate) fn check_vertices(&self, vertices: usize) -> Result<(), AnimationError> {
        let found = self.vertices;
        if found == vertices { Ok(()) } else { Err(AnimationError::Vertices { found, vertices }) }
    }

    /// Returns the greatest magnitude of a coordinate.
    pub(crate) fn greatest_coordinate(&self) -> f64 {
        self.samples.greatest.into()
    }

    /// Returns the number of samples.
    pub fn samples(&self) -> usize {
        self.positions().len() / self.vertices
    }

    /// Returns the positions of all vertices, sample by sample.
    pub fn positions(&self) -> &[[f32; 3]] {
        &self.samples.positions
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
    pub(crate) fn phase(&self, time: f64) -> f64 {
        ((time - self.start) / self.interval).clamp(0.0, (self.samples() - 1) as f64)
    }

    /// Computes the positions at a time in samples.
    pub(crate) fn positions_at(&self, phase: f64, out: &mut Vec<Point3<f64>>) {
        let (samples, share) = self.samples_at(phase);
        let between = |(a, b): (&[f32; 3], &[f32; 3])| {
            Point3::from(std::array::from_fn(|c| {
                let (a, b) = (f64::from(a[c]), f64::from(b[c]));
                a + share * (b - a)
            }))
        };
        out.clear();
        let [before, after] = samples.map(|sample| self.sample(sample));
        out.extend(before.iter().zip(after).map(between));
    }

    /// Returns the samples before and after a time in samples, and the share of the second one.
    pub(crate) fn samples_at(&self, phase: f64) -> ([usize; 2], f64) {
        let last = self.samples() - 1;
        let sample = (phase as usize).min(last);
        ([sample, (sample + 1).min(last)], phase - sample as f64)
    }

    /// Returns the positions of all vertices in a sample.
    pub(crate) fn sample(&self, sample: usize) -> &[[f32; 3]] {
        &self.positions()[sample * self.vertices..(sample + 1) * self.vertices]
    }

    /// Returns a hash of the positions and the times. It is computed at the first call.
    pub(crate) fn hash(&self) -> u64 {
        let positions = || self.positions().iter().flatten().fold(0, |hash, x| mix(hash, x.to_bits().into()));
        let positions = *self.samples.hash.get_or_init(positions);
        [self.vertices as u64, self.start.to_bits(), self.interval.to_bits()].into_iter().fold(positions, mix)
    }

    /// Returns the greatest displacement of a vertex from one sample to the next, divided by the interval.
    pub(crate) fn greatest_speed(&self) -> f64 {
        let pairs = self.positions().iter().zip(&self.positions()[self.vertices..]);
        let squared = pairs.map(|(a, b)| (0..3).map(|c| f64::from(b[c] - a[c]).powi(2)).sum::<f64>());
        squared.fold(0.0, f64::max).sqrt() / self.interval
    }
}

/// Adds a word to a hash: FNV-1a with words in place of bytes, and with a rotation, because a product carries no bit
/// downwards.
pub(crate) fn mix(hash: u64, word: u64) -> u64 {
    ((hash ^ word).wrapping_mul(0x0000_0100_0000_01b3)).rotate_left(23)
}
