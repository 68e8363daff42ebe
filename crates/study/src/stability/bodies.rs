//! Builds the bodies and colliders of the cases.

use std::fmt;

use nalgebra::{Point3, Vector3};
use supple::reference::{Mass, Momenta};
use supple::{Body, BodyBuilder, Collider, Error, Key, Lattice, Material, Selection, Simulation};

use crate::suite::Suite;

/// Regions, Poisson's ratio and inflation of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Matter {
    pub(super) half_width: f64,
    pub(super) poisson_ratio: f64,
    pub(super) inflate: f64,
}

impl Matter {
    /// Materials with Poisson's ratio that are inflated or shrink: both ratios and both inflations with each half-width, and
    /// each ratio with each inflation.
    pub(super) const VARIED: [Self; 6] = [
        Self { half_width: 0.5, poisson_ratio: 0.3, inflate: 0.7 },
        Self { half_width: 0.5, poisson_ratio: 0.45, inflate: 1.5 },
        Self { half_width: 1.0, poisson_ratio: 0.3, inflate: 1.5 },
        Self { half_width: 1.0, poisson_ratio: 0.45, inflate: 0.7 },
        Self { half_width: 2.0, poisson_ratio: 0.3, inflate: 0.7 },
        Self { half_width: 2.0, poisson_ratio: 0.45, inflate: 1.5 },
    ];

    /// Returns regions of a half-width without Poisson's ratio and inflation, and after them the [`VARIED`](Self::VARIED)
    /// materials.
    pub(super) fn beside(half_width: f64) -> impl Iterator<Item = Self> {
        std::iter::once(half_width.into()).chain(Self::VARIED)
    }

    /// Returns regions of a half-width as [`beside`](Self::beside), and after them the materials of half-width 2 alone: narrower
    /// regions are softer, and the loads of some cases too strong for them.
    pub(super) fn wide(half_width: f64) -> impl Iterator<Item = Self> {
        Self::beside(half_width).filter(|matter| matter.is_plain() || matter.half_width == 2.0)
    }

    /// Returns the name of a case: with the material, unless it is plain.
    pub(super) fn named(self, name: impl fmt::Display) -> String {
        if self.is_plain() { name.to_string() } else { format!("{name}; {self}") }
    }

    /// Returns whether the body has neither Poisson's ratio nor inflation.
    pub(super) fn is_plain(self) -> bool {
        self == self.half_width.into()
    }

    /// Returns the bound of the energy that an undamped body gains. Where its volume changes, with few steps to a period, the
    /// energy of the leapfrog steps varies by several per cent without growing: the bound is that of the tests of Poisson's
    /// ratio.
    pub(super) fn gain(self) -> f64 {
        if self.is_plain() { 0.05 } else { 0.1 }
    }

    /// Returns the run-time class of a case that takes long with Poisson's ratio.
    pub(super) fn suite(self) -> Suite {
        if self.is_plain() { Suite::Quick } else { Suite::Long }
    }

    /// Gives a body Poisson's ratio and inflation.
    pub(super) fn applied(self, body: BodyBuilder) -> BodyBuilder {
        if self.is_plain() { body } else { body.poisson_ratio(self.poisson_ratio).inflate(self.inflate) }
    }
}

impl From<f64> for Matter {
    fn from(half_width: f64) -> Self {
        Self { half_width, poisson_ratio: 0.0, inflate: 1.0 }
    }
}

impl fmt::Display for Matter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "half-width {}", self.half_width)?;
        if self.is_plain() {
            Ok(())
        } else {
            write!(f, ", ratio {}, inflate {}", self.poisson_ratio, self.inflate)
        }
    }
}

/// Returns the cells of a block with `size` cells along x, y and z.
pub(super) fn block(size: [i32; 3]) -> Vec<[i32; 3]> {
    let [nx, ny, nz] = size;
    (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z]))).collect()
}

/// Returns the cells of two blocks of 4 x 4 x 4 cells. The second block is translated by `offset` cells.
pub(super) fn two_blocks(offset: [i32; 3]) -> Vec<[i32; 3]> {
    let second = block([4; 3]).into_iter().map(|cell| [0, 1, 2].map(|c| cell[c] + offset[c]));
    block([4; 3]).into_iter().chain(second).collect()
}

