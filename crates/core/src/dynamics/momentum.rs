//! Momentum book-keeping: what f32 loses of a free body's momenta is given back each step.
//!
//! The rounding of g - x is a constant force that is integrated twice: without a book a free body drifts, and one
//! whose drift alone is removed spins itself up. So for each component on which nothing pulls, linear and angular
//! momentum are kept in f64, changed only by known outside impulses, and the velocities are corrected by the rigid
//! velocity that they miss.

use fearless_simd::{Simd, SimdBase, dispatch, f32x8, f64x4};
use nalgebra::{Matrix3, Vector3};

use crate::lanes::{LANES, Lanes, load};
use crate::lattice::Lattice;
use crate::matching::layout::Layout;
use crate::parallel::{CHUNK, Executor, level};

/// The momenta of one component: masses in full cells, lengths in cells.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "scene", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Momentum {
    /// Σ m v, in cell masses times cells/s.
    pub(crate) linear: [f64; 3],
    /// Σ m (x - c) x v about the component's centre of mass.
    pub(crate) angular: [f64; 3],
}

/// Which component each lattice vertex belongs to.
#[derive(Clone, Debug)]
pub(crate) enum Components {
    /// All to the only one.
    One,
    /// By slot.
    Several(Vec<u32>),
}

impl Components {
    /// The component of a slot.
    #[inline(always)]
    pub(crate) fn of(&self, slot: u32) -> usize {
        match self {
            Self::One => 0,
            Self::Several(of_slot) => of_slot[slot as usize] as usize,
        }
    }
}

/// Sums over a component, in f64.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    mass: f64,
    /// Σ m v, Σ m x, Σ m x x v, Σ m (xx, yy, zz, xy, xz, yz).
    moments: [f64; MOMENTS],
}

const MOMENTS: usize = 15;

/// A rigid velocity field v + ω x x, about the body's origin.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct RigidVelocity {
    pub(crate) linear: [f32; 3],
    pub(crate) angular: [f32; 3],
}

/// A component's mass, centre and momenta as its vertices have them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RigidState {
    pub(crate) mass: f64,
    pub(crate) centre: Vector3<f64>,
    pub(crate) momentum: Momentum,
    inertia: Matrix3<f64>,
}

/// Sums momenta; its buffers.
#[derive(Clone, Debug)]
pub(crate) struct Bookkeeper {
    components: Components,
    /// Of each component, in full cells.
    masses: Vec<f64>,
    partial: Vec<Sums>,
    states: Vec<RigidState>,
    corrections: Vec<RigidVelocity>,
    /// Components that something holds: their momenta are not their own.
    pulled: Vec<bool>,
}

impl Bookkeeper {
    /// For a lattice stored by `layout`.
    pub(crate) fn new(lattice: &Lattice, layout: &Layout) -> Self {
        let count = lattice.components().count;
        let mut masses = vec![0.0; count];
        for (&component, &cells) in lattice.components().of_vertex.iter().zip(lattice.occupied_cells()) {
            masses[component as usize] += f64::from(cells) / 8.0;
        }
        let components = if count == 1 {
            Components::One
        } else {
            let mut of_slot = vec![0; layout.blocks() * LANES];
            for (&slot, &component) in layout.slots().iter().zip(&lattice.components().of_vertex) {
                of_slot[slot as usize] = component;
            }
            Components::Several(of_slot)
        };
        Self {
            components,
            masses,
            partial: vec![Sums::default(); count * layout.blocks().div_ceil(CHUNK)],
            states: vec![Sums::default().rigid_state(); count],
            corrections: vec![RigidVelocity::default(); count],
            pulled: vec![false; count],
        }
    }

    /// Shuts the books of the components of which a vertex is held; `held` by lattice vertex.
    pub(crate) fn pull(&mut self, slots: &[u32], held: &[bool], books: &mut [Option<Momentum>]) {
        self.pulled.fill(false);
        for (&slot, _) in slots.iter().zip(held).filter(|(_, held)| **held) {
            self.pulled[self.components.of(slot)] = true;
        }
        for (book, _) in books.iter_mut().zip(&self.pulled).filter(|(_, pulled)| **pulled) {
            *book = None;
        }
    }

    /// Whether a book is to be opened: its component is free, and its momenta are not known.
    pub(crate) fn any_to_open(&self, books: &[Option<Momentum>]) -> bool {
        books.iter().zip(&self.pulled).any(|(book, pulled)| book.is_none() && !pulled)
    }

