//! The baseline of instructions: those of each kernel and each whole update when they were last meant to change.
//!
//! `cargo bench -p situ-bench --bench instructions` counts them, by gungraun under valgrind's callgrind, and holds them
//! against `results/baselines/instructions.json`. A program takes the same number each time. So a difference comes from
//! the code or from the compiler:
//!
//! - more than [`TOLERANCE`](super::verdict::TOLERANCE) above the baseline is a regression, and the command fails;
//! - more than that below is an improvement: mint it, or what was gained can be lost again unseen;
//! - a count by another toolchain, target or kind of vectors, and a bench that the baseline lacks, are incomparable and
//!   never fail.
//!
//! A change that means to move a number mints the baseline in a commit of its own, and says why:
//!
//! ```text
//! cargo bench -p situ-bench --bench instructions -- --mint
//! ```

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::baseline_file::{self, SCHEMA};
use super::origin::Origin;
use super::verdict::{Verdict, instructions_differ};
use crate::error::BenchError;

/// The baseline: the expected instructions of each bench.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InstructionBaseline {
    schema: u64,
    /// Where it was minted.
    pub origin: Origin,
    /// Instructions by the name of the bench.
    pub instructions: BTreeMap<String, u64>,
}

impl InstructionBaseline {
    /// A baseline of these counts.
    pub fn new(origin: Origin, instructions: BTreeMap<String, u64>) -> Self {
        Self { schema: SCHEMA, origin, instructions }
    }

    /// Reads a baseline.
    ///
    /// # Errors
    /// [`BenchError::Read`]; [`BenchError::Baseline`] with the line where it is none.
    pub fn read(path: &Path) -> Result<Self, BenchError> {
        baseline_file::read(path, |baseline: &Self| baseline.schema)
    }

    /// The file's text.
    pub fn to_json(&self) -> String {
        baseline_file::to_json(self)
    }

    /// The verdict on so many instructions of a bench, and why.
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

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    const FIT: &str = "kernels::hmm_fit::twenty_iterations";

    fn expected(count: u64) -> InstructionBaseline {
        InstructionBaseline::new(Origin::sample("rustc 1"), BTreeMap::from([(FIT.to_owned(), count)]))
    }

    /// One more iteration of EM in twenty is caught, and the words say where. A change within the tolerance is none.
    /// Fewer instructions are to be minted. A count that cannot be compared is never a regression.
    #[test]
    fn a_planted_slowdown_is_caught() {
        let twenty = 20 * 1_000_000;
        let judge = |now| expected(twenty).judge(&Origin::sample("rustc 1"), FIT, now);
        let why = "20000000 → 21000000 instructions, +5.00 %";
        assert_eq!(judge(21 * 1_000_000), (Verdict::Regressed, why.to_owned()));
        assert_eq!(judge(twenty).0, Verdict::Unchanged);
        assert_eq!(judge(twenty + twenty / 50).0, Verdict::Unchanged, "2 % is within the tolerance");
        assert_eq!(judge(twenty + twenty / 50 + 1).0, Verdict::Regressed, "and not an instruction more");
        let why = "20000000 → 19000000 instructions, -5.00 %: mint it";
        assert_eq!(judge(19 * 1_000_000), (Verdict::Improved, why.to_owned()));
        let (verdict, why) = expected(twenty).judge(&Origin::sample("rustc 2"), FIT, 10 * twenty);
        assert!(verdict == Verdict::Incomparable && why.ends_with("is of rustc 1 for c with d"), "{why}");
        let (verdict, why) = expected(twenty).judge(&Origin::sample("rustc 1"), "kernels::another", 1);
        assert!(verdict == Verdict::Incomparable && why.contains("mint"), "{why}");
    }

    #[test]
    fn what_is_written_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("instructions.json");
        fs::write(&path, expected(7).to_json()).unwrap();
        assert_eq!(InstructionBaseline::read(&path).unwrap(), expected(7));
        fs::write(&path, expected(7).to_json().replace(": 7", ": -7")).unwrap();
        let error = InstructionBaseline::read(&path).unwrap_err();
        assert!(error.to_string().contains("instructions.json:") && error.exit_status() == 2, "{error}");
    }
}