/// Creates a builder for a body of cells of edge 1 with a material, or with regions of a half-width.
pub(super) fn of_cells(cells: &[[i32; 3]], matter: impl Into<Matter>) -> Result<BodyBuilder, Error> {
    of_sized_cells(cells, 1.0, matter)
}

/// Creates a builder for a body of cells of edge `cell_size` with a material, or with regions of a half-width.
pub(super) fn of_sized_cells(
    cells: &[[i32; 3]],
    cell_size: f64,
    matter: impl Into<Matter>,
) -> Result<BodyBuilder, Error> {
    let matter = matter.into();
    let lattice = Lattice::from_cells(cells, cell_size, Point3::origin(), false)?;
    let body = Body::from_lattice(lattice).material(Material::fast_lsm()).half_width(matter.half_width);
    Ok(matter.applied(body))
}

/// Builds a simulation of one body without gravity and colliders, on one thread.
pub(super) fn alone(body: Body) -> Result<Simulation, Error> {
    Simulation::builder().sleep(false).body(body).gravity([0.0; 3]).threads(1).build()
}

/// Sets random velocities with components of up to `size` cells per step of 1/60 s, and subtracts the rigid
/// motion, so that linear and angular momentum are zero.
pub(super) fn shake(body: &mut Body, size: f64) -> Result<(), Error> {
    let mut random = fastrand::Rng::with_seed(3);
    let max_component = 60.0 * size * body.lattice().cell_size();
    let mut component = || max_component * (2.0 * random.f64() - 1.0);
    let (masses, positions) = (body.masses(), body.positions());
    let points: Vec<Mass> = masses
        .iter()
        .zip(&positions)
        .map(|(&mass, x)| {
            let velocity = Vector3::new(component(), component(), component());
            Mass { mass, position: x.coords, velocity }
        })
        .collect();
    let momenta = Momenta::of(points.iter().copied());
    let (drift, spin) = momenta.missing(&Momenta::default(), points.iter().copied());
    let velocities = points.iter().map(|p| p.velocity + drift + spin.cross(&(p.position - momenta.center)));
    body.set_velocities(&velocities.collect::<Vec<_>>())?;
    Ok(())
}

/// Applies `deform` to the positions relative to their mean.
pub(super) fn deform(
    body: &mut Body,
    deform: impl Fn(&[Vector3<f64>]) -> Vec<Vector3<f64>>,
) -> Result<(), Error> {
    let positions: Vec<_> = body.positions().iter().map(|p| p.coords).collect();
    let mean = positions.iter().sum::<Vector3<f64>>() / positions.len() as f64;
    let relative: Vec<_> = positions.iter().map(|x| x - mean).collect();
    let moved: Vec<_> = deform(&relative).into_iter().map(|x| Point3::from(x + mean)).collect();
    body.set_positions(&moved)?;
    Ok(())
}

/// Selects the lattice vertices of a block of cells whose index along x is `x`.
pub(super) fn layer(block: [i32; 3], x: i32) -> Selection {
    let [nx, ny, nz] = block.map(|cells| cells + 1);
    // Lattice vertices are sorted by z, then y, then x.
    Selection::Vertices((0..ny * nz).map(|row| (row * nx + x) as u32).collect())
}

/// Creates a plate: a horizontal plane at the height `y` whose normal is `normal` (1 or -1) along y. It moves
/// along y by `travel` within 1 s, rests for 1 s, and returns within 0.5 s.
pub(super) fn plate(y: f64, normal: f64, travel: f64) -> Collider {
    let key = |(time, travel)| Key { time, translate: [0.0, travel, 0.0], rotate: [0.0; 3] };
    let keys = [(0.0, 0.0), (1.0, travel), (2.0, travel), (2.5, 0.0)].map(key).to_vec();
    Collider { keys, ..Collider::plane([0.0, y, 0.0], [0.0, normal, 0.0]) }
}
