//! T5: what a corrected model still does: the original task, and the variations it met before.

use std::collections::BTreeMap;

use situ::edit::Edit;
use situ::method::Role;

use super::{Cell, Column, MethodName, Methods, Shape, Table, column, mean, rate, seed};
use crate::record::{Record, Run, Stage};

const NOTE: &str = "A row is a cell over its seeds, or a stage of a sequence, in which each variation is met with the model that the \
one before left. `before` and `after` are success on the variation, `original before` and `original after` on the original task, \
from the same starts; `earlier` is success on the variations of all earlier stages after this one. Pooled over rollouts, with the \
Wilson 95 % interval; demonstrations are means over seeds with a 95 % bootstrap interval, runs that used the budget up among them.";

/// A cell or a stage; those that stand alone come first.
type Row<'a> = (&'a str, &'a str, Option<&'a Stage>, &'a str, Edit, &'a str, MethodName);

fn columns() -> Vec<Column> {
    let text = ["protocol", "task", "sequence", "stage", "variation", "edit_needed", "teacher", "method"];
    let rates = ["before", "after", "original_before", "original_after", "earlier"];
    text.map(|name| column(name, Shape::Text))
        .into_iter()
        .chain([column("runs", Shape::Count)])
        .chain(rates.map(|name| column(name, Shape::Rate)))
        .chain([column("demonstrations", Shape::Estimate(1))])
        .collect()
}

/// The table, from records in canonical order.
pub(super) fn table(records: &[Record]) -> Table {
    let methods = Methods::listed();
    let mut rows: BTreeMap<Row, Vec<&Run>> = BTreeMap::new();
    for record in records {
        if let Record::Run(run) = record
            && run.outcome.counts()
            && run.retained.is_some()
            && methods.role(&run.key.method) != Role::FromScratch
        {
            let key = &run.key;
            let method = methods.name(&key.method);
            let row =
                (&*key.protocol, &*key.task, key.stage.as_ref(), &*key.variation, key.edit, &*key.teacher, method);
            rows.entry(row).or_default().push(run);
        }
    }
    let rendered = rows.iter().map(|((protocol, task, stage, variation, edit, teacher, method), runs)| {
        let text = |word: &str| Cell::Text(word.to_owned());
        let place = stage.map_or([Cell::Nothing, Cell::Nothing], |stage| {
            [Cell::Text(stage.sequence.clone()), Cell::Text(stage.number.to_string())]
        });
        let mut cells = vec![text(protocol), text(task)];
        cells.extend(place);
        cells.extend([variation, edit.name(), teacher, &method.name].map(text));
        cells.push(Cell::Count(runs.len()));
        cells.push(rate(runs.iter().filter_map(|run| run.before)));
        cells.push(rate(runs.iter().filter_map(|run| run.after)));
        cells.push(rate(runs.iter().filter_map(|run| run.original_rate)));
        cells.push(rate(runs.iter().filter_map(|run| run.retained)));
        cells.push(rate(runs.iter().flat_map(|run| run.earlier.values().copied())));
        let spent: Vec<f64> = runs.iter().map(|run| f64::from(run.effort.demonstrations)).collect();
        let label = format!("t5/{protocol}/{task}/{stage:?}/{variation}/{teacher}/{}", method.name);
        cells.push(mean(&spent, seed(&label, "demonstrations")));
        cells
    });
    Table {
        id: "t5",
        title: "T5 retention: what a corrected model still does",
        note: NOTE,
        columns: columns(),
        rows: rendered.collect(),
        protocols: rows.keys().map(|row| row.0.to_owned()).collect(),
        records: rows.values().map(Vec::len).sum(),
    }
}
