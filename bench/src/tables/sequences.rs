//! T5, sequences: what is learned, and what is kept, over many changes; how the model grows, and its updates with it.

use std::collections::{BTreeMap, BTreeSet};

use situ::method::Role;
use situ::structure::Structure;

use super::column::{Bound, Cell, Columns, Shape, some};
use super::measure::{EFFORT, cell, effort, mean, of_runs, share, share_of, success};
use super::plotted::lines;
use super::pooled::pooled_ratio;
use super::rows::{self, CellKey, MethodName, TeacherKey, role, rows, teacher_key};
use super::table::{Figure, Table, Title};
use crate::chart::{Chart, ChartAxis, ChartPanel};
use crate::correction_record::CorrectionRecord;
use crate::ledger::Canonical;
use crate::record::{Record, RunRecord};
use crate::stats::sequence::{SequenceScore, sequence};

const STAGES: Title = Title {
    id: "t5_stages",
    text: "T5 stages: each change of a sequence, met with the model that the one before left",
    note: "`before` and `after` are success on the stage's task, `original` on the original one, from fresh starts, by \
        which nothing was decided. `kept`: of all tasks so far, the original and this stage's among them and each \
        counted once, the share on which success meets the target. A stage called `original` undoes what was changed. \
        Means with 95 % bootstrap intervals over seeds, from two seeds on. Demonstrations: the budget, where the \
        target was not reached; ≥ marks a mean with such runs.",
};

const AGEING: Title = Title {
    id: "t5_ageing",
    text: "T5 ageing: how model and update grow from change to change",
    note: "All sequences together, by the number of the stage. `kept`, as in T5 stages. `primitives` and `edges` are \
        those of the model after the stage; `segments` were read by one update to fit policies and signatures, and \
        `seconds` is its time. Means with 95 % bootstrap intervals over units (family × seed) and over sequences.",
};

const SCORES: Title = Title {
    id: "t5_sequences",
    text: "T5 sequences: what is learned, and what is kept, over several changes",
    note: "Success on each stage once it was met, and after every later one (Liu et al. 2023): FWT is the mean over \
        stages of success on a stage after it was corrected; NBT what the later stages cost the earlier ones; AUC the \
        mean over stages of success from then on. `kept` is the share of all tasks that is kept at the end, as in T5 \
        stages. Means over sequences and seeds, and for each sequence; two 95 % bootstrap intervals each: by units \
        (family × seed) and by sequences.",
};

/// The runs that are stages.
fn stage_runs(records: &Canonical) -> impl Iterator<Item = &RunRecord> {
    let runs = records.iter().filter_map(|record| if let Record::Run(run) = record { Some(run) } else { None });
    runs.filter(|run| run.key.stage.is_some())
}

/// The tasks so far that are kept, and how many there are; `None` where the run has no model.
fn kept(run: &RunRecord) -> Option<(f64, f64)> {
    let (kept, of) = run.kept();
    (run.outcome.counts() && of > 0).then(|| (f64::from(kept), f64::from(of)))
}

/// The demonstrations that a stage took; the control has none.
fn demonstrations(method: &str, runs: &[&RunRecord]) -> Cell {
    if role(method) == Role::Control {
        return Cell::Nothing;
    }
    effort(runs.iter().copied(), EFFORT[0].1)
}

