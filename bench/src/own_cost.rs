//! What the corrections of a model of one's own cost: the gate for an engineer whose robot must not get slower at
//! learning. Counters are exact, so they are held to a baseline; the clock is in none.

use std::fmt::Write;
use std::path::Path;

use comfy_table::{Table, presets::ASCII_MARKDOWN};
use serde::{Deserialize, Serialize};
use situ::edit::Edit;
use situ::trace::Counters;

use crate::cost::processor_timed;
use crate::demonstration_file::DemonstrationFile;
use crate::error::BenchError;
use crate::gate::{self, Verdict};
use crate::kept_model::{KeptDemonstration, KeptModel};
use crate::stop::StopPoint;

/// Corrections side by side.
const COLUMNS: usize = 4;
/// How often a correction is timed, each time on a copy of the model.
const TIMES: usize = 5;

/// What one correction cost.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OwnUpdate {
    /// The corrective demonstration.
    pub correction: KeptDemonstration,
    /// The edit that it made.
    pub edit_made: Edit,
    /// Its work.
    pub counters: Counters,
    /// Processor seconds, the least first; in no baseline.
    #[serde(skip)]
    pub seconds: Vec<f64>,
}

/// The baseline of a model of one's own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OwnBaseline {
    schema: u64,
    /// The method of the model.
    pub method: String,
    /// The hash of the model's file.
    pub model: String,
    /// One row for each correction, in order.
    pub rows: Vec<OwnUpdate>,
}

/// Folds corrections into a model, one after another, and measures each.
///
/// # Errors
/// As [`KeptModel::correct`].
pub fn measured(
    kept: &mut KeptModel,
    corrections: &[DemonstrationFile],
    stops: &[StopPoint],
) -> Result<Vec<OwnUpdate>, BenchError> {
    let mut rows = Vec::with_capacity(corrections.len());
    for (file, stop) in corrections.iter().zip(stops) {
        let mut seconds = Vec::with_capacity(TIMES);
        for _ in 1..TIMES {
            let mut copy = kept.copied();
            seconds.push(processor_timed(|| copy.correct(file, stop)).1);
        }
        let (corrected, last) = processor_timed(|| kept.correct(file, stop));
        let corrected = corrected?;
        seconds.push(last);
        seconds.sort_by(f64::total_cmp);
        let correction =
            kept.seen.last().cloned().ok_or_else(|| {
                BenchError::Argument(format!("`{}` does not keep what it has seen", kept.method.name()))
            })?;
        let (edit_made, counters) = (corrected.difference.edit(), corrected.trace.counters);
        rows.push(OwnUpdate { correction, edit_made, counters, seconds });
    }
    Ok(rows)
}

/// The measurements as a table, a column for each correction.
pub fn table(rows: &[OwnUpdate]) -> String {
    let mut text = String::new();
    for few in rows.chunks(COLUMNS) {
        let mut table = Table::new();
        table.load_style(ASCII_MARKDOWN);
        table
            .set_header(["correction".to_owned()].into_iter().chain(few.iter().map(|row| row.correction.name.clone())));
        let made = few.iter().map(|row| row.edit_made.to_string());
        table.add_row(["edit made".to_owned()].into_iter().chain(made));
        for (word, at) in [("ms (processor), median", TIMES / 2), ("least", 0), ("greatest", TIMES - 1)] {
            let milliseconds =
                |row: &OwnUpdate| format!("{:.2}", 1e3 * row.seconds.get(at).copied().unwrap_or_default());
            table.add_row([word.to_owned()].into_iter().chain(few.iter().map(milliseconds)));
        }
        for (index, (name, _)) in Counters::default().named().iter().enumerate() {
            let counts = few.iter().map(|row| row.counters.named()[index].1.to_string());
            table.add_row([name.replace('_', " ")].into_iter().chain(counts));
        }
        let _ = writeln!(text, "{table}\n");
    }
    text
}

impl OwnBaseline {
    /// A baseline of these measurements.
    pub fn new(method: &str, model: String, rows: Vec<OwnUpdate>) -> Self {
        Self { schema: gate::SCHEMA, method: method.to_owned(), model, rows }
    }

    /// Reads a baseline.
    ///
    /// # Errors
    /// [`BenchError::Read`]; [`BenchError::Malformed`] with the line where it is none.
    pub fn read(path: &Path) -> Result<Self, BenchError> {
        gate::read(path, |baseline: &Self| baseline.schema)
    }

    /// The file's text.
    pub fn to_json(&self) -> String {
        gate::to_json(self)
    }

    /// The verdicts on measurements of now, in words, and whether none regressed.
    pub fn judge(&self, now: &Self) -> (String, bool) {
        let mut text = String::from("against the baseline\n");
        let (mut counts, mut is_sound) = ([0; 4], true);
        let mut say = |name: &str, (verdict, why): (Verdict, String)| {
            let why = if why.is_empty() { why } else { format!(": {why}") };
            let _ = writeln!(text, "  {verdict:<12} {name}{why}");
            counts[verdict as usize] += 1;
            is_sound &= verdict != Verdict::Regressed;
        };
        for (index, row) in now.rows.iter().enumerate() {
            say(&row.correction.name, self.judge_row(now, index, row));
        }
        for row in self.rows.iter().skip(now.rows.len()) {
            say(&row.correction.name, (Verdict::Incomparable, "not measured".to_owned()));
        }
        let all = [Verdict::Improved, Verdict::Regressed, Verdict::Unchanged, Verdict::Incomparable];
        let words = all.map(|verdict| format!("{verdict} {}", counts[verdict as usize]));
        (format!("{text}{}\n", words.join(", ")), is_sound)
    }

    fn judge_row(&self, now: &Self, index: usize, row: &OwnUpdate) -> (Verdict, String) {
        let incomparable = |why: &str| (Verdict::Incomparable, why.to_owned());
        if (&self.model, &self.method) != (&now.model, &now.method) {
            return incomparable("the baseline is of another model: --mint it anew");
        }
        let Some(before) = self.rows.get(index) else { return incomparable("not in the baseline") };
        let shown =
            |rows: &[OwnUpdate]| rows.iter().take(index + 1).map(|row| row.correction.clone()).collect::<Vec<_>>();
        if shown(&self.rows) != shown(&now.rows) {
            return incomparable("after other corrections than in the baseline");
        }
        if before.edit_made != row.edit_made {
            return incomparable(&format!("it made {}, now {}", before.edit_made, row.edit_made));
        }
        gate::verdict(gate::both(&before.counters, &row.counters))
    }
}
