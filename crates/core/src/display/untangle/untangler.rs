//! Moves vertices until the determinants of all cells are positive.
//!
//! Sweeps over the corners of the cells that are not yet untangled move one vertex at a time, to the minimum of
//!
//! ```text
//! sum over the determinants J that depend on the vertex of  max(0, TARGET - J)²  +  PROXIMITY |d|²
//! ```
//!
//! with the displacement `d` of the vertex in this sweep. Each `J` is linear in `d`, so that the sum is convex. Where
//! the number of these cells does not halve in [`SWEEPS`] sweeps, the part of the lattice around them is relaxed, and
//! the sweeps go on. The order of the vertices is fixed, and one thread does all.

use nalgebra::{Matrix3, Vector3};

use super::cells::Cells;
use super::determinants::{
    Corners, LinearDeterminant, center_determinant, determinants_of, least_determinant,
};
use super::limits::Within;
use super::relaxation::{ITERATIONS, Relaxation};
use crate::lattice::Lattice;
use crate::volume::Limits;

/// Determinant towards which the determinants of a cell are raised.
const TARGET: f64 = 0.05;

/// Determinant from which a cell counts as untangled. It is less than the target, because the minimum of a sum is a
/// compromise.
const UNTANGLED: f64 = 0.02;

/// Weight of the displacement of a vertex in a sweep. It is the square of the area from which on a determinant is
/// raised by moving one vertex, rather than by opening the area.
const PROXIMITY: f64 = 0.01;

/// Greatest displacement of a vertex in a sweep, in cells.
const GREATEST_STEP: f64 = 0.5;

/// Maximum number of displacements in a frame, as a multiple of the number of vertices: it bounds the time of a frame.
/// Drops from twice the height of a body, with the material `jelly`, need up to 100.
const DISPLACEMENTS: usize = 150;

/// Part of the volume at rest below which a body counts as crushed. The volume is the sum of the determinants at the
/// centers of the cells, negative where they are inside out.
const CRUSHED: f64 = 0.25;

/// As [`DISPLACEMENTS`], of a crushed body. The full number leaves it tangled in most frames as well, and can take as
/// long as all steps of the frame.
const CRUSHED_DISPLACEMENTS: usize = 15;

/// Number of sweeps in which the number of cells must halve.
const SWEEPS: usize = 4;

/// Maximum number of relaxations of one lattice. The part that is relaxed grows by a ring of cells with every second
/// one.
const RELAXATIONS: usize = 16;

/// Maximum number of solutions for a vertex in a sweep: the solution determines which determinants are below their
/// target.
const SOLUTIONS: usize = 4;

/// Determinant that a correction may leave, or half of that before the correction if this is less.
const CORRECTED: f64 = 0.01;

/// Maximum number of times that displacements are shortened.
const SHORTENINGS: usize = 100;

/// Number of bits of the factor of one shortening.
const FACTOR_BITS: u32 = 8;

/// Factor of a displacement below which the displacement is removed.
const LEAST_FACTOR: f32 = 1e-3;

/// Untangles lattices, and owns the buffers.
#[derive(Debug, Default)]
pub(in crate::display) struct Untangler {
    cells: Cells,
    /// Whether each vertex is held by pins or handles.
    fixed: Vec<bool>,
    relaxation: Relaxation,
    /// Cells that are not untangled, without repetition, and whether each cell is one of them.
    tangled: Vec<u32>,
    is_tangled: Vec<bool>,
    /// Vertices that move in a sweep, in increasing order, and whether each vertex is one of them.
    active: Vec<u32>,
    is_active: Vec<bool>,
    /// Positions of a correction, and the factor of the displacement of each vertex.
    corrected: Vec<[f32; 3]>,
    factors: Vec<f32>,
    /// Least factor of the present shortening at each vertex; 1 between shortenings.
    shortened: Vec<f32>,
    /// Number of displacements of the frame, and number of those that remain; see [`DISPLACEMENTS`].
    allowed: usize,
    remaining: usize,
    /// Whether the body is crushed in the frame; see [`CRUSHED`].
    is_crushed: bool,
}

