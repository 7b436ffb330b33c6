//! Files that are written whole or not at all, and nothing replaced that is no file.

use std::fs::{self, File, OpenOptions, Permissions};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::error::BenchError;

/// Held while files take their places, or a line is added to one.
static WRITING: Mutex<()> = Mutex::new(());

/// Waits until nothing is being written, and lets nothing be written as long as the guard lives.
pub fn held() -> MutexGuard<'static, ()> {
    WRITING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Where an output goes.
enum Target {
    /// A file that is made anew beside `path` and takes its place, with the permissions of the one that is there.
    File { path: PathBuf, permissions: Option<Permissions> },
    /// A device or a pipe, which is written to and stays what it is.
    Stream { path: PathBuf, open: File },
}

/// Writes all of these files, or none. Each content goes to a new file beside its target. When all of them are written,
/// the new files take the places of the targets and have their permissions. A link stays, and what it leads to is
/// written. A device or a pipe is written to, before any file takes its place.
///
/// # Errors
/// [`BenchError::Write`]; [`BenchError::Argument`] where two contents have one target, or a target is a folder, a link
/// to nothing, or a pipe that nobody reads.
pub fn write_all(files: &[(PathBuf, impl AsRef<[u8]>)]) -> Result<(), BenchError> {
    write_beside(&[], files)
}

/// [`write_all`] of a program that has read these inputs: none of them is overwritten, whatever its path is spelt like.
///
/// # Errors
/// As [`write_all`]; [`BenchError::Argument`] where a target is one of the inputs.
pub fn write_beside(inputs: &[&Path], files: &[(PathBuf, impl AsRef<[u8]>)]) -> Result<(), BenchError> {
    refuse_one_for_two(inputs, files)?;
    let mut parts = Parts(Vec::new());
    let mut targets = Vec::with_capacity(files.len());
    for (path, content) in files {
        let write = |source| BenchError::Write { path: path.clone(), source };
        let target = target(path)?;
        if let Target::File { path, permissions } = &target {
            let part = beside(path);
            let mut file = OpenOptions::new().write(true).create_new(true).open(&part).map_err(write)?;
            parts.0.push(part);
            // Before there is anything to be read.
            if let Some(permissions) = permissions {
                file.set_permissions(permissions.clone()).map_err(write)?;
            }
            file.write_all(content.as_ref()).map_err(write)?;
            file.sync_all().map_err(write)?;
        }
        targets.push((target, content.as_ref()));
    }
    for (target, content) in &mut targets {
        if let Target::Stream { path, open } = target {
            let written = open.write_all(content).and_then(|()| open.flush());
            written.map_err(|source| BenchError::Write { path: path.clone(), source })?;
        }
    }
    let _writing = held();
    let paths = targets.iter().filter_map(|(target, _)| match target {
        Target::File { path, .. } => Some(path),
        Target::Stream { .. } => None,
    });
    for (path, part) in paths.zip(&parts.0) {
        fs::rename(part, path).map_err(|source| BenchError::Write { path: path.clone(), source })?;
    }
    Ok(())
}

/// New files that have not taken their places yet. Those that are left of an unfinished write are removed.
struct Parts(Vec<PathBuf>);

impl Drop for Parts {
    fn drop(&mut self) {
        // One that has taken its place, or cannot be removed, is not there.
        self.0.iter().for_each(|part| drop(fs::remove_file(part)));
    }
}

