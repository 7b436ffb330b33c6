//! Rows before they are written: records that share a key.

use std::collections::BTreeMap;
use std::fmt;

use situ::edit::Edit;
use situ::method::{self, Role};

use super::column::{Cell, Columns};
use super::measure::effort_ratio;
use crate::ledger::Canonical;
use crate::record::{Outcome, Record, RunRecord, Stage};

/// A method, in the order in which methods are listed; methods that are not listed follow by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct MethodName<'a> {
    rank: usize,
    pub(super) name: &'a str,
}

impl<'a> MethodName<'a> {
    pub(super) fn of(name: &'a str) -> Self {
        let methods = method::all();
        Self { rank: methods.iter().position(|method| method.name() == name).unwrap_or(methods.len()), name }
    }
}

impl fmt::Display for MethodName<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.name)
    }
}

/// What a method does with a changed task. A method that is not listed takes corrections.
pub(super) fn role(name: &str) -> Role {
    method::all().iter().find(|method| method.name() == name).map_or(Role::Correct, |method| method.role())
}

/// A row before it is written.
pub(super) struct Row<K, T> {
    pub(super) key: K,
    /// The members of the row, in the order of the records; never empty.
    pub(super) of: Vec<T>,
}

/// The rows, in the order of their keys.
pub(super) fn rows<K: Ord, T>(items: impl IntoIterator<Item = (K, T)>) -> Vec<Row<K, T>> {
    let mut rows: BTreeMap<K, Vec<T>> = BTreeMap::new();
    for (key, item) in items {
        rows.entry(key).or_default().push(item);
    }
    rows.into_iter().map(|(key, of)| Row { key, of }).collect()
}

/// Protocol, method, and the edit that the variation needs.
pub(super) type MethodKey<'a> = (&'a str, MethodName<'a>, Edit);

pub(super) fn method_key(run: &RunRecord) -> MethodKey<'_> {
    (&run.key.protocol, MethodName::of(&run.key.method), run.key.edit)
}

/// A column for each part of the key.
pub(super) fn method_columns<'a, R: 'a>(key: fn(&R) -> MethodKey<'a>) -> Columns<'a, R> {
    Columns::new()
        .text("protocol", move |row| key(row).0)
        .text("method", move |row| key(row).1.name)
        .text("edit_needed", move |row| key(row).2.name())
}

/// Protocol, teacher and method.
pub(super) type TeacherKey<'a> = (&'a str, &'a str, MethodName<'a>);

pub(super) fn teacher_key(run: &RunRecord) -> TeacherKey<'_> {
    (&run.key.protocol, &run.key.teacher, MethodName::of(&run.key.method))
}

/// A cell of the protocol, or a stage of a sequence; those that stand alone come first.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct CellKey<'a> {
    pub(super) protocol: &'a str,
    pub(super) task: &'a str,
    pub(super) stage: Option<&'a Stage>,
    pub(super) variation: &'a str,
    pub(super) edit: Edit,
    pub(super) teacher: &'a str,
    pub(super) method: MethodName<'a>,
}

impl<'a> From<&'a RunRecord> for CellKey<'a> {
    fn from(run: &'a RunRecord) -> Self {
        let key = &run.key;
        Self {
            protocol: &key.protocol,
            task: &key.task,
            stage: key.stage.as_ref(),
            variation: &key.variation,
            edit: key.edit,
            teacher: &key.teacher,
            method: MethodName::of(&key.method),
        }
    }
}

/// The cell of a run but for the method, and its seed: what runs of two methods are paired by.
pub(super) fn place(run: &RunRecord) -> (&str, &str, &str, &str, u64) {
    let key = &run.key;
    (&key.protocol, &key.task, &key.variation, &key.teacher, key.seed)
}

/// A row of runs that stand alone, beside the runs of another method.
pub(super) struct Compared<'a, K> {
    pub(super) row: Row<K, &'a RunRecord>,
    /// Those of the runs that say something about the method.
    pub(super) counted: Vec<&'a RunRecord>,
    /// Each of these and the other method's run in its place, where that says something too.
    pub(super) pairs: Vec<(&'a RunRecord, &'a RunRecord)>,
}

/// The rows of all runs that stand alone. The runs of `other` are the partners of those that have one.
pub(super) fn compared<'a, K: Ord>(
    records: &'a Canonical,
    key: fn(&'a RunRecord) -> K,
    other: &str,
    has_partner: fn(&RunRecord) -> bool,
) -> Vec<Compared<'a, K>> {
    let runs = || records.iter().filter_map(Record::single_run);
    let partners = runs().filter(|run| run.key.method == other && run.outcome.counts());
    let partners: BTreeMap<_, &RunRecord> = partners.map(|run| (place(run), run)).collect();
    let compared = |row: Row<K, &'a RunRecord>| {
        let counted: Vec<_> = row.of.iter().copied().filter(|run| run.outcome.counts()).collect();
        let pairs = counted.iter().filter(|run| has_partner(run));
        let pairs = pairs.filter_map(|run| Some((*run, *partners.get(&place(run))?))).collect();
        Compared { row, counted, pairs }
    };
    rows(runs().map(|run| (key(run), run))).into_iter().map(compared).collect()
}

impl<'a, K> Compared<'a, K> {
    fn outcomes(&self, is: fn(&Outcome) -> bool) -> usize {
        self.row.of.iter().filter(|run| is(&run.outcome)).count()
    }

    /// The ratio of a measure to that of the partners.
    pub(super) fn ratio(&self, measure: fn(&RunRecord) -> f64) -> Cell {
        effort_ratio(&self.pairs, measure)
    }

    /// The runs that say something about the method.
    pub(super) fn runs(&self) -> impl Iterator<Item = &'a RunRecord> {
        self.counted.iter().copied()
    }
}

/// And a column for each outcome that says nothing about the method, and for the runs whose teacher gave up.
pub(super) fn uncounted<'a, K>(columns: Columns<'a, Compared<'a, K>>) -> Columns<'a, Compared<'a, K>> {
    columns
        .count("not_applicable", |row| row.outcomes(|outcome| *outcome == Outcome::NotApplicable))
        .count("untaught", |row| row.outcomes(|outcome| matches!(outcome, Outcome::Untaught { .. })))
        .count("spoilt", |row| row.outcomes(|outcome| matches!(outcome, Outcome::Spoilt { .. })))
        .count("gave_up", |row| row.outcomes(|outcome| matches!(outcome, Outcome::GaveUp { .. })))
        .count("broken_off", |row| row.outcomes(Outcome::is_failure))
}