/// Each stage of each sequence.
pub(super) fn stages(records: &Canonical) -> Table {
    type Row<'a> = rows::Row<CellKey<'a>, &'a RunRecord>;
    let counted = stage_runs(records).filter(|run| run.outcome.counts() && run.retained.is_some());
    let rows: Vec<Row> = rows(counted.map(|run| (CellKey::from(run), run)));
    let columns = Columns::<Row>::new()
        .text("protocol", |row| row.key.protocol)
        .text("task", |row| row.key.task)
        .text("sequence", |row| some(row.key.stage, |stage| (&*stage.sequence).into()))
        .text("stage", |row| some(row.key.stage, |stage| Cell::Text(stage.number.to_string())))
        .text("variation", |row| row.key.variation)
        .text("edit_needed", |row| row.key.edit.name())
        .text("teacher", |row| row.key.teacher)
        .text("method", |row| row.key.method.name)
        .count("runs", |row| row.of.len())
        .column("before", Shape::Pooled(2), |row| success(row.of.iter().copied(), |run| run.before))
        .column("after", Shape::Pooled(2), |row| success(row.of.iter().copied(), |run| run.after))
        .column("original", Shape::Pooled(2), |row| success(row.of.iter().copied(), |run| run.retained))
        .column("kept", Shape::Pooled(2), |row| share_of(&of_runs(row.of.iter().copied(), kept)))
        .column("demonstrations", Shape::Pooled(1), |row| demonstrations(row.key.method.name, &row.of));
    Table::new(STAGES, columns, &rows, rows.iter().map(|row| (row.key.protocol, row.of.len())))
}

/// All runs of a teacher and a method that have come to the same stage.
type Aged<'a> = rows::Row<(TeacherKey<'a>, u32), &'a RunRecord>;

fn aged(records: &Canonical) -> Vec<Aged<'_>> {
    let counted = stage_runs(records).filter(|run| run.outcome.counts());
    let number = |run: &RunRecord| run.key.stage.as_ref().map_or(0, |stage| stage.number);
    rows(counted.map(|run| ((teacher_key(run), number(run)), run)))
}

fn kept_share(row: &Aged<'_>) -> Cell {
    share_of(&of_runs(row.of.iter().copied(), kept))
}

fn of_structure(row: &Aged<'_>, of: fn(&Structure) -> u32) -> Cell {
    mean(row.of.iter().copied(), |run| run.structure.as_ref().map(|structure| f64::from(of(structure))))
}

/// The mean over updates.
fn of_updates(row: &Aged<'_>, of: fn(&CorrectionRecord) -> f64) -> Cell {
    let sums = |run: &RunRecord| {
        let sum: f64 = run.corrections.iter().map(of).sum();
        (!run.corrections.is_empty()).then_some((sum, run.corrections.len() as f64))
    };
    cell(pooled_ratio(&of_runs(row.of.iter().copied(), sums)), Bound::Exact)
}

fn primitives(row: &Aged<'_>) -> Cell {
    of_structure(row, |structure| structure.nodes)
}

fn segments(row: &Aged<'_>) -> Cell {
    of_updates(row, |correction| correction.counters.segments_touched as f64)
}

fn seconds(row: &Aged<'_>) -> Cell {
    of_updates(row, |correction| correction.update_seconds)
}

/// What a panel shows: its name, the cell of a row, and the axis.
type Measured = (&'static str, fn(&Aged<'_>) -> Cell, fn(&str) -> ChartAxis);

/// What is kept, how large the model is and what an update costs, from stage to stage; the time apart.
pub(super) fn figures(records: &Canonical) -> Vec<Figure> {
    const EXACT: [Measured; 3] = [
        ("tasks kept", kept_share, ChartAxis::shares),
        ("primitives", primitives, ChartAxis::amounts),
        ("segments an update", segments, ChartAxis::amounts),
    ];
    const TIMED: [Measured; 1] = [("seconds an update", seconds, |name| ChartAxis::log(name, None))];
    let rows = aged(records);
    let chart = |title: &str, measures: &[Measured]| Chart {
        title: title.to_owned(),
        columns: 3,
        panels: measures.iter().flat_map(|measured| by_teacher(&rows, *measured)).collect(),
    };
    let exact = "How a model ages over a sequence of changes: the tasks that are kept, the primitives of the model, and \
        the segments that an update reads.";
    let timed = "How long an update takes over a sequence of changes.";
    vec![
        Figure { id: "t5_ageing", chart: chart(exact, &EXACT) },
        Figure { id: "t5_ageing_wall", chart: chart(timed, &TIMED) },
    ]
}

