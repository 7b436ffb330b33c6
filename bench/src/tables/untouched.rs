//! Families that decisions were made with, beside families that nothing was tuned on: first what is worse on these.

use situ::edit::Edit;
use situ::method::Role;

use super::column::{Bound, Cell, Columns, Shape};
use super::measure::{cell, of_runs, units};
use super::pooled::{OfRuns, Pooled, pooled_by, pooled_share};
use super::rows::{self, MethodName, role, rows};
use super::table::{NO_FIGURES, Publication, Table, Title};
use crate::correction_record::CorrectionRecord;
use crate::ledger::Canonical;
use crate::record::{Outcome, Record, RunRecord};
use crate::tally::Rate;
use crate::untouched::is_untouched;

/// The publication.
pub(super) const UNTOUCHED: Publication = Publication {
    name: "untouched",
    question: "What of it holds in families that nothing was tuned on?",
    tables: |records| vec![table(records)],
    figures: NO_FIGURES,
};

const TITLE: Title = Title {
    id: "untouched",
    text: "Old families beside untouched ones",
    note: "`old` are the families that decisions were made with, `new` those that were written after the decisions were \
        frozen. `changed` is success on the changed task and `original` on the original one after the last \
        demonstration, from fresh starts; `demonstrations` counts the budget where the target was not reached; `right` \
        is the share of first corrections showing the change whose edits are those that were needed. 95 % bootstrap \
        intervals by units (family × seed), drawn within each family. Worse is a difference whose interval is on the \
        wrong side of 0; it tells families apart as well as tuned from untuned.",
};

/// What is measured of a run: a sum, and how many it is of.
type Of = fn(&RunRecord) -> Option<(f64, f64)>;

/// A measure: its name, whether more of it is better, and what it is of a run.
#[derive(Clone, Copy)]
struct Measured {
    name: &'static str,
    more_is_better: bool,
    of: Of,
}

fn share(rate: Rate) -> (f64, f64) {
    (f64::from(rate.successes), f64::from(rate.rollouts))
}

fn once(holds: bool) -> (f64, f64) {
    (f64::from(u8::from(holds)), 1.0)
}

const MEASURES: [Measured; 5] = [
    Measured { name: "reached", more_is_better: true, of: |run| Some(once(run.is_reached())) },
    Measured { name: "changed", more_is_better: true, of: |run| run.after.map(share) },
    Measured { name: "original", more_is_better: true, of: |run| run.retained.map(share) },
    Measured {
        name: "demonstrations",
        more_is_better: false,
        of: |run| (role(&run.key.method) != Role::Control).then(|| (f64::from(run.charged()), 1.0)),
    },
    Measured {
        name: "right",
        more_is_better: true,
        of: |run| {
            let edits = run.first_to_show().map(CorrectionRecord::edits)?;
            (run.key.edit != Edit::None).then(|| once(edits.into_iter().eq([run.key.edit])))
        },
    },
];

/// Protocol, teacher, method, the edit that is needed, and the measure by its number.
type Key<'a> = (&'a str, &'a str, MethodName<'a>, Edit, usize);

type Row<'a> = rows::Row<Key<'a>, &'a RunRecord>;

fn measured<'a>(row: &Row<'a>) -> Vec<(&'a RunRecord, (f64, f64))> {
    of_runs(row.of.iter().copied(), MEASURES[row.key.4].of)
}

/// The runs of old or of new families.
fn side<'a>(row: &Row<'a>, new: bool) -> Vec<&'a RunRecord> {
    row.of.iter().copied().filter(|run| is_untouched(&run.key.task) == new).collect()
}

/// The measure over the runs of old or of new families.
fn over(row: &Row<'_>, new: bool) -> Option<Pooled> {
    let of: Vec<_> = measured(row).into_iter().filter(|(run, _)| is_untouched(&run.key.task) == new).collect();
    pooled_share(&of)
}

