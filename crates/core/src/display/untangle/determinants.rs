//! Determinants of a deformed cell, and their derivatives.

use nalgebra::{Matrix3, Vector3};

/// Positions of the corners of a cell, in cells.
pub(super) type Corners = [Vector3<f64>; 8];

/// A determinant as a function of the displacement of one vertex: `value + gradient · displacement`.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct LinearDeterminant {
    pub(super) value: f64,
    pub(super) gradient: Vector3<f64>,
}

/// Least singular value of a gradient after [`opened`].
const LEAST_STRETCH: f64 = 0.3;

/// Returns the least of the determinants of the eight corners and of the center of a cell.
pub(super) fn least_determinant(corners: &Corners) -> f64 {
    let determinant = |[x, y, z]: [Vector3<f64>; 3]| x.dot(&y.cross(&z));
    (0..8).map(|k| determinant(edges(corners, k))).fold(determinant(mean_edges(corners)), f64::min)
}

/// Returns the determinant of the center of a cell: its volume in cells, if its faces are parallelograms.
pub(super) fn center_determinant(corners: &Corners) -> f64 {
    let [x, y, z] = mean_edges(corners);
    x.dot(&y.cross(&z))
}

/// Returns the determinants that depend on a corner of a cell: of its three neighbors, of the corner, and of the
/// center of the cell.
pub(super) fn determinants_of(corners: &Corners, corner: usize) -> [LinearDeterminant; 5] {
    let sign = |corner: usize, axis: usize| if corner >> axis & 1 == 0 { 1.0 } else { -1.0 };
    let (own, mean) = (edges(corners, corner), mean_edges(corners));
    let (own_areas, mean_areas) = (areas(&own), areas(&mean));
    let mut all = [LinearDeterminant::default(); 5];
    (all[3].value, all[4].value) = (own[0].dot(&own_areas[0]), mean[0].dot(&mean_areas[0]));
    for axis in 0..3 {
        all[3].gradient -= own_areas[axis] * sign(corner, axis);
        all[4].gradient -= mean_areas[axis] * (0.25 * sign(corner, axis));
        let neighbor = corner ^ 1 << axis;
        let edges = edges(corners, neighbor);
        let area = areas(&edges)[axis];
        let gradient = area * sign(neighbor, axis);
        all[axis] = LinearDeterminant { value: edges[axis].dot(&area), gradient };
    }
    all
}

/// Returns the edges of a cell at a corner, in the positive directions of the axes.
fn edges(corners: &Corners, corner: usize) -> [Vector3<f64>; 3] {
    [1, 2, 4].map(|bit| corners[corner | bit] - corners[corner & !bit])
}

/// Returns the mean edge of a cell along each axis: the derivatives of the position at its center.
pub(super) fn mean_edges(corners: &Corners) -> [Vector3<f64>; 3] {
    [1, 2, 4].map(|bit| {
        let factor = |k: usize| if k & bit == 0 { -0.25 } else { 0.25 };
        (0..8).map(|k| corners[k] * factor(k)).sum()
    })
}

/// Returns the cross products of the edges: the derivatives of their determinant.
fn areas([x, y, z]: &[Vector3<f64>; 3]) -> [Vector3<f64>; 3] {
    [y.cross(z), z.cross(x), x.cross(y)]
}

/// Returns a gradient that is changed so that it is not inside out and no thinner than [`LEAST_STRETCH`]: the singular
/// values are raised, after the least one was negated if the gradient is inside out. `None` if it has no singular
/// values in f64.
pub(super) fn opened(gradient: &Matrix3<f64>) -> Option<Matrix3<f64>> {
    // The least singular value is above a bound if GᵀG, less the square of the bound, is positive definite.
    let rest = gradient.tr_mul(gradient) - Matrix3::from_diagonal_element(LEAST_STRETCH * LEAST_STRETCH);
    let leading = rest.m11 * rest.m22 - rest.m12 * rest.m21;
    if rest.m11 > 0.0 && leading > 0.0 && rest.determinant() > 0.0 && gradient.determinant() > 0.0 {
        return Some(*gradient);
    }
    let svd = gradient.try_svd(true, true, f64::EPSILON, 64)?;
    let (mut u, v_t) = (svd.u?, svd.v_t?);
    if u.determinant() * v_t.determinant() < 0.0 {
        u.column_mut(svd.singular_values.imin()).neg_mut();
    }
    Some(u * Matrix3::from_diagonal(&svd.singular_values.map(|value| value.max(LEAST_STRETCH))) * v_t)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cell with random corners, about 1 cell apart.
    fn random_cell() -> Corners {
        let mut state = 5_u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 8) / f64::from(1 << 24) - 0.5
        };
        std::array::from_fn(|k| {
            Vector3::from([1, 2, 4].map(|bit| if k & bit == 0 { 0.0 } else { 1.0 } + random()))
        })
    }

    fn determinant([x, y, z]: [Vector3<f64>; 3]) -> f64 {
        x.dot(&y.cross(&z))
    }

    #[test]
    fn determinants_are_linear_in_a_corner() {
        let cell = random_cell();
        let displacement = Vector3::new(0.3, -0.7, 0.45);
        for corner in 0..8 {
            let mut moved = cell;
            moved[corner] += displacement;
            let neighbors = [1, 2, 4].map(|bit| determinant(edges(&moved, corner ^ bit)));
            let [x, y, z] = neighbors;
            let expected = [x, y, z, determinant(edges(&moved, corner)), determinant(mean_edges(&moved))];
            for (linear, expected) in determinants_of(&cell, corner).iter().zip(expected) {
                // The terms are products of at most four numbers below 3.
                let value = linear.value + linear.gradient.dot(&displacement);
                assert!((value - expected).abs() < 100.0 * f64::EPSILON, "{corner}: {value} {expected}");
            }
        }
    }

    #[test]
    fn opened_gradients_are_right_handed_and_thick() {
        let turned = *nalgebra::Rotation3::new(Vector3::new(0.4, 1.0, -0.3)).matrix();
        for stretches in [[1.0, 2.0, -1.0], [1.0, 1.0, 0.0], [2.0, 0.0, 0.0], [0.0; 3], [1.0, -0.5, 0.7]] {
            let gradient = turned * Matrix3::from_diagonal(&stretches.into());
            let opened = opened(&gradient).unwrap();
            let least = opened.singular_values().min();
            assert!(opened.determinant() > 0.0 && least > LEAST_STRETCH - 1e-12, "{stretches:?}: {opened}");
        }
        // A gradient that is neither inside out nor thin stays.
        let plain = turned * Matrix3::from_diagonal(&[0.5, 2.0, 1.0].into());
        assert!((opened(&plain).unwrap() - plain).norm() < 1e-12);
    }
}
