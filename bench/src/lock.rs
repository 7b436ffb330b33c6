//! The lock of a folder of results: two programs that write there would lose records.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{Read, Write};
use std::path::{Path, PathBuf};

use crate::error::BenchError;

/// The lock's name in its folder.
const NAME: &str = ".lock";

/// Held as long as this program writes into a folder. The system lets it go where the program dies.
#[derive(Debug)]
pub struct Lock {
    path: PathBuf,
    /// The lock is the file's, and goes with it.
    _file: File,
}

impl Lock {
    /// Where the lock of a folder is.
    pub fn path(folder: &Path) -> PathBuf {
        folder.join(NAME)
    }

    /// Takes the lock of a folder, which must be there.
    ///
    /// # Errors
    /// [`BenchError::Locked`] where another program has it; [`BenchError::Write`] where the file system has no locks.
    pub fn take(folder: &Path) -> Result<Self, BenchError> {
        let path = Self::path(folder);
        let wrong = |source| BenchError::Write { path: path.clone(), source };
        loop {
            let open = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(&path);
            let mut file = open.map_err(wrong)?;
            match file.try_lock() {
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => {
                    let mut holder = String::new();
                    // What cannot be read names nobody.
                    let _ = file.read_to_string(&mut holder);
                    let holder = if holder.is_empty() { "another process".to_owned() } else { holder };
                    return Err(BenchError::Locked { folder: folder.to_owned(), holder });
                }
                Err(TryLockError::Error(source)) => return Err(wrong(source)),
            }
            // Whoever had the lock may have removed the file after it was opened here: then it locks nothing.
            if !is_at(&file, &path) {
                continue;
            }
            file.set_len(0).and_then(|()| file.write_all(this_process().as_bytes())).map_err(wrong)?;
            return Ok(Self { path, _file: file });
        }
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        // A file that cannot be removed locks nothing once this program has ended.
        let _ = fs::remove_file(&self.path);
    }
}

/// Whether a file is still the one that its path leads to.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;

    let same = |own: fs::Metadata, other: fs::Metadata| (own.dev(), own.ino()) == (other.dev(), other.ino());
    file.metadata().ok().zip(fs::metadata(path).ok()).is_some_and(|(own, other)| same(own, other))
}

/// An open file cannot be removed where this is not Unix.
#[cfg(not(unix))]
fn is_at(_: &File, _: &Path) -> bool {
    true
}

/// How this process is called in messages to others.
fn this_process() -> String {
    let id = std::process::id();
    #[cfg(unix)]
    return format!("process {id} on {}", rustix::system::uname().nodename().to_string_lossy());
    #[cfg(not(unix))]
    return format!("process {id}");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_at_a_time() {
        let folder = tempfile::tempdir().unwrap();
        let first = Lock::take(folder.path()).unwrap();
        let error = Lock::take(folder.path()).unwrap_err();
        let id = std::process::id();
        assert!(error.to_string().contains(&format!("process {id}")), "{error}");
        assert_eq!(error.exit_status(), 2);
        drop(first);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "nothing stays behind");
        drop(Lock::take(folder.path()).unwrap());
        // What a program that was killed has left behind locks nothing.
        fs::write(folder.path().join(NAME), "process 1 on nowhere").unwrap();
        Lock::take(folder.path()).unwrap();
    }

    #[test]
    fn of_many_that_try_at_once_one_at_a_time_gets_it() {
        use std::sync::atomic::{AtomicUsize, Ordering};

        let folder = tempfile::tempdir().unwrap();
        let (inside, taken) = (AtomicUsize::new(0), AtomicUsize::new(0));
        std::thread::scope(|scope| {
            for _ in 0..8 {
                scope.spawn(|| {
                    for _ in 0..200 {
                        let Ok(lock) = Lock::take(folder.path()) else { continue };
                        assert_eq!(inside.fetch_add(1, Ordering::SeqCst), 0, "two at a time");
                        taken.fetch_add(1, Ordering::SeqCst);
                        std::thread::yield_now();
                        inside.fetch_sub(1, Ordering::SeqCst);
                        drop(lock);
                    }
                });
            }
        });
        assert!(taken.into_inner() > 0);
    }
}
