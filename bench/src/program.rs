//! What this program was built of, as the build script found it. What it could not find is [`UNKNOWN`].

/// What is said of something that cannot be known.
pub const UNKNOWN: &str = "unknown";
/// The last commit that changed the program's sources, followed by `, changed` where the files were not those of the
/// commit. Commits of results, tests and prose make no other program. Unknown outside a repository.
pub const REVISION: &str = env!("SITU_REVISION");
/// The SHA-256 of all files that the program was built of, `Cargo.lock` among them, in hexadecimal digits. Where two
/// programs have the same, they are of the same code, whether it was committed or not.
pub const SOURCES: &str = env!("SITU_SOURCES");
/// The SHA-256 of `Cargo.lock`, in hexadecimal digits.
pub const LOCK: &str = env!("SITU_LOCK");
/// The compiler, in its own words.
pub const TOOLCHAIN: &str = env!("SITU_TOOLCHAIN");
/// The target triple.
pub const TARGET: &str = env!("SITU_TARGET");
