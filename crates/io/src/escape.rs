//! Displays text from files, file names and arguments in messages.

use std::fmt::{self, Display, Write};

/// Displays text with its control characters escaped, such as `\n` and `\u{1b}`. A terminal that shows the
/// text receives no control sequence.
///
/// Characters that change the direction or the lines of the text around them are also escaped. Letters of any
/// language, quotes and backslashes are unchanged.
#[derive(Clone, Copy, Debug)]
pub struct Escaped<T>(pub T);

impl<T: Display> Display for Escaped<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(Escape(f), "{}", self.0)
    }
}

/// A writer that escapes control characters.
struct Escape<'a, 'b>(&'a mut fmt::Formatter<'b>);

impl Write for Escape<'_, '_> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        let mut rest = text;
        while let Some((at, found)) = rest.char_indices().find(|&(_, character)| is_control(character)) {
            self.0.write_str(&rest[..at])?;
            // Escapes as in Rust: `\n`, `\t`, `\r`, otherwise `\u{1b}`.
            write!(self.0, "{}", found.escape_default())?;
            rest = &rest[at + found.len_utf8()..];
        }
        self.0.write_str(rest)
    }
}

/// Returns whether a character can change the display of other characters: a control character, a separator
/// of lines, or a mark or override of the text direction.
fn is_control(character: char) -> bool {
    character.is_control()
        || matches!(character, '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{206f}')
}

/// Displays the start of a text that a message quotes, as [`Escaped`]. A text of more than 80 characters is
/// cut, and its length is added.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Excerpt<'a>(pub(crate) &'a str);

impl Display for Excerpt<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = self.0;
        match text.char_indices().nth(80) {
            None => write!(f, "{}", Escaped(text)),
            Some((end, _)) => write!(f, "{}... ({} bytes)", Escaped(&text[..end]), text.len()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn control_characters_are_escaped_and_letters_are_not() {
        for (text, expected) in [
            ("a\u{1b}[31mb\u{7}", "a\\u{1b}[31mb\\u{7}"),
            ("\u{9b}2J\r\n\t", "\\u{9b}2J\\r\\n\\t"),
            ("\u{202e}gpj.exe\u{2028}", "\\u{202e}gpj.exe\\u{2028}"),
            ("C:\\models\\'Kopf'\"", "C:\\models\\'Kopf'\""),
            ("Ko\u{308}pfe \u{5b57} \u{1f9b4}", "Ko\u{308}pfe \u{5b57} \u{1f9b4}"),
        ] {
            assert_eq!(Escaped(text).to_string(), expected);
        }
    }

    #[test]
    fn excerpts_are_short() {
        assert_eq!(Excerpt(&"\u{e4}".repeat(80)).to_string(), "\u{e4}".repeat(80));
        assert_eq!(Excerpt(&"x".repeat(1000)).to_string(), format!("{}... (1000 bytes)", "x".repeat(80)));
    }
}
