//! Points of a frame as 16-bit numbers, and their prediction from earlier frames.
//!
//! A point set has its own grid in each frame: 65,536 values per axis, or 4096 for a lattice, from the smallest to the
//! largest coordinate. The position of a point is that of the nearest grid point, so its error per axis is at most half
//! a grid step: the extent divided by 131,070, or by 8190.
//!
//! A set is packed as the differences between its values and their predictions, which compress better. A point is
//! expected to keep its velocity: x(t) = 2 x(t-1) - x(t-2), rounded to the grid. The error of the point before it in
//! the set is subtracted, because neighbors err alike. All coordinates are `f64` and all operations are exactly those
//! of JavaScript, so that a browser computes the same predictions.

/// Largest value of a coordinate of a mesh.
pub(super) const MESH_VALUES: u16 = 65535;

/// Largest value of a coordinate of a lattice. A lattice is drawn as lines, for which a fortieth of a percent of the
/// extent is enough, and has a third of the size that it would have with 16 bits.
pub(super) const LATTICE_VALUES: u16 = 4095;

/// Size of the bounds of a set, in bytes: smallest x, y, z, then largest x, y, z, as `f32`.
pub(super) const BOUNDS: usize = 24;

/// Size of a point, in bytes: x, y, z as `u16`.
pub(super) const POINT: usize = 6;

/// The grid of a set in a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Grid {
    largest: f64,
    low: [f64; 3],
    step: [f64; 3],
}

impl Grid {
    fn new(bounds: &[u8], largest: u16) -> Self {
        let largest = f64::from(largest);
        let number = |at: usize| f64::from(f32::from_le_bytes([0, 1, 2, 3].map(|k| bounds[4 * at + k])));
        let low = [0, 1, 2].map(number);
        Self { largest, low, step: [0, 1, 2].map(|axis| (number(3 + axis) - low[axis]) / largest) }
    }

    /// Returns the value nearest to a coordinate.
    fn value(&self, axis: usize, coordinate: f64) -> u16 {
        if self.step[axis] <= 0.0 {
            return 0;
        }
        ((coordinate - self.low[axis]) / self.step[axis] + 0.5).floor().clamp(0.0, self.largest) as u16
    }

    fn coordinate(&self, axis: usize, value: u16) -> f64 {
        self.low[axis] + f64::from(value) * self.step[axis]
    }
}

/// Returns the value of an axis of a point.
fn value(points: &[u8], point: usize, axis: usize) -> u16 {
    let at = POINT * point + 2 * axis;
    u16::from_le_bytes([points[at], points[at + 1]])
}

/// Appends the bounds of finite positions to `head`, and the positions as values up to `largest` to `points`.
pub(super) fn quantize(positions: &[[f32; 3]], largest: u16, head: &mut Vec<u8>, points: &mut Vec<u8>) {
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for position in positions {
        for axis in 0..3 {
            low[axis] = low[axis].min(position[axis]);
            high[axis] = high[axis].max(position[axis]);
        }
    }
    if positions.is_empty() {
        (low, high) = ([0.0; 3], [0.0; 3]);
    }
    let start = head.len();
    low.iter().chain(&high).for_each(|number| head.extend(number.to_le_bytes()));
    let grid = Grid::new(&head[start..], largest);
    for position in positions {
        for axis in 0..3 {
            points.extend(grid.value(axis, position[axis].into()).to_le_bytes());
        }
    }
}

/// Returns the positions of values.
pub(super) fn positions(bounds: &[u8], largest: u16, points: &[u8]) -> Vec<[f64; 3]> {
    let grid = Grid::new(bounds, largest);
    let position = |point| [0, 1, 2].map(|axis| grid.coordinate(axis, value(points, point, axis)));
    (0..points.len() / POINT).map(position).collect()
}

/// Predicts the values of a set from its last two frames.
#[derive(Clone, Debug)]
pub(super) struct Predictor {
    largest: u16,
    /// Positions one and two frames before; empty before the first frame.
    last: Vec<[f64; 3]>,
    second_last: Vec<[f64; 3]>,
}

impl Predictor {
    /// `largest`: largest value of a coordinate.
    pub(super) fn new(largest: u16) -> Self {
        Self { largest, last: Vec::new(), second_last: Vec::new() }
    }

    /// Appends the packed values to `packed`: the differences, zigzag-encoded, first the low bytes of all points, then
    /// the high bytes, each axis by axis.
    pub(super) fn pack(&mut self, bounds: &[u8], points: &[u8], packed: &mut Vec<u8>) {
        let count = points.len() / POINT;
        let grid = Grid::new(bounds, self.largest);
        let mut words = Vec::with_capacity(3 * count);
        for axis in 0..3 {
            let mut before = 0;
            for point in 0..count {
                let error = value(points, point, axis).wrapping_sub(self.predict(&grid, point, axis));
                let difference = error.wrapping_sub(before) as i16;
                words.push((difference << 1 ^ difference >> 15) as u16);
                before = error;
            }
        }
        packed.extend(words.iter().map(|word| *word as u8));
        packed.extend(words.iter().map(|word| (word >> 8) as u8));
        self.advance(positions(bounds, self.largest, points));
    }

    /// Appends the values of `packed`, which [`Predictor::pack`] returned, to `points`.
    pub(super) fn unpack(&mut self, bounds: &[u8], packed: &[u8], points: &mut Vec<u8>) {
        let count = packed.len() / POINT;
        let grid = Grid::new(bounds, self.largest);
        let (low, high) = packed.split_at(3 * count);
        let start = points.len();
        points.resize(start + packed.len(), 0);
        for axis in 0..3 {
            let mut error = 0_u16;
            for point in 0..count {
                let at = axis * count + point;
                let word = u16::from_le_bytes([low[at], high[at]]);
                error = error.wrapping_add(word >> 1 ^ (word & 1).wrapping_neg());
                let value = self.predict(&grid, point, axis).wrapping_add(error);
                let at = start + POINT * point + 2 * axis;
                points[at..at + 2].copy_from_slice(&value.to_le_bytes());
            }
        }
        self.advance(positions(bounds, self.largest, &points[start..]));
    }

