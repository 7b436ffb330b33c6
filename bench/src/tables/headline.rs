//! The table that comes first: every method, over all changes that need an edit.

use situ::edit::Edit;
use situ::method::Role;

use super::column::{Cell, Columns, MILLISECONDS_PER_SECOND, Shape};
use super::measure::{EFFORT, effort, mean, median, of_runs, success, units, variations};
use super::rows::{self, TeacherKey, role, rows, teacher_key};
use super::table::{NO_FIGURES, Publication, Table, Title};
use crate::ledger::Canonical;
use crate::record::{Outcome, Record, RunRecord};

/// The publication.
pub(super) const HEADLINE: Publication = Publication {
    name: "headline",
    question: "What does each method reach, and what is kept of the original task?",
    tables: |records| vec![table(records)],
    figures: NO_FIGURES,
};

const TITLE: Title = Title {
    id: "headline",
    text: "What each method reaches, and what it keeps",
    note: "A row is a method over all changes that need an edit. `changed` is success on the changed task after the \
        last demonstration, `original` success on the original task after it, both from fresh starts: no rollout from \
        them has decided anything. `original before` is success on the original task before the first correction, from \
        the same starts. Demonstrations: those that the robot was given, the budget where the target was not reached \
        by the rollouts that decided; ≥ marks a mean with such runs, whose keyframes are those of the tries so far. \
        `originals` are the keyframes that taught the original task, which a correction builds on, charged apart. \
        Untaught and spoilt runs are counted apart; a run whose teacher gave up counts its budget. A control is taught \
        nothing and has no effort. Two 95 % bootstrap intervals each: by units (family × seed) and by variations. The \
        clock: the median over runs of the mean time of an update; other runs went on beside it.",
};

type Row<'a> = rows::Row<TeacherKey<'a>, &'a RunRecord>;

fn columns<'a>() -> Columns<'a, Row<'a>> {
    let runs = |row: &Row<'a>| row.of.clone().into_iter().filter(|run| run.outcome.counts());
    let outcomes = |row: &Row, is: fn(&Outcome) -> bool| row.of.iter().filter(|run| is(&run.outcome)).count();
    let is_control = |row: &Row| role(row.key.2.name) == Role::Control;
    let (_, demonstrations, digits) = EFFORT[0];
    let (_, keyframes, _) = EFFORT[2];
    Columns::<Row<'a>>::new()
        .text("protocol", |row| row.key.0)
        .text("teacher", |row| row.key.1)
        .text("method", |row| row.key.2.name)
        .count("runs", move |row| runs(row).count())
        .count("units", move |row| units(runs(row)))
        .count("variations", move |row| variations(runs(row)))
        .count("untaught", move |row| outcomes(row, |outcome| matches!(outcome, Outcome::Untaught { .. })))
        .count("spoilt", move |row| outcomes(row, |outcome| matches!(outcome, Outcome::Spoilt { .. })))
        .count("gave_up", move |row| outcomes(row, |outcome| matches!(outcome, Outcome::GaveUp { .. })))
        .count("broken_off", move |row| outcomes(row, Outcome::is_failure))
        .column("changed", Shape::Pooled(2), move |row| success(runs(row), |run| run.after))
        .column("original_before", Shape::Pooled(2), move |row| {
            if role(row.key.2.name) == Role::FromScratch {
                return Cell::Nothing;
            }
            success(runs(row), |run| run.original_rate)
        })
        .column("original", Shape::Pooled(2), move |row| success(runs(row), |run| run.retained))
        .column("demonstrations", Shape::Pooled(digits), move |row| {
            if is_control(row) { Cell::Nothing } else { effort(runs(row), demonstrations) }
        })
        .column("keyframes", Shape::Pooled(1), move |row| {
            if is_control(row) { Cell::Nothing } else { effort(runs(row), keyframes) }
        })
        .column("originals", Shape::Pooled(1), move |row| {
            // Teaching from scratch builds on no original.
            let is_anew = role(row.key.2.name) == Role::FromScratch;
            mean(runs(row), |run| (!is_anew).then(|| f64::from(run.original.keyframes)))
        })
        .wall("update_ms", Shape::Pooled(2), move |row| {
            let times = of_runs(runs(row), |run| Some(MILLISECONDS_PER_SECOND * run.update_seconds()?));
            median(&times)
        })
}

fn table(records: &Canonical) -> Table {
    let runs = records.iter().filter_map(Record::single_run);
    let wanted = runs.filter(|run| run.key.edit != Edit::None && run.outcome != Outcome::NotApplicable);
    let rows: Vec<Row> = rows(wanted.map(|run| (teacher_key(run), run)));
    Table::new(TITLE, columns(), &rows, rows.iter().map(|row| (row.key.0, row.of.len())))
}
