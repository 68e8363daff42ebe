//! `study.svg`: error over run time, a panel an error.

mod axis;
mod labels;
mod legend;
mod mark;
mod panel;
mod style;

use std::path::Path;

use plotters::prelude::{DrawingAreaErrorKind, IntoDrawingArea, SVGBackend, WHITE};
use plotters::style::Color;

use super::Report;
use crate::error::StudyError;
use crate::front::Front;
use crate::output::write_whole;
use axis::Axis;
use panel::Panel;
use style::text;

/// Pixels, as a browser shows them at its own scale.
const SIZE: (u32, u32) = (1180, 1000);
const TITLE: u32 = 64;
const LEGEND: u32 = 96;

/// What the panels show, in reading order.
const PANELS: [(Front, &str, &str); 4] = [
    (Front::Surface, "Surface: distance from the finest lattice", "rms distance / diagonal"),
    (Front::Volume, "Volume: of the mesh, greatest in the motion", "|volume / volume at rest - 1|"),
    (Front::Cells, "Cells: their volumes one by one", "rms of volume / volume at rest - 1"),
    (Front::Path, "Path: distance from the naive sums in f64", "rms distance, cells"),
];

/// Draws the plot.
pub(super) fn write(report: &Report, path: &Path) -> Result<(), StudyError> {
    let mut svg = String::new();
    draw(report, &mut svg)
        .map_err(|error| StudyError::Plot { path: path.to_owned(), what: error.to_string() })?;
    write_whole(path, svg.as_bytes())
}

type Drawn = Result<(), DrawingAreaErrorKind<std::io::Error>>;

fn draw(report: &Report, svg: &mut String) -> Drawn {
    let page = SVGBackend::with_string(svg, SIZE).into_drawing_area();
    page.fill(&WHITE)?;
    let (_, rest) = page.split_vertically(TITLE);
    let (panels, _) = rest.split_vertically(SIZE.1 - TITLE - LEGEND);
    let grey = plotters::style::BLACK.mix(0.7);
    let title = format!("{}: error against run time", report.scene);
    page.draw_text(&title, &text(22.0, &plotters::style::BLACK), (20, 12))?;
    page.draw_text(&report.machine.line(), &text(14.0, &grey), (20, 42))?;
    let times = report.points.iter().map(|point| point.timing.total.median);
    let time = Axis::around(times);
    for (area, (front, title, unit)) in panels.split_evenly((2, 2)).iter().zip(PANELS) {
        let points = report.points.iter().filter(|point| front.tells(point, &report.method)).collect();
        Panel { front, title, unit, time: &time, points }.draw(&page, area)?;
    }
    legend::draw(&page, (SIZE.1 - LEGEND) as i32)?;
    page.present()
}
