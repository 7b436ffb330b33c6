//! The paper's two questions, one table each: to correct against to teach from scratch, and successive corrections
//! against all demonstrations at once.

use std::collections::BTreeMap;

use situ::method::Role;

use super::column::{Cell, Columns, Shape};
use super::group::Group;
use super::measure::{EFFORT, Measure, difference, effort_ratio, share, units, variations};
use super::rows::{self, MethodName, place, role, rows};
use super::table::{self, NO_FIGURES, Publication, Table, Title};
use crate::ledger::Canonical;
use crate::record::{Pooled, Record, RunRecord};
use crate::tally::Rate;

/// The publication.
pub(super) const QUESTIONS: Publication = Publication {
    name: "questions",
    question: "The paper's two: to correct or to teach from scratch, and separate or joint?",
    tables: |records| vec![scratch(records), joint(records)],
    figures: NO_FIGURES,
};

const FROM_SCRATCH: Title = Title {
    id: "correct_or_scratch",
    text: "To correct, or to teach from scratch",
    note: "Ratios of what corrections took to what teaching from scratch took, sums over runs that are paired by cell \
        and seed. A demonstration is one that the robot was given, a try one that the teacher performed; lengths are \
        over all tries. A run that did not reach the target, by the rollouts that decided, counts the budget of \
        demonstrations; ≥, ≤ and ~ mark such corrections, such teaching from scratch, and both. `success` is the \
        difference of the success rates from fresh starts, corrected less from scratch. Two 95 % bootstrap intervals \
        each: by units (family × seed) and by variations. The originals that a correction builds on are charged to \
        neither; they are in T1. Shown: what is observed tells the changed task from the original one wherever another \
        decision has to be made, by the list tasks/shown.",
};

const SEPARATE: Title = Title {
    id: "separate_or_joint",
    text: "Separate, or joint",
    note: "The model that successive corrections led to, less what `rebuild:no_modify` makes of the same \
        demonstrations at once, in success rates from fresh starts: on the changed task and on the original one. Two \
        95 % bootstrap intervals each: by units (family × seed) and by variations. A joint model keeps a changed way \
        of doing a thing as a primitive of its own.",
};

/// Protocol, teacher, method and group.
type Key<'a> = (&'a str, &'a str, MethodName<'a>, Group);

/// A run, and the run that it is compared with.
type Row<'a> = rows::Row<Key<'a>, (&'a RunRecord, &'a RunRecord)>;

fn keys(run: &RunRecord) -> impl Iterator<Item = Key<'_>> {
    Group::of(run).map(|group| (&*run.key.protocol, &*run.key.teacher, MethodName::of(&run.key.method), group))
}

/// A column for each part of the key, and for how much there is.
fn key_columns<'a>() -> Columns<'a, Row<'a>> {
    Columns::<Row<'a>>::new()
        .text("protocol", |row| row.key.0)
        .text("teacher", |row| row.key.1)
        .text("method", |row| row.key.2.name)
        .text("edit_needed", |row| row.key.3.name())
        .count("runs", |row| row.of.len())
        .count("units", |row| units(row.of.iter().map(|pair| pair.0)))
        .count("variations", |row| variations(row.of.iter().map(|pair| pair.0)))
}

/// The method of which a sentence is said, and the groups.
const SAID: (&str, [Group; 4]) =
    ("situ", [Group::All, Group::ButSelfLoops, Group::ModificationShown, Group::ModificationNotShown]);

/// The rows of which a sentence is said, and how each begins.
fn said<'r, 'a>(rows: &'r [Row<'a>]) -> impl Iterator<Item = (&'r Row<'a>, String)> {
    let is_said = |row: &&Row| row.key.2.name == SAID.0 && SAID.1.contains(&row.key.3);
    rows.iter().filter(is_said).map(|row| {
        let (runs, first) = (row.of.len(), || row.of.iter().map(|pair| pair.0));
        let beginning = format!(
            "`{}`, {}, {} ({runs} runs, {} units, {} variations)",
            row.key.2,
            row.key.1,
            if row.key.3 == Group::All { "every edit" } else { row.key.3.name() },
            units(first()),
            variations(first()),
        );
        (row, beginning)
    })
}

/// A pooled cell in words.
fn words(cell: Cell, digits: usize) -> String {
    table::markdown(Shape::Pooled(digits), &cell)
}

fn ratio(row: &Row, (_, measure, _): Measure) -> Cell {
    effort_ratio(&row.of, measure)
}

/// The difference of the success rates, corrected less from scratch.
fn gain(row: &Row) -> Cell {
    difference(row.of.iter().map(|(own, other)| (*own, share(own.after), share(other.after))))
}

/// The difference of a success rate, separate less joint.
fn separate_gain(row: &Row, own: fn(&RunRecord) -> Option<Rate>, joint: fn(&Pooled) -> Rate) -> Cell {
    let joint = |run: &RunRecord| share(run.pooled.as_ref().map(joint));
    difference(row.of.iter().map(|(run, _)| (*run, share(own(run)), joint(run))))
}

fn scratch(records: &Canonical) -> Table {
    let runs = || records.iter().filter_map(Record::single_run).filter(|run| run.outcome.counts());
    let anew = runs().filter(|run| run.key.method == "from_scratch");
    let anew: BTreeMap<_, &RunRecord> = anew.map(|run| (place(run), run)).collect();
    let corrected = runs().filter(|run| role(&run.key.method) == Role::Correct);
    let pairs = corrected.filter_map(|run| Some((run, *anew.get(&place(run))?)));
    let rows: Vec<Row> = rows(pairs.flat_map(|pair| keys(pair.0).map(move |key| (key, pair))));
    let columns = EFFORT.into_iter().fold(key_columns(), |columns, measure| {
        columns.column(measure.0, Shape::Pooled(2), move |row: &Row| ratio(row, measure))
    });
    let columns = columns.column("success", Shape::Pooled(2), gain);
    let source = rows.iter().map(|row| (row.key.0, if row.key.3 == Group::All { row.of.len() } else { 0 }));
    let sentences = said(&rows).map(|(row, beginning)| {
        format!(
            "{beginning}: corrections took {} times as many demonstrations and {} times as many keyframes as teaching \
             from scratch, with a success rate that differs by {}.",
            words(ratio(row, EFFORT[0]), 2),
            words(ratio(row, EFFORT[2]), 2),
            words(gain(row), 2),
        )
    });
    let sentences = sentences.collect();
    Table::new(FROM_SCRATCH, columns, &rows, source).saying(sentences)
}

fn joint(records: &Canonical) -> Table {
    let runs = records.iter().filter_map(Record::single_run);
    let runs = runs.filter(|run| run.outcome.counts() && run.pooled.is_some());
    let rows: Vec<Row> = rows(runs.flat_map(|run| keys(run).map(move |key| (key, (run, run)))));
    let success = |row: &Row| separate_gain(row, |run| run.after, |joint| joint.pooled);
    let original = |row: &Row| separate_gain(row, |run| run.retained, |joint| joint.retained);
    let columns =
        key_columns().column("success", Shape::Pooled(2), success).column("original", Shape::Pooled(2), original);
    let source = rows.iter().map(|row| (row.key.0, if row.key.3 == Group::All { row.of.len() } else { 0 }));
    let sentences = said(&rows).map(|(row, beginning)| {
        format!(
            "{beginning}: separate less joint is {} in success on the changed task and {} on the original one.",
            words(success(row), 2),
            words(original(row), 2),
        )
    });
    let sentences = sentences.collect();
    Table::new(SEPARATE, columns, &rows, source).saying(sentences)
}
