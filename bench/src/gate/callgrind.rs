//! Exact instructions of updates, counted by valgrind's callgrind. The program runs itself under it, once for each
//! automaton.
//!
//! Only [`crate::cost::corrected`] is counted, and not how the automaton is taught. Callgrind writes one profile each
//! time that function returns.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use situ::edit::Edit;

use crate::error::BenchError;

/// The function that is counted, by its whole name. Callgrind's options for it must all give one name, not a pattern in
/// one and a name in another.
const COUNTED: &str = "situ_bench::cost::corrected";

/// Whether valgrind is here.
pub fn is_possible() -> bool {
    let status = Command::new("valgrind").arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status();
    status.is_ok_and(|status| status.success())
}

/// The instructions of one update of each edit, in the order of [`Edit::ALL`]. `program` is this program; `arguments`
/// make it measure those updates in that order and nothing else.
///
/// # Errors
/// [`BenchError::Valgrind`] where the run fails or its profiles are not to be read.
pub fn count(program: &Path, arguments: &[String]) -> Result<Vec<u64>, BenchError> {
    let refuse = |problem: String| BenchError::Valgrind { problem };
    let folder = tempfile::tempdir().map_err(|source| refuse(source.to_string()))?;
    let profile = folder.path().join("profile");
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--collect-atstart=no"])
        .arg(format!("--toggle-collect={COUNTED}"))
        .arg(format!("--dump-after={COUNTED}"))
        .arg(format!("--callgrind-out-file={}", profile.display()))
        .arg(program)
        .args(arguments)
        .output()
        .map_err(|source| refuse(source.to_string()))?;
    if !output.status.success() {
        return Err(refuse(String::from_utf8_lossy(&output.stderr).into_owned()));
    }
    (1..=Edit::ALL.len())
        .map(|number| {
            let path = profile.with_extension(number.to_string());
            let text = fs::read_to_string(&path).map_err(|source| refuse(format!("{}: {source}", path.display())))?;
            total(&text).ok_or_else(|| refuse(format!("{}: no totals in the profile", path.display())))
        })
        .collect()
}

/// The instructions of a profile.
fn total(profile: &str) -> Option<u64> {
    let line =
        profile.lines().find_map(|line| line.strip_prefix("totals:").or_else(|| line.strip_prefix("summary:")))?;
    line.split_whitespace().next()?.parse().ok()
}
