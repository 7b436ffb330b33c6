//! What this program was built of. What cannot be known is [`UNKNOWN`].

use std::path::Path;

pub(crate) mod checkout;

/// What is said of something that cannot be known.
pub const UNKNOWN: &str = "unknown";
/// The SHA-256 of all files that the program was built of, `Cargo.lock` among them, in hexadecimal digits. Where two
/// programs have the same, they are of the same code, whether it was committed or not.
pub const SOURCES: &str = env!("SITU_SOURCES");
/// The SHA-256 of `Cargo.lock`, in hexadecimal digits.
pub const LOCK: &str = env!("SITU_LOCK");
/// The compiler, in its own words.
pub const TOOLCHAIN: &str = env!("SITU_TOOLCHAIN");
/// The target triple.
pub const TARGET: &str = env!("SITU_TARGET");

/// The last commit that changed the program's sources, followed by `, changed` where the files were not those of the
/// commit; `unknown` outside a repository. Commits of results, tests and prose make no other program.
///
/// A commit is no reason to build the program again. So the workspace is asked once more: while it holds the files that
/// the program was built of, its revision is the program's. Where they have changed, or are not on this machine, what
/// counts is the revision when the program was built.
pub fn revision() -> String {
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."));
    let is_built_of = checkout::sources(root).is_some_and(|sources| sources == SOURCES);
    let now = if is_built_of { checkout::revision(root) } else { None };
    now.unwrap_or_else(|| env!("SITU_REVISION").to_owned())
}
