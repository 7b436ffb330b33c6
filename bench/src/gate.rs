//! The gate on the instructions of kernels and whole updates: what each took when that was last meant to change, and what it takes now.
//!
//! `cargo bench -p situ-bench --bench instructions` counts them, by gungraun under valgrind's callgrind, and holds them against
//! `results/baselines/instructions.json`. A program takes the same number each time, so what differs is the code, or the compiler:
//!
//! - more than [`TOLERANCE`](crate::baseline::TOLERANCE) above the baseline is a regression, and the command fails;
//! - more than that below is an improvement: mint it, or what was gained can be lost again unseen;
//! - what another toolchain, target or kind of vectors counted, or what the baseline has not, is incomparable and never fails.
//!
//! A change that means to move a number mints the baseline in a commit of its own, and says why:
//!
//! ```text
//! cargo bench -p situ-bench --bench instructions -- --mint
//! ```

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::baseline::{Origin, Verdict, instructions_differ};
use crate::error::BenchError;

/// The version of the file.
const SCHEMA: u64 = 1;

/// The baseline: what each bench is expected to take.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Expected {
    schema: u64,
    /// Where it was minted.
    pub origin: Origin,
    /// Instructions by the name of the bench.
    pub instructions: BTreeMap<String, u64>,
}

impl Expected {
    /// A baseline of these counts.
    pub fn new(origin: Origin, instructions: BTreeMap<String, u64>) -> Self {
        Self { schema: SCHEMA, origin, instructions }
    }

    /// Reads a baseline.
    ///
    /// # Errors
    /// [`BenchError::Read`]; [`BenchError::Baseline`] with the line where it is none.
    pub fn read(path: &Path) -> Result<Self, BenchError> {
        let text = fs::read_to_string(path).map_err(|source| BenchError::Read { path: path.to_owned(), source })?;
        let refuse = |line, problem| BenchError::Baseline { path: path.to_owned(), line, problem };
        let expected: Self = serde_json::from_str(&text).map_err(|error| refuse(error.line(), error.to_string()))?;
        if expected.schema != SCHEMA {
            return Err(refuse(1, format!("`schema`: expected {SCHEMA}, found {}: mint it anew", expected.schema)));
        }
        Ok(expected)
    }

    /// The file's text.
    pub fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).expect("it has no number that is not finite") + "\n"
    }

    /// What so many instructions of a bench are, and why.
    pub fn judge(&self, origin: &Origin, bench: &str, now: u64) -> (Verdict, String) {
        let Some(before) = self.instructions.get(bench).copied() else {
            return (Verdict::Incomparable, format!("{now} instructions, not in the baseline: mint it"));
        };
        let share = 100.0 * (now as f64 / before as f64 - 1.0);
        let change = format!("{before} → {now} instructions, {share:+.2} %");
        match () {
            () if !self.origin.counts_as(origin) => {
                let Origin { toolchain, target, vectors, .. } = &self.origin;
                let why = format!("{change}, but the baseline is of {toolchain} for {target} with {vectors}");
                (Verdict::Incomparable, why)
            }
            () if !instructions_differ(before, now) => (Verdict::Unchanged, change),
            () if now > before => (Verdict::Regressed, change),
            () => (Verdict::Improved, format!("{change}: mint it")),
        }
    }
}

/// What gungraun says of a bench, as far as it is read.
#[derive(Deserialize)]
struct Summary {
    group: String,
    function_name: String,
    id: Option<String>,
    profiles: serde_json::Value,
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
    let count = profiles.pointer("/0/data/total/metrics/Ir/values/new").and_then(serde_json::Value::as_u64);
    let count = count.ok_or_else(|| refuse(format!("no number of instructions of `{name}`")))?;
    Ok((name, count))
}

#[cfg(test)]
mod tests {
    use super::*;

    const FIT: &str = "kernels::hmm_fit::twenty_iterations";

    fn origin(toolchain: &str) -> Origin {
        let word = |text: &str| text.to_owned();
        let [machine, revision, target, vectors] = ["a", "b", "c", "d"].map(word);
        Origin { machine, revision, toolchain: word(toolchain), target, vectors }
    }

    fn expected(count: u64) -> Expected {
        Expected::new(origin("rustc 1"), BTreeMap::from([(FIT.to_owned(), count)]))
    }

    /// One more iteration of EM in twenty is caught, in the words that say where; what is within the tolerance is not, what is less is to be
    /// minted, and what cannot be compared is never a regression.
    #[test]
    fn a_planted_slowdown_is_caught() {
        let twenty = 20 * 1_000_000;
        let judge = |now| expected(twenty).judge(&origin("rustc 1"), FIT, now);
        let why = "20000000 → 21000000 instructions, +5.00 %";
        assert_eq!(judge(21 * 1_000_000), (Verdict::Regressed, why.to_owned()));
        assert_eq!(judge(twenty).0, Verdict::Unchanged);
        assert_eq!(judge(twenty + twenty / 50).0, Verdict::Unchanged, "2 % is within the tolerance");
        assert_eq!(judge(twenty + twenty / 50 + 1).0, Verdict::Regressed, "and not an instruction more");
        let why = "20000000 → 19000000 instructions, -5.00 %: mint it";
        assert_eq!(judge(19 * 1_000_000), (Verdict::Improved, why.to_owned()));
        let (verdict, why) = expected(twenty).judge(&origin("rustc 2"), FIT, 10 * twenty);
        assert!(verdict == Verdict::Incomparable && why.ends_with("is of rustc 1 for c with d"), "{why}");
        let (verdict, why) = expected(twenty).judge(&origin("rustc 1"), "kernels::another", 1);
        assert!(verdict == Verdict::Incomparable && why.contains("mint"), "{why}");
    }

    #[test]
    fn what_is_written_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("instructions.json");
        fs::write(&path, expected(7).to_json()).unwrap();
        assert_eq!(Expected::read(&path).unwrap(), expected(7));
        fs::write(&path, expected(7).to_json().replace(": 7", ": -7")).unwrap();
        let error = Expected::read(&path).unwrap_err();
        assert!(error.to_string().contains("instructions.json:") && error.exit_status() == 2, "{error}");
    }

    /// The lines of version 0.20 of the runner, cut down to what is read of them.
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
