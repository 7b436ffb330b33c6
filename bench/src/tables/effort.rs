//! T1: number and length of the demonstrations it takes to correct a task model, against teaching from scratch.

use situ::method::Role;

use super::column::{Cell, Columns, Shape, made, share};
use super::measure::{EFFORT, effort, mean, once, success};
use super::rows::{CellKey, Compared, compared, role, uncounted};
use super::table::{NO_FIGURES, Publication, Table, Title};
use crate::ledger::Canonical;
use crate::record::RunRecord;

/// The publication.
pub(super) const T1: Publication = Publication {
    name: "t1",
    question: "What do corrections take, against teaching the changed task from scratch?",
    tables: |records| vec![table(records)],
    figures: NO_FIGURES,
};

const TITLE: Title = Title {
    id: "t1",
    text: "T1 effort: what corrections take, against teaching from scratch",
    note: "A row is a cell over its seeds. Runs of a method that cannot make the edit needed (not applicable), \
        untaught and spoilt runs are counted apart and enter nothing else. `before`, `after`, and `once` (at some time \
        in the rollout) are success from fresh starts, by which nothing was decided; whether a run reached the target, \
        and so what it took, is by the rollouts that did decide. A demonstration is one that the robot was given, a \
        try one that the teacher performed; lengths are over all tries. A run that did not reach the target, or whose \
        teacher gave up, counts the budget of demonstrations; ≥ marks a mean with such runs; tries and lengths of such \
        a run are what was spent. Ratios are to teaching from scratch, paired by seed; ≥, ≤ and ~ mark corrections \
        that did not reach the target, such teaching from scratch, and both. Means with 95 % bootstrap intervals over \
        seeds, from two seeds on; `reached` with the Wilson 95 % interval. `originals` is the number of demonstrations \
        of the original task that a correction builds on, charged apart. A control is taught nothing and has no \
        effort.",
};

/// The method that others are compared with, and whose demonstrations are whole ones.
const FROM_SCRATCH: &str = "from_scratch";

/// The measures of [`EFFORT`] whose ratio to teaching from scratch is shown: number and length, the paper's own.
const RATIOS: [(&str, usize); 2] = [("demonstrations_ratio", 0), ("keyframes_ratio", 2)];

type Row<'a> = Compared<'a, CellKey<'a>>;

fn columns<'a>() -> Columns<'a, Row<'a>> {
    let columns = Columns::<Row<'a>>::new()
        .text("protocol", |row| row.row.key.protocol)
        .text("task", |row| row.row.key.task)
        .text("variation", |row| row.row.key.variation)
        .text("edit_needed", |row| row.row.key.edit.name())
        .text("teacher", |row| row.row.key.teacher)
        .text("method", |row| row.row.key.method.name)
        .count("seeds", |row| row.counted.len());
    let columns = uncounted(columns)
        .column("before", Shape::Pooled(2), |row| success(row.runs(), |run| run.before))
        .column("after", Shape::Pooled(2), |row| success(row.runs(), |run| run.after))
        .column("once", Shape::Pooled(2), |row| once(row.runs()))
        .column("reached", Shape::Rate, |row| share(row.counted.iter().map(|run| run.is_reached())));
    let columns = EFFORT.into_iter().fold(columns, |columns, (name, measure, digits)| {
        columns.column(name, Shape::Pooled(digits), move |row| {
            if role(row.row.key.method.name) == Role::Control {
                return Cell::Nothing;
            }
            effort(row.runs(), measure)
        })
    });
    let columns = RATIOS.into_iter().fold(columns, |columns, (name, measure)| {
        columns.column(name, Shape::Pooled(2), move |row| row.ratio(EFFORT[measure].1))
    });
    // Teaching from scratch builds on no original.
    let originals =
        |run: &RunRecord| (role(&run.key.method) != Role::FromScratch).then(|| f64::from(run.original.demonstrations));
    columns
        .column("originals", Shape::Pooled(1), move |row| mean(row.runs(), originals))
        .text("made_first", |row| made(row.runs().filter_map(|run| Some(run.first_to_show()?.edits()))))
        .text("made_in_all", |row| made(row.runs().map(RunRecord::edits).filter(|edits| !edits.is_empty())))
}

fn table(records: &Canonical) -> Table {
    let is_corrected = |run: &RunRecord| role(&run.key.method) == Role::Correct;
    let rows = compared(records, CellKey::from, FROM_SCRATCH, is_corrected);
    Table::new(TITLE, columns(), &rows, rows.iter().map(|row| (row.row.key.protocol, row.row.of.len())))
}
