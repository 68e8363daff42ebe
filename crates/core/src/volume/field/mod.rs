//! Computes the deformation field V: the displacement of each lattice vertex per unit of the scale `lambda`.
//!
//! | file | content |
//! |---|---|
//! | `paper` | field of Takamatsu & Kanai (2009): boundary normals, extended inwards layer by layer |
//! | `walls` | pieces of the boundary at lattice vertices, with normals and areas |
//! | `smooth` | smoothest field that moves the walls by 1 along their normals |

mod paper;
mod smooth;
mod walls;

use super::adjacency::{Adjacency, Corners, octants};
use super::options::FieldKind;
use super::surface::Surface;
use crate::lattice::Lattice;
use crate::simd::vector::cross;

/// Field at rest, in the model's frame. The correction rotates each vector by the shape-matching rotation of
/// its vertex.
#[derive(Clone, Debug)]
pub(super) struct Field {
    /// One vector per vertex, in vertex order.
    pub(super) directions: Vec<[f32; 3]>,
    /// Thickness of each component: the greatest depth of its vertices below its boundary, in links (edges of
    /// cells); 0.5 without interior vertices.
    pub(super) thickness: Vec<f64>,
}

impl Field {
    /// Computes the field of a lattice and of its embedded surface.
    pub(super) fn new(
        kind: FieldKind,
        lattice: &Lattice,
        surface: Option<Surface<'_>>,
        adjacency: &Adjacency,
    ) -> Self {
        let corners = Corners::new(lattice, adjacency);
        let octants = octants(adjacency.len(), &corners);
        let depth = adjacency.distances((0..adjacency.len()).filter(|&i| octants[i] != u8::MAX));
        let mut greatest_depth = vec![0_u32; adjacency.component_count];
        for (i, &depth) in depth.iter().enumerate() {
            let greatest = &mut greatest_depth[adjacency.component(i)];
            *greatest = depth.max(*greatest);
        }
        let normals = paper::boundary_normals(adjacency, lattice.indices(), &octants);
        let paper_field = paper::fill(adjacency, &depth, &greatest_depth, normals.clone());
        let thickness: Vec<f64> = greatest_depth.into_iter().map(|depth| f64::from(depth).max(0.5)).collect();
        let walls = match (kind, surface) {
            (FieldKind::Paper, _) => {
                let directions = paper_field.into_iter().map(|v| v.map(|x| x as f32).into()).collect();
                return Self { directions, thickness };
            }
            (FieldKind::Surface | FieldKind::Auto, Some(surface)) => {
                let least_alignment = if kind == FieldKind::Auto { walls::SHEET_ALIGNMENT } else { 0.0 };
                walls::of_surface((lattice, &corners), surface, adjacency, &normals, least_alignment)
            }
            (FieldKind::Cells | FieldKind::Surface | FieldKind::Auto, _) => walls::of_cells(lattice),
        };
        let directions = smooth::fill((lattice, adjacency), &thickness, &walls, &paper_field);
        Self { directions, thickness }
    }
}

/// Returns `v` rotated by the unit quaternion `q = (x, y, z, w)`.
#[inline]
pub(super) fn rotated(q: &[f32; 4], v: &[f32; 3]) -> [f32; 3] {
    let [x, y, z, w] = *q;
    // v + 2 u × (u × v + w v), where u is the vector part (x, y, z) of q.
    let inner = cross([x, y, z], *v);
    let inner = std::array::from_fn(|k| inner[k] + w * v[k]);
    let outer = cross([x, y, z], inner);
    std::array::from_fn(|k| v[k] + 2.0 * outer[k])
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;

    use super::*;
    use crate::lattice::Lattice;

    fn field(cells: &[[i32; 3]]) -> (Lattice, Field) {
        let lattice = Lattice::from_cells(cells, 1.0, Point3::origin(), false).unwrap();
        let field = Field::new(FieldKind::Paper, &lattice, None, &Adjacency::new(&lattice));
        (lattice, field)
    }

    fn block(n: i32) -> Vec<[i32; 3]> {
        (0..n * n * n).map(|i| [i % n, i / n % n, i / n / n]).collect()
    }

    fn length(v: [f32; 3]) -> f32 {
        v.iter().map(|x| x * x).sum::<f32>().sqrt()
    }

    #[test]
    fn paper_field_decreases_from_one_at_the_boundary_to_zero_at_the_center() {
        let (lattice, field) = field(&block(6));
        for (index, &v) in lattice.indices().iter().zip(&field.directions) {
            let depth = index.iter().map(|&i| i.min(6 - i)).min().unwrap();
            assert!((length(v) - (1.0 - depth as f32 / 3.0)).abs() < 1e-6, "{index:?}: {v:?}");
        }
        assert_eq!(field.thickness, [3.0]);
        let at = |index| field.directions[lattice.vertex_at(index).unwrap() as usize];
        assert_eq!(at([3, 3, 0]), [0.0, 0.0, -1.0]);
        assert_eq!(at([6, 3, 2]), [1.0, 0.0, 0.0]);
        let edge = 0.5_f32.sqrt();
        assert_eq!(at([0, 6, 3]), [-edge, edge, 0.0]);
    }

    #[test]
    fn normals_of_concave_edges_point_into_the_gap() {
        let mut cells = block(2);
        cells.retain(|&[x, y, _]| [x, y] != [1, 1]);
        let (lattice, field) = field(&cells);
        let v = field.directions[lattice.vertex_at([1, 1, 1]).unwrap() as usize];
        assert_eq!(v, [0.5_f32.sqrt(), 0.5_f32.sqrt(), 0.0]);
    }

    #[test]
    fn every_boundary_vertex_has_a_unit_normal() {
        // Cells that touch along edges and at corners, where the missing directions cancel.
        let checkered: Vec<[i32; 3]> =
            block(4).into_iter().filter(|c| c.iter().sum::<i32>() % 2 == 0).collect();
        for cells in [checkered, vec![[0, 0, 0], [1, 1, 1]], vec![[0, 0, 0], [1, 1, 0]]] {
            let (_, field) = field(&cells);
            assert!(field.directions.iter().all(|&v| (length(v) - 1.0).abs() < 1e-6), "{cells:?}");
            assert_eq!(field.thickness, [0.5]);
        }
    }

    #[test]
    fn rotated_matches_nalgebra() {
        let rotation = nalgebra::UnitQuaternion::from_euler_angles(0.3, -1.2, 2.5);
        let v = nalgebra::Vector3::new(0.2, -0.7, 0.4);
        let expected: [f64; 3] = (rotation * v).into();
        let q = rotation.coords.map(|x| x as f32).into();
        let v = rotated(&q, &[0.2, -0.7, 0.4]);
        assert!(v.iter().zip(expected).all(|(a, b)| (f64::from(*a) - b).abs() < 1e-6), "{v:?} {expected:?}");
    }
}
