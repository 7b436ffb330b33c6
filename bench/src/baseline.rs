//! The update-cost baseline: the exact work of the cost suite as it was when it was last meant to change, and what a new measurement is
//! against it.
//!
//! Counters depend on the input alone, so any difference is a verdict. Instructions depend on the toolchain, the target and the
//! processor's vectors besides; they are compared where these are the same, and by [`TOLERANCE`]. The clock is in no baseline.

use std::collections::BTreeMap;
use std::fmt;
use std::fs;
use std::path::Path;
use std::process::Command;

use serde::{Deserialize, Serialize};

use crate::error::BenchError;
use crate::protocol::Protocol;
use crate::record::{Cost, Identity, Record};

/// The version of the file.
const SCHEMA: u64 = 1;
/// Instructions that differ by no more than this share are unchanged.
pub const TOLERANCE: f64 = 0.02;

/// Where and of what a baseline was minted.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Origin {
    /// The machine's processor, in its own words.
    pub machine: String,
    /// The revision of the code; `unknown` outside a repository.
    pub revision: String,
    /// The compiler, in its own words.
    pub toolchain: String,
    /// The target triple.
    pub target: String,
    /// The processor's vectors that the kernels ran on ([`situ::vector::kind`]).
    #[serde(default)]
    pub vectors: String,
}

impl Origin {
    /// Of this code, on this machine.
    pub fn here() -> Self {
        let cpu = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
        let model = cpu.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
        let git = |words: &[&str]| {
            let output = Command::new("git").args(words).output().ok().filter(|output| output.status.success())?;
            Some(String::from_utf8(output.stdout).ok()?.trim().to_owned())
        };
        let changes = git(&["status", "--porcelain", "--untracked-files=no"]);
        let changed = changes.is_some_and(|changes| !changes.is_empty());
        let revision = git(&["rev-parse", "HEAD"]).unwrap_or_else(|| "unknown".to_owned());
        Self {
            machine: model.map_or("unknown", |(_, model)| model.trim()).to_owned(),
            revision: if changed { format!("{revision}, changed") } else { revision },
            toolchain: env!("SITU_TOOLCHAIN").to_owned(),
            target: env!("SITU_TARGET").to_owned(),
            vectors: situ::vector::kind().to_owned(),
        }
    }

    /// Whether instructions that were counted here and there are to be compared.
    pub fn counts_as(&self, other: &Self) -> bool {
        (&self.toolchain, &self.target, &self.vectors) == (&other.toolchain, &other.target, &other.vectors)
    }
}

/// Whether so many instructions now are another number than before, by [`TOLERANCE`].
pub fn instructions_differ(before: u64, now: u64) -> bool {
    (now as f64 - before as f64).abs() > TOLERANCE * before as f64
}

/// A row: one update.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Row {
    /// What was measured, its time 0.
    #[serde(flatten)]
    pub cost: Cost,
    /// Instructions of the update, where they were counted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub instructions: Option<u64>,
}

/// The baseline.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Baseline {
    schema: u64,
    /// Where it was minted.
    pub origin: Origin,
    /// The text of the protocol.
    pub protocol: String,
    /// One an update, in canonical order.
    pub rows: Vec<Row>,
}

/// What a measurement is against the baseline.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Verdict {
    /// Some work is less and none is more.
    Improved,
    /// Some work is more.
    Regressed,
    /// All work is the same.
    Unchanged,
    /// There is nothing to compare with: another protocol, or a row that one of the two has not.
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

impl Baseline {
    /// A baseline of these measurements.
    pub fn new(origin: Origin, protocol: &Protocol, rows: Vec<Row>) -> Self {
        let mut rows = rows;
        rows.iter_mut().for_each(|row| row.cost.update_seconds = 0.0);
        rows.sort_by_key(|row| identity(&row.cost));
        Self { schema: SCHEMA, origin, protocol: protocol.source.clone(), rows }
    }

