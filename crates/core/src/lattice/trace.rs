//! The trace of triangles in a grid: the cells that they enter, and the faces of cells that they lie on.

use super::bitmap::Bitmap;
use super::overlap::TriangleAxes;

/// Boxes of cells up to this number are tested cell by cell; larger ones are halved first.
const SMALL_BOX: i64 = 16;

/// What the triangles leave in the grid.
pub(crate) struct Trace {
    /// Cells whose inside some triangle enters.
    pub(crate) entered: Bitmap,
    /// For each axis, where a triangle lies in a grid plane across it.
    pub(crate) faces: [Option<Faces>; 3],
}

/// Faces of cells, across one axis, on which a triangle lies; each is kept with the upper of its two cells.
pub(crate) struct Faces {
    /// The normal of the triangle points up the axis.
    up: Bitmap,
    /// The normal of the triangle points down the axis.
    down: Bitmap,
}

impl Trace {
    pub(crate) fn new(size: [usize; 3]) -> Self {
        Self { entered: Bitmap::new(size), faces: [None, None, None] }
    }

    /// Adds a triangle; false if it enters no cell and lies in no single grid plane: it has no area, or too little.
    pub(crate) fn add(&mut self, corners: &[[f64; 3]; 3]) -> bool {
        let [a, b, c] = corners;
        // No coordinate is negative, so that whole numbers come from cutting off.
        let mut low: [i32; 3] = std::array::from_fn(|k| a[k].min(b[k]).min(c[k]) as i32);
        let mut high: [i32; 3] = std::array::from_fn(|k| {
            let highest = a[k].max(b[k]).max(c[k]);
            highest as i32 + i32::from(f64::from(highest as i32) < highest)
        });
        let mut flat = (0..3).filter(|&k| low[k] == high[k]);
        let Some(axis) = flat.next() else {
            return Boxes { corners, flat: None }.visit(low, high, &mut |cell| self.entered.set(cell));
        };
        if flat.next().is_some() {
            return false;
        }
        // A triangle in a plane overlaps the squares of the plane as it does boxes of two cells about the plane.
        low[axis] -= 1;
        high[axis] += 1;
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let area = (b[u] - a[u]) * (c[v] - a[v]) - (b[v] - a[v]) * (c[u] - a[u]);
        let size = self.entered.size();
        let faces =
            self.faces[axis].get_or_insert_with(|| Faces { up: Bitmap::new(size), down: Bitmap::new(size) });
        let side = if area < 0.0 { &mut faces.down } else { &mut faces.up };
        Boxes { corners, flat: Some(axis) }.visit(low, high, &mut |mut cell| {
            cell[axis] += 1;
            side.set(cell);
        })
    }

    /// All faces across an axis on which a triangle lies.
    pub(crate) fn walls(&self, axis: usize) -> Option<Bitmap> {
        let faces = self.faces[axis].as_ref()?;
        let mut walls = faces.up.clone();
        walls.insert(&faces.down);
        Some(walls)
    }

    /// The cells to which faces in grid planes belong: those on the inner side, by the flood; where both sides are open, by the
    /// normal, and for a sheet with two sides the lower one.
    pub(crate) fn cells_behind_faces(&self, outside: &Bitmap, flipped: bool) -> Vec<[i32; 3]> {
        let mut cells = Vec::new();
        for (axis, faces) in self.faces.iter().enumerate() {
            let Some(Faces { up, down }) = faces else { continue };
            let (front, back) = if flipped { (down, up) } else { (up, down) };
            let only_back = back.cells().filter(|cell| !front.get(*cell)).map(|cell| (cell, false));
            for (upper, faces_up) in front.cells().map(|cell| (cell, true)).chain(only_back) {
                let mut lower = upper;
                lower[axis] -= 1;
                let preferred = if faces_up { [lower, upper] } else { [upper, lower] };
                match (outside.get(upper), outside.get(lower)) {
                    (false, false) => {}
                    (false, true) => cells.push(upper),
                    (true, false) => cells.push(lower),
                    (true, true) => cells.extend(preferred.into_iter().find(|cell| outside.within(*cell))),
                }
            }
        }
        cells
    }
}

/// The boxes that a triangle enters: single cells, or, for a triangle in a plane across the axis `flat`, pairs of cells about it.
struct Boxes<'a> {
    corners: &'a [[f64; 3]; 3],
    flat: Option<usize>,
}

impl Boxes<'_> {
    /// Visits, by their lower cell, the boxes that the triangle enters between two corners of the grid, around its own extent; false
    /// if there are none.
    fn visit(&self, low: [i32; 3], high: [i32; 3], emit: &mut impl FnMut([i32; 3])) -> bool {
        if self.count(low, high) == 1 {
            // A triangle within one cell that lies in no plane of it enters it.
            emit(low);
            return true;
        }
        self.visit_part(&TriangleAxes::new(self.corners), low, high, emit)
    }

    fn extent(&self, low: [i32; 3], high: [i32; 3], axis: usize) -> i64 {
        if self.flat == Some(axis) { 1 } else { i64::from(high[axis] - low[axis]) }
    }

    fn count(&self, low: [i32; 3], high: [i32; 3]) -> i64 {
        (0..3).map(|axis| self.extent(low, high, axis)).fold(1, i64::saturating_mul)
    }

    fn visit_part(
        &self,
        axes: &TriangleAxes,
        low: [i32; 3],
        high: [i32; 3],
        emit: &mut impl FnMut([i32; 3]),
    ) -> bool {
        let count = self.count(low, high);
        if count > SMALL_BOX {
            if !axes.enter(low.map(f64::from), high.map(f64::from)) {
                return false;
            }
            let axis = (0..3).max_by_key(|&axis| self.extent(low, high, axis)).unwrap_or(0);
            let middle = low[axis] + (high[axis] - low[axis]) / 2;
            let (mut lower_high, mut upper_low) = (high, low);
            lower_high[axis] = middle;
            upper_low[axis] = middle;
            return self.visit_part(axes, low, lower_high, emit)
                | self.visit_part(axes, upper_low, high, emit);
        }
        let step: [i32; 3] = std::array::from_fn(|axis| if self.flat == Some(axis) { 2 } else { 1 });
        let mut entered = false;
        for z in (low[2]..high[2]).step_by(step[2] as usize) {
            for y in (low[1]..high[1]).step_by(step[1] as usize) {
                for x in (low[0]..high[0]).step_by(step[0] as usize) {
                    let end = [x + step[0], y + step[1], z + step[2]];
                    if axes.enter([x, y, z].map(f64::from), end.map(f64::from)) {
                        emit([x, y, z]);
                        entered = true;
                    }
                }
            }
        }
        entered
    }
}
