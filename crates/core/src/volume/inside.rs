//! How often a closed shell winds around a point, by the signed crossings of a ray.

use nalgebra::{Point3, Vector3};

/// Bins along either side of the grid at most.
const MOST_BINS: usize = 512;

/// The triangles of a closed shell, binned by their projection along x.
pub(super) struct Winding<'a> {
    vertices: &'a [Point3<f64>],
    triangles: &'a [[u32; 3]],
    bins: Bins,
    /// Triangles of bin `b`: `members[starts[b]..starts[b + 1]]`.
    starts: Vec<u32>,
    members: Vec<u32>,
}

/// A grid over the (y, z) plane.
struct Bins {
    low: [f64; 2],
    per_length: [f64; 2],
    count: usize,
}

impl Bins {
    fn at(&self, axis: usize, x: f64) -> usize {
        // Saturating: what lies below the grid is in its first bin, what lies above in its last.
        (((x - self.low[axis]) * self.per_length[axis]) as usize).min(self.count - 1)
    }
}

impl<'a> Winding<'a> {
    pub(super) fn new(
        vertices: &'a [Point3<f64>],
        triangles: &'a [[u32; 3]],
        (low, high): (Point3<f64>, Point3<f64>),
    ) -> Self {
        let count = (triangles.len() as f64).sqrt().ceil().clamp(1.0, MOST_BINS as f64) as usize;
        let per_length = [1, 2].map(|axis| {
            let extent: f64 = high[axis] - low[axis];
            if extent > 0.0 { count as f64 / extent } else { 0.0 }
        });
        let bins = Bins { low: [low.y, low.z], per_length, count };
        let mut starts = vec![0_u32; count * count + 1];
        let covered = |triangle: &[u32; 3]| {
            let corners = triangle.map(|corner| vertices[corner as usize]);
            let range = |axis: usize| {
                let along = corners.map(|corner| bins.at(axis, corner[axis + 1]));
                along.into_iter().fold(usize::MAX, usize::min)..along.into_iter().fold(0, usize::max) + 1
            };
            let (columns, rows) = (range(0), range(1));
            rows.flat_map(move |row| columns.clone().map(move |column| row * count + column))
        };
        for bin in triangles.iter().flat_map(covered) {
            starts[bin + 1] += 1;
        }
        for bin in 1..starts.len() {
            starts[bin] += starts[bin - 1];
        }
        let mut next = starts.clone();
        let mut members = vec![0_u32; starts[count * count] as usize];
        for (index, triangle) in triangles.iter().enumerate() {
            for bin in covered(triangle) {
                members[next[bin] as usize] = index as u32;
                next[bin] += 1;
            }
        }
        Self { vertices, triangles, bins, starts, members }
    }

    /// Turns of the shell around `point`: 1 inside a shell that looks outwards, -1 if it looks inwards, 0 outside.
    pub(super) fn around(&self, point: &Point3<f64>) -> i32 {
        let bin = self.bins.at(1, point.z) * self.bins.count + self.bins.at(0, point.y);
        let members = &self.members[self.starts[bin] as usize..self.starts[bin + 1] as usize];
        members.iter().map(|&member| self.crossing(self.triangles[member as usize], point)).sum()
    }

    /// 1 if the ray from `point` towards +x leaves through the triangle's front, -1 if through its back, else 0.
    fn crossing(&self, triangle: [u32; 3], point: &Point3<f64>) -> i32 {
        let [a, b, c] = triangle;
        let turns = self.passes(a, b, point) + self.passes(b, c, point) + self.passes(c, a, point);
        if turns == 0 {
            return 0;
        }
        let [a, b, c] = triangle.map(|corner| self.vertices[corner as usize]);
        let normal: Vector3<f64> = (b - a).cross(&(c - a));
        let offset = point - a;
        let along = offset.dot(&normal);
        // The ray meets the plane ahead iff the plane lies on the side that its normal's x points to.
        i32::from(along * normal.x < 0.0) * turns
    }

    /// Whether the edge crosses the ray from the projected point towards +y, and on which way (up 1, down -1). The
    /// crossing is computed in the same order for both triangles of an edge, so that no ray slips between them.
    fn passes(&self, a: u32, b: u32, point: &Point3<f64>) -> i32 {
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
