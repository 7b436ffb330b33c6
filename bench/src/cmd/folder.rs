//! A folder of runs as somebody left it: its manifest and its protocol.

use std::fs;
use std::path::Path;

use crate::cmd::run::{LEDGER, PROTOCOL};
use crate::digest;
use crate::error::BenchError;
use crate::manifest::{self, Manifest};

/// The manifest of a folder.
pub(super) fn manifest(folder: &Path) -> Result<Manifest, BenchError> {
    let path = manifest::beside(&folder.join(LEDGER));
    let missing = || BenchError::Argument(format!("{}: not there, expected what `run` wrote", path.display()));
    Manifest::read(&path)?.ok_or_else(missing)
}

/// The text of its protocol, which must be what the manifest says.
pub(super) fn protocol(folder: &Path, manifest: &Manifest) -> Result<String, BenchError> {
    let path = folder.join(PROTOCOL);
    let text = fs::read_to_string(&path).map_err(|source| BenchError::Read { path: path.clone(), source })?;
    if digest::hash(&text) == manifest.protocol.hash {
        return Ok(text);
    }
    let (path, hash) = (path.display(), &manifest.protocol.hash);
    Err(BenchError::Argument(format!("{path}: not what made the ledger: expected the file with the SHA-256 {hash}")))
}
