//! Cases that measure Poisson's ratio and the moduli: bars that are pulled, bent and twisted by their ends, and cubes that
//! are dilated.
//!
//! The laws are those of a solid times the factors of the lattice and its regions: see [`Regions`]. Forces, strains and
//! energies are means of a load and its opposite, which leaves out the next order in the strain e: near Poisson's ratio 1/2
//! the force of a pulled bar is E A e (1 - 3/4 e), because its sides come closer as (1 + e)^-1/2.

use std::error::Error;

use nalgebra::{Point3, Vector3};
use supple::{
    BodyBuilder, ElasticLaw, HalfWidth, Handle, HandleMotion, Key, Selection, Simulation, TimeWindow,
};

use crate::material::bodies::{bar, bar_vertices, stepped};
use crate::material::case::{Case, Measured, Outcome, Quantity, Target};
use crate::material::regions::Regions;
use crate::material::theory::Bar;

/// Length of a bar, of the thickness 1. Its middle fifth is measured.
const LENGTH: i32 = 5;

/// Strain of a bar that is pulled, and the twist.
const STRAIN: f64 = 0.01;

/// Curvature of a bar that is bent: its ends stay in place, which pulls it by the square of the curvature.
const CURVATURE: f64 = 0.0025;

/// Strain of a cube along each axis.
const DILATION: f64 = 1e-3;

/// Steps per second.
const STEP_RATE: f64 = 240.0;

/// Time in which a body comes to rest, in decay times of its lowest mode: up to exp(-12) (1 + 12) of the distance at the
/// start.
const DECAY_TIMES: f64 = 12.0;

/// What the ends of a bar do.
#[derive(Clone, Copy)]
enum Load {
    Pull,
    Bend,
    Twist,
}

impl Load {
    /// Returns the rigid displacement of a cross-section at x and y from the axis, whose change along the bar is the strain.
    fn mode(self, x: f64, y: f64) -> Vector3<f64> {
        match self {
            Self::Pull => Vector3::z(),
            Self::Bend => Vector3::z() * x,
            Self::Twist => Vector3::new(-y, x, 0.0),
        }
    }

    /// Returns the displacement of a solid bar of the given length with the strain 1, at `p` from its middle.
    fn displacement(self, p: Vector3<f64>, length: f64, ratio: f64) -> Vector3<f64> {
        let across = match self {
            Self::Pull => Vector3::new(p.x, p.y, 0.0) * -ratio,
            Self::Bend => {
                let deflection = ((length / 2.0).powi(2) - p.z * p.z - ratio * (p.x * p.x - p.y * p.y)) / 2.0;
                Vector3::new(deflection, -ratio * p.x * p.y, 0.0)
            }
            Self::Twist => Vector3::zeros(),
        };
        self.mode(p.x, p.y) * p.z + across
    }

    /// Returns the displacement of an end at `z` from the middle with the given strain, as a keyframe.
    fn end(self, z: f64, strain: f64) -> Key {
        let (along, angle) = (strain * z, (strain * z).to_degrees());
        let (translate, rotate) = match self {
            Self::Pull => ([0.0, 0.0, along], [0.0; 3]),
            Self::Bend => ([0.0; 3], [0.0, -angle, 0.0]),
            Self::Twist => ([0.0; 3], [0.0, 0.0, angle]),
        };
        Key { time: 0.0, translate, rotate }
    }
}

/// A lattice with `cells` cells per unit of length, and its material.
#[derive(Clone, Copy)]
struct Solid {
    cells: i32,
    half_width: HalfWidth,
    poisson_ratio: f64,
}

impl Solid {
    /// Returns the laws of a bar of the thickness 1, with Young's modulus at the greatest alpha.
    fn bar(self) -> Bar {
        let Self { cells, half_width, poisson_ratio } = self;
        let density = supple::Material::default().density;
        let law =
            ElasticLaw { density, cell_size: 1.0 / f64::from(cells), dt: 1.0 / STEP_RATE, poisson_ratio };
        let modulus = law.modulus(half_width, law.greatest_alpha());
        Bar { thickness: 1.0, length: f64::from(LENGTH), modulus, poisson_ratio, density }
    }

    fn regions(self) -> Regions {
        let Self { cells, half_width, poisson_ratio } = self;
        Regions { cells, half_width, poisson_ratio }
    }

    /// Returns a builder of a bar of 1 x 1 x `length` that is damped as much as its lowest mode is at its critical damping.
    fn builder(self, length: i32) -> Result<BodyBuilder, supple::Error> {
        let body = bar(self.cells, length)?.half_width(self.half_width).stiffness(1.0);
        Ok(body.poisson_ratio(self.poisson_ratio).damping_ratio(1.0))
    }

    /// Lets a bar come to rest whose ends are displaced by a load.
    fn loaded(self, load: Load, strain: f64) -> Result<Simulation, supple::Error> {
        let length = f64::from(LENGTH);
        let mut body = self.builder(LENGTH)?;
        for side in [-1.0, 1.0] {
            let end = Vector3::z() * (length / 2.0 * (1.0 + side));
            let selection = Selection::Plane {
                point: (end - Vector3::z() * (side * 1e-6)).into(),
                normal: [0.0, 0.0, side],
            };
            let motion = HandleMotion::from(vec![load.end(side * length / 2.0, strain)]);
            body = body.handle(Handle { goal: None, selection, motion, window: TimeWindow::default() });
        }
        let mut body = body.build()?;
        let start: Vec<_> = body
            .positions()
            .iter()
            .map(|p| p + load.displacement(from_middle(p), length, self.poisson_ratio) * strain)
            .collect();
        body.set_positions(&start)?;
        let mut simulation = stepped(body, [0.0; 3], 1.0 / STEP_RATE).build()?;
        let rate = std::f64::consts::TAU * self.bar().bending();
        simulation.steps((DECAY_TIMES / rate * STEP_RATE) as u64);
        Ok(simulation)
    }

