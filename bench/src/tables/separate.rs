//! T2: the model built by successive corrections, against the model built from the same demonstrations at once.

use std::collections::BTreeMap;

use situ::edit::Edit;
use situ::structure::Structure;

use super::{Cell, Column, MethodName, Methods, Shape, Table, column, mean, rate, seed};
use crate::record::{Joint, Rate, Record, Run};

const NOTE: &str = "A row is a method and the edit that the variation needs, over all tasks and then for each, of the runs that were corrected \
at least once. `separate` is the model that the corrections led to; `joint` is what full retraining (`rebuild`) makes of the same demonstrations, \
original and corrective. Success on the changed task is from starts by which no correction was called for; pooled over rollouts, with the Wilson \
95 % interval. `difference` is separate less joint, paired by run; it, nodes and F1 are means over runs with 95 % bootstrap intervals. What F1 \
counts is in T3.";

/// All tasks come before each.
type Row<'a> = (&'a str, MethodName, Edit, Option<&'a str>);

type Measure = (&'static str, fn(&Structure) -> Option<f64>);

fn columns() -> Vec<Column> {
    let text = ["protocol", "method", "edit_needed", "task"].map(|name| column(name, Shape::Text));
    let estimates = [
        ("nodes_separate", 1),
        ("nodes_joint", 1),
        ("node_F1_separate", 2),
        ("node_F1_joint", 2),
        ("edge_F1_separate", 2),
        ("edge_F1_joint", 2),
    ];
    text.into_iter()
        .chain([column("runs", Shape::Count)])
        .chain(["separate", "joint"].map(|name| column(name, Shape::Rate)))
        .chain([column("difference", Shape::Estimate(2))])
        .chain(["original_separate", "original_joint"].map(|name| column(name, Shape::Rate)))
        .chain(estimates.map(|(name, digits)| column(name, Shape::Estimate(digits))))
        .collect()
}

/// The table, from records in canonical order.
pub(super) fn table(records: &[Record]) -> Table {
    let methods = Methods::listed();
    let mut rows: BTreeMap<Row, Vec<(&Run, &Joint)>> = BTreeMap::new();
    for run in records.iter().filter_map(Record::single_run).filter(|run| run.outcome.counts()) {
        let Some(joint) = &run.joint else { continue };
        for task in [None, Some(&*run.key.task)] {
            let row = (&*run.key.protocol, methods.name(&run.key.method), run.key.edit, task);
            rows.entry(row).or_default().push((run, joint));
        }
    }
    Table {
        id: "t2",
        title: "T2 separate or joint: successive corrections against all demonstrations at once",
        note: NOTE,
        columns: columns(),
        rows: rows.iter().map(|(row, runs)| cells(row, runs)).collect(),
        protocols: rows.keys().map(|row| row.0.to_owned()).collect(),
        records: rows.iter().filter(|(row, _)| row.3.is_none()).map(|(_, runs)| runs.len()).sum(),
    }
}

fn cells((protocol, method, edit, task): &Row, runs: &[(&Run, &Joint)]) -> Vec<Cell> {
    let label = format!("t2/{protocol}/{}/{edit}/{task:?}", method.name);
    let mut cells =
        [*protocol, &method.name, edit.name(), task.unwrap_or("all")].map(|word| Cell::Text(word.to_owned())).to_vec();
    cells.push(Cell::Count(runs.len()));
    cells.push(rate(runs.iter().map(|(_, joint)| joint.separate)));
    cells.push(rate(runs.iter().map(|(_, joint)| joint.joint)));
    let share = |rate: Rate| f64::from(rate.successes) / f64::from(rate.rollouts.max(1));
    let differences: Vec<f64> = runs.iter().map(|(_, joint)| share(joint.separate) - share(joint.joint)).collect();
    cells.push(mean(&differences, seed(&label, "difference")));
    cells.push(rate(runs.iter().filter_map(|(run, _)| run.retained)));
    cells.push(rate(runs.iter().map(|(_, joint)| joint.retained)));
    let measures: [Measure; 3] = [
        ("nodes", |structure| Some(f64::from(structure.nodes))),
        ("node_F1", |structure| structure.pairs.f1()),
        ("edge_F1", |structure| structure.transitions.f1()),
    ];
    for (name, measure) in measures {
        let separate: Vec<f64> = runs.iter().filter_map(|(run, _)| measure(run.structure.as_ref()?)).collect();
        let joint: Vec<f64> = runs.iter().filter_map(|(_, joint)| measure(joint.structure.as_ref()?)).collect();
        cells.push(mean(&separate, seed(&label, &format!("{name} separate"))));
        cells.push(mean(&joint, seed(&label, &format!("{name} joint"))));
    }
    cells
}
