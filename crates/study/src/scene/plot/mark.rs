//! Defines the marks of points, colors and text styles of the plot.

use plotters::coord::Shift;
use plotters::prelude::{Circle, DrawingArea, DrawingAreaErrorKind, PathElement, Polygon, SVGBackend};
use plotters::style::{BLACK, Color, FontStyle, IntoFont, RGBColor, TextStyle, WHITE};

use crate::scene::point::Point;
use crate::scene::setting::Axis;

/// The page, or a part of it.
pub(super) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
pub(super) type Drawn = Result<(), DrawingAreaErrorKind<std::io::Error>>;

/// Radius of a mark, in pixels.
pub(super) const RADIUS: i32 = 5;
/// Radius of the ring around marks on a front, in pixels.
const RING: i32 = 8;

/// Shape of a mark. It shows which parameter of the point differs from the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Mark {
    Circle,
    Triangle,
    Cross,
    Plus,
    Square,
    Diamond,
}

impl Mark {
    /// All marks with their descriptions in the legend.
    pub(super) const NAMED: [(Self, &str); 6] = [
        (Self::Circle, "lattices, coarse to fine"),
        (Self::Triangle, "other steps per frame"),
        (Self::Cross, "half-width: new material"),
        (Self::Plus, "half-width, same material"),
        (Self::Square, "naive sums"),
        (Self::Diamond, "naive, breadth-first"),
    ];

    /// Returns the mark of a point.
    pub(super) fn of(point: &Point) -> Self {
        match point.axis {
            Axis::Base | Axis::Resolution => Self::Circle,
            Axis::Substeps => Self::Triangle,
            Axis::HalfWidth => Self::Cross,
            Axis::Regions => Self::Plus,
            Axis::Sums if point.sums == "naive" => Self::Square,
            Axis::Sums => Self::Diamond,
        }
    }

    /// Draws the mark at a pixel, with a ring if `ringed`.
    pub(super) fn draw(self, area: &Area<'_>, (x, y): (i32, i32), color: RGBColor, ringed: bool) -> Drawn {
        if ringed {
            area.draw(&Circle::new((x, y), RING, WHITE.filled()))?;
            area.draw(&Circle::new((x, y), RING, BLACK.stroke_width(2)))?;
        }
        let polygon = |corners: &[(i32, i32)]| {
            let corners: Vec<_> = corners.iter().map(|(dx, dy)| (x + dx, y + dy)).collect();
            area.draw(&Polygon::new(corners, color.filled()))
        };
        let lines = |ends: [[(i32, i32); 2]; 2]| {
            ends.iter().try_for_each(|line| {
                let line = line.map(|(dx, dy)| (x + dx, y + dy));
                area.draw(&PathElement::new(line, color.stroke_width(3)))
            })
        };
        let r = RADIUS;
        match self {
            Self::Circle => area.draw(&Circle::new((x, y), r, color.filled())),
            Self::Triangle => polygon(&[(0, -r), (r, r - 1), (-r, r - 1)]),
            Self::Square => polygon(&[(-r, -r), (r, -r), (r, r), (-r, r)]),
            Self::Diamond => polygon(&[(0, -r - 1), (r + 1, 0), (0, r + 1), (-r - 1, 0)]),
            Self::Cross => lines([[(-r, -r), (r, r)], [(-r, r), (r, -r)]]),
            Self::Plus => lines([[(-r, 0), (r, 0)], [(0, -r), (0, r)]]),
        }
    }
}

/// Color of each method of volume preservation, from a palette that is safe for color-blind readers (Okabe &
/// Ito 2008).
pub(super) const METHODS: [(&str, RGBColor); 7] = [
    ("off", RGBColor(130, 130, 130)),
    ("lattice global", RGBColor(230, 159, 0)),
    ("lattice regional", RGBColor(213, 94, 0)),
    ("cells global", RGBColor(86, 180, 233)),
    ("cells regional", RGBColor(0, 114, 178)),
    ("mesh global", RGBColor(0, 158, 115)),
    ("mesh regional", RGBColor(204, 121, 167)),
];

/// Color of the line of a front.
pub(super) const FRONT: RGBColor = RGBColor(40, 40, 40);

/// Returns the color of a method of volume preservation.
pub(super) fn color(method: &str) -> RGBColor {
    METHODS.iter().find(|(name, _)| *name == method).map_or(BLACK, |(_, color)| *color)
}

/// Returns a text style of a size and a color.
pub(super) fn text<'a>(size: f64, color: &'a impl Color) -> TextStyle<'a> {
    ("sans-serif", size, FontStyle::Normal).into_font().color(color)
}