/// A panel for each teacher, a line for each method.
fn by_teacher(rows: &[Aged<'_>], (name, cell, axis): Measured) -> Vec<ChartPanel> {
    let teachers: BTreeSet<(&str, &str)> = rows.iter().map(|row| (row.key.0.0, row.key.0.1)).collect();
    let protocols = teachers.iter().map(|(protocol, _)| protocol).collect::<BTreeSet<_>>().len();
    let last = rows.iter().map(|row| row.key.1).max().unwrap_or(0);
    let panel = |(protocol, teacher): &(&str, &str)| {
        let of_teacher = rows.iter().filter(|row| (row.key.0.0, row.key.0.1) == (*protocol, *teacher));
        let points = of_teacher.map(|row| (row.key.0.2.name, f64::from(row.key.1), cell(row)));
        let title = if protocols > 1 { format!("{protocol}, {teacher}") } else { (*teacher).to_owned() };
        ChartPanel { title, x: ChartAxis::counts("change", last), y: axis(name), lines: lines(points) }
    };
    teachers.iter().map(panel).collect()
}

/// All sequences, by the number of the stage.
pub(super) fn ageing(records: &Canonical) -> Table {
    let rows = aged(records);
    let columns = Columns::<Aged>::new()
        .text("protocol", |row| row.key.0.0)
        .text("teacher", |row| row.key.0.1)
        .text("method", |row| row.key.0.2.name)
        .text("stage", |row| Cell::Text(row.key.1.to_string()))
        .count("runs", |row| row.of.len())
        .column("after", Shape::Pooled(2), |row| success(row.of.iter().copied(), |run| run.after))
        .column("kept", Shape::Pooled(2), kept_share)
        .column("demonstrations", Shape::Pooled(1), |row| demonstrations(row.key.0.2.name, &row.of))
        .column("primitives", Shape::Pooled(1), primitives)
        .column("edges", Shape::Pooled(1), |row| of_structure(row, |structure| structure.edges))
        .column("segments", Shape::Pooled(0), segments)
        .wall("seconds", Shape::Pooled(4), seconds);
    Table::new(AGEING, columns, &rows, rows.iter().map(|row| (row.key.0.0, row.of.len())))
}

/// Protocol, teacher, method, and the sequence; all sequences come first.
type SequenceKey<'a> = (&'a str, &'a str, MethodName<'a>, Option<(&'a str, &'a str)>);

/// The last run of a sequence, and its score.
type Scored<'a> = (&'a RunRecord, SequenceScore);

/// The sequences that were gone through to their ends.
fn scored(records: &Canonical) -> impl Iterator<Item = Scored<'_>> {
    let mut sequences: BTreeMap<_, Vec<&RunRecord>> = BTreeMap::new();
    for run in stage_runs(records) {
        let key = &run.key;
        let Some(stage) = &key.stage else { continue };
        let name = (&key.protocol, &key.task, &stage.sequence, &key.teacher, &key.method, key.seed);
        sequences.entry(name).or_default().push(run);
    }
    sequences.into_values().filter_map(|mut runs| {
        runs.sort_by_key(|run| run.key.stage.as_ref().map(|stage| stage.number));
        let row = |(index, run): (usize, &&RunRecord)| {
            let stages = runs[..=index].iter().map(|stage| share(run.success_on(&stage.key.variation)));
            stages.collect::<Option<Vec<f64>>>()
        };
        let is_whole = runs
            .iter()
            .enumerate()
            .all(|(index, run)| run.key.stage.as_ref().is_some_and(|stage| stage.number as usize == index + 1));
        let rates = is_whole.then(|| runs.iter().enumerate().map(row).collect::<Option<Vec<_>>>())??;
        Some((*runs.last()?, sequence(&rates)?))
    })
}

/// The scores of whole sequences.
pub(super) fn scores(records: &Canonical) -> Table {
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
        .column("AUC", Shape::Pooled(2), move |row| mean(row, |score| Some(score.area)))
        .column("kept", Shape::Pooled(2), |row| share_of(&of_runs(row.of.iter().map(|(run, _)| *run), kept)));
    let source = rows.iter().map(|row| (row.key.0, if row.key.3.is_none() { row.of.len() } else { 0 }));
    Table::new(SCORES, columns, &rows, source)
}
