//! The file of a baseline: JSON, with the version of its schema.

use std::fs;
use std::path::Path;

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::error::BenchError;

/// The version that this program reads and writes.
pub(super) const SCHEMA: u64 = 1;

/// Reads a baseline; `schema` is the version that the file says it has.
///
/// # Errors
/// [`BenchError::Read`]; [`BenchError::Baseline`] with the line where the file is no baseline of this version.
pub(super) fn read<T: DeserializeOwned>(path: &Path, schema: fn(&T) -> u64) -> Result<T, BenchError> {
    let text = fs::read_to_string(path).map_err(|source| BenchError::Read { path: path.to_owned(), source })?;
    let refuse = |line, problem| BenchError::Baseline { path: path.to_owned(), line, problem };
    let baseline: T = serde_json::from_str(&text).map_err(|error| refuse(error.line(), error.to_string()))?;
    match schema(&baseline) {
        SCHEMA => Ok(baseline),
        other => Err(refuse(1, format!("`schema`: expected {SCHEMA}, found {other}: mint it anew"))),
    }
}

/// The file's text.
pub(super) fn to_json(baseline: &impl Serialize) -> String {
    serde_json::to_string_pretty(baseline).expect("a baseline's numbers are finite and its keys are strings") + "\n"
}
