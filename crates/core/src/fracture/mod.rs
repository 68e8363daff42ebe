//! Fracture: finds the joints of a lattice that break, and grows cracks (O'Brien & Hodgins 1999 choose the plane of a
//! crack by the principal stress in the same way; Rivers & James 2007, section 6, break the links of a lattice).
//!
//! A joint breaks by the strain of the goal positions. F of a joint is the mean of the gradients of its two cells, and
//! its strain is the square root of the greatest eigenvalue of FᵀF, minus 1. A crack is a plane. It begins at the joint
//! with the greatest strain relative to its limit, and grows along the plane, a ring of joints in a step, where the
//! strain along its normal, times [`TIP`], exceeds the limit.
//!
//! | file | contents |
//! |---|---|
//! | `options` | when joints break |
//! | `cells` | finds stretched cells |
//! | `cracks` | planes, broken joints, fronts |
//! | `shells` | the mesh of a piece follows the cells of one piece |
//! | `mod` | [`Fracture`]: the stage |

mod cells;
mod cracks;
mod options;
mod shells;

pub(crate) use cracks::Cracks;
pub use options::{BreakLimit, FractureOptions};

use cells::{Cells, gradient, greatest_stretch};
use cracks::Crack;
use nalgebra::{Matrix3, Point3, Unit, UnitQuaternion, Vector3};

use crate::cut::{CutMesh, CutSurface, cut};
use crate::lattice::{Joint, Lattice, Layout};
use crate::mesh::{Mesh, MeshError, mix};
use crate::parallel::Executor;
use crate::simd::lanes::Lanes;

/// Factor of the strain along the normal of a crack at its front. The lattice resolves the concentration of the strain
/// at the front of a crack in part only.
const TIP: f64 = 1.6;

/// The least distance, in cells, of a new crack from broken joints; and per cell of the half-width of the regions.
const LEAST_DISTANCE: [u32; 2] = [3, 2];

/// Relative difference of strains up to which they count as equal where a crack begins. Among equal joints, the one
/// whose axis is nearest to the direction of the strain is chosen, so that rounding does not decide.
const EQUAL_STRAINS: f64 = 1e-3;

/// The stage of a body that can break.
#[derive(Clone, Debug)]
pub(crate) struct Fracture {
    /// `None` if the body is only cut.
    options: Option<FractureOptions>,
    cracks: Cracks,
    cells: Cells,
    /// The joints at which each crack can grow; computed after each event.
    fronts: Vec<Vec<Joint>>,
    /// Goal positions.
    goals: Lanes<3>,
    /// Buffers.
    stretched: Vec<u32>,
    breaking: Vec<(Joint, u32)>,
}

/// What the stage reads in a step.
pub(crate) struct Stretch<'a> {
    pub(crate) lattice: &'a Lattice,
    pub(crate) layout: &'a Layout,
    /// Rotation of the region around each vertex: unit quaternions (x, y, z, w).
    pub(crate) rotations: &'a Lanes<4>,
    /// Half-width of the regions in cells.
    pub(crate) half_width: usize,
    /// Young's modulus in force.
    pub(crate) modulus: f64,
    /// Whether each lattice vertex is held by a pin or handle; empty if none is.
    pub(crate) held: &'a [bool],
}

impl Fracture {
    pub(crate) fn new(options: Option<FractureOptions>, lattice: &Lattice, layout: &Layout) -> Self {
        let is_armed = options.is_some();
        Self {
            options,
            cracks: Cracks::default(),
            cells: Cells::new(lattice, layout),
            fronts: Vec::new(),
            goals: Lanes::zeros(if is_armed { layout.blocks() } else { 0 }),
            stretched: Vec::with_capacity(if is_armed { lattice.cells().len() } else { 0 }),
            breaking: Vec::new(),
        }
    }

    /// Prepares for a lattice whose joints broke.
    pub(crate) fn prepare(&mut self, lattice: &Lattice, layout: &Layout) {
        let (cracks, breaking) = (std::mem::take(&mut self.cracks), std::mem::take(&mut self.breaking));
        *self = Self { cracks, breaking, ..Self::new(self.options, lattice, layout) };
        self.breaking.clear();
        for number in 0..self.cracks.list.len() as u32 {
            let is_growing = self.cracks.list[number as usize].is_growing;
            let front = if is_growing { self.cracks.front(lattice, number) } else { Vec::new() };
            self.cracks.list[number as usize].is_growing = !front.is_empty();
            self.fronts.push(front);
        }
    }

    /// Returns the options; `None` if the body breaks only where it is cut.
    pub(crate) fn options(&self) -> Option<&FractureOptions> {
        self.options.as_ref()
    }

    /// Returns whether the body breaks by itself.
    pub(crate) fn is_armed(&self) -> bool {
        self.options.is_some()
    }

    /// Returns the state.
    pub(crate) fn cracks(&self) -> &Cracks {
        &self.cracks
    }

