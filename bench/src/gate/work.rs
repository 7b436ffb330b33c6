//! The baseline of the cost suite: the exact work of each update when that was last meant to change.
//!
//! `situ-bench cost --check` compares with it, `situ-bench cost --mint` writes it anew.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::baseline_file::{self, SCHEMA};
use super::origin::Origin;
use super::verdict::{Verdict, instructions_differ};
use crate::error::BenchError;
use crate::protocol::Protocol;
use crate::record::{CostRecord, Identity};

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
    /// [`BenchError::Read`]; [`BenchError::Baseline`] with the line where it is none.
    pub fn read(path: &Path) -> Result<Self, BenchError> {
        baseline_file::read(path, |baseline: &Self| baseline.schema)
    }

    /// The file's text.
    pub fn to_json(&self) -> String {
        baseline_file::to_json(self)
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
    let mut changes: Vec<(&str, u64, u64)> = before
        .cost
        .counters
        .named()
        .into_iter()
        .zip(now.cost.counters.named())
        .map(|((name, before), (_, now))| (name, before, now))
        .collect();
    let instructions = before.instructions.zip(now.instructions).filter(|_| counts_instructions);
    if let Some((before, now)) = instructions
        && instructions_differ(before, now)
    {
        changes.push(("instructions", before, now));
    }
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
}
