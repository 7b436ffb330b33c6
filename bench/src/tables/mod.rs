//! Tables: projections of the ledger's records, and of nothing else, so that equal records give equal bytes.
//!
//! A table is made once, as cells; Markdown and CSV are two ways to write it. Where Markdown says `18/20 [0.70, 0.97]`, CSV has
//! a column for each of the four numbers. Columns that hold the clock come last; in CSV their names end in `_wall`.

pub mod cost;
pub mod edits;
pub mod effort;
pub mod growth;
pub mod latency;
pub mod methods;
pub mod retention;
pub mod separate;

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

use situ::edit::Edit;
use situ::method::{self, Role};
use situ::random::stream;

use crate::ledger;
use crate::record::{Rate, Record};
use crate::stats::{self, Estimate};

/// What the harness publishes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// T1: what corrections take, against teaching from scratch.
    Effort,
    /// T2: successive corrections, against all demonstrations at once.
    Separate,
    /// T3: which edit was needed, and which was made; how far the structure is what the teacher meant.
    Edits,
    /// T4: what an update costs.
    Cost,
    /// T5: what a corrected model still does.
    Retention,
    /// Every method beside every edit.
    Methods,
}

impl Kind {
    /// All of them, in the order of publication.
    pub const ALL: [Self; 6] = [Self::Effort, Self::Separate, Self::Edits, Self::Cost, Self::Retention, Self::Methods];

    /// The name on the command line and of files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Effort => "t1",
            Self::Separate => "t2",
            Self::Edits => "t3",
            Self::Cost => "t4",
            Self::Retention => "t5",
            Self::Methods => "methods",
        }
    }

    /// One sentence: the question it answers.
    pub const fn question(self) -> &'static str {
        match self {
            Self::Effort => "What do corrections take, against teaching the changed task from scratch?",
            Self::Separate => {
                "Is a model built by successive corrections as good as one built from all demonstrations at once?"
            }
            Self::Edits => {
                "Which edit did the task need, which did the method make, and is the structure what the teacher meant?"
            }
            Self::Cost => "What does an update cost, and how does that grow with the task model?",
            Self::Retention => {
                "What does a corrected model still do: the original task, and the changes it met before?"
            }
            Self::Methods => {
                "What does every method reach, edit by edit, and what does its update cost against SITU's?"
            }
        }
    }

    /// The tables of this kind, from records in any order.
    pub fn tables(self, records: &[Record]) -> Vec<Table> {
        let records = ledger::canonical(records.to_vec());
        match self {
            Self::Effort => vec![effort::table(&records)],
            Self::Separate => vec![separate::table(&records)],
            Self::Edits => vec![edits::table(&records)],
            Self::Cost => vec![
                cost::physics(&records),
                growth::scaling(&records),
                growth::slopes(&records),
                growth::crossover(&records),
                latency::latency(&records),
            ],
            Self::Retention => vec![retention::table(&records)],
            Self::Methods => vec![methods::table(&records)],
        }
    }
}

/// What a column holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Shape {
    /// Words.
    Text,
    /// A whole number.
    Count,
    /// A number with this many decimals in Markdown.
    Number(usize),
    /// k of n, with the Wilson 95 % interval.
    Rate,
    /// A number with its 95 % interval, and this many decimals in Markdown.
    Estimate(usize),
}

/// A column.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Column {
    name: &'static str,
    shape: Shape,
    /// Whether it holds the clock: the same run gives other numbers then.
    wall: bool,
}

const fn column(name: &'static str, shape: Shape) -> Column {
    Column { name, shape, wall: false }
}

const fn wall(name: &'static str, shape: Shape) -> Column {
    Column { name, shape, wall: true }
}

/// How an estimate stands to the truth where runs were censored at their budget.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Bound {
    Exact,
    AtLeast,
    AtMost,
    Unknown,
}

impl Bound {
    /// Of a ratio whose numerator and denominator are or are not known exactly: what is not is at least so much.
    const fn of(numerator: bool, denominator: bool) -> Self {
        match (numerator, denominator) {
            (true, true) => Self::Exact,
            (false, true) => Self::AtLeast,
            (true, false) => Self::AtMost,
            (false, false) => Self::Unknown,
        }
    }