/// Where an output goes.
///
/// # Errors
/// [`BenchError::Argument`] where nothing can be written there.
fn target(path: &Path) -> Result<Target, BenchError> {
    let refuse = |problem: &str| Err(BenchError::Argument(format!("{}: {problem}", path.display())));
    let wrong = |source| BenchError::Write { path: path.to_owned(), source };
    let found = match fs::symlink_metadata(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => {
            return Ok(Target::File { path: path.to_owned(), permissions: None });
        }
        found => found.map_err(wrong)?,
    };
    let (path, found) = if found.is_symlink() {
        match path.canonicalize() {
            Ok(end) => {
                let found = fs::metadata(&end).map_err(wrong)?;
                (end, found)
            }
            Err(error) if error.kind() == ErrorKind::NotFound => {
                return refuse("a link to nothing, expected a file or a new name");
            }
            Err(source) => return Err(wrong(source)),
        }
    } else {
        (path.to_owned(), found)
    };
    if found.is_dir() {
        return refuse("a folder, expected a file or a new name");
    }
    if found.is_file() {
        return Ok(Target::File { path, permissions: Some(found.permissions()) });
    }
    match stream(&path) {
        Ok(open) => Ok(Target::Stream { path, open }),
        Err(error) if is_unread(&error) => refuse("a pipe that nobody reads, expected a reader, or a file"),
        Err(source) => Err(wrong(source)),
    }
}

/// Opens a device or a pipe to write to it. A pipe must have a reader: waiting for one could take for ever.
#[cfg(unix)]
fn stream(path: &Path) -> io::Result<File> {
    use rustix::fs::{Mode, OFlags, open};

    // This fails where a pipe has no reader. Once it has one, the second call does not wait.
    let probe = open(path, OFlags::WRONLY | OFlags::NONBLOCK | OFlags::CLOEXEC, Mode::empty())?;
    let file = OpenOptions::new().write(true).open(path);
    drop(probe);
    file
}

/// Opens a device to write to it.
#[cfg(not(unix))]
fn stream(path: &Path) -> io::Result<File> {
    OpenOptions::new().write(true).open(path)
}

/// Whether a pipe has no reader.
fn is_unread(error: &io::Error) -> bool {
    #[cfg(unix)]
    return error.raw_os_error() == Some(rustix::io::Errno::NXIO.raw_os_error());
    #[cfg(not(unix))]
    return false;
}

/// Refuses two contents for one target, and a target that is an input.
fn refuse_one_for_two(inputs: &[&Path], files: &[(PathBuf, impl AsRef<[u8]>)]) -> Result<(), BenchError> {
    let inputs: Vec<PathBuf> = inputs.iter().map(|path| place(path)).collect();
    let mut known: Vec<PathBuf> = Vec::with_capacity(files.len());
    for (path, _) in files {
        let place = place(path);
        let refuse = |problem: &str| Err(BenchError::Argument(format!("{}: {problem}", path.display())));
        if inputs.contains(&place) {
            return refuse("an input, expected another file to write to");
        }
        if known.contains(&place) {
            return refuse("two outputs with one name, expected two names");
        }
        known.push(place);
    }
    Ok(())
}

/// A path by which a file is called in one way only, links followed. Of a file that is not there its folder counts.
fn place(path: &Path) -> PathBuf {
    if let Ok(place) = path.canonicalize() {
        return place;
    }
    let folder = path.parent().map(|folder| if folder.as_os_str().is_empty() { Path::new(".") } else { folder });
    match (folder.and_then(|folder| folder.canonicalize().ok()), path.file_name()) {
        (Some(folder), Some(name)) => folder.join(name),
        _ => path.to_owned(),
    }
}

