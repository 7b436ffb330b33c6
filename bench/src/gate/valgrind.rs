//! Exact instructions of updates, counted by valgrind's callgrind. The program runs itself under it, once for each
//! automaton.
//!
//! Only [`crate::cost::corrected`] is counted, and not how the automaton is taught. Callgrind writes one profile each
//! time that function returns.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use serde::Deserialize;
use serde_json::Value;
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

/// The part that is read of the runner's output for a bench.
#[derive(Deserialize)]
struct Summary {
    group: String,
    function_name: String,
    id: Option<String>,
    profiles: Value,
}

/// The name of a bench and the instructions that it took, from the line of JSON that gungraun's runner writes of it.
///
/// # Errors
/// [`BenchError::Valgrind`] where the line is none, or has no such number.
pub fn counted(line: &str) -> Result<(String, u64), BenchError> {
    let refuse = |problem: String| BenchError::Valgrind { problem: format!("gungraun's summary: {problem}") };
    let Summary { group, function_name, id, profiles } =
        serde_json::from_str(line).map_err(|error| refuse(error.to_string()))?;
    let name = [Some(group), Some(function_name), id].into_iter().flatten().collect::<Vec<_>>().join("::");
    // The number of this run; beside it may be that of the last run, under `old`.
    let count = profiles.pointer("/0/data/total/metrics/Ir/values/new").and_then(Value::as_u64);
    let count = count.ok_or_else(|| refuse(format!("no number of instructions of `{name}`")))?;
    Ok((name, count))
}

#[cfg(test)]
mod tests {
    use super::*;

    const FIT: &str = "kernels::hmm_fit::twenty_iterations";

    /// Lines of version 0.20 of the runner, cut down to the part that is read.
    #[test]
    fn the_runner_s_line_is_read() {
        let line = |values: &str, id: &str| {
            let profiles =
                format!(r#"[{{"tool":"callgrind","data":{{"total":{{"metrics":{{"Ir":{{{values}}}}}}}}}}}]"#);
            format!(r#"{{"function_name":"hmm_fit","group":"kernels",{id}"profiles":{profiles},"version":"1"}}"#)
        };
        let id = r#""id":"twenty_iterations","#;
        assert_eq!(counted(&line(r#""values":{"new":7}"#, id)).unwrap(), (FIT.to_owned(), 7));
        let compared = line(r#""change":{"factor":1.0},"values":{"new":7,"old":9}"#, "");
        assert_eq!(counted(&compared).unwrap(), ("kernels::hmm_fit".to_owned(), 7));
        for bad in [line(r#""values":{"old":9}"#, id), "kernels::hmm_fit".to_owned()] {
            let error = counted(&bad).unwrap_err().to_string();
            assert!(error.starts_with("valgrind: gungraun's summary: "), "{error}");
        }
    }
}
