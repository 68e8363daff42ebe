//! Determines which shells of a closed surface bound the body. A shell is a connected component of the
//! surface. A nested shell is ignored or bounds a cavity, depending on its orientation.

use nalgebra::{Point3, Vector3, center};

use crate::mesh::{Csr, signed_volume};

/// Number of vertices of a shell that are tested to decide whether the shell lies inside another shell. The
/// majority decides.
const SAMPLES: usize = 15;

/// Maximum number of bins of a [`Winding`] grid along either axis.
const MAX_BINS: usize = 512;

/// Connected component of a closed surface.
pub(super) struct Shell {
    /// Triangles, in the orientation of the mesh.
    pub(super) triangles: Vec<[u32; 3]>,
    /// Lattice component that contains the shell.
    pub(super) component: u32,
    /// Signed volume, in cubed scene units.
    pub(super) volume: f64,
    /// Low and high corner of the AABB.
    aabb: (Point3<f64>, Point3<f64>),
}

impl Shell {
    pub(super) fn new(vertices: &[Point3<f64>], triangles: Vec<[u32; 3]>, component: u32) -> Self {
        let corners = || triangles.iter().flatten().map(|&corner| vertices[corner as usize]);
        let first = vertices[triangles[0][0] as usize];
        let aabb = corners().fold((first, first), |(low, high), x| (low.inf(&x), high.sup(&x)));
        let middle = center(&aabb.0, &aabb.1);
        let volume = signed_volume(&triangles, |corner| vertices[corner as usize] - middle);
        Self { triangles, component, volume, aabb }
    }

    /// Returns whether `other` may lie inside this shell: both are in the same lattice component, and their
    /// AABBs overlap.
    fn may_contain(&self, other: &Self) -> bool {
        self.component == other.component
            && (0..3).all(|k| self.aabb.0[k] <= other.aabb.1[k] && other.aabb.0[k] <= self.aabb.1[k])
    }

    /// Returns whether most of the tested vertices of this shell lie inside another shell. `winding`: winding
    /// number of the other shell.
    fn lies_within(&self, winding: &Winding<'_>, vertices: &[Point3<f64>]) -> bool {
        let count = SAMPLES.min(self.triangles.len());
        let inside = (0..count).filter(|sample| {
            let triangle = self.triangles[sample * self.triangles.len() / count];
            winding.number(&vertices[triangle[0] as usize]) != 0
        });
        2 * inside.count() > count
    }
}

/// Returns the sign of each shell, by which its signed volume is multiplied in the volume of the body: `1`,
/// `-1`, or `0` for an ignored shell.
///
/// An outermost shell gets the sign that makes its volume positive. An inner shell with the orientation of
/// the shell around it is ignored, because the volume of the outer shell contains its volume (for example, an
/// eye in a head). An inner shell with the opposite orientation bounds a cavity, and its volume is
/// subtracted. For a shell inside a cavity, the shell of the cavity is the outer shell, and the same rules
/// apply.
pub(super) fn signs(vertices: &[Point3<f64>], shells: &[Shell]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..shells.len()).collect();
    order.sort_by(|&a, &b| shells[b].volume.abs().total_cmp(&shells[a].volume.abs()));
    let mut signs = vec![0.0; shells.len()];
    let mut windings: Vec<Option<Winding<'_>>> = (0..shells.len()).map(|_| None).collect();
    for (rank, &index) in order.iter().enumerate() {
        let shell = &shells[index];
        // The smallest enclosing shell decides: the last enclosing shell in descending order of volume.
        let enclosing = order[..rank].iter().rev().copied().find(|&outer| {
            signs[outer] != 0.0 && shells[outer].may_contain(shell) && {
                let outer_shell = &shells[outer];
                let winding = windings[outer]
                    .get_or_insert_with(|| Winding::new(vertices, &outer_shell.triangles, outer_shell.aabb));
                shell.lies_within(winding, vertices)
            }
        });
        signs[index] = match enclosing {
            None => shell.volume.signum(),
            Some(outer) if (shells[outer].volume > 0.0) == (shell.volume > 0.0) => 0.0,
            Some(outer) => signs[outer],
        };
    }
    signs
}

