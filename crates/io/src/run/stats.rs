//! One row a frame and body, as CSV or JSON: whole after every frame, continued on resume.

use std::fmt::Write as _;
use std::fs::File;
use std::io::{Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use super::error::RunError;
use super::row::Row;

const HEADER: &str = "frame,time,body,ms_step,ms_volume,ms_embed,ms_write,volume_rest,volume_before,\
                      volume_after,lambda,residual,capped,energy_kinetic,max_speed\n";
const JSON_HEAD: &str = "[\n";
const JSON_TAIL: &str = "\n]\n";

/// The formats of a stats file, told by its extension.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Csv,
    Json,
}

/// An open stats file.
#[derive(Debug)]
pub(super) struct Stats {
    file: File,
    path: PathBuf,
    kind: Kind,
    /// Where the next row goes: in JSON the closing bracket stands there.
    end: u64,
    /// Whether a row stands before it.
    any: bool,
}

/// Checks that a stats file's extension says what it is.
pub(super) fn check_name(path: &Path) -> Result<(), RunError> {
    kind(path).map(|_| ())
}

impl Stats {
    /// A new file, over an existing one.
    pub(super) fn create(path: &Path) -> Result<Self, RunError> {
        let kind = kind(path)?;
        let file = File::create(path).map_err(|source| RunError::io("create", path, source))?;
        let mut stats = Self { file, path: path.to_owned(), kind, end: 0, any: false };
        let head = match kind {
            Kind::Csv => HEADER,
            Kind::Json => JSON_HEAD,
        };
        stats.append(head)?;
        Ok(stats)
    }

    /// An existing file, cut off after the rows up to frame `last`; a new one if there is none.
    pub(super) fn resume(path: &Path, last: u64) -> Result<Self, RunError> {
        if !path.exists() {
            return Self::create(path);
        }
        let kind = kind(path)?;
        let text = std::fs::read_to_string(path).map_err(|source| RunError::io("read", path, source))?;
        let head = match kind {
            Kind::Csv => HEADER,
            Kind::Json => JSON_HEAD,
        };
        let rows = text.strip_prefix(head).ok_or_else(|| RunError::NotStats { path: path.to_owned() })?;
        let keep: usize = rows
            .split_inclusive('\n')
            .take_while(|line| frame_of(line, kind).is_some_and(|frame| frame <= last))
            .map(str::len)
            .sum();
        let (mut end, any) = ((head.len() + keep) as u64, keep > 0);
        if kind == Kind::Json && any {
            // The last row kept ends as `},\n` or `}\n`: what follows its brace is written anew.
            end = (head.len() + rows[..keep].trim_end_matches(['\n', ',']).len()) as u64;
        }
        let file = File::options()
            .write(true)
            .open(path)
            .and_then(|file| file.set_len(end).map(|()| file))
            .map_err(|source| RunError::io("write", path, source))?;
        let mut stats = Self { file, path: path.to_owned(), kind, end, any };
        stats.append("")?;
        Ok(stats)
    }

    /// Adds rows; the file is whole when this returns.
    pub(super) fn push(&mut self, rows: &[Row]) -> Result<(), RunError> {
        let mut text = String::new();
        for row in rows {
            match self.kind {
                Kind::Csv => text.push_str(&csv(row)),
                Kind::Json => {
                    text.push_str(if self.any { ",\n" } else { "" });
                    text.push_str(&json(row));
                }
            }
            self.any = true;
        }
        self.append(&text)
    }

    fn append(&mut self, text: &str) -> Result<(), RunError> {
        let tail = match (self.kind, self.any) {
            (Kind::Csv, _) => "",
            (Kind::Json, true) => JSON_TAIL,
            (Kind::Json, false) => "]\n",
        };
        let write = |file: &mut File| {
            file.seek(SeekFrom::Start(self.end))?;
            // One write, so that a kill between two rows leaves a whole file.
            file.write_all(format!("{text}{tail}").as_bytes())
        };
        write(&mut self.file).map_err(|source| RunError::io("write", &self.path, source))?;
        self.end += text.len() as u64;
        Ok(())
    }
}

fn kind(path: &Path) -> Result<Kind, RunError> {
    match path.extension().and_then(|extension| extension.to_str()) {
        Some("csv") => Ok(Kind::Csv),
        Some("json") => Ok(Kind::Json),
        _ => Err(RunError::StatsName { path: path.to_owned() }),
    }
}

/// The frame of a whole line.
fn frame_of(line: &str, kind: Kind) -> Option<u64> {
    let line = line.strip_suffix('\n')?;
    match kind {
        Kind::Csv => line.split(',').next()?.parse().ok(),
        Kind::Json => {
            let rest = line.strip_prefix("{\"frame\": ")?;
            rest.split(',').next()?.parse().ok()
        }
    }
}

/// The numbers of a row after its name, in the order of the header, `capped` apart.
fn numbers(row: &Row) -> [(&'static str, f64); 11] {
    [
        ("ms_step", row.ms_step),
        ("ms_volume", row.ms_volume),
        ("ms_embed", row.ms_embed),
        ("ms_write", row.ms_write),
        ("volume_rest", row.volume_rest),
        ("volume_before", row.volume_before),
        ("volume_after", row.volume_after),
        ("lambda", row.lambda),
        ("residual", row.residual),
        ("energy_kinetic", row.energy_kinetic),
        ("max_speed", row.max_speed),
    ]
}

fn csv(row: &Row) -> String {
    // Names need no quotes: they hold letters, digits, `-`, `_` and `.` only.
    let mut line = format!("{},{:?},{}", row.frame, row.time, row.body);
    for (name, value) in numbers(row) {
        if name == "energy_kinetic" {
            let _ = write!(line, ",{}", row.capped);
        }
        // The shortest text that reads back, with an exponent where it is shorter.
        let _ = write!(line, ",{value:?}");
    }
    line.push('\n');
    line
}

fn json(row: &Row) -> String {
    let mut line =
        format!("{{\"frame\": {}, \"time\": {:?}, \"body\": \"{}\"", row.frame, row.time, row.body);
    for (name, value) in numbers(row) {
        if name == "energy_kinetic" {
            let _ = write!(line, ", \"capped\": {}", row.capped);
        }
        // JSON has no infinities.
        let _ = match value.is_finite() {
            true => write!(line, ", \"{name}\": {value:?}"),
            false => write!(line, ", \"{name}\": null"),
        };
    }
    line.push('}');
    line
}

#[cfg(test)]
mod tests;
