//! A recording: which kind of file it is, and its sheet.

use std::fs;
use std::path::{Path, PathBuf};

use crate::error::BenchError;
use crate::import::csv_sheet;
#[cfg(feature = "lerobot")]
use crate::import::lerobot_sheet;
use crate::import::mapping::Mapping;
#[cfg(feature = "mcap")]
use crate::import::mcap_sheet;
use crate::import::sheet::Sheet;

/// How every MCAP file begins.
const MCAP: &[u8] = b"\x89MCAP0\r\n";
/// How every Parquet file begins.
const PARQUET: &[u8] = b"PAR1";

/// The sheet of a recording: a folder is a LeRobot dataset, a file is MCAP or else CSV.
///
/// # Errors
/// [`BenchError::Read`]; [`BenchError::Recording`].
pub(super) fn sheet(path: &Path, mapping: &Mapping) -> Result<Sheet, BenchError> {
    if path.is_dir() {
        return folder(path, mapping);
    }
    let bytes = fs::read(path).map_err(|source| BenchError::Read { path: path.to_owned(), source })?;
    file(&bytes, path, mapping)
}

/// The sheet of a file with these bytes.
pub(super) fn file(bytes: &[u8], path: &Path, mapping: &Mapping) -> Result<Sheet, BenchError> {
    if bytes.starts_with(PARQUET) {
        return Err(refuse(
            path,
            "a Parquet file alone: expected the folder of the dataset, with its `meta/info.json`",
        ));
    }
    if bytes.starts_with(MCAP) {
        return mcap(bytes, path, mapping);
    }
    csv_sheet::read(bytes, path)
}

#[cfg(feature = "lerobot")]
fn folder(path: &Path, mapping: &Mapping) -> Result<Sheet, BenchError> {
    lerobot_sheet::read(path, mapping)
}

#[cfg(not(feature = "lerobot"))]
fn folder(path: &Path, _: &Mapping) -> Result<Sheet, BenchError> {
    Err(refuse(path, "a LeRobot dataset: this program was built without the feature `lerobot`"))
}

#[cfg(feature = "mcap")]
fn mcap(bytes: &[u8], path: &Path, mapping: &Mapping) -> Result<Sheet, BenchError> {
    mcap_sheet::read(bytes, path, mapping)
}

#[cfg(not(feature = "mcap"))]
fn mcap(_: &[u8], path: &Path, _: &Mapping) -> Result<Sheet, BenchError> {
    Err(refuse(path, "an MCAP file: this program was built without the feature `mcap`"))
}

/// The error of a recording as a whole.
pub(super) fn refuse(path: &Path, problem: impl Into<String>) -> BenchError {
    BenchError::Recording { path: PathBuf::from(path), place: String::new(), problem: problem.into() }
}
