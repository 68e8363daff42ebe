//! Reads the maps of a file, which give each `v` a number, in a pass of its own, because only selections of maps need them.

use super::Document;
use super::lines::{Statements, Words};
use super::numbers::{Numbers, finite_or_zero};

/// The maps of a color: `alpha` is its opacity.
pub(crate) const COLORS: [&str; 4] = ["red", "green", "blue", "alpha"];

/// Value of the maps of colors, also `alpha`, at a vertex without a color.
pub(crate) const WHITE: f32 = 1.0;

/// Greatest number of a color whose numbers are bytes.
const BYTE: f32 = 255.0;

impl Document {
    /// Returns the maps of the file: names, and a finite number for each `v`.
    ///
    /// The three or four numbers after the position of a `v` of an OBJ file are a color: the maps `red`, `green`, `blue`
    /// and `alpha`. If one of them is above 1 in the file, all are divided by 255. A `v` without a color is white, 1, if
    /// another one has a color. Text that is not a finite number counts as 0.
    ///
    /// The document of a refined mesh has only the maps of OBJ files.
    pub fn maps(&self) -> Vec<(String, Vec<f32>)> {
        match self.own_maps() {
            None => self.color_maps(),
            Some(maps) => {
                let maps = maps.iter().filter(|(_, values)| values.len() == self.vertex_count());
                maps.cloned().collect()
            }
        }
    }

    /// Returns the maps of the colors in `v` statements.
    fn color_maps(&self) -> Vec<(String, Vec<f32>)> {
        let mut colors: Vec<[Option<f32>; 4]> = Vec::new();
        for (v, numbers) in self.vertex_numbers().iter().enumerate() {
            let color = self.color(numbers);
            if color[0].is_some() {
                colors.resize(v, [None; 4]);
                colors.push(color);
            }
        }
        let numbers = colors.iter().flatten().flatten();
        let divisor = if numbers.copied().any(|number| number > 1.0) { BYTE } else { 1.0 };
        let map = |(channel, name): (usize, &str)| {
            let given = colors.iter().map(|color| color[channel].map(|number| number / divisor));
            given.clone().any(|number| number.is_some()).then(|| {
                let mut values: Vec<f32> = given.map(|number| number.unwrap_or(WHITE)).collect();
                values.resize(self.vertex_count(), WHITE);
                (name.to_owned(), values)
            })
        };
        COLORS.into_iter().enumerate().filter_map(map).collect()
    }

    /// Returns the color of a `v` as in the file: three numbers or four, or none if another number of words follows the
    /// position.
    fn color(&self, numbers: &Numbers) -> [Option<f32>; 4] {
        let rest = &self.bytes()[numbers.span().end..];
        let mut color = [None; 4];
        let Some(statement) = Statements::new(rest).next() else { return color };
        let mut count = 0;
        for word in Words::new(rest, &statement.bytes) {
            let Some(channel) = color.get_mut(count) else { return [None; 4] };
            *channel = Some(finite_or_zero(&rest[word]));
            count += 1;
        }
        if count < 3 { [None; 4] } else { color }
    }
}