    const fn mark(self) -> &'static str {
        match self {
            Self::Exact => "",
            Self::AtLeast => "≥",
            Self::AtMost => "≤",
            Self::Unknown => "~",
        }
    }
}

#[derive(Clone, Debug, PartialEq)]
enum Cell {
    Text(String),
    Count(usize),
    Number(f64),
    Rate(Rate),
    Estimate(Estimate, Bound),
    Nothing,
}

/// A table.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    id: &'static str,
    title: &'static str,
    note: &'static str,
    columns: Vec<Column>,
    rows: Vec<Vec<Cell>>,
    protocols: BTreeSet<String>,
    records: usize,
}

/// Decimals of a share.
const SHARE: usize = 2;
/// Decimals of every number in CSV.
const CSV: usize = 6;

impl Table {
    /// The name of its file, without an ending.
    pub fn id(&self) -> &'static str {
        self.id
    }

    /// Whether it has no row.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// The table in Markdown; `command` is what the reader types to make it again.
    pub fn to_markdown(&self, command: &str) -> String {
        let protocols = self.protocols.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
        let protocols = if protocols.is_empty() { "none".to_owned() } else { protocols };
        let mut text = format!(
            "## {}\n\nProtocol: {protocols}. Records: {}. Made by `{command}`; do not edit.\n\n{}\n\n",
            self.title, self.records, self.note
        );
        let heads = self.columns.iter().map(|column| {
            let name = column.name.replace('_', " ").replace('|', "\\|");
            if column.wall { format!("{name} (wall)") } else { name }
        });
        let rule =
            self.columns.iter().map(|column| if column.shape == Shape::Text { "---" } else { "---:" }.to_owned());
        let rows = self.rows.iter().map(|row| {
            self.columns.iter().zip(row).map(|(column, cell)| markdown(column.shape, cell)).collect::<Vec<_>>()
        });
        for row in [heads.collect::<Vec<_>>(), rule.collect()].into_iter().chain(rows) {
            let _ = writeln!(text, "| {} |", row.join(" | "));
        }
        text
    }

    /// The table in CSV, a header first.
    pub fn to_csv(&self) -> String {
        let mut writer = csv::Writer::from_writer(Vec::new());
        let heads = self.columns.iter().flat_map(|column| {
            let clock = if column.wall { "_wall" } else { "" };
            suffixes(column.shape).iter().map(move |suffix| format!("{}{suffix}{clock}", csv_name(column.name)))
        });
        let rows = self.rows.iter().map(|row| {
            self.columns.iter().zip(row).flat_map(|(column, cell)| fields(column.shape, cell)).collect::<Vec<_>>()
        });
        for row in std::iter::once(heads.collect()).chain(rows) {
            writer.write_record(&row).expect("rows of one length, in memory");
        }
        String::from_utf8(writer.into_inner().expect("in memory")).expect("made of strings")
    }
}

/// A column's name without signs: `|Z|` is `applicable`, `|T|` is `model_size`.
fn csv_name(name: &str) -> String {
    name.replace("|Z|", "applicable").replace("|T|", "model_size").replace('/', "_over_").replace([' ', '-'], "_")
}

const fn suffixes(shape: Shape) -> &'static [&'static str] {
    match shape {
        Shape::Text | Shape::Count | Shape::Number(_) => &[""],
        Shape::Rate => &["_successes", "_n", "_low", "_high"],
        Shape::Estimate(_) => &["", "_low", "_high", "_bound"],
    }
}

/// A number with so many decimals; what rounds to 0 has no sign.
fn fixed(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$}");
    match text.strip_prefix('-') {
        Some(rest) if rest.chars().all(|digit| matches!(digit, '0' | '.')) => rest.to_owned(),
        _ => text,
    }
}

fn fields(shape: Shape, cell: &Cell) -> Vec<String> {
    let number = |value: &f64| fixed(*value, CSV);
    match cell {
        Cell::Text(text) => vec![text.clone()],
        Cell::Count(count) => vec![count.to_string()],
        Cell::Number(value) => vec![number(value)],
        Cell::Rate(rate) => {
            let (low, high) = stats::wilson(rate.successes, rate.rollouts);
            vec![rate.successes.to_string(), rate.rollouts.to_string(), number(&low), number(&high)]
        }
        Cell::Estimate(estimate, bound) => {
            vec![number(&estimate.value), number(&estimate.low), number(&estimate.high), bound.mark().to_owned()]
        }
        Cell::Nothing => vec![String::new(); suffixes(shape).len()],
    }
}

