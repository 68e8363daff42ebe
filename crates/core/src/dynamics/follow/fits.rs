//! Rigid fits of lattice vertices to an animated mesh: moving least squares (Schaefer, McPhail & Warren 2006, section
//! 2.3, in three dimensions). A lattice vertex p with the weights w of the mesh vertices m around it moves to
//!
//! ```text
//! R (p - m*) + q*,    m* = Σ w m,    q* = Σ w q,    R = rotation of Σ w (q - q*) (m - m*)ᵀ
//! ```
//!
//! where q are the positions of these mesh vertices in a sample, and Σ w = 1. A rigid motion of the mesh is a rigid
//! motion of the lattice vertices, whatever the weights are.
//!
//! A rigid fit does not stretch with the mesh. A few steps of simultaneous reconstruction (SIRT; Gilbert 1972)
//! therefore move the lattice vertices such that the mesh that they deform is closer to the sample: x += C Bᵀ (q - W
//! x), with the trilinear weights W, whose rows have the sum 1, the weights B = max(W, 0), and the inverse sums C of
//! the columns of B. They change no rigid motion, and a lattice vertex moves by at most a weighted mean of the
//! distances of the mesh vertices in its cells.

use nalgebra::{Isometry3, Matrix3, Point3, Rotation3, UnitQuaternion, Vector3};

use super::neighbors::neighbors;
use crate::dynamics::Selection;
use crate::lattice::{Embedding, Lattice};
use crate::matching::{ROTATIONS, rotations_near};
use crate::mesh::{Csr, Mesh, MeshAnimation, Scale, mix};
use crate::parallel::Executor;

/// Distance in cells within which the weight of a mesh vertex, 1/(d² + r²), hardly depends on its distance d.
const WEIGHT_RADIUS: f64 = 0.25;

/// Weight of the rotation of the whole part in each rotation, relative to Σ w |m - m*|². It alone determines a rotation
/// that the neighbors of a vertex do not, such as that about the line on which they lie. It turns the others by about
/// 1e-4 of the angle between both, and by more where the neighbors are nearly on a line.
const COMMON: f64 = 1e-4;

/// Number of steps of simultaneous reconstruction.
const RECONSTRUCTIONS: usize = 8;

/// Least sum of weights of the mesh vertices at a lattice vertex that moves by their weighted mean. With a smaller sum
/// it moves less: mesh vertices on the other side of its cells hardly determine its position.
const LEAST_SUM: f64 = 0.01;

/// Weight below which a mesh vertex is too far outside its cell for a reconstruction. Rounding, and the choice of the
/// cell near its faces, make weights of -0.002.
const LEAST_WEIGHT: f32 = -0.01;

/// Number of lattice vertices of a task. A multiple of [`ROTATIONS`].
const TASK: usize = 32 * ROTATIONS;

/// The mesh of a body with its lattice, as a handle reads it.
pub(crate) struct BodyMesh<'a> {
    pub(crate) lattice: &'a Lattice,
    /// The mesh in the model's frame.
    pub(crate) mesh: &'a Mesh,
    pub(crate) embedding: &'a Embedding,
    /// Scale of the mesh.
    pub(crate) scale: Scale,
    pub(crate) model_to_world: Isometry3<f64>,
}

/// The fits of the lattice vertices of a handle to the samples of an animation.
#[derive(Debug)]
pub(in crate::dynamics) struct Fits {
    pub(super) animation: MeshAnimation,
    /// The selection of the handle.
    pub(super) selection: Selection,
    scale: Scale,
    /// The transformation from the model's frame to world space.
    pub(super) model_to_world: Isometry3<f64>,
    /// Mesh vertices that the fits use, in increasing order, with their rest positions in the model's frame.
    points: Vec<(u32, Point3<f64>)>,
    /// The neighbors of each lattice vertex of the handle.
    neighbors: Csr<Neighbor>,
    anchors: Vec<Anchor>,
    embedded: Vec<Embedded>,
    /// Inverse sum of the positive weights of the embedded mesh vertices at each lattice vertex, but not above 1 /
    /// [`LEAST_SUM`].
    inverse_weights: Vec<f64>,
    /// Index of the first lattice vertex of each task, and the number of lattice vertices.
    tasks: Vec<usize>,
    /// A hash of the animation, the lattice vertices and their neighbors.
    pub(super) identity: u64,
}

/// A mesh vertex near a lattice vertex.
#[derive(Clone, Copy, Debug)]
struct Neighbor {
    point: u32,
    /// Weight w.
    weight: f32,
    /// w (m - m*).
    moment: [f32; 3],
}

/// The place of a lattice vertex at its neighbors.
#[derive(Clone, Copy, Debug)]
struct Anchor {
    /// p - m*.
    offset: Vector3<f64>,
    /// Factor of the rotation of the whole part.
    common: f64,
}

