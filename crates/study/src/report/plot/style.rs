//! Colours and letters of the plot.

use plotters::style::{BLACK, Color, FontStyle, IntoFont, RGBColor, TextStyle};

/// A colour a method (Okabe & Ito 2008: told apart by those who see fewer colours too).
pub(super) const METHODS: [(&str, RGBColor); 7] = [
    ("off", RGBColor(130, 130, 130)),
    ("lattice global", RGBColor(230, 159, 0)),
    ("lattice regional", RGBColor(213, 94, 0)),
    ("cells global", RGBColor(86, 180, 233)),
    ("cells regional", RGBColor(0, 114, 178)),
    ("mesh global", RGBColor(0, 158, 115)),
    ("mesh regional", RGBColor(204, 121, 167)),
];

/// The colour of the front.
pub(super) const FRONT: RGBColor = RGBColor(40, 40, 40);

/// The colour of a method.
pub(super) fn colour(method: &str) -> RGBColor {
    METHODS.iter().find(|(name, _)| *name == method).map_or(BLACK, |(_, colour)| *colour)
}

/// Letters of a size in a colour.
pub(super) fn text<'a>(size: f64, colour: &'a impl Color) -> TextStyle<'a> {
    ("sans-serif", size, FontStyle::Normal).into_font().color(colour)
}