    /// Replaces the state. [`Fracture::prepare`] must follow.
    pub(crate) fn set_cracks(&mut self, cracks: Cracks) {
        self.cracks = cracks;
    }

    /// Returns the memory in bytes.
    pub(crate) fn bytes(&self) -> usize {
        self.cells.bytes()
            + self.cracks.bytes()
            + self.goals.bytes()
            + self.stretched.capacity() * size_of::<u32>()
            + self.breaking.capacity() * size_of::<(Joint, u32)>()
            + self.fronts.iter().map(|front| size_of_val(&**front)).sum::<usize>()
    }

    /// Returns the buffer of the goal positions.
    pub(crate) fn goals_mut(&mut self) -> &mut Lanes<3> {
        &mut self.goals
    }

    /// Finds the joints that break at the goal positions. Returns whether there are any; [`Fracture::break_found`]
    /// breaks them.
    pub(crate) fn find_breaking(
        &mut self,
        stretch: &Stretch,
        executor: &Executor,
        task_blocks: &[usize],
    ) -> bool {
        self.breaking.clear();
        let Some(options) = self.options else { return false };
        let limit = options.strain_limit(stretch.modulus);
        self.stretched.clear();
        // No crack begins at a smaller stretch: the noise takes at most this fraction off the limit of a joint. The
        // joints at the fronts of cracks, which break at smaller strains, are all tested.
        let least = 1.0 + limit * (1.0 - options.noise);
        match options.rotation {
            None => self.cells.find_stretched(
                (stretch.layout, &self.goals),
                least as f32,
                (executor, task_blocks),
                &mut self.stretched,
            ),
            Some(_) => self.stretched.extend(0..stretch.lattice.cells().len() as u32),
        }
        let Self { cracks, fronts, goals, stretched, breaking, .. } = self;
        let goals = Goals { stretch, goals };
        let limit_of =
            |joint: Joint| limit * (1.0 + options.noise * variation(options.seed, stretch.lattice, joint));
        for ((number, crack), front) in (0..).zip(&cracks.list).zip(&*fronts) {
            for &joint in front {
                let strain = goals.strain_along(joint, &crack.normal());
                if TIP * strain > limit_of(joint) && !goals.is_held(joint) {
                    breaking.push((joint, number));
                }
            }
        }
        let angle = options.rotation.map(f64::to_radians);
        if let Some(crack) = begin(cracks, fronts, &goals, stretched, (&limit_of, angle, options.cracks)) {
            let number = cracks.list.len() as u32;
            breaking.push((crack.1, number));
            cracks.list.push(crack.0);
            // It grows after the event.
            fronts.push(Vec::new());
        }
        !breaking.is_empty()
    }

    /// Breaks the joints that were found.
    pub(crate) fn break_found(&mut self) {
        let mut breaking = std::mem::take(&mut self.breaking);
        breaking.sort_unstable();
        breaking.dedup_by_key(|(joint, _)| *joint);
        self.cracks.break_joints(&breaking);
        breaking.clear();
        self.breaking = breaking;
    }

    /// Breaks all joints between the cells on the two sides of a plane. `point` and `normal`: the plane at rest in the
    /// model's frame. Returns whether there are any.
    pub(crate) fn cut(&mut self, lattice: &Lattice, point: Point3<f64>, normal: Unit<Vector3<f64>>) -> bool {
        let in_grid = Point3::from((point - lattice.origin()) / lattice.cell_size());
        let crack = Crack::new(in_grid, normal.into_inner(), false);
        let number = self.cracks.list.len() as u32;
        let joints: Vec<_> =
            self.cracks.on_plane(lattice, &crack).into_iter().map(|joint| (joint, number)).collect();
        if joints.is_empty() {
            return false;
        }
        self.cracks.list.push(crack);
        self.cracks.break_joints(&joints);
        true
    }

    /// Cuts the mesh of the whole body along the broken joints.
    ///
    /// # Errors
    /// See [`cut`].
    pub(crate) fn cut_mesh(&self, mesh: &Mesh, lattice: &Lattice) -> Result<CutMesh, MeshError> {
        let planes: Vec<_> = self.cracks.list.iter().map(|crack| crack.plane(lattice)).collect();
        let surface = self.options.map_or(CutSurface::default(), |options| options.surface);
        let joints = self.cracks.cuts();
        let mut cut = cut(mesh, lattice, &joints, &planes, surface)?;
        shells::follow_one_piece(&mut cut, lattice);
        Ok(cut)
    }
}

