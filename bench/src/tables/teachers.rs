//! T6: what it takes, and what comes of it, by the teacher.

use situ::method::Role;

use super::column::{Bound, Cell, Columns, Shape};
use super::measure::{EFFORT, cell, effort, mean, of_runs, share_of, success, units, variations};
use super::pooled::pooled_ratio;
use super::rows::{self, TeacherKey, role, rows, teacher_key};
use super::table::{NO_FIGURES, Publication, Table, Title};
use crate::ledger::Canonical;
use crate::record::{Outcome, Record, RunRecord};
use crate::tally::TotalEffort;

/// The publication.
pub(super) const T6: Publication = Publication {
    name: "t6",
    question: "What does it take, and what comes of it, by the teacher?",
    tables: |records| vec![table(records)],
    figures: NO_FIGURES,
};

const TITLE: Title = Title {
    id: "t6",
    text: "T6 teachers: what it takes, and what comes of it, by the teacher",
    note: "A row is a method and a teacher over all changes that need an edit. Untaught runs (the original task was \
        never learned) are counted apart; runs in which the teacher gave up count their budget of demonstrations. \
        `changed` and `original` are success after the last demonstration, from fresh starts. A try is a demonstration \
        that the teacher performed, given or not; `failed` is the share of tries that were not given, of the original \
        task (but for teaching from scratch) and the changed one, untaught and spoilt runs among them. `foreseen` are \
        the grasps, for each try, that the teacher thought of and dropped because they would not hold: nobody saw \
        them. Tries and lengths of a run that did not reach the target are what was spent; a control is taught nothing \
        and has no effort. `primitives a skill` are the nodes of the last model over the skills that they hold, as the \
        teacher calls them. Two 95 % bootstrap intervals each: by units (family × seed) and by variations.",
};

type Row<'a> = rows::Row<TeacherKey<'a>, &'a RunRecord>;

/// The runs of a row that say something about the method.
fn counted<'a>(row: &Row<'a>) -> impl Iterator<Item = &'a RunRecord> {
    row.of.clone().into_iter().filter(|run| run.outcome.counts())
}

/// What was spent on the changed task and on the original one, on which teaching from scratch does not build.
fn spent(run: &RunRecord) -> TotalEffort {
    let mut spent = if role(&run.key.method) == Role::FromScratch { TotalEffort::default() } else { run.original };
    spent += run.effort;
    spent
}

fn columns<'a>() -> Columns<'a, Row<'a>> {
    let outcomes = |row: &Row, is: fn(&Outcome) -> bool| row.of.iter().filter(|run| is(&run.outcome)).count();
    let columns = Columns::<Row<'a>>::new()
        .text("protocol", |row| row.key.0)
        .text("method", |row| row.key.2.name)
        .text("teacher", |row| row.key.1)
        .count("runs", |row| counted(row).count())
        .count("units", |row| units(counted(row)))
        .count("variations", |row| variations(counted(row)))
        .count("untaught", move |row| outcomes(row, |outcome| matches!(outcome, Outcome::Untaught { .. })))
        .count("spoilt", move |row| outcomes(row, |outcome| matches!(outcome, Outcome::Spoilt { .. })))
        .count("gave_up", move |row| outcomes(row, |outcome| matches!(outcome, Outcome::GaveUp { .. })))
        .count("broken_off", move |row| outcomes(row, Outcome::is_failure))
        .column("changed", Shape::Pooled(2), |row| success(counted(row), |run| run.after))
        .column("original", Shape::Pooled(2), |row| success(counted(row), |run| run.retained));
    let columns = EFFORT.into_iter().fold(columns, |columns, (name, measure, digits)| {
        columns.column(name, Shape::Pooled(digits), move |row| {
            if role(row.key.2.name) == Role::Control {
                return Cell::Nothing;
            }
            effort(counted(row), measure)
        })
    });
    columns
        .column("failed", Shape::Pooled(2), |row| {
            let failed = |run: &RunRecord| {
                let TotalEffort { demonstrations, tries, .. } = spent(run);
                Some((f64::from(tries - demonstrations.min(tries)), f64::from(tries)))
            };
            share_of(&of_runs(row.of.iter().copied(), failed))
        })
        .column("foreseen", Shape::Pooled(2), |row| {
            let foreseen = |run: &RunRecord| Some((f64::from(spent(run).foreseen), f64::from(spent(run).tries)));
            let of = of_runs(row.of.iter().copied(), foreseen);
            // A teacher who takes everything as the script does has nothing to foresee.
            let is_any = of.iter().any(|(_, (dropped, _))| *dropped > 0.0);
            cell(pooled_ratio(&of).filter(|_| is_any), Bound::Exact)
        })
        .column("primitives_a_skill", Shape::Pooled(2), |row| {
            let ratio = |run: &RunRecord| {
                let structure = run.structure?;
                (structure.skills > 0).then(|| f64::from(structure.nodes) / f64::from(structure.skills))
            };
            mean(counted(row), ratio)
        })
}

fn table(records: &Canonical) -> Table {
    let runs = records.iter().filter_map(Record::single_run);
    let wanted = runs.filter(|run| run.key.edit != situ::edit::Edit::None && run.outcome != Outcome::NotApplicable);
    let mut rows: Vec<Row> = rows(wanted.map(|run| (teacher_key(run), run)));
    rows.sort_by_key(|row| (row.key.0, row.key.2, row.key.1));
    Table::new(TITLE, columns(), &rows, rows.iter().map(|row| (row.key.0, row.of.len())))
}
