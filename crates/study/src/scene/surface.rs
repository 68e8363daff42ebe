//! Computes the distance of two surfaces with the same faces.

use nalgebra::Point3;
use parry3d_f64::math::Vector;
use parry3d_f64::query::PointQuery;
use parry3d_f64::shape::TriMesh;

/// Distance of two surfaces.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Distance {
    /// Sum of the squared distances of corresponding vertices.
    pub(super) squares: f64,
    /// Hausdorff distance: the maximum distance of a vertex of either surface from the other surface.
    pub(super) hausdorff: f64,
}

/// Computes the distance of two surfaces with the same triangles.
pub(super) fn distance(a: &[Point3<f64>], b: &[Point3<f64>], triangles: &[[u32; 3]]) -> Distance {
    let squares: Vec<f64> = a.iter().zip(b).map(|(a, b)| (a - b).norm_squared()).collect();
    // The distance to the corresponding vertex bounds the distance to the other surface. In descending order
    // of this bound, the search ends at the first bound that is not above the maximum found so far.
    let mut order: Vec<usize> = (0..squares.len()).collect();
    order.sort_by(|&i, &j| squares[j].total_cmp(&squares[i]));
    let mut hausdorff = 0.0_f64;
    for (points, other) in [(a, b), (b, a)] {
        // A surface has triangles.
        let Ok(other) = TriMesh::new(other.iter().map(to_parry).collect(), triangles.to_vec()) else {
            continue;
        };
        for &vertex in &order {
            let bound = squares[vertex].sqrt();
            if bound <= hausdorff {
                break;
            }
            let point = to_parry(&points[vertex]);
            let nearest = other.project_local_point_with_max_dist(point, false, bound);
            hausdorff = hausdorff.max(nearest.map_or(bound, |nearest| nearest.point.distance(point)));
        }
    }
    Distance { squares: squares.iter().sum(), hausdorff }
}

fn to_parry(point: &Point3<f64>) -> Vector {
    Vector::new(point.x, point.y, point.z)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the corners of a square of edge `size` at a height.
    fn square(size: f64, height: f64) -> Vec<Point3<f64>> {
        [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
            .map(|[x, y]| Point3::new(size * x, size * y, height))
            .to_vec()
    }

    const TRIANGLES: [[u32; 3]; 2] = [[0, 1, 2], [0, 2, 3]];

    #[test]
    fn the_hausdorff_distance_is_between_surfaces_not_vertices() {
        let distance = |a: &[Point3<f64>], b: &[Point3<f64>]| distance(a, b, &TRIANGLES);
        let (low, high) = (square(2.0, 0.0), square(2.0, 0.5));
        assert_eq!(distance(&low, &low), Distance::default());
        assert_eq!(distance(&low, &high), Distance { squares: 4.0 * 0.25, hausdorff: 0.5 });
        // The smaller square is inside the larger one, whose far corner has the maximum distance, in both
        // orders.
        let inner = square(1.0, 0.0);
        assert_eq!(distance(&low, &inner).hausdorff, 2.0_f64.sqrt());
        assert_eq!(distance(&inner, &low).hausdorff, 2.0_f64.sqrt());
        // The same surface with permuted vertices.
        let turned = [low[1], low[2], low[3], low[0]];
        assert!(distance(&low, &turned).squares > 1.0);
        assert_eq!(distance(&low, &turned).hausdorff, 0.0);
    }
}
