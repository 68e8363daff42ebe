//! What the author of a scene probably does not expect: found before the first step, and printed by `run` and `inspect`.

use std::fmt;

use nalgebra::{Point3, Vector3};

use super::deviation::four_digits;
use super::overlap::Overlap;
use crate::count::counted;
use crate::escape::Escaped;
use supple::{Body, Elasticity, Interior, Shape, Simulation};

/// Compression at the base of a body by a weight, as the weight per area over Young's modulus, above which a caution says
/// so. At 1/2 linear elasticity loses its meaning: the base has half of its height left.
const GREATEST_COMPRESSION: f64 = 0.5;

/// Length of an edge in cells from which on a face is large.
const LARGE_EDGE: f64 = 3.0;

/// Share of the area in large faces from which on a caution says so.
const LARGE_SHARE: f64 = 0.5;

/// Number of cells of a bridge from which on a caution says so: eyes and teeth are nearer to a head.
const LONG_BRIDGE: usize = 4;

/// Distance that a handle moves its vertices within one step, in cells, from which on a caution says so.
const JUMP: f64 = 0.5;

/// Distance of neighboring `f32` at the coordinates of a body, in cells, from which on a caution says so: positions that
/// are off by it strain a cell by 0.1 %.
const COARSE_NUMBERS: f64 = 1e-3;

/// Distance from the origin, in extents of the body, beyond which a position is probably a mistake. Neighboring `f32` then
/// differ by more than a twentieth of the body.
const FAR: f64 = 1e6;

/// A property of a scene that its author probably does not expect. The message names the body, the numbers and the way out.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Caution {
    /// Two bodies overlap at the start.
    Overlap(Overlap),
    /// A body begins inside a closed mesh collider.
    InCollider {
        /// Name of the body.
        body: String,
        /// Index of the collider.
        collider: usize,
    },
    /// A weight compresses the base of a body to less than half of its height.
    TooSoft {
        /// Name of the body.
        body: String,
        /// Name of the body above it whose weight it is; `None` for its own weight.
        load: Option<String>,
        /// Young's modulus in force.
        modulus: f64,
        /// Young's modulus that carries the weight.
        needed: f64,
    },
    /// A handle with a start after 0 moves its vertices at once when it becomes active.
    Jump {
        /// Name of the body.
        body: String,
        /// Index of the constraint of the body.
        constraint: usize,
        /// Time in seconds.
        time: f64,
        /// Distance in scene units.
        distance: f64,
    },
    /// Parts of a body that lie far apart are joined by a bridge of cells.
    Bridge {
        /// Name of the body.
        body: String,
        /// Number of such parts.
        parts: usize,
        /// Length of the longest bridge in scene units.
        length: f64,
    },
    /// The displayed surface can't bend like the lattice, because its faces are much larger than the cells.
    LargeFaces {
        /// Name of the body.
        body: String,
        /// Length of the longest edge in scene units.
        edge: f64,
        /// Edge of a cell in scene units.
        cell_size: f64,
    },
    /// Neighboring numbers of the frames differ by a visible part of a cell at the coordinates of a body.
    CoarseNumbers {
        /// Name of the body.
        body: String,
        /// Distance of the numbers.
        spacing: f64,
        /// Greatest coordinate.
        coordinate: f64,
        /// Edge of a cell.
        cell_size: f64,
        /// Longest side of the bounding box of the body.
        extent: f64,
        /// Distance of the bounding box from the origin.
        from_origin: f64,
    },
    /// The surface of a body is not closed.
    NotClosed {
        /// Name of the body.
        body: String,
        /// Rule by which points are inside.
        interior: Interior,
        /// Mass of the body.
        mass: f64,
    },
}