/// A mesh vertex in a cell whose corners are lattice vertices of the handle.
#[derive(Clone, Copy, Debug)]
struct Embedded {
    point: u32,
    /// Index of each corner among the lattice vertices of the handle.
    corners: [u32; 8],
    weights: [f32; 8],
}

impl Fits {
    /// Creates the fits of the lattice vertices `held` to the mesh vertices `part`. Both are in increasing order and
    /// not empty. The animation has the vertices of the mesh.
    pub(in crate::dynamics) fn new(
        body: &BodyMesh<'_>,
        animation: &MeshAnimation,
        selection: &Selection,
        part: &[u32],
        held: &[u32],
    ) -> Self {
        let near = neighbors(body.lattice, body.mesh, body.embedding, part, held);
        let rest = |point: u32| body.mesh.vertices()[point as usize];
        let cell_size = body.lattice.cell_size();
        let (mut starts, mut items, mut anchors) = (vec![0], Vec::new(), Vec::new());
        for (&vertex, list) in held.iter().zip(near.rows()) {
            let position = body.lattice.rest_position(vertex);
            let squared = |point: u32| ((rest(point) - position) / cell_size).norm_squared();
            let weight = |&point: &u32| 1.0 / (squared(point) + WEIGHT_RADIUS * WEIGHT_RADIUS);
            let total: f64 = list.iter().map(weight).sum();
            let weights: Vec<f32> = list.iter().map(|point| (weight(point) / total) as f32).collect();
            // Differences to the first neighbor keep the digits far from the origin of the model.
            let first = rest(list[0]);
            let weighted = list.iter().zip(&weights);
            let mean: Vector3<f64> = weighted.map(|(&point, &w)| (rest(point) - first) * f64::from(w)).sum();
            let mean = first + mean;
            let mut variance = 0.0;
            for (&point, &weight) in list.iter().zip(&weights) {
                let moment = (rest(point) - mean) * f64::from(weight);
                variance += moment.dot(&(rest(point) - mean));
                items.push(Neighbor { point, weight, moment: moment.map(|x| x as f32).into() });
            }
            starts.push(items.len() as u32);
            anchors.push(Anchor { offset: position - mean, common: COMMON * variance });
        }
        let mut points = near.into_items();
        points.sort_unstable();
        points.dedup();
        let embedded: Vec<Embedded> =
            points.iter().filter_map(|&point| Embedded::new(body.embedding, point, held)).collect();
        let count = anchors.len();
        let mut sums = vec![0.0; count];
        for Embedded { corners, weights, .. } in &embedded {
            corners
                .iter()
                .zip(weights)
                .for_each(|(&corner, w)| sums[corner as usize] += f64::from(w.max(0.0)));
        }
        let indices = items.iter().map(|neighbor: &Neighbor| neighbor.point).chain(held.iter().copied());
        let identity = indices.fold(animation.hash(), |hash, index| mix(hash, index.into()));
        Self {
            animation: animation.clone(),
            selection: selection.clone(),
            scale: body.scale,
            model_to_world: body.model_to_world,
            points: points.into_iter().map(|point| (point, rest(point))).collect(),
            neighbors: Csr::from_parts(starts, items),
            anchors,
            embedded,
            inverse_weights: sums.iter().map(|sum| 1.0 / sum.max(LEAST_SUM)).collect(),
            tasks: (0..count).step_by(TASK).chain([count]).collect(),
            identity,
        }
    }

    /// Returns the number of lattice vertices.
    pub(super) fn len(&self) -> usize {
        self.anchors.len()
    }

