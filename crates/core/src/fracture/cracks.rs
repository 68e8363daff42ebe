//! Cracks: planes along which joints break, and their growth.

use nalgebra::{Point3, Vector3};

use super::cut::{BrokenJoint, CrackPlane};
use crate::lattice::{Joint, Lattice};
use crate::mesh::distinct;

/// A crack. Coordinates are grid indices of the lattice: cell sizes from its origin, at rest.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Crack {
    /// A point of the plane.
    point: [f64; 3],
    /// Unit normal of the plane.
    normal: [f64; 3],
    /// Whether the crack can still grow.
    pub(super) can_grow: bool,
}

impl Crack {
    pub(super) fn new(point: Point3<f64>, normal: Vector3<f64>, can_grow: bool) -> Self {
        Self { point: point.into(), normal: normal.into(), can_grow }
    }

    pub(super) fn normal(&self) -> Vector3<f64> {
        self.normal.into()
    }

    /// Returns the plane in the model's frame.
    pub(super) fn plane(&self, lattice: &Lattice) -> CrackPlane {
        let point = lattice.origin() + Vector3::from(self.point) * lattice.cell_size();
        CrackPlane { point, normal: self.normal() }
    }

    /// Returns whether the numbers are finite and the normal has the length 1, up to rounding.
    fn is_valid(&self) -> bool {
        self.point.iter().all(|x| x.is_finite()) && (self.normal().norm() - 1.0).abs() < 1e-6
    }
}

/// The cracks of a body and the joints that they broke: the state of fracture.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Cracks {
    pub(super) list: Vec<Crack>,
    /// The broken joints, sorted, with the crack of each.
    broken: Vec<(Joint, u32)>,
    /// Number of events: steps or cuts in which joints broke.
    events: u64,
}

impl Cracks {
    /// Returns the number of broken joints.
    pub(crate) fn broken_count(&self) -> usize {
        self.broken.len()
    }

    /// Returns the number of events: steps or cuts in which joints broke.
    pub(crate) fn event_count(&self) -> u64 {
        self.events
    }

    /// Returns the lattice in which exactly the joints of the cracks are broken.
    pub(crate) fn broken_lattice(&self, lattice: &Lattice) -> Lattice {
        let joints: Vec<Joint> = self.broken.iter().map(|(joint, _)| *joint).collect();
        lattice.with_broken_joints(&joints)
    }

    /// Returns the broken joints as the cut of the mesh takes them.
    pub(super) fn cuts(&self) -> Vec<BrokenJoint> {
        let cut = |&(Joint { cell, axis }, crack): &(Joint, u32)| BrokenJoint { cell, axis, crack };
        self.broken.iter().map(cut).collect()
    }

    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.list) + size_of_val(&*self.broken)
    }

    /// Breaks all joints that hold between cells on the two sides of a plane, with a plane for each component; `None`
    /// leaves a component as it is. Returns whether there are any.
    pub(super) fn cut(&mut self, lattice: &Lattice, planes: &[Option<CrackPlane>]) -> bool {
        let in_grid: Vec<_> = planes.iter().map(|plane| plane.map(|plane| plane.in_grid(lattice))).collect();
        let mut numbers = vec![None; planes.len()];
        let mut joints = Vec::new();
        for (joint, _) in lattice.joints() {
            let component = lattice.component_of_cell(joint.cell) as usize;
            let (Some(plane), Some(grid_plane)) = (&planes[component], &in_grid[component]) else { continue };
            let face = (lattice.cells()[joint.cell as usize], joint.axis.into());
            if lattice.is_broken(joint) || !grid_plane.is_between(0, face) {
                continue;
            }
            let number = *numbers[component].get_or_insert_with(|| {
                let point = Point3::from((plane.point - lattice.origin()) / lattice.cell_size());
                self.list.push(Crack::new(point, plane.normal, false));
                self.list.len() as u32 - 1
            });
            joints.push((joint, number));
        }
        if joints.is_empty() {
            return false;
        }
        self.break_joints(&joints);
        true
    }

    /// Breaks joints, in any order, of which none is broken.
    pub(super) fn break_joints(&mut self, joints: &[(Joint, u32)]) {
        self.broken.extend_from_slice(joints);
        self.broken.sort_unstable();
        self.events = self.events.saturating_add(1);
    }

    /// Checks deserialized data for a lattice.
    pub(crate) fn fits(&self, lattice: &Lattice) -> bool {
        let exists = |joint: &Joint| {
            (joint.cell as usize) < lattice.cells().len()
                && joint.axis < 3
                && lattice.joint_cells(*joint).is_some()
        };
        (self.broken.is_empty() || self.events > 0)
            && self.broken.is_sorted_by(|a, b| a.0 < b.0)
            && self.broken.iter().all(|(joint, crack)| exists(joint) && (*crack as usize) < self.list.len())
            && self.list.iter().all(Crack::is_valid)
    }

    /// Finds the front of a crack: the joints on its plane that hold and have a lattice vertex in common with a joint
    /// that it broke. Sorted.
    pub(super) fn front(&self, lattice: &Lattice, number: u32) -> Vec<Joint> {
        let plane = self.list[number as usize].plane(lattice).in_grid(lattice);
        let mut front = Vec::new();
        for &(joint, _) in self.broken.iter().filter(|(_, crack)| *crack == number) {
            let Some(cells) = lattice.joint_cells(joint) else { continue };
            let corners = cells.map(|cell| lattice.cell_corners(cell));
            let index = lattice.cells()[joint.cell as usize];
            for k in 0..27 {
                let offset = [k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1];
                let Some(cell) = lattice.cell_at(std::array::from_fn(|a| index[a] + offset[a])) else {
                    continue;
                };
                for axis in 0..3 {
                    let near = Joint { cell, axis };
                    if lattice.joint_cells(near).is_none()
                        || lattice.is_broken(near)
                        || !plane.is_between(0, (lattice.cells()[cell as usize], axis.into()))
                    {
                        continue;
                    }
                    let face = lattice.joint_corners(near);
                    if face.iter().any(|corner| corners.iter().any(|cell| cell.contains(corner))) {
                        front.push(near);
                    }
                }
            }
        }
        distinct(front)
    }

    /// Returns whether a joint is broken within `distance` cells of a cell, along each axis.
    pub(super) fn is_broken_near(&self, lattice: &Lattice, cell: u32, distance: u32) -> bool {
        let cells = lattice.cells();
        let index = cells[cell as usize];
        self.broken.iter().any(|(joint, _)| {
            let other = cells[joint.cell as usize];
            (0..3).all(|a| index[a].abs_diff(other[a]) <= distance)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn broken_joints_need_an_event_and_the_count_of_events_has_an_end() {
        let lattice = Lattice::from_cells(&[[0, 0, 0], [1, 0, 0]], 1.0, Point3::origin(), false).unwrap();
        let list = vec![Crack::new(Point3::new(1.0, 0.5, 0.5), Vector3::x(), false)];
        let joint = (Joint { cell: 0, axis: 0 }, 0);
        let mut cracks = Cracks { list, broken: vec![joint], events: 0 };
        assert!(!cracks.fits(&lattice));
        cracks.events = u64::MAX;
        assert!(cracks.fits(&lattice));
        cracks.broken.clear();
        cracks.break_joints(&[joint]);
        assert_eq!(cracks.events, u64::MAX);
    }
}
