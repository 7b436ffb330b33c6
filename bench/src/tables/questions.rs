//! The paper's two questions, one table each: to correct against to teach from scratch, and successive corrections
//! against all demonstrations at once.

use std::collections::{BTreeMap, BTreeSet};

use situ::method::Role;

use super::column::{Bound, Cell, Columns, Shape, some};
use super::group::Group;
use super::pooled::pooled;
use super::rows::{self, MethodName, role, rows};
use super::table::{Publication, Table, Title};
use crate::ledger::Canonical;
use crate::record::{Rate, Record, RunRecord};

/// The publication.
pub(super) const QUESTIONS: Publication = Publication {
    name: "questions",
    question: "The paper's two: to correct or to teach from scratch, and separate or joint?",
    tables: |records| vec![scratch(records), joint(records)],
};

const FROM_SCRATCH: Title = Title {
    id: "correct_or_scratch",
    text: "To correct, or to teach from scratch",
    note: "Ratios of what corrections took to what teaching from scratch took, sums over runs that are paired by cell \
        and seed. A demonstration is one that the robot was given, a try one that the teacher performed; lengths are \
        over all tries. A run that did not reach the target counts the budget of demonstrations; ≥, ≤ and ~ mark such \
        corrections, such teaching from scratch, and both. `success` is the difference of the success rates from fresh \
        starts, corrected less from scratch. Two 95 % bootstrap intervals each: by units (family × seed) and by \
        variations. The originals that a correction builds on are charged to neither; they are in T1.",
};

const SEPARATE: Title = Title {
    id: "separate_or_joint",
    text: "Separate, or joint",
    note: "The model that successive corrections led to, less what `rebuild:no_modify` makes of the same demonstrations \
        at once, in success rates from fresh starts: on the changed task and on the original one. Two 95 % bootstrap \
        intervals each: by units (family × seed) and by variations. A joint model keeps a changed way of doing a thing \
        as a primitive of its own.",
};

/// Protocol, teacher, method and group.
type Key<'a> = (&'a str, &'a str, MethodName<'a>, Group);

/// A run, and the run that it is compared with.
type Row<'a> = rows::Row<Key<'a>, (&'a RunRecord, &'a RunRecord)>;

fn keys(run: &RunRecord) -> impl Iterator<Item = Key<'_>> {
    Group::of(run).map(|group| (&*run.key.protocol, &*run.key.teacher, MethodName::of(&run.key.method), group))
}

fn label(table: &'static str) -> impl Fn(&Key<'_>) -> String {
    move |(protocol, teacher, method, group)| format!("{table}/{protocol}/{teacher}/{method}/{}", group.name())
}

/// A column for each part of the key, and for how much there is.
fn key_columns<'a>() -> Columns<'a, Row<'a>> {
    let count = |row: &Row<'a>, of: fn(&RunRecord) -> (&str, &str, u64)| {
        row.of.iter().map(|(run, _)| of(run)).collect::<BTreeSet<_>>().len()
    };
    Columns::<Row<'a>>::new()
        .text("protocol", |row| row.key.0)
        .text("teacher", |row| row.key.1)
        .text("method", |row| row.key.2.name)
        .text("edit_needed", |row| row.key.3.name())
        .count("runs", |row| row.of.len())
        .count("units", move |row| count(row, |run| (&run.key.task, "", run.key.seed)))
        .count("variations", move |row| count(row, |run| (&run.key.task, &run.key.variation, 0)))
}

