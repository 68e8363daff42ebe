//! Splits the motion of a surface into that of a rigid node and components of its deformation.
//!
//! ```text
//! x_f = R_f y_f + c_f         c_f: mean position; R_f: best rotation of frame 0 onto frame f (Kabsch 1976)
//! d_f = y_f - y_0             deformation of frame f, three numbers per vertex
//! X_fs = d_f . d_s            s: frames of the basis, all or MAX_BASIS of them, or more if these keep no error
//! X_ss A = A L                principal components (Sirovich 1987, method of snapshots): sum over s of A_sk d_s
//! d_f ~ sum over k of W_fk sum over s of A_sk d_s,   W = X A / L
//! ```
//!
//! The number of components is the smallest with which no vertex of any frame is further from its place than asked. Sums
//! are in a fixed order, over blocks of vertices, so that a part of the frames is in memory.

use std::io;
use std::ops::Range;

use nalgebra::{DMatrix, DVector, Matrix3, Rotation3, SymmetricEigen, UnitQuaternion, Vector3};

/// Largest number of frames of which components are combined, if their combinations keep the error.
const MAX_BASIS: usize = 384;

/// Largest number of vertices whose deformation determines the components; the others only count in the error.
const MAX_POINTS: usize = 1 << 14;

/// Number of points, of all frames, in a block.
const BLOCK: usize = 1 << 20;

/// Number of components of points that are computed before it is known whether they are needed.
const MORE: usize = 16;

/// Eigenvalue, relative to the largest one, below which rounding hides a component.
const NOISE: f64 = 1e-12;

/// Positions and normals of points in all frames.
pub(crate) trait Samples {
    /// Returns the number of frames.
    fn frames(&self) -> usize;

    /// Reads the vectors of a range of points in a frame.
    fn read(&mut self, frame: usize, points: Range<usize>, out: &mut Vec<[f32; 3]>) -> io::Result<()>;

    /// Returns whether a file shows a point in a frame.
    fn is_shown(&self, _frame: usize, _point: usize) -> bool {
        true
    }
}

/// The vectors of points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Vectors {
    Positions,
    Normals,
}

/// The motion of a node.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pose {
    pub(super) rotation: UnitQuaternion<f64>,
    pub(super) translation: Vector3<f64>,
    /// Whether the node is shown.
    pub(super) is_shown: bool,
}

/// The motion of a surface.
pub(super) struct Motion {
    /// The points of the surface among the samples: positions; as many normals follow.
    points: Range<usize>,
    /// The pose of each frame.
    pub(super) poses: Vec<Pose>,
    /// The frames of which components are combined.
    basis: Vec<usize>,
    /// The components, each a combination of these frames, one per column.
    combinations: DMatrix<f32>,
    /// The weights of the components in each frame, one component per column, each in [0, 1].
    pub(super) weights: DMatrix<f32>,
    /// Largest distance of a vertex of a frame from its place.
    pub(super) error: f64,
    /// Largest extent of the surface in frame 0 along an axis.
    pub(super) size: f64,
}

impl Motion {
    /// Splits the motion of `points`, the positions of a surface. `tolerance`: largest error, relative to its size.
    pub(super) fn new(samples: &mut dyn Samples, points: Range<usize>, tolerance: f64) -> io::Result<Self> {
        let (poses, size) = poses(samples, points.clone())?;
        let frames = poses.len();
        let (combinations, weights) = (DMatrix::zeros(0, 0), DMatrix::zeros(frames, 0));
        let basis = Vec::new();
        let mut motion = Self { points, poses, basis, combinations, weights, error: f64::INFINITY, size };
        // With all frames in the basis, the components are exact.
        let mut count = if tolerance > 0.0 { frames.min(MAX_BASIS) } else { frames };
        while motion.error > tolerance * size {
            motion.basis = (0..count).map(|k| k * (frames - 1) / (count - 1).max(1)).collect();
            motion.find_components(samples, tolerance * size)?;
            count = frames.min(2 * count);
        }
        Ok(motion)
    }

