//! Fracture: finds the joints of a lattice that break, and grows cracks (O'Brien & Hodgins 1999 choose the plane of a
//! crack by the principal stress in the same way; Rivers & James 2007, section 6, break the links of a lattice).
//!
//! A joint breaks by the strain of the regions around its four corners. F of a joint is the mean of their deformation
//! gradients, and its strain is the square root of the greatest eigenvalue of FᵀF, minus 1. So the strain is a mean
//! over the width of the regions, and the load at which a body breaks depends little on how its notches lie in the
//! grid. A crack is a plane. It begins at the joint with the greatest strain relative to its limit, and grows along
//! the plane, a ring of joints in a step, where the strain along its normal, times [`TIP`], exceeds the limit.
//!
//! | file | contents |
//! |---|---|
//! | `cut` | cuts a mesh along broken joints |
//! | `options` | when joints break |
//! | `cracks` | planes, broken joints, fronts |
//! | `strains` | the strain of joints |
//! | `shells` | the mesh of a piece follows the cells of one piece |
//! | `mod` | [`Fracture`]: the stage |

mod cracks;
mod cut;
mod options;
mod shells;
mod strains;

pub(crate) use cracks::Cracks;
pub use cut::{BrokenJoint, CrackPlane, CutMesh, CutSurface, FaceSource, Origin, cut};
pub use options::{BreakLimit, FractureOptions};
pub(crate) use strains::Deformation;

use cracks::Crack;
use nalgebra::Vector3;
use strains::{CellRotations, greatest_stretch};

use crate::lattice::{Joint, Lattice, Layout};
use crate::matching::Gradients;
use crate::mesh::{Mesh, MeshError, mix};
use crate::simd::lanes::Lanes;

/// Factor of the strain along the normal of a crack at its front. The lattice resolves the concentration of the strain
/// at the front of a crack in part only.
const TIP: f64 = 1.6;

/// Ratio of a strain to its limit above which a crack begins although others can grow, or beside pins and handles. A
/// crack that has stopped prevents others only up to this strain.
const OVERLOAD: f64 = 4.0;

/// The least distance, in cells, of a new crack from broken joints; and per cell of the half-width of the regions.
const LEAST_DISTANCE: [u32; 2] = [3, 2];

/// Relative difference of strains up to which they count as equal where a crack begins. Among equal joints, the one
/// whose axis is nearest to the direction of the strain is chosen, so that rounding does not decide.
const EQUAL_STRAINS: f64 = 1e-3;

/// The stage of a body that can break.
#[derive(Clone, Debug)]
pub(crate) struct Fracture {
    /// `None` if the body is only cut. All further arrays but the cracks are then empty.
    options: Option<FractureOptions>,
    cracks: Cracks,
    /// The joints at which each crack can grow; computed after each event.
    fronts: Vec<Vec<Joint>>,
    /// Deformation gradient of each region, column by column.
    gradients: Lanes<9>,
    /// For each block, the bit mask of the lanes whose regions are stretched so far that a joint may break.
    stretched: Vec<u8>,
    /// The rotation of each cell; empty unless rotations break joints.
    rotations: CellRotations,
    /// Buffers.
    breaking: Vec<(Joint, u32)>,
    growing: Vec<(u32, u32)>,
    cells: Vec<u32>,
    candidates: Vec<Candidate>,
}

/// A joint at which a crack can begin.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    component: u32,
    /// The strain divided by the limit.
    ratio: f64,
    joint: Joint,
    /// The direction in which the joint is stretched most, at rest.
    direction: Vector3<f64>,
}

impl Fracture {
    pub(crate) fn new(options: Option<FractureOptions>, lattice: &Lattice, layout: &Layout) -> Self {
        let blocks = if options.is_some() { layout.blocks() } else { 0 };
        let is_rotation_limited = is_rotation_limited(&options);
        Self {
            options,
            cracks: Cracks::default(),
            fronts: Vec::new(),
            gradients: Lanes::zeros(blocks),
            stretched: vec![0; blocks],
            rotations: CellRotations::new(if is_rotation_limited { lattice.cells().len() } else { 0 }),
            breaking: Vec::new(),
            growing: Vec::new(),
            cells: Vec::new(),
            candidates: Vec::new(),
        }
    }