/// A name that nothing else uses, in the same folder, so that a rename stays on one file system.
fn beside(path: &Path) -> PathBuf {
    static NUMBER: AtomicU64 = AtomicU64::new(0);
    let number = NUMBER.fetch_add(1, Ordering::Relaxed);
    path.with_file_name(format!(".{}-{number}.part", std::process::id()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        let mut names: Vec<_> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn all_or_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let file = |name: &str| (folder.path().join(name), name.to_owned());
        assert!(write_all(&[file("a"), file("nowhere/b")]).is_err());
        assert!(write_all(&[file("a"), file("a")]).is_err());
        assert!(write_all(&[file("a"), file("./a")]).is_err());
        assert!(names(folder.path()).is_empty());
        write_all(&[file("a"), file("b")]).unwrap();
        write_all(&[file("b")]).unwrap();
        assert_eq!(names(folder.path()), ["a", "b"]);
        assert_eq!(fs::read_to_string(folder.path().join("b")).unwrap(), "b");
        // A folder is no file, and the other outputs are not written either.
        fs::create_dir(folder.path().join("c")).unwrap();
        let error = write_all(&[(folder.path().join("a"), "new".to_owned()), file("c")]).unwrap_err();
        assert!(error.to_string().ends_with("c: a folder, expected a file or a new name"), "{error}");
        assert_eq!((error.exit_status(), names(folder.path())), (2, vec!["a".into(), "b".into(), "c".into()]));
        assert_eq!(fs::read_to_string(folder.path().join("a")).unwrap(), "a");
        // As long a name as there can be.
        write_all(&[file(&"n".repeat(255))]).unwrap();
    }

    #[test]
    fn an_input_is_never_overwritten() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("in"), "precious").unwrap();
        fs::create_dir(at("sub")).unwrap();
        for spelling in ["in", "./in", "sub/../in"] {
            let error = write_beside(&[&at("in")], &[(at("other"), "x"), (at(spelling), "x")]).unwrap_err();
            assert!(error.to_string().ends_with("an input, expected another file to write to"), "{error}");
        }
        assert_eq!((fs::read_to_string(at("in")).unwrap().as_str(), names(folder.path()).len()), ("precious", 2));
        write_beside(&[&at("in")], &[(at("other"), "x")]).unwrap();
    }

    #[cfg(unix)]
    #[test]
    fn only_a_file_is_replaced() {
        use std::os::unix::fs::{FileTypeExt, PermissionsExt, symlink};

        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("store"), "old").unwrap();
        fs::set_permissions(at("store"), Permissions::from_mode(0o640)).unwrap();
        symlink(at("store"), at("link")).unwrap();
        symlink(at("nowhere"), at("dangling")).unwrap();
        write_all(&[(at("link"), "new")]).unwrap();
        assert!(fs::symlink_metadata(at("link")).unwrap().is_symlink(), "the link stays");
        assert_eq!(fs::read_to_string(at("store")).unwrap(), "new");
        assert_eq!(fs::metadata(at("store")).unwrap().permissions().mode() & 0o777, 0o640, "permissions are kept");
        let error = write_all(&[(at("store"), "newer"), (at("dangling"), "x")]).unwrap_err();
        assert!(error.to_string().contains("a link to nothing") && error.exit_status() == 2, "{error}");
        assert!(write_all(&[(at("store"), "x"), (at("link"), "y")]).is_err(), "two outputs in one place");
        assert!(write_beside(&[&at("store")], &[(at("link"), "y")]).is_err(), "a link to an input");
        assert_eq!(fs::read_to_string(at("store")).unwrap(), "new");

        rustix::fs::mkfifoat(rustix::fs::CWD, at("pipe"), rustix::fs::Mode::from_raw_mode(0o600)).unwrap();
        let error = write_all(&[(at("store"), "newer"), (at("pipe"), "x")]).unwrap_err();
        assert!(error.to_string().contains("a pipe that nobody reads"), "{error}");
        let pipe = at("pipe");
        let reader = std::thread::spawn(move || fs::read_to_string(pipe).unwrap());
        // The reader waits for a writer; until it does, nobody reads.
        while write_all(&[(at("pipe"), "through")]).is_err() {
            std::thread::yield_now();
        }
        assert_eq!(reader.join().unwrap(), "through");
        assert!(fs::symlink_metadata(at("pipe")).unwrap().file_type().is_fifo(), "the pipe stays");
        write_all(&[("/dev/null".into(), "x")]).unwrap();
        assert!(fs::symlink_metadata("/dev/null").unwrap().file_type().is_char_device(), "a device stays");
    }
}
