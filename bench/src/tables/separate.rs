//! T2: the model built by successive corrections, against the pooled one, which is built from the same demonstrations
//! at once.

use situ::structure::Structure;

use super::column::{Columns, Shape, mean, rate};
use super::rows::{self, MethodKey, method_columns, method_key, rows};
use super::table::{Publication, Table, Title};
use crate::ledger::Canonical;
use crate::record::{Pooled, Rate, Record, RunRecord};

/// The publication.
pub(super) const T2: Publication = Publication {
    name: "t2",
    question: "Is a model built by successive corrections as good as one built from all demonstrations at once?",
    tables: |records| vec![table(records)],
};

const TITLE: Title = Title {
    id: "t2",
    text: "T2 separate or joint: successive corrections against all demonstrations at once",
    note: "A row is a method and the edit that the variation needs, over all tasks and then for each, of the runs that \
        were corrected at least once. `separate` is the model that the corrections led to; `joint` is what full \
        retraining (`rebuild`) makes of the same demonstrations, original and corrective. Success on the changed task \
        is from starts by which nothing was decided; pooled over rollouts, with the Wilson 95 % interval. \
        `difference` is separate less joint, paired by run; it, nodes and F1 are means over runs with 95 % bootstrap \
        intervals. What F1 counts is in T3.",
};

/// The row of all tasks comes before those of each.
type Key<'a> = (MethodKey<'a>, Option<&'a str>);

type Row<'a> = rows::Row<Key<'a>, (&'a RunRecord, &'a Pooled)>;

/// A measure of a structure: its name in the seeds of the bootstraps, the heads of its two columns, decimals, and the
/// measure.
type Measure = (&'static str, [&'static str; 2], usize, fn(&Structure) -> Option<f64>);

const MEASURES: [Measure; 3] = [
    ("nodes", ["nodes_separate", "nodes_joint"], 1, |structure| Some(f64::from(structure.nodes))),
    ("node_F1", ["node_F1_separate", "node_F1_joint"], 2, |structure| structure.pairs.f1()),
    ("edge_F1", ["edge_F1_separate", "edge_F1_joint"], 2, |structure| structure.transitions.f1()),
];

fn columns<'a>() -> Columns<'a, Row<'a>> {
    let share = |rate: Rate| f64::from(rate.successes) / f64::from(rate.rollouts.max(1));
    let columns = method_columns::<Row<'a>>(|row| row.key.0)
        .text("task", |row| row.key.1.unwrap_or("all"))
        .count("runs", |row| row.of.len())
        .column("separate", Shape::Rate, |row| rate(row.of.iter().filter_map(|(run, _)| run.after)))
        .column("joint", Shape::Rate, |row| rate(row.of.iter().map(|(_, pooled)| pooled.pooled)))
        .column("difference", Shape::Estimate(2), move |row| {
            let differences = row.of.iter().filter_map(|(run, pooled)| Some(share(run.after?) - share(pooled.pooled)));
            mean(differences, row.seed("difference"))
        })
        .column("original_separate", Shape::Rate, |row| rate(row.of.iter().filter_map(|(run, _)| run.retained)))
        .column("original_joint", Shape::Rate, |row| rate(row.of.iter().map(|(_, pooled)| pooled.retained)));
    MEASURES.into_iter().fold(columns, |columns, (name, [separate, joint], digits, measure)| {
        columns
            .column(separate, Shape::Estimate(digits), move |row| {
                let scores = row.of.iter().filter_map(|(run, _)| measure(run.structure.as_ref()?));
                mean(scores, row.seed(&format!("{name} separate")))
            })
            .column(joint, Shape::Estimate(digits), move |row| {
                let scores = row.of.iter().filter_map(|(_, pooled)| measure(pooled.structure.as_ref()?));
                mean(scores, row.seed(&format!("{name} joint")))
            })
    })
}

fn table(records: &Canonical) -> Table {
    let runs = records.iter().filter_map(Record::single_run).filter(|run| run.outcome.counts());
    let compared = runs.filter_map(|run| Some((run, run.pooled.as_ref()?)));
    let label = |((protocol, method, edit), task): &Key<'_>| format!("t2/{protocol}/{method}/{edit}/{task:?}");
    let places = compared
        .flat_map(|(run, pooled)| [None, Some(&*run.key.task)].map(|task| ((method_key(run), task), (run, pooled))));
    let rows: Vec<Row> = rows(places, label);
    // A run is in two rows, and counts once.
    let source = rows.iter().map(|row| (row.key.0.0, if row.key.1.is_none() { row.of.len() } else { 0 }));
    Table::new(TITLE, columns(), &rows, source)
}