    /// Returns the memory in bytes, without the samples of the animation, which handles can share.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.points)
            + self.neighbors.bytes()
            + size_of_val(&*self.tasks)
            + size_of_val(&*self.anchors)
            + size_of_val(&*self.embedded)
            + size_of_val(&*self.inverse_weights)
    }

    /// Computes the positions of the lattice vertices in a sample, in the model's frame. `sums` has as many entries as
    /// `positions`, of any value.
    pub(super) fn fit(
        &self,
        sample: usize,
        (positions, sums): (&mut [Point3<f64>], &mut [Vector3<f64>]),
        executor: &Executor,
    ) {
        let sample = self.animation.sample(sample);
        let common = self.common_rotation(sample);
        executor.tasks(&self.tasks, (&mut *positions, (), &mut [(); 0]), |task, positions, (), _| {
            let first = self.tasks[task];
            for (index, positions) in positions.chunks_mut(ROTATIONS).enumerate() {
                self.fit_some(sample, &common, first + index * ROTATIONS, positions);
            }
        });
        for _ in 0..RECONSTRUCTIONS {
            self.reconstruct(sample, positions, sums);
        }
    }

    /// Makes a step of simultaneous reconstruction.
    fn reconstruct(&self, sample: &[[f32; 3]], positions: &mut [Point3<f64>], sums: &mut [Vector3<f64>]) {
        sums.fill(Vector3::zeros());
        for &Embedded { point, corners, weights } in &self.embedded {
            let q = self.position(sample, point);
            let weighted = || corners.iter().zip(weights).map(|(&corner, w)| (corner as usize, f64::from(w)));
            let rest: Vector3<f64> = weighted().map(|(corner, w)| (q - positions[corner]) * w).sum();
            weighted().for_each(|(corner, w)| sums[corner] += rest * w.max(0.0));
        }
        for ((position, sum), inverse) in positions.iter_mut().zip(sums).zip(&self.inverse_weights) {
            *position += *sum * *inverse;
        }
    }

    /// Computes the positions of up to [`ROTATIONS`] lattice vertices, of which the first has the index `first`.
    fn fit_some(
        &self,
        sample: &[[f32; 3]],
        common: &UnitQuaternion<f64>,
        first: usize,
        positions: &mut [Point3<f64>],
    ) {
        let rotation = common.to_rotation_matrix().into_inner();
        let mut sums = [Matrix3::zeros(); ROTATIONS];
        for (index, (position, sum)) in positions.iter_mut().zip(&mut sums).enumerate() {
            let list = self.neighbors.row(first + index);
            let origin = self.position(sample, list[0].point);
            let mut mean = Vector3::zeros();
            for &Neighbor { point, weight, moment } in list {
                let q = self.position(sample, point) - origin;
                mean += q * f64::from(weight);
                *sum += q * Vector3::from(moment.map(f64::from)).transpose();
            }
            *sum += rotation * self.anchors[first + index].common;
            *position = origin + mean;
        }
        let rotations = rotations_near(&sums[..positions.len()], common);
        for (index, (position, rotation)) in positions.iter_mut().zip(rotations).enumerate() {
            *position += rotation * self.anchors[first + index].offset;
        }
    }

    /// Returns the rotation of the whole part. If it is not unique, it is the smallest one.
    fn common_rotation(&self, sample: &[[f32; 3]]) -> UnitQuaternion<f64> {
        let (first, rest) = self.points[0];
        let origin = self.position(sample, first);
        let offsets =
            || self.points.iter().map(|&(point, m)| (self.position(sample, point) - origin, m - rest));
        let count = self.points.len() as f64;
        let mean: Vector3<f64> = offsets().map(|(_, m)| m / count).sum();
        // Σ (m - mean) is zero, so that the positions q need no mean.
        let sum: Matrix3<f64> = offsets().map(|(q, m)| q * (m - mean).transpose()).sum();
        let [rotation, ..] = rotations_near(&[sum], &UnitQuaternion::identity());
        UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(rotation))
    }

    /// Returns the position of a mesh vertex in a sample, in the model's frame.
    fn position(&self, sample: &[[f32; 3]], point: u32) -> Point3<f64> {
        self.scale.apply(&Point3::from(sample[point as usize].map(f64::from)))
    }

    /// Returns whether a mesh vertex that the fits use moves between two times in samples.
    pub(super) fn moves(&self, phases: [f64; 2]) -> bool {
        let [from, to] = [phases[0].min(phases[1]), phases[0].max(phases[1])];
        let samples = from.floor() as usize..to.ceil() as usize;
        from < to
            && samples.into_iter().any(|sample| {
                let [a, b] = [sample, sample + 1].map(|sample| self.animation.sample(sample));
                self.points.iter().any(|&(point, _)| a[point as usize] != b[point as usize])
            })
    }

    /// Returns the greatest speed of a mesh vertex that the fits use, in scene units per second.
    pub(super) fn greatest_speed(&self) -> f64 {
        let distances = (1..self.animation.samples()).flat_map(|sample| {
            let [a, b] = [sample - 1, sample].map(|sample| self.animation.sample(sample));
            self.points
                .iter()
                .map(move |&(point, _)| (self.position(b, point) - self.position(a, point)).norm())
        });
        distances.fold(0.0, f64::max) / self.animation.interval()
    }

    /// Returns the greatest displacement of a mesh vertex that the fits use from its rest position, along a direction
    /// in world space.
    pub(super) fn greatest_displacement(&self, direction: &Vector3<f64>) -> f64 {
        let direction = self.model_to_world.inverse_transform_vector(direction);
        let along = (0..self.animation.samples()).flat_map(|sample| {
            let sample = self.animation.sample(sample);
            self.points
                .iter()
                .map(move |&(point, rest)| (self.position(sample, point) - rest).dot(&direction))
        });
        along.fold(0.0, f64::max)
    }
}

impl Embedded {
    /// Returns a mesh vertex if all corners of its cell are in `held`, and the vertex is in its cell.
    fn new(embedding: &Embedding, point: u32, held: &[u32]) -> Option<Self> {
        let weights = embedding.weights(point as usize);
        if weights.iter().any(|&w| w < LEAST_WEIGHT) {
            return None;
        }
        let mut indices = [0; 8];
        for (index, corner) in indices.iter_mut().zip(embedding.corners(point as usize)) {
            *index = held.binary_search(&corner).ok()? as u32;
        }
        Some(Self { point, corners: indices, weights })
    }
}
