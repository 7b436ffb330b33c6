//! T2: the model built by successive corrections, against the pooled one, which is built from the same demonstrations
//! at once.

use situ::structure::Structure;

use super::column::{Columns, Shape};
use super::measure::{difference, mean, median, of_runs, share, success, units};
use super::rows::{self, MethodKey, method_columns, method_key, rows};
use super::table::{NO_FIGURES, Publication, Table, Title};
use crate::ledger::Canonical;
use crate::record::{Pooled, Record, RunRecord};
use crate::tally::Rate;

/// The publication.
pub(super) const T2: Publication = Publication {
    name: "t2",
    question: "Is a model built by successive corrections as good as one built from all demonstrations at once?",
    tables: |records| vec![table(records)],
    figures: NO_FIGURES,
};

const TITLE: Title = Title {
    id: "t2",
    text: "T2 separate or joint: successive corrections against all demonstrations at once",
    note: "A row is a method and the edit that the variation needs, over all tasks and then for each, of the runs that \
        were corrected at least once, for the methods of which the protocol asks it. `separate` is the model that the \
        corrections led to; `joint` is what full retraining without order (`rebuild:no_modify`) makes of the same \
        demonstrations, original and corrective. Success is from starts by which nothing was decided. `difference` is \
        separate less joint, paired by run. What F1 counts is in T3; `likelihood` is of a demonstration of the changed \
        task that neither was given, nats per keyframe, the median over runs. Two 95 % bootstrap intervals each: by \
        units (family × seed) and by variations.",
};

/// The row of all tasks comes before those of each.
type Key<'a> = (MethodKey<'a>, Option<&'a str>);

type Row<'a> = rows::Row<Key<'a>, &'a RunRecord>;

/// A measure of a structure: the heads of its two columns, decimals, and the measure.
type Measure = ([&'static str; 2], usize, fn(&Structure) -> Option<f64>);

const MEASURES: [Measure; 3] = [
    (["nodes_separate", "nodes_joint"], 1, |structure| Some(f64::from(structure.nodes))),
    (["node_F1_separate", "node_F1_joint"], 2, |structure| structure.pairs.f1()),
    (["edge_F1_separate", "edge_F1_joint"], 2, |structure| structure.transitions.f1()),
];

fn columns<'a>() -> Columns<'a, Row<'a>> {
    let columns = method_columns::<Row<'a>>(|row| row.key.0)
        .text("task", |row| row.key.1.unwrap_or("all"))
        .count("runs", |row| row.of.len())
        .count("units", |row| units(row.of.iter().copied()))
        .column("separate", Shape::Pooled(2), |row| success(runs(row), |run| run.after))
        .column("joint", Shape::Pooled(2), |row| success(runs(row), |run| joint(run, |of| of.pooled)))
        .column("difference", Shape::Pooled(2), move |row| {
            let of = runs(row).map(|run| (run, share(run.after), share(joint(run, |of| of.pooled))));
            difference(of)
        })
        .column("original_separate", Shape::Pooled(2), |row| success(runs(row), |run| run.retained))
        .column("original_joint", Shape::Pooled(2), |row| success(runs(row), |run| joint(run, |of| of.retained)));
    let columns = MEASURES.into_iter().fold(columns, |columns, ([separate, joint], digits, measure)| {
        columns
            .column(separate, Shape::Pooled(digits), move |row| mean(runs(row), |run| measure(run.structure.as_ref()?)))
            .column(joint, Shape::Pooled(digits), move |row| {
                let of = |run: &RunRecord| measure(run.pooled.as_ref()?.structure.as_ref()?);
                mean(runs(row), of)
            })
    });
    columns
        .column("likelihood_separate", Shape::Pooled(1), |row| {
            let of = of_runs(runs(row), |run| run.held_out?.per_keyframe());
            median(&of)
        })
        .column("likelihood_joint", Shape::Pooled(1), |row| {
            let of = of_runs(runs(row), |run| run.pooled.as_ref()?.held_out?.per_keyframe());
            median(&of)
        })
}

fn runs<'a>(row: &Row<'a>) -> impl Iterator<Item = &'a RunRecord> {
    row.of.clone().into_iter()
}

/// A rate of the joint model.
fn joint(run: &RunRecord, rate: fn(&Pooled) -> Rate) -> Option<Rate> {
    run.pooled.as_ref().map(rate)
}

fn table(records: &Canonical) -> Table {
    let runs = records.iter().filter_map(Record::single_run).filter(|run| run.outcome.counts());
    let compared = runs.filter(|run| run.pooled.is_some());
    let places = compared.flat_map(|run| [None, Some(&*run.key.task)].map(|task| ((method_key(run), task), run)));
    let rows: Vec<Row> = rows(places);
    // A run is in two rows, and counts once.
    let source = rows.iter().map(|row| (row.key.0.0, if row.key.1.is_none() { row.of.len() } else { 0 }));
    Table::new(TITLE, columns(), &rows, source)
}
