//! Demonstrations written as files, in the format that `learn` reads.

use std::path::PathBuf;

use situ::demonstration::Demonstration;
use situ::state::Schema;

use crate::demonstration_file::{Before, render};
use crate::error::BenchError;
use crate::files;

/// A folder that demonstrations are written into.
#[derive(Clone, Debug)]
pub struct Archive {
    folder: PathBuf,
}

impl Archive {
    /// An archive in this folder, which need not be there.
    pub fn new(folder: impl Into<PathBuf>) -> Self {
        Self { folder: folder.into() }
    }

    /// Writes a demonstration to `path`, with `.json` added, below the folder.
    ///
    /// # Errors
    /// [`BenchError::Write`].
    pub fn write(
        &self,
        path: &str,
        demonstration: &Demonstration,
        schema: &Schema,
        before: &Before,
    ) -> Result<(), BenchError> {
        let file = self.folder.join(format!("{path}.json"));
        if let Some(folder) = file.parent() {
            std::fs::create_dir_all(folder).map_err(|source| BenchError::Write { path: folder.to_owned(), source })?;
        }
        files::write_all(&[(file, render(demonstration, schema, before))])
    }
}