impl Caution {
    /// Returns the cautions about a simulation at its start.
    pub fn all(simulation: &mut Simulation) -> Vec<Self> {
        let mut cautions = Vec::new();
        let loads = Loads::of(simulation);
        for (index, body) in simulation.bodies().iter().enumerate() {
            let modulus = simulation.body(index).youngs_modulus();
            cautions.extend(not_closed(body));
            cautions.extend(bridge(body));
            cautions.extend(large_faces(body));
            cautions.extend(coarse_numbers(body));
            cautions.extend(jumps(body));
            cautions.extend(in_colliders(simulation, body));
            let too_soft = |(loads, modulus)| too_soft(body, loads, index, modulus);
            cautions.extend(loads.as_ref().zip(modulus).and_then(too_soft));
        }
        cautions.extend(Overlap::all(simulation).into_iter().map(Self::Overlap));
        cautions
    }

    /// Returns whether the scene is probably a mistake; otherwise the caution only says what the program does.
    pub fn is_warning(&self) -> bool {
        !matches!(self, Self::NotClosed { .. })
    }
}

/// The weights of the bodies of a simulation, and where they stand.
struct Loads<'a> {
    /// The direction against gravity.
    up: Vector3<f64>,
    gravity: f64,
    /// Empty if bodies do not touch each other.
    bodies: Vec<Load<'a>>,
}

/// A body that may lie on another one or carry it.
struct Load<'a> {
    body: &'a Body,
    /// The bounding box of its lattice vertices.
    bounds: (Vector3<f64>, Vector3<f64>),
    /// Coordinate of its center of mass along `up`.
    level: f64,
}

impl<'a> Loads<'a> {
    /// Returns the loads, or `None` without gravity.
    fn of(simulation: &'a Simulation) -> Option<Self> {
        let gravity = Vector3::from(simulation.gravity());
        let magnitude = gravity.norm();
        let up = (magnitude > 0.0).then(|| gravity / -magnitude)?;
        let load = |body: &'a Body| {
            let level = body.center_of_mass().coords.dot(&up);
            Load { body, bounds: bounds(body), level }
        };
        let touching = if simulation.contact() { simulation.bodies() } else { &[] };
        Some(Self { up, gravity: magnitude, bodies: touching.iter().map(load).collect() })
    }

    /// Iterates over the bodies that may come to lie on the body `index`: those above it that it touches, and whose boxes
    /// overlap with its own when they are moved along the vertical.
    fn above(&self, index: usize) -> impl Iterator<Item = &'a Body> {
        let own = self.bodies.get(index);
        let above =
            self.bodies.iter().filter(move |other| own.is_some_and(|own| other.is_above(own, &self.up)));
        above.map(|load| load.body)
    }
}

impl Load<'_> {
    /// Returns whether the body may come to lie on another one.
    fn is_above(&self, other: &Self, up: &Vector3<f64>) -> bool {
        let ((low, high), (other_low, other_high)) = (&self.bounds, &other.bounds);
        let overlaps =
            (0..3).all(|a| up[a].abs() > 0.5 || (low[a] < other_high[a] && high[a] > other_low[a]));
        let ignores = |a: &Self, b: &Self| a.body.touching().ignored.iter().any(|name| name == b.body.name());
        self.level > other.level && overlaps && !ignores(self, other) && !ignores(other, self)
    }
}

/// Returns the bounding box of the lattice vertices.
fn bounds(body: &Body) -> (Vector3<f64>, Vector3<f64>) {
    let (low, high) = body.bounds();
    (low.coords, high.coords)
}

/// Returns the extent of a body along `up`.
fn height(body: &Body, up: &Vector3<f64>) -> f64 {
    let levels = body.positions();
    let levels = levels.iter().map(|p| p.coords.dot(up));
    let (low, high) = levels.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
    high - low
}