    /// Opens the books of free components with the momenta measured last.
    pub(crate) fn open(&self, books: &mut [Option<Momentum>]) {
        for ((book, state), pulled) in books.iter_mut().zip(&self.states).zip(&self.pulled) {
            if book.is_none() && !pulled {
                *book = Some(state.momentum);
            }
        }
    }

    /// Mass, centre and momenta of each component.
    pub(crate) fn measure(
        &mut self,
        executor: &Executor,
        constants: &Lanes<6>,
        positions: &Lanes<3>,
        velocities: &Lanes<3>,
    ) {
        let count = self.states.len();
        let fields = Fields { constants, positions, velocities };
        let components = &self.components;
        executor.groups(&mut self.partial, count, |chunk, sums| {
            let blocks = chunk * CHUNK..fields.constants.blocks().len().min((chunk + 1) * CHUNK);
            sums.fill(Sums::default());
            match components {
                Components::One => dispatch!(level(), simd => sums[0] = sum(simd, fields, blocks)),
                Components::Several(_) => sum_by_component(fields, components, blocks, sums),
            }
        });
        for (component, state) in self.states.iter_mut().enumerate() {
            let mut total = Sums::default();
            for sums in self.partial.iter().skip(component).step_by(count) {
                total.add(sums);
            }
            *state = total.rigid_state();
        }
    }

    /// Enters in the open books that each vertex has gained `gain`, in cells/s.
    pub(crate) fn enter(&self, books: &mut [Option<Momentum>], gain: Vector3<f64>) {
        for (book, mass) in books.iter_mut().zip(&self.masses) {
            if let Some(book) = book {
                book.linear = (Vector3::from(book.linear) + gain * *mass).into();
            }
        }
    }

    /// Memory that the sums take.
    pub(crate) fn bytes(&self) -> usize {
        let of_slots = match &self.components {
            Components::One => 0,
            Components::Several(of_slot) => size_of_val(of_slot.as_slice()),
        };
        of_slots + size_of_val(self.partial.as_slice())
    }

    /// Whether any component is free, so that its momenta are its own.
    pub(crate) fn any_free(&self) -> bool {
        self.pulled.contains(&false)
    }

    /// The centre of mass of the body in the last measurement, in cells.
    pub(crate) fn centre(&self) -> Vector3<f64> {
        self.states.iter().map(|state| state.centre * state.mass).sum::<Vector3<f64>>() / self.mass()
    }

    /// The velocity of that centre, in cells/s.
    pub(crate) fn velocity(&self) -> Vector3<f64> {
        self.states.iter().map(|state| Vector3::from(state.momentum.linear)).sum::<Vector3<f64>>()
            / self.mass()
    }

    fn mass(&self) -> f64 {
        self.states.iter().map(|state| state.mass).sum()
    }

    /// The rigid velocity that each component, as measured last, misses of its book; none where that is shut.
    pub(crate) fn corrections(&mut self, books: &[Option<Momentum>]) -> (&Components, &[RigidVelocity]) {
        for ((state, book), correction) in self.states.iter().zip(books).zip(&mut self.corrections) {
            *correction = book.map_or_else(RigidVelocity::default, |book| state.missing(book));
        }
        (&self.components, &self.corrections)
    }
}

impl RigidState {
    /// The rigid velocity that brings the momenta to those of the book.
    fn missing(&self, book: Momentum) -> RigidVelocity {
        let linear = (Vector3::from(book.linear) - Vector3::from(self.momentum.linear)) / self.mass;
        let angular = Vector3::from(book.angular) - Vector3::from(self.momentum.angular);
        let omega = turn(&self.inertia, angular);
        let at_origin = linear - omega.cross(&self.centre);
        let finite = at_origin.iter().chain(omega.iter()).all(|x| x.is_finite());
        if !finite {
            return RigidVelocity::default();
        }
        RigidVelocity { linear: narrow(at_origin), angular: narrow(omega) }
    }
}

/// ω with I ω = l, leaving out the axes about which the component has next to no inertia: points on a line, or on
/// one another, cannot carry spin about it.
fn turn(inertia: &Matrix3<f64>, angular: Vector3<f64>) -> Vector3<f64> {
    let scale = inertia.trace();
    if scale <= 0.0 || !scale.is_finite() {
        return Vector3::zeros();
    }
    let eigen = (inertia / scale).symmetric_eigen();
    let mut omega = Vector3::zeros();
    for (value, axis) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
        if *value > 1e-9 {
            omega += axis * (axis.dot(&angular) / (value * scale));
        }
    }
    omega
}

