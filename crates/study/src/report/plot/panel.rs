//! One panel: an error over the run time of a frame, both logarithmic, with its front.

use plotters::chart::ChartBuilder;
use plotters::coord::Shift;
use plotters::coord::combinators::{BindKeyPoints, IntoLogRange};
use plotters::prelude::{DrawingArea, PathElement, SVGBackend};
use plotters::style::{BLACK, Color};

use super::Drawn;
use super::axis::{Axis, number};
use super::labels::Labels;
use super::mark::Mark;
use super::style::{FRONT, METHODS, colour, text};
use crate::front::Front;
use crate::point::Point;
use crate::setting;

/// What a panel shows.
pub(super) struct Panel<'a> {
    pub(super) front: Front,
    pub(super) title: &'a str,
    pub(super) unit: &'a str,
    pub(super) time: &'a Axis,
    pub(super) points: Vec<&'a Point>,
}

/// A point of the study on the page.
struct Placed<'a> {
    point: &'a Point,
    at: (i32, i32),
}

impl Panel<'_> {
    /// Draws it into its part of the page.
    pub(super) fn draw(
        &self,
        page: &DrawingArea<SVGBackend<'_>, Shift>,
        area: &DrawingArea<SVGBackend<'_>, Shift>,
    ) -> Drawn {
        let errors = || self.points.iter().filter_map(|point| self.front.error(point));
        let axis = Axis::around(errors());
        let log = |axis: &Axis| {
            axis.range
                .clone()
                .log_scale()
                .with_key_points(axis.ticks.clone())
                .with_light_points(axis.fine.clone())
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
            // An error of nothing at all stands at the foot of its panel.
            let error = error.max(axis.range.start);
            let at = chart.plotting_area().map_coordinate(&(point.timing.total.median, error));
            placed.push(Placed { point, at });
        }
        self.lines(page, &placed)?;
        self.front(page, &placed)?;
        for Placed { point, at } in &placed {
            let ringed = point.front.contains(&self.front);
            let colour = if point.sums == "fast" { colour(&point.method) } else { BLACK };
            Mark::of(point).draw(page, *at, colour, ringed)?;
        }
        self.labels(page, area, &placed)
    }

    /// A thin line a method, from coarse lattices to fine ones.
    fn lines(&self, page: &DrawingArea<SVGBackend<'_>, Shift>, placed: &[Placed<'_>]) -> Drawn {
        for (method, colour) in METHODS {
            let of_line = |point: &Point| {
                point.method == method
                    && matches!(point.axis, setting::Axis::Base | setting::Axis::Resolution)
            };
            let mut line: Vec<_> = placed.iter().filter(|placed| of_line(placed.point)).collect();
            line.sort_by_key(|placed| placed.point.lattice_vertices);
            page.draw(&PathElement::new(
                line.iter().map(|placed| placed.at).collect::<Vec<_>>(),
                colour.mix(0.6),
            ))?;
        }
        Ok(())
    }

    /// The front, as steps: up to the next point on it nothing faster is better than the last.
    fn front(&self, page: &DrawingArea<SVGBackend<'_>, Shift>, placed: &[Placed<'_>]) -> Drawn {
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

    /// Lattice vertices beside the points on the front, where there is room.
    fn labels(
        &self,
        page: &DrawingArea<SVGBackend<'_>, Shift>,
        area: &DrawingArea<SVGBackend<'_>, Shift>,
        placed: &[Placed<'_>],
    ) -> Drawn {
        let mut labels = Labels::new(area, placed.iter().map(|placed| placed.at));
        let usual =
            self.points.iter().find(|point| point.axis == setting::Axis::Base).map(|point| point.substeps);
        for Placed { point, at } in placed.iter().filter(|placed| placed.point.front.contains(&self.front)) {
            let mut label = point.lattice_vertices.to_string();
            if usual != Some(point.substeps) {
                label += &format!(", {} steps", point.substeps);
            }
            labels.draw(page, *at, &label)?;
        }
        Ok(())
    }
}