/// The untangling of cells that are inside out, in a displayed frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct UntanglingReport {
    /// Number of displacements of lattice vertices, each by the size of a cell or less. It is at most 150 for each
    /// vertex of the lattice, and at most 15 if the body is crushed to less than a quarter of its volume.
    pub displacements: usize,
    /// Whether the body is crushed to less than a quarter of its volume, and the displacements did not suffice: the
    /// surface is displayed with cells inside out.
    pub given_up: bool,
}

impl Untangler {
    /// Returns the memory in bytes.
    pub(in crate::display) fn bytes(&self) -> usize {
        let cells = size_of_val(&*self.tangled) + size_of_val(&*self.is_tangled);
        let vertices = size_of_val(&*self.active) + size_of_val(&*self.is_active);
        let factors = size_of_val(&*self.factors) + size_of_val(&*self.shortened);
        let correction = size_of_val(&*self.corrected) + factors;
        self.cells.bytes()
            + size_of_val(&*self.fixed)
            + self.relaxation.bytes()
            + cells
            + vertices
            + correction
    }

    /// Begins a frame. Must be called before [`Untangler::untangle`].
    pub(in crate::display) fn begin(&mut self, vertices: usize) {
        self.allowed = DISPLACEMENTS * vertices;
        self.remaining = self.allowed;
        self.is_crushed = false;
    }

    /// Allows fewer displacements in the frame if the body is crushed. Must be called after [`Untangler::prepare`],
    /// before the first displacement.
    pub(in crate::display) fn limit_if_crushed(&mut self, positions: &[[f32; 3]]) {
        let [cells, vertices] = [self.cells.len(), self.cells.vertex_count()];
        let volume: f64 =
            (0..cells as u32).map(|cell| center_determinant(&self.cells.corners(cell, positions))).sum();
        self.is_crushed = volume.abs() < CRUSHED * cells as f64;
        if self.is_crushed {
            self.allowed = CRUSHED_DISPLACEMENTS * vertices;
            self.remaining = self.allowed;
        }
    }

    /// Returns the report on the frame.
    pub(in crate::display) fn report(&self) -> UntanglingReport {
        UntanglingReport {
            displacements: self.allowed - self.remaining,
            given_up: self.is_crushed && self.is_exhausted(),
        }
    }

    /// Returns whether no displacement remains in the frame.
    pub(in crate::display) fn is_exhausted(&self) -> bool {
        self.remaining == 0
    }

    /// Prepares for a lattice. `fixed`: vertices that do not move.
    pub(in crate::display) fn prepare(&mut self, lattice: &Lattice, fixed: impl Iterator<Item = u32>) {
        self.cells.prepare(lattice);
        self.fixed.clear();
        self.fixed.resize(lattice.len(), false);
        fixed.for_each(|vertex| self.fixed[vertex as usize] = true);
        self.tangled.clear();
        self.is_tangled.clear();
        self.is_tangled.resize(self.cells.len(), false);
        self.is_active.clear();
        self.is_active.resize(lattice.len(), false);
    }

    /// Returns whether a cell is inverted. Must be called after [`Untangler::prepare`].
    pub(in crate::display) fn is_inverted(&self, positions: &[[f32; 3]]) -> bool {
        (0..self.cells.len() as u32).any(|cell| self.cells.least_determinant(cell, positions) <= 0.0)
    }

    /// Moves vertices within limits of their displacements from `start`, until no cell is inverted, [`RELAXATIONS`] have
    /// not helped, or no displacement remains in the frame.
    ///
    /// Must be called after [`Untangler::prepare`].
    pub(in crate::display) fn untangle(
        &mut self,
        limits: &Limits,
        start: &[[f32; 3]],
        positions: &mut [[f32; 3]],
    ) {
        self.active.clear();
        self.active.extend(0..positions.len() as u32);
        self.find_tangled(|cells, cell| cells.least_determinant(cell, positions) > 0.0);
        let (mut relaxations, mut sweeps, mut count) = (0, 0, self.tangled.len());
        while !self.tangled.is_empty() && self.remaining > 0 {
            if sweeps == SWEEPS {
                if 2 * self.tangled.len() > count {
                    relaxations += 1;
                    if relaxations > RELAXATIONS {
                        break;
                    }
                    self.relax(limits, start, 1 + relaxations / 2, positions);
                }
                (sweeps, count) = (0, self.tangled.len());
            }
            sweeps += 1;
            self.activate();
            self.remaining = self.remaining.saturating_sub(self.active.len());
            let within = Within { limits, start, fixed: &self.fixed };
            for &vertex in &self.active {
                self.move_vertex(within, vertex, positions);
            }
            self.find_tangled(|cells, cell| cells.least_determinant(cell, positions) > UNTANGLED);
        }
    }

