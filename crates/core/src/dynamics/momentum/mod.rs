//! Momentum book-keeping: what f32 loses of a free body's momenta is given back each step.
//!
//! The rounding of g - x is a constant force that is integrated twice: without a book a free body drifts, and one
//! whose drift alone is removed spins itself up. So for each component on which nothing pulls, linear and angular
//! momentum are kept in f64, changed only by known outside impulses, and the velocities are corrected by the rigid
//! velocity that they miss.

mod rigid;
pub(crate) mod sums;

pub(crate) use rigid::{Momentum, RigidVelocity};

use fearless_simd::dispatch;
use nalgebra::Vector3;

use crate::lattice::Lattice;
use crate::lattice::layout::Layout;
use crate::parallel::Executor;
use crate::simd::lanes::{LANES, Lanes};
use crate::simd::level;
use rigid::RigidState;
use sums::{Fields, Sums};

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
    /// For a lattice stored by `layout`, with so many tasks in a step.
    pub(crate) fn new(lattice: &Lattice, layout: &Layout, tasks: usize) -> Self {
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
            partial: vec![Sums::default(); count * tasks],
            states: masses.iter().map(|&mass| Sums::default().rigid_state(mass)).collect(),
            masses,
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

    /// Says that nothing is held.
    pub(crate) fn free(&mut self) {
        self.pulled.fill(false);
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

    /// Measures mass, centre and momenta of each component; `bounds` of blocks part the tasks.
    pub(crate) fn measure(
        &mut self,
        executor: &Executor,
        bounds: &[usize],
        shares: &Lanes<2>,
        positions: &Lanes<3>,
        velocities: &Lanes<3>,
    ) {
        let (components, partial) = self.open_sums();
        executor.tasks(bounds, (&mut [], &mut [], partial), |task, _: &mut [()], _: &mut [()], sums| {
            let blocks = bounds[task]..bounds[task + 1];
            let fields = Fields {
                shares: &shares.blocks()[blocks.clone()],
                positions: &positions.blocks()[blocks.clone()],
                velocities: &velocities.blocks()[blocks.clone()],
            };
            dispatch!(level(), simd => sums::add(simd, components, blocks.start, fields, sums));
        });
        self.close_sums();
    }

    /// The sums of each task, equally many, at zero; one for each component.
    pub(crate) fn open_sums(&mut self) -> (&Components, &mut [Sums]) {
        self.partial.fill(Sums::default());
        (&self.components, &mut self.partial)
    }

    /// Mass, centre and momenta of each component, from the sums of the tasks.
    pub(crate) fn close_sums(&mut self) {
        let count = self.states.len();
        for (component, state) in self.states.iter_mut().enumerate() {
            let mut total = Sums::default();
            for sums in self.partial.iter().skip(component).step_by(count) {
                total.add(sums);
            }
            *state = total.rigid_state(self.masses[component]);
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

    /// The kinetic energy of rigid components with the momenta measured last, in full cells times (cells/s)².
    pub(crate) fn rigid_energy(&self) -> f64 {
        self.states.iter().map(RigidState::rigid_energy).sum()
    }

    /// Says that all velocities have been multiplied by `scale` since the last measurement.
    pub(crate) fn slow(&mut self, scale: f64) {
        for momentum in self.states.iter_mut().map(|state| &mut state.momentum) {
            momentum.linear = momentum.linear.map(|p| p * scale);
            momentum.angular = momentum.angular.map(|l| l * scale);
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