/// Finds the weight that compresses the body `index` most: its own, or that of a body above it. The elasticity of regions
/// has no modulus that a scene could raise.
fn too_soft(body: &Body, loads: &Loads, index: usize, modulus: f64) -> Option<Caution> {
    if matches!(body.material().elasticity, Elasticity::Regions { .. }) {
        return None;
    }
    let (density, height) = (body.material().density, height(body, &loads.up));
    // The area of the base.
    let area = body.mass() / (density * height);
    let own = (None, density * loads.gravity * height);
    let others = loads.above(index).map(|other| (Some(other), other.mass() * loads.gravity / area));
    let (load, pressure) = std::iter::once(own).chain(others).max_by(|a, b| a.1.total_cmp(&b.1))?;
    let needed = pressure / GREATEST_COMPRESSION;
    (modulus < needed).then(|| Caution::TooSoft {
        body: body.name().to_owned(),
        load: load.map(|other| other.name().to_owned()),
        modulus,
        needed,
    })
}

fn jumps(body: &Body) -> impl Iterator<Item = Caution> {
    let least = JUMP * body.lattice().cell_size();
    body.constraints().filter_map(move |constraint| {
        let (time, distance) = constraint.jump(body.lattice().cell_size())?;
        let body = body.name().to_owned();
        (time > 0.0 && distance > least).then(|| Caution::Jump {
            body,
            constraint: constraint.index(),
            time,
            distance,
        })
    })
}

fn bridge(body: &Body) -> Option<Caution> {
    let bridges = body.lattice().report().floating.iter().map(|part| part.bridge_cells);
    let long: Vec<usize> = bridges.filter(|cells| *cells >= LONG_BRIDGE).collect();
    let length = *long.iter().max()? as f64 * body.lattice().cell_size();
    Some(Caution::Bridge { body: body.name().to_owned(), parts: long.len(), length })
}

fn large_faces(body: &Body) -> Option<Caution> {
    if body.is_rigid() {
        return None;
    }
    let (mesh, cell_size) = (body.mesh()?, body.lattice().cell_size());
    let (mut total, mut large, mut longest) = (0.0, 0.0, 0.0_f64);
    for triangle in mesh.triangles() {
        let [a, b, c] = triangle.map(|vertex| mesh.vertices()[vertex as usize]);
        let area = (b - a).cross(&(c - a)).norm();
        let edge = (b - a).norm().max((c - b).norm()).max((a - c).norm());
        total += area;
        large += if edge > LARGE_EDGE * cell_size { area } else { 0.0 };
        longest = longest.max(edge);
    }
    let body = body.name().to_owned();
    (large > LARGE_SHARE * total).then_some(Caution::LargeFaces { body, edge: longest, cell_size })
}

fn coarse_numbers(body: &Body) -> Option<Caution> {
    let ((low, high), cell_size) = (bounds(body), body.lattice().cell_size());
    let coordinate = low.amax().max(high.amax());
    let spacing = spacing(coordinate);
    let outside = low.sup(&-high).map(|x| x.max(0.0));
    let (extent, from_origin) = ((high - low).amax(), outside.norm());
    let body = body.name().to_owned();
    let caution = Caution::CoarseNumbers { body, spacing, coordinate, cell_size, extent, from_origin };
    (spacing > COARSE_NUMBERS * cell_size).then_some(caution)
}

/// Returns the distance of the magnitude `value` to the next greater `f32`.
fn spacing(value: f64) -> f64 {
    let value = (value as f32).min(f32::MAX / 2.0);
    f64::from(f32::from_bits(value.to_bits() + 1) - value)
}

/// Finds the closed mesh colliders that all vertices of a body are in.
fn in_colliders(simulation: &Simulation, body: &Body) -> Vec<Caution> {
    let positions = body.positions();
    let encloses = |index: &usize| {
        let collider = simulation.collider(*index).description();
        let is_closed = matches!(&collider.shape, Shape::Mesh { mesh, .. } if mesh.is_closed());
        if !(is_closed && collider.enabled.value(0.0)) {
            return false;
        }
        let Ok(distance) = collider.signed_distance_at(0.0) else { return false };
        positions.iter().all(|position: &Point3<f64>| distance((*position).into()) < 0.0)
    };
    let body = body.name();
    let found = (0..simulation.collider_count()).filter(encloses);
    found.map(|collider| Caution::InCollider { body: body.to_owned(), collider }).collect()
}