    /// Shortens the displacements of a correction from `start`, so that no cell of `positions` is inverted that was not
    /// so before.
    ///
    /// The displacements of the corners of an inverted cell are multiplied by the factor at which it is not inverted,
    /// until no cell is. Must be called after [`Untangler::prepare`].
    pub(in crate::display) fn shorten(&mut self, start: &[[f32; 3]], positions: &mut [[f32; 3]]) {
        self.corrected.clear();
        self.corrected.extend_from_slice(positions);
        self.factors.clear();
        self.factors.resize(start.len(), 1.0);
        self.shortened.resize(start.len(), 1.0);
        self.active.clear();
        self.active.extend(0..start.len() as u32);
        for _ in 0..SHORTENINGS {
            self.find_tangled(|cells, cell| is_kept(cells, cell, start, &cells.corners(cell, positions)));
            if self.tangled.is_empty() {
                return;
            }
            self.activate();
            for &cell in &self.tangled {
                let factor = longest(&self.cells, cell, start, positions);
                for &vertex in self.cells.vertices(cell) {
                    let least = &mut self.shortened[vertex as usize];
                    *least = least.min(factor);
                }
            }
            for &vertex in &self.active {
                let vertex = vertex as usize;
                let factor = &mut self.factors[vertex];
                *factor *= std::mem::replace(&mut self.shortened[vertex], 1.0);
                if *factor < LEAST_FACTOR {
                    *factor = 0.0;
                }
                let (from, to) = (start[vertex], self.corrected[vertex]);
                positions[vertex] = std::array::from_fn(|k| from[k] + *factor * (to[k] - from[k]));
            }
        }
        positions.copy_from_slice(start);
    }

    /// Lists the cells around the active vertices that are not untangled.
    fn find_tangled(&mut self, is_untangled: impl Fn(&Cells, u32) -> bool) {
        for cell in self.tangled.drain(..) {
            self.is_tangled[cell as usize] = false;
        }
        for &vertex in &self.active {
            for (cell, _) in self.cells.around(vertex) {
                if !std::mem::replace(&mut self.is_tangled[cell as usize], true) {
                    self.tangled.push(cell);
                }
            }
        }
        // All cells around the active vertices are listed now, each once. Those that are untangled are removed.
        let Self { cells, tangled, is_tangled, .. } = self;
        tangled.retain(|&cell| {
            let remains = !is_untangled(cells, cell);
            is_tangled[cell as usize] = remains;
            remains
        });
    }

    /// Lists the corners of the cells that are not untangled.
    fn activate(&mut self) {
        self.active.clear();
        for &cell in &self.tangled {
            for &vertex in self.cells.vertices(cell) {
                if !std::mem::replace(&mut self.is_active[vertex as usize], true) {
                    self.active.push(vertex);
                }
            }
        }
        self.active.sort_unstable();
        self.active.iter().for_each(|&vertex| self.is_active[vertex as usize] = false);
    }

