//! Prints lines, and formats numbers, sizes, durations and commands.
//!
//! The printing functions ignore all write errors. The usual cause is a closed pipe, as in
//! `supple ... | head`, which is not a failure of the command.

use std::ffi::OsString;
use std::fmt::Display;
use std::io::{self, Write};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

use serde_json::{Value, json};
use supple_io::Escaped;

/// The command line of the program.
static ARGUMENTS: OnceLock<Vec<String>> = OnceLock::new();

/// Whether messages are printed as JSON.
static AS_JSON: AtomicBool = AtomicBool::new(false);

/// Stores the command line of the program, for messages.
pub(crate) fn set_arguments(arguments: &[OsString]) {
    let words = arguments.iter().map(|word| word.to_string_lossy().into_owned());
    let _ = ARGUMENTS.set(words.collect());
}

/// Prints lines to standard output. Control characters of names and paths in them are escaped.
pub(crate) fn print(lines: impl Display) {
    let _ = writeln!(io::stdout().lock(), "{}", escaped(&lines.to_string()));
}

/// Prints lines for other programs to standard output, unchanged.
pub(crate) fn print_data(lines: impl Display) {
    let _ = writeln!(io::stdout().lock(), "{lines}");
}

/// Prints lines to standard error. Control characters of names and paths in them are escaped.
pub(crate) fn print_to_stderr(lines: impl Display) {
    print_message("note", "", &lines.to_string());
}

/// Prints a line to standard error: `warning: ` and the message.
pub(crate) fn print_warning(warning: impl Display) {
    print_message("warning", "warning: ", &warning.to_string());
}

/// Prints all later messages on standard error as JSON objects, one per line.
pub(crate) fn print_messages_as_json() {
    AS_JSON.store(true, Ordering::Relaxed);
}

/// Prints a JSON object in one line to standard error.
pub(crate) fn print_event(event: &Value) {
    // In one piece, so that lines of several programs in a log do not mix.
    let _ = io::stderr().lock().write_all(format!("{event}\n").as_bytes());
}

/// Prints a message to standard error: as text after `prefix`, or as JSON object of the kind `event`.
fn print_message(event: &str, prefix: &str, message: &str) {
    if AS_JSON.load(Ordering::Relaxed) {
        print_event(&json!({ "event": event, "message": message.trim() }));
    } else {
        let _ = writeln!(io::stderr().lock(), "{prefix}{}", escaped(message));
    }
}

/// Escapes all control characters but the line ends.
fn escaped(lines: &str) -> String {
    lines.split('\n').map(|line| Escaped(line).to_string()).collect::<Vec<_>>().join("\n")
}

/// Prints a line to standard error: `error: ` and the message.
pub(crate) fn print_error(error: impl Display) {
    print_message("error", "error: ", &error.to_string());
}

/// Formats a number with at least four significant digits: in scientific notation from 1e5 and below 1e-3,
/// otherwise with up to six decimals and all digits before the decimal point.
pub(crate) fn number(value: f64) -> String {
    if value == 0.0 || (1e-3..1e5).contains(&value.abs()) {
        let digits = (3 - value.abs().max(1e-3).log10().floor() as i32).clamp(0, 6) as usize;
        format!("{value:.digits$}")
    } else {
        format!("{value:.3e}")
    }
}

/// Formats a number of bytes with a decimal unit: `1.2 MB` is 1.2 million bytes.
pub(crate) fn bytes(bytes: u64) -> String {
    let units = ["B", "kB", "MB", "GB", "TB", "PB", "EB"];
    let (mut value, mut unit) = (bytes as f64, 0);
    while value >= 999.5 && unit + 1 < units.len() {
        value /= 1000.0;
        unit += 1;
    }
    if unit == 0 { format!("{bytes} B") } else { format!("{value:.1} {}", units[unit]) }
}

/// Formats a duration, given in seconds, as `4.2 s`, `3 min 07 s` or `2 h 05 min`.
pub(crate) fn duration(seconds: f64) -> String {
    let whole = seconds.round() as u64;
    match whole {
        0..60 => format!("{seconds:.1} s"),
        60..3600 => format!("{} min {:02} s", whole / 60, whole % 60),
        _ => format!("{} h {:02} min", whole / 3600, whole / 60 % 60),
    }
}

/// Returns the command line of the program with `--resume` added, quoted for a shell.
pub(crate) fn resume_command() -> String {
    let mut words: Vec<String> = ARGUMENTS.get().into_iter().flatten().map(|word| quoted(word)).collect();
    // The run has begun to replace the frames after the one of `--from`.
    while let Some(at) = words.iter().position(|word| word == "--from" || word.starts_with("--from=")) {
        let count = if words[at] == "--from" { 2 } else { 1 };
        words.drain(at..words.len().min(at + count));
    }
    if !words.iter().any(|word| word.split('=').next() == Some("--resume")) {
        words.push("--resume".to_owned());
    }
    words.join(" ")
}

/// Quotes a word for a shell.
pub(crate) fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=:,+@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn control_characters_other_than_line_ends_are_escaped() {
        assert_eq!(escaped("a\u{1b}[2J\nb\t\u{9b}"), "a\\u{1b}[2J\nb\\t\\u{9b}");
    }

    #[test]
    fn sizes_and_durations_have_units() {
        assert_eq!([0, 999, 1000, 94_400_000].map(bytes), ["0 B", "999 B", "1.0 kB", "94.4 MB"]);
        assert_eq!([0.0, 4.24, 187.2, 7500.0].map(duration), ["0.0 s", "4.2 s", "3 min 07 s", "2 h 05 min"]);
    }

    #[test]
    fn words_are_quoted_for_a_shell() {
        assert_eq!(quoted("a/b.toml"), "a/b.toml");
        assert_eq!(quoted("a b"), "'a b'");
        assert_eq!(quoted("it's"), r"'it'\''s'");
        assert_eq!(quoted(""), "''");
    }
}