    /// Reads a baseline.
    ///
    /// # Errors
    /// [`BenchError::Read`]; [`BenchError::Baseline`] with the line where it is none.
    pub fn read(path: &Path) -> Result<Self, BenchError> {
        let text = fs::read_to_string(path).map_err(|source| BenchError::Read { path: path.to_owned(), source })?;
        let refuse = |line, problem| BenchError::Baseline { path: path.to_owned(), line, problem };
        let baseline: Self = serde_json::from_str(&text).map_err(|error| refuse(error.line(), error.to_string()))?;
        if baseline.schema != SCHEMA {
            return Err(refuse(1, format!("`schema`: expected {SCHEMA}, found {}: mint it anew", baseline.schema)));
        }
        Ok(baseline)
    }

    /// The file's text.
    pub fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).expect("its numbers are finite") + "\n"
    }

    /// The verdict on each update of either, in canonical order.
    pub fn judge(&self, origin: &Origin, protocol: &Protocol, rows: &[Row]) -> Vec<Judged> {
        let by_name =
            |rows: &[Row]| rows.iter().map(|row| (identity(&row.cost), row.clone())).collect::<BTreeMap<_, _>>();
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

fn identity(cost: &Cost) -> Identity {
    Record::Cost(cost.clone()).identity()
}

fn judge(before: &Row, now: &Row, counts_instructions: bool) -> (Verdict, String) {
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
    use super::*;
    use crate::tables::tests::sample;

    fn rows() -> Vec<Row> {
        let costs = sample().into_iter().filter_map(|record| match record {
            Record::Cost(cost) => Some(Row { cost, instructions: Some(1_000_000) }),
            Record::Run(_) => None,
        });
        costs.collect()
    }

    fn origin(toolchain: &str) -> Origin {
        let word = |text: &str| text.to_owned();
        let [machine, revision, target, vectors] = ["a", "b", "c", "d"].map(word);
        Origin { machine, revision, toolchain: word(toolchain), target, vectors }
    }

    /// One more iteration of EM and one needless divergence are caught, in the row in which they are; less work is an improvement unless other
    /// work grew; and what cannot be compared is never a regression.
    #[test]
    fn any_work_more_is_a_regression() {
        let protocol = Protocol::find("cost").unwrap();
        let baseline = Baseline::new(origin("rustc 1"), &protocol, rows());
        let verdicts = |change: &dyn Fn(&mut Row)| {
            let mut rows = rows();
            change(&mut rows[3]);
            rows[3].cost.update_seconds *= 100.0;
            let judged = baseline.judge(&origin("rustc 1"), &protocol, &rows);
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
        let less = |row: &mut Row| row.cost.counters.classifier_fits -= 1;
        assert_eq!(verdicts(&less), one(Verdict::Improved, "classifier_fits 3 → 2"));
        let both = |row: &mut Row| {
            less(row);
            row.cost.counters.divergences += 1;
        };
        assert_eq!(verdicts(&both)[0].0, Verdict::Regressed);
        assert_eq!(verdicts(&|row| row.instructions = Some(1_019_000)), [], "within the tolerance");
        let why = "instructions 1000000 → 1021000";
        assert_eq!(verdicts(&|row| row.instructions = Some(1_021_000)), one(Verdict::Regressed, why));
        assert_eq!(verdicts(&|row| row.instructions = None), [], "without valgrind the counters alone are compared");
        // The row it was is not measured, the one that it is now is not in the baseline.
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
        assert!(all(baseline.judge(&origin("rustc 2"), &protocol, &slower), Verdict::Unchanged), "another compiler");
        let quick = Protocol::find("quick").unwrap();
        assert!(all(baseline.judge(&origin("rustc 1"), &quick, &slower), Verdict::Incomparable), "another protocol");
    }

    #[test]
    fn what_is_written_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("baseline.json");
        let baseline = Baseline::new(origin("rustc 1"), &Protocol::find("cost").unwrap(), rows());
        fs::write(&path, baseline.to_json()).unwrap();
        assert_eq!(Baseline::read(&path).unwrap(), baseline);
        fs::write(&path, baseline.to_json().replace("\"hmm_fits\": 6,", "\"hmm_fits\": -6,")).unwrap();
        let error = Baseline::read(&path).unwrap_err();
        assert!(error.to_string().contains("baseline.json:") && error.exit_status() == 2, "{error}");
    }
}