/// Winding number of a closed shell, as a function of position.
///
/// The winding number is the sum of the signed crossings of a ray from the position towards +x with the
/// triangles. The triangles are binned by y and z.
struct Winding<'a> {
    vertices: &'a [Point3<f64>],
    triangles: &'a [[u32; 3]],
    bins: Bins,
    /// Triangles that overlap each bin.
    members: Csr<u32>,
}

/// Uniform grid over the (y, z) plane.
struct Bins {
    /// Low corner.
    low: [f64; 2],
    /// Number of bins per unit length along each axis.
    per_length: [f64; 2],
    /// Number of bins along each axis.
    count: usize,
}

impl Bins {
    /// Returns the bin of a coordinate along `axis` (0: y, 1: z).
    fn at(&self, axis: usize, coordinate: f64) -> usize {
        // The cast saturates: coordinates below the grid are in the first bin, coordinates above in the last.
        (((coordinate - self.low[axis]) * self.per_length[axis]) as usize).min(self.count - 1)
    }
}

impl<'a> Winding<'a> {
    /// Bins the triangles of a shell with the AABB `(low, high)`.
    fn new(
        vertices: &'a [Point3<f64>],
        triangles: &'a [[u32; 3]],
        (low, high): (Point3<f64>, Point3<f64>),
    ) -> Self {
        let count = (triangles.len() as f64).sqrt().ceil().clamp(1.0, MAX_BINS as f64) as usize;
        let per_length = [1, 2].map(|axis| {
            let extent: f64 = high[axis] - low[axis];
            if extent > 0.0 { count as f64 / extent } else { 0.0 }
        });
        let bins = Bins { low: [low.y, low.z], per_length, count };
        let covered_bins = |triangle: &[u32; 3]| {
            let corners = triangle.map(|corner| vertices[corner as usize]);
            let range = |axis: usize| {
                let corner_bins = corners.map(|corner| bins.at(axis, corner[axis + 1]));
                let first = corner_bins.into_iter().fold(usize::MAX, usize::min);
                first..corner_bins.into_iter().fold(0, usize::max) + 1
            };
            let (columns, rows) = (range(0), range(1));
            rows.flat_map(move |row| columns.clone().map(move |column| (row * count + column) as u32))
        };
        let entry = |(index, triangle)| covered_bins(triangle).map(move |bin| (bin, index));
        let members = Csr::sorted(count * count, (0..).zip(triangles).flat_map(entry));
        Self { vertices, triangles, bins, members }
    }

    /// Returns the winding number at `point`: 0 outside the shell; inside, 1 if the shell is oriented
    /// outwards and -1 if it is oriented inwards.
    fn number(&self, point: &Point3<f64>) -> i32 {
        let bin = self.bins.at(1, point.z) * self.bins.count + self.bins.at(0, point.y);
        let members = self.members.row(bin).iter();
        members.map(|&member| self.crossing(self.triangles[member as usize], point)).sum()
    }

    /// Returns the signed crossing of the ray from `point` towards +x with a triangle: 1 if the triangle's
    /// normal has a positive x component, -1 if negative, 0 if the ray does not cross the triangle.
    fn crossing(&self, triangle: [u32; 3], point: &Point3<f64>) -> i32 {
        let [a, b, c] = triangle;
        let crossing = self.edge_crossing(a, b, point)
            + self.edge_crossing(b, c, point)
            + self.edge_crossing(c, a, point);
        if crossing == 0 {
            return 0;
        }
        let [a, b, c] = triangle.map(|corner| self.vertices[corner as usize]);
        let normal: Vector3<f64> = (b - a).cross(&(c - a));
        let offset = point - a;
        let height = offset.dot(&normal);
        // The ray intersects the plane iff the height above it and the x component of the normal have
        // opposite signs.
        i32::from(height * normal.x < 0.0) * crossing
    }

