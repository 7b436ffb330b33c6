//! T1: number and length of the demonstrations it takes to correct a task model, against teaching from scratch.

use situ::method::Role;

use super::column::{Columns, Shape, made, rate, share, spent};
use super::rows::{CellKey, Compared, compared, role, uncounted};
use super::table::{Publication, Table, Title};
use crate::ledger::Canonical;
use crate::record::{RunRecord, TotalEffort};

/// The publication.
pub(super) const T1: Publication = Publication {
    name: "t1",
    question: "What do corrections take, against teaching the changed task from scratch?",
    tables: |records| vec![table(records)],
};

const TITLE: Title = Title {
    id: "t1",
    text: "T1 effort: what corrections take, against teaching from scratch",
    note: "A row is a cell over its seeds. Runs of a method that cannot make the edit needed (not applicable), \
        untaught and spoilt runs are counted apart and enter nothing else. Success is pooled over the rollouts of all \
        seeds, with the Wilson 95 % interval. Demonstrations, keyframes, seconds and metres are what was spent until \
        the target success rate was first reached or the budget of demonstrations was used up (restricted mean, 95 % \
        bootstrap interval over seeds); ≥ marks a mean over runs some of which used the budget up. Ratios are to \
        teaching from scratch, paired by seed; ≥, ≤ and ~ mark censored corrections, censored teaching from scratch, \
        and both.",
};

/// The method that others are compared with, and whose demonstrations are whole ones.
const FROM_SCRATCH: &str = "from_scratch";

type Measure = (&'static str, fn(&TotalEffort) -> f64, usize);

const MEASURES: [Measure; 4] = [
    ("demonstrations", |effort| f64::from(effort.demonstrations), 1),
    ("keyframes", |effort| f64::from(effort.keyframes), 1),
    ("seconds", |effort| effort.seconds, 1),
    ("metres", |effort| effort.metres, 2),
];

/// The measures whose ratio to teaching from scratch is shown: number and length, the paper's own.
const RATIOS: [(&str, usize); 2] = [("demonstrations_ratio", 0), ("keyframes_ratio", 1)];

type Row<'a> = Compared<'a, CellKey<'a>>;

fn columns<'a>() -> Columns<'a, Row<'a>> {
    let columns = Columns::<Row<'a>>::new()
        .text("protocol", |row| row.row.key.protocol)
        .text("task", |row| row.row.key.task)
        .text("variation", |row| row.row.key.variation)
        .text("edit_needed", |row| row.row.key.edit.name())
        .text("teacher", |row| row.row.key.teacher)
        .text("method", |row| row.row.key.method.name)
        .count("seeds", |row| row.row.of.len());
    let columns = uncounted(columns)
        .column("before", Shape::Rate, |row| rate(row.counted.iter().filter_map(|run| run.before)))
        .column("after", Shape::Rate, |row| rate(row.counted.iter().filter_map(|run| run.after)))
        .column("reached", Shape::Rate, |row| share(row.counted.iter().map(|run| run.is_reached())));
    let columns = MEASURES.into_iter().fold(columns, |columns, (name, measure, digits)| {
        columns.column(name, Shape::Estimate(digits), move |row| {
            let of = row.counted.iter().map(|run| (measure(&run.effort), !run.is_reached()));
            spent(of, row.row.seed(name))
        })
    });
    let columns = RATIOS.into_iter().fold(columns, |columns, (name, measure)| {
        columns.column(name, Shape::Estimate(2), move |row| row.ratio(|run| MEASURES[measure].1(&run.effort), name))
    });
    columns
        .text("made_first", |row| made(row.counted.iter().filter_map(|run| run.edits_made().next())))
        .text("made_in_all", |row| made(row.counted.iter().flat_map(|run| run.edits_made())))
}

fn table(records: &Canonical) -> Table {
    let label = |key: &CellKey<'_>| {
        let CellKey { protocol, task, variation, edit, teacher, method, .. } = key;
        format!("t1/{protocol}/{task}/{variation}/{edit}/{teacher}/{method}")
    };
    let is_corrected = |run: &RunRecord| role(&run.key.method) == Role::Correct;
    let rows = compared(records, CellKey::from, label, FROM_SCRATCH, is_corrected);
    Table::new(TITLE, columns(), &rows, rows.iter().map(|row| (row.row.key.protocol, row.row.of.len())))
}