/// What is counted of a run.
type Measure = (&'static str, fn(&RunRecord) -> f64);

const MEASURES: [Measure; 5] = [
    ("demonstrations", |run| f64::from(if run.is_reached() { run.effort.demonstrations } else { run.budget })),
    ("tries", |run| f64::from(run.effort.tries)),
    ("keyframes", |run| f64::from(run.effort.keyframes)),
    ("seconds", |run| run.effort.seconds),
    ("metres", |run| run.effort.metres),
];

/// A pooled ratio of sums as a cell.
fn cell(of: &[(&RunRecord, (f64, f64))], bound: Bound, seed: u64) -> Cell {
    some(pooled(of, seed), |pooled| Cell::Pooled(pooled, bound))
}

fn share(rate: Option<Rate>) -> Option<f64> {
    rate.filter(|rate| rate.rollouts > 0).map(|rate| f64::from(rate.successes) / f64::from(rate.rollouts))
}

/// The mean of a difference over the runs that have one.
fn difference<'a>(of: impl Iterator<Item = (&'a RunRecord, Option<f64>, Option<f64>)>, seed: u64) -> Cell {
    let of: Vec<_> = of.filter_map(|(run, own, other)| Some((run, (own? - other?, 1.0)))).collect();
    cell(&of, Bound::Exact, seed)
}

fn scratch(records: &Canonical) -> Table {
    let runs = || records.iter().filter_map(Record::single_run).filter(|run| run.outcome.counts());
    let place =
        |run: &'_ RunRecord| (run.key.task.clone(), run.key.variation.clone(), run.key.teacher.clone(), run.key.seed);
    let anew = runs().filter(|run| run.key.method == "from_scratch");
    let anew: BTreeMap<_, &RunRecord> = anew.map(|run| ((run.key.protocol.clone(), place(run)), run)).collect();
    let corrected = runs().filter(|run| role(&run.key.method) == Role::Correct);
    let pairs = corrected.filter_map(|run| Some((run, *anew.get(&(run.key.protocol.clone(), place(run)))?)));
    let rows: Vec<Row> = rows(pairs.flat_map(|pair| keys(pair.0).map(move |key| (key, pair))), label("q1"));
    let columns = MEASURES.into_iter().fold(key_columns(), |columns, (name, measure)| {
        columns.column(name, Shape::Pooled(2), move |row: &Row| {
            let of: Vec<_> = row.of.iter().map(|(own, other)| (*own, (measure(own), measure(other)))).collect();
            let reached = |of: fn(&(&RunRecord, &RunRecord)) -> bool| row.of.iter().all(of);
            let bound = Bound::of(reached(|pair| pair.0.is_reached()), reached(|pair| pair.1.is_reached()));
            cell(&of, bound, row.seed(name))
        })
    });
    let columns = columns.column("success", Shape::Pooled(2), |row: &Row| {
        difference(row.of.iter().map(|(own, other)| (*own, share(own.after), share(other.after))), row.seed("success"))
    });
    let source = rows.iter().map(|row| (row.key.0, if row.key.3 == Group::All { row.of.len() } else { 0 }));
    Table::new(FROM_SCRATCH, columns, &rows, source)
}

fn joint(records: &Canonical) -> Table {
    let runs = records.iter().filter_map(Record::single_run);
    let runs = runs.filter(|run| run.outcome.counts() && run.pooled.is_some());
    let rows: Vec<Row> = rows(runs.flat_map(|run| keys(run).map(move |key| (key, (run, run)))), label("q2"));
    let columns = key_columns()
        .column("success", Shape::Pooled(2), |row: &Row| {
            let joint = |run: &RunRecord| share(run.pooled.as_ref().map(|pooled| pooled.pooled));
            difference(row.of.iter().map(|(run, _)| (*run, share(run.after), joint(run))), row.seed("success"))
        })
        .column("original", Shape::Pooled(2), |row: &Row| {
            let joint = |run: &RunRecord| share(run.pooled.as_ref().map(|pooled| pooled.retained));
            difference(row.of.iter().map(|(run, _)| (*run, share(run.retained), joint(run))), row.seed("original"))
        });
    let source = rows.iter().map(|row| (row.key.0, if row.key.3 == Group::All { row.of.len() } else { 0 }));
    Table::new(SEPARATE, columns, &rows, source)
}