fn markdown(shape: Shape, cell: &Cell) -> String {
    let digits = match shape {
        Shape::Number(digits) | Shape::Estimate(digits) => digits,
        _ => SHARE,
    };
    match cell {
        Cell::Text(text) => text.replace('|', "\\|"),
        Cell::Count(count) => count.to_string(),
        Cell::Number(value) => fixed(*value, digits),
        Cell::Rate(rate) => {
            let (low, high) = stats::wilson(rate.successes, rate.rollouts);
            format!("{}/{} [{low:.SHARE$}, {high:.SHARE$}]", rate.successes, rate.rollouts)
        }
        Cell::Estimate(estimate, bound) => {
            let number = |value| fixed(value, digits);
            format!("{}{} [{}, {}]", bound.mark(), number(estimate.value), number(estimate.low), number(estimate.high))
        }
        Cell::Nothing => "–".to_owned(),
    }
}

/// A rate; nothing where there was no rollout.
fn rate(rates: impl Iterator<Item = Rate>) -> Cell {
    let pooled = rates.fold(Rate::default(), |mut sum, rate| {
        sum += rate;
        sum
    });
    if pooled.rollouts == 0 { Cell::Nothing } else { Cell::Rate(pooled) }
}

/// The share of things that are so, as a rate.
fn share(of: impl Iterator<Item = bool>) -> Cell {
    rate(of.map(|is_so| Rate { successes: u32::from(is_so), rollouts: 1 }))
}

fn number(value: Option<f64>) -> Cell {
    value.map_or(Cell::Nothing, Cell::Number)
}

fn estimate(estimate: Option<Estimate>) -> Cell {
    estimate.map_or(Cell::Nothing, |estimate| Cell::Estimate(estimate, Bound::Exact))
}

/// The median with its bootstrap interval.
fn median(values: &[f64], seed: u64) -> Cell {
    estimate(stats::bootstrap(values.len(), seed, |drawn| {
        stats::median(&drawn.iter().map(|index| values[*index]).collect::<Vec<_>>())
    }))
}

/// The mean with its bootstrap interval.
fn mean(values: &[f64], seed: u64) -> Cell {
    estimate(stats::bootstrap(values.len(), seed, |drawn| {
        (!drawn.is_empty()).then(|| drawn.iter().map(|index| values[*index]).sum::<f64>() / drawn.len() as f64)
    }))
}

/// How often each edit was made, in words.
fn made(edits: impl Iterator<Item = Edit>) -> Cell {
    let mut counts: BTreeMap<Edit, usize> = BTreeMap::new();
    for edit in edits {
        *counts.entry(edit).or_default() += 1;
    }
    let words: Vec<String> = counts.iter().map(|(edit, count)| format!("{edit} {count}")).collect();
    if words.is_empty() { Cell::Nothing } else { Cell::Text(words.join(", ")) }
}

/// A method, in the order in which methods are listed; methods that are not listed follow by name.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct MethodName {
    rank: usize,
    name: String,
}

/// The listed methods and what they do with a changed task.
struct Methods(Vec<(&'static str, Role)>);

impl Methods {
    fn listed() -> Self {
        Self(method::all().iter().map(|method| (method.name(), method.role())).collect())
    }

    fn name(&self, name: &str) -> MethodName {
        let rank = self.0.iter().position(|(listed, _)| *listed == name).unwrap_or(self.0.len());
        MethodName { rank, name: name.to_owned() }
    }

    /// A method that is not listed takes corrections.
    fn role(&self, name: &str) -> Role {
        self.0.iter().find(|(listed, _)| *listed == name).map_or(Role::Correct, |(_, role)| *role)
    }
}

/// The seed of a bootstrap: each quantity of each row has its own stream, so that a row does not depend on its neighbours.
fn seed(row: &str, quantity: &str) -> u64 {
    stream(0, &format!("bootstrap/{row}/{quantity}"))
}

#[cfg(test)]
pub(crate) mod tests;
