//! Files that are written whole or not at all.

use std::fs;
use std::path::{Path, PathBuf};

use crate::error::BenchError;

/// Writes all of these files, or none. Each content goes to a new file beside its target. When all of them are written,
/// the new files take the places of the targets.
///
/// # Errors
/// [`BenchError::Write`]; [`BenchError::Argument`] where two contents have one target.
pub fn write_all(files: &[(PathBuf, impl AsRef<[u8]>)]) -> Result<(), BenchError> {
    for (index, (path, _)) in files.iter().enumerate() {
        if files[..index].iter().any(|(other, _)| other == path) {
            return Err(BenchError::Argument(format!(
                "{}: two outputs with one name, expected two names",
                path.display()
            )));
        }
    }
    let parts: Vec<PathBuf> = files.iter().map(|(path, _)| beside(path)).collect();
    let write = || {
        for ((path, content), part) in files.iter().zip(&parts) {
            fs::write(part, content).map_err(|source| BenchError::Write { path: path.clone(), source })?;
        }
        for ((path, _), part) in files.iter().zip(&parts) {
            fs::rename(part, path).map_err(|source| BenchError::Write { path: path.clone(), source })?;
        }
        Ok(())
    };
    let written = write();
    if written.is_err() {
        // The new files that are left of an unfinished write. One that cannot be removed was never there.
        parts.iter().for_each(|part| drop(fs::remove_file(part)));
    }
    written
}

/// A name that only this process uses, in the same folder, so that a rename stays on one file system.
fn beside(path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!(".{name}.{}.part", std::process::id()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_or_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let names = || {
            let mut names: Vec<_> =
                fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
            names.sort();
            names
        };
        let file = |name: &str| (folder.path().join(name), name.to_owned());
        assert!(write_all(&[file("a"), file("nowhere/b")]).is_err());
        assert!(write_all(&[file("a"), file("a")]).is_err());
        assert!(names().is_empty());
        write_all(&[file("a"), file("b")]).unwrap();
        write_all(&[file("b")]).unwrap();
        assert_eq!(names(), ["a", "b"]);
        assert_eq!(fs::read_to_string(folder.path().join("b")).unwrap(), "b");
    }
}
