//! What a run leaves behind of which nothing came: no trace of it stays.

use std::fs;
use std::path::{Path, PathBuf};

use crate::error::BenchError;

/// What a run leaves behind of which nothing came.
#[derive(Clone)]
pub(super) struct Traces {
    /// The ledger of the runs.
    pub(super) ledger: PathBuf,
    /// The files that were not there before.
    pub(super) files: Vec<PathBuf>,
    /// The lock of the folder.
    pub(super) lock: PathBuf,
    /// The folders that were not there before, the innermost first.
    pub(super) folders: Vec<PathBuf>,
}

impl Traces {
    /// Removes the files where no run has finished. What cannot be removed stays.
    pub(super) fn remove_files(&self) {
        if fs::metadata(&self.ledger).is_ok_and(|found| found.len() == 0) {
            self.files.iter().for_each(|path| drop(fs::remove_file(path)));
        }
    }

    /// The last act of a program that is cut off.
    pub(super) fn remove_all(&self) {
        self.remove_files();
        let _ = fs::remove_file(&self.lock);
        remove_empty(&self.folders);
    }
}

/// Makes a folder; returns what of it was not there before, the innermost first.
///
/// # Errors
/// [`BenchError::Write`].
pub(super) fn make(folder: &Path) -> Result<Vec<PathBuf>, BenchError> {
    let new = folder.ancestors().take_while(|path| !path.as_os_str().is_empty() && !path.exists());
    let new = new.map(Path::to_owned).collect();
    fs::create_dir_all(folder).map_err(|source| BenchError::Write { path: folder.to_owned(), source })?;
    Ok(new)
}

/// A folder that nothing was written into does not stay behind; one with files cannot be removed so.
pub(super) fn remove_empty(folders: &[PathBuf]) {
    folders.iter().for_each(|path| drop(fs::remove_dir(path)));
}
