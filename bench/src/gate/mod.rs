//! The gate of update cost: the work of updates and kernels now, against their work when it was last meant to change.
//!
//! Two baselines are files below `results/baselines`. A [`WorkBaseline`] holds the exact counters of the cost suite,
//! and the instructions of its smaller updates. `situ-bench cost --check` compares with it, and `situ-bench cost
//! --mint` writes it anew. An [`InstructionBaseline`] holds the instructions of kernels and of whole updates; the bench
//! `instructions` compares with it. Counters depend on the input alone, so any difference is a verdict. Instructions
//! depend on the toolchain, the target and the processor's vectors besides; they are compared where these are the same,
//! by [`TOLERANCE`]. The clock is in no baseline.
//!
//! `cargo bench -p situ-bench --bench instructions` counts instructions, by gungraun under valgrind's callgrind. A
//! program takes the same number each time. So a difference comes from the code or from the compiler:
//!
//! - more than [`TOLERANCE`] above the baseline is a regression, and the command fails;
//! - more than that below is an improvement: mint it, or what was gained can be lost again unseen;
//! - a count by another toolchain, target or kind of vectors, and a bench that the baseline lacks, are incomparable and
//!   never fail.
//!
//! A change that means to move a number mints the baseline in a commit of its own, and says why:
//!
//! ```text
//! cargo bench -p situ-bench --bench instructions -- --mint
//! ```

mod origin;
pub mod valgrind;

use std::collections::BTreeMap;
use std::fmt;
use std::fs;
use std::path::Path;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use situ::trace::Counters;

use crate::error::BenchError;
use crate::protocol::Protocol;
use crate::record::{CostRecord, Identity};

pub use origin::Origin;

/// Instructions that differ by no more than this share are unchanged.
pub const TOLERANCE: f64 = 0.02;

/// A measurement compared with the baseline.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Verdict {
    /// Some work is less and none is more.
    Improved,
    /// Some work is more.
    Regressed,
    /// All work is the same.
    Unchanged,
    /// There is nothing to compare with: the protocol is another, or one of the two lacks the row.
    Incomparable,
}

impl fmt::Display for Verdict {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(match self {
            Self::Improved => "improved",
            Self::Regressed => "regressed",
            Self::Unchanged => "unchanged",
            Self::Incomparable => "incomparable",
        })
    }
}

/// Whether so many instructions now are another number than before, by [`TOLERANCE`].
fn instructions_differ(before: u64, now: u64) -> bool {
    (now as f64 - before as f64).abs() > TOLERANCE * before as f64
}

/// The version that this program reads and writes.
pub(crate) const SCHEMA: u64 = 1;

/// Reads the file of a baseline; `schema` gives the version that it says it has.
///
/// # Errors
/// [`BenchError::Read`]; [`BenchError::Malformed`] with the line where the file is no baseline of this version.
pub(crate) fn read<T: DeserializeOwned>(path: &Path, schema: fn(&T) -> u64) -> Result<T, BenchError> {
    let text = fs::read_to_string(path).map_err(|source| BenchError::Read { path: path.to_owned(), source })?;
    let refuse = |line, problem| BenchError::Malformed { path: path.to_owned(), line, problem };
    let baseline: T = serde_json::from_str(&text).map_err(|error| refuse(error.line(), error.to_string()))?;
    match schema(&baseline) {
        SCHEMA => Ok(baseline),
        other => Err(refuse(1, format!("`schema`: expected {SCHEMA}, found {other}: mint it anew"))),
    }
}

/// The file's text.
pub(crate) fn to_json(baseline: &impl Serialize) -> String {
    serde_json::to_string_pretty(baseline).expect("a baseline's numbers are finite and its keys are strings") + "\n"
}

/// One update as it was measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MeasuredUpdate {
    /// The measurement; its time is 0.
    #[serde(flatten)]
    pub cost: CostRecord,
    /// Instructions of the update, where they were counted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub instructions: Option<u64>,
}

/// The baseline.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WorkBaseline {
    schema: u64,
    /// Where it was minted.
    pub origin: Origin,
    /// The text of the protocol.
    pub protocol: String,
    /// One row for each update, in canonical order.
    pub rows: Vec<MeasuredUpdate>,
}

