//! `study.svg`.
use std::path::Path;

use super::Report;
use crate::error::StudyError;

pub(super) fn write(_report: &Report, _path: &Path) -> Result<(), StudyError> {
    Ok(())
}