    /// Returns the number of components.
    pub(super) fn components(&self) -> usize {
        self.weights.ncols()
    }

    /// Returns the ranges of points of blocks, counted from the first point of the surface.
    pub(super) fn blocks(&self) -> impl Iterator<Item = Range<usize>> + use<> {
        let (count, block) = (self.points.len(), (BLOCK / self.poses.len()).max(64));
        (0..count).step_by(block).map(move |start| start..count.min(start + block))
    }

    /// Returns the vectors of frame 0 of a block.
    pub(super) fn base(
        &self,
        samples: &mut dyn Samples,
        block: Range<usize>,
        vectors: Vectors,
    ) -> io::Result<Vec<[f32; 3]>> {
        let mut base = Vec::new();
        samples.read(0, self.placed(block, vectors), &mut base)?;
        let center = self.center(0, vectors);
        for vector in &mut base {
            *vector = (Vector3::from(vector.map(f64::from)) - center).cast::<f32>().into();
        }
        Ok(base)
    }

    /// Returns the displacements of a block in each component: one component per column, with the numbers of the points
    /// one after another.
    pub(super) fn displacements(
        &self,
        samples: &mut dyn Samples,
        block: Range<usize>,
        vectors: Vectors,
    ) -> io::Result<DMatrix<f32>> {
        Ok(self.combined(&self.deformed(samples, block, vectors)?, self.components()))
    }

    /// Returns the first components of the deformation of points.
    fn combined(&self, deformed: &DMatrix<f32>, components: usize) -> DMatrix<f32> {
        let combinations = self.combinations.columns(0, components);
        if self.basis.len() == self.poses.len() {
            return deformed * combinations;
        }
        deformed.select_columns(&self.basis) * combinations
    }

    /// Returns the points of a block among the samples.
    fn placed(&self, block: Range<usize>, vectors: Vectors) -> Range<usize> {
        let first = match vectors {
            Vectors::Positions => self.points.start,
            Vectors::Normals => self.points.end,
        };
        first + block.start..first + block.end
    }

    /// Returns the origin of vectors in a frame.
    fn center(&self, frame: usize, vectors: Vectors) -> Vector3<f64> {
        match vectors {
            Vectors::Positions => self.poses[frame].translation,
            Vectors::Normals => Vector3::zeros(),
        }
    }

    /// Returns the deformation of a block: the differences of all frames from frame 0, one frame per column, with the
    /// numbers of the points one after another.
    fn deformed(
        &self,
        samples: &mut dyn Samples,
        block: Range<usize>,
        vectors: Vectors,
    ) -> io::Result<DMatrix<f32>> {
        let base = self.base(samples, block.clone(), vectors)?;
        let mut deformed = DMatrix::zeros(3 * base.len(), self.poses.len());
        let mut now = Vec::new();
        for (mut column, (frame, pose)) in deformed.column_iter_mut().zip(self.poses.iter().enumerate()) {
            samples.read(frame, self.placed(block.clone(), vectors), &mut now)?;
            let (back, center) = (pose.rotation.inverse().to_rotation_matrix(), self.center(frame, vectors));
            let numbers = column.as_mut_slice().as_chunks_mut::<3>().0;
            for (number, (now, base)) in numbers.iter_mut().zip(now.iter().zip(&base)) {
                let local = back * (Vector3::from(now.map(f64::from)) - center);
                *number = std::array::from_fn(|axis| (local[axis] - f64::from(base[axis])) as f32);
            }
        }
        Ok(deformed)
    }