    /// Measures the strain and the force or torque of a bar, and its strain across.
    fn response(self, load: Load, strain: f64) -> Result<[f64; 3], Box<dyn Error>> {
        let simulation = self.loaded(load, strain)?;
        let body = simulation.body(0);
        let cells = f64::from(self.cells);
        let rest = |index: [i32; 3]| Point3::from(index.map(f64::from)) / cells;
        let vertices: Vec<_> = body
            .lattice()
            .indices()
            .iter()
            .zip(body.positions())
            .map(|(&index, x)| (index, from_middle(&rest(index)), x - rest(index)))
            .collect();
        let [low, high] = [2, 3].map(|fifth| fifth * self.cells);
        let amount = |layer: i32| {
            let in_layer = vertices.iter().filter(|(index, ..)| index[2] == layer);
            let sums = in_layer.map(|(_, p, u)| {
                let mode = load.mode(p.x, p.y);
                Vector3::new(mode.dot(u), mode.norm_squared(), 0.0)
            });
            let sums: Vector3<f64> = sums.sum();
            sums.x / sums.y
        };
        let wider = |axis: usize| {
            let side = |at: i32| {
                let on_side = vertices
                    .iter()
                    .filter(|(index, ..)| (low..=high).contains(&index[2]) && index[axis] == at);
                let displacements: Vec<f64> = on_side.map(|(_, _, u)| u[axis]).collect();
                displacements.iter().sum::<f64>() / displacements.len() as f64
            };
            side(self.cells) - side(0)
        };
        let hold = body.hold_force(1)?.unwrap_or_default();
        let response = match load {
            Load::Pull => hold.force.z,
            Load::Bend => -hold.torque.y,
            Load::Twist => hold.torque.z,
        };
        Ok([amount(high) - amount(low), response, (wider(0) + wider(1)) / 2.0])
    }

    /// Measures Poisson's ratio and the stiffness of a bar in tension, bending and torsion.
    fn stiffness(self) -> Outcome {
        let difference = |load: Load, strain: f64| -> Result<Vector3<f64>, Box<dyn Error>> {
            let [with, against] =
                [self.response(load, strain)?, self.response(load, -strain)?].map(Vector3::from);
            Ok(with - against)
        };
        let pulled = difference(Load::Pull, STRAIN)?;
        let bent = difference(Load::Bend, CURVATURE)?;
        let twisted = difference(Load::Twist, STRAIN)?;
        let (bar, regions) = (self.bar(), self.regions());
        Ok(vec![
            (-pulled.z / pulled.x).into(),
            Measured::by_law(pulled.y / pulled.x, bar.tensile_stiffness() * regions.stretch()),
            Measured::by_law(bent.y / bent.x, bar.bending_stiffness() * regions.bending()),
            Measured::by_law(twisted.y / twisted.x, bar.torsional_stiffness() * regions.torsion()),
        ])
    }

    /// Dilates a cube, and measures the bulk modulus by its elastic energy, K/2 times the square of the change of the volume.
    fn bulk(self) -> Outcome {
        let energy = |strain: f64| -> Result<f64, Box<dyn Error>> {
            let mut body = self.builder(1)?.build()?;
            let dilated: Vec<_> = body.positions().iter().map(|p| p * (1.0 + strain)).collect();
            body.set_positions(&dilated)?;
            let simulation = stepped(body, [0.0; 3], 1.0 / STEP_RATE).build()?;
            Ok(simulation.body(0).elastic_energy().unwrap_or(f64::NAN))
        };
        let modulus = (energy(DILATION)? + energy(-DILATION)?) / (3.0 * DILATION).powi(2);
        Ok(vec![Measured::by_law(modulus, self.bar().bulk_modulus() * self.regions().dilation())])
    }
}

/// Returns the position of a point of a bar relative to its middle.
fn from_middle(p: &Point3<f64>) -> Vector3<f64> {
    p.coords - Vector3::new(0.5, 0.5, f64::from(LENGTH) / 2.0)
}

/// Returns the cases of this family.
pub(super) fn cases() -> Vec<Case> {
    let sizes = [1, 2, 4, 6].map(|cells| (cells, HalfWidth::CELL)).into_iter();
    let wide = [1, 2].into_iter().flat_map(|w| [6, 10].map(|cells| (cells, w.into())));
    let mut cases = Vec::new();
    for (cells, half_width) in sizes.chain(wide) {
        for poisson_ratio in [0.0, 0.3, 0.45] {
            let solid = Solid { cells, half_width, poisson_ratio };
            let text =
                format!("{cells} cells across, half-width {}, ratio {poisson_ratio}", half_width.cells());
            let law = |name| Quantity::new(name, Target::within(0.97, 1.03));
            let quantities = [
                Quantity::new("Poisson's ratio", around(poisson_ratio)),
                law("E A, N"),
                law("E I, N m^2"),
                law("G J, N m^2"),
            ];
            let case = Case::new(format!("bar, {text}"), quantities, move || solid.stiffness());
            cases.push(case.of_vertices(bar_vertices(cells, LENGTH)));
            let quantity = [law("bulk modulus, Pa")];
            cases.push(Case::new(format!("cube, {text}"), quantity, move || solid.bulk()));
        }
    }
    cases
}

/// Returns the range of Poisson's ratios that differ by at most 0.02, in whole thousandths.
fn around(ratio: f64) -> Target {
    let [low, high] = [-20.0, 20.0].map(|offset| (1000.0 * ratio + offset).round() / 1000.0);
    Target::within(low, high)
}
