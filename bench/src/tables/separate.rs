//! T2: the model built by successive corrections, against the pooled one, which is built from the same demonstrations
//! at once.

use situ::edit::Edit;
use situ::structure::Structure;

use super::cell::{mean, rate, seed};
use super::column::{Columns, Shape};
use super::method_name::{MethodName, Methods};
use super::publication::Publication;
use super::row::{self, rows};
use super::table::{Table, Title};
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
        is from starts by which no correction was called for; pooled over rollouts, with the Wilson 95 % interval. \
        `difference` is separate less joint, paired by run; it, nodes and F1 are means over runs with 95 % bootstrap \
        intervals. What F1 counts is in T3.",
};

/// The row of all tasks comes before those of each.
type Key<'a> = (&'a str, MethodName<'a>, Edit, Option<&'a str>);

type Row<'a> = row::Row<Key<'a>, (&'a RunRecord, &'a Pooled)>;

/// A measure of a structure: its name in the seeds of the bootstraps, the heads of its two columns, decimals, and the
/// measure.
type Measure = (&'static str, [&'static str; 2], usize, fn(&Structure) -> Option<f64>);

const MEASURES: [Measure; 3] = [
    ("nodes", ["nodes_separate", "nodes_joint"], 1, |structure| Some(f64::from(structure.nodes))),
    ("node_F1", ["node_F1_separate", "node_F1_joint"], 2, |structure| structure.pairs.f1()),
    ("edge_F1", ["edge_F1_separate", "edge_F1_joint"], 2, |structure| structure.transitions.f1()),
];

fn row_seed(row: &Row, quantity: &str) -> u64 {
    let (protocol, method, edit, task) = row.key;
    seed(&format!("t2/{protocol}/{}/{edit}/{task:?}", method.name), quantity)
}

fn columns<'a>() -> Columns<'a, Row<'a>> {
    let share = |rate: Rate| f64::from(rate.successes) / f64::from(rate.rollouts.max(1));
    let columns = Columns::<Row<'a>>::new()
        .text("protocol", |row| row.key.0)
        .text("method", |row| row.key.1.name)
        .text("edit_needed", |row| row.key.2.name())
        .text("task", |row| row.key.3.unwrap_or("all"))
        .count("runs", |row| row.of.len())
        .column("separate", Shape::Rate, |row| rate(row.of.iter().map(|(_, pooled)| pooled.separate)))
        .column("joint", Shape::Rate, |row| rate(row.of.iter().map(|(_, pooled)| pooled.pooled)))
        .column("difference", Shape::Estimate(2), move |row| {
            let differences = row.of.iter().map(|(_, pooled)| share(pooled.separate) - share(pooled.pooled));
            mean(&differences.collect::<Vec<_>>(), row_seed(row, "difference"))
        })
        .column("original_separate", Shape::Rate, |row| rate(row.of.iter().filter_map(|(run, _)| run.retained)))
        .column("original_joint", Shape::Rate, |row| rate(row.of.iter().map(|(_, pooled)| pooled.retained)));
    MEASURES.into_iter().fold(columns, |columns, (name, [separate, joint], digits, measure)| {
        columns
            .column(separate, Shape::Estimate(digits), move |row| {
                let scores: Vec<f64> = row.of.iter().filter_map(|(run, _)| measure(run.structure.as_ref()?)).collect();
                mean(&scores, row_seed(row, &format!("{name} separate")))
            })
            .column(joint, Shape::Estimate(digits), move |row| {
                let scores: Vec<f64> =
                    row.of.iter().filter_map(|(_, pooled)| measure(pooled.structure.as_ref()?)).collect();
                mean(&scores, row_seed(row, &format!("{name} joint")))
            })
    })
}

fn table(records: &Canonical) -> Table {
    let methods = Methods::listed();
    let runs = records.iter().filter_map(Record::single_run).filter(|run| run.outcome.counts());
    let compared = runs.filter_map(|run| Some((run, run.pooled.as_ref()?)));
    let rows: Vec<Row> = rows(compared.flat_map(|(run, pooled)| {
        let key = |task| (&*run.key.protocol, methods.name(&run.key.method), run.key.edit, task);
        [None, Some(&*run.key.task)].map(|task| (key(task), (run, pooled)))
    }));
    // A run is in two rows, and counts once.
    let source = rows.iter().map(|row| (row.key.0, if row.key.3.is_none() { row.of.len() } else { 0 }));
    Table::new(TITLE, columns(), &rows, source)
}
