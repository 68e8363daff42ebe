//! Draws one panel: an error over the run time of a frame on logarithmic axes, with the front and its labels.

use std::ops::Range;

use plotters::chart::ChartBuilder;
use plotters::coord::combinators::{BindKeyPoints, IntoLogRange};
use plotters::prelude::PathElement;
use plotters::style::{BLACK, Color};
use supple_io::counted;

use super::axis::{Axis, number};
use super::mark::{Area, Drawn, FRONT, METHODS, Mark, RADIUS, color, text};
use crate::scene::point::{Front, Point};
use crate::scene::setting;

/// Contents of a panel.
pub(super) struct Panel<'a> {
    pub(super) front: Front,
    pub(super) title: &'a str,
    pub(super) unit: &'a str,
    pub(super) time: &'a Axis,
    pub(super) points: Vec<&'a Point>,
}

/// A point of the study and the pixel on the page at which it is drawn.
struct Placed<'a> {
    point: &'a Point,
    at: (i32, i32),
}

impl Panel<'_> {
    /// Draws the panel into `area`.
    pub(super) fn draw(&self, page: &Area<'_>, area: &Area<'_>) -> Drawn {
        let errors = || self.points.iter().filter_map(|point| self.front.error(point));
        let axis = Axis::around(errors());
        let log = |axis: &Axis| {
            axis.range
                .clone()
                .log_scale()
                .with_key_points(axis.ticks.clone())
                .with_light_points(axis.grid_lines.clone())
        };
        let mut chart = ChartBuilder::on(area)
            .caption(self.title, text(17.0, &BLACK))
            .margin(14)
            .x_label_area_size(44)
            .y_label_area_size(66)
            .build_cartesian_2d(log(self.time), log(&axis))?;
        chart
            .configure_mesh()
            .bold_line_style(BLACK.mix(0.22))
            .light_line_style(BLACK.mix(0.07))
            .label_style(text(13.0, &BLACK))
            .axis_desc_style(text(14.0, &BLACK))
            .x_desc("run time of a frame, ms")
            .y_desc(self.unit)
            .x_label_formatter(&|x| number(*x))
            .y_label_formatter(&|y| number(*y))
            .draw()?;
        let mut placed = Vec::new();
        for &point in &self.points {
            let Some(error) = self.front.error(point) else { continue };
            // An error of 0 is drawn at the bottom of the panel.
            let error = error.max(axis.range.start);
            let at = chart.plotting_area().map_coordinate(&(point.timing.total.median, error));
            placed.push(Placed { point, at });
        }
        self.lines(page, &placed)?;
        self.front(page, &placed)?;
        for Placed { point, at } in &placed {
            let ringed = point.front.contains(&self.front);
            let color = if point.sums == "fast" { color(&point.method) } else { BLACK };
            Mark::of(point).draw(page, *at, color, ringed)?;
        }
        self.labels(
            page,
            Labels::new(chart.plotting_area().get_pixel_range(), placed.iter().map(|placed| placed.at)),
            &placed,
        )
    }

    /// Draws a thin line for each method, from coarse to fine lattices.
    fn lines(&self, page: &Area<'_>, placed: &[Placed<'_>]) -> Drawn {
        for (method, color) in METHODS {
            let is_on_line = |point: &Point| {
                point.method == method
                    && matches!(point.axis, setting::Axis::Base | setting::Axis::Resolution)
            };
            let mut line: Vec<_> = placed.iter().filter(|placed| is_on_line(placed.point)).collect();
            line.sort_by_key(|placed| placed.point.lattice_vertices);
            page.draw(&PathElement::new(
                line.iter().map(|placed| placed.at).collect::<Vec<_>>(),
                color.mix(0.6),
            ))?;
        }
        Ok(())
    }

    /// Draws the front as a staircase. For run times between two points on the front, the faster of the two
    /// is the best choice, so the line keeps its error.
    fn front(&self, page: &Area<'_>, placed: &[Placed<'_>]) -> Drawn {
        let mut best: Vec<_> =
            placed.iter().filter(|placed| placed.point.front.contains(&self.front)).collect();
        best.sort_by_key(|placed| placed.at.0);
        let mut steps: Vec<(i32, i32)> = Vec::new();
        for placed in best {
            steps.extend(steps.last().map(|last| (placed.at.0, last.1)));
            steps.push(placed.at);
        }
        page.draw(&PathElement::new(steps, FRONT.stroke_width(2)))
    }

    /// Labels the points on the front with their number of lattice vertices, where there is free space.
    fn labels(&self, page: &Area<'_>, mut labels: Labels, placed: &[Placed<'_>]) -> Drawn {
        let usual =
            self.points.iter().find(|point| point.axis == setting::Axis::Base).map(|point| point.substeps);
        for Placed { point, at } in placed.iter().filter(|placed| placed.point.front.contains(&self.front)) {
            let mut label = point.lattice_vertices.to_string();
            if usual != Some(point.substeps) {
                label += &format!(", {}", counted(point.substeps as usize, "step"));
            }
            labels.draw(page, *at, &label)?;
        }
        Ok(())
    }
}

/// Height of the letters, in pixels.
const SIZE: i32 = 12;
/// Approximate width of a letter, in pixels.
const WIDTH: i32 = 7;
/// Distance from the center of a mark to its label, in pixels.
const GAP: i32 = 11;

/// A rectangle in pixels: left, top, right, bottom.
type Rectangle = [i32; 4];

/// Places the labels of a panel on free space.
struct Labels {
    panel: Rectangle,
    /// Rectangles of marks and of labels that are already drawn.
    occupied: Vec<Rectangle>,
}

impl Labels {
    /// Creates the labels of a panel with the pixel ranges x and y, and marks at the given pixels.
    fn new((x, y): (Range<i32>, Range<i32>), marks: impl Iterator<Item = (i32, i32)>) -> Self {
        let occupied = marks.map(|(x, y)| [x - RADIUS, y - RADIUS, x + RADIUS, y + RADIUS]).collect();
        Self { panel: [x.start, y.start, x.end, y.end], occupied }
    }

    /// Draws a label at the first free side of a mark, or nothing if no side is free.
    fn draw(&mut self, page: &Area<'_>, (x, y): (i32, i32), label: &str) -> Drawn {
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
            let rectangle = [left, top, left + width, top + SIZE];
            let [l, t, r, b] = self.panel;
            let inside = rectangle[0] >= l && rectangle[1] >= t && rectangle[2] <= r && rectangle[3] <= b;
            (inside && !self.occupied.iter().any(|other| overlap(&rectangle, other))).then_some(rectangle)
        });
        let Some(rectangle) = free else { return Ok(()) };
        self.occupied.push(rectangle);
        page.draw_text(label, &text(f64::from(SIZE), &BLACK), (rectangle[0], rectangle[1]))
    }
}

/// Returns whether two rectangles overlap.
fn overlap(a: &Rectangle, b: &Rectangle) -> bool {
    a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3]
}