/// The verdict on one update.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Judged {
    /// The update.
    pub update: Identity,
    /// The verdict.
    pub verdict: Verdict,
    /// Why, in words.
    pub why: String,
}

impl WorkBaseline {
    /// A baseline of these measurements.
    pub fn new(origin: Origin, protocol: &Protocol, rows: Vec<MeasuredUpdate>) -> Self {
        let mut rows = rows;
        rows.iter_mut().for_each(|row| row.cost.update_seconds = 0.0);
        rows.sort_by_key(|row| row.cost.identity());
        Self { schema: SCHEMA, origin, protocol: protocol.source.clone(), rows }
    }

    /// Reads a baseline.
    ///
    /// # Errors
    /// [`BenchError::Read`]; [`BenchError::Malformed`] with the line where it is none.
    pub fn read(path: &Path) -> Result<Self, BenchError> {
        read(path, |baseline: &Self| baseline.schema)
    }

    /// The file's text.
    pub fn to_json(&self) -> String {
        to_json(self)
    }

    /// The verdict on each update of either, in canonical order.
    pub fn judge(&self, origin: &Origin, protocol: &Protocol, rows: &[MeasuredUpdate]) -> Vec<Judged> {
        let by_name = |rows: &[MeasuredUpdate]| {
            rows.iter().map(|row| (row.cost.identity(), row.clone())).collect::<BTreeMap<_, _>>()
        };
        let (before, now) = (by_name(&self.rows), by_name(rows));
        let mut names: Vec<&Identity> = before.keys().chain(now.keys()).collect();
        names.sort();
        names.dedup();
        let counts_instructions = self.origin.counts_as(origin);
        names
            .into_iter()
            .map(|name| {
                let (verdict, why) = match (before.get(name), now.get(name)) {
                    _ if self.protocol != protocol.source => (Verdict::Incomparable, "another protocol".to_owned()),
                    (None, _) => (Verdict::Incomparable, "not in the baseline".to_owned()),
                    (_, None) => (Verdict::Incomparable, "not measured".to_owned()),
                    (Some(before), Some(now)) => judge(before, now, counts_instructions),
                };
                Judged { update: name.clone(), verdict, why }
            })
            .collect()
    }
}

fn judge(before: &MeasuredUpdate, now: &MeasuredUpdate, counts_instructions: bool) -> (Verdict, String) {
    if before.cost.edit_made != now.cost.edit_made {
        return (Verdict::Incomparable, format!("it made {}, now {}", before.cost.edit_made, now.cost.edit_made));
    }
    let mut changes = both(&before.cost.counters, &now.cost.counters);
    let instructions = before.instructions.zip(now.instructions).filter(|_| counts_instructions);
    if let Some((before, now)) = instructions
        && instructions_differ(before, now)
    {
        changes.push(("instructions", before, now));
    }
    verdict(changes)
}

/// Each counter, before and now.
pub fn both(before: &Counters, now: &Counters) -> Vec<(&'static str, u64, u64)> {
    before.named().into_iter().zip(now.named()).map(|((name, before), (_, now))| (name, before, now)).collect()
}