    /// Prepares for a lattice whose joints broke.
    pub(crate) fn prepare(&mut self, lattice: &Lattice, layout: &Layout) {
        let cracks = std::mem::take(&mut self.cracks);
        *self = Self { cracks, ..Self::new(self.options, lattice, layout) };
        for number in 0..self.cracks.list.len() as u32 {
            let can_grow = self.is_armed() && self.cracks.list[number as usize].can_grow;
            let front = if can_grow { self.cracks.front(lattice, number) } else { Vec::new() };
            self.cracks.list[number as usize].can_grow = !front.is_empty();
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
        self.cracks.bytes()
            + self.gradients.bytes()
            + self.stretched.len()
            + self.rotations.bytes()
            + self.breaking.capacity() * size_of::<(Joint, u32)>()
            + self.growing.capacity() * size_of::<(u32, u32)>()
            + self.cells.capacity() * size_of::<u32>()
            + self.candidates.capacity() * size_of::<Candidate>()
            + self.fronts.iter().map(|front| size_of_val(&**front)).sum::<usize>()
    }

    /// Returns where the shape matching stores the deformation gradients; `None` if the body does not break by itself.
    ///
    /// * `modulus`: the greatest Young's modulus in force.
    /// * `strength`: the least factor of the limits.
    /// * `has_values`: whether all gradients are wanted.
    pub(crate) fn gradients(
        &mut self,
        (modulus, strength): (f64, f64),
        has_values: bool,
    ) -> Option<Gradients<'_>> {
        let Self { options: Some(options), gradients, stretched, .. } = self else { return None };
        // No crack begins at a smaller stretch: the noise takes at most this fraction off the limit of a joint. Joints
        // at the fronts of cracks break at smaller strains, and are tested in each step.
        let least = 1.0 + options.strain_limit(modulus) * strength * (1.0 - options.noise);
        // A margin for the rounding of gradients in f32.
        let least = (least * (1.0 - 1e-5)) as f32;
        Some(Gradients {
            values: if has_values { gradients.blocks_mut() } else { &mut [] },
            stretched,
            least,
        })
    }

    /// Returns whether the next step needs all gradients: at the fronts of cracks, and probably where a region was
    /// stretched in the step before.
    pub(crate) fn expects_gradients(&self) -> bool {
        self.fronts.iter().any(|front| !front.is_empty()) || self.stretched.iter().any(|&lanes| lanes != 0)
    }

    /// Returns whether a joint may break in this step, so that all gradients are needed.
    pub(crate) fn needs_gradients(&self) -> bool {
        is_rotation_limited(&self.options) || self.expects_gradients()
    }

    /// Finds the joints that break. Returns whether there are any; [`Fracture::break_found`] breaks them. The shape
    /// matching has stored the [gradients](Fracture::gradients).
    pub(crate) fn find_breaking(&mut self, deformation: &Deformation) -> bool {
        self.breaking.clear();
        let Some(options) = self.options else { return false };
        let angle = options.rotation.map(f64::to_radians);
        if angle.is_some() {
            self.rotations.compute(deformation);
        }
        let limits = Limits { options: &options, angle, deformation };
        self.grow(&limits);
        self.begin(&limits);
        !self.breaking.is_empty()
    }

    /// Finds the joints at the fronts of cracks that break, and the components in which cracks can grow. A crack that
    /// has stopped can grow again.
    fn grow(&mut self, limits: &Limits) {
        let Self { cracks, fronts, gradients, rotations, breaking, growing, .. } = self;
        growing.clear();
        let lattice = limits.deformation.lattice;
        for ((number, crack), front) in (0..).zip(&cracks.list).zip(&*fronts) {
            for &joint in front.iter().filter(|joint| !limits.deformation.is_held(**joint)) {
                let strain = limits.deformation.strain_along(gradients, joint, &crack.normal());
                let ratio = limits.ratio(joint, TIP * strain, rotations);
                if ratio > 1.0 {
                    breaking.push((joint, number));
                }
                growing.push((lattice.component_of_cell(joint.cell), number));
            }
        }
        growing.sort_unstable();
        growing.dedup();
    }

