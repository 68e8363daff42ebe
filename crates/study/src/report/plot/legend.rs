//! The legend: a colour a method, a mark an axis, the front.

use plotters::coord::Shift;
use plotters::prelude::{DrawingArea, PathElement, SVGBackend};
use plotters::style::{BLACK, Color};

use super::Drawn;
use super::mark::Mark;
use super::style::{FRONT, METHODS, text};

/// Pixels from one entry to the next.
const METHOD: i32 = 160;
const MARK: i32 = 232;

/// Draws the legend at the foot of the page, `top` pixels from its head.
pub(super) fn draw(page: &DrawingArea<SVGBackend<'_>, Shift>, top: i32) -> Drawn {
    let style = text(14.0, &BLACK);
    for (index, (name, colour)) in METHODS.iter().enumerate() {
        let at = (30 + METHOD * index as i32, top + 22);
        Mark::Circle.draw(page, at, *colour, false)?;
        let label = if *name == "off" { "volume not kept" } else { name };
        page.draw_text(label, &style, (at.0 + 12, at.1 - 8))?;
    }
    for (index, (mark, label)) in Mark::NAMED.iter().enumerate() {
        let at = (30 + MARK * index as i32, top + 48);
        mark.draw(page, at, BLACK, false)?;
        page.draw_text(label, &style, (at.0 + 12, at.1 - 8))?;
    }
    let at = top + 74;
    page.draw(&PathElement::new([(14, at), (46, at)], FRONT.stroke_width(2)))?;
    Mark::Circle.draw(page, (30, at), BLACK, true)?;
    let label = "front: nothing is both faster and better; lattice vertices beside it, and steps a frame where these are \
                 not the scene's. At the foot of a panel: no error at all";
    page.draw_text(label, &style, (54, at - 8))
}
