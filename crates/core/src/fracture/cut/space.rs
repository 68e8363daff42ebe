//! The points of the mesh in the space of the cut.
//!
//! In this space lengths are in cells, the cracks are staircases of faces, and the mesh beside a crack is moved along
//! the normal of the crack until it is clear of its staircase. Edges on one side of a crack then do not cross the
//! staircase, and edges that cross the plane of the crack do.

use nalgebra::{Point3, Vector3};

use super::faces::CutSurface;
use super::input::Input;
use super::planes::Cell;
use super::refine::Refined;
use crate::voxel::Grid;

/// Distance in cells between moved points and the staircase. Far greater than rounding errors.
const CLEARANCE: f64 = 1e-3;

/// Distance in cells to which a point in a plane of the grid is moved. Far less than [`CLEARANCE`], and greater than
/// rounding errors.
const BESIDE: f64 = 5e-7;

/// Number of rounds in which the planes of several cracks move a point.
const ROUNDS: usize = 4;

/// Greatest displacement of a point, in cells: twice the half diagonal of a cell.
const FARTHEST: f64 = 1.74;

/// Least component of a unit normal along which a point in a plane is moved to the inner side of the surface.
const INNER: f64 = 0.05;

/// A point in the space of the cut.
#[derive(Clone, Copy)]
pub(super) struct Point {
    /// Position in the model frame.
    pub(super) position: Point3<f64>,
    /// Position in the space of the cut.
    pub(super) u: Vector3<f64>,
    /// Index of the cell that contains the point. On an axis of `on`: the plane that contains it, below cell `k`.
    pub(super) k: Cell,
    /// Bit mask of the axes on which the point is in a plane of the grid.
    pub(super) on: u8,
}

/// The mesh in the space of the cut.
pub(super) struct Space {
    /// The points: first the vertices of the mesh, of which only the welded ones are used.
    pub(super) points: Vec<Point>,
    pub(super) refined: Refined,
}

impl Space {
    pub(super) fn new(input: &Input<'_>) -> Self {
        let Input { mesh, lattice, planes, faces, surface, .. } = *input;
        let mut positions = mesh.vertices().to_vec();
        let to_cells = |point: &Point3<f64>| (point - lattice.origin()) / lattice.cell_size();
        let refined = match surface {
            CutSurface::Smooth => Refined::new(mesh, planes, faces, &mut positions, to_cells),
            CutSurface::Cells => Refined::unchanged(mesh),
        };
        let tolerance = Grid::tolerance(&mesh.bounds(), lattice.cell_size());
        let placer = Placer { input, tolerance };
        let mut in_plane = vec![false; positions.len()];
        let mut points: Vec<Point> = Vec::with_capacity(positions.len());
        for (position, in_plane) in positions.iter().zip(&mut in_plane) {
            let (u, k, is_in_plane) = placer.place(to_cells(position), &Vector3::zeros());
            *in_plane = is_in_plane;
            points.push(Point { position: *position, u, k, on: 0 });
        }
        if in_plane.contains(&true) {
            let mut normals = vec![Vector3::zeros(); positions.len()];
            for triangle in &refined.triangles {
                if triangle.corners.iter().any(|&corner| in_plane[corner as usize]) {
                    let [a, b, c] = triangle.corners.map(|corner| positions[corner as usize]);
                    let normal = (b - a).cross(&(c - a));
                    triangle.corners.iter().for_each(|&corner| normals[corner as usize] += normal);
                }
            }
            for ((point, normal), _) in
                points.iter_mut().zip(normals).zip(in_plane).filter(|(_, in_plane)| *in_plane)
            {
                let normal = normal.try_normalize(0.0).unwrap_or_default();
                (point.u, point.k, _) = placer.place(to_cells(&point.position), &normal);
            }
        }
        Self { points, refined }
    }
}

/// Finds the place of a point in the space of the cut.
struct Placer<'a> {
    input: &'a Input<'a>,
    /// Distance in cells within which a point is in a plane.
    tolerance: f64,
}

impl Placer<'_> {
    /// Returns the place of a point, its cell, and whether the normal of the surface was needed. A point in a plane of
    /// the grid or of a crack belongs to the side on which the mesh is, as in the voxelization.
    ///
    /// * `point`: the point in cells.
    /// * `normal`: unit normal of the surface at the point, or zero.
    fn place(&self, point: Vector3<f64>, normal: &Vector3<f64>) -> (Vector3<f64>, Cell, bool) {
        let Input { lattice, planes, faces, surface, .. } = *self.input;
        let (mut u, mut in_plane) = (point, false);
        let near = match surface {
            CutSurface::Smooth => faces.near(point.map(|x| x.floor() as i32).into()),
            CutSurface::Cells => &[],
        };
        for _ in 0..if near.len() > 1 { ROUNDS } else { near.len() } {
            for &crack in near {
                let distance = planes.distance(crack, &point);
                let mut side = if distance < 0.0 { -1.0 } else { 1.0 };
                if distance.abs() <= self.tolerance {
                    in_plane = true;
                    side = if planes.normal(crack).dot(normal) > INNER { -1.0 } else { 1.0 };
                }
                let clear = planes.half_width(crack) + CLEARANCE;
                let missing = clear - side * planes.distance(crack, &u);
                if missing > 0.0 {
                    u += planes.normal(crack) * (side * missing);
                }
            }
        }
        let moved = (u - point).norm();
        if moved > FARTHEST {
            u = point + (u - point) * (FARTHEST / moved);
        }
        let mut k: Cell = u.map(|x| x.floor() as i32).into();
        let mut axes = 0;
        for a in 0..3 {
            let plane = u[a].round();
            if (u[a] - plane).abs() <= self.tolerance {
                axes |= 1 << a;
                k[a] = plane as i32 - i32::from(normal[a] > INNER);
            }
        }
        if axes != 0 && lattice.cell_at(k).is_none() {
            let beside = |mask: i32| -> Cell {
                let other = |a: usize| if k[a] == u[a].round() as i32 { k[a] - 1 } else { k[a] + 1 };
                std::array::from_fn(|a| if mask >> a & 1 != 0 { other(a) } else { k[a] })
            };
            let mut masks = (1..8).filter(|mask| mask & !axes == 0).map(beside);
            k = masks.find(|&cell| lattice.cell_at(cell).is_some()).unwrap_or(k);
        }
        // The point is moved to its side of the plane. Triangles that share it then agree on which side of a corner
        // of the grid the mesh lies.
        for a in (0..3).filter(|a| axes >> a & 1 != 0) {
            let plane = u[a].round();
            u[a] = if k[a] == plane as i32 { plane + BESIDE } else { plane - BESIDE };
        }
        (u, k, in_plane || axes != 0)
    }
}
