//! Tells the program what it was built of: the revision, a hash of its sources, the lock file's and the compiler. The
//! manifests of ledgers and the baselines name them.
//!
//! The script runs again where one of these files changed, and after a commit. Then the crate is built again, and no
//! other crate of the workspace is.

use std::env;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use sha2::{Digest, Sha256};

/// What the program is made of, in the workspace. Tests, results and prose make no other program.
const PROGRAM: [&str; 15] = [
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
/// What is said of something that cannot be known.
const UNKNOWN: &str = "unknown";

fn main() {
    let root = Path::new("..");
    let rustc = env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let toolchain = said(Command::new(rustc).arg("--version"));
    let lock = fs::read(root.join("Cargo.lock")).ok().map(|text| hex(&Sha256::digest(text)));
    tell("TOOLCHAIN", toolchain);
    tell("TARGET", env::var("TARGET").ok());
    tell("LOCK", lock);
    tell("SOURCES", sources(root));
    tell("REVISION", revision(root));
    let watched = PROGRAM.iter().map(|path| root.join(path)).chain(log_of_commits(root));
    watched.filter(|path| path.exists()).for_each(|path| println!("cargo:rerun-if-changed={}", path.display()));
}

fn tell(name: &str, value: Option<String>) {
    println!("cargo:rustc-env=SITU_{name}={}", value.as_deref().unwrap_or(UNKNOWN));
}

/// What a command prints, where it succeeds and prints something.
fn said(command: &mut Command) -> Option<String> {
    let output = command.output().ok().filter(|output| output.status.success())?;
    let text = String::from_utf8(output.stdout).ok()?.trim().to_owned();
    (!text.is_empty()).then_some(text)
}

fn git(root: &Path) -> Command {
    let mut command = Command::new("git");
    command.arg("--no-optional-locks").arg("-C").arg(root);
    command
}

/// The last commit that changed the program, and whether files were changed since. `None` outside a repository: in a
/// source archive, even in one that was unpacked inside another repository.
fn revision(root: &Path) -> Option<String> {
    let top = said(git(root).args(["rev-parse", "--show-toplevel"]))?;
    if fs::canonicalize(top).ok()? != fs::canonicalize(root).ok()? {
        return None;
    }
    let commit = said(git(root).args(["log", "-1", "--format=%H", "--"]).args(PROGRAM))?;
    let changes = said(git(root).args(["status", "--porcelain", "--"]).args(PROGRAM));
    Some(if changes.is_some() { format!("{commit}, changed") } else { commit })
}

/// The file that grows with each commit and checkout.
fn log_of_commits(root: &Path) -> Option<PathBuf> {
    said(git(root).args(["rev-parse", "--git-path", "logs/HEAD"])).map(|path| root.join(path))
}

/// The hash of all files of the program: of each the name, the length and the content.
fn sources(root: &Path) -> Option<String> {
    let mut files = Vec::new();
    for path in PROGRAM {
        walk(&root.join(path), path, &mut files);
    }
    files.sort();
    let mut hash = Sha256::new();
    for (name, path) in files {
        let content = fs::read(path).ok()?;
        hash.update(format!("{name}\n{}\n", content.len()));
        hash.update(content);
    }
    Some(hex(&hash.finalize()))
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

fn hex(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}
