//! T3: which edit was needed and which was made, the confusion matrix of each method with one row for each edit needed;
//! and how far the structure that it led to is what the teacher meant.

use situ::edit::Edit;
use situ::method::Role;
use situ::structure::Structure;

use super::column::{Columns, Shape, mean, share};
use super::rows::{self, MethodKey, method_columns, method_key, role, rows};
use super::table::{Publication, Table, Title};
use crate::ledger::Canonical;
use crate::record::{Record, RunRecord};

/// The publication.
pub(super) const T3: Publication = Publication {
    name: "t3",
    question: "Which edit did the task need, which did the method make, and is the structure what the teacher meant?",
    tables: |records| vec![table(records)],
};

const TITLE: Title = Title {
    id: "t3",
    text: "T3 edits: needed and made",
    note: "A row is a method and the edit that the variation needs, over all tasks, teachers and seeds whose run \
        counts. `first` counts the edit that the first correction of each run made, `all` that of every correction; \
        `right` is the share in which it was the edit needed, with the Wilson 95 % interval. Runs that reached the \
        target without a correction are counted apart. Teaching from scratch edits nothing and has no row. Node F1 is \
        over pairs of keyframes, which belong together where the teacher calls both the same; edge F1 is over \
        transitions from skill to skill; duplicates are nodes that hold a skill which another node holds as well. 1 is \
        beyond a method that cuts where the object changes and sees one skill where two cubes go into one bin: the \
        best of those is `oracle_edit`. Means over runs with 95 % bootstrap intervals.",
};

/// Protocol, method, and the edit that the variation needs.
type Row<'a> = rows::Row<MethodKey<'a>, &'a RunRecord>;

/// Columns of edits made, in the order of [`Edit::ALL`], and of the share that was right.
type Made = ([&'static str; 4], &'static str, fn(&RunRecord) -> Vec<Edit>);

const MADE: [Made; 2] = [
    (["first_node-addition", "first_edge-addition", "first_node-modification", "first_none"], "first_right", |run| {
        run.edits_made().take(1).collect()
    }),
    (["all_node-addition", "all_edge-addition", "all_node-modification", "all_none"], "all_right", |run| {
        run.edits_made().collect()
    }),
];

type Measure = (&'static str, fn(&Structure) -> Option<f64>);

const STRUCTURE: [Measure; 3] = [
    ("node_F1", |structure| structure.pairs.f1()),
    ("edge_F1", |structure| structure.transitions.f1()),
    ("duplicates", |structure| Some(f64::from(structure.duplicates))),
];

fn columns<'a>() -> Columns<'a, Row<'a>> {
    let columns = method_columns::<Row<'a>>(|row| row.key)
        .count("runs", |row| row.of.len())
        .count("uncorrected", |row| row.of.iter().filter(|run| run.corrections.is_empty()).count());
    let columns = MADE.into_iter().fold(columns, |columns, (names, right, made)| {
        let of = move |row: &Row| row.of.iter().flat_map(|run| made(run)).collect::<Vec<_>>();
        let counts = names.into_iter().zip(Edit::ALL).fold(columns, |columns, (name, edit)| {
            columns.count(name, move |row| of(row).into_iter().filter(|made| *made == edit).count())
        });
        counts.column(right, Shape::Rate, move |row| share(of(row).into_iter().map(|made| made == row.key.2)))
    });
    STRUCTURE.into_iter().fold(columns, |columns, (name, measure)| {
        columns.column(name, Shape::Estimate(2), move |row| {
            mean(row.of.iter().filter_map(|run| measure(run.structure.as_ref()?)), row.seed(name))
        })
    })
}

fn table(records: &Canonical) -> Table {
    let runs = records.iter().filter_map(Record::single_run);
    let counted = runs.filter(|run| run.outcome.counts() && role(&run.key.method) != Role::FromScratch);
    let label = |(protocol, method, needed): &MethodKey<'_>| format!("t3/{protocol}/{method}/{needed}");
    let rows: Vec<Row> = rows(counted.map(|run| (method_key(run), run)), label);
    Table::new(TITLE, columns(), &rows, rows.iter().map(|row| (row.key.0, row.of.len())))
}
