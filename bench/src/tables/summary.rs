//! What a run came to, in ten lines that fit a terminal of 100 columns.

use std::collections::BTreeSet;

use comfy_table::{CellAlignment, Table as Grid, presets::NOTHING};
use situ::edit::Edit;
use situ::method::Role;

use super::aligned::wrapped;
use super::column::{Cell, MILLISECONDS_PER_SECOND, Shape};
use super::measure::{EFFORT, effort, median, of_runs, success};
use super::pooled::Pooled;
use super::rows::{MethodName, role, rows};
use super::table::{Publication, words};
use crate::ledger::Canonical;
use crate::record::{Key, Outcome, Record, RunRecord};

/// The widest line.
const WIDTH: usize = 100;
/// The most methods that are shown.
const MOST: usize = 5;
/// The methods that are shown before others, where there are too many.
const FIRST: [&str; 5] = ["situ", "rebuild", "nearest", "from_scratch", "no_update"];
/// The teacher that is shown, where there are several.
const TEACHER: &str = "novice";

/// What was run, the answer, and where the rest is: `folder` holds these publications.
pub fn summary(records: &Canonical, folder: &str, made: &[&Publication]) -> String {
    let runs: Vec<&RunRecord> = records.iter().filter_map(Record::single_run).collect();
    let compared: Vec<&RunRecord> = runs.into_iter().filter(|run| run.grade.is_none() && is_counted(run)).collect();
    let mut lines = vec![was_run(records)];
    if compared.is_empty() {
        lines.extend(answers(made));
    } else {
        lines.extend(table(&compared));
    }
    lines.push(wrapped(&format!("Tables, figures and the ledger are in {folder}."), WIDTH));
    lines.iter().map(|line| format!("{line}\n")).collect()
}

fn is_counted(run: &RunRecord) -> bool {
    run.key.edit != Edit::None && run.outcome != Outcome::NotApplicable
}

/// So many things of a kind.
fn many(count: usize, one: &str, more: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { more })
}

/// What was run.
fn was_run(records: &Canonical) -> String {
    let mut protocols = BTreeSet::new();
    let (mut costs, mut keys) = (0, Vec::new());
    for record in records.iter() {
        match record {
            Record::Run(run) => keys.push(&run.key),
            Record::Cost(cost) => {
                protocols.insert(&*cost.protocol);
                costs += 1;
            }
        }
    }
    protocols.extend(keys.iter().map(|key| &*key.protocol));
    let named = protocols.into_iter().collect::<Vec<_>>().join(", ");
    let of = |what: fn(&Key) -> String| keys.iter().map(|key| what(key)).collect::<BTreeSet<_>>();
    let mut parts = Vec::new();
    if !keys.is_empty() {
        let teachers = of(|key| key.teacher.clone());
        let changes = of(|key| format!("{}/{}", key.task, key.variation)).len();
        parts.push(format!(
            "{} of {} on {} of {}, {}, {}",
            many(keys.len(), "run", "runs"),
            many(of(|key| key.method.clone()).len(), "method", "methods"),
            many(changes, "change", "changes"),
            many(of(|key| key.task.clone()).len(), "task", "tasks"),
            match teachers.len() {
                1 => format!("teacher {}", teachers.iter().next().map_or("", |name| name)),
                count => many(count, "teacher", "teachers"),
            },
            many(of(|key| key.seed.to_string()).len(), "seed", "seeds"),
        ));
    }
    if costs > 0 {
        parts.push(many(costs, "update of a synthetic automaton", "updates of synthetic automata"));
    }
    wrapped(&format!("{named}: {}", parts.join("; ")), WIDTH)
}

/// Where no run can stand in a table of methods: the questions that the tables answer.
fn answers(made: &[&Publication]) -> Vec<String> {
    let answer =
        |publication: &&Publication| wrapped(&format!("{}.md: {}", publication.name, publication.question), WIDTH);
    made.iter().take(MOST).map(answer).collect()
}

/// The methods that are shown, in the order of the tables.
fn shown<'a>(runs: &[&'a RunRecord]) -> Vec<MethodName<'a>> {
    let all: BTreeSet<MethodName> = runs.iter().map(|run| MethodName::of(&run.key.method)).collect();
    let first = all.iter().filter(|method| FIRST.contains(&method.name));
    let others = all.iter().filter(|method| !FIRST.contains(&method.name));
    let mut shown: Vec<MethodName> = first.chain(others).copied().take(MOST).collect();
    shown.sort();
    shown
}

/// A cell with the interval by units alone.
fn brief(cell: Cell, digits: usize) -> String {
    let cell = match cell {
        Cell::Pooled(pooled, bound) => Cell::Pooled(Pooled { variations: None, ..pooled }, bound),
        other => other,
    };
    words(Shape::Pooled(digits), &cell)
}

/// A cell without its interval.
fn alone(cell: Cell, digits: usize) -> String {
    let cell = match cell {
        Cell::Pooled(pooled, bound) => Cell::Pooled(Pooled { units: None, variations: None, ..pooled }, bound),
        other => other,
    };
    words(Shape::Pooled(digits), &cell)
}

/// A line for each method, below a head.
fn table(runs: &[&RunRecord]) -> Vec<String> {
    let teachers: BTreeSet<&str> = runs.iter().map(|run| &*run.key.teacher).collect();
    let teacher = teachers.get(TEACHER).or(teachers.first()).copied().unwrap_or(TEACHER);
    let of_teacher: Vec<&RunRecord> = runs.iter().filter(|run| run.key.teacher == teacher).copied().collect();
    let shown = shown(&of_teacher);
    let mut grid = Grid::new();
    grid.load_style(NOTHING);
    grid.set_header([
        &format!("teacher {teacher}"),
        "reached",
        "changed task",
        "original task",
        "demonstrations",
        "update ms",
    ]);
    let placed = of_teacher.iter().map(|run| (MethodName::of(&run.key.method), *run));
    let rows = rows(placed.filter(|(method, _)| shown.contains(method)));
    let all: BTreeSet<&str> = of_teacher.iter().map(|run| &*run.key.method).collect();
    for row in &rows {
        let counted: Vec<&RunRecord> = row.of.iter().filter(|run| run.outcome.counts()).copied().collect();
        let runs = || counted.iter().copied();
        let times = of_runs(runs(), |run| Some(MILLISECONDS_PER_SECOND * run.update_seconds()?));
        let is_control = role(row.key.name) == Role::Control;
        grid.add_row([
            row.key.name.to_owned(),
            format!("{}/{}", runs().filter(|run| run.is_reached()).count(), counted.len()),
            brief(success(runs(), |run| run.after), 2),
            brief(success(runs(), |run| run.retained), 2),
            if is_control { words(Shape::Text, &Cell::Nothing) } else { alone(effort(runs(), EFFORT[0].1), 2) },
            alone(median(&times), 2),
        ]);
    }
    for column in 1..6 {
        if let Some(column) = grid.column_mut(column) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    let mut lines: Vec<String> = grid.lines().map(|line| line.trim().to_owned()).collect();
    let mut more = vec!["success from fresh starts, with 95 % intervals, where an edit was needed".to_owned()];
    if all.len() > shown.len() {
        more.push(many(all.len() - shown.len(), "more method", "more methods"));
    }
    if teachers.len() > 1 {
        more.push(many(teachers.len() - 1, "more teacher", "more teachers"));
    }
    let more = more.join("; ");
    lines.push(wrapped(&format!("({more}: headline.md)"), WIDTH));
    lines
}