    /// Relaxes the cells that are not untangled, with rings of cells around them.
    fn relax(&mut self, limits: &Limits, start: &[[f32; 3]], rings: usize, positions: &mut [[f32; 3]]) {
        for _ in 0..rings {
            self.activate();
            for &vertex in &self.active {
                for (cell, _) in self.cells.around(vertex) {
                    if !std::mem::replace(&mut self.is_tangled[cell as usize], true) {
                        self.tangled.push(cell);
                    }
                }
            }
        }
        self.activate();
        self.tangled.sort_unstable();
        let part = (&*self.tangled, &*self.active);
        self.remaining = self.remaining.saturating_sub(ITERATIONS * self.active.len());
        let within = Within { limits, start, fixed: &self.fixed };
        self.relaxation.relax((&self.cells, within), part, rings, positions);
        self.find_tangled(|cells, cell| cells.least_determinant(cell, positions) > UNTANGLED);
    }

    /// Moves a vertex to the minimum of its sum; see the module.
    fn move_vertex(&self, within: Within<'_>, vertex: u32, positions: &mut [[f32; 3]]) {
        let mut determinants = [LinearDeterminant::default(); 40];
        let around = self.cells.around(vertex);
        let count = 5 * around.len();
        for ((cell, corner), out) in around.zip(determinants.as_chunks_mut::<5>().0) {
            *out = determinants_of(&self.cells.corners(cell, positions), corner);
        }
        let determinants = &determinants[..count];
        let step = minimum(determinants, None);
        let along = |normal, along| minimum(determinants, Some((normal, along)));
        within.advance(vertex, step, along, positions);
    }
}

/// Returns whether the least determinant of a cell is above [`CORRECTED`], or above half of that at the start if this
/// is less.
fn is_kept(cells: &Cells, cell: u32, start: &[[f32; 3]], corners: &Corners) -> bool {
    let least = least_determinant(corners);
    least > CORRECTED || least > 0.5 * cells.least_determinant(cell, start)
}

/// Returns a factor below 1 of the displacements of the corners of a cell from the start, at which the cell is kept:
/// see [`is_kept`]. It is the greatest one if the cell is kept at all smaller ones.
fn longest(cells: &Cells, cell: u32, start: &[[f32; 3]], positions: &[[f32; 3]]) -> f32 {
    let (from, to) = (cells.corners(cell, start), cells.corners(cell, positions));
    let (mut factor, mut step) = (0.0, 1.0);
    for _ in 0..FACTOR_BITS {
        step *= 0.5;
        let longer = std::array::from_fn(|k| from[k].lerp(&to[k], factor + step));
        if is_kept(cells, cell, start, &longer) {
            factor += step;
        }
    }
    factor as f32
}

/// Returns the displacement of a vertex with the least sum, of at most [`GREATEST_STEP`]; see the module. `plane`: unit
/// normal, and the given displacement along it.
fn minimum(determinants: &[LinearDeterminant], plane: Option<(Vector3<f64>, f64)>) -> Vector3<f64> {
    let fixed = plane.map_or(Vector3::zeros(), |(normal, along)| normal * along);
    let mut step = fixed;
    let mut below_before = None;
    for _ in 0..SOLUTIONS {
        let (mut matrix, mut right) = (Matrix3::identity() * PROXIMITY, Vector3::zeros());
        // Bit mask of the determinants below their target.
        let mut below = 0_u64;
        for (k, LinearDeterminant { value, gradient }) in determinants.iter().enumerate() {
            if value + gradient.dot(&step) < TARGET {
                below |= 1 << k;
                let free = plane.map_or(*gradient, |(normal, _)| gradient - normal * normal.dot(gradient));
                matrix += free * free.transpose();
                right += free * (TARGET - value - gradient.dot(&fixed));
            }
        }
        if below_before == Some(below) {
            break;
        }
        below_before = Some(below);
        step = fixed + solve(&matrix, &right);
    }
    step.cap_magnitude(GREATEST_STEP)
}

/// Solves a symmetric, positive definite system by Cramer's rule. The result is not finite if the matrix is nearly
/// singular.
fn solve(matrix: &Matrix3<f64>, right: &Vector3<f64>) -> Vector3<f64> {
    let [x, y, z]: [Vector3<f64>; 3] = [0, 1, 2].map(|k| matrix.column(k).into());
    let yz = y.cross(&z);
    Vector3::new(right.dot(&yz), x.dot(&right.cross(&z)), x.dot(&y.cross(right))) / x.dot(&yz)
}
