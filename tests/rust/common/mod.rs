//! Bodies, lattices and measures that several tests share.
#![allow(dead_code, unreachable_pub, reason = "not every test program uses every item")]

use nalgebra::{Point3, Rotation3, Vector3};
use supple::{
    Body, BodyBuilder, Handle, Key, Lattice, Material, Mesh, Pin, Selection, Simulation, TimeWindow,
};

/// A seeded random number generator (Steele, Lea & Flood 2014: SplitMix64).
pub struct Random(pub u64);

impl Random {
    /// Returns 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Returns a number that is uniform in [0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Returns a number that is uniform in [-1, 1).
    pub fn signed(&mut self) -> f64 {
        2.0 * self.unit() - 1.0
    }

    /// Returns a vector whose components are uniform in [-1, 1).
    pub fn vector(&mut self) -> Vector3<f64> {
        Vector3::new(self.signed(), self.signed(), self.signed())
    }

    /// Returns a random rotation.
    pub fn rotation(&mut self) -> Rotation3<f64> {
        Rotation3::new(self.vector() * 3.0)
    }
}

/// Returns the cells of a box with its lowest cell at [0, 0, 0].
pub fn block(size: [i32; 3]) -> Vec<[i32; 3]> {
    let [nx, ny, nz] = size;
    (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z]))).collect()
}

/// Returns the mesh of a cuboid of unit cells: a quad for each face of a cell on its surface.
pub fn cuboid(size: [i32; 3]) -> Mesh {
    let (vertices, quads) = surface_of(&block(size));
    Mesh::new(vertices, &quads).unwrap()
}

/// Returns the volume of each piece of the mesh of a body, with its vertices at other positions.
pub fn volumes_of_pieces(body: &Body, positions: &[Point3<f64>]) -> Vec<f64> {
    let pieces = body.piece_of_mesh_vertices().unwrap();
    let mut volumes = vec![0.0; body.pieces()];
    for triangle in body.mesh().unwrap().triangles() {
        let [a, b, c] = triangle.map(|vertex| positions[vertex as usize].coords);
        volumes[pieces[triangle[0] as usize] as usize] += a.dot(&b.cross(&c)) / 6.0;
    }
    volumes
}

/// Returns the boundary surface of cells of edge 1: its vertices, and quads that face outwards.
pub fn surface_of(cells: &[[i32; 3]]) -> (Vec<[f64; 3]>, Vec<[u32; 4]>) {
    let occupied: std::collections::BTreeSet<_> = cells.iter().copied().collect();
    let mut numbers = std::collections::BTreeMap::new();
    let (mut vertices, mut quads) = (Vec::new(), Vec::new());
    for cell in cells {
        for axis in 0..3 {
            for side in [0, 1] {
                let mut beyond = *cell;
                beyond[axis] += 2 * side - 1;
                if occupied.contains(&beyond) {
                    continue;
                }
                let mut quad = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[u, v]| {
                    let mut at = *cell;
                    at[axis] += side;
                    at[(axis + 1) % 3] += u;
                    at[(axis + 2) % 3] += v;
                    *numbers.entry(at).or_insert_with(|| {
                        vertices.push(at.map(f64::from));
                        vertices.len() as u32 - 1
                    })
                });
                if side == 0 {
                    quad.reverse();
                }
                quads.push(quad);
            }
        }
    }
    (vertices, quads)
}

/// Returns the root mean square of lengths.
pub fn rms(lengths: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = lengths.fold((0.0, 0.0), |(sum, count), x| (sum + x * x, count + 1.0));
    f64::sqrt(sum / count)
}

/// Pins a body below `low`, moves its part above `high` by `distance` along `axis` in one second, and returns
/// the simulation after `steps` steps.
pub fn pull_apart(
    body: BodyBuilder,
    axis: usize,
    [low, high]: [f64; 2],
    distance: f64,
    steps: u64,
) -> Simulation {
    let along = |x: f64| {
        let mut vector = [0.0; 3];
        vector[axis] = x;
        vector
    };
    let beyond = |at: f64, side: f64| Selection::Plane { point: along(at), normal: along(side) };
    let key = |time, distance| Key { time, translate: along(distance), rotate: [0.0; 3] };
    let keys = vec![key(0.0, 0.0), key(1.0, distance)];
    let body = body.pin(Pin { selection: beyond(low, -1.0), window: TimeWindow::default() }).handle(Handle {
        selection: beyond(high, 1.0),
        motion: keys.into(),
        window: TimeWindow::default(),
    });
    let simulation = Simulation::builder().body(body.build().unwrap()).gravity([0.0; 3]);
    let mut simulation = simulation.build().unwrap();
    simulation.steps(steps);
    simulation
}

