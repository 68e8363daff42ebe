//! Marks: what stands for a point.

use plotters::coord::Shift;
use plotters::prelude::{Circle, DrawingArea, PathElement, Polygon, SVGBackend};
use plotters::style::{BLACK, Color, RGBColor, WHITE};

use super::Drawn;
use crate::point::Point;
use crate::setting::Axis;

/// Pixels from the middle of a mark to its edge, and to a ring around it.
pub(super) const RADIUS: i32 = 5;
const RING: i32 = 8;

/// A mark an axis of the matrix.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Mark {
    Circle,
    Triangle,
    Cross,
    Square,
    Diamond,
}

impl Mark {
    /// All of them, and what they stand for.
    pub(super) const NAMED: [(Self, &str); 5] = [
        (Self::Circle, "lattices, coarse to fine"),
        (Self::Triangle, "other steps a frame"),
        (Self::Cross, "other half-width: another material"),
        (Self::Square, "naive sums"),
        (Self::Diamond, "naive sums, breadth-first regions"),
    ];

    /// The mark of a point.
    pub(super) fn of(point: &Point) -> Self {
        match point.axis {
            Axis::Base | Axis::Resolution => Self::Circle,
            Axis::Substeps => Self::Triangle,
            Axis::HalfWidth => Self::Cross,
            Axis::Sums if point.sums == "naive" => Self::Square,
            Axis::Sums => Self::Diamond,
        }
    }

    /// Draws it at a pixel.
    pub(super) fn draw(
        self,
        area: &DrawingArea<SVGBackend<'_>, Shift>,
        (x, y): (i32, i32),
        colour: RGBColor,
        ringed: bool,
    ) -> Drawn {
        if ringed {
            area.draw(&Circle::new((x, y), RING, WHITE.filled()))?;
            area.draw(&Circle::new((x, y), RING, BLACK.stroke_width(2)))?;
        }
        let polygon = |corners: &[(i32, i32)]| {
            let corners: Vec<_> = corners.iter().map(|(dx, dy)| (x + dx, y + dy)).collect();
            area.draw(&Polygon::new(corners, colour.filled()))
        };
        let r = RADIUS;
        match self {
            Self::Circle => area.draw(&Circle::new((x, y), r, colour.filled())),
            Self::Triangle => polygon(&[(0, -r), (r, r - 1), (-r, r - 1)]),
            Self::Square => polygon(&[(-r, -r), (r, -r), (r, r), (-r, r)]),
            Self::Diamond => polygon(&[(0, -r - 1), (r + 1, 0), (0, r + 1), (-r - 1, 0)]),
            Self::Cross => {
                let stroke = colour.stroke_width(3);
                area.draw(&PathElement::new([(x - r, y - r), (x + r, y + r)], stroke))?;
                area.draw(&PathElement::new([(x - r, y + r), (x + r, y - r)], stroke))
            }
        }
    }
}
