//! A box of cells under global shape matching (Mueller et al. 2005), as a minimal body for the tests of
//! contacts.

#![allow(dead_code, reason = "not every test uses every item")]

use nalgebra::{Matrix3, Point3, Vector3};
use supple::internals::{
    BodyFrame, BodyState, Colliders, ContactReport, Contacts, Interval, Lanes, SampleCells,
};

/// A body of `size` cells with its samples.
pub(crate) struct Block {
    pub(crate) rest: Vec<Vector3<f64>>,
    pub(crate) corners: Vec<[u32; 8]>,
    pub(crate) slots: Vec<u32>,
    pub(crate) positions: Lanes<3>,
    pub(crate) velocities: Lanes<3>,
    pub(crate) frame: BodyFrame,
    pub(crate) contacts: Contacts,
    pub(crate) samples: Vec<(u32, [f32; 3])>,
    pub(crate) gravity: [f64; 3],
    /// Share of the velocities relative to the body's rigid motion that a step removes.
    pub(crate) damping: f64,
    pub(crate) steps: u64,
}

impl Block {
    /// Creates a body with samples as (cell, position in the cell). `None` means every boundary vertex and
    /// the center of every boundary face.
    pub(crate) fn new(size: [u32; 3], cell_size: f64, samples: Option<Vec<(u32, [f32; 3])>>) -> Self {
        let n = size.map(|s| s + 1);
        let vertex = |i: [u32; 3]| (i[2] * n[1] + i[1]) * n[0] + i[0];
        let grid = |n: [u32; 3]| {
            (0..n[2]).flat_map(move |z| (0..n[1]).flat_map(move |y| (0..n[0]).map(move |x| [x, y, z])))
        };
        let rest: Vec<_> = grid(n).map(|i| Vector3::from(i.map(f64::from))).collect();
        let corners: Vec<[u32; 8]> = grid(size)
            .map(|i| std::array::from_fn(|k| vertex(std::array::from_fn(|a| i[a] + (k as u32 >> a & 1)))))
            .collect();
        let samples = samples.unwrap_or_else(|| surface(grid(size), size));
        // Slots in another order and with gaps, as in a layout in blocks.
        let slots: Vec<u32> = (0..rest.len() as u32).map(|v| 3 + 2 * (rest.len() as u32 - 1 - v)).collect();
        let blocks = (2 * rest.len() + 3).div_ceil(8);
        let (cells, local): (Vec<u32>, Vec<[f32; 3]>) = samples.iter().copied().unzip();
        let contacts = Contacts::new(SampleCells::new(&cells, &local, |c| corners[c as usize], &slots));
        let frame = BodyFrame { origin: Point3::new(10.0, -3.0, 0.7), cell_size };
        let mut block = Self {
            positions: Lanes::zeros(blocks),
            velocities: Lanes::zeros(blocks),
            rest,
            corners,
            slots,
            frame,
            contacts,
            samples,
            gravity: [0.0, -9.81, 0.0],
            damping: 0.1,
            steps: 0,
        };
        block.place(&Matrix3::identity(), Point3::origin());
        block
    }

    /// Sets the positions to the rest shape, transformed by `rotation` about its corner, with that corner at
    /// `corner` in world space.
    pub(crate) fn place(&mut self, rotation: &Matrix3<f64>, corner: Point3<f64>) {
        for (v, rest) in self.rest.iter().enumerate() {
            let world = corner + rotation * rest * self.frame.cell_size;
            self.positions.set(self.slots[v], self.frame.to_local(&world).map(|x| x as f32).into());
        }
    }

    pub(crate) fn set_velocity(&mut self, world: Vector3<f64>) {
        for &slot in &self.slots {
            self.velocities.set(slot, (world / self.frame.cell_size).map(|c| c as f32).into());
        }
    }

    pub(crate) fn state(&mut self) -> (BodyState<'_>, &mut Contacts) {
        let state = BodyState {
            positions: &mut self.positions,
            compensation: None,
            velocities: &mut self.velocities,
            frame: self.frame,
        };
        (state, &mut self.contacts)
    }

    pub(crate) fn position(&self, v: usize) -> Vector3<f64> {
        Vector3::from(self.positions.get(self.slots[v]).map(f64::from))
    }

    pub(crate) fn velocity(&self, v: usize) -> Vector3<f64> {
        Vector3::from(self.velocities.get(self.slots[v]).map(f64::from))
    }

    /// Returns the position of a sample in cells.
    pub(crate) fn sample(&self, index: usize) -> Vector3<f64> {
        self.blend(index, |v| self.position(v))
    }

    pub(crate) fn sample_velocity(&self, index: usize) -> Vector3<f64> {
        self.blend(index, |v| self.velocity(v))
    }

    fn blend(&self, index: usize, of: impl Fn(usize) -> Vector3<f64>) -> Vector3<f64> {
        let (cell, local) = self.samples[index];
        (0..8).fold(Vector3::zeros(), |sum, k| {
            let weight: f64 =
                (0..3).map(|a| f64::from(if k >> a & 1 == 1 { local[a] } else { 1.0 - local[a] })).product();
            sum + of(self.corners[cell as usize][k] as usize) * weight
        })
    }

    /// Returns the world positions of all samples.
    pub(crate) fn surface(&self) -> Vec<Point3<f64>> {
        (0..self.samples.len()).map(|i| self.frame.origin + self.sample(i) * self.frame.cell_size).collect()
    }