fn narrow(v: Vector3<f64>) -> [f32; 3] {
    [v.x as f32, v.y as f32, v.z as f32]
}

impl Sums {
    fn add(&mut self, other: &Self) {
        self.mass += other.mass;
        for (sum, other) in self.moments.iter_mut().zip(other.moments) {
            *sum += other;
        }
    }

    fn rigid_state(&self) -> RigidState {
        let m = &self.moments;
        let mass = if self.mass > 0.0 { self.mass } else { 1.0 };
        let linear = Vector3::new(m[0], m[1], m[2]);
        let centre = Vector3::new(m[3], m[4], m[5]) / mass;
        let angular = Vector3::new(m[6], m[7], m[8]) - centre.cross(&linear);
        let [xx, yy, zz, xy, xz, yz] = [m[9], m[10], m[11], m[12], m[13], m[14]];
        let spread = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz) - centre * centre.transpose() * mass;
        let inertia = Matrix3::identity() * spread.trace() - spread;
        RigidState {
            mass,
            centre,
            momentum: Momentum { linear: linear.into(), angular: angular.into() },
            inertia,
        }
    }
}

#[derive(Clone, Copy)]
struct Fields<'a> {
    constants: &'a Lanes<6>,
    positions: &'a Lanes<3>,
    velocities: &'a Lanes<3>,
}

/// The moments of one vertex: all but the mass are linear in m.
#[inline(always)]
fn moments<T>(m: T, [x, y, z]: [T; 3], [u, v, w]: [T; 3]) -> [T; MOMENTS]
where
    T: Copy + std::ops::Mul<Output = T> + std::ops::Sub<Output = T>,
{
    let (mx, my, mz) = (m * x, m * y, m * z);
    [
        m * u,
        m * v,
        m * w,
        mx,
        my,
        mz,
        my * w - mz * v,
        mz * u - mx * w,
        mx * v - my * u,
        mx * x,
        my * y,
        mz * z,
        mx * y,
        mx * z,
        my * z,
    ]
}

/// The sums of a range of blocks, four lanes at a time.
#[inline(always)]
fn sum<S: Simd>(simd: S, fields: Fields, blocks: std::ops::Range<usize>) -> Sums {
    let mut mass = f64x4::splat(simd, 0.0);
    let mut total = [f64x4::splat(simd, 0.0); MOMENTS];
    for block in blocks {
        let [m] = load(simd, &fields.constants.blocks()[block]);
        let [x, y, z] = load(simd, &fields.positions.blocks()[block]);
        let [u, v, w] = load(simd, &fields.velocities.blocks()[block]);
        let (m, x, y, z) = (halves(simd, m), halves(simd, x), halves(simd, y), halves(simd, z));
        let (u, v, w) = (halves(simd, u), halves(simd, v), halves(simd, w));
        for half in 0..2 {
            mass += m[half];
            let moments = moments(m[half], [x[half], y[half], z[half]], [u[half], v[half], w[half]]);
            for i in 0..MOMENTS {
                total[i] += moments[i];
            }
        }
    }
    let mut sums = Sums { mass: across(mass), moments: [0.0; MOMENTS] };
    for i in 0..MOMENTS {
        sums.moments[i] = across(total[i]);
    }
    sums
}

#[inline(always)]
fn halves<S: Simd>(simd: S, row: f32x8<S>) -> [f64x4<S>; 2] {
    let (low, high) = simd.widen_f32x8(row);
    [low, high]
}

#[inline(always)]
fn across<S: Simd>(lanes: f64x4<S>) -> f64 {
    let [a, b, c, d] = lanes.to_array();
    (a + b) + (c + d)
}

fn sum_by_component(
    fields: Fields,
    components: &Components,
    blocks: std::ops::Range<usize>,
    sums: &mut [Sums],
) {
    for slot in blocks.start * LANES..blocks.end * LANES {
        let [m, share, ..] = fields.constants.get(slot as u32);
        if share > 0.0 {
            let m = f64::from(m);
            let x = fields.positions.get(slot as u32).map(f64::from);
            let v = fields.velocities.get(slot as u32).map(f64::from);
            sums[components.of(slot as u32)].add(&Sums { mass: m, moments: moments(m, x, v) });
        }
    }
}