/// By how much it is more in the new families. `None` where there is nothing to compare.
fn difference(row: &Row<'_>) -> Option<Pooled> {
    let of: Vec<_> = measured(row).into_iter().map(|(run, pair)| (run, (is_untouched(&run.key.task), pair))).collect();
    let of: &OfRuns<'_, (bool, (f64, f64))> = &of;
    pooled_by(of, |things| {
        let mut sums = [(0.0, 0.0); 2];
        for (is_new, (above, below)) in things {
            let sum = &mut sums[usize::from(*is_new)];
            *sum = (sum.0 + above, sum.1 + below);
        }
        let [old, new] = sums;
        (old.1 > 0.0 && new.1 > 0.0).then(|| new.0 / new.1 - old.0 / old.1)
    })
}

/// How much worse the new families are, where that is beyond the interval.
fn worse(row: &Row<'_>) -> Option<f64> {
    let difference = difference(row)?;
    let (low, high) = difference.units?;
    let is_worse = if MEASURES[row.key.4].more_is_better { high < 0.0 } else { low > 0.0 };
    is_worse.then(|| difference.value.abs())
}

/// What is worse, the most first; a measure that counts is not held against one that is a share.
fn said(rows: &[Row<'_>]) -> Vec<String> {
    let mut found: Vec<(bool, f64, String)> = Vec::new();
    for row in rows {
        let (Some(by), (_, teacher, method, edit, measure)) = (worse(row), row.key) else { continue };
        let Measured { name, more_is_better, .. } = MEASURES[measure];
        let (Some(old), Some(new)) = (over(row, false), over(row, true)) else { continue };
        let sentence = format!(
            "Worse: `{name}` of `{}`, {teacher}, {}: {:.2}, and {:.2} before.",
            method.name,
            edit.name(),
            new.value,
            old.value
        );
        found.push((!more_is_better, -by, sentence));
    }
    found.sort_by(|one, other| one.0.cmp(&other.0).then(one.1.total_cmp(&other.1)));
    if found.is_empty() && !rows.is_empty() {
        return vec!["Nothing is worse beyond its interval.".to_owned()];
    }
    found.into_iter().map(|(_, _, sentence)| sentence).collect()
}

fn table(records: &Canonical) -> Table {
    let runs = records.iter().filter_map(Record::single_run);
    let counted: Vec<&RunRecord> =
        runs.filter(|run| run.outcome.counts() && run.outcome != Outcome::NotApplicable).collect();
    let has = |new: bool| counted.iter().any(|run| is_untouched(&run.key.task) == new);
    // Old or new alone have nothing to stand beside.
    let counted = if has(true) && has(false) { counted } else { Vec::new() };
    let measures = |run: &RunRecord| {
        (0..MEASURES.len()).filter(|measure| (MEASURES[*measure].of)(run).is_some()).collect::<Vec<_>>()
    };
    let placed = counted.into_iter().filter(|run| run.grade.is_none()).flat_map(|run| {
        let key =
            |measure| (&*run.key.protocol, &*run.key.teacher, MethodName::of(&run.key.method), run.key.edit, measure);
        measures(run).into_iter().map(move |measure| (key(measure), run))
    });
    let rows: Vec<Row> = rows(placed);
    let said = said(&rows);
    let columns = Columns::<Row>::new()
        .text("protocol", |row| row.key.0)
        .text("teacher", |row| row.key.1)
        .text("method", |row| row.key.2.name)
        .text("edit_needed", |row| row.key.3.name())
        .text("measure", |row| MEASURES[row.key.4].name)
        .count("old_units", |row| units(side(row, false)))
        .count("new_units", |row| units(side(row, true)))
        .column("old", Shape::Pooled(2), |row| by_units(over(row, false)))
        .column("new", Shape::Pooled(2), |row| by_units(over(row, true)))
        .column("new_less_old", Shape::Pooled(2), |row| by_units(difference(row)))
        .text("worse", |row| if worse(row).is_some() { Cell::Text("worse".to_owned()) } else { Cell::Nothing });
    let source = rows.iter().map(|row| (row.key.0, if row.key.4 == 0 { row.of.len() } else { 0 }));
    Table::new(TITLE, columns, &rows, source).saying(said)
}

/// The statistic with its interval by units alone: what varies between variations is what is compared.
fn by_units(pooled: Option<Pooled>) -> Cell {
    cell(pooled.map(|pooled| Pooled { variations: None, ..pooled }), Bound::Exact)
}
