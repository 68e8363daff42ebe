//! Reads the runs of a page.

use std::io;

use super::run::Run;
use super::text;

/// Reads the runs of a page.
///
/// # Errors
/// If the page is not one of this program, is incomplete, or was changed.
pub(crate) fn read_page(page: &[u8]) -> io::Result<Vec<Run<'static>>> {
    if !page.trim_ascii_end().ends_with(b"</html>") {
        return Err(text::invalid("it is not a page of supple, or is incomplete"));
    }
    let mut data = text::runs(page)?;
    // The last one is the player.
    if data.pop().is_none() || data.is_empty() {
        return Err(text::invalid("it is not a page of supple"));
    }
    data.iter().map(|compressed| Run::read(compressed)).collect()
}