fn not_closed(body: &Body) -> Option<Caution> {
    let interior = body.mesh()?.interior();
    let (body, mass) = (body.name().to_owned(), body.mass());
    (interior != Interior::Closed).then_some(Caution::NotClosed { body, interior, mass })
}

/// Returns why the numbers of frames are coarse beside the cells of a body, and what makes them finer.
fn finer_numbers(extent: f64, from_origin: f64) -> String {
    if from_origin > FAR * extent {
        let (distance, times) = (four_digits(from_origin), four_digits(from_origin / extent));
        format!(
            "it is {distance} from the origin, {times} times its extent; check `translate` and the unit of the mesh"
        )
    } else if from_origin > extent {
        "move it nearer to the origin with `translate`".to_owned()
    } else {
        "its cells are too small for its size; choose a larger `cell_size` or fewer `lattice_vertices`"
            .to_owned()
    }
}

impl fmt::Display for Caution {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Overlap(overlap) => overlap.fmt(f),
            Self::InCollider { body, collider } => write!(
                f,
                "body {}: it begins inside the closed mesh of collider.{collider}, which pushes it out; if the mesh is a \
                 room, set `inside = true` of the collider",
                Escaped(body)
            ),
            Self::TooSoft { body, load, modulus, needed } => {
                let (body, modulus, needed) = (Escaped(body), four_digits(*modulus), four_digits(*needed));
                let weight = match load {
                    None => "its own weight".to_owned(),
                    Some(load) => format!("the weight of body {}", Escaped(load)),
                };
                write!(
                    f,
                    "body {body}: {weight} crushes it at a Young's modulus of {modulus}: frames take long, and volumes \
                     are not kept; `youngs_modulus` of {needed} or more carries it"
                )
            }
            Self::Jump { body, constraint, time, distance } => write!(
                f,
                "body {}: hold {constraint} jumps by {} at {time} s, when it becomes active; times of `keys` count from \
                 the start of the simulation, not from `start`: add {time} to them, or remove `start`",
                Escaped(body),
                four_digits(*distance)
            ),
            Self::Bridge { body, parts, length } => write!(
                f,
                "body {}: invisible bridges join {} of its mesh that {} apart, the longest {} along its cells; to separate \
                 them, make a body of each (`object`), or set `join = false`",
                Escaped(body),
                counted(*parts, "part"),
                if *parts == 1 { "lies" } else { "lie" },
                four_digits(*length)
            ),
            Self::LargeFaces { body, edge, cell_size } => write!(
                f,
                "body {}: edges of its mesh are up to {} long, and cells {}: the surface shows no bend between its \
                 vertices; set `refine = \"auto\"`, which gives the frames more vertices, or choose a larger `cell_size`",
                Escaped(body),
                four_digits(*edge),
                four_digits(*cell_size)
            ),
            Self::CoarseNumbers { body, spacing, coordinate, cell_size, extent, from_origin } => {
                let [spacing, coordinate, cell_size] =
                    [spacing, coordinate, cell_size].map(|x| four_digits(*x));
                write!(
                    f,
                    "body {}: frames have 32-bit numbers, which are {spacing} apart at the coordinate {coordinate}, and a \
                     cell has the size {cell_size}: {}",
                    Escaped(body),
                    finer_numbers(*extent, *from_origin)
                )
            }
            Self::NotClosed { body, interior, mass } => {
                let (body, mass) = (Escaped(body), four_digits(*mass));
                match interior {
                    Interior::Sheet => write!(
                        f,
                        "body {body}: its surface is a sheet, and the cells that it enters are full: mass {mass}"
                    ),
                    _ => write!(
                        f,
                        "body {body}: its surface is not closed; points with a winding number above 1/2 are inside: mass \
                         {mass}"
                    ),
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_spacing_of_f32_is_a_power_of_two() {
        assert_eq!([1.0, 1.9, 1000.0, 1e6].map(spacing), [-23, -23, -14, -4].map(|power| 2_f64.powi(power)));
        assert!(spacing(1e300).is_finite() && spacing(0.0) > 0.0);
    }
}
