//! The workspace that the program was built in, as files and as a repository. The build script reads this file, too.

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use sha2::{Digest, Sha256};

/// What the program is made of, in the workspace. Tests, results and prose make no other program.
pub(crate) const PARTS: [&str; 15] = [
    "Cargo.lock",
    "Cargo.toml",
    "bench/Cargo.toml",
    "bench/build.rs",
    "bench/protocols",
    "bench/src",
    "sim/Cargo.toml",
    "sim/src",
    "situ/Cargo.toml",
    "situ/src",
    "synth_teachers/Cargo.toml",
    "synth_teachers/src",
    "tasks/Cargo.toml",
    "tasks/library",
    "tasks/src",
];

/// The hash of all files of the program: of each, in the order of the names, its name, its length and its content.
/// `None` where one cannot be read, or there is none.
pub(crate) fn sources(root: &Path) -> Option<String> {
    let mut files = Vec::new();
    for part in PARTS {
        walk(&root.join(part), part, &mut files);
    }
    files.sort();
    let mut hash = Sha256::new();
    for (name, path) in &files {
        let content = fs::read(path).ok()?;
        hash.update(format!("{name}\n{}\n", content.len()));
        hash.update(content);
    }
    (!files.is_empty()).then(|| hex(&hash.finalize()))
}

/// Every file at or below `path` that is not hidden, each with its name in the workspace.
fn walk(path: &Path, name: &str, files: &mut Vec<(String, PathBuf)>) {
    if path.is_file() {
        files.push((name.to_owned(), path.to_owned()));
    }
    for entry in fs::read_dir(path).into_iter().flatten().flatten() {
        let inner = entry.file_name().to_string_lossy().into_owned();
        if !inner.starts_with('.') {
            walk(&entry.path(), &format!("{name}/{inner}"), files);
        }
    }
}

/// Hexadecimal digits.
pub(crate) fn hex(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}

/// The last commit that changed the program, followed by `, changed` where its files are not those of the commit.
/// `None` outside a repository: in a source archive, even in one that was unpacked inside another repository.
pub(crate) fn revision(root: &Path) -> Option<String> {
    let top = said(git(root).args(["rev-parse", "--show-toplevel"]))?;
    if fs::canonicalize(top.trim()).ok()? != fs::canonicalize(root).ok()? {
        return None;
    }
    let commit = said(git(root).args(["log", "-1", "--format=%H", "--"]).args(PARTS))?;
    let changes = said(git(root).args(["status", "--porcelain", "--"]).args(PARTS))?;
    let commit = commit.trim();
    match (commit, changes.as_str()) {
        ("", _) => None,
        (_, "") => Some(commit.to_owned()),
        _ => Some(format!("{commit}, changed")),
    }
}

fn git(root: &Path) -> Command {
    let mut command = Command::new("git");
    command.arg("--no-optional-locks").arg("-C").arg(root);
    command
}

/// What a command prints, where it succeeds.
fn said(command: &mut Command) -> Option<String> {
    let output = command.output().ok().filter(|output| output.status.success())?;
    String::from_utf8(output.stdout).ok()
}