/// Chooses the joint at which a crack begins, with the crack; `None` if there is none. `limit_of` returns the strain
/// limit of a joint; then the limit of the angle between its cells, and the greatest number of cracks that grow in a
/// component.
fn begin(
    cracks: &Cracks,
    fronts: &[Vec<Joint>],
    goals: &Goals,
    stretched: &[u32],
    (limit_of, angle, greatest_number): (&impl Fn(Joint) -> f64, Option<f64>, usize),
) -> Option<(Crack, Joint)> {
    let lattice = goals.stretch.lattice;
    let component = |cell: u32| lattice.component_of_cell(cell);
    let growing_in = |wanted: u32| {
        fronts
            .iter()
            .filter_map(|front| front.first())
            .filter(|joint| component(joint.cell) == wanted)
            .count()
    };
    let [least, per_cell] = LEAST_DISTANCE;
    let distance = least.max(per_cell * goals.stretch.half_width as u32);
    let mut candidates: Vec<(f64, Joint, Vector3<f64>)> = Vec::new();
    let mut greatest = 1.0;
    for &cell in stretched {
        if growing_in(component(cell)) >= greatest_number {
            continue;
        }
        for side in 0..6 {
            let Some(other) = lattice.joined_cell(cell, side) else { continue };
            let joint = Joint { cell: if side % 2 == 1 { cell } else { other }, axis: (side / 2) as u8 };
            let (stretch, direction) = greatest_stretch(&goals.gradient(joint));
            let turn = angle.map_or(0.0, |angle| goals.angle(joint) / angle);
            let ratio = ((stretch - 1.0) / limit_of(joint)).max(turn);
            if ratio > greatest * (1.0 - EQUAL_STRAINS) && ratio > 1.0 && !goals.is_held(joint) {
                greatest = ratio.max(greatest);
                candidates.push((ratio, joint, direction));
            }
        }
    }
    candidates.retain(|(ratio, joint, _)| {
        *ratio > greatest * (1.0 - EQUAL_STRAINS) && !cracks.is_broken_near(lattice, joint.cell, distance)
    });
    let alignment = |joint: Joint, direction: &Vector3<f64>| direction[usize::from(joint.axis)].abs();
    let (_, joint, direction) = candidates.into_iter().max_by(|a, b| {
        let [x, y] = [a, b].map(|(_, joint, direction)| alignment(*joint, direction));
        x.total_cmp(&y).then(b.1.cmp(&a.1))
    })?;
    let mut center = Vector3::from(lattice.cells()[joint.cell as usize].map(|i| f64::from(i) + 0.5));
    center[usize::from(joint.axis)] += 0.5;
    Some((Crack::new(center.into(), direction, true), joint))
}

/// Returns a number in [-1, 1) that depends on the seed and on the place of a joint in the grid.
fn variation(seed: u64, lattice: &Lattice, joint: Joint) -> f64 {
    let place = lattice.cells()[joint.cell as usize].into_iter().fold(seed, |hash, i| mix(hash, i as u64));
    let hash = mix(mix(place, u64::from(joint.axis)), 0);
    (hash >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

/// The goal positions of a lattice, and what joints have there.
struct Goals<'a> {
    stretch: &'a Stretch<'a>,
    goals: &'a Lanes<3>,
}

impl Goals<'_> {
    /// Returns the cells of a joint.
    fn cells(&self, joint: Joint) -> [u32; 2] {
        let other = self.stretch.lattice.cell_beyond(joint.cell, joint.axis, 1);
        [joint.cell, other.unwrap_or(joint.cell)]
    }

    /// Returns the mean of the gradients of the cells of a joint.
    fn gradient(&self, joint: Joint) -> Matrix3<f64> {
        let Stretch { lattice, layout, .. } = self.stretch;
        let of_cell =
            |cell: u32| {
                gradient(&lattice.cell_corners(cell).map(|corner| {
                    Vector3::from(self.goals.get(layout.slots()[corner as usize]).map(f64::from))
                }))
            };
        let [a, b] = self.cells(joint).map(of_cell);
        (a + b) * 0.5
    }

    /// Returns the strain of a joint along a direction at rest.
    fn strain_along(&self, joint: Joint, direction: &Vector3<f64>) -> f64 {
        (self.gradient(joint) * direction).norm() - 1.0
    }

    /// Returns the angle between the rotations of the cells of a joint, in radians.
    fn angle(&self, joint: Joint) -> f64 {
        let Stretch { lattice, layout, rotations, .. } = self.stretch;
        let of_cell = |cell: u32| {
            let corners = lattice.cell_corners(cell);
            let quaternion = |corner: u32| {
                nalgebra::Vector4::from(rotations.get(layout.slots()[corner as usize]).map(f64::from))
            };
            let first = quaternion(corners[0]);
            let sum: nalgebra::Vector4<f64> =
                corners.iter().map(|&corner| quaternion(corner)).map(|q| q * q.dot(&first).signum()).sum();
            UnitQuaternion::new_normalize(nalgebra::Quaternion::from(sum))
        };
        let [a, b] = self.cells(joint).map(of_cell);
        a.angle_to(&b)
    }

    /// Returns whether pins or handles hold all corners of the cells of a joint.
    fn is_held(&self, joint: Joint) -> bool {
        let Stretch { lattice, held, .. } = self.stretch;
        let is_held = |corner: u32| held.get(corner as usize).copied().unwrap_or(false);
        self.cells(joint).into_iter().all(|cell| lattice.cell_corners(cell).into_iter().all(is_held))
    }
}