    pub(crate) fn center(&self) -> Point3<f64> {
        let sum: Vector3<f64> = (0..self.rest.len()).map(|v| self.position(v)).sum();
        self.frame.origin + sum / self.rest.len() as f64 * self.frame.cell_size
    }

    pub(crate) fn mean_velocity(&self) -> Vector3<f64> {
        let sum: Vector3<f64> = (0..self.rest.len()).map(|v| self.velocity(v)).sum();
        sum / self.rest.len() as f64 * self.frame.cell_size
    }

    /// Resolves contacts without a step of the body.
    pub(crate) fn resolve(&mut self, colliders: &Colliders, step: Interval) -> ContactReport {
        self.contacts.begin(&self.velocities);
        self.finish(colliders, step)
    }

    fn finish(&mut self, colliders: &Colliders, step: Interval) -> ContactReport {
        let gravity = self.gravity;
        let (mut state, contacts) = self.state();
        contacts.resolve(&mut state, colliders, step, gravity)
    }

    /// Runs a step of length `dt` with stiffness `alpha`. At 0 the vertices move independently.
    pub(crate) fn step(&mut self, colliders: &Colliders, dt: f64, alpha: f64) -> ContactReport {
        self.contacts.begin(&self.velocities);
        let goals = if alpha > 0.0 { self.goals() } else { Vec::new() };
        let gravity = Vector3::from(self.gravity) / self.frame.cell_size;
        let before: Vec<_> = (0..self.rest.len()).map(|v| self.position(v)).collect();
        let mut velocities: Vec<_> = (0..self.rest.len()).map(|v| self.velocity(v) + gravity * dt).collect();
        for (v, goal) in goals.iter().enumerate() {
            velocities[v] += (goal - before[v]) * (alpha / dt);
        }
        if alpha > 0.0 {
            damp(&before, &mut velocities, self.damping);
        }
        for (v, velocity) in velocities.iter().enumerate() {
            self.velocities.set(self.slots[v], velocity.map(|c| c as f32).into());
            self.positions.set(self.slots[v], (before[v] + velocity * dt).map(|c| c as f32).into());
        }
        let report = self.finish(colliders, Interval::of_step(self.steps, dt));
        self.steps += 1;
        report
    }

    /// Runs several steps at stiffness 1.
    pub(crate) fn run(&mut self, count: usize, colliders: &Colliders, dt: f64) {
        for _ in 0..count {
            self.step(colliders, dt, 1.0);
        }
    }

    fn goals(&self) -> Vec<Vector3<f64>> {
        let count = self.rest.len() as f64;
        let center = (0..self.rest.len()).map(|v| self.position(v)).sum::<Vector3<f64>>() / count;
        let rest_center = self.rest.iter().sum::<Vector3<f64>>() / count;
        let moment = (0..self.rest.len()).fold(Matrix3::zeros(), |sum, v| {
            sum + (self.position(v) - center) * (self.rest[v] - rest_center).transpose()
        });
        let svd = moment.svd(true, true);
        let (u, v_t) = (svd.u.unwrap(), svd.v_t.unwrap());
        let sign = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, (u * v_t).determinant().signum()));
        let rotation = u * sign * v_t;
        self.rest.iter().map(|rest| center + rotation * (rest - rest_center)).collect()
    }
}

/// Blends velocities with the rigid motion of the same momenta (Mueller et al. 2007, section 3.5).
fn damp(positions: &[Vector3<f64>], velocities: &mut [Vector3<f64>], part: f64) {
    let count = positions.len() as f64;
    let center = positions.iter().sum::<Vector3<f64>>() / count;
    let mean = velocities.iter().sum::<Vector3<f64>>() / count;
    let (mut spin, mut inertia) = (Vector3::zeros(), Matrix3::zeros());
    for (x, v) in positions.iter().zip(velocities.iter()) {
        let r = x - center;
        spin += r.cross(v);
        inertia += Matrix3::identity() * r.norm_squared() - r * r.transpose();
    }
    let Some(inverse) = inertia.try_inverse() else { return };
    let turn = inverse * spin;
    for (x, v) in positions.iter().zip(velocities) {
        *v += (mean + turn.cross(&(x - center)) - *v) * part;
    }
}

/// Returns the boundary vertices and the centers of the boundary faces of a box of cells.
fn surface(cells: impl Iterator<Item = [u32; 3]>, size: [u32; 3]) -> Vec<(u32, [f32; 3])> {
    let mut seen = std::collections::BTreeSet::new();
    let mut samples = Vec::new();
    for (cell, i) in (0u32..).zip(cells) {
        for z in 0..3 {
            for y in 0..3 {
                for x in 0..3 {
                    let half = [x, y, z];
                    let corner = half.iter().all(|h| h % 2 == 0);
                    let face = half.iter().filter(|&&h| h != 1).count() == 1;
                    let on_border =
                        (0..3).any(|a| (half[a] == 0 && i[a] == 0) || (half[a] == 2 && i[a] + 1 == size[a]));
                    let place: [u32; 3] = std::array::from_fn(|a| 2 * i[a] + half[a]);
                    if (corner || face) && on_border && seen.insert(place) {
                        samples.push((cell, half.map(|h| h as f32 / 2.0)));
                    }
                }
            }
        }
    }
    samples
}
