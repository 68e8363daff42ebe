//! Converts the coordinates of a scene to those of the files that a run writes.

use std::ops::Neg;

use nalgebra::{Matrix4, Rotation3};
use serde::{Deserialize, Serialize};
use supple::euler_degrees;

/// Axis of a model, or of the files of a run, that points up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Up {
    /// y, the convention of most character animation programs.
    #[default]
    Y,
    /// z, the convention of most engineering programs.
    Z,
}

impl Up {
    /// Returns the axis of a scene that points up: z if gravity points mainly against it, otherwise y.
    pub fn of_gravity([x, y, z]: [f64; 3]) -> Self {
        if -z > x.abs().max(y.abs()) { Self::Z } else { Self::Y }
    }

    /// Returns the name in scenes.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Y => "y",
            Self::Z => "z",
        }
    }
}

/// The coordinates of files: those of the scene, rotated about x by a quarter turn if another axis points up, then
/// scaled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FileSpace {
    /// Axis of the scene that points up.
    from: Up,
    /// Axis of the files that points up.
    up: Up,
    /// Length in the files of a length 1 of the scene.
    scale: f64,
}

impl FileSpace {
    /// The coordinates of files in which `up` points up, for a scene in which `from` does.
    pub(crate) fn new(from: Up, up: Up, scale: f64) -> Self {
        Self { from, up, scale }
    }

    /// Returns the axis of the files that points up.
    pub(crate) fn up(self) -> Up {
        self.up
    }

    /// Converts a direction, with its length.
    pub(crate) fn direction<T: Neg<Output = T>>(self, [x, y, z]: [T; 3]) -> [T; 3] {
        match (self.from, self.up) {
            (Up::Y, Up::Z) => [x, -z, y],
            (Up::Z, Up::Y) => [x, z, -y],
            _ => [x, y, z],
        }
    }

    /// Converts a position.
    pub(crate) fn position(self, position: [f64; 3]) -> [f64; 3] {
        self.direction(position).map(|number| self.scale * number)
    }

    /// Converts a length.
    pub(crate) fn length(self, length: f64) -> f64 {
        self.scale * length
    }

    /// Converts a volume.
    pub(crate) fn volume(self, volume: f64) -> f64 {
        self.scale.powi(3) * volume
    }

    /// Converts positions in place. Numbers are rounded once.
    pub(crate) fn convert_positions(self, positions: &mut [[f32; 3]]) {
        self.convert_directions(positions);
        if self.scale != 1.0 {
            let scaled = |number: f32| (self.scale * f64::from(number)) as f32;
            positions.iter_mut().for_each(|position| *position = position.map(scaled));
        }
    }

    /// Converts directions in place.
    pub(crate) fn convert_directions(self, directions: &mut [[f32; 3]]) {
        if self.from != self.up {
            directions.iter_mut().for_each(|direction| *direction = self.direction(*direction));
        }
    }

    /// Converts a rotation, as Euler angles in degrees about the fixed axes x, then y, then z.
    pub(crate) fn angles(self, angles: [f64; 3]) -> [f64; 3] {
        if self.from == self.up {
            return angles;
        }
        let turn = self.turn();
        let rotation = turn * Rotation3::from_matrix_unchecked(euler_degrees(angles)) * turn.inverse();
        let (x, y, z) = rotation.euler_angles();
        [x, y, z].map(f64::to_degrees)
    }

    /// Returns the transformation of column vectors.
    pub(crate) fn matrix(self) -> Matrix4<f64> {
        self.turn().to_homogeneous() * Matrix4::new_scaling(self.scale)
    }

    fn turn(self) -> Rotation3<f64> {
        let axis =
            |axis: usize| self.direction(std::array::from_fn(|k| f64::from(u8::from(k == axis)))).into();
        Rotation3::from_matrix_unchecked(nalgebra::Matrix3::from_columns(&[0, 1, 2].map(axis)))
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Point3, Vector3};

    use super::*;

    #[test]
    fn the_up_axis_of_a_scene_is_against_gravity() {
        for (gravity, up) in [
            ([0.0, -9.81, 0.0], Up::Y),
            ([0.0, 0.0, -9.81], Up::Z),
            ([0.0, 0.0, 9.81], Up::Y),
            ([0.0; 3], Up::Y),
            ([0.0, -9.0, -3.0], Up::Y),
            ([0.0, 1.0, -3.0], Up::Z),
        ] {
            assert_eq!(Up::of_gravity(gravity), up, "{gravity:?}");
        }
    }

    #[test]
    fn the_axis_that_points_up_stays_up_and_turning_back_restores_positions() {
        let (y, z) = (FileSpace::new(Up::Y, Up::Z, 1.0), FileSpace::new(Up::Z, Up::Y, 1.0));
        assert_eq!(y.direction([0.0, 1.0, 0.0]), [0.0, 0.0, 1.0]);
        assert_eq!(z.direction([0.0, 0.0, 1.0]), [0.0, 1.0, 0.0]);
        assert_eq!(z.direction(y.direction([1.0, 2.0, 3.0])), [1.0, 2.0, 3.0]);
        for space in [y, z] {
            assert_eq!(space.turn().matrix().determinant(), 1.0, "right-handed axes stay right-handed");
        }
    }

    #[test]
    fn positions_matrices_and_angles_agree() {
        let point = [1.5, -2.0, 0.25];
        for (from, up) in [(Up::Y, Up::Z), (Up::Z, Up::Y), (Up::Z, Up::Z)] {
            let space = FileSpace::new(from, up, 100.0);
            let expected = space.position(point);
            assert_eq!(space.matrix().transform_point(&Point3::from(point)), Point3::from(expected));
            let mut positions = [point.map(|number| number as f32)];
            space.convert_positions(&mut positions);
            assert_eq!(positions[0].map(f64::from), expected);
            // A rotated point is the converted point, rotated by the converted angles.
            let angles = [20.0, 30.0, 140.0];
            let rotated = space.position((euler_degrees(angles) * Vector3::from(point)).into());
            let again = euler_degrees(space.angles(angles)) * Vector3::from(expected);
            // Angles and matrices are rounded to about 1e-16, and the point is 250 from the center.
            assert!((Vector3::from(rotated) - again).norm() < 1e-12);
        }
    }
}
