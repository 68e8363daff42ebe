//! Labels beside marks, where they hide nothing.

use plotters::coord::Shift;
use plotters::prelude::{DrawingArea, SVGBackend};
use plotters::style::BLACK;

use super::Drawn;
use super::mark::RADIUS;
use super::style::text;

/// Height of the letters, and about their width, in pixels.
const SIZE: i32 = 12;
const WIDTH: i32 = 7;
/// From the middle of a mark to its label.
const GAP: i32 = 11;

/// A rectangle in pixels: left, top, right, bottom.
type Rectangle = [i32; 4];

/// The labels of a panel.
pub(super) struct Labels {
    panel: Rectangle,
    taken: Vec<Rectangle>,
}

impl Labels {
    /// For a panel with marks at these pixels.
    pub(super) fn new(
        area: &DrawingArea<SVGBackend<'_>, Shift>,
        marks: impl Iterator<Item = (i32, i32)>,
    ) -> Self {
        let (x, y) = area.get_pixel_range();
        let taken = marks.map(|(x, y)| [x - RADIUS, y - RADIUS, x + RADIUS, y + RADIUS]).collect();
        Self { panel: [x.start, y.start, x.end, y.end], taken }
    }

    /// Draws a label beside a mark, on the first side where it has room; nowhere if there is none.
    pub(super) fn draw(
        &mut self,
        page: &DrawingArea<SVGBackend<'_>, Shift>,
        (x, y): (i32, i32),
        label: &str,
    ) -> Drawn {
        let width = WIDTH * label.chars().count() as i32;
        let corners = [
            (x + GAP, y - SIZE - 3),
            (x + GAP, y + 3),
            (x - GAP - width, y + 3),
            (x - GAP - width, y - SIZE - 3),
            (x - width / 2, y - GAP - SIZE),
            (x - width / 2, y + GAP),
        ];
        let free = corners.into_iter().find_map(|(left, top)| {
            let own = [left, top, left + width, top + SIZE];
            let [l, t, r, b] = self.panel;
            let inside = own[0] >= l && own[1] >= t && own[2] <= r && own[3] <= b;
            (inside && !self.taken.iter().any(|other| overlap(&own, other))).then_some(own)
        });
        let Some(own) = free else { return Ok(()) };
        self.taken.push(own);
        page.draw_text(label, &text(f64::from(SIZE), &BLACK), (own[0], own[1]))
    }
}

fn overlap(a: &Rectangle, b: &Rectangle) -> bool {
    a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3]
}
