//! Every method beside every edit: success, demonstrations, and what an update costs against SITU's.

use std::collections::BTreeMap;

use situ::edit::Edit;

use super::{Bound, Cell, Column, MethodName, Methods, Shape, Table, column, median, rate, seed, share, wall};
use crate::record::{Key, Outcome, Record, Run};
use crate::stats;

/// The method that others are compared with.
const SITU: &str = "situ";

const NOTE: &str = "A row is a method and the edit that the variation needs, over all tasks, variations, teachers and seeds. Runs of a method that \
cannot make the edit (not applicable), untaught and spoilt runs are counted apart and enter nothing else. `reached` is the share of runs that \
reached the target within their budget, `after` success pooled over rollouts; Wilson 95 % intervals. Demonstrations are corrective, or full ones \
where a method is taught from scratch, until the target was reached or the budget used up (restricted mean, 95 % bootstrap interval over runs); ≥ \
marks a mean over runs some of which used it up. `to_situ` is the ratio of such means, paired by cell and seed; ≥, ≤ and ~ mark runs of the method, \
of situ and of both that used their budget up. The clock: the median over runs of the mean time of an update, and the median of its ratio to that of \
situ in the same cell with the same seed, where both were corrected; other runs went on beside it.";

type Row<'a> = (&'a str, MethodName, Edit);

/// A run but for its method.
type Partner<'a> = (&'a str, &'a str, &'a str, &'a str, u64);

fn partner(key: &Key) -> Partner<'_> {
    (&key.protocol, &key.task, &key.variation, &key.teacher, key.seed)
}

fn columns() -> Vec<Column> {
    let text = ["protocol", "method", "edit_needed"].map(|name| column(name, Shape::Text));
    let counts = ["cells", "runs", "not_applicable", "untaught", "spoilt"].map(|name| column(name, Shape::Count));
    text.into_iter()
        .chain(counts)
        .chain(["reached", "after"].map(|name| column(name, Shape::Rate)))
        .chain([column("demonstrations", Shape::Estimate(2)), column("demonstrations_to_situ", Shape::Estimate(2))])
        .chain([wall("update_ms", Shape::Estimate(2)), wall("update_to_situ", Shape::Estimate(1))])
        .collect()
}

/// The table, from records in canonical order.
pub(super) fn table(records: &[Record]) -> Table {
    let methods = Methods::listed();
    let mut rows: BTreeMap<Row, Vec<&Run>> = BTreeMap::new();
    let mut partners: BTreeMap<Partner, &Run> = BTreeMap::new();
    for run in records.iter().filter_map(Record::single_run) {
        let key = &run.key;
        rows.entry((&key.protocol, methods.name(&key.method), key.edit)).or_default().push(run);
        if key.method == SITU && run.outcome.counts() {
            partners.insert(partner(key), run);
        }
    }
    Table {
        id: "methods",
        title: "Methods: every method beside every edit",
        note: NOTE,
        columns: columns(),
        rows: rows.iter().map(|(row, runs)| cells(row, runs, &partners)).collect(),
        protocols: rows.keys().map(|row| row.0.to_owned()).collect(),
        records: rows.values().map(Vec::len).sum(),
    }
}

fn cells((protocol, method, edit): &Row, runs: &[&Run], partners: &BTreeMap<Partner, &Run>) -> Vec<Cell> {
    let label = format!("methods/{protocol}/{}/{edit}", method.name);
    let mut cells = [*protocol, &method.name, edit.name()].map(|word| Cell::Text(word.to_owned())).to_vec();
    let mut tasks: Vec<_> = runs.iter().map(|run| (&run.key.task, &run.key.variation, &run.key.teacher)).collect();
    tasks.sort_unstable();
    tasks.dedup();
    let outcomes = |is: fn(&Outcome) -> bool| Cell::Count(runs.iter().filter(|run| is(&run.outcome)).count());
    cells.push(Cell::Count(tasks.len()));
    cells.push(Cell::Count(runs.len()));
    cells.push(outcomes(|outcome| *outcome == Outcome::NotApplicable));
    cells.push(outcomes(|outcome| *outcome == Outcome::Untaught));
    cells.push(outcomes(|outcome| matches!(outcome, Outcome::Spoilt { .. })));
    let counted: Vec<&Run> = runs.iter().copied().filter(|run| run.outcome.counts()).collect();
    cells.push(share(counted.iter().map(|run| is_reached(run))));
    cells.push(rate(counted.iter().filter_map(|run| run.after)));
    let demonstrations = |run: &Run| f64::from(run.effort.demonstrations);
    let spent: Vec<(f64, bool)> = counted.iter().map(|run| (demonstrations(run), !is_reached(run))).collect();
    cells.push(match stats::restricted_mean(&spent, seed(&label, "demonstrations")) {
        None => Cell::Nothing,
        Some(mean) => Cell::Estimate(mean.estimate, Bound::of(mean.censored == 0, true)),
    });
    let beside: Vec<(&Run, &Run)> = if method.name == SITU {
        Vec::new()
    } else {
        counted.iter().filter_map(|run| Some((*run, *partners.get(&partner(&run.key))?))).collect()
    };
    let pairs: Vec<(f64, f64)> = beside.iter().map(|(run, situ)| (demonstrations(run), demonstrations(situ))).collect();
    let all = |part: fn(&(&Run, &Run)) -> bool| beside.iter().all(part);
    let bound = Bound::of(all(|(run, _)| is_reached(run)), all(|(_, situ)| is_reached(situ)));
    let ratio = stats::paired_ratio(&pairs, seed(&label, "ratio"));
    cells.push(ratio.map_or(Cell::Nothing, |ratio| Cell::Estimate(ratio, bound)));
    let milliseconds: Vec<f64> = counted.iter().filter_map(|run| Some(1e3 * update_seconds(run)?)).collect();
    cells.push(median(&milliseconds, seed(&label, "time")));
    let ratios: Vec<f64> =
        beside.iter().filter_map(|(run, situ)| Some(update_seconds(run)? / update_seconds(situ)?)).collect();
    let ratios: Vec<f64> = ratios.into_iter().filter(|ratio| ratio.is_finite()).collect();
    cells.push(median(&ratios, seed(&label, "time ratio")));
    cells
}

fn is_reached(run: &Run) -> bool {
    run.outcome == Outcome::Reached
}

/// The mean time of an update of a run; nothing of a run without one.
fn update_seconds(run: &Run) -> Option<f64> {
    stats::mean(&run.corrections.iter().map(|correction| correction.update_seconds).collect::<Vec<_>>())
}
