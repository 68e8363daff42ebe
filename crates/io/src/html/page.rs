//! Writes a page: an HTML file with the player and the data of its runs.

use std::fmt::Write as _;
use std::io::{self, Write};

use flate2::Compression;
use flate2::write::GzEncoder;

use super::frame::Layout;
use super::run::Run;
use super::text::TextWriter;
use crate::count::counted;

/// The page without its variable parts, each at a mark `{{name}}`.
const PAGE: &str = include_str!("player/page.html");
const STYLE: &str = include_str!("player/style.css");
const BOOT: &str = include_str!("player/boot.js");

/// three.js: see `vendor/README.md`.
const THREE: &str = include_str!("vendor/three.min.js");
const THREE_LICENCE: &str = include_str!("vendor/LICENSE");

/// The program of the page, in the order in which its files are joined.
const PLAYER: [&str; 9] = [
    include_str!("player/data.js"),
    include_str!("player/surface.js"),
    include_str!("player/colliders.js"),
    include_str!("player/stage.js"),
    include_str!("player/view.js"),
    include_str!("player/plot.js"),
    include_str!("player/clock.js"),
    include_str!("player/keys.js"),
    include_str!("player/main.js"),
];

/// Writes a page with runs side by side.
///
/// # Errors
/// If a frame cannot be read, or `out` cannot be written.
pub(crate) fn write_page(mut out: impl Write, runs: &mut [Run<'_>]) -> io::Result<()> {
    let names: Vec<&str> = runs.iter().map(|run| &*run.header.name).collect();
    let title = escaped(&names.join(" · "));
    let summary = runs.iter_mut().map(summary).collect::<io::Result<Vec<_>>>()?.join("\n");
    let mut rest = PAGE;
    while let Some((before, mark)) = rest.split_once("{{") {
        out.write_all(before.as_bytes())?;
        let (name, after) = mark.split_once("}}").unwrap_or((mark, ""));
        match name {
            "version" => out.write_all(env!("CARGO_PKG_VERSION").as_bytes())?,
            "title" => out.write_all(title.as_bytes())?,
            "summary" => out.write_all(summary.as_bytes())?,
            "style" => out.write_all(STYLE.as_bytes())?,
            "licence" => out.write_all(THREE_LICENCE.trim().as_bytes())?,
            "boot" => out.write_all(BOOT.as_bytes())?,
            "player" => write_player(&mut out, runs.len())?,
            "data" => {
                for (index, run) in runs.iter_mut().enumerate() {
                    let mut text = TextWriter::new(&mut out, index);
                    run.write(&mut text)?;
                    text.finish()?;
                }
            }
            _ => debug_assert!(false, "the page has an unknown mark {name}"),
        }
        rest = after;
    }
    out.write_all(rest.as_bytes())
}

/// Writes the program, compressed, as the data of a further run.
fn write_player(out: &mut impl Write, index: usize) -> io::Result<()> {
    let mut text = TextWriter::new(out, index);
    let mut encoder = GzEncoder::new(&mut text, Compression::best());
    for file in [THREE].iter().chain(&PLAYER) {
        encoder.write_all(file.as_bytes())?;
    }
    encoder.finish()?;
    text.finish().map(drop)
}

/// Describes a run for readers who do not see the page, as HTML.
fn summary(run: &mut Run<'_>) -> io::Result<String> {
    let layout = Layout::new(&run.header);
    let mut ranges = vec![[f64::INFINITY, f64::NEG_INFINITY]; run.header.bodies.len()];
    let mut frame = Vec::new();
    for index in 0..run.header.frames {
        run.frames.read_frame(index, &mut frame)?;
        for (body, [low, high]) in ranges.iter_mut().enumerate() {
            let [rest, _, after] = layout.volumes(&frame, body);
            if rest > 0.0 {
                (*low, *high) = (low.min(after / rest), high.max(after / rest));
            }
        }
    }
    let header = &run.header;
    let (frames, bodies) = (counted(header.frames, "frame"), counted(header.bodies.len(), "body"));
    let seconds = header.frames.saturating_sub(1) as f64 * header.every as f64 / header.fps;
    let mut text = format!(
        "<section><h2>{}</h2>\n<p>{bodies}, {frames} at {} frames per second, {seconds:.2} seconds.</p>\n<ul>\n",
        escaped(&header.name),
        // With at most three decimals.
        (1e3 * header.fps / header.every as f64).round() / 1e3,
    );
    for (body, [low, high]) in header.bodies.iter().zip(ranges) {
        let volume = if low <= high {
            format!("volume from {:.2} % to {:.2} % of the volume at rest", 100.0 * low, 100.0 * high)
        } else {
            "volume not recorded".to_owned()
        };
        // Writing to a string does not fail.
        let _ = writeln!(text, "<li>{}: {volume}</li>", escaped(&body.name));
    }
    text.push_str("</ul></section>");
    Ok(text)
}

/// Escapes the characters of a text that have a meaning in HTML.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