/// The verdict on work that was counted before and now, and why.
pub fn verdict(mut changes: Vec<(&str, u64, u64)>) -> (Verdict, String) {
    changes.retain(|(_, before, now)| before != now);
    let why =
        changes.iter().map(|(name, before, now)| format!("{name} {before} → {now}")).collect::<Vec<_>>().join(", ");
    let verdict = match () {
        () if changes.is_empty() => Verdict::Unchanged,
        () if changes.iter().any(|(_, before, now)| now > before) => Verdict::Regressed,
        () => Verdict::Improved,
    };
    (verdict, why)
}

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
    /// [`BenchError::Read`]; [`BenchError::Malformed`] with the line where it is none.
    pub fn read(path: &Path) -> Result<Self, BenchError> {
        read(path, |baseline: &Self| baseline.schema)
    }

    /// The file's text.
    pub fn to_json(&self) -> String {
        to_json(self)
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
    use crate::record::Record;
    use crate::sample;

    fn rows() -> Vec<MeasuredUpdate> {
        let costs = sample::records().into_iter().filter_map(|record| match record {
            Record::Cost(cost) => Some(MeasuredUpdate { cost, instructions: Some(1_000_000) }),
            Record::Run(_) => None,
        });
        costs.collect()
    }

    /// One more iteration of EM and one needless divergence are caught, each in its row. Less work is an improvement
    /// unless other work grew. A row that cannot be compared is never a regression.
    #[test]
    fn any_work_more_is_a_regression() {
        let protocol = Protocol::find("cost").unwrap();
        let baseline = WorkBaseline::new(Origin::sample("rustc 1"), &protocol, rows());
        let verdicts = |change: &dyn Fn(&mut MeasuredUpdate)| {
            let mut rows = rows();
            change(&mut rows[3]);
            rows[3].cost.update_seconds *= 100.0;
            let judged = baseline.judge(&Origin::sample("rustc 1"), &protocol, &rows);
            let changed: Vec<(Verdict, String)> = judged
                .into_iter()
                .filter(|judged| judged.verdict != Verdict::Unchanged)
                .map(|judged| (judged.verdict, judged.why))
                .collect();
            changed
        };
        assert_eq!(verdicts(&|_| ()), [], "the clock is no verdict");
        let one = |verdict, why: &str| [(verdict, why.to_owned())];
        let em = rows()[3].cost.counters.em_iterations;
        let why = format!("em_iterations {em} → {}", em + 1);
        assert_eq!(verdicts(&|row| row.cost.counters.em_iterations += 1), one(Verdict::Regressed, &why));
        assert_eq!(verdicts(&|row| row.cost.counters.divergences += 1), one(Verdict::Regressed, "divergences 0 → 1"));
        let less = |row: &mut MeasuredUpdate| row.cost.counters.classifier_fits -= 1;
        assert_eq!(verdicts(&less), one(Verdict::Improved, "classifier_fits 3 → 2"));
        let both = |row: &mut MeasuredUpdate| {
            less(row);
            row.cost.counters.divergences += 1;
        };
        assert_eq!(verdicts(&both)[0].0, Verdict::Regressed);
        assert_eq!(verdicts(&|row| row.instructions = Some(1_019_000)), [], "within the tolerance");
        let why = "instructions 1000000 → 1021000";
        assert_eq!(verdicts(&|row| row.instructions = Some(1_021_000)), one(Verdict::Regressed, why));
        assert_eq!(verdicts(&|row| row.instructions = None), [], "without valgrind the counters alone are compared");
        // The row is renamed: the old name is not measured, and the new one is not in the baseline.
        let renamed = verdicts(&|row| row.cost.nodes += 1);
        assert!(
            renamed.len() == 2 && renamed.iter().all(|(verdict, _)| *verdict == Verdict::Incomparable),
            "{renamed:?}"
        );
        let mut slower = rows();
        slower[0].instructions = Some(5_000_000);
        let all = |judged: Vec<Judged>, verdict| {
            judged.len() == slower.len() && judged.iter().all(|one| one.verdict == verdict)
        };
        assert!(
            all(baseline.judge(&Origin::sample("rustc 2"), &protocol, &slower), Verdict::Unchanged),
            "another compiler"
        );
        let quick = Protocol::find("quick").unwrap();
        assert!(
            all(baseline.judge(&Origin::sample("rustc 1"), &quick, &slower), Verdict::Incomparable),
            "another protocol"
        );
    }

    #[test]
    fn what_is_written_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("baseline.json");
        let baseline = WorkBaseline::new(Origin::sample("rustc 1"), &Protocol::find("cost").unwrap(), rows());
        fs::write(&path, baseline.to_json()).unwrap();
        assert_eq!(WorkBaseline::read(&path).unwrap(), baseline);
        fs::write(&path, baseline.to_json().replace("\"hmm_fits\": 6,", "\"hmm_fits\": -6,")).unwrap();
        let error = WorkBaseline::read(&path).unwrap_err();
        assert!(error.to_string().contains("baseline.json:") && error.exit_status() == 2, "{error}");
    }

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
    fn an_instruction_baseline_is_read_as_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("instructions.json");
        fs::write(&path, expected(7).to_json()).unwrap();
        assert_eq!(InstructionBaseline::read(&path).unwrap(), expected(7));
        fs::write(&path, expected(7).to_json().replace(": 7", ": -7")).unwrap();
        let error = InstructionBaseline::read(&path).unwrap_err();
        assert!(error.to_string().contains("instructions.json:") && error.exit_status() == 2, "{error}");
    }
}
