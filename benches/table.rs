//! Formats the table of results: measured figures, targets, and whether the targets are met.

use std::fmt;

/// Target of a figure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Target {
    /// The figure must be at most this number.
    AtMost(f64),
    /// The figure must be at least this number.
    AtLeast(f64),
}

impl Target {
    /// Returns whether a figure meets the target.
    pub fn is_met(self, measured: f64) -> bool {
        match self {
            Self::AtMost(maximum) => measured <= maximum,
            Self::AtLeast(minimum) => measured >= minimum,
        }
    }
}

/// A measured figure.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Name of the case.
    pub case: String,
    /// Measured value, in `unit`.
    pub measured: f64,
    /// Unit: `ns/vertex`, `ms`, `times`, ...
    pub unit: &'static str,
    /// Target; `None` for figures that only serve as a comparison.
    pub target: Option<Target>,
    /// Figures measured in the same samples, as text.
    pub comparison: String,
}

/// Sections of rows under headings. `Display` formats the rows in columns.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    sections: Vec<(String, Vec<Row>)>,
}

impl Table {
    /// Starts a section. Sections without rows are not printed.
    pub fn section(&mut self, heading: impl Into<String>) {
        self.sections.push((heading.into(), Vec::new()));
    }

    /// Adds a row to the last section.
    ///
    /// # Panics
    ///
    /// Panics if no section was started.
    pub fn row(&mut self, row: Row) {
        self.sections.last_mut().expect("a section was started").1.push(row);
    }

    /// Returns the rows of all sections.
    pub fn rows(&self) -> impl Iterator<Item = &Row> {
        self.sections.iter().flat_map(|(_, rows)| rows)
    }
}

/// Headings of the columns: case, measured value, target, `met` or `MISSED`, comparison.
const HEADINGS: [&str; 5] = ["", "measured", "target", "", "compared with"];

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sections: Vec<_> = self.sections.iter().filter(|(_, rows)| !rows.is_empty()).collect();
        let lines: Vec<Vec<[String; 5]>> =
            sections.iter().map(|(_, rows)| rows.iter().map(Row::columns).collect()).collect();
        let widths: [usize; 5] = std::array::from_fn(|column| {
            let cells = lines.iter().flatten().map(|line| line[column].chars().count());
            cells.chain([HEADINGS[column].len()]).max().unwrap_or(0)
        });
        write_line(f, &HEADINGS.map(str::to_owned), &widths)?;
        for ((heading, _), lines) in sections.iter().zip(&lines) {
            writeln!(f, "\n{heading}")?;
            lines.iter().try_for_each(|line| write_line(f, line, &widths))?;
        }
        let verdicts = || self.rows().filter_map(|row| Some(row.target?.is_met(row.measured)));
        let met = verdicts().filter(|met| *met).count();
        writeln!(f, "\n{met} of {} targets met", verdicts().count())
    }
}

/// Writes the cells of one line, padded to `widths`.
fn write_line(
    f: &mut fmt::Formatter<'_>,
    [case, measured, target, verdict, comparison]: &[String; 5],
    widths: &[usize; 5],
) -> fmt::Result {
    let [a, b, c, d, _] = *widths;
    let line = format!("  {case:<a$}  {measured:>b$}  {target:<c$}  {verdict:<d$}  {comparison}");
    writeln!(f, "{}", line.trim_end())
}

impl Row {
    /// Returns the cells of the row.
    fn columns(&self) -> [String; 5] {
        let (target, verdict) = match self.target {
            None => (String::new(), ""),
            Some(target) => {
                let text = match target {
                    Target::AtMost(maximum) => format!("<= {}", figure(maximum)),
                    Target::AtLeast(minimum) => format!(">= {}", figure(minimum)),
                };
                (text, if target.is_met(self.measured) { "met" } else { "MISSED" })
            }
        };
        let measured = format!("{} {}", figure(self.measured), self.unit);
        [self.case.clone(), measured, target, verdict.to_owned(), self.comparison.clone()]
    }
}

/// Rounds a number to three significant digits, but not to fewer than all digits of its integer part and not
/// to more than five decimals. Omits trailing zeros of the decimals.
fn figure(number: f64) -> String {
    let digits = if number == 0.0 { 0 } else { number.abs().log10().floor() as i32 };
    let decimals = (2 - digits).clamp(0, 5) as usize;
    let text = format!("{number:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_prints_verdicts() {
        let mut table = Table::default();
        table.section("empty");
        table.section("step");
        let row = |case: &str, measured, target| Row {
            case: case.to_owned(),
            measured,
            unit: "ns",
            target,
            comparison: "w = 2: 30 ns".to_owned(),
        };
        table.row(row("w = 1", 21.96, Some(Target::AtMost(22.0))));
        table.row(row("w = 3", 104.2, Some(Target::AtLeast(1000.0))));
        table.row(row("w = 5", 0.012_345, None));
        let expected = "
                measured  target          compared with

step
  w = 1    22 ns  <= 22    met     w = 2: 30 ns
  w = 3   104 ns  >= 1000  MISSED  w = 2: 30 ns
  w = 5  0.0123 ns                 w = 2: 30 ns

1 of 2 targets met
";
        let squeeze = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
        assert_eq!(squeeze(&table.to_string()), squeeze(expected));
    }

    #[test]
    fn figures_are_rounded_to_three_significant_digits() {
        for (number, text) in
            [(0.0, "0"), (0.3, "0.3"), (0.012_345, "0.0123"), (21.96, "22"), (31.24, "31.2")]
        {
            assert_eq!(figure(number), text);
        }
        assert_eq!((figure(1234.5).as_str(), figure(-0.004).as_str()), ("1234", "-0.004"));
    }
}