    /// Finds as many components as keep all vertices within `tolerance` of their places, a length.
    fn find_components(&mut self, samples: &mut dyn Samples, tolerance: f64) -> io::Result<()> {
        let (frames, count) = (self.poses.len(), self.basis.len());
        let stride = self.points.len().div_ceil(MAX_POINTS);
        let mut products = DMatrix::<f64>::zeros(frames, count);
        let mut numbers = 0;
        for block in self.blocks() {
            let length = block.len();
            let deformed = self.deformed(samples, block, Vectors::Positions)?;
            let some: Vec<usize> = (0..length).step_by(stride).flat_map(|k| 3 * k..3 * k + 3).collect();
            let deformed = deformed.select_rows(&some).cast::<f64>();
            products += deformed.tr_mul(&deformed.select_columns(&self.basis));
            numbers += some.len();
        }
        let of_basis = products.select_rows(&self.basis);
        let eigen = SymmetricEigen::new((&of_basis + of_basis.transpose()) * 0.5);
        let mut order: Vec<usize> = (0..count).collect();
        order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]).then(a.cmp(&b)));
        let largest = eigen.eigenvalues[order[0]];
        order.retain(|&k| eigen.eigenvalues[k] > NOISE * largest);
        let combinations = eigen.eigenvectors.select_columns(&order);
        let mut weights = products * &combinations;
        for (mut column, &k) in weights.column_iter_mut().zip(&order) {
            column /= eigen.eigenvalues[k];
        }
        self.set_components(combinations, weights);
        // The mean square of the distances that components leave is at most the square of the largest distance.
        let least = tolerance.powi(2) * (numbers / 3 * count) as f64;
        let mut left: f64 = order.iter().map(|&k| eigen.eigenvalues[k]).sum();
        let mut at_least = 0;
        while at_least < order.len() && left > least {
            left -= eigen.eigenvalues[order[at_least]];
            at_least += 1;
        }
        let needed = self.needed_components(samples, at_least, tolerance)?;
        let targets = needed + usize::from(needed > 0);
        if count == frames && (targets + 1 >= frames || self.error > tolerance) {
            // A component per frame is exact.
            let each = DMatrix::from_fn(frames, frames - 1, |row, k| f64::from(u8::from(row == k + 1)));
            self.set_components(each.clone(), each);
            self.error = 0.0;
        } else {
            self.combinations = self.combinations.columns(0, needed).into_owned();
            self.weights = self.weights.columns(0, needed).into_owned();
            self.make_weights_positive();
        }
        Ok(())
    }

    /// Gives all weights a range from 0 to 1, to which some programs limit them. A component more, whose weight is always
    /// 1, has the sum of the smallest weights: w c = (w - low) c + low c.
    fn make_weights_positive(&mut self) {
        let lowest: Vec<f32> = self.weights.column_iter().map(|weights| weights.min().min(0.0)).collect();
        if lowest.iter().all(|&low| low == 0.0) {
            return;
        }
        let components = self.components();
        let sum = &self.combinations * DVector::from_vec(lowest.clone());
        for (k, low) in lowest.into_iter().enumerate() {
            let range = self.weights.column(k).max() - low;
            self.weights.column_mut(k).apply(|weight| *weight = (*weight - low) / range);
            self.combinations.column_mut(k).scale_mut(range);
        }
        self.combinations = std::mem::take(&mut self.combinations).insert_column(components, 0.0);
        self.combinations.set_column(components, &sum);
        self.weights = std::mem::take(&mut self.weights).insert_column(components, 1.0);
    }

    /// Sets the components. Scales them, so that the largest weight of each is 1.
    fn set_components(&mut self, mut combinations: DMatrix<f64>, mut weights: DMatrix<f64>) {
        for (mut combination, mut weights) in combinations.column_iter_mut().zip(weights.column_iter_mut()) {
            let scale = weights.amax();
            combination *= scale;
            weights /= scale;
        }
        (self.combinations, self.weights) = (combinations.cast(), weights.cast());
    }

    /// Returns the number of components, `at_least` or more, that keep all vertices within `tolerance`, a length; all of
    /// them if they do not. Sets the error with this number.
    fn needed_components(
        &mut self,
        samples: &mut dyn Samples,
        at_least: usize,
        tolerance: f64,
    ) -> io::Result<usize> {
        let mut needed = at_least;
        // A component that a later vertex needs can move an earlier one from its place.
        loop {
            let before = needed;
            let mut error = 0.0_f32;
            for block in self.blocks() {
                let deformed = self.deformed(samples, block, Vectors::Positions)?;
                let (number, distance) = self.needed_by(&deformed, needed, tolerance as f32);
                needed = number;
                error = error.max(distance);
            }
            if needed == before {
                self.error = f64::from(error);
                return Ok(needed);
            }
        }
    }

    /// Returns the number of components, at least `at_least`, that keep the points of a block within `tolerance`, and their
    /// largest distance from their places with them.
    fn needed_by(&self, deformed: &DMatrix<f32>, at_least: usize, tolerance: f32) -> (usize, f32) {
        let mut combined = self.combined(deformed, self.components().min(at_least + MORE));
        let mut rest = deformed.clone();
        let of_first = self.weights.columns(0, at_least).transpose();
        rest.gemm(-1.0, &combined.columns(0, at_least), &of_first, 1.0);
        let mut needed = at_least;
        loop {
            let points = rest.as_slice().as_chunks::<3>().0.iter();
            let distance = points.map(|[x, y, z]| x * x + y * y + z * z).fold(0.0, f32::max).sqrt();
            if distance <= tolerance || needed == self.components() {
                return (needed, distance);
            }
            if needed == combined.ncols() {
                combined = self.combined(deformed, self.components().min(2 * needed + MORE));
            }
            let weights = self.weights.column(needed);
            rest.ger(-1.0, &combined.column(needed), &weights, 1.0);
            needed += 1;
        }
    }
}

