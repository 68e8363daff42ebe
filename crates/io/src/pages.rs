//! Joins pages: shows several runs side by side in one page.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::{self, BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};

use crate::escape::Escaped;
use crate::file::{self, is_same_file, write_atomically};
use crate::html::{Run, read_page, write_page};
use crate::run::PAGE;

/// Error of joining pages.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PageError {
    /// A page cannot be read.
    #[error("cannot read {}: {source}", Escaped(path.display()))]
    Read {
        /// The page.
        path: PathBuf,
        /// Cause.
        source: io::Error,
    },
    /// A folder has no page.
    #[error(
        "{} has no page {PAGE}.html: run the scene with --format html, or with --format obj,html for frames too",
        Escaped(path.display())
    )]
    NoPage {
        /// The folder.
        path: PathBuf,
    },
    /// The page to write is one of the pages to join.
    #[error("{} is one of the pages to join, and would be replaced; choose another name", Escaped(path.display()))]
    OutputIsInput {
        /// The page.
        path: PathBuf,
    },
    /// The page cannot be written.
    #[error("cannot write {}: {source}", Escaped(path.display()))]
    Write {
        /// The page.
        path: PathBuf,
        /// Cause.
        source: io::Error,
    },
}

impl PageError {
    /// Returns whether the cause is an invalid input or argument. In this case nothing was written.
    pub fn is_input(&self) -> bool {
        !matches!(self, Self::Write { .. })
    }
}

/// Writes the page `output` with the runs of `inputs` side by side: pages, or folders of runs that have a page. A run
/// is named after its folder, or after its page if that has another name than `supple.html`; the runs of a page with
/// several runs keep their names. Returns the number of runs.
///
/// # Errors
///
/// If an input has no page or its page is damaged, or if `output` is one of the inputs or cannot be written.
pub fn join(inputs: &[PathBuf], output: &Path) -> Result<usize, PageError> {
    let mut all: Vec<Run<'static>> = Vec::new();
    for input in inputs {
        let path = page_of(input)?;
        if is_same_file(&path, output) {
            return Err(PageError::OutputIsInput { path });
        }
        let mut runs = file::read(&path, u64::MAX)
            .and_then(|bytes| read_page(&bytes))
            .map_err(|source| PageError::Read { path: path.clone(), source })?;
        if let [run] = &mut runs[..] {
            run.header.name = name_of(&path).unwrap_or(std::mem::take(&mut run.header.name));
        }
        all.append(&mut runs);
    }
    number_equal_names(&mut all);
    let count = all.len();
    write_atomically(output, |file: &mut File| {
        let mut out = BufWriter::new(file);
        write_page(&mut out, &mut all)?;
        out.flush()
    })
    .map_err(|source| PageError::Write { path: output.to_owned(), source })?;
    Ok(count)
}

/// Returns the page of an input.
fn page_of(input: &Path) -> Result<PathBuf, PageError> {
    match std::fs::metadata(input) {
        Err(source) => Err(PageError::Read { path: input.to_owned(), source }),
        Ok(metadata) if metadata.is_dir() => {
            let path = input.join(format!("{PAGE}.html"));
            match path.symlink_metadata() {
                Err(error) if error.kind() == ErrorKind::NotFound => {
                    Err(PageError::NoPage { path: input.to_owned() })
                }
                _ => Ok(path),
            }
        }
        Ok(_) => Ok(input.to_owned()),
    }
}

/// Returns the name of a page, or that of its folder if the page has the name that runs give it.
fn name_of(page: &Path) -> Option<String> {
    let stem = page.file_stem()?;
    if stem != PAGE {
        return Some(stem.to_string_lossy().into_owned());
    }
    let folder = std::fs::canonicalize(page).ok()?;
    Some(folder.parent()?.file_name()?.to_string_lossy().into_owned())
}

/// Appends numbers to names that are not unique.
fn number_equal_names(runs: &mut [Run<'_>]) {
    let mut names = BTreeSet::new();
    for run in runs {
        let name = run.header.name.clone();
        let mut number = 1;
        while !names.insert(run.header.name.clone()) {
            number += 1;
            run.header.name = format!("{name} ({number})");
        }
    }
}
