//! T5: what a corrected model still does: the original task, and the variations it met before.

use std::collections::BTreeMap;

use situ::method::Role;

use super::column::{Bound, Cell, Columns, Shape, some};
use super::measure::{EFFORT, cell, effort, share, success};
use super::pooled::pooled_ratio;
use super::rows::{self, CellKey, MethodName, role, rows};
use super::table::{Publication, Table, Title};
use crate::ledger::Canonical;
use crate::record::{Record, RunRecord};
use crate::stats::sequence::{SequenceScore, sequence};
use crate::tally::Rate;

/// The publication.
pub(super) const T5: Publication = Publication {
    name: "t5",
    question: "What does a corrected model still do: the original task, and the changes it met before?",
    tables: |records| vec![table(records), sequences(records)],
};

const TITLE: Title = Title {
    id: "t5",
    text: "T5 retention: what a corrected model still does",
    note: "A row is a cell over its seeds, or a stage of a sequence, in which each variation is met with the model \
        that the one before left. `before` and `after` are success on the variation, `original before` and `original \
        after` on the original task, from the same fresh starts, by which nothing was decided; `earlier` is success on \
        the variations of all earlier stages after this one. Means with 95 % bootstrap intervals over seeds, from two \
        seeds on. Demonstrations: the budget, where the target was not reached; ≥ marks a mean with such runs. \
        Teaching from scratch has no row, and the control has one in sequences alone.",
};

const SEQUENCES: Title = Title {
    id: "t5_sequences",
    text: "T5 sequences: what is learned, and what is kept, over several changes",
    note: "Success on each stage once it was met, and after every later one (Liu et al. 2023): FWT is the mean over \
        stages of success on a stage after it was corrected; NBT what the later stages cost the earlier ones; AUC the \
        mean over stages of success from then on. Means over sequences and seeds, and for each sequence; two 95 % \
        bootstrap intervals each: by units (family × seed) and by sequences.",
};

type Row<'a> = rows::Row<CellKey<'a>, &'a RunRecord>;

fn columns<'a>() -> Columns<'a, Row<'a>> {
    let of = |row: &Row<'a>, rate: fn(&RunRecord) -> Option<Rate>| success(row.of.iter().copied(), rate);
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
        .column("before", Shape::Pooled(2), move |row| of(row, |run| run.before))
        .column("after", Shape::Pooled(2), move |row| of(row, |run| run.after))
        .column("original_before", Shape::Pooled(2), move |row| of(row, |run| run.original_rate))
        .column("original_after", Shape::Pooled(2), move |row| of(row, |run| run.retained))
        .column("earlier", Shape::Pooled(2), move |row| {
            let rate = |run: &RunRecord| (!run.earlier.is_empty()).then(|| run.earlier.values().copied().sum::<Rate>());
            of(row, rate)
        })
        .column("demonstrations", Shape::Pooled(1), |row| {
            if role(row.key.method.name) == Role::Control {
                return Cell::Nothing;
            }
            effort(row.of.iter().copied(), EFFORT[0].1)
        })
}

fn table(records: &Canonical) -> Table {
    let runs = records.iter().filter_map(|record| if let Record::Run(run) = record { Some(run) } else { None });
    let counted =
        runs.filter(|run| run.outcome.counts() && run.retained.is_some() && role(&run.key.method) != Role::FromScratch);
    let rows: Vec<Row> = rows(counted.map(|run| (CellKey::from(run), run)));
    Table::new(TITLE, columns(), &rows, rows.iter().map(|row| (row.key.protocol, row.of.len())))
}

/// Protocol, teacher, method, and the sequence; all sequences come first.
type SequenceKey<'a> = (&'a str, &'a str, MethodName<'a>, Option<(&'a str, &'a str)>);

/// The last run of a sequence, and its score.
type Scored<'a> = (&'a RunRecord, SequenceScore);

/// The sequences that were gone through to their ends.
fn scored(records: &Canonical) -> impl Iterator<Item = Scored<'_>> {
    let stages = records.iter().filter_map(|record| if let Record::Run(run) = record { Some(run) } else { None });
    let mut sequences: BTreeMap<_, Vec<&RunRecord>> = BTreeMap::new();
    for run in stages {
        let key = &run.key;
        let Some(stage) = &key.stage else { continue };
        let name = (&key.protocol, &key.task, &stage.sequence, &key.teacher, &key.method, key.seed);
        sequences.entry(name).or_default().push(run);
    }
    sequences.into_values().filter_map(|mut runs| {
        runs.sort_by_key(|run| run.key.stage.as_ref().map(|stage| stage.number));
        let row = |run: &&RunRecord| {
            let number = run.key.stage.as_ref()?.number as usize;
            let earlier = runs[..number - 1].iter().map(|stage| share(run.earlier.get(&stage.key.variation).copied()));
            earlier.chain([share(run.after)]).collect::<Option<Vec<f64>>>()
        };
        let is_whole = runs
            .iter()
            .enumerate()
            .all(|(index, run)| run.key.stage.as_ref().is_some_and(|stage| stage.number as usize == index + 1));
        let rates = is_whole.then(|| runs.iter().map(row).collect::<Option<Vec<_>>>())??;
        Some((*runs.last()?, sequence(&rates)?))
    })
}

fn sequences(records: &Canonical) -> Table {
    let places = scored(records).flat_map(|(run, score)| {
        let key = &run.key;
        let name = key.stage.as_ref().map(|stage| (&*key.task, &*stage.sequence));
        [None, name].map(|name| ((&*key.protocol, &*key.teacher, MethodName::of(&key.method), name), (run, score)))
    });
    type Row<'a> = rows::Row<SequenceKey<'a>, Scored<'a>>;
    let rows: Vec<Row> = rows(places);
    let mean = |row: &Row, of: fn(&SequenceScore) -> Option<f64>| {
        let of: Vec<_> = row.of.iter().filter_map(|(run, score)| Some((*run, (of(score)?, 1.0)))).collect();
        cell(pooled_ratio(&of), Bound::Exact)
    };
    let columns = Columns::<Row>::new()
        .text("protocol", |row| row.key.0)
        .text("teacher", |row| row.key.1)
        .text("method", |row| row.key.2.name)
        .text("task", |row| row.key.3.map_or("all", |(task, _)| task))
        .text("sequence", |row| row.key.3.map_or("all", |(_, sequence)| sequence))
        .count("runs", |row| row.of.len())
        .column("FWT", Shape::Pooled(2), move |row| mean(row, |score| Some(score.forward)))
        .column("NBT", Shape::Pooled(2), move |row| mean(row, |score| score.negative_backward))
        .column("AUC", Shape::Pooled(2), move |row| mean(row, |score| Some(score.area)));
    let source = rows.iter().map(|row| (row.key.0, if row.key.3.is_none() { row.of.len() } else { 0 }));
    Table::new(SEQUENCES, columns, &rows, source)
}