    /// Returns the predicted value of an axis of a point, on the grid of the next frame.
    fn predict(&self, grid: &Grid, point: usize, axis: usize) -> u16 {
        let Some(last) = self.last.get(point) else { return 0 };
        match self.second_last.get(point) {
            Some(second_last) => grid.value(axis, last[axis] + (last[axis] - second_last[axis])),
            None => grid.value(axis, last[axis]),
        }
    }

    fn advance(&mut self, positions: Vec<[f64; 3]>) {
        self.second_last = std::mem::replace(&mut self.last, positions);
    }
}

/// Appends words, packed as their differences, zigzag-encoded: the lowest bytes of all words first, the highest last.
pub(super) fn pack_words(words: impl Iterator<Item = u32>, packed: &mut Vec<u8>) {
    let mut before = 0;
    let differences: Vec<u32> = words
        .map(|word| {
            let difference = word.wrapping_sub(std::mem::replace(&mut before, word)) as i32;
            (difference << 1 ^ difference >> 31) as u32
        })
        .collect();
    for byte in 0..4 {
        packed.extend(differences.iter().map(|word| (word >> (8 * byte)) as u8));
    }
}

/// Returns the words of [`pack_words`].
pub(super) fn unpack_words(packed: &[u8]) -> Vec<u32> {
    let count = packed.len() / 4;
    let mut before = 0_u32;
    let word = |index: usize| {
        let zigzag = u32::from_le_bytes(std::array::from_fn(|byte| packed[byte * count + index]));
        before = before.wrapping_add(zigzag >> 1 ^ (zigzag & 1).wrapping_neg());
        before
    };
    (0..count).map(word).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_read_back() {
        let words = [0, 1, u32::MAX, 7, 7, 1 << 31, 3];
        let mut packed = Vec::new();
        pack_words(words.into_iter(), &mut packed);
        assert_eq!(unpack_words(&packed), words);
    }

    /// Points on a rod that swings and stretches; one of them does not move, and z is the same for all.
    fn frame(time: f32) -> Vec<[f32; 3]> {
        let point = |k: u16| {
            let along = f32::from(k) / 40.0;
            let angle = time * time * 0.3;
            [along * angle.cos() * (1.0 + time), 1e3 + along * angle.sin(), -2.5]
        };
        (0..41).map(point).collect()
    }

    #[test]
    fn positions_are_within_half_a_grid_step() {
        let positions_before = frame(0.7);
        let (mut head, mut points) = (Vec::new(), Vec::new());
        quantize(&positions_before, MESH_VALUES, &mut head, &mut points);
        assert_eq!((head.len(), points.len()), (BOUNDS, POINT * 41));
        let grid = Grid::new(&head, MESH_VALUES);
        for (position, before) in positions(&head, MESH_VALUES, &points).iter().zip(&positions_before) {
            for axis in 0..3 {
                // Rounding in `f64` adds less than the unit roundoff times the coordinate, a few times.
                let bound = grid.step[axis] / 2.0 + 1e-15 * f64::from(before[axis]).abs();
                assert!((position[axis] - f64::from(before[axis])).abs() <= bound);
            }
        }
        assert_eq!(grid.step[2], 0.0, "a set without extent has one value");
        assert_eq!(positions(&[0; BOUNDS], MESH_VALUES, &[]), Vec::<[f64; 3]>::new());
    }

    #[test]
    fn packed_values_read_back_and_smooth_motion_has_small_differences() {
        let (mut packer, mut reader) = (Predictor::new(LATTICE_VALUES), Predictor::new(LATTICE_VALUES));
        for step in 0..6_u8 {
            let (mut head, mut points) = (Vec::new(), Vec::new());
            quantize(&frame(f32::from(step) / 30.0), LATTICE_VALUES, &mut head, &mut points);
            let (mut packed, mut read) = (Vec::new(), Vec::new());
            packer.pack(&head, &points, &mut packed);
            reader.unpack(&head, &packed, &mut read);
            assert_eq!(read, points, "frame {step}");
        }
        // A set at rest differs from its prediction by nothing.
        let (mut head, mut points, mut packed) = (Vec::new(), Vec::new(), Vec::new());
        quantize(&frame(0.3), LATTICE_VALUES, &mut head, &mut points);
        for _ in 0..3 {
            packed.clear();
            packer.pack(&head, &points, &mut packed);
        }
        assert!(packed.iter().all(|&byte| byte == 0), "{packed:?}");
    }

    #[test]
    fn extreme_coordinates_read_back() {
        let mut predictor = [Predictor::new(MESH_VALUES), Predictor::new(MESH_VALUES)];
        for sign in [1.0, -1.0, 1.0] {
            let corner = [f32::MAX * sign, f32::MIN_POSITIVE * sign, -1e-30];
            let (mut head, mut points) = (Vec::new(), Vec::new());
            quantize(&[corner, [-f32::MAX, 0.0, 1e-30], [0.0; 3]], MESH_VALUES, &mut head, &mut points);
            let (mut packed, mut read) = (Vec::new(), Vec::new());
            predictor[0].pack(&head, &points, &mut packed);
            predictor[1].unpack(&head, &packed, &mut read);
            assert_eq!(read, points);
        }
    }
}