    /// Begins at most one crack in each component.
    fn begin(&mut self, limits: &Limits) {
        let Self {
            cracks,
            gradients,
            stretched,
            rotations,
            growing,
            breaking,
            cells,
            candidates,
            fronts,
            ..
        } = self;
        let Deformation { lattice, half_width, .. } = limits.deformation;
        candidates.clear();
        match limits.angle {
            None => strains::cells_beside(limits.deformation, stretched, cells),
            Some(_) => {
                cells.clear();
                cells.extend(0..lattice.cells().len() as u32);
            }
        }
        let growing_in = |wanted: u32| growing.iter().filter(|(component, _)| *component == wanted).count();
        let [least, per_cell] = LEAST_DISTANCE;
        let distance = least.max(per_cell * half_width.links() as u32);
        let joints = cells.iter().flat_map(|&cell| (0..3).map(move |axis| Joint { cell, axis }));
        for joint in joints.filter(|joint| lattice.joint_cells(*joint).is_some()) {
            let stretch = greatest_stretch(&limits.deformation.gradient(gradients, joint));
            let strain = stretch.map_or(0.0, |(stretch, _)| stretch - 1.0);
            let ratio = limits.ratio(joint, strain, rotations);
            let component = lattice.component_of_cell(joint.cell);
            if ratio > 1.0
                && (ratio > OVERLOAD
                    || (growing_in(component) < limits.options.cracks
                        && !limits.deformation.is_beside_held(joint)))
                && !lattice.is_broken(joint)
                && !limits.deformation.is_held(joint)
                && !cracks.is_broken_near(lattice, joint.cell, distance)
            {
                let axis = Vector3::ith(usize::from(joint.axis), 1.0);
                let direction = stretch.map_or(axis, |(_, direction)| direction);
                candidates.push(Candidate { component, ratio, joint, direction });
            }
        }
        // The order of the joints decides among equals.
        candidates.sort_unstable_by_key(|candidate| (candidate.component, candidate.joint));
        for candidates in candidates.chunk_by(|a, b| a.component == b.component) {
            let greatest = candidates.iter().map(|candidate| candidate.ratio).fold(0.0, f64::max);
            let equal =
                candidates.iter().filter(|candidate| candidate.ratio > greatest * (1.0 - EQUAL_STRAINS));
            let alignment =
                |candidate: &&Candidate| candidate.direction[usize::from(candidate.joint.axis)].abs();
            let first = equal.rev().max_by(|a, b| alignment(a).total_cmp(&alignment(b)));
            let Some(&Candidate { joint, direction, .. }) = first else { continue };
            let mut center = Vector3::from(lattice.cells()[joint.cell as usize].map(|i| f64::from(i) + 0.5));
            center[usize::from(joint.axis)] += 0.5;
            breaking.push((joint, cracks.list.len() as u32));
            cracks.list.push(Crack::new(center.into(), direction, true));
            // It grows after the event.
            fronts.push(Vec::new());
        }
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

    /// Breaks all joints between the cells on the two sides of a plane at rest in the model's frame, with a plane for
    /// each component of the lattice. Returns whether there are any.
    pub(crate) fn cut(&mut self, lattice: &Lattice, planes: &[Option<CrackPlane>]) -> bool {
        self.cracks.cut(lattice, planes)
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

/// Returns whether joints break by the rotations of their cells.
fn is_rotation_limited(options: &Option<FractureOptions>) -> bool {
    options.is_some_and(|options| options.rotation.is_some())
}

/// The limits of joints.
struct Limits<'a> {
    options: &'a FractureOptions,
    /// Angle between the rotations of two cells at which their joint breaks, in radians.
    angle: Option<f64>,
    deformation: &'a Deformation<'a>,
}

impl Limits<'_> {
    /// Returns the strain of a joint, or the angle between its cells, relative to its limit, whichever is greater.
    fn ratio(&self, joint: Joint, strain: f64, rotations: &CellRotations) -> f64 {
        let Self { options, angle, deformation } = self;
        let modulus = deformation.modulus * deformation.factor(joint);
        let variation = 1.0 + options.noise * variation(options.seed, deformation.lattice, joint);
        let by_angle = angle.map_or(0.0, |angle| rotations.angle(deformation.lattice, joint) / angle);
        (strain / options.strain_limit(modulus)).max(by_angle) / (variation * deformation.strength(joint))
    }
}

/// Returns a number in [-1, 1) that depends on the seed and on the place of a joint in the grid.
fn variation(seed: u64, lattice: &Lattice, joint: Joint) -> f64 {
    let place = lattice.cells()[joint.cell as usize].into_iter().fold(seed, |hash, i| mix(hash, i as u64));
    let hash = mix(mix(place, u64::from(joint.axis)), 0);
    (hash >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}