/// Returns a lattice of cells of edge 1 with its origin at zero, without bridges between floating parts.
pub fn lattice(cells: &[[i32; 3]]) -> Lattice {
    Lattice::from_cells(cells, 1.0, Point3::origin(), false).unwrap()
}

/// Returns a block of 4 x 3 x 2 cells of edge 0.5 with its lowest corner at (1, 2, 3).
pub fn half_cells() -> Lattice {
    let cells = block([4, 3, 2]);
    Lattice::from_cells(&cells, 0.5, Point3::new(1.0, 2.0, 3.0), true).unwrap()
}

/// Returns a simulation of one body without gravity, in steps of 0.01 s, on one thread.
pub fn without_gravity(body: Body) -> Simulation {
    Simulation::builder().body(body).gravity([0.0; 3]).dt(0.01).threads(1).build().unwrap()
}

/// Returns the linear momentum of a body.
pub fn momentum(body: &Body) -> Vector3<f64> {
    body.masses().iter().zip(body.velocities()).map(|(m, v)| v * *m).sum()
}

/// Returns lattices of difficult shapes (thin, concave, sparse, far from index 0) with their names.
pub fn shapes() -> Vec<(&'static str, Lattice)> {
    let u_shape: Vec<_> = block([9, 7, 2]).into_iter().filter(|c| c[1] < 2 || c[0] < 3 || c[0] > 3).collect();
    let mut random = Random(7);
    let mut sparse = |size: [i32; 3], share: f64| {
        block(size).into_iter().filter(|_| random.unit() < share).collect::<Vec<_>>()
    };
    vec![
        ("single cell", lattice(&block([1, 1, 1]))),
        ("box", lattice(&block([6, 5, 7]))),
        ("long box", lattice(&block([21, 4, 3]))),
        ("rod in x", lattice(&block([40, 1, 1]))),
        ("rod in y", lattice(&block([1, 40, 1]))),
        ("rod in z", lattice(&block([1, 1, 40]))),
        ("sheet", lattice(&block([1, 14, 17]))),
        ("u", lattice(&u_shape)),
        ("random cells", lattice(&sparse([9, 8, 7], 0.35))),
        ("more random cells", lattice(&sparse([12, 10, 9], 0.6))),
        ("random cells far from zero", {
            let cells: Vec<_> =
                sparse([10, 7, 6], 0.5).into_iter().map(|c| [c[0] - 1003, c[1] + 517, c[2] - 88]).collect();
            lattice(&cells)
        }),
    ]
}

/// Returns a body of a bare lattice with regions of half-width `half_width` and default settings.
pub fn bare(lattice: &Lattice, half_width: usize) -> Body {
    Body::from_lattice(lattice.clone()).material(Material::fast_lsm()).half_width(half_width).build().unwrap()
}

/// Returns the rest positions of a lattice.
pub fn rest(lattice: &Lattice) -> Vec<Vector3<f64>> {
    (0..lattice.len() as u32).map(|v| lattice.rest_position(v).coords).collect()
}

/// Converts points to vectors.
pub fn coordinates(points: &[Point3<f64>]) -> Vec<Vector3<f64>> {
    points.iter().map(|p| p.coords).collect()
}

/// Converts vectors to points.
pub fn points(vectors: &[Vector3<f64>]) -> Vec<Point3<f64>> {
    vectors.iter().map(|&v| v.into()).collect()
}

/// Returns the largest difference of a coordinate.
pub fn worst(a: &[Vector3<f64>], b: &[Vector3<f64>]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).amax()).fold(0.0, f64::max)
}

/// Returns the largest permitted difference of positions from the reference, in cells of edge 1: 1e-5, or 4
/// ulp of the largest coordinate `extent` if that is more.
pub fn tolerance(extent: f64) -> f64 {
    let ulp = 2.0_f64.powi(extent.log2().floor() as i32 - 23);
    (4.0 * ulp).max(1e-5)
}

/// Returns the rigid motion (R, c, d) with x ≈ R (x0 - c) + d that has the least mass-weighted squared error.
pub fn rigid_fit(
    masses: &[f64],
    from: &[Vector3<f64>],
    to: &[Vector3<f64>],
) -> (Rotation3<f64>, Vector3<f64>, Vector3<f64>) {
    let mass: f64 = masses.iter().sum();
    let mean = |x: &[Vector3<f64>]| x.iter().zip(masses).map(|(x, m)| x * *m).sum::<Vector3<f64>>() / mass;
    let (c, d) = (mean(from), mean(to));
    let a = from.iter().zip(to).zip(masses).map(|((x0, x), m)| (x - d) * (x0 - c).transpose() * *m).sum();
    (Rotation3::from_matrix_unchecked(supple::reference::rotation(&a)), c, d)
}
