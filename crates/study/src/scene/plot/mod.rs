//! Draws `study.svg`: error over run time, with one panel per error.

mod axis;
mod mark;
mod panel;

use std::path::Path;

use plotters::prelude::{IntoDrawingArea, PathElement, SVGBackend, WHITE};
use plotters::style::{BLACK, Color};

use super::point::Front;
use super::report::Report;
use crate::error::StudyError;
use crate::output::write_atomically;
use axis::Axis;
use mark::{Area, Drawn, FRONT, METHODS, Mark, text};
use panel::Panel;

/// Size of the page, in pixels.
const SIZE: (u32, u32) = (1180, 1000);
/// Height of the title, in pixels.
const TITLE: u32 = 64;
/// Height of the legend, in pixels.
const LEGEND: u32 = 96;

/// Error, title and unit of each panel, in reading order.
const PANELS: [(Front, &str, &str); 4] = [
    (Front::Surface, "Surface: distance from the finest lattice", "rms distance / diagonal"),
    (Front::Volume, "Volume: of the mesh, maximum in the motion", "|volume / volume at rest - 1|"),
    (Front::Cells, "Cells: volumes of the individual cells", "rms of volume / volume at rest - 1"),
    (Front::Path, "Path: distance from the naive sums in f64", "rms distance, cells"),
];

/// Draws the plot.
pub(super) fn write(report: &Report, path: &Path) -> Result<(), StudyError> {
    let mut svg = String::new();
    page(report, &mut svg)
        .map_err(|error| StudyError::Plot { path: path.to_owned(), what: error.to_string() })?;
    write_atomically(path, svg.as_bytes())
}

/// Draws the whole page into `svg`.
fn page(report: &Report, svg: &mut String) -> Drawn {
    let page = SVGBackend::with_string(svg, SIZE).into_drawing_area();
    page.fill(&WHITE)?;
    let (_, rest) = page.split_vertically(TITLE);
    let (panels, _) = rest.split_vertically(SIZE.1 - TITLE - LEGEND);
    let grey = BLACK.mix(0.7);
    let title = format!("{}: error against run time", report.scene);
    page.draw_text(&title, &text(22.0, &BLACK), (20, 12))?;
    page.draw_text(&report.machine.line(), &text(14.0, &grey), (20, 42))?;
    let times = report.points.iter().map(|point| point.timing.total.median);
    let time = Axis::around(times);
    for (area, (front, title, unit)) in panels.split_evenly((2, 2)).iter().zip(PANELS) {
        let points = report.points.iter().filter(|point| front.applies_to(point, &report.method)).collect();
        Panel { front, title, unit, time: &time, points }.draw(&page, area)?;
    }
    legend(&page, (SIZE.1 - LEGEND) as i32)?;
    page.present()
}

/// Width of a legend entry of a method, in pixels.
const METHOD: i32 = 160;
/// Width of a legend entry of a mark, in pixels.
const MARK: i32 = 192;

/// Draws the legend at the bottom of the page, `top` pixels from the top.
fn legend(page: &Area<'_>, top: i32) -> Drawn {
    let style = text(14.0, &BLACK);
    for (index, (name, color)) in METHODS.iter().enumerate() {
        let at = (30 + METHOD * index as i32, top + 22);
        Mark::Circle.draw(page, at, *color, false)?;
        let label = if *name == "off" { "volume not preserved" } else { name };
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
    let label = "front: no point is both faster and better; labels: lattice vertices, and steps per frame if \
                 not the scene's. At the bottom of a panel: error 0";
    page.draw_text(label, &style, (54, at - 8))
}