/// Returns the pose of points in each frame, and their largest extent in frame 0.
fn poses(samples: &mut dyn Samples, points: Range<usize>) -> io::Result<(Vec<Pose>, f64)> {
    let (mut first, mut now) = (Vec::new(), Vec::new());
    samples.read(0, points.clone(), &mut first)?;
    let wide = |point: &[f32; 3]| Vector3::from(point.map(f64::from));
    let mean =
        |points: &[[f32; 3]]| points.iter().map(wide).sum::<Vector3<f64>>() / points.len().max(1) as f64;
    let (low, high) =
        first.iter().map(wide).fold(
            (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY)),
            |(low, high), point| (low.inf(&point), high.sup(&point)),
        );
    let size = (high - low).max().max(0.0);
    let center = mean(&first);
    let is_shown = |samples: &dyn Samples, frame| samples.is_shown(frame, points.start);
    let rotation = UnitQuaternion::identity();
    let mut poses = vec![Pose { rotation, translation: center, is_shown: is_shown(samples, 0) }];
    for frame in 1..samples.frames() {
        samples.read(frame, points.clone(), &mut now)?;
        let translation = mean(&now);
        let products = now
            .iter()
            .zip(&first)
            .map(|(now, first)| (wide(now) - translation) * (wide(first) - center).transpose());
        let before = poses[frame - 1].rotation;
        let rotation = best_rotation(&products.sum::<Matrix3<f64>>()).unwrap_or(before);
        let rotation = near(rotation, before);
        poses.push(Pose { rotation, translation, is_shown: is_shown(samples, frame) });
    }
    Ok((poses, size))
}

/// Returns the one of the two quaternions of a rotation to which viewers interpolate on the short way from `before`.
pub(super) fn near(rotation: UnitQuaternion<f64>, before: UnitQuaternion<f64>) -> UnitQuaternion<f64> {
    let is_far = rotation.coords.dot(&before.coords) < 0.0;
    if is_far { UnitQuaternion::new_unchecked(-rotation.into_inner()) } else { rotation }
}

/// Returns the rotation nearest to a matrix; `None` if rotations about an axis are equally near.
fn best_rotation(products: &Matrix3<f64>) -> Option<UnitQuaternion<f64>> {
    let svd = products.svd(true, true);
    let (u, v_t) = (svd.u?, svd.v_t?);
    let [largest, second, smallest] = svd.singular_values.into();
    let sign = (u * v_t).determinant().signum();
    if second + sign * smallest <= 1e-9 * largest {
        return None;
    }
    let rotation = u * Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, sign)) * v_t;
    Some(UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(rotation)))
}