    /// Returns how the edge from `a` to `b` crosses the ray from `point` towards +y, both projected to the
    /// (y, z) plane: 1 towards +z, -1 towards -z, 0 if the edge does not cross the ray.
    ///
    /// The crossing is computed in the same vertex order for both triangles of an edge, so that no ray
    /// towards +x passes between the two triangles.
    fn edge_crossing(&self, a: u32, b: u32, point: &Point3<f64>) -> i32 {
        let [low, high] = [a.min(b), a.max(b)].map(|corner| self.vertices[corner as usize]);
        if (low.z <= point.z) == (high.z <= point.z) {
            return 0;
        }
        let y = low.y + (point.z - low.z) * ((high.y - low.y) / (high.z - low.z));
        if y <= point.y {
            return 0;
        }
        if self.vertices[b as usize].z > point.z { 1 } else { -1 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Creates a cube with faces oriented outwards, or inwards if `flipped`.
    fn cuboid(vertices: &mut Vec<Point3<f64>>, low: [f64; 3], side: f64, flipped: bool) -> Shell {
        let first = vertices.len() as u32;
        for k in 0..8 {
            let offset = [k & 1, k >> 1 & 1, k >> 2 & 1].map(f64::from);
            vertices.push(Point3::from(std::array::from_fn(|a| low[a] + side * offset[a])));
        }
        let mut triangles = Vec::new();
        for [a, b, c, d] in crate::lattice::FACE_CORNERS.map(|f| f.map(|k| first + k as u32)) {
            triangles.extend(if flipped { [[a, c, b], [a, d, c]] } else { [[a, b, c], [a, c, d]] });
        }
        Shell::new(vertices, triangles, 0)
    }

    #[test]
    fn signs_of_nested_shells() {
        let mut vertices = Vec::new();
        let shells = [
            cuboid(&mut vertices, [0.0; 3], 10.0, false),
            cuboid(&mut vertices, [1.0; 3], 2.0, false), // same orientation: ignored
            cuboid(&mut vertices, [4.0; 3], 4.0, true),  // a cavity
            cuboid(&mut vertices, [5.0, 5.0, 5.1], 1.0, false), // an island in the cavity
            cuboid(&mut vertices, [6.5; 3], 1.0, true),  // same orientation as the cavity: ignored
            cuboid(&mut vertices, [20.0; 3], 1.0, true), // outermost, oriented inwards
            cuboid(&mut vertices, [9.5; 3], 2.0, false), // mostly outside
        ];
        assert_eq!(signs(&vertices, &shells), [1.0, 0.0, 1.0, 1.0, 0.0, -1.0, 1.0]);
        let volume: f64 = shells.iter().zip(signs(&vertices, &shells)).map(|(s, sign)| sign * s.volume).sum();
        assert!((volume - (1000.0 - 64.0 + 1.0 + 1.0 + 8.0)).abs() < 1e-9);
    }

    #[test]
    fn signs_of_a_flipped_shell_with_a_cavity() {
        let mut vertices = Vec::new();
        let shells =
            [cuboid(&mut vertices, [0.0; 3], 4.0, true), cuboid(&mut vertices, [1.0; 3], 2.0, false)];
        assert_eq!(signs(&vertices, &shells), [-1.0, -1.0]);
    }

    #[test]
    fn winding_number_is_one_inside_and_zero_outside() {
        let mut vertices = Vec::new();
        let shell = cuboid(&mut vertices, [0.0; 3], 1.0, false);
        let winding = Winding::new(&vertices, &shell.triangles, shell.aabb);
        for k in 0..4096 {
            let point = Point3::new(k % 16, k / 16 % 16, k / 256).map(|i| (f64::from(i) - 3.5) / 8.0);
            let inside = point.iter().all(|&x| x > 0.0 && x < 1.0);
            assert_eq!(winding.number(&point), i32::from(inside), "{point}");
        }
    }
}
