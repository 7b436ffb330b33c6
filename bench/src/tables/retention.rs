//! T5: what a corrected model still does: the original task, and the variations it met before.

use situ::edit::Edit;
use situ::method::Role;

use super::cell::{Cell, mean, rate, seed, some};
use super::column::{Columns, Shape};
use super::method_name::{MethodName, Methods};
use super::publication::Publication;
use super::row::{self, rows};
use super::table::{Table, Title};
use crate::ledger::Canonical;
use crate::record::{Record, RunRecord, Stage};

/// The publication.
pub(super) const T5: Publication = Publication {
    name: "t5",
    question: "What does a corrected model still do: the original task, and the changes it met before?",
    tables: |records| vec![table(records)],
};

const TITLE: Title = Title {
    id: "t5",
    text: "T5 retention: what a corrected model still does",
    note: "A row is a cell over its seeds, or a stage of a sequence, in which each variation is met with the model \
        that the one before left. `before` and `after` are success on the variation, `original before` and `original \
        after` on the original task, from the same starts; `earlier` is success on the variations of all earlier \
        stages after this one. Pooled over rollouts, with the Wilson 95 % interval; demonstrations are means over \
        seeds with a 95 % bootstrap interval, runs that used the budget up among them.",
};

/// A cell of the protocol, or a stage of a sequence; those that stand alone come first.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct Key<'a> {
    protocol: &'a str,
    task: &'a str,
    stage: Option<&'a Stage>,
    variation: &'a str,
    edit: Edit,
    teacher: &'a str,
    method: MethodName<'a>,
}

type Row<'a> = row::Row<Key<'a>, &'a RunRecord>;

fn columns<'a>() -> Columns<'a, Row<'a>> {
    Columns::<Row<'a>>::new()
        .text("protocol", |row| row.key.protocol)
        .text("task", |row| row.key.task)
        .text("sequence", |row| some(row.key.stage, |stage| (&*stage.sequence).into()))
        .text("stage", |row| some(row.key.stage, |stage| Cell::Text(stage.number.to_string())))
        .text("variation", |row| row.key.variation)
        .text("edit_needed", |row| row.key.edit.name())
        .text("teacher", |row| row.key.teacher)
        .text("method", |row| row.key.method.name)
        .count("runs", |row| row.of.len())
        .column("before", Shape::Rate, |row| rate(row.of.iter().filter_map(|run| run.before)))
        .column("after", Shape::Rate, |row| rate(row.of.iter().filter_map(|run| run.after)))
        .column("original_before", Shape::Rate, |row| rate(row.of.iter().filter_map(|run| run.original_rate)))
        .column("original_after", Shape::Rate, |row| rate(row.of.iter().filter_map(|run| run.retained)))
        .column("earlier", Shape::Rate, |row| rate(row.of.iter().flat_map(|run| run.earlier.values().copied())))
        .column("demonstrations", Shape::Estimate(1), |row| {
            let Key { protocol, task, stage, variation, teacher, method, .. } = &row.key;
            let label = format!("t5/{protocol}/{task}/{stage:?}/{variation}/{teacher}/{}", method.name);
            let spent: Vec<f64> = row.of.iter().map(|run| f64::from(run.effort.demonstrations)).collect();
            mean(&spent, seed(&label, "demonstrations"))
        })
}

fn table(records: &Canonical) -> Table {
    let methods = Methods::listed();
    let runs = records.iter().filter_map(|record| if let Record::Run(run) = record { Some(run) } else { None });
    let counted = runs.filter(|run| {
        run.outcome.counts() && run.retained.is_some() && methods.role(&run.key.method) != Role::FromScratch
    });
    let rows: Vec<Row> = rows(counted.map(|run| {
        let key = &run.key;
        let (protocol, task, variation, teacher) = (&*key.protocol, &*key.task, &*key.variation, &*key.teacher);
        let (stage, method) = (key.stage.as_ref(), methods.name(&key.method));
        (Key { protocol, task, stage, variation, edit: key.edit, teacher, method }, run)
    }));
    Table::new(TITLE, columns(), &rows, rows.iter().map(|row| (row.key.protocol, row.of.len())))
}
